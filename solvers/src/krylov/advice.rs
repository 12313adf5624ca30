//! Remedies that the errors of the Krylov backends name.

use super::Cause;
use crate::preconditioner::Demand;
use crate::problem::Symmetry;

/// The direct backend for systems of this kind.
fn direct(symmetry: Symmetry) -> &'static str {
    match symmetry {
        Symmetry::PositiveDefinite => "faer-llt",
        Symmetry::QuasiDefinite => "faer-ldlt",
        Symmetry::Indefinite | Symmetry::General => "faer-lu",
    }
}

/// The strongest preconditioner of the table for a method and a kind of system.
fn strongest(demand: Demand, symmetry: Symmetry) -> &'static str {
    match (symmetry, demand) {
        (Symmetry::PositiveDefinite, _) | (Symmetry::QuasiDefinite, Demand::Any) => "stale",
        (_, Demand::Any) => "ilu0",
        _ => "block-jacobi",
    }
}

/// What to do about slow convergence.
pub(super) fn on_slowness(
    first: &str,
    preconditioner: &str,
    demand: Demand,
    symmetry: Symmetry,
) -> String {
    let (better, direct) = (strongest(demand, symmetry), direct(symmetry));
    if preconditioner == better {
        return format!("check that the matrix is as described, or use `{direct}`");
    }
    format!("{first}, use preconditioner={better}, or use `{direct}`")
}

/// What to do about a breakdown.
pub(super) fn on_breakdown(cause: Cause, symmetry: Symmetry) -> String {
    let direct = direct(symmetry);
    match cause {
        Cause::NotDefinite => format!("try `{direct}`, which names the row"),
        Cause::PreconditionerNotDefinite => {
            "use preconditioner=jacobi, or `gmres`, which takes any".into()
        }
        Cause::Singular | Cause::LeastSquares => {
            "prescribe enough values to exclude rigid motion or a free constant".into()
        }
        Cause::Orthogonal => format!("use `gmres`, which cannot break down so, or `{direct}`"),
        Cause::Overflow => format!("balance the units of the unknowns, or use `{direct}`"),
    }
}
