//! Sparse matrices by rows.

use crate::PetscError;
use crate::ffi::{self, PetscScalar};
use crate::session::{Comm, Session, call};
use crate::vector::{Vector, to_int};

/// What is known of the values of a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    General,
    /// Symmetric, now and later.
    Symmetric,
    /// Symmetric positive definite, now and later.
    PositiveDefinite,
}

/// Pattern of the rows that this process holds.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// Start of each row in `columns`, from 0, and the end of the last.
    pub starts: &'a [i32],
    /// Global numbers of the columns, ascending within a row.
    pub columns: &'a [i32],
    /// Number of rows and columns of the whole matrix.
    pub size: usize,
    /// Unknowns per point.
    pub block: usize,
}

impl Rows<'_> {
    fn check(&self) -> Result<(), PetscError> {
        let wrong = |what: &str| Err(PetscError::Input(format!("rows of a matrix: {what}")));
        let Some((last, _)) = self.starts.split_last() else {
            return wrong("there is no start");
        };
        if self.starts[0] != 0 || *last as usize != self.columns.len() {
            return wrong("the starts do not span the columns");
        }
        for row in self.starts.windows(2) {
            let (Ok(start), Ok(end)) = (usize::try_from(row[0]), usize::try_from(row[1])) else {
                return wrong("a start is negative");
            };
            let Some(columns) = self.columns.get(start..end) else {
                return wrong("the starts do not ascend");
            };
            if columns.windows(2).any(|pair| pair[0] >= pair[1]) {
                return wrong("columns do not ascend");
            }
            let outside = |column: &i32| usize::try_from(*column).map_or(true, |c| c >= self.size);
            if columns.first().is_some_and(outside) || columns.last().is_some_and(outside) {
                return wrong("a column is outside");
            }
        }
        Ok(())
    }
}

/// A sparse matrix; each process holds consecutive rows.
#[derive(Debug)]
pub struct Matrix {
    session: &'static Session,
    pub(crate) raw: ffi::Mat,
    shared: bool,
    nonzeros: usize,
}

impl Matrix {
    /// A matrix of zeros with this pattern.
    ///
    /// # Errors
    /// [`PetscError::Call`]; [`PetscError::Input`] for rows that make no matrix.
    pub fn new(
        session: &'static Session,
        comm: Comm,
        rows: &Rows<'_>,
        kind: Kind,
    ) -> Result<Self, PetscError> {
        rows.check()?;
        let shared = session.size(comm) > 1;
        let mut raw = std::ptr::null_mut();
        let comm = session.comm(comm);
        // SAFETY: a live communicator and a valid place.
        unsafe { call!(session, MatCreate(comm, &mut raw)) }?;
        let matrix = Self {
            session,
            raw,
            shared,
            nonzeros: rows.columns.len(),
        };
        matrix.lay_out(rows)?;
        matrix.declare(kind)?;
        Ok(matrix)
    }

    fn lay_out(&self, rows: &Rows<'_>) -> Result<(), PetscError> {
        let (session, raw) = (self.session, self.raw);
        let (local, block) = (to_int(rows.starts.len() - 1)?, to_int(rows.block)?);
        let (total, size) = (ffi::PETSC_DETERMINE, to_int(rows.size)?);
        if !self.shared {
            check_size(local, size)?;
        }
        let kind = if self.shared { c"mpiaij" } else { c"seqaij" };
        // SAFETY: a live matrix and a C string.
        unsafe {
            call!(session, MatSetSizes(raw, local, local, total, total))?;
            call!(session, MatSetType(raw, kind.as_ptr()))?;
            call!(session, MatSetBlockSize(raw, block))?;
        }
        let (starts, columns) = (rows.starts.as_ptr(), rows.columns.as_ptr());
        let zeros = vec![0.0; rows.columns.len()];
        // SAFETY: `Rows::check` has found the pattern to be one; everything is copied.
        unsafe {
            if self.shared {
                call!(
                    session,
                    MatMPIAIJSetPreallocationCSR(raw, starts, columns, zeros.as_ptr())
                )
            } else {
                call!(
                    session,
                    MatSeqAIJSetPreallocationCSR(raw, starts, columns, zeros.as_ptr())
                )
            }
        }?;
        let (mut found, mut columns) = (0, 0);
        // SAFETY: a live matrix and valid places.
        unsafe { call!(session, MatGetSize(raw, &mut found, &mut columns)) }?;
        check_size(found, size)
    }

