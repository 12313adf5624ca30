//! What shells offer at a tab, and manual pages.

use std::process::Command;

use crate::support::Place;

/// What bash offers for the last of the words, by the script that the program printed.
fn offered(place: &Place, words: &[&str]) -> Vec<String> {
    let script = place.succeed(&["completions", "bash"]);
    let last = words.last().unwrap();
    let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    let ask = format!(
        "{script}\nCOMP_WORDS=({})\nCOMP_CWORD={}\nCOMP_TYPE=9\n\
         _clap_complete_perifrac perifrac '{last}' ''\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
        quoted.join(" "),
        words.len() - 1
    );
    let mut bash = Command::new("bash");
    bash.args(["--norc", "--noprofile", "-c", &ask]);
    let output = bash.current_dir(place.path("")).output().unwrap();
    assert!(output.stderr.is_empty(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let lines = text.lines().filter(|line| !line.is_empty());
    lines.map(str::to_owned).collect()
}

#[test]
fn a_scene_is_a_bundled_case_its_variant_or_a_file() {
    let place = Place::with_scene(&[]);
    place.write("nature/deep.toml", "");
    place.write("natural.toml", "");
    place.write("natural.csv", "");
    let expected = [
        "natural-fractures",
        "natural-fractures/smoke",
        "natural-fractures/paper",
        "natural-fractures/vertical",
        "natural-fractures/wide",
        "natural.toml",
        "nature/",
    ];
    for verb in ["run", "plan", "check"] {
        assert_eq!(offered(&place, &["perifrac", verb, "na"]), expected);
    }
    let variants = offered(&place, &["perifrac", "run", "well-test/"]);
    assert_eq!(variants, ["well-test/limited"]);
    let within = offered(&place, &["perifrac", "run", "nature/"]);
    assert_eq!(within, ["nature/deep.toml"]);
    assert!(offered(&place, &["perifrac", "run", "no-such-"]).is_empty());
    let all = offered(&place, &["perifrac", "study", "cost", ""]);
    let cases = perifrac::cases::names();
    assert!(
        cases.iter().all(|case| all.iter().any(|own| own == case)),
        "{all:?}"
    );
}

#[test]
fn flags_with_names_offer_the_names() {
    let place = Place::new();
    let schemes = [
        "implicit",
        "explicit",
        "semi-implicit",
        "staggered",
        "monolithic",
    ];
    assert_eq!(
        offered(&place, &["perifrac", "run", "terzaghi", "--scheme", ""]),
        schemes
    );
    let factors = offered(&place, &["perifrac", "plan", "--solver", "faer-l"]);
    assert_eq!(factors, ["faer-llt", "faer-ldlt", "faer-lu"]);
    let listed = place.succeed(&["solvers"]);
    for solver in offered(&place, &["perifrac", "check", "--solver", ""]) {
        assert!(
            listed.lines().any(|line| line.starts_with(&solver)),
            "{solver}"
        );
    }
    let ends = offered(&place, &["perifrac", "run", "--e"]);
    assert_eq!(ends, ["--end"]);
}

#[test]
fn every_shell_has_a_script_that_asks_the_program() {
    let place = Place::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = place.succeed(&["completions", shell]);
        assert!(text.contains("PERIFRAC_COMPLETE"), "{shell}: {text}");
        assert!(
            text.contains(env!("CARGO_BIN_EXE_perifrac")),
            "{shell}: {text}"
        );
    }
}

/// Flags that a help names.
fn flags(help: &str) -> Vec<&str> {
    let word = |line: &'_ str| -> Option<usize> { line.find("--") };
    let lines = help
        .lines()
        .filter(|line| line.trim_start().starts_with('-'));
    let flag = |line| {
        let line: &str = line;
        let rest = &line[word(line)?..];
        rest.split([' ', '=', ',']).next()
    };
    lines.filter_map(flag).collect()
}

#[test]
fn manual_pages_name_every_verb_and_every_flag() {
    let place = Place::new();
    let told = place.succeed(&["man", "share/man1"]);
    assert!(told.contains("share/man1/perifrac.1"), "{told}");
    let page = |name: &str| {
        let text = place.read(&format!("share/man1/{name}.1"));
        String::from_utf8(text).unwrap().replace('\\', "")
    };
    let whole = page("perifrac");
    let help = place.succeed(&["--help"]);
    let verbs = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let verbs = verbs.take_while(|line| !line.is_empty());
    let starts = verbs.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let verbs: Vec<&str> = starts
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert!(verbs.len() > 10, "{help}");
    for verb in verbs.into_iter().filter(|verb| *verb != "help") {
        assert!(
            whole.contains(&format!("perifrac-{verb}(1)")),
            "{verb}: {whole}"
        );
        let own = page(&format!("perifrac-{verb}"));
        let help = place.succeed(&[verb, "--help"]);
        let flags = flags(&help);
        assert!(flags.contains(&"--help"), "{help}");
        for flag in flags {
            assert!(own.contains(flag), "{verb} {flag}: {own}");
        }
    }
    place.write("taken", "");
    let refused = place.run(&["man", "taken"]);
    assert_ne!(refused.code, Some(0));
    assert!(
        refused
            .stderr
            .contains("taken: could not write the pages: File exists"),
        "{refused:?}"
    );
}
