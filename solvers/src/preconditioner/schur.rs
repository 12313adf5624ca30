//! Block preconditioners of quasi-definite matrices [K, −Bᵀ; −B, −C], for GMRES from the right.
//!
//! The upper triangular factor [K, −Bᵀ; 0, −S] with the Schur complement S = C + B K⁻¹ Bᵀ leaves two
//! iterations; here a few multigrid-preconditioned iterations stand for K⁻¹, one multigrid cycle for
//! S⁻¹, and a sparse matrix for S:
//!
//! - `schur`: C + B D⁻¹ Bᵀ with the point blocks D of K, right where the stiffness is degraded too, and
//!   diag([`Problem::schur_diagonal`]) where it is known: B D⁻¹ Bᵀ does not see smooth pressures, which
//!   B K⁻¹ Bᵀ answers alike whatever their length, and two terms of one size for rough ones cost little;
//! - `fixed-stress`: C + diag([`Problem::schur_diagonal`]), the storage of the fixed-stress split of
//!   poroelasticity, which knows nothing of damage.

mod complement;
mod inner;
mod split;
#[cfg(test)]
mod tests;

use self::complement::{SelfComplement, with_diagonal};
use self::inner::Inner;
use self::split::Blocks;
use super::amg::{AmgOptions, SmoothedAggregation};
use super::{Preconditioner, PreconditionerWork};
use crate::problem::{Problem, Symmetry};
use crate::registry::Options;
use crate::{CsrMatrix, CsrView, SolveError, SpecError, multiply};

/// What stands for the Schur complement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Complement {
    /// C + B D⁻¹ Bᵀ with the diagonal blocks D of K, and [`Problem::schur_diagonal`] if it is given.
    SelfPreconditioned,
    /// C + [`Problem::schur_diagonal`].
    FixedStress,
}

/// Builds `schur` from the options of a backend.
///
/// # Errors
/// [`SpecError`] for a value that is no number.
pub(super) fn build_self(options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    build(options, Complement::SelfPreconditioned)
}

/// Builds `fixed-stress` from the options of a backend.
///
/// # Errors
/// [`SpecError`] for a value that is no number.
pub(super) fn build_fixed_stress(
    options: &Options<'_>,
) -> Result<Box<dyn Preconditioner>, SpecError> {
    build(options, Complement::FixedStress)
}

fn build(
    options: &Options<'_>,
    complement: Complement,
) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(SchurBlocks {
        complement,
        inner: options.count("inner")?,
        amg: AmgOptions::of(options)?,
        parts: None,
    }))
}

/// Multigrid on K and on an approximate Schur complement.
struct SchurBlocks {
    complement: Complement,
    /// Iterations on K in each application.
    inner: usize,
    amg: AmgOptions,
    parts: Option<Parts>,
}

/// What is known from the pattern, and the values last taken.
struct Parts {
    blocks: Blocks,
    /// How S is computed; without it the given diagonal is added.
    own: Option<SelfComplement>,
    given: Vec<f64>,
    schur: CsrMatrix,
    stiffness_amg: SmoothedAggregation,
    schur_amg: SmoothedAggregation,
    work: Work,
}

/// Vectors of one application.
struct Work {
    force: Vec<f64>,
    displacement: Vec<f64>,
    push: Vec<f64>,
    source: Vec<f64>,
    pressure: Vec<f64>,
    inner: Inner,
}

impl Work {
    fn new(displacements: usize, pressures: usize) -> Self {
        Self {
            force: vec![0.0; displacements],
            displacement: vec![0.0; displacements],
            push: vec![0.0; displacements],
            source: vec![0.0; pressures],
            pressure: vec![0.0; pressures],
            inner: Inner::new(displacements),
        }
    }
}

impl SchurBlocks {
    fn given(&self, problem: &Problem<'_>) -> Result<Vec<f64>, SolveError> {
        let given = problem.schur_diagonal;
        if self.complement == Complement::FixedStress && given.is_none() {
            return Err(SolveError::InvalidProblem {
                reason: "preconditioner=fixed-stress needs the storage of the fixed-stress split; \
                         choose preconditioner=schur"
                    .into(),
            });
        }
        Ok(given.map_or_else(Vec::new, <[f64]>::to_vec))
    }
}

