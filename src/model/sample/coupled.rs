//! How strongly flow and mechanics feel each other, point by point.

use super::{PointLimit, Seen, extremes};

/// Numbers of the coupling; the constrained modulus λ + 2μ stands for the rock.
#[derive(Debug, Clone, PartialEq)]
pub struct CoupledSample {
    /// Largest α²/(s(λ + 2μ)).
    pub strength: f64,
    /// Largest α/(s(λ + 2μ) + α²): undrained pressure per load of a confined rock.
    pub loading_efficiency: f64,
    /// Smallest and largest consolidation coefficient κ/(s + α²/(λ + 2μ)), m²/s.
    pub consolidation: [f64; 2],
    /// Largest step of schemes in which strain lags (Eq. 71).
    pub limit: PointLimit,
    /// Largest Δx²/(6 c_v): a shorter step overshoots next to a jump of the pressure, s.
    pub oscillation: f64,
}

/// Coupling safety factor of Eq. 71.
const SAFETY: f64 = 0.5;

impl<const D: usize> Seen<'_, D> {
    pub(super) fn coupling(&self) -> CoupledSample {
        let cloud = self.cloud;
        let biot = &self.points.biot_coefficient;
        let storage = &self.points.storage;
        let by_strain = |i: usize| biot[i].powi(2) / self.oedometer_modulus(i);
        let consolidation = |i: usize| self.mobility(i) / (storage[i] + by_strain(i));
        let time = |i: usize| cloud.spacing(i).powi(2) / consolidation(i);
        let efficiency =
            |i: usize| biot[i] / (storage[i] * self.oedometer_modulus(i) + biot[i].powi(2));
        let points = 0..cloud.len();
        let largest =
            |values: &dyn Fn(usize) -> f64| points.clone().map(values).fold(0.0, f64::max);
        CoupledSample {
            strength: largest(&|i| by_strain(i) / storage[i]),
            loading_efficiency: largest(&efficiency),
            consolidation: extremes(points.clone().map(consolidation)),
            limit: PointLimit::smallest(cloud, |i| SAFETY * time(i)),
            oscillation: largest(&|i| time(i) / 6.0),
        }
    }

    /// Storage of an explicit step: a solid that follows at rest adds β α²/(λ + 2μ/D), 1/Pa.
    pub(super) fn explicit_storage(&self, point: usize) -> f64 {
        let follows = (self.plan.mechanics.as_ref()).is_some_and(|mechanics| !mechanics.inertia);
        let split = match (self.plan.coupling, follows) {
            (Some(_), true) => {
                let lame = &self.points.lame[point];
                let bulk = lame.lambda + 2.0 * lame.mu / D as f64;
                let biot = self.points.biot_coefficient[point];
                self.plan.scheme_options.relaxation * biot.powi(2) / bulk
            }
            _ => 0.0,
        };
        self.points.storage[point] + split
    }
}
