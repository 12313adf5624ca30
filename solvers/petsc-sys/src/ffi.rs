//! Types, constants and functions of the C interface, declared by hand.
//!
//! `tests/headers.rs` holds every declaration against the headers of an installed PETSc.

use std::ffi::{c_char, c_int, c_uint, c_void};

use crate::PetscError;

/// Declares handles: pointers to structures of unknown content.
macro_rules! handles {
    ($($name:ident = $target:ident;)*) => {$(
        #[repr(C)]
        #[derive(Debug)]
        pub(crate) struct $target {
            _opaque: [u8; 0],
        }
        pub(crate) type $name = *mut $target;
    )*};
}

/// Declares constants of C enumerations.
macro_rules! constants {
    ($($name:ident: $kind:ident = $value:expr;)*) => {$(
        pub(crate) const $name: $kind = $value;
    )*};
}

/// Declares the table of functions and how it is filled from the library.
macro_rules! functions {
    ($($name:ident: fn($($argument:ty),*) -> $result:ty;)*) => {
        /// Addresses of the functions used.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct Api {
            $(pub(crate) $name: unsafe extern "C" fn($($argument),*) -> $result,)*
        }

        impl Api {
            /// Looks up every function.
            ///
            /// # Errors
            /// [`PetscError::Symbol`] for the first one missing.
            pub(crate) fn load(library: &libloading::Library) -> Result<Self, PetscError> {
                Ok(Self {
                    $($name: {
                        // SAFETY: the type is the one declared in the table, which the headers
                        // of all versions accepted share; the library is never unloaded.
                        let symbol = unsafe { library.get(stringify!($name)) };
                        *symbol.map_err(|_| PetscError::Symbol(stringify!($name)))?
                    },)*
                })
            }
        }
    };
}

handles! {
    MPI_Comm = ompi_communicator_t;
    PetscObject = _p_PetscObject;
    PetscOptions = _n_PetscOptions;
    Vec = _p_Vec;
    VecScatter = _p_PetscSF;
    Mat = _p_Mat;
    MatNullSpace = _p_MatNullSpace;
    IS = _p_IS;
    KSP = _p_KSP;
    PC = _p_PC;
}

pub(crate) type PetscErrorCode = c_int;
pub(crate) type PetscInt = c_int;
pub(crate) type PetscScalar = f64;
pub(crate) type PetscReal = f64;
pub(crate) type PetscBool = c_uint;
pub(crate) type PetscErrorType = c_uint;
pub(crate) type PetscDataType = c_uint;
pub(crate) type PetscCopyMode = c_uint;
pub(crate) type InsertMode = c_uint;
pub(crate) type ScatterMode = c_uint;
pub(crate) type MatAssemblyType = c_uint;
pub(crate) type MatOption = c_int;
pub(crate) type MatInfoType = c_uint;
pub(crate) type MatType = *const c_char;
pub(crate) type KSPType = *const c_char;
pub(crate) type PCType = *const c_char;
pub(crate) type KSPNormType = c_int;
pub(crate) type KSPConvergedReason = c_int;
pub(crate) type PCFailedReason = c_int;
pub(crate) type PetscErrorHandler = Option<
    unsafe extern "C" fn(
        MPI_Comm,
        c_int,
        *const c_char,
        *const c_char,
        PetscErrorCode,
        PetscErrorType,
        *const c_char,
        *mut c_void,
    ) -> PetscErrorCode,
>;

/// Counts and sizes of a matrix.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct MatInfo {
    pub(crate) block_size: f64,
    pub(crate) nz_allocated: f64,
    pub(crate) nz_used: f64,
    pub(crate) nz_unneeded: f64,
    pub(crate) memory: f64,
    pub(crate) assemblies: f64,
    pub(crate) mallocs: f64,
    pub(crate) fill_ratio_given: f64,
    pub(crate) fill_ratio_needed: f64,
    pub(crate) factor_mallocs: f64,
}

/// Lets PETSc find a size; a macro in the headers.
pub(crate) const PETSC_DETERMINE: PetscInt = -1;

