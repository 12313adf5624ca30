//! `perifrac completions`, and what a shell is offered for the words of the command line.
//!
//! The scripts hold no words: at every tab they ask the program, by the dynamic engine of `clap_complete`. A script with
//! the words in it can offer files for a word or a list of values, and SCENE may be either; it would also go on to
//! offer the cases and solvers of the build that printed it. What the engine costs is a start of the program at a tab,
//! of some milliseconds.

use std::ffi::OsStr;
use std::path::Path;

use clap_complete::engine::{
    ArgValueCandidates, ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};
use clap_complete::env::Shells;
use clap_complete::{CompleteEnv, Shell};
use perifrac_solvers::BACKENDS;

use crate::cases::CASES;
use crate::scene::SchemeName;

use super::exit::{Failure, print};

/// Set by the scripts where they ask for candidates.
const VARIABLE: &str = "PERIFRAC_COMPLETE";

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The shell
    shell: Shell,
}

/// Prints the script that asks the program that was called, by the path it was called by.
pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let name = args.shell.to_string();
    let shells = Shells::builtins();
    let Some(shell) = shells.completer(&name) else {
        return Err(Failure::Usage(format!(
            "there are no completions for {name}"
        )));
    };
    let mut script = Vec::new();
    shell
        .write_registration(VARIABLE, "perifrac", "perifrac", &called(), &mut script)
        .map_err(|error| Failure::Usage(format!("no script could be made: {error}")))?;
    print(&String::from_utf8_lossy(&script))
}

/// The program as it was called: a name that is looked for on the path, or the whole of a path.
fn called() -> String {
    let word = std::env::args_os().next().unwrap_or_default();
    let whole = match Path::new(&word).components().count() {
        0 | 1 => Path::new(&word).to_owned(),
        _ => std::path::absolute(&word).unwrap_or_else(|_| word.into()),
    };
    whole.to_string_lossy().into_owned()
}

/// Answers a script that asks for candidates, and ends the program then.
pub(super) fn answer(command: fn() -> clap::Command) {
    CompleteEnv::with_factory(command).var(VARIABLE).complete();
}

/// For a word that names a scene: bundled cases, their variants, and files.
pub(super) fn scenes() -> ArgValueCompleter {
    ArgValueCompleter::new(|typed: &OsStr| {
        let files =
            PathCompleter::any().filter(|path| path.extension().is_some_and(|own| own == "toml"));
        let cases = bundled(typed).into_iter();
        cases.chain(files.complete(typed)).collect()
    })
}

/// For a word that names a bundled case.
pub(super) fn cases() -> ArgValueCompleter {
    ArgValueCompleter::new(bundled)
}

/// Bundled cases and variants that begin with what is typed.
fn bundled(typed: &OsStr) -> Vec<CompletionCandidate> {
    let all = CASES.iter().flat_map(|case| {
        let variants = case.variants.iter();
        let variants = variants.map(|(variant, _)| format!("{}/{variant}", case.name));
        let names = std::iter::once(case.name.to_owned()).chain(variants);
        names.map(|name| CompletionCandidate::new(name).help(Some(case.summary.into())))
    });
    let typed = typed.to_string_lossy();
    let fits = |own: &CompletionCandidate| own.get_value().to_string_lossy().starts_with(&*typed);
    all.filter(fits).collect()
}

/// For a word that names a time scheme.
pub(super) fn schemes() -> ArgValueCandidates {
    let names = || {
        SchemeName::ALL
            .iter()
            .map(|scheme| scheme.name().into())
            .collect()
    };
    ArgValueCandidates::new(names)
}

/// For a word that names a linear solver.
pub(super) fn solvers() -> ArgValueCandidates {
    ArgValueCandidates::new(|| {
        let named = |backend: &perifrac_solvers::Backend| {
            CompletionCandidate::new(backend.name).help(Some(backend.summary.into()))
        };
        BACKENDS.iter().map(named).collect()
    })
}
