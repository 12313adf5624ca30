//! Names of default folders: one for each variant of a case, so that none overwrites another.

use super::common::SceneArgs;

/// Longest name of a variant that is written out.
const LONGEST: usize = 100;
/// Letters of a longer one that are kept.
const KEPT: usize = 80;

/// What tells these arguments from the case itself, such as `+explicit+geometry.spacing=0.5`; empty without
/// any. Where a name cannot hold all of it, a checksum of the whole stands at its end.
pub(super) fn label(args: &SceneArgs) -> String {
    let scheme = args.scheme.iter().map(String::as_str);
    let solver = args.solver.iter().map(String::as_str);
    let end = args.end.as_ref().map(|end| format!("end={end}"));
    let words = scheme
        .chain(solver)
        .chain(args.overrides.iter().map(String::as_str))
        .chain(end.as_deref());
    let words: Vec<&str> = words.collect();
    let (mut text, mut whole) = (String::new(), true);
    for word in &words {
        let (name, complete) = plain(word);
        text += &format!("+{name}");
        whole &= complete;
    }
    if whole && text.len() <= LONGEST {
        return text;
    }
    let mut check = flate2::Crc::new();
    check.update(words.join("\n").as_bytes());
    let kept: String = text.chars().take(KEPT).collect();
    format!("{kept}~{:08x}", check.sum())
}

/// A word in letters that any file system takes, and whether nothing that matters is missing.
fn plain(word: &str) -> (String, bool) {
    let (key, value) = word.split_once('=').unwrap_or(("", word));
    let value = value.trim();
    let list = value
        .strip_prefix('[')
        .and_then(|rest| rest.strip_suffix(']'));
    let equals = if key.is_empty() { "" } else { "=" };
    let text = format!("{key}{equals}{}", list.unwrap_or(value));
    let mut whole = true;
    let mut letter = |c: char| match c {
        _ if c.is_whitespace() || c == '"' || c == '\'' => None,
        _ if c.is_ascii_alphanumeric() || ".,=+-_".contains(c) => Some(c),
        // The name of a solver and its options.
        ':' => Some('-'),
        _ => {
            whole = false;
            Some('-')
        }
    };
    (text.chars().filter_map(&mut letter).collect(), whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(scheme: Option<&str>, solver: Option<&str>, overrides: &[&str]) -> String {
        label(&SceneArgs {
            scene: String::new(),
            overrides: overrides.iter().map(|&text| text.to_owned()).collect(),
            scheme: scheme.map(str::to_owned),
            solver: solver.map(str::to_owned),
            end: None,
        })
    }

    #[test]
    fn a_variant_is_named_by_what_was_typed() {
        assert_eq!(named(None, None, &[]), "");
        let overrides = ["geometry.spacing = 0.5", "time.mode=\"steady\""];
        assert_eq!(
            named(Some("explicit"), None, &overrides),
            "+explicit+geometry.spacing=0.5+time.mode=steady"
        );
        assert_eq!(
            named(
                None,
                Some("faer-cg:preconditioner=amg"),
                &["geometry.points=[50, 50]"]
            ),
            "+faer-cg-preconditioner=amg+geometry.points=50,50"
        );
    }

    #[test]
    fn a_run_with_another_end_has_a_name_of_its_own() {
        let ending = |end: &str| {
            label(&SceneArgs {
                scene: String::new(),
                overrides: vec!["time.step=1".to_owned()],
                scheme: None,
                solver: None,
                end: Some(end.to_owned()),
            })
        };
        assert_eq!(ending("30 s"), "+time.step=1+end=30s");
    }

    #[test]
    fn what_a_name_cannot_hold_still_makes_another_name() {
        let pair = [
            "cracks.a.at=[[0, 1], [2, 3]]",
            "cracks.a.at=[[0], [1, 2, 3]]",
        ];
        let names = pair.map(|text| named(None, None, &[text]));
        assert_ne!(names[0], names[1]);
        let long = |last: &str| {
            let many = ["materials.rock.permeability=1e-15"; 9];
            named(None, None, &[&many[..], &[last]].concat())
        };
        assert_ne!(long("time.end=1"), long("time.end=2"));
        for name in [
            &names[0],
            &names[1],
            &long("time.end=1"),
            &named(None, None, &["a=../../b"]),
        ] {
            assert!(name.len() <= LONGEST, "{name}");
            assert!(!name.contains(['/', '\\', '[', ' ', ':']), "{name}");
        }
    }
}
