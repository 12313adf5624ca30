//! What a run works with, and who is told how it goes on.

use std::path::PathBuf;
use std::sync::Arc;

use perifrac_solvers::{Communicator, Interrupt};

use super::Writer;
use super::checkpoint::{Checkpoint, Snapshot};
use super::settings::Settings;
use super::view::View;
use crate::schemes::State;

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Time, s.
    pub time: f64,
    /// End, s.
    pub end: f64,
    /// Last step, s.
    pub dt: f64,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// Iterations of the linear solver in the last step.
    pub iterations: usize,
    /// Passes between the fields in the last step, and what the last of them left, relative to its scale.
    pub passes: Option<(usize, f64)>,
    /// Energy of Eq. 73 less the work of the loads, J; with mechanics.
    pub potential: Option<f64>,
    /// Length of all cracks, m (area in space, m²); with damage.
    pub crack_length: Option<f64>,
}

/// Is told how a run goes on; `()` does not listen.
///
/// To end a run from here, say that it [is enough](Observer::is_enough), or raise its [`Interrupt`].
///
/// ```
/// use perifrac::prelude::*;
///
/// struct Impatient(Interrupt);
///
/// impl Observer for Impatient {
///     fn step(&mut self, progress: &Progress) {
///         if progress.steps == 3 {
///             self.0.raise();
///         }
///     }
/// }
///
/// # let scene = r#"
/// #     title = "A square that drains to the left"
/// #     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
/// #     fluid.viscosity = "1 mPa s"
/// #     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
/// #     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
/// #     time.end = "1 s"
/// # "#;
/// let plan = Setup::text(scene).plan()?;
/// let interrupt = Interrupt::default();
/// let ended = run(&plan, None, &mut Impatient(interrupt.clone()), &interrupt);
/// assert!(matches!(ended, Err(RunError::Interrupted { .. })));
/// # Ok::<(), SceneErrors>(())
/// ```
pub trait Observer {
    /// A doubt arose.
    fn warn(&mut self, _message: &str) {}
    /// A step was accepted.
    fn step(&mut self, _progress: &Progress) {}
    /// The fields after that step.
    fn state(&mut self, _state: &State) {}
    /// What can be asked of the state after the start and after every step; comes last of the three.
    fn look(&mut self, _view: &dyn View) {}
    /// Whether the run has come far enough: it then ends after this step as it would at its end, with all its
    /// files, and can go on from there. An [`Interrupt`] leaves without a summary.
    fn is_enough(&mut self) -> bool {
        false
    }
    /// What can be asked of the state with which the run ends, at its end or before.
    fn end(&mut self, _view: &dyn View) {}
}

impl Observer for () {}

/// What a run works with, beside its plan.
///
/// ```
/// use perifrac::prelude::*;
///
/// # let scene = r#"
/// #     title = "A square that drains to the left"
/// #     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
/// #     fluid.viscosity = "1 mPa s"
/// #     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
/// #     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
/// #     time.end = "1 s"
/// # "#;
/// let plan = Setup::text(scene).plan()?;
/// let (interrupt, mut listener) = (Interrupt::default(), ());
/// let job = Job {
///     settings: Settings { reject_every: Some(2), ..Settings::default() },
///     ..Job::new(&mut listener, &interrupt)
/// };
/// // Every second step is done twice, which must change nothing.
/// let (_, state) = run_job(&plan, job)?;
/// let (_, usual) = run(&plan, None, &mut (), &interrupt)?;
/// assert_eq!(state.pressure, usual.pressure);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Job<'a> {
    /// Other processes, if there are any: all must run the same plan together, each with its own writer.
    /// The summary and the state are the same everywhere.
    pub team: Option<&'a Arc<dyn Communicator>>,
    /// Writes the files of the run.
    pub writer: Option<&'a mut Writer>,
    /// Is told how the run goes on.
    pub observer: &'a mut dyn Observer,
    /// Stops the run.
    pub interrupt: &'a Interrupt,
    /// How the run is done.
    pub settings: Settings,
    /// Folder that paths of the scene are relative to, for checkpoints.
    pub base: PathBuf,
    /// Where the run goes on from; its beginning without one.
    pub from: Option<Checkpoint>,
    /// Takes in the state every now and then, for whoever ends the program while a step cannot be left.
    pub snapshot: Snapshot,
}

impl<'a> Job<'a> {
    /// A run in this process alone, without files.
    pub fn new(observer: &'a mut dyn Observer, interrupt: &'a Interrupt) -> Self {
        Job {
            team: None,
            writer: None,
            observer,
            interrupt,
            settings: Settings::default(),
            base: PathBuf::new(),
            from: None,
            snapshot: Snapshot::default(),
        }
    }
}
