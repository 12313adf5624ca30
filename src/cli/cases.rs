//! `perifrac cases`.

use std::path::PathBuf;

use crate::cases::{CASES, find, names};
use crate::output::write_atomically;
use crate::scene::closest;

use super::exit::{Failure, print};

/// Arguments of `cases`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Write the scene and the notes of this case into the folder NAME
    #[arg(long, value_name = "NAME")]
    write: Option<String>,
}

/// Lists or writes cases.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let Some(name) = &args.write else {
        let lines: Vec<String> = CASES
            .iter()
            .map(|case| {
                let names = case.variants.iter().map(|(name, _)| format!(" /{name}"));
                let variants: String = names.collect();
                format!("{:17} {}{variants}", case.name, case.summary)
            })
            .collect();
        return print(&lines.join("\n"));
    };
    let Some(case) = find(name) else {
        let guess = closest(name, names())
            .map_or_else(String::new, |guess| format!("; did you mean {guess}?"));
        let message = format!("there is no bundled case \"{name}\"{guess}");
        return Err(Failure::Usage(message));
    };
    let folder = PathBuf::from(case.name);
    let mut files = vec![
        ("scene.toml".to_owned(), case.scene),
        ("README.md".to_owned(), case.readme),
    ];
    files.extend(
        case.variants
            .iter()
            .map(|(name, text)| (format!("{name}.toml"), *text)),
    );
    for (file, _) in &files {
        let path = folder.join(file);
        if path.exists() {
            let message = format!("{} exists already; move it away first", path.display());
            return Err(Failure::Usage(message));
        }
    }
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::Usage(format!("cannot create {}: {error}", folder.display())))?;
    for (file, text) in &files {
        write_atomically(folder.join(file), |out| out.write_all(text.as_bytes()))?;
    }
    print(&format!(
        "wrote {0}/scene.toml; run it with: perifrac run {0}/scene.toml",
        case.name
    ))
}
