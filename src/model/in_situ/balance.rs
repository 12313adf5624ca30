//! Equilibrium of the in-situ state inside: ∇·σ + ρ **g** + **b** = 0.

use super::InSitu;
use crate::effects::{tensor, vector};
use crate::geometry::{Matrix, Vector};
use crate::model::ModelError;
use crate::plan::Plan;

/// Share of the largest term that may be left: stresses are typed with a few digits.
const ACCEPTED: f64 = 1e-3;

/// Checks the gradients of the stress point by point. Borders of regions and materials are no part of it: what
/// jumps there is implied like tractions.
///
/// # Errors
/// [`ModelError::UnbalancedStress`] with the largest residual.
pub(super) fn check<const D: usize>(plan: &Plan, state: &InSitu<'_, D>) -> Result<(), ModelError> {
    let force = plan
        .mechanics
        .as_ref()
        .and_then(|own| own.body_force.as_ref());
    let force: Vector<D> = force.map_or_else(Vector::zeros, |force| vector(force));
    let at = |point: usize| {
        let gradient: Matrix<D> = state.total_gradient(point);
        let weight = state.down * state.weight[point];
        let left = gradient * state.down + weight + force;
        let scale = (gradient * state.down).norm() + weight.norm() + force.norm();
        (point, left.norm(), scale)
    };
    let wrong = (0..state.cloud.len())
        .map(at)
        .filter(|(_, left, scale)| *left > ACCEPTED * scale)
        .max_by(|a, b| a.1.total_cmp(&b.1));
    match wrong {
        None => Ok(()),
        Some((point, residual, _)) => Err(ModelError::UnbalancedStress {
            residual,
            weight: state.weight[point],
            at: state.cloud.position[point].iter().copied().collect(),
        }),
    }
}

impl<const D: usize> InSitu<'_, D> {
    /// Change of the total stress with depth at a point, Pa/m.
    fn total_gradient(&self, point: usize) -> Matrix<D> {
        if self.region[point].is_none() && self.initial.k0.is_some() {
            // Only the vertical stress changes along the vertical.
            return self.down * self.down.transpose() * -self.weight[point];
        }
        let mut gradient = match self.region[point] {
            Some(_) => [0.0; 6],
            None => self.initial.gradient,
        };
        if !self.initial.total {
            let push = self.biot[point] * self.fluid_weight;
            gradient[..3].iter_mut().for_each(|own| *own -= push);
        }
        tensor(&gradient)
    }
}
