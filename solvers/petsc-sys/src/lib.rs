//! PETSc, loaded at run time, behind safe types.
//!
//! Nothing of PETSc is needed to build this crate: the library is opened when it is first asked
//! for, and a program without it runs as long as nobody asks. Versions 3.18 to 3.23 with real
//! numbers in double precision and 32-bit integers can be used, on any MPI they were built with.
//!
//! All calls are made by one thread, see [`run`]; objects refer to a [`Session`] and stay there:
//!
//! ```no_run
//! use perifrac_petsc_sys::{Comm, PetscError, Vector, run};
//!
//! # fn main() -> Result<(), PetscError> {
//! let length = run(|session| -> Result<usize, PetscError> {
//!     let mut vector = Vector::new(session, Comm::Own, 4, 2)?;
//!     vector.set(&[1.0, 2.0, 3.0, 4.0])?;
//!     Ok(vector.length())
//! })??;
//! # assert_eq!(length, 4); Ok(()) }
//! ```
//!
//! This is the only crate of the workspace with unsafe code.

mod error;
#[allow(non_camel_case_types, non_snake_case, clippy::upper_case_acronyms)]
mod ffi;
mod index_set;
mod load;
mod matrix;
mod session;
mod solver;
mod thread;
mod vector;

pub use error::PetscError;
pub use index_set::IndexSet;
pub use load::PATH_VARIABLE;
pub use matrix::{Kind, Matrix, Rows};
pub use session::{Comm, Info, Session, abort};
pub use solver::{FactorSize, Failure, Outcome, Solver};
pub use thread::{Parked, finish, run};
pub use vector::{Gather, Vector};
