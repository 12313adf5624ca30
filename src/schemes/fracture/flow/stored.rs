//! What pores and cracks take up in a step.

use crate::model::{Filling, Model};
use crate::operators::Response;
use crate::schemes::implicit::weighted_flows;
use crate::schemes::{State, StepError, StepReport, flow_of};

/// Where a step starts.
pub(crate) struct StepStart<'a> {
    /// The state.
    pub state: &'a State,
    /// What points hold there, m^D, shape `(n,)`; empty where that does not follow from a state.
    pub held: Vec<f64>,
    /// Length of the step, s.
    pub dt: f64,
}

impl<'a> StepStart<'a> {
    /// A step of `dt` seconds from a state, with the model at its coefficients.
    pub(crate) fn new<const D: usize>(model: &Model<D>, state: &'a State, dt: f64) -> Self {
        let response = model.crack_response(&state.view());
        let held = response.map_or_else(Vec::new, |own| model.held(&state.view(), Some(&own)));
        StepStart { state, held, dt }
    }
}

/// What the pores took up since `old`, at the coefficients of now, m^D.
pub(super) fn stored_increment<const D: usize>(
    model: &Model<D>,
    start: &StepStart<'_>,
    state: &State,
    response: Option<&Response<D>>,
) -> Result<Vec<f64>, StepError> {
    let flow = flow_of(model)?;
    if model.has_crack_content() {
        let held = model.held(&state.view(), response);
        return Ok(held.iter().zip(&start.held).map(|(n, o)| n - o).collect());
    }
    let step = state.since(start.state);
    let mut taken = model.content(&step.displacement, &step.walls);
    for (i, taken) in taken.iter_mut().enumerate() {
        *taken += flow.capacity[i] * step.pressure[i];
    }
    Ok(taken)
}

/// Enters into a report what came in over a step of `dt` seconds with the rates of a state, and what the
/// pores took up; with the response to the new state where cracks hold fluid of their own.
///
/// # Errors
/// [`StepError::MissingPart`] without flow.
pub(crate) fn close<const D: usize>(
    model: &Model<D>,
    start: &StepStart<'_>,
    (new, response): (&State, Option<&Response<D>>),
    (dt, at): (f64, &State),
    report: &mut StepReport,
) -> Result<(), StepError> {
    let flow = flow_of(model)?;
    let mut imbalance = vec![0.0; flow.points()];
    flow.imbalance(at.time, &at.pressure, &mut imbalance);
    let taken = stored_increment(model, start, new, response)?;
    report.flows = weighted_flows(flow, &[(dt, &at.pressure, at.time, &imbalance)]);
    for fixed in &flow.fixed {
        report.flows.hold(fixed.load, taken[fixed.point]);
    }
    // What a state holds is audited as such; what follows from increments only can be as their sum.
    report.stored = (!model.has_crack_content()).then(|| taken.iter().sum());
    Ok(())
}

/// Gives what is broken by a response to a state fluid of its own, `in_balance` at the pressure that broke it and else at
/// that of the pores.
pub(crate) fn fill_broken<const D: usize>(
    model: &mut Model<D>,
    response: Option<&Response<D>>,
    state: &mut State,
    in_balance: bool,
) {
    let Some(response) = response else { return };
    let filling = Filling {
        displacement: &state.displacement,
        walls: &state.walls,
        pressure: &mut state.pressure,
        in_balance,
    };
    model.fill_broken(response, filling);
}
