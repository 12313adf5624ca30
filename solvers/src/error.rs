//! Everything that can go wrong, with the values that matter and the remedy.

use crate::problem::Symmetry;

/// Failure of an analysis, a factorisation or a solve.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The matrix has a different number of rows and columns.
    #[error("the matrix has {rows} rows and {columns} columns; a square one is needed")]
    NotSquare {
        /// Number of rows found.
        rows: usize,
        /// Number of columns found.
        columns: usize,
    },
    /// A slice has the wrong length.
    #[error("{what} has {found} entries, expected {expected}")]
    Length {
        /// Name of the slice.
        what: &'static str,
        /// Length found.
        found: usize,
        /// Length needed.
        expected: usize,
    },
    /// The description of the problem contradicts itself.
    #[error("the linear problem is described wrongly: {reason}")]
    InvalidProblem {
        /// What does not fit.
        reason: String,
    },
    /// The backend cannot solve this kind of system.
    #[error("solver `{solver}` refuses a {symmetry} system: {advice}")]
    Refused {
        /// Name of the backend.
        solver: &'static str,
        /// Symmetry of the system.
        symmetry: Symmetry,
        /// What to choose instead.
        advice: String,
    },
    /// A stage was called before the one it depends on succeeded.
    #[error("solver `{solver}`: call `{missing}` successfully first")]
    NotAnalysed {
        /// Name of the backend.
        solver: &'static str,
        /// The stage that is missing, `analyse` or `refresh`.
        missing: &'static str,
    },
    /// The matrix does not have the pattern that was analysed.
    #[error(
        "the sparsity pattern changed since `analyse` ({expected} stored entries then, {found} \
         now); analyse the new pattern"
    )]
    PatternChanged {
        /// Stored entries of the analysed pattern.
        expected: usize,
        /// Stored entries of the matrix given.
        found: usize,
    },
    /// NaN or infinity in the input.
    #[error("{what} holds {value} in row {row}; look for a division by zero where it is built")]
    NotFinite {
        /// The matrix, the right-hand side or the initial guess.
        what: &'static str,
        /// First row affected.
        row: usize,
        /// The value found.
        value: f64,
    },
    /// A row of zeros.
    #[error(
        "row {row} holds only zeros, so the matrix is singular; the unknown has no equation: \
         prescribe it or give its point a bond or a storage term"
    )]
    Singular {
        /// The row.
        row: usize,
    },
    /// A pivot or diagonal entry is not positive.
    #[error(
        "the matrix is not positive definite at row {row} (its diagonal entry is {diagonal:e}); \
         prescribe enough values to exclude rigid motion or a free constant, and check the sign \
         of every stiffness"
    )]
    NotPositiveDefinite {
        /// Row where the factorisation stopped.
        row: usize,
        /// Diagonal entry of the matrix in this row.
        diagonal: f64,
    },
    /// A pivot of an L D Lᵀ factorisation is zero or not finite.
    #[error(
        "the factorisation has a zero or infinite pivot at row {row} (its diagonal entry is \
         {diagonal:e}), so the matrix is singular or not quasi-definite; prescribe enough values, \
         and give every unknown of the negative block a storage or coupling term"
    )]
    ZeroPivot {
        /// Row where the factorisation stopped.
        row: usize,
        /// Diagonal entry of the matrix in this row.
        diagonal: f64,
    },
    /// A direct solution that stays inaccurate after refinement.
    #[error(
        "the direct solution has a relative residual of {residual:e} after {refinements} \
         refinements (allowed {bar:e}); {advice}"
    )]
    Inaccurate {
        /// True relative residual.
        residual: f64,
        /// Largest residual allowed.
        bar: f64,
        /// Refinement steps done.
        refinements: usize,
        /// Remedy.
        advice: &'static str,
    },
    /// An iteration that ran out of steps.
    #[error(
        "no convergence in {iterations} iterations: relative residual {residual:e}, wanted \
         {tolerance:e}; {advice}"
    )]
    NotConverged {
        /// Iterations done, over all restarts.
        iterations: usize,
        /// True relative residual reached.
        residual: f64,
        /// Relative residual wanted.
        tolerance: f64,
        /// Remedy.
        advice: String,
    },
    /// An iteration that no longer comes nearer to the solution.
    #[error(
        "`{method}` stagnates after {iterations} iterations: relative residual {residual:e}, \
         wanted {tolerance:e}; {advice}"
    )]
    Stagnated {
        /// Name of the backend.
        method: &'static str,
        /// Iterations done, over all restarts.
        iterations: usize,
        /// True relative residual reached.
        residual: f64,
        /// Relative residual wanted.
        tolerance: f64,
        /// Remedy.
        advice: String,
    },
    /// An iteration that cannot be continued, because it would divide by zero or because the matrix
    /// or the preconditioner lacks a property it needs.
    #[error("`{method}` broke down in iteration {iterations}: {cause}; {advice}")]
    Breakdown {
        /// Name of the backend.
        method: &'static str,
        /// Iterations done, over all restarts.
        iterations: usize,
        /// What was met.
        cause: &'static str,
        /// Remedy.
        advice: String,
    },
    /// An incomplete factorisation without usable pivot.
    #[error(
        "preconditioner `{preconditioner}` finds no usable pivot at row {row} (its diagonal entry is \
         {diagonal:e}), even with {shift} added to the diagonal of the scaled matrix; choose \
         another preconditioner, and check that every unknown has an equation of its own"
    )]
    IncompletePivot {
        /// Name of the preconditioner.
        preconditioner: &'static str,
        /// Row where the factorisation stopped.
        row: usize,
        /// Diagonal entry of the matrix in this row.
        diagonal: f64,
        /// Largest shift tried, relative to the diagonal.
        shift: f64,
    },
    /// The factor does not fit into memory or into 32-bit indices.
    #[error("the factor of {unknowns} unknowns is too large ({reason}); use `faer-cg`")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
        /// Which limit was met.
        reason: String,
    },
    /// The library behind the backend is missing or cannot be used.
    #[error("solver `{solver}` cannot be used here: {reason}")]
    Unavailable {
        /// Name of the backend.
        solver: &'static str,
        /// What is missing and how to get it.
        reason: String,
    },
    /// The library behind the backend reports an error.
    #[error("solver `{solver}`: {message}; check its options `{options}`")]
    External {
        /// Name of the backend.
        solver: &'static str,
        /// What the library says.
        message: String,
        /// Options in use.
        options: String,
    },
    /// Flags that the methods chosen do not read.
    #[error(
        "solver `{solver}`: nothing reads {flags}; check the spelling, and whether the methods \
         chosen have such an option"
    )]
    UnusedFlags {
        /// Name of the backend.
        solver: &'static str,
        /// The flags, as typed.
        flags: String,
    },
    /// The preconditioner or factorisation of an external library failed.
    #[error("solver `{solver}`: {stage} failed: {reason}; {advice}")]
    Failed {
        /// Name of the backend.
        solver: &'static str,
        /// What was being done.
        stage: &'static str,
        /// Why it failed.
        reason: String,
        /// Remedy.
        advice: &'static str,
    },
    /// Whoever started the solve asked it to stop, see [`crate::Interrupt`].
    #[error("the solve was interrupted")]
    Interrupted,
    /// Another process of the team met an error.
    #[error("process {process} met an error, so this one stops too; see its message")]
    OtherProcess {
        /// Number of that process.
        process: usize,
    },
}

