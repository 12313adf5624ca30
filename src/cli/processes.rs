//! A run over several processes: who speaks, and how a failure of one ends all.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use perifrac_solvers::{Communicator, petsc_abort, petsc_finish, petsc_team};

use super::exit::Failure;

/// Variables in which starters of MPI tell a process its number, and how many there are.
const VARIABLES: [(&str, &str); 3] = [
    ("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"),
    ("PMI_RANK", "PMI_SIZE"),
    ("MV2_COMM_WORLD_RANK", "MV2_COMM_WORLD_SIZE"),
];

/// How long other processes leave the first one time to tell of a failure that all share.
const COURTESY: Duration = Duration::from_millis(1500);

/// Whether the processes have been brought together.
static JOINED: AtomicBool = AtomicBool::new(false);

/// This process among those that were started together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Processes {
    /// Number of this one, from 0.
    pub rank: usize,
    /// How many there are.
    pub size: usize,
}

impl Processes {
    /// What the starter said; one process if there was none.
    pub(super) fn started() -> Self {
        let number = |name: &str| std::env::var(name).ok()?.parse().ok();
        let known = VARIABLES.iter().find_map(|(rank, size)| {
            Some(Processes {
                rank: number(rank)?,
                size: number(size)?,
            })
        });
        known.unwrap_or(Processes { rank: 0, size: 1 })
    }

    /// Whether this is the one that prints.
    pub(super) fn leads(self) -> bool {
        self.rank == 0
    }

    /// Brings the processes together, if there are several.
    ///
    /// # Errors
    /// [`Failure::Usage`] without PETSc, or if its MPI is not that of the starter.
    pub(super) fn team(self) -> Result<Option<Arc<dyn Communicator>>, Failure> {
        if self.size == 1 {
            return Ok(None);
        }
        let usage = |reason: String| {
            let size = self.size;
            Failure::Usage(format!("{size} processes were started, but {reason}"))
        };
        let team = petsc_team().map_err(|error| usage(error.to_string()))?;
        if team.size() != self.size {
            return Err(usage(format!(
                "PETSc sees {}: start them with the mpirun of the MPI that PETSc was built with",
                team.size()
            )));
        }
        JOINED.store(true, Ordering::Relaxed);
        Ok(Some(team))
    }

    /// Threads of each process, if the user does not say: all processors are shared out.
    pub(super) fn threads(self) -> Option<usize> {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        (self.size > 1).then(|| (processors / self.size).max(1))
    }

    /// Ends the program. A failure ends all processes: others may wait for this one for ever.
    pub(super) fn leave(self, result: &Result<(), Failure>) -> ExitCode {
        let Err(failure) = result else {
            petsc_finish();
            return ExitCode::SUCCESS;
        };
        if !self.leads() {
            std::thread::sleep(COURTESY);
        }
        // What fails before the processes are together fails in all of them alike.
        let joined = JOINED.load(Ordering::Relaxed);
        let code = match self.leads() || joined {
            true => failure.report(),
            false => failure.code(),
        };
        match joined {
            true => petsc_abort(i32::from(code)),
            false => {
                petsc_finish();
                ExitCode::from(code)
            }
        }
    }
}
