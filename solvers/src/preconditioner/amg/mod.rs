//! Smoothed-aggregation multigrid (Vaněk, Mandel & Brezina 1996, Computing 56, 179).
//!
//! ```text
//! Problem (pattern, near-nullspace) ── analyse ─▶ BlockPattern, Modes
//! values ── build ─▶ Couplings ─▶ Aggregates ─▶ Tentative ─▶ Transfer ─▶ next level …
//! new values ── refresh ─▶ smoother, A P and Pᵀ A P where rows changed
//! residual ── apply ─▶ one symmetric V-cycle
//! ```
//!
//! Points that couple strongly form aggregates. An orthonormal basis of the near-nullspace on each
//! aggregate, smoothed by one damped Jacobi step, spans the coarse space. The smoother is a
//! Chebyshev polynomial of the matrix preconditioned by its point blocks. The coarsest matrix is
//! factorised.
//!
//! Strength is measured against the largest coupling of a point, not against its diagonal: with
//! 60 neighbours no coupling exceeds a few per cent of the diagonal. One threshold then serves flow
//! and elasticity, intact or damaged.
//!
//! A hierarchy keeps aggregates and prolongation while the matrix changes, so that a refresh costs
//! only what the changed rows need, and is rebuilt when solves take clearly longer than at first
//! or when many points change their material.

mod aggregation;
pub(super) mod block;
mod coarsest;
mod cycle;
pub(super) mod dense;
mod hierarchy;
pub(super) mod kernel;
mod modes;
pub(super) mod product;
mod smoother;
mod tentative;
#[cfg(test)]
pub(crate) mod tests;
mod transfer;

use self::block::{BlockPattern, PointBlocks};
use self::hierarchy::{Hierarchy, Shape};
use self::modes::Modes;
use self::smoother::Polynomial;
use super::{Preconditioner, PreconditionerWork};
use crate::matrix::{Rows, diagonal};
use crate::problem::Problem;
use crate::registry::Options;
use crate::{CsrView, SolveError, SpecError};

/// A kept hierarchy is rebuilt when a solve takes this multiple of the iterations it took when new.
const WORN: f64 = 1.5;
/// A solve is interrupted for a rebuild after this multiple of the iterations of a new hierarchy.
const HOPELESS: usize = 3;
/// Iterations that are never too many.
const FEW: usize = 10;
/// Iterations allowed as long as none have been seen.
const UNSEEN: usize = 100;
/// A diagonal entry that changed by more than this factor belongs to another material.
const JUMP: f64 = 10.0;
/// Part of the points that may jump before the hierarchy is rebuilt without waiting for a solve.
const JUMPED: f64 = 0.005;

/// Choices of the user.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AmgOptions {
    /// Part of the largest coupling of a point up to which a coupling does not join points.
    pub(crate) threshold: f64,
    /// Degree of the smoother's polynomial.
    pub(crate) smoother_degree: usize,
    /// Upper over lower end of the part of the spectrum that the smoother damps.
    pub(crate) smoother_ratio: f64,
    /// Unknowns that are solved directly.
    pub(crate) coarsest: usize,
}

impl Default for AmgOptions {
    fn default() -> Self {
        Self {
            threshold: 0.2,
            smoother_degree: 2,
            smoother_ratio: 10.0,
            coarsest: 1000,
        }
    }
}

/// Builds the preconditioner from the options of a backend.
///
/// # Errors
/// [`SpecError`] for a value that is no number.
pub(super) fn build(options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(SmoothedAggregation::new(AmgOptions::of(options)?)))
}

impl AmgOptions {
    /// What the user chose.
    ///
    /// # Errors
    /// [`SpecError`] for a value that is no number.
    pub(crate) fn of(options: &Options<'_>) -> Result<Self, SpecError> {
        Ok(Self {
            threshold: options.number("threshold")?,
            smoother_degree: options.count("smoother_degree")?,
            ..Self::default()
        })
    }
}

/// Smoothed-aggregation multigrid as a preconditioner.
pub(crate) struct SmoothedAggregation {
    options: AmgOptions,
    analysis: Option<Analysis>,
    hierarchy: Option<Hierarchy>,
    state: State,
    builds: u64,
}

/// What is known from the pattern.
struct Analysis {
    pattern: BlockPattern,
    modes: Modes,
    size: usize,
}

