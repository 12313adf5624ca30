//! Vectors, and vectors brought together on every process.

use crate::PetscError;
use crate::ffi::{self, PetscInt};
use crate::session::{Comm, Session, call};

/// A count as PETSc takes it.
pub(crate) fn to_int(count: usize) -> Result<PetscInt, PetscError> {
    let too_large = || PetscError::Input(format!("{count} does not fit into 32-bit integers"));
    PetscInt::try_from(count).map_err(|_| too_large())
}

/// A vector; each process holds consecutive entries of it.
#[derive(Debug)]
pub struct Vector {
    session: &'static Session,
    pub(crate) raw: ffi::Vec,
    length: usize,
}

impl Vector {
    /// A vector of which this process holds `length` entries, in blocks of `block`.
    ///
    /// # Errors
    /// [`PetscError::Call`], [`PetscError::Input`].
    pub fn new(
        session: &'static Session,
        comm: Comm,
        length: usize,
        block: usize,
    ) -> Result<Self, PetscError> {
        let (local, block) = (to_int(length)?, to_int(block)?);
        let mut raw = std::ptr::null_mut();
        let comm = session.comm(comm);
        // SAFETY: a live communicator and a valid place.
        unsafe {
            call!(
                session,
                VecCreateMPI(comm, local, ffi::PETSC_DETERMINE, &mut raw)
            )
        }?;
        let vector = Self {
            session,
            raw,
            length,
        };
        // SAFETY: the vector was just made.
        unsafe { call!(session, VecSetBlockSize(raw, block)) }?;
        Ok(vector)
    }

    /// Number of entries this process holds.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    /// Sets the entries of this process.
    ///
    /// # Errors
    /// [`PetscError::Call`]; [`PetscError::Input`] for another length.
    pub fn set(&mut self, values: &[f64]) -> Result<(), PetscError> {
        self.check_length(values.len())?;
        let mut array = std::ptr::null_mut();
        // SAFETY: a live vector; its array has `length` entries, as many as `values`, and is ours
        // until it is given back.
        unsafe {
            call!(self.session, VecGetArray(self.raw, &mut array))?;
            if !values.is_empty() {
                std::ptr::copy_nonoverlapping(values.as_ptr(), array, values.len());
            }
            call!(self.session, VecRestoreArray(self.raw, &mut array))
        }
    }

    /// Copies the entries of this process.
    ///
    /// # Errors
    /// [`PetscError::Call`]; [`PetscError::Input`] for another length.
    pub fn get(&self, values: &mut [f64]) -> Result<(), PetscError> {
        self.check_length(values.len())?;
        let mut array = std::ptr::null();
        // SAFETY: as in `set`, with the roles exchanged.
        unsafe {
            call!(self.session, VecGetArrayRead(self.raw, &mut array))?;
            if !values.is_empty() {
                std::ptr::copy_nonoverlapping(array, values.as_mut_ptr(), values.len());
            }
            call!(self.session, VecRestoreArrayRead(self.raw, &mut array))
        }
    }

    fn check_length(&self, found: usize) -> Result<(), PetscError> {
        if found == self.length {
            return Ok(());
        }
        let expected = self.length;
        Err(PetscError::Input(format!(
            "{found} values for a vector of {expected}"
        )))
    }
}

impl Drop for Vector {
    fn drop(&mut self) {
        if self.session.alive() {
            // SAFETY: destroyed once; nothing of Rust refers to it any more.
            unsafe { (self.session.api.VecDestroy)(&mut self.raw) };
        }
    }
}

/// Brings the entries of a vector together on every process of the team.
#[derive(Debug)]
pub struct Gather {
    part: Vector,
    whole: Vector,
    scatter: ffi::VecScatter,
}

impl Gather {
    /// For a vector of which this process holds `length` entries.
    ///
    /// # Errors
    /// [`PetscError::Call`], [`PetscError::Input`].
    pub fn new(session: &'static Session, length: usize) -> Result<Self, PetscError> {
        let part = Vector::new(session, Comm::Communicator, length, 1)?;
        let (mut scatter, mut raw) = (std::ptr::null_mut(), std::ptr::null_mut());
        // SAFETY: a live vector and valid places.
        unsafe {
            call!(
                session,
                VecScatterCreateToAll(part.raw, &mut scatter, &mut raw)
            )
        }?;
        let mut gather = Self {
            part,
            whole: Vector {
                session,
                raw,
                length: 0,
            },
            scatter,
        };
        let mut length = 0;
        // SAFETY: the vector was just made.
        unsafe { call!(session, VecGetLocalSize(raw, &mut length)) }?;
        gather.whole.length = length as usize;
        Ok(gather)
    }

    /// Gives the entries of this process and receives those of all, process after process.
    ///
    /// # Errors
    /// [`PetscError::Call`]; [`PetscError::Input`] for wrong lengths.
    pub fn gather(&mut self, own: &[f64], all: &mut [f64]) -> Result<(), PetscError> {
        self.part.set(own)?;
        let (session, scatter) = (self.part.session, self.scatter);
        let (from, to) = (self.part.raw, self.whole.raw);
        let (insert, forward) = (ffi::INSERT_VALUES, ffi::SCATTER_FORWARD);
        // SAFETY: live objects that were made for each other.
        unsafe {
            call!(session, VecScatterBegin(scatter, from, to, insert, forward))?;
            call!(session, VecScatterEnd(scatter, from, to, insert, forward))?;
        }
        self.whole.get(all)
    }
}

impl Drop for Gather {
    fn drop(&mut self) {
        let session = self.part.session;
        if session.alive() {
            // SAFETY: destroyed once; nothing of Rust refers to it any more.
            unsafe { (session.api.VecScatterDestroy)(&mut self.scatter) };
        }
    }
}
