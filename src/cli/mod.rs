//! The command line: one file per verb.

mod cases;
mod check;
mod common;
mod completions;
mod exit;
#[cfg(feature = "study")]
mod forecast;
mod interrupt;
mod label;
mod man;
mod memory;
mod plan;
mod processes;
mod progress;
#[cfg(feature = "study")]
mod report;
mod resume;
mod run;
mod schema;
mod schemes;
mod solvers;
mod stages;
#[cfg(feature = "study")]
mod study;
mod threads;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

/// Implicit peridynamic simulator for flow in porous rock.
#[derive(Debug, Parser)]
#[command(name = "perifrac", version, max_term_width = 100)]
#[command(
    after_help = "SCENE is a path or the name of a bundled case; `perifrac cases` lists them.\n\
                        Precedence: defaults < scene < --set < the other flags.\n\
                        Exit codes: 0 done, 1 run failed, 2 usage or no PETSc, 3 scene, \
                        4 not converged, 130 interrupted,\n143 ended by SIGTERM."
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run a scene and write its results
    Run(run::Args),
    /// Go on with a run that was stopped, from its last checkpoint
    Resume(resume::Args),
    /// Tell what a scene would run, why, and what it would cost
    Plan(plan::Args),
    /// Check a scene without running it
    Check(check::Args),
    #[cfg(feature = "study")]
    /// Run a case in many ways and report what accuracy costs and where schemes hold
    Study(study::Args),
    #[cfg(feature = "study")]
    /// Put fields, histories, errors and balances of a run on one page
    Report(report::Args),
    /// List the bundled cases, or write one to a folder
    Cases(cases::Args),
    /// Tell what schemes, effects and solvers can be combined with, and why not
    Schemes,
    /// List the linear solvers and their options
    Solvers(solvers::Args),
    /// Print the JSON Schema of scenes, for editors, or what stands in the tables of runs
    Schema(schema::Args),
    /// Print a completion script for a shell
    Completions(completions::Args),
    /// Write the manual pages
    Man(man::Args),
}

/// Runs the program; the exit code tells how it went.
pub fn main() -> ExitCode {
    completions::answer(Cli::command);
    interrupt::keep_hangups_ignored();
    let verb = Cli::parse().verb;
    let result = threads::check_environment().and_then(|()| act(verb));
    processes::Processes::started().leave(&result)
}

fn act(verb: Verb) -> Result<(), exit::Failure> {
    match verb {
        Verb::Run(args) => run::run(&args),
        Verb::Resume(args) => resume::run(&args),
        Verb::Plan(args) => plan::run(&args),
        Verb::Check(args) => check::run(&args),
        #[cfg(feature = "study")]
        Verb::Study(args) => study::run(&args),
        #[cfg(feature = "study")]
        Verb::Report(args) => report::run(&args),
        Verb::Cases(args) => cases::run(&args),
        Verb::Schemes => schemes::run(),
        Verb::Solvers(args) => solvers::run(&args),
        Verb::Schema(args) => schema::run(&args),
        Verb::Completions(args) => completions::run(&args),
        Verb::Man(args) => man::run(&args, Cli::command()),
    }
}
