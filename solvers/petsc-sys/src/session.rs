//! PETSc as started on its thread.

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::sync::OnceLock;

use crate::PetscError;
use crate::ffi::{self, Api, MPI_Comm, PetscErrorCode, PetscErrorType};
use crate::load::{Loaded, load};

/// Calls a function of the table and turns its code into a result.
macro_rules! call {
    ($session:expr, $function:ident($($argument:expr),* $(,)?)) => {
        $session.check(stringify!($function), ($session.api.$function)($($argument),*))
    };
}
pub(crate) use call;

/// Arguments PETSc is started with: no handler of signals, no options but ours, no output.
const ARGUMENTS: [&CStr; 5] = [
    c"perifrac",
    c"-no_signal_handler",
    c"-skip_petscrc",
    c"-options_left",
    c"no",
];
/// Variables by which a process knows that it was started as one of several.
const LAUNCHERS: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"];
/// Packages that matter to the choice of options.
const PACKAGES: [&str; 10] = [
    "mumps",
    "hypre",
    "superlu",
    "superlu_dist",
    "suitesparse",
    "scalapack",
    "ptscotch",
    "parmetis",
    "ml",
    "hdf5",
];

/// What to stop the team with, known to every thread.
static STOP: OnceLock<Stop> = OnceLock::new();

struct Stop {
    abort: unsafe extern "C" fn(MPI_Comm, c_int) -> c_int,
    team: MPI_Comm,
}

// SAFETY: a communicator is a value that any thread may name; see `abort` for the call.
unsafe impl Send for Stop {}
// SAFETY: as above.
unsafe impl Sync for Stop {}

/// Ends all processes of the team at once with this exit code, and this process alone where PETSc
/// was never started.
pub fn abort(code: i32) -> ! {
    if let Some(stop) = STOP.get() {
        // The thread of PETSc may be waiting for other processes, so it cannot be asked.
        // SAFETY: MPI was started. The call does not return, so it matters little that it comes
        // from another thread than the others.
        unsafe { (stop.abort)(stop.team, code) };
    }
    std::process::exit(code)
}

/// Who shares an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comm {
    /// Only this process.
    Own,
    /// All processes of the team.
    Communicator,
}

/// What is known of the library in use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Info {
    /// Version, as in `3.18.5`.
    pub version: String,
    /// File of the library.
    pub path: String,
    /// External packages it was built with.
    pub packages: Vec<&'static str>,
    /// Number of this process, from 0.
    pub rank: usize,
    /// Number of processes.
    pub size: usize,
}

/// PETSc, started. It exists on the thread of PETSc only.
#[derive(Debug)]
pub struct Session {
    pub(crate) api: Api,
    info: Info,
    team: MPI_Comm,
    own: MPI_Comm,
    finished: Cell<bool>,
    /// Keeps the type on its thread.
    _thread: PhantomData<*mut ()>,
}

thread_local! {
    /// Message of the last error, as PETSc told it to [`remember`].
    static MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// PETSc's handler of errors: keeps the message, prints nothing, lets the code go back.
unsafe extern "C" fn remember(
    _comm: MPI_Comm,
    _line: c_int,
    function: *const c_char,
    _file: *const c_char,
    code: PetscErrorCode,
    kind: PetscErrorType,
    message: *const c_char,
    _context: *mut c_void,
) -> PetscErrorCode {
    if kind == ffi::PETSC_ERROR_INITIAL {
        let (function, message) = (text(function), text(message));
        let message = format!("{} (in {function})", message.trim());
        let _ =
            MESSAGE.try_with(|last| last.try_borrow_mut().map(|mut last| *last = Some(message)));
    }
    code
}

/// A C string that PETSc handed out, or nothing for a null pointer.
pub(crate) fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: PETSc's strings end with a null character.
    let string = unsafe { CStr::from_ptr(pointer) };
    string.to_string_lossy().into_owned()
}

/// A C string to hand to PETSc.
pub(crate) fn c_text(text: &str) -> Result<CString, PetscError> {
    CString::new(text).map_err(|_| PetscError::Input("a text holds a null character".into()))
}

/// The start of a session.
pub(crate) struct Start;

impl Start {
    pub(crate) fn new() -> Self {
        Self
    }

    /// Loads and starts PETSc. The session stays for the life of the process.
    pub(crate) fn run(self) -> Result<&'static Session, PetscError> {
        let loaded = load()?;
        stand_alone_if_not_launched();
        initialise(&loaded.api)?;
        let session = describe(loaded)?;
        Ok(Box::leak(Box::new(session)))
    }
}

/// Without `mpirun`, Open MPI would start a daemon to find out that the process is alone.
fn stand_alone_if_not_launched() {
    const ALONE: &str = "OMPI_MCA_ess_singleton_isolated";
    let is_set = |name: &&str| std::env::var_os(name).is_some();
    if LAUNCHERS.iter().chain(&[ALONE]).any(is_set) {
        return;
    }
    // SAFETY: other threads of the process are Rust code, which reads the environment under the
    // lock that this call takes too; MPI, which reads it without, starts only afterwards.
    unsafe { std::env::set_var(ALONE, "1") };
}

