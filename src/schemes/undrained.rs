//! The undrained start: equilibrium with no fluid moving, S Δp + Q Δu = 0 point by point.

use perifrac_solvers::norm2;

use super::accelerator::Accelerator;
use super::memory::Predictor;
use super::solid::SolidSolver;
use super::{State, StepError, coupling_of, flow_of};
use crate::model::Model;
use crate::plan::SchemeOptions;

/// Change of a pass, relative to the pressure, at which passes end.
const SETTLED: f64 = 1e-12;

/// Forces out of balance, over all forces, up to which passes may go on to a tenth of them; what relaxation leaves
/// differs from pass to pass, and after 100 of them Mandel's slab still changed by 2.5 of its tolerance.
const EXACT: f64 = 1e-9;
const RELAXED: f64 = 10.0;

/// Change that is rounding, relative to the pressures and stresses that balance each other: of loads in
/// balance with 10 MPa of stress passes went on to change 1e-9 Pa for ever.
const ROUNDING: f64 = 1e-12;

/// Brings `state` to the undrained response to the loads at its time by accelerated fixed-stress passes.
///
/// The full split is used whatever `scheme.relaxation` says: the start is the same for all schemes.
/// Passes end at the accuracy of the solid solver.
///
/// # Errors
/// [`StepError::CouplingDiverged`], and those of the solid solver.
pub(super) fn undrained<const D: usize>(
    model: &Model<D>,
    solid: &mut dyn SolidSolver<D>,
    options: &SchemeOptions,
    state: &mut State,
) -> Result<(), StepError> {
    let (flow, coupling) = (flow_of(model)?, coupling_of(model)?);
    let capacity = &flow.capacity;
    let (split, storage) = coupling.split(1.0, capacity);
    let start = state.clone();
    let bar = match solid.accuracy() {
        exact if exact <= EXACT => SETTLED.max(0.1 * exact),
        relaxed => RELAXED * relaxed,
    };
    let mut accelerator = Accelerator::new(options.acceleration);
    let mut guess = Predictor::none(storage.len());
    let mut relative = f64::INFINITY;
    solid.equilibrate(model, state)?;
    for _ in 0..options.coupling_iterations {
        let step = state.since(&start);
        guess.content = model.content(&step.displacement, &step.walls);
        let mut pressure: Vec<f64> = (0..storage.len())
            .map(|i| (split[i] * guess.pressure[i] - guess.content[i]) / storage[i])
            .collect();
        flow.fix(state.time, &start.pressure, &mut pressure);
        let change: Vec<f64> = pressure
            .iter()
            .zip(&guess.pressure)
            .map(|(n, o)| n - o)
            .collect();
        // Forces balance to a share of all forces, those of the pressure that is there included.
        let whole = norm2(&pressure).max(norm2(&state.pressure));
        let size = whole.max(ROUNDING / bar * model.level);
        relative = norm2(&change) / size.max(f64::MIN_POSITIVE);
        let found = Predictor {
            pressure,
            content: guess.content.clone(),
        };
        guess = accelerator.next(guess, found, &storage);
        let moved = start
            .pressure
            .iter()
            .zip(&guess.pressure)
            .map(|(s, g)| s + g);
        state
            .pressure
            .iter_mut()
            .zip(moved)
            .for_each(|(p, m)| *p = m);
        solid.equilibrate(model, state)?;
        if relative <= bar {
            return Ok(());
        }
    }
    Err(StepError::CouplingDiverged {
        time: state.time,
        passes: options.coupling_iterations,
        residual: relative,
        relaxation: 1.0,
        strength: coupling.strength(capacity),
    })
}