    fn declare(&self, kind: Kind) -> Result<(), PetscError> {
        let options: &[ffi::MatOption] = match kind {
            Kind::General => &[],
            Kind::Symmetric => &[ffi::MAT_SYMMETRIC, ffi::MAT_SYMMETRY_ETERNAL],
            Kind::PositiveDefinite => &[
                ffi::MAT_SYMMETRIC,
                ffi::MAT_SYMMETRY_ETERNAL,
                ffi::MAT_SPD,
                ffi::MAT_SPD_ETERNAL,
            ],
        };
        for option in options {
            // SAFETY: a live matrix.
            unsafe {
                call!(
                    self.session,
                    MatSetOption(self.raw, *option, ffi::PETSC_TRUE)
                )
            }?;
        }
        Ok(())
    }

    /// Replaces all values of the rows of this process, in the order of the pattern.
    ///
    /// # Errors
    /// [`PetscError::Call`]; [`PetscError::Input`] for another number of values.
    pub fn set_values(&mut self, values: &[f64]) -> Result<(), PetscError> {
        if values.len() != self.nonzeros {
            let (found, expected) = (values.len(), self.nonzeros);
            return Err(PetscError::Input(format!(
                "{found} values for a matrix of {expected}"
            )));
        }
        let (session, raw) = (self.session, self.raw);
        if self.shared {
            // SAFETY: as many values as the pattern has entries are read.
            return unsafe { call!(session, MatUpdateMPIAIJWithArray(raw, values.as_ptr())) };
        }
        let mut array: *mut PetscScalar = std::ptr::null_mut();
        // SAFETY: the array holds the values in the order of the pattern, as many as `values`,
        // and is ours until it is given back.
        unsafe {
            call!(session, MatSeqAIJGetArray(raw, &mut array))?;
            if !values.is_empty() {
                std::ptr::copy_nonoverlapping(values.as_ptr(), array, values.len());
            }
            call!(session, MatSeqAIJRestoreArray(raw, &mut array))?;
            call!(session, MatAssemblyBegin(raw, ffi::MAT_FINAL_ASSEMBLY))?;
            call!(session, MatAssemblyEnd(raw, ffi::MAT_FINAL_ASSEMBLY))
        }
    }

    /// Names the rigid-body modes of points at these coordinates, one block of the vector each,
    /// as what the matrix hardly resists.
    ///
    /// # Errors
    /// [`PetscError::Call`].
    pub fn set_rigid_modes(&mut self, coordinates: &Vector) -> Result<(), PetscError> {
        let session = self.session;
        let mut space = std::ptr::null_mut();
        // SAFETY: live objects; the matrix takes a reference of its own.
        unsafe {
            call!(
                session,
                MatNullSpaceCreateRigidBody(coordinates.raw, &mut space)
            )?;
            let set = call!(session, MatSetNearNullSpace(self.raw, space));
            call!(session, MatNullSpaceDestroy(&mut space))?;
            set
        }
    }
}

/// The rows of all processes together must be those of a square matrix of this size.
fn check_size(found: i32, expected: i32) -> Result<(), PetscError> {
    if found == expected {
        return Ok(());
    }
    Err(PetscError::Input(format!(
        "the processes hold {found} rows of a matrix of {expected}"
    )))
}

impl Drop for Matrix {
    fn drop(&mut self) {
        if self.session.alive() {
            // SAFETY: destroyed once; solvers hold references of their own.
            unsafe { (self.session.api.MatDestroy)(&mut self.raw) };
        }
    }
}