impl Parts {
    fn new(
        problem: &Problem<'_>,
        complement: Complement,
        given: Vec<f64>,
        amg: AmgOptions,
    ) -> Result<Self, SolveError> {
        let size = problem.unknowns_per_point;
        let blocks = Blocks::analyse(problem.pattern, size);
        let part = |matrix, unknowns_per_point| Problem {
            coordinates: problem.coordinates,
            ..Problem::new(matrix, Symmetry::PositiveDefinite, unknowns_per_point)
        };
        let mut stiffness_amg = SmoothedAggregation::new(amg);
        stiffness_amg.analyse(&Problem {
            near_nullspace: problem.near_nullspace,
            ..part(blocks.stiffness.view(), size - 1)
        })?;
        let mut own = match complement {
            Complement::SelfPreconditioned => Some(SelfComplement::analyse(&blocks)),
            Complement::FixedStress => None,
        };
        let schur = own
            .as_mut()
            .map_or_else(|| blocks.storage.clone(), |own| own.matrix(&blocks));
        let mut schur_amg = SmoothedAggregation::new(amg);
        schur_amg.analyse(&part(schur.view(), 1))?;
        Ok(Self {
            work: Work::new(blocks.stiffness.rows(), schur.rows()),
            blocks,
            own,
            given,
            schur,
            stiffness_amg,
            schur_amg,
        })
    }

    fn fill(&mut self, matrix: CsrView<'_>) {
        self.blocks.fill(matrix);
        let own = self.own.as_mut().map(|own| own.matrix(&self.blocks));
        self.schur = match own {
            Some(own) if self.given.is_empty() => own,
            own => with_diagonal(
                &own.unwrap_or_else(|| self.blocks.storage.clone()),
                &self.given,
            ),
        };
    }
}

impl Preconditioner for SchurBlocks {
    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.parts = None;
        if problem.unknowns_per_point < 2 {
            return Err(SolveError::InvalidProblem {
                reason: "a block preconditioner needs two fields at each point".into(),
            });
        }
        let given = self.given(problem)?;
        self.parts = Some(Parts::new(problem, self.complement, given, self.amg)?);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let parts = self.parts.as_mut().ok_or(SolveError::NotAnalysed {
            solver: "schur",
            missing: "analyse",
        })?;
        parts.fill(matrix);
        parts.stiffness_amg.refresh(parts.blocks.stiffness.view())?;
        parts.schur_amg.refresh(parts.schur.view())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        let Some(parts) = &mut self.parts else {
            return;
        };
        let (blocks, work) = (&parts.blocks, &mut parts.work);
        blocks.separate(residual, &mut work.force, &mut work.source);
        parts.schur_amg.apply(&work.source, &mut work.pressure);
        work.pressure.iter_mut().for_each(|p| *p = -*p);
        multiply(blocks.gradient.view(), &work.pressure, &mut work.push);
        for (force, push) in work.force.iter_mut().zip(&work.push) {
            *force -= push;
        }
        if self.inner == 1 {
            parts
                .stiffness_amg
                .apply(&work.force, &mut work.displacement);
        } else {
            work.inner.solve(
                blocks.stiffness.view(),
                &mut parts.stiffness_amg,
                &mut work.force,
                &mut work.displacement,
                self.inner,
            );
        }
        blocks.join(&work.displacement, &work.pressure, correction);
    }

    fn patience(&self) -> Option<usize> {
        let parts = self.parts.as_ref()?;
        let own = [parts.stiffness_amg.patience(), parts.schur_amg.patience()];
        own.into_iter().flatten().min()
    }

    fn renew(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        let Some(parts) = &mut self.parts else {
            return Ok(());
        };
        parts.fill(matrix);
        parts.stiffness_amg.renew(parts.blocks.stiffness.view())?;
        parts.schur_amg.renew(parts.schur.view())
    }

    fn begin_anew(&mut self) {
        if let Some(parts) = &mut self.parts {
            parts.stiffness_amg.begin_anew();
            parts.schur_amg.begin_anew();
        }
    }

    fn observe(&mut self, iterations: usize) {
        if let Some(parts) = &mut self.parts {
            parts.stiffness_amg.observe(iterations);
            parts.schur_amg.observe(iterations);
        }
    }

    fn is_symmetric(&self) -> bool {
        false
    }

    /// Several iterations of conjugate gradients are no linear function of the residual.
    fn is_variable(&self) -> bool {
        self.inner > 1
    }

    fn work(&self) -> PreconditionerWork {
        let Some(parts) = &self.parts else {
            return PreconditionerWork::default();
        };
        let (one, other) = (parts.stiffness_amg.work(), parts.schur_amg.work());
        let blocks = 12 * (parts.blocks.nonzeros() + parts.schur.nnz()) as u64;
        PreconditionerWork {
            factorisations: one.factorisations.max(other.factorisations),
            nonzeros: one.nonzeros + other.nonzeros,
            bytes: one.bytes + other.bytes + blocks,
        }
    }
}
