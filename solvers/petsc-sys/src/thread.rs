//! The one thread that calls PETSc.
//!
//! PETSc and an MPI that is started the usual way must be called by a single thread, the one that
//! started them. It is started here by the first who asks, and owns every object of PETSc. Work
//! is handed over as closures that receive the [`Session`]; objects that outlive one such closure
//! are kept in [`Parked`], which may travel between threads but opens only on this one.

use std::cell::Cell;
use std::mem::ManuallyDrop;
use std::sync::OnceLock;
use std::sync::mpsc::{Sender, channel};

use crate::PetscError;
use crate::session::{Session, Start};

type Job = Box<dyn FnOnce(&'static Session) + Send>;

/// The way to the thread, once it runs.
#[derive(Debug, Clone)]
struct Office {
    jobs: Sender<Job>,
}

static OFFICE: OnceLock<Result<Office, PetscError>> = OnceLock::new();

thread_local! {
    /// The session, on the thread that owns it.
    static SESSION: Cell<Option<&'static Session>> = const { Cell::new(None) };
}

/// Runs `work` on the thread of PETSc and waits for its result. PETSc is loaded and started first
/// if it is not yet.
///
/// # Errors
/// Why PETSc cannot be used, the same on every call.
pub fn run<R: Send>(work: impl FnOnce(&'static Session) -> R + Send) -> Result<R, PetscError> {
    if let Some(session) = SESSION.get() {
        return Ok(work(session));
    }
    let office = OFFICE.get_or_init(open).as_ref().map_err(Clone::clone)?;
    hand_over(office, work)
}

/// Ends PETSc and MPI. Every process of a team must call it, after its last use of PETSc. Without
/// effect if PETSc was never started.
pub fn finish() {
    let Some(Ok(office)) = OFFICE.get() else {
        return;
    };
    if SESSION.get().is_some() {
        return;
    }
    // Nobody is left to tell of an error.
    let _ = hand_over(office, Session::finish);
}

fn open() -> Result<Office, PetscError> {
    let (jobs, queue) = channel::<Job>();
    let (report, reported) = channel();
    let serve = move || {
        let session = match Start::new().run() {
            Ok(session) => session,
            Err(error) => {
                let _ = report.send(Err(error));
                return;
            }
        };
        SESSION.set(Some(session));
        let _ = report.send(Ok(()));
        for job in queue {
            // After the end of PETSc, work is dropped unread: whoever waits for it is told so.
            if session.alive() {
                job(session);
            }
        }
    };
    let thread = std::thread::Builder::new().name("petsc".into());
    thread
        .spawn(serve)
        .map_err(|error| PetscError::Start(error.to_string()))?;
    let died = || PetscError::Start("its thread ended".into());
    reported.recv().map_err(|_| died())??;
    Ok(Office { jobs })
}

fn hand_over<'a, R: Send + 'a>(
    office: &Office,
    work: impl FnOnce(&'static Session) -> R + Send + 'a,
) -> Result<R, PetscError> {
    let (answer, answered) = channel();
    let task = move |session: &'static Session| {
        let work = std::panic::AssertUnwindSafe(|| work(session));
        let outcome = std::panic::catch_unwind(work);
        let _ = answer.send(outcome);
    };
    let task: Box<dyn FnOnce(&'static Session) + Send + 'a> = Box::new(task);
    // SAFETY: only the lifetime changes. What the closure borrows stays alive until `recv` below
    // returns, and that is after the closure ran or was dropped: either its answer arrives or the
    // sender it owns is gone.
    let task: Job = unsafe { std::mem::transmute(task) };
    office.jobs.send(task).map_err(|_| PetscError::Finished)?;
    match answered.recv().map_err(|_| PetscError::Finished)? {
        Ok(result) => Ok(result),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// An object of the PETSc thread that other threads may hold but not open.
#[derive(Debug)]
pub struct Parked<T: 'static>(ManuallyDrop<T>);

// SAFETY: the content is made, reached and dropped on the PETSc thread only: `new` and `get` need
// the session, which never leaves that thread, and `drop` sends the content there.
unsafe impl<T> Send for Parked<T> {}

impl<T: 'static> Parked<T> {
    /// Parks an object.
    pub fn new(_session: &Session, object: T) -> Self {
        Self(ManuallyDrop::new(object))
    }

    /// The object, on its thread.
    pub fn get(&mut self, _session: &Session) -> &mut T {
        &mut self.0
    }
}

impl<T: 'static> Drop for Parked<T> {
    fn drop(&mut self) {
        // SAFETY: taken once, here; `self.0` is not used afterwards.
        let content = unsafe { ManuallyDrop::take(&mut self.0) };
        let content = Carried(ManuallyDrop::new(content));
        // After the end of PETSc the content is leaked: the closure is dropped without running.
        let _ = run(move |_| {
            let Carried(content) = { content };
            drop(ManuallyDrop::into_inner(content));
        });
    }
}

/// What `Parked` sends home.
struct Carried<T>(ManuallyDrop<T>);

// SAFETY: as for `Parked`.
unsafe impl<T> Send for Carried<T> {}
