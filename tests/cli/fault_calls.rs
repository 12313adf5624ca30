//! Wrong words on the command line.

use crate::support::{FAULT, Fault, Place, check};

#[test]
fn names_and_flags_that_do_not_exist() {
    check(&[
        Fault {
            name: "a misspelt case",
            arguments: &["run", "five-spto"],
            code: 2,
            stderr: r#"
error: there is no file and no bundled case called "five-spto"; did you mean five-spot? (bundled: five-spot, two-layer, channel, barrier, inclusion, heterogeneous, spe10-1, reservoir-3d, theis, anisotropic, well-test, terzaghi, terzaghi-graded, terzaghi-tensor, column-3d, mandel, footing, layers-stiffness, sneddon, notched-tension, notched-shear, pressurised-notch, natural-fractures, injection-rate, kgd-toughness, kgd-viscosity, kgd-leak-off, breakdown, inclined-injection, two-cracks, wing-cracks, staged-injection, penny-3d, penny-viscosity, manufactured)
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt case to write",
            arguments: &["cases", "--write", "chanel"],
            code: 2,
            stderr: r#"
error: there is no bundled case "chanel"; did you mean channel?
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt variant to write",
            arguments: &["cases", "--write", "penny-3d/smoek"],
            code: 2,
            stderr: r#"
error: the case penny-3d has no variant "smoek"; did you mean smoke?
"#,
            ..FAULT
        },
        Fault {
            name: "a case that is there already",
            files: &[("channel/scene.toml", b"mine")],
            arguments: &["cases", "--write", "channel"],
            code: 2,
            stderr: r#"
error: channel/scene.toml exists already; move it away first
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt flag",
            arguments: &["run", "scene.toml", "--sovler", "auto"],
            code: 2,
            stderr: r#"
error: unexpected argument '--sovler' found

  tip: a similar argument exists: '--solver'

Usage: perifrac run --solver <SOLVER> <SCENE>

For more information, try '--help'.
"#,
            ..FAULT
        },
        Fault {
            name: "a verb that does not exist",
            arguments: &["rum", "scene.toml"],
            code: 2,
            stderr: r#"
error: unrecognized subcommand 'rum'

  tip: some similar subcommands exist: 'run', 'resume'

Usage: perifrac <COMMAND>

For more information, try '--help'.
"#,
            ..FAULT
        },
        Fault {
            name: "no scene",
            arguments: &["run"],
            code: 2,
            stderr: r#"
error: the following required arguments were not provided:
  <SCENE>

Usage: perifrac run <SCENE>

For more information, try '--help'.
"#,
            ..FAULT
        },
        Fault {
            name: "no threads",
            arguments: &["run", "scene.toml", "--threads", "0"],
            code: 2,
            stderr: r#"
error: --threads must be at least 1
"#,
            ..FAULT
        },
        Fault {
            name: "a number of threads that is none",
            arguments: &["run", "scene.toml", "--threads", "two"],
            code: 2,
            stderr: r#"
error: invalid value 'two' for '--threads <N>': invalid digit found in string

For more information, try '--help'.
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn overrides_that_cannot_be() {
    check(&[
        Fault {
            name: "an override without a value",
            arguments: &["run", "scene.toml", "--set", "time.end"],
            stderr: r#"
error: `--set` needs a key and a value
 --> --set #1:1:1
  |
1 | time.end
  | ^^^^^^^^
  |
  = help: write --set key.path=value, one key at a time
"#,
            ..FAULT
        },
        Fault {
            name: "an override with an open list",
            arguments: &["run", "scene.toml", "--set", "geometry.size=[1, 2"],
            stderr: r#"
error: unclosed array, expected `]`
 --> --set #1:1:20
  |
1 | geometry.size=[1, 2
  |                    ^
"#,
            ..FAULT
        },
        Fault {
            name: "the second of two overrides in a wrong unit",
            arguments: &[
                "check",
                "scene.toml",
                "--set",
                "time.step=1",
                "--set",
                "time.end=30 m",
            ],
            stderr: r#"
error: expected a time (s), found a length: "30 m"
 --> --set #2:1:10
  |
1 | time.end=30 m
  |          ^^^^
  |
  = help: write it like "2 h"
"#,
            ..FAULT
        },
        Fault {
            name: "an override of a key that does not exist",
            arguments: &["plan", "scene.toml", "--set", "time.ned=30 s"],
            stderr: r#"
error: unknown key `ned`
 --> --set #1:1:6
  |
1 | time.ned=30 s
  |      ^^^
  |
  = help: did you mean `end`?
"#,
            ..FAULT
        },
        Fault {
            name: "an override that does not fit the file",
            arguments: &[
                "run",
                "scene.toml",
                "--set",
                "wells.w.rate=1",
                "--set",
                "wells.w.at=[2, 0.5]",
            ],
            stderr: r#"
error: `at` lies outside the domain
 --> --set #2:1:12
  |
1 | wells.w.at=[2, 0.5]
  |            ^^^^^^^^
  |
  = help: the domain is [0, 1] × [0, 1] m
"#,
            ..FAULT
        },
        Fault {
            name: "a section set to a number",
            arguments: &["run", "scene.toml", "--set", "materials=3"],
            stderr: r#"
error: expected a table of named entries, found 3
 --> --set #1:1:11
  |
1 | materials=3
  |           ^
"#,
            ..FAULT
        },
        Fault {
            name: "a flag with a scheme that does not exist",
            arguments: &["run", "scene.toml", "--scheme", "implict"],
            stderr: r#"
error: `implict` is not known here
 --> --scheme:1:13
  |
1 | scheme.name="implict"
  |             ^^^^^^^^^
  |
  = help: did you mean `implicit`?
"#,
            ..FAULT
        },
        Fault {
            name: "a flag with a solver that does not exist",
            arguments: &["run", "scene.toml", "--solver", "faer-ltl"],
            stderr: r#"
error: unknown solver `faer-ltl`, did you mean `faer-llt`?; valid names: auto, faer-llt, faer-ldlt, faer-cg, faer-lu, fourier, minres, gmres, fgmres, bicgstab, petsc
 --> --solver:1:13
  |
1 | solver.name="faer-ltl"
  |             ^^^^^^^^^^
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn ends_that_cannot_be() {
    let wrong = |end: &'static str, message: &str, help: &str| {
        let marks = "^".repeat(end.len() + 2);
        let typed = format!("time.end=\"{end}\"");
        let text = format!(
            "error: {message}\n --> --end:1:10\n  |\n1 | {typed}\n  |          {marks}{help}"
        );
        let place = Place::with_scene(&[]);
        let outcome = place.run(&["plan", "scene.toml", "--end", end]);
        assert_eq!(outcome.code, Some(3), "{outcome:?}");
        assert_eq!(outcome.stderr.trim_end(), text);
    };
    wrong(
        "30 m",
        "expected a time (s), found a length: \"30 m\"",
        "\n  |\n  = help: write it like \"2 h\"",
    );
    wrong(
        "",
        "expected a number with a unit, such as \"3 m\", found \"\"",
        "",
    );
    wrong("0", "`end` must be positive", "");
    wrong("-1", "`end` must be positive", "");
}

#[test]
fn a_steady_run_has_no_end_to_set() {
    let place = Place::with_scene(&[]);
    let steady = [
        "check",
        "scene.toml",
        "--set",
        "time.mode=steady",
        "--end",
        "1 s",
    ];
    let outcome = place.run(&steady);
    assert_eq!(outcome.code, Some(3));
    assert!(
        outcome
            .stderr
            .starts_with("error: a steady run has no `--end`\n --> --set #1:1:11"),
        "{outcome:?}"
    );
}

#[test]
fn a_last_stage_cannot_end_before_the_one_in_front_of_it() {
    let place = Place::new();
    place.succeed(&["check", "staged-injection", "--end", "22 s"]);
    let outcome = place.run(&["check", "staged-injection", "--end", "20.3 s"]);
    assert_eq!(outcome.code, Some(3));
    let told = "error: the stage would end at 20.3 s, where the clock of the stage \"inject\" before it ends at 20.3 s";
    assert!(outcome.stderr.starts_with(told), "{outcome:?}");
    assert!(outcome.stdout.is_empty(), "{outcome:?}");
}
