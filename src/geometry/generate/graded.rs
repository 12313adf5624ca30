//! Tensor-product grading: each axis is a list of segments with uniform or geometric spacing.

use super::{GenerateError, check_count, divide, tensor_cells};
use crate::geometry::{Cloud, Domain, Vector};

/// Part of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Length in metres.
    pub length: f64,
    /// Spacing at the start in metres.
    pub first: f64,
    /// Spacing at the end in metres; equal to `first` for a uniform segment.
    pub last: f64,
}

impl Segment {
    /// Number of cells along the segment of axis `axis`.
    ///
    /// # Errors
    /// As [`graded`].
    pub fn cells(&self, axis: usize) -> Result<usize, GenerateError> {
        let growth = self.last / self.first;
        if (growth - 1.0).abs() < 1e-12 {
            return divide(self.length, self.first, axis);
        }
        // A geometric series from `first` to `last` sums to (last·q − first)/(q − 1).
        let mean = (self.last - self.first) / growth.ln();
        let count = (self.length / mean).round().max(2.0);
        check_count(count)?;
        Ok(count as usize)
    }

    /// Cell widths, in metres. A geometric segment takes the whole number of cells nearest to what
    /// its two spacings imply and keeps their ratio, so both shift slightly to fill the length.
    fn widths(&self, axis: usize) -> Result<Vec<f64>, GenerateError> {
        let (growth, cells) = (self.last / self.first, self.cells(axis)?);
        if (growth - 1.0).abs() < 1e-12 {
            return Ok(vec![self.length / cells as f64; cells]);
        }
        let ratio = growth.powf(1.0 / (cells as f64 - 1.0));
        let raw: Vec<f64> = (0..cells as i32)
            .map(|k| self.first * ratio.powi(k))
            .collect();
        let scale = self.length / raw.iter().sum::<f64>();
        Ok(raw.into_iter().map(|width| width * scale).collect())
    }
}

/// Tensor-graded cloud with one list of segments per axis, starting at `origin` (metres).
///
/// # Errors
/// [`GenerateError::NotDivisible`] for a uniform segment whose spacing does not divide it;
/// [`GenerateError::TooMany`].
pub fn graded<const D: usize>(
    origin: Vector<D>,
    axes: &[Vec<Segment>; D],
) -> Result<Cloud<D>, GenerateError> {
    let mut edges: [Vec<f64>; D] = std::array::from_fn(|axis| vec![origin[axis]]);
    for axis in 0..D {
        let mut start = origin[axis];
        for segment in &axes[axis] {
            let mut x = start;
            for width in segment.widths(axis)? {
                x += width;
                edges[axis].push(x);
            }
            start += segment.length;
            // The sum of the widths ends here up to rounding; the plane must be exact.
            if let Some(end) = edges[axis].last_mut() {
                *end = start;
            }
        }
    }
    check_count(edges.iter().map(|e| (e.len() - 1) as f64).product())?;
    let (position, cell) = tensor_cells(&edges);
    let upper = Vector::from_fn(|axis, _| edges[axis].last().copied().unwrap_or(origin[axis]));
    let first = cell[0];
    Ok(Cloud {
        domain: Domain {
            lower: origin,
            upper,
            planes: true,
        },
        volume: cell.iter().map(Vector::product).collect(),
        filled: true,
        outline: None,
        irregular: cell
            .iter()
            .any(|width| (width - first).amax() > 1e-9 * first.amax()),
        position,
        cell,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_geometric_segment_fills_its_length_and_keeps_the_ratio() {
        let segment = Segment {
            length: 15.0,
            first: 0.025,
            last: 0.1,
        };
        let widths = segment.widths(0).unwrap();
        assert!((widths.iter().sum::<f64>() - 15.0).abs() < 1e-12);
        let ratio = widths[widths.len() - 1] / widths[0];
        assert!((ratio - 4.0).abs() < 1e-9);
        assert!((widths[0] - 0.025).abs() < 0.001);
    }

    #[test]
    fn a_uniform_axis_is_regular_and_a_graded_one_is_not() {
        let uniform = vec![Segment {
            length: 1.0,
            first: 0.25,
            last: 0.25,
        }];
        let growing = vec![Segment {
            length: 1.0,
            first: 0.05,
            last: 0.2,
        }];
        let plain = graded(Vector::<2>::zeros(), &[uniform.clone(), uniform.clone()]).unwrap();
        assert!(!plain.irregular && plain.len() == 16);
        let cloud = graded(Vector::<2>::zeros(), &[growing, uniform]).unwrap();
        assert!(cloud.irregular);
        assert!((cloud.volume.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_spacing_that_does_not_divide_is_refused_with_one_that_does() {
        let axis = vec![Segment {
            length: 1.0,
            first: 0.3,
            last: 0.3,
        }];
        let error = graded(Vector::<2>::zeros(), &[axis.clone(), axis]).unwrap_err();
        assert!(error.to_string().contains("such as 0.333"), "{error}");
    }
}
