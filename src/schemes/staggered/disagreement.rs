//! What flow and mechanics do not agree on after a pass.

use super::Staggered;
use crate::model::Model;
use crate::schemes::memory::Predictor;
use crate::schemes::stage::Target;
use crate::schemes::{StepError, flow_of};

/// Share of what the pores hold that counts in the scale: steps may be so small that their own
/// changes drown in rounding errors.
const FLOOR: f64 = 1e-3;

impl<const D: usize> Staggered<D> {
    /// Root mean square of the pressure that one pass leaves unsettled, Pa: fluid that strain owes its point, over
    /// what pores and exchange would take off it in the step for every pascal.
    ///
    /// Pressures so rough that no strain answers them are stored by the split alone and swing about what is right,
    /// at the speed of exchange and whatever the step, until the storage of the rock has worn them down: what
    /// strain owes them is all that flows.
    pub(super) fn unsettled(
        &self,
        model: &Model<D>,
        dt: f64,
        (guess, found): (&Predictor, &Predictor),
    ) -> Result<f64, StepError> {
        let flow = flow_of(model)?;
        let volume = &flow.operator.neighbourhood().cloud.volume;
        let pressure = |i: usize| {
            let strain = found.content[i] - guess.content[i];
            let owed = strain - self.split[i] * (found.pressure[i] - guess.pressure[i]);
            let taken = dt * flow.exchange_rate(i) + flow.capacity[i];
            match self.is_fixed[i] || taken <= 0.0 {
                true => 0.0,
                false => owed / taken,
            }
        };
        let squares = (0..volume.len()).map(|i| volume[i] * pressure(i).powi(2));
        Ok((squares.sum::<f64>() / volume.iter().sum::<f64>()).sqrt())
    }

    /// Residual of the coupled mass balance in absolute amounts, and its scale, m^D.
    pub(super) fn disagreement(
        &self,
        target: &Target<'_>,
        rhs: &[f64],
        (guess, found): (&Predictor, &Predictor),
    ) -> (f64, f64) {
        let base = &target.base.pressure;
        let mut total = (0.0, 0.0);
        for (i, right) in rhs.iter().enumerate().filter(|(i, _)| !self.is_fixed[*i]) {
            let strain = guess.content[i] - found.content[i];
            let pressure = self.split[i] * (guess.pressure[i] - found.pressure[i]);
            let held = FLOOR * base[i].abs() + found.pressure[i].abs();
            total.0 += (strain - pressure).abs();
            // What the split adds is no fluid: it may be many times what a fracture takes up.
            let stored = self.storage[i] - self.split[i];
            total.1 += right.abs() + found.content[i].abs() + stored * held;
        }
        total
    }
}
