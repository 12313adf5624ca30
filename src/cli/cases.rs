//! `perifrac cases`.

use std::path::{Path, PathBuf};

use crate::cases::{CASES, Case, find, names};
use crate::output::write_atomically;
use crate::scene::closest;

use super::completions;
use super::exit::{Failure, print};

/// Arguments of `cases`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Write the scene, its variants and the notes of this case
    #[arg(long, value_name = "CASE[/VARIANT]", add = completions::cases())]
    write: Option<String>,
    /// Folder to write to, the name of the case if absent
    #[arg(value_name = "DIR", requires = "write", value_hint = clap::ValueHint::DirPath)]
    folder: Option<PathBuf>,
}

/// Lists or writes cases.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    match &args.write {
        Some(name) => write(name, args.folder.as_deref()),
        None => list(),
    }
}

fn list() -> Result<(), Failure> {
    let lines: Vec<String> = CASES
        .iter()
        .map(|case| {
            let names = case.variants.iter().map(|(name, _)| format!(" /{name}"));
            let variants: String = names.collect();
            format!("{:17} {}{variants}", case.name, case.summary)
        })
        .collect();
    print(&lines.join("\n"))
}

/// Writes a case with all of its variants, which change its scene.
fn write(name: &str, folder: Option<&Path>) -> Result<(), Failure> {
    let (case, variant) = match name.split_once('/') {
        Some((case, variant)) => (case, Some(variant)),
        None => (name, None),
    };
    let guess =
        |guess: Option<&str>| guess.map_or_else(String::new, |g| format!("; did you mean {g}?"));
    let Some(case) = find(case) else {
        let guess = guess(closest(case, names()));
        let message = format!("there is no bundled case \"{case}\"{guess}");
        return Err(Failure::Usage(message));
    };
    let variants = || case.variants.iter().map(|(name, _)| *name);
    if let Some(variant) = variant.filter(|own| variants().all(|name| name != *own)) {
        let guess = guess(closest(variant, variants()));
        let message = format!("the case {} has no variant \"{variant}\"{guess}", case.name);
        return Err(Failure::Usage(message));
    }
    let folder = folder.unwrap_or(Path::new(case.name));
    write_files(case, folder)?;
    let scene = folder.join(format!("{}.toml", variant.unwrap_or("scene")));
    let scene = scene.display();
    print(&format!("wrote {scene}; run it with: perifrac run {scene}"))
}

fn write_files(case: &Case, folder: &Path) -> Result<(), Failure> {
    let own = [("scene.toml", case.scene), ("README.md", case.readme)];
    let own = own.map(|(file, text)| (file.to_owned(), text)).into_iter();
    let variants = case.variants.iter();
    let variants = variants.map(|(name, text)| (format!("{name}.toml"), *text));
    let files: Vec<(PathBuf, &str)> = own
        .chain(variants)
        .map(|(file, text)| (folder.join(file), text))
        .collect();
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists()) {
        let message = format!("{} exists already; move it away first", path.display());
        return Err(Failure::Usage(message));
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Usage(format!("cannot create {}: {error}", folder.display())))?;
    for (path, text) in &files {
        write_atomically(path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}
