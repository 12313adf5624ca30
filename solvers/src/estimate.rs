//! What a linear system will cost, from its outline alone.
//!
//! The constants are seconds fitted to timings of wide-stencil matrices (flow and plane elasticity at
//! 200² and 400² points) on two cores, of which a factor uses one; they decide between methods whose
//! costs differ by multiples, not between close ones.

use serde::Serialize;

use crate::problem::{Problem, Symmetry};

/// What is known of a linear system before it is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// Symmetry of the matrix.
    pub symmetry: Symmetry,
    /// Number of points.
    pub points: usize,
    /// Unknowns per point.
    pub unknowns_per_point: usize,
    /// Mean number of stored entries per row.
    pub entries_per_row: f64,
    /// Dimension of space.
    pub dimension: usize,
    /// Right-hand sides expected per change of the values.
    pub solves: usize,
    /// As [`Problem::lags`].
    pub lags: bool,
    /// Largest over smallest coefficient.
    pub contrast: f64,
    /// As [`Problem::volume_stiffness`].
    pub volume_stiffness: f64,
    /// Whether the points are a lattice that separates, see [`Lattice::separates`](crate::Lattice::separates).
    pub separates: bool,
    /// Processes that share the matrix.
    pub processes: usize,
}

/// (λ + 2μ)/μ at a Poisson's ratio of 0.25, with which the constants were fitted.
const USUAL_VOLUME_STIFFNESS: f64 = 3.0;

impl Outline {
    /// Outline of a problem.
    #[must_use]
    pub fn of(problem: &Problem<'_>) -> Self {
        let stored = problem.partition.map_or_else(
            || problem.unknowns(),
            |partition| partition.own().len() * problem.unknowns_per_point,
        );
        Self {
            symmetry: problem.symmetry,
            points: problem.points(),
            unknowns_per_point: problem.unknowns_per_point,
            entries_per_row: problem.pattern.nnz() as f64 / stored.max(1) as f64,
            dimension: problem.coordinates.map_or(2, |own| own.dimension),
            solves: problem.solves,
            lags: problem.lags,
            contrast: problem.contrast,
            volume_stiffness: problem.volume_stiffness,
            separates: (problem.lattice).is_ok_and(|lattice| lattice.separates().is_ok()),
            processes: problem.partition.map_or(1, |own| own.team().size()),
        }
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.points * self.unknowns_per_point
    }

    /// Iterations of multigrid over those at [`USUAL_VOLUME_STIFFNESS`].
    ///
    /// Point smoothers do not see fields without change of volume, so iterations grow with the root of
    /// what resists that. Measured with CG and smoothed aggregation to 1e-12, a cantilever of 8 × 1 in
    /// the plane and one of 4 × 1 × 1 in space, iterations a solve (seconds of one core for two solves
    /// with the set-up, and those of a factor):
    ///
    /// | Poisson's ratio | 0.3 | 0.45 | 0.49 | 0.499 | factor |
    /// |---|---|---|---|---|---|
    /// | root of volume stiffness | 1.9 | 3.3 | 7.1 | 22 | |
    /// | 160 × 20 points | 25 (0.12) | 46 (0.19) | 101 (0.37) | 334 (1.0) | 0.07 |
    /// | 320 × 40 points | 31 (0.70) | 44 (0.78) | 88 (1.3) | 365 (4.9) | 0.36 |
    /// | 640 × 80 points | 33 (3.2) | | 107 (7.0) | | 2.8 |
    /// | 32 × 8 × 8 points | 20 (0.17) | | 92 (0.54) | 355 (1.7) | 0.15 |
    /// | 48 × 12 × 12 points | 20 (0.79) | | 88 (2.1) | 344 (6.1) | 0.94 |
    fn slowness(&self) -> f64 {
        (self.volume_stiffness / USUAL_VOLUME_STIFFNESS)
            .max(1.0)
            .sqrt()
    }

    /// Points that a point is coupled to, its own included.
    fn width(&self) -> f64 {
        (self.entries_per_row / self.unknowns_per_point as f64).max(1.0)
    }

    /// Entries and operations of a Cholesky factor with nested dissection of a compact cloud.
    #[must_use]
    pub fn factor(&self) -> FactorEstimate {
        let (points, own) = (self.points as f64, self.unknowns_per_point as f64);
        let width = self.width();
        // Separators are as thick as rows reach: √width points in the plane, ∛width in space.
        let (nonzeros, flops) = match self.dimension {
            3 => {
                let reach = width.cbrt();
                (
                    0.9 * own.powi(2) * reach * points.powf(4.0 / 3.0),
                    3.0 * (own * reach).powi(3) * points.powi(2),
                )
            }
            _ => {
                let levels = (points.log2() - 8.7).max(1.0);
                let reach = width.sqrt();
                // Dissection ends at pieces that rows reach across, which cost as their entries do.
                let dissected = (points.sqrt() - 4.4 * reach).max(0.0);
                (
                    own.powi(2) * width * points * levels,
                    14.5 * (own * reach * dissected).powi(3),
                )
            }
        };
        FactorEstimate { nonzeros, flops }
    }
}