fn initialise(api: &Api) -> Result<(), PetscError> {
    // MPI and PETSc keep the arguments: they are leaked.
    let arguments = ARGUMENTS.map(|argument| argument.as_ptr().cast_mut());
    let arguments = Box::leak(Box::new([
        arguments[0],
        arguments[1],
        arguments[2],
        arguments[3],
        arguments[4],
        std::ptr::null_mut(),
    ]));
    let count = Box::leak(Box::new(ARGUMENTS.len() as c_int));
    let list = Box::leak(Box::new(arguments.as_mut_ptr()));
    let none = std::ptr::null();
    // SAFETY: `list` holds `count` C strings and a null pointer, all of static lifetime, and
    // nobody writes to them; this is the first call on the only thread that calls PETSc.
    let started = unsafe { (api.PetscInitialize)(count, list, none, none) };
    if started != 0 {
        return Err(PetscError::Start(format!(
            "PetscInitialize gives {started}"
        )));
    }
    // SAFETY: the handler has the type PETSc expects and needs no context.
    let code = unsafe { (api.PetscPushErrorHandler)(Some(remember), std::ptr::null_mut()) };
    match code {
        0 => Ok(()),
        code => Err(PetscError::Start(format!(
            "PetscPushErrorHandler gives {code}"
        ))),
    }
}

/// The communicator of all processes.
fn team(loaded: &Loaded) -> Result<MPI_Comm, PetscError> {
    const NAME: &str = "PETSC_COMM_WORLD";
    // SAFETY: the symbol is a variable of type `MPI_Comm`, set by PetscInitialize.
    let symbol = unsafe { loaded.library.get::<*mut MPI_Comm>(NAME) };
    let place = *symbol.map_err(|_| PetscError::Symbol(NAME))?;
    // SAFETY: only the address of the symbol is taken.
    let open_mpi = unsafe { loaded.library.get::<*mut c_void>("ompi_mpi_comm_world") }.is_ok();
    if open_mpi {
        // SAFETY: with Open MPI the variable is a pointer.
        return Ok(unsafe { *place });
    }
    // SAFETY: MPICH and its kin use a C integer, which goes to functions in the same registers.
    let number = unsafe { *place.cast::<c_int>() };
    Ok(std::ptr::without_provenance_mut(number as u32 as usize))
}

fn describe(loaded: Loaded) -> Result<Session, PetscError> {
    let team = team(&loaded)?;
    let Loaded {
        library,
        api,
        path,
        version,
    } = loaded;
    // Its functions are used as long as the process lives.
    std::mem::forget(library);
    let (mut rank, mut size, mut own) = (0, 1, std::ptr::null_mut());
    // SAFETY: MPI was started and `team` is its communicator; all processes make these calls.
    let codes = unsafe {
        [
            (api.MPI_Comm_rank)(team, &mut rank),
            (api.MPI_Comm_size)(team, &mut size),
            (api.MPI_Comm_split)(team, rank, 0, &mut own),
        ]
    };
    if codes != [0; 3] {
        return Err(PetscError::Start(format!("MPI gives {codes:?}")));
    }
    let abort = api.MPI_Abort;
    let _ = STOP.set(Stop { abort, team });
    Ok(Session {
        info: Info {
            version,
            path,
            packages: packages(&api),
            rank: rank as usize,
            size: size as usize,
        },
        api,
        team,
        own,
        finished: Cell::new(false),
        _thread: PhantomData,
    })
}

fn packages(api: &Api) -> Vec<&'static str> {
    let present = |name: &&str| {
        let (Ok(name), mut found) = (c_text(name), ffi::PETSC_FALSE) else {
            return false;
        };
        // SAFETY: a C string and a valid place, after initialisation.
        let code = unsafe { (api.PetscHasExternalPackage)(name.as_ptr(), &mut found) };
        code == 0 && found == ffi::PETSC_TRUE
    };
    PACKAGES.into_iter().filter(|name| present(name)).collect()
}

impl Session {
    /// What is known of the library.
    #[must_use]
    pub fn info(&self) -> &Info {
        &self.info
    }

    pub(crate) fn comm(&self, comm: Comm) -> MPI_Comm {
        match comm {
            Comm::Own => self.own,
            Comm::Communicator => self.team,
        }
    }

    /// Number of processes that share objects on this communicator.
    pub(crate) fn size(&self, comm: Comm) -> usize {
        match comm {
            Comm::Own => 1,
            Comm::Communicator => self.info.size,
        }
    }

    /// Whether objects may still be destroyed.
    pub(crate) fn alive(&self) -> bool {
        !self.finished.get()
    }

    pub(crate) fn finish(&'static self) {
        if self.finished.replace(true) {
            return;
        }
        // SAFETY: the last call to PETSc; objects not yet dropped are leaked from now on.
        unsafe { (self.api.PetscFinalize)() };
    }

    /// The error behind a code, if it is one.
    pub(crate) fn check(
        &self,
        function: &'static str,
        code: PetscErrorCode,
    ) -> Result<(), PetscError> {
        if code == 0 {
            return Ok(());
        }
        let told = MESSAGE.take().filter(|message| !message.starts_with(' '));
        Err(PetscError::Call {
            function,
            code,
            message: told.unwrap_or_else(|| self.message(code)),
        })
    }

    /// PETSc's general text for a code.
    fn message(&self, code: PetscErrorCode) -> String {
        let mut message = std::ptr::null();
        // SAFETY: a valid place; the other may be null.
        unsafe { (self.api.PetscErrorMessage)(code, &mut message, std::ptr::null_mut()) };
        text(message)
    }
}
