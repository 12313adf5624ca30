//! The hourglass energy alone: ½ Σ_i V_i Σ_b ω V_j (R f)²; it vanishes for linear fields only.

use std::sync::Arc;

use super::{BondForm, Coupling, Gradient, Neighbourhood};
use crate::geometry::Matrix;
use crate::parallel;

/// Form Rᵀ D(V_i ω V_j) R with R f = f_j − f_i − ∇̃f_i·ξ (Eq. 10).
#[derive(Debug, Clone)]
pub(crate) struct Hourglass<const D: usize> {
    around: Arc<Neighbourhood<D>>,
    gradient: Arc<Gradient<D>>,
    /// Factor per point, shape `(n,)`.
    factor: Vec<f64>,
    /// −factor V_i K_i, shape `(n,)`.
    stiffness: Vec<Matrix<D>>,
}

impl<const D: usize> Hourglass<D> {
    /// Form over the plain gradient of the same neighbourhood.
    pub(crate) fn new(around: Arc<Neighbourhood<D>>, gradient: Arc<Gradient<D>>) -> Self {
        let ones = vec![1.0; around.len()];
        Self::weighted(around, gradient, ones)
    }

    /// The same with a factor per family, shape `(n,)`.
    pub(crate) fn weighted(
        around: Arc<Neighbourhood<D>>,
        gradient: Arc<Gradient<D>>,
        factor: Vec<f64>,
    ) -> Self {
        let stiffness = parallel::map(around.len(), |i| {
            around.shape(i) * (-factor[i] * around.cloud.volume[i])
        });
        Hourglass {
            around,
            gradient,
            factor,
            stiffness,
        }
    }
}

impl<const D: usize> BondForm<D> for Hourglass<D> {
    fn name(&self) -> &'static str {
        "hourglass"
    }

    fn neighbourhood(&self) -> &Neighbourhood<D> {
        &self.around
    }

    fn geometric(&self, owner: usize, bond: usize) -> f64 {
        self.factor[owner] * self.around.cloud.volume[owner] * self.around.measure[bond]
    }

    fn mean(&self, _owner: f64, _end: f64) -> f64 {
        1.0
    }

    fn conductances(&self, owner: usize, _mobility: &[f64], conductances: &mut [f64]) {
        let family = self.around.families.family(owner);
        for (bond, conductance) in family.zip(conductances) {
            *conductance = self.geometric(owner, bond);
        }
    }

    fn couples(&self, _owner: usize) -> bool {
        true
    }

    fn coupling(&self, owner: usize, _mobility: &[f64]) -> [Option<Coupling<'_, D>>; 2] {
        let stiffness = self.stiffness[owner];
        let weight = &self.gradient.weight[self.around.families.family(owner)];
        [Some(Coupling { stiffness, weight }), None]
    }

    fn bytes(&self) -> usize {
        self.gradient.bytes() + 8 * (D * D + 1) * self.stiffness.len()
    }
}
