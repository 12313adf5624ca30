//! `perifrac solvers`.

use perifrac_solvers::{BACKENDS, Backend, PRECONDITIONERS, PetscStatus, SolveError, petsc_status};

use super::exit::{Failure, print};

/// Arguments of `solvers`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {}

/// Lists solvers, preconditioners and what PETSc is there.
pub(super) fn run(_args: &Args) -> Result<(), Failure> {
    let mut text = String::from(
        "Choose with --solver NAME, --solver NAME:key=value,key=value, or\n\
         --solver \"petsc:-flag value ...\"\n\n",
    );
    for backend in BACKENDS {
        text += &describe(backend);
    }
    text += "\nPreconditioners\n";
    for own in PRECONDITIONERS {
        text += &format!("  {:14} {}\n", own.name, own.meaning);
    }
    text += &petsc(petsc_status());
    print(&text)
}

fn describe(backend: &Backend) -> String {
    let kinds: Vec<String> = backend.symmetries.iter().map(ToString::to_string).collect();
    let mut text = format!("{:13} {}\n", backend.name, backend.summary);
    text += &format!("{:13}   for {} systems\n", "", kinds.join(", "));
    for option in backend.options {
        let default = match option.default {
            "" => String::new(),
            default => format!(" (default {default})"),
        };
        text += &format!(
            "{:13}   {}={}{default}: {}\n",
            "",
            option.key,
            option.value.describe(),
            option.meaning
        );
    }
    text
}

fn petsc(status: Result<PetscStatus, SolveError>) -> String {
    match status {
        Ok(found) => format!(
            "\nPETSc {} in {}\n  with {}\n  processes: {} (start more with mpirun -n P)\n",
            found.version,
            found.path,
            found.packages.join(", "),
            found.processes
        ),
        Err(error) => format!("\nPETSc is not there: {error}\n"),
    }
}