/// How the hierarchy stands to the current matrix.
#[derive(Debug, Default)]
struct State {
    /// Factor that brings the matrix to order one.
    scale: f64,
    /// Diagonal of the matrix the hierarchy was built for.
    diagonal: Vec<f64>,
    /// Whether the prolongation belongs to an earlier matrix.
    kept: bool,
    /// Whether the last solve took too long.
    worn: bool,
    /// Iterations of the first solve with the new hierarchy.
    reference: Option<usize>,
}

impl SmoothedAggregation {
    pub(crate) fn new(options: AmgOptions) -> Self {
        Self {
            options,
            analysis: None,
            hierarchy: None,
            state: State::default(),
            builds: 0,
        }
    }

    fn build(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.hierarchy = None;
        let analysis = analysed(self.analysis.as_ref())?;
        let diagonal = diagonal(matrix);
        let largest = diagonal
            .iter()
            .fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let scale = if largest > 0.0 {
            (-largest.log2().round()).exp2()
        } else {
            1.0
        };
        let finest = PointBlocks {
            matrix: Rows::new(&matrix),
            pattern: &analysis.pattern,
            size: analysis.size,
            scale,
        };
        let shape = Shape {
            threshold: self.options.threshold,
            polynomial: Polynomial {
                degree: self.options.smoother_degree.max(1),
                ratio: self.options.smoother_ratio,
            },
            coarsest: self.options.coarsest,
        };
        self.hierarchy = Some(Hierarchy::build(&finest, &analysis.modes, shape)?);
        self.state = State {
            scale,
            diagonal,
            ..State::default()
        };
        self.builds += 1;
        Ok(())
    }

    /// Whether so many points changed their material that the aggregates no longer fit.
    fn has_jumped(&self, matrix: CsrView<'_>) -> bool {
        let now = diagonal(matrix);
        let entries = now.iter().zip(&self.state.diagonal);
        let jumped = entries.filter(|(now, then)| **now > JUMP * **then || **then > JUMP * **now);
        jumped.count() as f64 > JUMPED * now.len() as f64
    }

    /// Stored entries of all levels over those of the finest.
    #[cfg(test)]
    fn complexity(&self) -> f64 {
        self.hierarchy.as_ref().map_or(0.0, Hierarchy::complexity)
    }
}

fn analysed(analysis: Option<&Analysis>) -> Result<&Analysis, SolveError> {
    analysis.ok_or(SolveError::NotAnalysed {
        solver: "amg",
        missing: "analyse",
    })
}

impl Preconditioner for SmoothedAggregation {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        let size = problem.unknowns_per_point;
        let rows = Rows::new(&problem.pattern);
        self.analysis = Some(Analysis {
            pattern: BlockPattern::of_points(rows, problem.points(), size),
            modes: Modes::of(problem),
            size,
        });
        self.hierarchy = None;
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        if self.state.worn || self.has_jumped(matrix) {
            return self.build(matrix);
        }
        let Some(hierarchy) = &mut self.hierarchy else {
            return self.build(matrix);
        };
        let analysis = analysed(self.analysis.as_ref())?;
        let finest = PointBlocks {
            matrix: Rows::new(&matrix),
            pattern: &analysis.pattern,
            size: analysis.size,
            scale: self.state.scale,
        };
        self.state.kept |= hierarchy.refresh(&finest)? > 0;
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        let Some(hierarchy) = &mut self.hierarchy else {
            correction.copy_from_slice(residual);
            return;
        };
        hierarchy.cycle(residual, correction);
        let scale = self.state.scale;
        correction.iter_mut().for_each(|value| *value *= scale);
    }

    fn patience(&self) -> Option<usize> {
        let few = self.state.reference.unwrap_or(UNSEEN / HOPELESS).max(FEW);
        self.state.kept.then_some(HOPELESS * few)
    }

    fn renew(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.build(matrix)
    }

    fn begin_anew(&mut self) {
        self.hierarchy = None;
        self.state = State::default();
    }

    fn observe(&mut self, iterations: usize) {
        let reference = *self.state.reference.get_or_insert(iterations);
        let limit = WORN * reference.max(FEW) as f64;
        self.state.worn = self.state.kept && iterations as f64 > limit;
    }

    fn work(&self) -> PreconditionerWork {
        let hierarchy = self.hierarchy.as_ref();
        PreconditionerWork {
            factorisations: self.builds,
            nonzeros: hierarchy.map_or(0, Hierarchy::nonzeros),
            bytes: hierarchy.map_or(0, |hierarchy| hierarchy.bytes() as u64),
        }
    }
}
