//! Sets of unknowns.

use crate::PetscError;
use crate::ffi;
use crate::session::{Comm, Session, call};
use crate::vector::{Vector, to_int};

/// Unknowns by their global numbers; each process names its own.
#[derive(Debug)]
pub struct IndexSet {
    session: &'static Session,
    pub(crate) raw: ffi::IS,
}

impl IndexSet {
    /// The set of `indices`, which come in blocks of `block` consecutive numbers.
    ///
    /// # Errors
    /// [`PetscError::Call`], [`PetscError::Input`].
    pub fn new(
        session: &'static Session,
        comm: Comm,
        indices: &[i32],
        block: usize,
    ) -> Result<Self, PetscError> {
        let (length, block) = (to_int(indices.len())?, to_int(block)?);
        let (comm, copy) = (session.comm(comm), ffi::PETSC_COPY_VALUES);
        let mut raw = std::ptr::null_mut();
        // SAFETY: `length` indices are read and copied; a valid place.
        unsafe {
            call!(
                session,
                ISCreateGeneral(comm, length, indices.as_ptr(), copy, &mut raw)
            )
        }?;
        let set = Self { session, raw };
        // SAFETY: the set was just made.
        unsafe { call!(session, ISSetBlockSize(raw, block)) }?;
        Ok(set)
    }

    /// Gives the block of a matrix on this set the rigid-body modes of points at these
    /// coordinates, one block of the vector each, as near-nullspace.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn set_rigid_modes(&mut self, coordinates: &Vector) -> Result<(), PetscError> {
        let session = self.session;
        let mut space = std::ptr::null_mut();
        let raw = coordinates.raw;
        // SAFETY: live objects; composing takes a reference of its own.
        unsafe {
            call!(session, MatNullSpaceCreateRigidBody(raw, &mut space))?;
            let composed = call!(
                session,
                PetscObjectCompose(self.raw.cast(), c"nearnullspace".as_ptr(), space.cast())
            );
            call!(session, MatNullSpaceDestroy(&mut space))?;
            composed
        }
    }
}

impl Drop for IndexSet {
    fn drop(&mut self) {
        if self.session.alive() {
            // SAFETY: destroyed once; nothing of Rust refers to it any more.
            unsafe { (self.session.api.ISDestroy)(&mut self.raw) };
        }
    }
}
