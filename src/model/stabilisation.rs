//! Stabilisation of the pressure against oscillations of nearly undrained rock.
//!
//! Pressures that alternate from point to point have no mechanical divergence, so that without storage
//! and flow nothing resists them. The term adds a storage that only rough pressures feel,
//!
//!   ½ Σ_i V_i θ (α²/(λ+2μ)) Δx² (2/m_i) Σ_b ω V_j (R p)²,
//!
//! with R of the hourglass energy (Eq. 10), which vanishes for linear pressures. Its sum over all
//! points is zero: it moves no fluid in or out.

use std::sync::Arc;

use crate::assembly::{Pattern, Refill, ScalarOperator};
use crate::geometry::Side;
use crate::operators::{Gradient, Hourglass, MirrorContinuation, Neighbourhood, Parity};

use super::{Coupling, ModelError};

/// The stabilising form and the continuation it uses.
pub(super) struct Stabilisation<const D: usize> {
    form: Hourglass<D>,
    extension: MirrorContinuation<D>,
}

impl<const D: usize> Stabilisation<D> {
    /// Term with the factor `strength` (θ) over the families of the flow operator.
    pub(crate) fn new(around: &Neighbourhood<D>, coupling: &Coupling, strength: f64) -> Self {
        let cloud = &around.cloud;
        let factor = |i: usize| {
            let storage = coupling.oedometric[i] / cloud.volume[i];
            2.0 * strength * storage * cloud.spacing(i).powi(2) / around.moment[i]
        };
        let factor = (0..around.len()).map(factor).collect();
        let around = Arc::new(around.clone());
        let gradient = Arc::new(Gradient::plain(&around));
        let planes: Vec<f64> = Side::all(D).map(|side| cloud.domain.plane(side)).collect();
        Stabilisation {
            extension: MirrorContinuation::new(
                &around.families.images,
                &[Parity::Even; 6],
                &planes,
            ),
            form: Hourglass::weighted(around, gradient, factor),
        }
    }

    /// Its sparsity.
    pub(crate) fn pattern(&self) -> Result<Pattern, ModelError> {
        Ok(Pattern::new(&self.form)?)
    }

    /// Its values in `pattern`, which holds its own, m^D/Pa.
    pub(crate) fn values(&self, pattern: &Pattern) -> Vec<f64> {
        let mut values = vec![0.0; pattern.nonzeros()];
        let plan: Refill = self.form.refill_plan(&self.extension, pattern);
        self.form
            .fill(&self.extension, &[], pattern, &plan, &mut values);
        values
    }
}
