//! A Krylov method with its preconditioner, chosen by options.

use std::ffi::c_char;

use crate::PetscError;
use crate::ffi;
use crate::index_set::IndexSet;
use crate::matrix::Matrix;
use crate::session::{Comm, Session, c_text, call, text};
use crate::vector::Vector;

/// Why a solve failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Failure {
    /// The limit of iterations was reached.
    Iterations,
    /// The residual grew.
    Divergence,
    /// The method broke down.
    Breakdown,
    /// The method needs a symmetric matrix or preconditioner.
    NotSymmetric,
    /// The preconditioner is not positive definite.
    IndefinitePreconditioner,
    /// The matrix is not positive definite.
    IndefiniteMatrix,
    /// A number became infinite or undefined.
    NotFinite,
    /// A factorisation met a zero pivot.
    ZeroPivot,
    /// A factorisation ran out of memory.
    OutOfMemory,
    /// The preconditioner failed for another reason.
    Preconditioner,
    /// A reason this crate does not know, by PETSc's number.
    Other(i32),
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Iterations done.
    pub iterations: usize,
    /// The failure, if it was one.
    pub failure: Option<Failure>,
}

/// Size of the factor of a direct solver, over all processes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FactorSize {
    /// Stored entries.
    pub nonzeros: u64,
    /// Bytes, 0 where the package does not tell.
    pub bytes: u64,
}

/// A method that PETSc calls KSP. It has its own table of options: two solvers may use the same
/// flags for different things.
#[derive(Debug)]
pub struct Solver {
    session: &'static Session,
    raw: ffi::KSP,
    options: ffi::PetscOptions,
}

impl Solver {
    /// A solver with these options: pairs of flag (`-ksp_type`) and value first, then a text of
    /// flags and values, which wins.
    ///
    /// # Errors
    /// [`PetscError::Call`], also for a text that PETSc cannot read.
    pub fn new(
        session: &'static Session,
        comm: Comm,
        defaults: &[(&str, String)],
        given: &str,
    ) -> Result<Self, PetscError> {
        let mut options = std::ptr::null_mut();
        // SAFETY: a valid place.
        unsafe { call!(session, PetscOptionsCreate(&mut options)) }?;
        let mut solver = Self {
            session,
            raw: std::ptr::null_mut(),
            options,
        };
        for (flag, value) in defaults {
            let (flag, value) = (c_text(flag)?, c_text(value)?);
            let (flag, value) = (flag.as_ptr(), value.as_ptr());
            // SAFETY: a live table and C strings, which are copied.
            unsafe { call!(session, PetscOptionsSetValue(options, flag, value)) }?;
        }
        let given = c_text(given)?;
        // SAFETY: as above.
        unsafe { call!(session, PetscOptionsInsertString(options, given.as_ptr())) }?;
        let comm = session.comm(comm);
        solver.with_options(|raw| {
            // SAFETY: a live communicator and a valid place.
            unsafe { call!(session, KSPCreate(comm, raw)) }
        })?;
        Ok(solver)
    }

    /// Makes the options of this solver those that PETSc reads while `work` runs.
    fn with_options<T>(
        &mut self,
        work: impl FnOnce(&mut ffi::KSP) -> Result<T, PetscError>,
    ) -> Result<T, PetscError> {
        let session = self.session;
        // SAFETY: a live table, taken off again below.
        unsafe { call!(session, PetscOptionsPush(self.options)) }?;
        let result = work(&mut self.raw);
        // SAFETY: takes off what was put on above.
        unsafe { call!(session, PetscOptionsPop()) }?;
        result
    }

    fn preconditioner_handle(&self) -> Result<ffi::PC, PetscError> {
        let mut raw = std::ptr::null_mut();
        // SAFETY: a live solver and a valid place; the solver keeps the object.
        unsafe { call!(self.session, KSPGetPC(self.raw, &mut raw)) }?;
        Ok(raw)
    }

