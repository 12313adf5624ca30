//! The table of preconditioners, and which of them a method can take.

use super::{Preconditioner, amg, block_jacobi, ic0, ilu0, jacobi, none, schur, single, stale};
use crate::SpecError;
use crate::problem::Symmetry;
use crate::registry::Options;

const ALL: &[Symmetry] = &[
    Symmetry::PositiveDefinite,
    Symmetry::QuasiDefinite,
    Symmetry::Indefinite,
    Symmetry::General,
];
const SYMMETRIC: &[Symmetry] = &[
    Symmetry::PositiveDefinite,
    Symmetry::QuasiDefinite,
    Symmetry::Indefinite,
];
const FACTORED: &[Symmetry] = &[Symmetry::PositiveDefinite, Symmetry::QuasiDefinite];
const DEFINITE: &[Symmetry] = &[Symmetry::PositiveDefinite];
const COUPLED: &[Symmetry] = &[Symmetry::QuasiDefinite];

/// Every preconditioner that can be chosen by name.
pub const PRECONDITIONERS: &[PreconditionerInfo] = &[
    PreconditionerInfo {
        name: "none",
        meaning: "nothing",
        symmetries: ALL,
        definite: ALL,
        build: none::build,
    },
    PreconditionerInfo {
        name: "jacobi",
        meaning: "diagonal",
        symmetries: ALL,
        definite: SYMMETRIC,
        build: jacobi::build,
    },
    PreconditionerInfo {
        name: "block-jacobi",
        meaning: "diagonal blocks of the points; absolute values of their eigenvalues if symmetric",
        symmetries: ALL,
        definite: SYMMETRIC,
        build: block_jacobi::build,
    },
    PreconditionerInfo {
        name: "ic0",
        meaning: "Cholesky factor without fill, diagonal raised until it exists",
        symmetries: DEFINITE,
        definite: DEFINITE,
        build: ic0::build,
    },
    PreconditionerInfo {
        name: "ilu0",
        meaning: "LU factors without fill, diagonal raised until they exist",
        symmetries: ALL,
        definite: &[],
        build: ilu0::build,
    },
    PreconditionerInfo {
        name: "f32",
        meaning: "LLT or LDLT factor in single precision: half the memory of a direct solver; in double where it serves badly",
        symmetries: FACTORED,
        definite: DEFINITE,
        build: single::build,
    },
    PreconditionerInfo {
        name: "stale",
        meaning: "LLT or LDLT factor of an earlier matrix, until it serves too badly",
        symmetries: FACTORED,
        definite: DEFINITE,
        build: stale::build,
    },
    PreconditionerInfo {
        name: "amg",
        meaning: "multigrid by smoothed aggregation, kept while a matrix changes little",
        symmetries: DEFINITE,
        definite: DEFINITE,
        build: amg::build,
    },
    PreconditionerInfo {
        name: "schur",
        meaning: "multigrid on both fields, Schur complement from the point blocks of the stiffness",
        symmetries: COUPLED,
        definite: &[],
        build: schur::build_self,
    },
    PreconditionerInfo {
        name: "fixed-stress",
        meaning: "multigrid on both fields, Schur complement from the storage of a fixed-stress split",
        symmetries: COUPLED,
        definite: &[],
        build: schur::build_fixed_stress,
    },
];

type Build = fn(&Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError>;

/// A preconditioner that can be chosen by name.
#[derive(Debug, Clone, Copy)]
pub struct PreconditionerInfo {
    /// Value of the option `preconditioner`.
    pub name: &'static str,
    /// One line on what it is.
    pub meaning: &'static str,
    /// Kinds of systems it takes.
    pub symmetries: &'static [Symmetry],
    /// Kinds of systems for which it is symmetric positive definite.
    pub definite: &'static [Symmetry],
    build: Build,
}

/// What a Krylov method asks of its preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Demand {
    /// Positive definite, as its matrix must be.
    DefiniteMatrix,
    /// Positive definite, whatever the signs of its symmetric matrix.
    Definite,
    /// Nothing.
    Any,
}

impl Demand {
    const fn takes(self, entry: &PreconditionerInfo) -> bool {
        match self {
            Self::Any => true,
            Self::Definite => !entry.definite.is_empty(),
            Self::DefiniteMatrix => {
                let mut index = 0;
                while index < entry.definite.len() {
                    if matches!(entry.definite[index], Symmetry::PositiveDefinite) {
                        return true;
                    }
                    index += 1;
                }
                false
            }
        }
    }
}

/// Number of preconditioners that meet a demand.
pub(crate) const fn count(demand: Demand) -> usize {
    let (mut index, mut found) = (0, 0);
    while index < PRECONDITIONERS.len() {
        if demand.takes(&PRECONDITIONERS[index]) {
            found += 1;
        }
        index += 1;
    }
    found
}

/// Their names; `N` is what [`count`] gives.
pub(crate) const fn words<const N: usize>(demand: Demand) -> [&'static str; N] {
    let mut words = [""; N];
    let (mut index, mut found) = (0, 0);
    while index < PRECONDITIONERS.len() && found < N {
        if demand.takes(&PRECONDITIONERS[index]) {
            words[found] = PRECONDITIONERS[index].name;
            found += 1;
        }
        index += 1;
    }
    words
}

/// The entry of the option `preconditioner`.
pub(crate) fn find(options: &Options<'_>) -> Result<&'static PreconditionerInfo, SpecError> {
    let name = options.choice("preconditioner");
    let found = PRECONDITIONERS.iter().find(|entry| entry.name == name);
    found.ok_or_else(|| options.invalid("preconditioner"))
}

/// Builds the preconditioner of an entry from the options of its backend.
pub(crate) fn build(
    entry: &PreconditionerInfo,
    options: &Options<'_>,
) -> Result<Box<dyn Preconditioner>, SpecError> {
    (entry.build)(options)
}
