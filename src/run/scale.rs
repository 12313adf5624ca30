//! What the error of a step is measured against: the range over which the pressure changes in the run.
//!
//! Known beforehand is what the problem's data say: how far prescribed pressures are, at any time, from the
//! pressure at the start. The run adds what it has seen and what the step under judgement brings, so a load
//! that comes late is resolved like one that acts from the start. Changes count, not pressures: a hydrostatic
//! column hides no pulse.

use serde::{Deserialize, Serialize};

use super::finish::extremes;
use crate::model::{FlowModel, Model};
use crate::plan::Plan;

/// Errors of the pressure that are rounding, relative to the pressures and stresses that balance each other.
/// Forces balance to 1e-11 of all forces, so pressures that follow from them carry as much. A body at rest under
/// 9.5 MPa, to which this allows 1e-3 Pa, has 2e-9 Pa of rounding after 643 explicit steps.
const NOISE: f64 = 1e-10;

/// Range and rounding of the pressure, Pa.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Scale {
    /// Largest range of the changes since the start so far.
    range: f64,
    /// Change that is rounding.
    noise: f64,
}

impl Scale {
    /// What the data of the problem tell.
    pub(super) fn new<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let Some(flow) = &model.flow else {
            return Scale {
                range: 0.0,
                noise: 0.0,
            };
        };
        Scale {
            range: announced(plan, flow),
            noise: NOISE * model.level,
        }
    }

    /// Whether the data tell of more than rounding.
    pub(super) fn is_known(&self) -> bool {
        self.range > self.noise
    }

    /// Takes in the pressures of an accepted state, or of one that is expected.
    pub(super) fn cover<const D: usize>(&mut self, model: &Model<D>, pressure: &[f64]) {
        self.range = self.range.max(changes(model, pressure));
    }

    /// Error of a step that leads to `pressure`, relative to the range; zero where it is rounding.
    pub(super) fn relative<const D: usize>(
        &self,
        model: &Model<D>,
        error: f64,
        pressure: &[f64],
    ) -> f64 {
        if error <= self.noise {
            return 0.0;
        }
        let range = self.range.max(changes(model, pressure));
        error / range.max(self.noise).max(f64::MIN_POSITIVE)
    }
}

/// Range of the changes since the start, zero included.
fn changes<const D: usize>(model: &Model<D>, pressure: &[f64]) -> f64 {
    let Some(flow) = &model.flow else { return 0.0 };
    let pairs = pressure.iter().zip(&flow.initial);
    let [low, high] = extremes(&pairs.map(|(now, start)| now - start).collect::<Vec<f64>>());
    high.max(0.0) - low.min(0.0)
}

/// Range of the changes that prescribed pressures announce, zero included.
fn announced<const D: usize>(plan: &Plan, flow: &FlowModel<D>) -> f64 {
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let mut enter = |start: f64, values: &[f64]| {
        for value in values {
            (low, high) = (low.min(value - start), high.max(value - start));
        }
    };
    for wall in &flow.walls {
        let values = wall.pressure.values();
        match plan.gravity {
            // Next to a side the column has a pressure of its own: only what varies is a change.
            Some(_) => enter(wall.pressure.at(0.0), values),
            None => wall
                .points()
                .for_each(|point| enter(flow.initial[point], values)),
        }
    }
    for fixed in &flow.fixed {
        enter(
            flow.initial[fixed.point],
            flow.fixed_loads[fixed.load].values(),
        );
    }
    high - low
}