constants! {
    PETSC_FALSE: PetscBool = 0;
    PETSC_TRUE: PetscBool = 1;
    PETSC_ERROR_INITIAL: PetscErrorType = 0;
    PETSC_DOUBLE: PetscDataType = 1;
    PETSC_INT: PetscDataType = 16;
    PETSC_COPY_VALUES: PetscCopyMode = 0;
    INSERT_VALUES: InsertMode = 1;
    SCATTER_FORWARD: ScatterMode = 0;
    MAT_FINAL_ASSEMBLY: MatAssemblyType = 0;
    MAT_SYMMETRIC: MatOption = 1;
    MAT_SYMMETRY_ETERNAL: MatOption = 10;
    MAT_SPD: MatOption = 15;
    MAT_SPD_ETERNAL: MatOption = 26;
    MAT_GLOBAL_SUM: MatInfoType = 3;
    KSP_NORM_UNPRECONDITIONED: KSPNormType = 2;
    KSP_DIVERGED_ITS: KSPConvergedReason = -3;
    KSP_DIVERGED_DTOL: KSPConvergedReason = -4;
    KSP_DIVERGED_BREAKDOWN: KSPConvergedReason = -5;
    KSP_DIVERGED_BREAKDOWN_BICG: KSPConvergedReason = -6;
    KSP_DIVERGED_NONSYMMETRIC: KSPConvergedReason = -7;
    KSP_DIVERGED_INDEFINITE_PC: KSPConvergedReason = -8;
    KSP_DIVERGED_NANORINF: KSPConvergedReason = -9;
    KSP_DIVERGED_INDEFINITE_MAT: KSPConvergedReason = -10;
    KSP_DIVERGED_PC_FAILED: KSPConvergedReason = -11;
    PC_NOERROR: PCFailedReason = 0;
    PC_FACTOR_STRUCT_ZEROPIVOT: PCFailedReason = 1;
    PC_FACTOR_NUMERIC_ZEROPIVOT: PCFailedReason = 2;
    PC_FACTOR_OUTMEMORY: PCFailedReason = 3;
}

