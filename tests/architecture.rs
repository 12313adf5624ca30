//! The direction of dependencies between the modules of the library (docs/adr/0001).

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

/// Every module may use those before it.
const ORDER: &[&str] = &[
    "parallel",
    "load",
    "geometry",
    "material",
    "reference",
    "scene",
    "plan",
    "operators",
    "assembly",
    "report",
    "effects",
    "boundary",
    "model",
    "explain",
    "schemes",
    "output",
    "run",
    "prelude",
    "cases",
    "study",
    "cli",
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// Names after `crate::` in code, comments left out.
fn used(text: &str) -> Vec<&str> {
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(|line| line.split("crate::").skip(1))
        .map(|rest| {
            rest.split(|c: char| !c.is_alphanumeric() && c != '_')
                .next()
                .unwrap_or("")
        })
        .filter(|name| ORDER.contains(name))
        .collect()
}

#[test]
fn modules_use_only_modules_before_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut seen = Vec::new();
    for path in sources(&root) {
        let relative = path.strip_prefix(&root).unwrap();
        let first = relative
            .components()
            .next()
            .unwrap()
            .as_os_str()
            .to_string_lossy();
        let module = first.trim_end_matches(".rs").to_owned();
        if module == "lib" || module == "main" {
            continue;
        }
        let place = ORDER.iter().position(|name| *name == module);
        let place = place.unwrap_or_else(|| panic!("{module} is not in the order"));
        for name in used(&fs::read_to_string(&path).unwrap()) {
            let other = ORDER.iter().position(|known| *known == name).unwrap();
            assert!(
                other <= place,
                "{} uses crate::{name}, which comes later",
                relative.display()
            );
        }
        seen.push(module);
    }
    for module in ORDER {
        assert!(
            seen.iter().any(|name| name == module),
            "{module} has no source"
        );
    }
}
