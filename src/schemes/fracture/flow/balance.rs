//! What points must still take up, and the pressure that brings it to them.

use perifrac_solvers::norm2;

use super::FractureFlowStep;
use super::stored::{StepStart, stored_increment};
use crate::model::Model;
use crate::operators::Response;
use crate::schemes::fracture::Fracture;
use crate::schemes::{SolidSolver, State, StepError, flow_of};

/// Storage of a point with a void over what it and its neighbours would take up: its pressure stays as it is.
const HELD: f64 = 1e12;

impl<const D: usize> FractureFlowStep<D> {
    /// What the pores must still take up over the step, zero where the pressure is prescribed or voids take it up, and
    /// what they took, Σ of absolutes; m^D.
    pub(super) fn mass_residual(
        &mut self,
        model: &mut Model<D>,
        start: &StepStart<'_>,
        state: &State,
        response: &Response<D>,
    ) -> Result<(Vec<f64>, f64), StepError> {
        let flow = flow_of(model)?;
        let mut left = vec![0.0; flow.points()];
        flow.imbalance(state.time, &state.pressure, &mut left);
        self.products += 1;
        let mut taken = stored_increment(model, start, state, Some(response))?;
        for (i, left) in left.iter_mut().enumerate() {
            let came = start.dt * *left;
            *left = match self.system.is_fixed[i] {
                true => 0.0,
                false => came - taken[i],
            };
            taken[i] += *left;
        }
        model.settle_voids(&mut left, response);
        let taken = taken.iter().zip(&left);
        let taken = taken.map(|(came, left)| (came - left).abs()).sum();
        Ok((left, taken))
    }

    /// Brings the pressure to the displacement: all the way where both are solved together, else with the
    /// compliance of the fractures, which stands in for the strain that the pressure will cause. Gives the
    /// iterations, and the share of the volume taken up that is owed to that strain.
    pub(super) fn balance(
        &mut self,
        model: &mut Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
        response: &Response<D>,
    ) -> Result<(usize, f64), StepError> {
        model.boil(&self.system.is_fixed, &mut state.pressure);
        let settings = self.plan.descent;
        let (mut iterations, mut rounds) = (0, 0);
        let mut owed = vec![0.0; state.pressure.len()];
        loop {
            let (left, taken) = self.mass_residual(model, start, state, response)?;
            let change = self.flow_change(model, start.dt, response, &left, &mut iterations)?;
            let split = self.split();
            for (i, change) in change.iter().enumerate() {
                state.pressure[i] += change;
                owed[i] += split.get(i).map_or(0.0, |split| split * change);
            }
            rounds += 1;
            if !model.boil(&self.system.is_fixed, &mut state.pressure)
                || rounds == settings.cavitation_rounds
            {
                let owed: f64 = owed.iter().map(|owed| owed.abs()).sum();
                return Ok((iterations, owed / taken.max(f64::MIN_POSITIVE)));
            }
        }
    }

    /// What the compliance stands in for, m^D/Pa, shape `(n,)`; empty where nothing.
    pub(super) fn split(&self) -> &[f64] {
        match self.splits() {
            true => &self.compliance.storage,
            false => &[],
        }
    }

    /// Change of the pressure, Pa, that brings points what they must still take up; none where there are voids.
    pub(super) fn flow_change(
        &mut self,
        model: &Model<D>,
        dt: f64,
        response: &Response<D>,
        left: &[f64],
        iterations: &mut usize,
    ) -> Result<Vec<f64>, StepError> {
        let flow = flow_of(model)?;
        self.flow.forget(flow);
        let mut storage = flow.capacity.clone();
        model.add_crack_storage(response, &mut storage);
        let pairs = storage.iter_mut().zip(self.split());
        pairs.for_each(|(storage, split)| *storage += split);
        for point in model.void_points() {
            storage[point] += HELD * (storage[point] + dt * flow.exchange_rate(point));
        }
        self.flow.prepare(flow, &storage, dt, &[])?;
        let mut change = vec![0.0; left.len()];
        *iterations += self.flow.solve(flow, left, &mut change)?;
        Ok(change)
    }

    /// Whether the compliance stands in for the strain to come: never where both are solved together.
    pub(super) fn splits(&self) -> bool {
        self.compliance.strength > self.plan.descent.compliance_threshold
    }

    /// Brings the compliance of the fractures to those of the last step, where fields take turns and the
    /// pressure responds to the strain.
    pub(super) fn follow_compliance(
        &mut self,
        model: &Model<D>,
        old: &State,
        state: &State,
    ) -> Result<usize, StepError> {
        if self.system.is_coupled() {
            return Ok(0);
        }
        let (demand, plan) = (&self.demand, self.plan);
        let solid =
            |raised: &mut State| Fracture::new(demand, model, plan)?.equilibrate(model, raised);
        let iterations = self.compliance.follow(model, old, self.relaxation, solid)?;
        let (moved, pressed) = (norm2(&state.displacement), norm2(&state.pressure));
        self.acceleration.depth = match self.splits() {
            true => plan.descent.compliant_anderson_depth,
            false => plan.descent.anderson_depth,
        };
        if moved > 0.0 && pressed > 0.0 {
            self.unit = moved / pressed;
        }
        Ok(iterations)
    }
}