/// A solver specification that cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SpecError {
    /// No backend of this name.
    #[error("unknown solver `{name}`{suggestion}; valid names: {valid}")]
    UnknownSolver {
        /// Name as typed.
        name: String,
        /// "did you mean", or empty.
        suggestion: String,
        /// All valid names.
        valid: String,
    },
    /// The backend has no such option.
    #[error("solver `{solver}` has no option `{option}`{suggestion}; valid options: {valid}")]
    UnknownOption {
        /// Name of the backend.
        solver: &'static str,
        /// Option as typed.
        option: String,
        /// "did you mean", or empty.
        suggestion: String,
        /// All valid options.
        valid: String,
    },
    /// The value of an option is not of its kind.
    #[error("solver `{solver}`: `{value}` is no value of `{option}`{suggestion}; give {valid}")]
    InvalidValue {
        /// Name of the backend.
        solver: &'static str,
        /// Option concerned.
        option: &'static str,
        /// Value as typed.
        value: String,
        /// "did you mean", or empty.
        suggestion: String,
        /// What is accepted.
        valid: String,
    },
    /// An option without `=`, or given twice.
    #[error("`{text}` in the solver specification: {reason}; write NAME:key=value,key=value")]
    Malformed {
        /// The piece of text.
        text: String,
        /// What is wrong with it.
        reason: &'static str,
    },
}