functions! {
    PetscInitialize: fn(*mut c_int, *mut *mut *mut c_char, *const c_char, *const c_char)
        -> PetscErrorCode;
    PetscFinalize: fn() -> PetscErrorCode;
    PetscGetVersionNumber: fn(*mut PetscInt, *mut PetscInt, *mut PetscInt, *mut PetscInt)
        -> PetscErrorCode;
    PetscPushErrorHandler: fn(PetscErrorHandler, *mut c_void) -> PetscErrorCode;
    PetscErrorMessage: fn(c_int, *mut *const c_char, *mut *mut c_char) -> PetscErrorCode;
    PetscDataTypeGetSize: fn(PetscDataType, *mut usize) -> PetscErrorCode;
    PetscDataTypeFromString: fn(*const c_char, *mut PetscDataType, *mut PetscBool)
        -> PetscErrorCode;
    PetscHasExternalPackage: fn(*const c_char, *mut PetscBool) -> PetscErrorCode;
    PetscObjectCompose: fn(PetscObject, *const c_char, PetscObject) -> PetscErrorCode;
    PetscOptionsCreate: fn(*mut PetscOptions) -> PetscErrorCode;
    PetscOptionsDestroy: fn(*mut PetscOptions) -> PetscErrorCode;
    PetscOptionsPush: fn(PetscOptions) -> PetscErrorCode;
    PetscOptionsPop: fn() -> PetscErrorCode;
    PetscOptionsSetValue: fn(PetscOptions, *const c_char, *const c_char) -> PetscErrorCode;
    PetscOptionsInsertString: fn(PetscOptions, *const c_char) -> PetscErrorCode;
    PetscOptionsLeftGet: fn(PetscOptions, *mut PetscInt, *mut *mut *mut c_char,
        *mut *mut *mut c_char) -> PetscErrorCode;
    PetscOptionsLeftRestore: fn(PetscOptions, *mut PetscInt, *mut *mut *mut c_char,
        *mut *mut *mut c_char) -> PetscErrorCode;
    VecCreateMPI: fn(MPI_Comm, PetscInt, PetscInt, *mut Vec) -> PetscErrorCode;
    VecSetBlockSize: fn(Vec, PetscInt) -> PetscErrorCode;
    VecGetArray: fn(Vec, *mut *mut PetscScalar) -> PetscErrorCode;
    VecRestoreArray: fn(Vec, *mut *mut PetscScalar) -> PetscErrorCode;
    VecGetArrayRead: fn(Vec, *mut *const PetscScalar) -> PetscErrorCode;
    VecRestoreArrayRead: fn(Vec, *mut *const PetscScalar) -> PetscErrorCode;
    VecGetLocalSize: fn(Vec, *mut PetscInt) -> PetscErrorCode;
    VecDestroy: fn(*mut Vec) -> PetscErrorCode;
    VecScatterCreateToAll: fn(Vec, *mut VecScatter, *mut Vec) -> PetscErrorCode;
    VecScatterBegin: fn(VecScatter, Vec, Vec, InsertMode, ScatterMode) -> PetscErrorCode;
    VecScatterEnd: fn(VecScatter, Vec, Vec, InsertMode, ScatterMode) -> PetscErrorCode;
    VecScatterDestroy: fn(*mut VecScatter) -> PetscErrorCode;
    ISCreateGeneral: fn(MPI_Comm, PetscInt, *const PetscInt, PetscCopyMode, *mut IS)
        -> PetscErrorCode;
    ISSetBlockSize: fn(IS, PetscInt) -> PetscErrorCode;
    ISDestroy: fn(*mut IS) -> PetscErrorCode;
    MatCreate: fn(MPI_Comm, *mut Mat) -> PetscErrorCode;
    MatSetSizes: fn(Mat, PetscInt, PetscInt, PetscInt, PetscInt) -> PetscErrorCode;
    MatGetSize: fn(Mat, *mut PetscInt, *mut PetscInt) -> PetscErrorCode;
    MatSetType: fn(Mat, MatType) -> PetscErrorCode;
    MatSetBlockSize: fn(Mat, PetscInt) -> PetscErrorCode;
    MatSeqAIJSetPreallocationCSR: fn(Mat, *const PetscInt, *const PetscInt, *const PetscScalar)
        -> PetscErrorCode;
    MatMPIAIJSetPreallocationCSR: fn(Mat, *const PetscInt, *const PetscInt, *const PetscScalar)
        -> PetscErrorCode;
    MatUpdateMPIAIJWithArray: fn(Mat, *const PetscScalar) -> PetscErrorCode;
    MatSeqAIJGetArray: fn(Mat, *mut *mut PetscScalar) -> PetscErrorCode;
    MatSeqAIJRestoreArray: fn(Mat, *mut *mut PetscScalar) -> PetscErrorCode;
    MatAssemblyBegin: fn(Mat, MatAssemblyType) -> PetscErrorCode;
    MatAssemblyEnd: fn(Mat, MatAssemblyType) -> PetscErrorCode;
    MatSetOption: fn(Mat, MatOption, PetscBool) -> PetscErrorCode;
    MatGetInfo: fn(Mat, MatInfoType, *mut MatInfo) -> PetscErrorCode;
    MatDestroy: fn(*mut Mat) -> PetscErrorCode;
    MatNullSpaceCreateRigidBody: fn(Vec, *mut MatNullSpace) -> PetscErrorCode;
    MatSetNearNullSpace: fn(Mat, MatNullSpace) -> PetscErrorCode;
    MatNullSpaceDestroy: fn(*mut MatNullSpace) -> PetscErrorCode;
    KSPCreate: fn(MPI_Comm, *mut KSP) -> PetscErrorCode;
    KSPSetOperators: fn(KSP, Mat, Mat) -> PetscErrorCode;
    KSPSetFromOptions: fn(KSP) -> PetscErrorCode;
    KSPGetType: fn(KSP, *mut KSPType) -> PetscErrorCode;
    KSPSetNormType: fn(KSP, KSPNormType) -> PetscErrorCode;
    KSPGetTolerances: fn(KSP, *mut PetscReal, *mut PetscReal, *mut PetscReal, *mut PetscInt)
        -> PetscErrorCode;
    KSPSetTolerances: fn(KSP, PetscReal, PetscReal, PetscReal, PetscInt) -> PetscErrorCode;
    KSPSetUp: fn(KSP) -> PetscErrorCode;
    KSPSetUpOnBlocks: fn(KSP) -> PetscErrorCode;
    KSPSolve: fn(KSP, Vec, Vec) -> PetscErrorCode;
    KSPGetIterationNumber: fn(KSP, *mut PetscInt) -> PetscErrorCode;
    KSPGetConvergedReason: fn(KSP, *mut KSPConvergedReason) -> PetscErrorCode;
    KSPGetPC: fn(KSP, *mut PC) -> PetscErrorCode;
    KSPDestroy: fn(*mut KSP) -> PetscErrorCode;
    PCSetType: fn(PC, PCType) -> PetscErrorCode;
    PCGetType: fn(PC, *mut PCType) -> PetscErrorCode;
    PCGetFailedReason: fn(PC, *mut PCFailedReason) -> PetscErrorCode;
    PCFactorGetMatrix: fn(PC, *mut Mat) -> PetscErrorCode;
    PCFieldSplitSetIS: fn(PC, *const c_char, IS) -> PetscErrorCode;
    PCGAMGSetReuseInterpolation: fn(PC, PetscBool) -> PetscErrorCode;
    MPI_Abort: fn(MPI_Comm, c_int) -> c_int;
    MPI_Comm_rank: fn(MPI_Comm, *mut c_int) -> c_int;
    MPI_Comm_size: fn(MPI_Comm, *mut c_int) -> c_int;
    MPI_Comm_split: fn(MPI_Comm, c_int, c_int, *mut MPI_Comm) -> c_int;
}
