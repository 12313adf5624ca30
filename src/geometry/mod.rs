//! Where the points are and who sees whom: clouds, boundary planes and their mirror images, families.
//!
//! Everything here is generic over the dimension `D` (2 or 3) and knows nothing of physics.

mod border;
mod cell_list;
mod cloud;
mod crack;
mod dual;
mod families;
pub mod generate;
mod horizon;
mod images;
mod influence;
mod lattice;
mod locator;
mod near;
mod sampler;
mod shape;
mod share;
mod side;
mod stencil;
mod transpose;
mod voids;

pub use border::border;
pub(crate) use cell_list::CellList;
pub(crate) use cloud::edge;
pub use cloud::{Cloud, Domain, Outline};
pub use crack::{Crack, Cutter, OnCrack};
pub use dual::{CellKind, DualCells};
pub use families::{Families, Severed};
pub use generate::GenerateError;
pub use horizon::{Horizon, horizons, horizons_in_parts};
pub use images::{Image, ImageTable};
pub use influence::Influence;
pub use lattice::Lattice;
pub use locator::{Locator, Place, neighbour_distances};
pub use sampler::{SampledBond, Sampler};
pub use shape::Shape;
pub use share::Subdomain;
pub use side::Side;
pub use stencil::{Stencil, Stencils, Term, sources};
pub use voids::Voids;

/// A position or vector in `D` dimensions, in metres where it is a position.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;

/// A `D × D` matrix.
pub type Matrix<const D: usize> = nalgebra::SMatrix<f64, D, D>;

/// Why a neighbourhood could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A family does not span the space, so its shape tensor (Eq. 56) has no inverse.
    #[error(
        "point {point} at {position:?}: its {found} neighbours within {horizon:.3e} m do not span \
         the space (singular shape tensor); enlarge the horizon"
    )]
    SingularShape {
        /// Index of the point.
        point: usize,
        /// Its position in metres.
        position: Vec<f64>,
        /// Number of neighbours found.
        found: usize,
        /// Horizon in metres.
        horizon: f64,
    },
    /// The cloud has fewer points than the requested number of neighbours.
    #[error("the cloud has {points} points, too few for {neighbours} neighbours each")]
    TooFewPoints {
        /// Points in the cloud.
        points: usize,
        /// Requested neighbours.
        neighbours: usize,
    },
    /// The horizon spans the domain so often that the mirror images cannot be numbered.
    #[error(
        "the horizon ({horizon:.3e} m) is more than {limit} times the thickness of the domain \
         ({thickness:.3e} m along axis {axis}); make the domain thicker or the horizon smaller"
    )]
    TooManyImages {
        /// Largest horizon in metres.
        horizon: f64,
        /// Thickness of the domain in metres.
        thickness: f64,
        /// Axis number, 0 for x.
        axis: usize,
        /// Largest supported ratio.
        limit: usize,
    },
    /// A cell so flat that its neighbours are not looked for.
    #[error(
        "the cell of point {point} is so flat that some {count} points lie within its length; use a more \
         even cloud, or flow.operator = \"bond\""
    )]
    FlatCell {
        /// Index of the point.
        point: usize,
        /// About how many points a ball of its length holds.
        count: usize,
    },
    /// More points or bonds than 32-bit indices can number.
    #[error("{what}: {count} is more than 32-bit indices can number; split the problem")]
    TooLarge {
        /// What was counted.
        what: &'static str,
        /// How many.
        count: usize,
    },
}
