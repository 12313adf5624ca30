//! Description of a linear problem: pattern, symmetry and, where known, geometry.

use std::fmt;

use crate::lattice::Lattice;
use crate::partition::Partition;
use crate::{CsrView, SolveError};

/// What is known of the matrix beyond its pattern. The pattern itself is symmetric in all cases
/// but [`Symmetry::General`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Symmetry {
    /// Symmetric positive definite.
    PositiveDefinite,
    /// Symmetric, positive definite in one block of unknowns and negative definite in the other.
    /// Number the unknowns of the negative block last at each point: geometric orderings then
    /// eliminate them after their neighbours of the positive block, which keeps pivots large.
    QuasiDefinite,
    /// Symmetric with eigenvalues of both signs.
    Indefinite,
    /// Not symmetric.
    General,
}

impl fmt::Display for Symmetry {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::PositiveDefinite => "positive definite",
            Self::QuasiDefinite => "quasi-definite",
            Self::Indefinite => "indefinite",
            Self::General => "general",
        })
    }
}

/// Positions of the points that carry the unknowns.
#[derive(Debug, Clone, Copy)]
pub struct Coordinates<'a> {
    /// Number of coordinates per point, 1 to 3.
    pub dimension: usize,
    /// Coordinates, point after point, `dimension · points` of them. Any unit.
    pub values: &'a [f64],
}

impl Coordinates<'_> {
    /// Coordinate of a point along an axis.
    pub(crate) fn along(&self, axis: usize, point: u32) -> f64 {
        self.values[point as usize * self.dimension + axis]
    }
}

/// Fields that a matrix, left free at its boundary, maps to (nearly) zero: what a multilevel method
/// must carry to its coarse levels exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NearNullspace {
    /// One constant for each unknown of a point.
    Constants,
    /// Translations and rotations. The first unknowns of a point are the components of a
    /// displacement, as many as there are coordinates; a further unknown has its own constant.
    RigidModes,
}

/// A linear problem as a solver needs to know it before it sees values.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a> {
    /// Full (both triangles) pattern with sorted columns. Its values are not read.
    pub pattern: CsrView<'a>,
    /// What is known of the values.
    pub symmetry: Symmetry,
    /// Positions of the points, for geometric orderings.
    pub coordinates: Option<Coordinates<'a>>,
    /// Unknowns per point `u`; unknown `i` belongs to point `i / u`.
    pub unknowns_per_point: usize,
    /// What the matrix hardly resists.
    pub near_nullspace: NearNullspace,
    /// Quasi-definite problems: one entry per point, known from the physics, that approximates the
    /// Schur complement B K⁻¹ Bᵀ of the negative block by a diagonal (for poroelasticity the
    /// fixed-stress storage in the scale of the matrix).
    pub schur_diagonal: Option<&'a [f64]>,
    /// Right-hand sides expected per change of the values; more of them pay for a dearer set-up.
    pub solves: usize,
    /// Whether matrices of successive solves differ by little and the caller refreshes only once solves slow down:
    /// what belongs to an earlier matrix then serves this one as a preconditioner.
    pub lags: bool,
    /// Largest over smallest coefficient, as far as it is known; 1 if it is not.
    pub contrast: f64,
    /// Largest ratio at a point of the resistance to changes of volume to that to changes of shape,
    /// (λ + 2μ)/μ of an elastic solid; 1 where it means nothing. Multigrid gets slower with its root.
    pub volume_stiffness: f64,
    /// The lattice that the points are, or why they are none, in words that end a sentence.
    pub lattice: Result<&'a Lattice, &'a str>,
    /// Distributed problems: which rows are stored here. Rows of other processes are empty.
    pub partition: Option<&'a Partition>,
}

impl<'a> Problem<'a> {
    /// A problem with constants as near-nullspace and nothing else known.
    #[must_use]
    pub fn new(pattern: CsrView<'a>, symmetry: Symmetry, unknowns_per_point: usize) -> Self {
        Self {
            pattern,
            symmetry,
            coordinates: None,
            unknowns_per_point,
            near_nullspace: NearNullspace::Constants,
            schur_diagonal: None,
            solves: 1,
            lags: false,
            contrast: 1.0,
            volume_stiffness: 1.0,
            lattice: Err("nothing is known of the order of the points"),
            partition: None,
        }
    }
}

impl Problem<'_> {
    /// Number of unknowns, the rows of the pattern.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.pattern.rows()
    }

    /// Number of points, `unknowns / unknowns_per_point`.
    #[must_use]
    pub fn points(&self) -> usize {
        self.unknowns() / self.unknowns_per_point.max(1)
    }

    /// Mean number of stored entries per row; 0 without rows.
    #[must_use]
    pub fn entries_per_row(&self) -> f64 {
        self.pattern.nnz() as f64 / self.unknowns().max(1) as f64
    }

    /// Checks that pattern, points and coordinates fit together.
    ///
    /// # Errors
    /// [`SolveError::NotSquare`], [`SolveError::InvalidProblem`], [`SolveError::Length`] or
    /// [`SolveError::NotFinite`] (coordinates).
    pub fn validate(&self) -> Result<(), SolveError> {
        let (rows, columns) = (self.pattern.rows(), self.pattern.cols());
        if rows != columns {
            return Err(SolveError::NotSquare { rows, columns });
        }
        if !self.pattern.is_csr() || !self.pattern.indptr().is_proper() {
            return invalid("the pattern must be a whole matrix in row storage (CSR)".into());
        }
        let per_point = self.unknowns_per_point;
        if per_point == 0 || !rows.is_multiple_of(per_point) {
            return invalid(format!(
                "{rows} unknowns cannot be {per_point} for each point"
            ));
        }
        if let Ok(lattice) = self.lattice {
            lattice.validate(self.points(), per_point)?;
        }
        self.coordinates.map_or(Ok(()), |coordinates| {
            self.validate_coordinates(&coordinates)
        })
    }

    fn validate_coordinates(&self, coordinates: &Coordinates<'_>) -> Result<(), SolveError> {
        let Coordinates { dimension, values } = *coordinates;
        if !(1..=3).contains(&dimension) {
            return invalid(format!(
                "coordinates have {dimension} dimensions, expected 1 to 3"
            ));
        }
        let expected = dimension * self.points();
        if values.len() != expected {
            return Err(SolveError::Length {
                what: "coordinates",
                found: values.len(),
                expected,
            });
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(SolveError::NotFinite {
                what: "the coordinates",
                row: index / dimension,
                value: values[index],
            }),
            None => Ok(()),
        }
    }
}

fn invalid(reason: String) -> Result<(), SolveError> {
    Err(SolveError::InvalidProblem { reason })
}
