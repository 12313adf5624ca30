//! What a scheme carries from one accepted step to the next beside the fields of a state.
//!
//! It is part of the state, so that a step is a function of the state it starts from: a rejected trial
//! leaves no trace, and a run that is continued from a checkpoint goes on with the same bits. Matrices,
//! factors and preconditioners are no part of it: they are functions of the coefficient that is kept here,
//! or are made anew in every step.

use serde::{Deserialize, Serialize};

use super::StepLimit;

/// Memory of a scheme; what a scheme does not use is empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Imbalance q − L p at the end of the step, m^D/s.
    pub imbalance: Option<Timed>,
    /// Acceleration at the end of the step, m/s².
    pub acceleration: Option<Timed>,
    /// Coefficient of L in the matrix that is factored, s.
    pub coefficient: Option<f64>,
    /// Pressure increment of the last linear solve, Pa: the first guess of the next.
    pub guess: Vec<f64>,
    /// Increments of the stages of the step, by which the next one starts where fields take turns.
    pub lags: [Option<Lag>; 2],
    /// Rates of the step.
    pub rates: Rates,
    /// Largest force so far, Σ of absolutes, N: the scale of forces once loads are gone.
    pub largest_force: f64,
    /// Smoothed local stiffness of dynamic relaxation per point, Eq. 67.
    pub local_stiffness: Vec<f64>,
    /// How the solid moved in the last explicit step that relaxation followed.
    pub followed: Rates,
    /// Iterations for which Newton's tangent is not tried after it failed.
    pub tangent_rest: usize,
    /// Residual that linear systems of both fields are solved to.
    pub forcing: Option<f64>,
    /// Metres per pascal that make displacement and pressure count alike.
    pub unit: Option<f64>,
    /// Compliance of fractures when it was measured.
    pub compliance: Option<Measured>,
    /// Growth watch of explicit steps.
    pub watch: GrowthMonitor,
    /// Stability limit as of the last step, where it follows the state.
    pub limit: Option<StepLimit>,
}

/// A vector at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timed {
    /// Time, s.
    pub time: f64,
    /// Values at that time.
    pub values: Vec<f64>,
}

impl Timed {
    /// The values, if they are those of this very time.
    pub fn at(&self, time: f64) -> Option<&[f64]> {
        (self.time.to_bits() == time.to_bits()).then_some(&self.values)
    }
}

/// Pressure change and strain content of one pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Predictor {
    /// Pa, shape `(n,)`.
    pub pressure: Vec<f64>,
    /// Pore volume gained by strain, m^D, shape `(n,)`.
    pub content: Vec<f64>,
}

impl Predictor {
    /// No change at all.
    pub fn none(points: usize) -> Self {
        Predictor {
            pressure: vec![0.0; points],
            content: vec![0.0; points],
        }
    }
}

/// Pressure change and strain content of a stage of a step of `dt` seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Lag {
    /// Length of the step, s.
    pub dt: f64,
    /// What its last pass found.
    pub found: Predictor,
}

impl Lag {
    /// The same in a step of another length, s.
    pub fn scaled(&self, dt: f64) -> Predictor {
        let share = if self.dt > 0.0 { dt / self.dt } else { 0.0 };
        let scale = |values: &[f64]| values.iter().map(|value| share * value).collect();
        Predictor {
            pressure: scale(&self.found.pressure),
            content: scale(&self.found.content),
        }
    }
}

/// How fast a step of `dt` seconds went.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Rates {
    /// Length of the step, s.
    pub dt: f64,
    /// m/s, shape `(n·D,)`.
    pub displacement: Vec<f64>,
    /// Pa/s, shape `(n,)`.
    pub pressure: Vec<f64>,
}

/// Compliance of all fractures together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Storage per broken volume, 1/Pa.
    pub density: f64,
    /// Broken volume then, m^D.
    pub broken: f64,
}

/// Watches the imbalance ‖q − L p‖ in the S⁻¹ norm. Stable steps never let it grow by more than the
/// loads change, so growth means instability, long before values overflow.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct GrowthMonitor {
    /// Steps seen.
    pub steps: usize,
    /// Largest imbalance that the loads until now can have caused.
    pub bound: f64,
}
