//! Ways to make a cloud: lattice, graded lattice, 2:1 blocks, points from a file.

mod blocks;
mod graded;
mod lattice;

pub use blocks::{Refinement, blocks};
pub use graded::{Segment, graded};
pub use lattice::{jitter, lattice};

use super::Vector;

/// Why a cloud could not be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A spacing that does not divide the domain.
    #[error(
        "spacing {spacing} m does not divide the length {length} m along axis {axis} \
         ({cells:.4} cells); choose a spacing that does, such as {suggestion} m"
    )]
    NotDivisible {
        /// Spacing in metres.
        spacing: f64,
        /// Length in metres.
        length: f64,
        /// Axis number.
        axis: usize,
        /// Their ratio.
        cells: f64,
        /// The nearest spacing that divides the length.
        suggestion: f64,
    },
    /// A refinement whose region no cell touches.
    #[error("geometry.refine #{number} touches no cell; move its region inside or enlarge it")]
    EmptyRefinement {
        /// Which, from 1.
        number: usize,
    },
    /// The number of points overflows 32-bit indices.
    #[error("{count:.3e} points are more than 32-bit indices can number; use a coarser cloud")]
    TooMany {
        /// Points asked for.
        count: f64,
    },
}

/// Cells of the given spacing along a length.
///
/// # Errors
/// [`GenerateError::NotDivisible`] unless the ratio is whole to 1e-6.
pub fn divide(length: f64, spacing: f64, axis: usize) -> Result<usize, GenerateError> {
    let cells = length / spacing;
    let whole = cells.round().max(1.0);
    if (cells - whole).abs() > 1e-6 * whole {
        let suggestion = length / whole;
        return Err(GenerateError::NotDivisible {
            spacing,
            length,
            axis,
            cells,
            suggestion,
        });
    }
    check_count(whole)?;
    Ok(whole as usize)
}

/// Refuses more points than 32-bit indices can number.
///
/// # Errors
/// [`GenerateError::TooMany`].
pub fn check_count(count: f64) -> Result<(), GenerateError> {
    if count < f64::from(u32::MAX) {
        Ok(())
    } else {
        Err(GenerateError::TooMany { count })
    }
}

/// Centres and widths of all cells of a tensor grid, x fastest; `edges` are the cell boundaries per
/// axis.
fn tensor_cells<const D: usize>(edges: &[Vec<f64>; D]) -> (Vec<Vector<D>>, Vec<Vector<D>>) {
    let cells: [usize; D] = std::array::from_fn(|axis| edges[axis].len() - 1);
    let total: usize = cells.iter().product();
    let (mut centre, mut width) = (Vec::with_capacity(total), Vec::with_capacity(total));
    for mut index in 0..total {
        let (mut x, mut w) = (Vector::zeros(), Vector::zeros());
        for axis in 0..D {
            let k = index % cells[axis];
            index /= cells[axis];
            let (low, high) = (edges[axis][k], edges[axis][k + 1]);
            x[axis] = 0.5 * (low + high);
            w[axis] = high - low;
        }
        centre.push(x);
        width.push(w);
    }
    (centre, width)
}