    /// Names the matrix of the system. Name it again when its values have changed: the next
    /// [`Self::set_up`] then takes them in.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn set_matrix(&mut self, matrix: &Matrix) -> Result<(), PetscError> {
        let (session, matrix) = (self.session, matrix.raw);
        // SAFETY: live objects; the solver takes a reference of its own.
        self.with_options(|raw| unsafe { call!(session, KSPSetOperators(*raw, matrix, matrix)) })
    }

    /// Names a block of unknowns for the preconditioner `fieldsplit`, which is chosen by it.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn add_block(&mut self, name: &str, unknowns: &IndexSet) -> Result<(), PetscError> {
        let (session, pc, name) = (self.session, self.preconditioner_handle()?, c_text(name)?);
        let set = unknowns.raw;
        // SAFETY: live objects and C strings; the solver takes references of its own.
        self.with_options(|_| unsafe {
            call!(session, PCSetType(pc, c"fieldsplit".as_ptr()))?;
            call!(session, PCFieldSplitSetIS(pc, name.as_ptr(), set))
        })
    }

    /// Takes in the options.
    ///
    /// # Errors
    /// [`PetscError::Call`] for an unknown method or a wrong value.
    pub fn configure(&mut self) -> Result<(), PetscError> {
        let session = self.session;
        // SAFETY: a live solver.
        self.with_options(|raw| unsafe { call!(session, KSPSetFromOptions(*raw)) })
    }

    /// Name of the method, as in `-ksp_type`.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn method(&self) -> Result<String, PetscError> {
        let mut name = std::ptr::null();
        // SAFETY: a live solver and a valid place.
        unsafe { call!(self.session, KSPGetType(self.raw, &mut name)) }?;
        Ok(text(name))
    }

    /// Name of the preconditioner, as in `-pc_type`.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn preconditioner(&self) -> Result<String, PetscError> {
        let (pc, mut name) = (self.preconditioner_handle()?, std::ptr::null());
        // SAFETY: a live object and a valid place.
        unsafe { call!(self.session, PCGetType(pc, &mut name)) }?;
        Ok(text(name))
    }

    /// Judges convergence by the true residual; not all methods can.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn use_true_residual(&mut self) -> Result<(), PetscError> {
        let norm = ffi::KSP_NORM_UNPRECONDITIONED;
        // SAFETY: a live solver.
        unsafe { call!(self.session, KSPSetNormType(self.raw, norm)) }
    }

    /// Relative residual at which to stop. The other limits stay.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn set_tolerance(&mut self, relative: f64) -> Result<(), PetscError> {
        let (mut old, mut absolute, mut divergence, mut limit) = (0.0, 0.0, 0.0, 0);
        let (session, raw) = (self.session, self.raw);
        // SAFETY: a live solver and valid places.
        unsafe {
            call!(
                session,
                KSPGetTolerances(raw, &mut old, &mut absolute, &mut divergence, &mut limit)
            )?;
            call!(
                session,
                KSPSetTolerances(raw, relative, absolute, divergence, limit)
            )
        }
    }

    /// Lets `gamg` keep its aggregates when values change, or not.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn keep_aggregates(&mut self, keep: bool) -> Result<(), PetscError> {
        let (pc, keep) = (self.preconditioner_handle()?, ffi::PetscBool::from(keep));
        // SAFETY: a live object; others than `gamg` ignore the call.
        unsafe { call!(self.session, PCGAMGSetReuseInterpolation(pc, keep)) }
    }

    /// Sets up for the present values of the matrix.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn set_up(&mut self) -> Result<Option<Failure>, PetscError> {
        let session = self.session;
        // SAFETY: a live solver.
        self.with_options(|raw| unsafe {
            call!(session, KSPSetUp(*raw))?;
            call!(session, KSPSetUpOnBlocks(*raw))
        })?;
        self.set_up_failure()
    }

    fn set_up_failure(&self) -> Result<Option<Failure>, PetscError> {
        let (pc, mut reason) = (self.preconditioner_handle()?, ffi::PC_NOERROR);
        // SAFETY: a live object and a valid place.
        unsafe { call!(self.session, PCGetFailedReason(pc, &mut reason)) }?;
        Ok(match reason {
            ffi::PC_NOERROR => None,
            ffi::PC_FACTOR_STRUCT_ZEROPIVOT | ffi::PC_FACTOR_NUMERIC_ZEROPIVOT => {
                Some(Failure::ZeroPivot)
            }
            ffi::PC_FACTOR_OUTMEMORY => Some(Failure::OutOfMemory),
            _ => Some(Failure::Preconditioner),
        })
    }

    /// Solves from zero.
    ///
    /// # Errors
    /// [`PetscError::Call`]. A failure to converge is an outcome, not an error.
    pub fn solve(&mut self, rhs: &Vector, x: &mut Vector) -> Result<Outcome, PetscError> {
        let session = self.session;
        let (mut iterations, mut reason) = (0, 0);
        // SAFETY: live objects and valid places.
        self.with_options(|raw| unsafe {
            call!(session, KSPSolve(*raw, rhs.raw, x.raw))?;
            call!(session, KSPGetIterationNumber(*raw, &mut iterations))?;
            call!(session, KSPGetConvergedReason(*raw, &mut reason))
        })?;
        Ok(Outcome {
            iterations: usize::try_from(iterations).unwrap_or(0),
            failure: self.failure(reason)?,
        })
    }

    fn failure(&self, reason: ffi::KSPConvergedReason) -> Result<Option<Failure>, PetscError> {
        Ok(match reason {
            0.. => None,
            ffi::KSP_DIVERGED_ITS => Some(Failure::Iterations),
            ffi::KSP_DIVERGED_DTOL => Some(Failure::Divergence),
            ffi::KSP_DIVERGED_BREAKDOWN | ffi::KSP_DIVERGED_BREAKDOWN_BICG => {
                Some(Failure::Breakdown)
            }
            ffi::KSP_DIVERGED_NONSYMMETRIC => Some(Failure::NotSymmetric),
            ffi::KSP_DIVERGED_INDEFINITE_PC => Some(Failure::IndefinitePreconditioner),
            ffi::KSP_DIVERGED_INDEFINITE_MAT => Some(Failure::IndefiniteMatrix),
            ffi::KSP_DIVERGED_NANORINF => Some(Failure::NotFinite),
            ffi::KSP_DIVERGED_PC_FAILED => {
                let known = self.set_up_failure()?;
                Some(known.unwrap_or(Failure::Preconditioner))
            }
            other => Some(Failure::Other(other)),
        })
    }

    /// Flags that nothing has read so far, without their dash.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn unused_flags(&self) -> Result<Vec<String>, PetscError> {
        let (session, options) = (self.session, self.options);
        let mut count = 0;
        let mut names: *mut *mut c_char = std::ptr::null_mut();
        let mut values: *mut *mut c_char = std::ptr::null_mut();
        // SAFETY: a live table and valid places; `names` holds `count` C strings until it is
        // given back.
        unsafe {
            call!(
                session,
                PetscOptionsLeftGet(options, &mut count, &mut names, &mut values)
            )?;
            let flags = (0..usize::try_from(count).unwrap_or(0)).map(|i| text(*names.add(i)));
            let flags = flags.collect();
            call!(
                session,
                PetscOptionsLeftRestore(options, &mut count, &mut names, &mut values)
            )?;
            Ok(flags)
        }
    }

    /// Size of the factor, if the preconditioner is a factorisation.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn factor_size(&self) -> Result<Option<FactorSize>, PetscError> {
        if !["lu", "cholesky", "ilu", "icc"].contains(&self.preconditioner()?.as_str()) {
            return Ok(None);
        }
        let (session, pc) = (self.session, self.preconditioner_handle()?);
        let mut factor = std::ptr::null_mut();
        let mut info = ffi::MatInfo::default();
        // SAFETY: live objects and valid places; the preconditioner keeps the factor.
        unsafe {
            call!(session, PCFactorGetMatrix(pc, &mut factor))?;
            call!(session, MatGetInfo(factor, ffi::MAT_GLOBAL_SUM, &mut info))?;
        }
        Ok(Some(FactorSize {
            nonzeros: info.nz_used as u64,
            bytes: info.memory as u64,
        }))
    }
}

impl Drop for Solver {
    fn drop(&mut self) {
        if self.session.alive() {
            // SAFETY: destroyed once; nothing of Rust refers to them any more.
            unsafe {
                if !self.raw.is_null() {
                    (self.session.api.KSPDestroy)(&mut self.raw);
                }
                (self.session.api.PetscOptionsDestroy)(&mut self.options);
            }
        }
    }
}