/// Size of a factor as estimated from an outline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FactorEstimate {
    /// Entries.
    pub nonzeros: f64,
    /// Multiplications and additions of one numeric factorisation.
    pub flops: f64,
}

/// Seconds of a method for one change of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cost {
    /// Until the first right-hand side can be solved for.
    pub(crate) setup: f64,
    /// Per right-hand side.
    pub(crate) solve: f64,
}

impl Cost {
    /// Of a factor in double precision.
    pub(crate) fn direct(outline: &Outline) -> Self {
        let FactorEstimate { nonzeros, flops } = outline.factor();
        let unknowns = outline.unknowns() as f64;
        Self {
            setup: flops / 1.2e11 + unknowns * (2e-6 + 3e-8 * outline.entries_per_row),
            solve: 2.1e-9 * nonzeros,
        }
    }

    /// Of conjugate gradients with smoothed aggregation.
    pub(crate) fn multilevel(outline: &Outline) -> Self {
        let unknowns = outline.unknowns() as f64;
        let entries = unknowns * outline.entries_per_row;
        // Jumps of the coefficients cost a few iterations, whatever their height.
        let iterations = if outline.contrast > 1e3 { 20.0 } else { 15.0 };
        let iterations = iterations * outline.slowness();
        Self {
            setup: 1.5e-6 * unknowns + 3e-8 * entries,
            solve: (1e-7 * unknowns + 1e-9 * entries) * iterations,
        }
    }

    /// Of flexible GMRES with multigrid on both fields of a coupled matrix.
    pub(crate) fn blocks(outline: &Outline) -> Self {
        let entries = outline.unknowns() as f64 * outline.entries_per_row;
        // Where pressure leaves along cracks iterations multiply: `natural-fractures` takes 20 a solve, 0.58 and
        // 2.1 s with 3 and 12 million entries, where a factor takes 0.32 and 2.2 s.
        let jumps = if outline.contrast > 1e3 { 7.0 } else { 1.0 };
        Self {
            setup: 1.35e-7 * entries,
            solve: 2.5e-8 * entries * outline.slowness() * jumps,
        }
    }

    /// Of flexible GMRES with a factor in single precision that serves until it slows down.
    ///
    /// Measured in cracks driven by fluid, coupled systems of 5,000 and 8,000 points: a factor serves four to five
    /// solves, each takes three iterations, and an iteration three quarters of the time of a substitution in double
    /// precision. 618 passes of `natural-fractures` took 121 factors and 1,930 iterations.
    pub(crate) fn kept(outline: &Outline) -> Self {
        let factor = Self::direct(outline);
        Self {
            setup: factor.setup / 4.5,
            solve: 3.0 * 0.75 * factor.solve,
        }
    }

    /// For so many right-hand sides.
    pub(crate) fn total(self, solves: usize) -> f64 {
        self.setup + self.solve * solves as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(points: usize, unknowns_per_point: usize, width: f64) -> Outline {
        Outline {
            symmetry: Symmetry::PositiveDefinite,
            points,
            unknowns_per_point,
            entries_per_row: width * unknowns_per_point as f64,
            dimension: 2,
            solves: 1,
            lags: false,
            contrast: 1.0,
            volume_stiffness: 1.0,
            separates: false,
            processes: 1,
        }
    }

    /// Factors measured with nested dissection: entries in millions, seconds of one core.
    #[test]
    fn factors_are_estimated_within_a_factor_of_two_of_measured_ones() {
        let measured = [
            (plane(40_000, 3, 67.7), 150.0, 10.0),
            (plane(40_000, 1, 62.0), 16.4, 0.42),
            (plane(160_000, 1, 62.0), 85.6, 2.7),
            (plane(40_000, 2, 63.0), 65.1, 2.6),
            (plane(160_000, 2, 63.0), 341.0, 22.7),
            (plane(10_000, 2, 68.0), 9.0, 0.18),
            (plane(3_600, 2, 66.0), 2.7, 0.062),
        ];
        for (outline, millions, seconds) in measured {
            let entries = outline.factor().nonzeros / 1e6 / millions;
            let time = Cost::direct(&outline).setup / seconds;
            assert!((0.5..2.0).contains(&entries), "{outline:?}: {entries}");
            assert!((0.5..2.0).contains(&time), "{outline:?}: {time}");
        }
    }
}
