//! Passes of displacement and pressure together, in the split model.
//!
//! The pressure in a crack and the displacement belong to one potential, smallest over displacements and largest
//! over pressures. Every pass solves its linear system with the damage, the normals and the wet points as they are:
//! such a pass never leads up, as the potential at fixed damage lies above. Near the end the exact tangent, with the
//! damage eliminated, is tried instead. The residual covers the forces and the mass, with the content of pores and
//! cracks as a function of the state.

use super::passes::{NEAR, PassMonitor};
use super::{FractureFlowStep, StepStart, Trial};
use crate::material::TangentKind;
use crate::model::{Model, Spreading, Voids};
use crate::schemes::{State, StepError, StepReport, flow_of};

/// Fluid out of balance, relative to what moves in the step, that counts as none.
const BALANCED_MASS: f64 = 5e-7;
/// Fluid that rounding may lose in a step, relative to all that points hold. Where nothing moves passes cannot do
/// better: in `kgd-toughness` at 12.5 cm, shut in after 1.5 s, steps to 1 s take 297 passes and 4 of 36 are cut, with
/// 1e-14 11,242 passes and 107 of 207.
const ROUNDING: f64 = 1e-12;
/// Share of what a pass with the exact tangent found out of balance that it may leave.
const LEFT: f64 = 0.9;
/// Growth of all forces in a pass from which it has gone too far. Passes of `kgd-toughness/smoke` with 10, 100 and 1e3:
/// 188, 185 and 181.
const FAR: f64 = 100.0;

/// Where a pass stands.
struct Place<const D: usize> {
    at: Trial<D>,
    /// What points must still take up, m^D.
    mass: Vec<f64>,
    /// Voids in cracks, m^D.
    voids: Voids,
    /// Forces out of balance, relative to all forces.
    forces: f64,
    /// Whether the pressure of cracks has come to act elsewhere, so that it does not compare with the place before.
    rewetted: bool,
    /// The larger of what is out of balance, forces and mass, over what is allowed.
    off: f64,
}

/// Where the last pass started.
struct Departure<const D: usize> {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    place: Place<D>,
    /// The tangent of the pass.
    tried: TangentKind,
}

impl<const D: usize> Departure<D> {
    /// Share of the pass to leave where it made all forces very much larger; `None` where it did not. The tangent of a
    /// closed crack knows nothing of how far it opens: what is pumped into it would be squeezed into its pores, and from
    /// where that leads passes return by any way.
    fn strayed(&self, to: &Place<D>) -> Option<f64> {
        let grown = to.at.scale / self.place.at.scale;
        (grown > FAR && grown.is_finite()).then(|| grown.recip())
    }

    /// Leaves a share of the pass that led to a state.
    fn shorten(&self, state: &mut State, share: f64) {
        let toward = |end: &mut [f64], from: &[f64]| {
            end.iter_mut()
                .zip(from)
                .for_each(|(end, from)| *end = from + share * (*end - from));
        };
        toward(&mut state.displacement, &self.displacement);
        toward(&mut state.pressure, &self.pressure);
    }
}

impl<const D: usize> FractureFlowStep<D> {
    /// Passes until forces and mass balance at the coefficients that the model has then, from those of the step's
    /// start.
    pub(super) fn converge_coupled(
        &mut self,
        model: &mut Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        let mut watch = PassMonitor::new(0.0);
        let mut before: Option<Departure<D>> = None;
        self.spreading = Spreading::Anew;
        for pass in 0..=self.plan.iterations {
            let mut here = self.place(model, start, state)?;
            if let Some(from) = &before
                && let Some(share) = from.strayed(&here)
            {
                from.shorten(state, share);
                here = self.place(model, start, state)?;
            }
            // The exact tangent may have led astray.
            if let Some(from) = before.take()
                && from.tried == TangentKind::Consistent
                && !here.rewetted
                && self.led_astray(&from.place, &here, &watch)
            {
                self.policy.failed();
                (state.displacement, state.pressure) = (from.displacement, from.pressure);
                here = self.return_to(model, from.place)?;
            }
            report.passes = pass;
            report.residual = Some(here.forces);
            if here.off <= 1.0 {
                self.largest = self.largest.max(here.at.scale);
                return Ok(());
            }
            if start.dt > self.cut_above && self.runs(model, start.state, &here.at)? {
                let (time, most) = (state.time, self.plan.largest_increment);
                return Err(StepError::Runs { time, most });
            }
            watch.best = watch.best.min(here.forces);
            if here.forces <= self.plan.tolerance {
                watch.splitting_residual = watch.splitting_residual.min(here.off * BALANCED_MASS);
            }
            let broken = here.at.response.damage.iter().sum();
            if !watch.continues(here.off, broken, false) || pass == self.plan.iterations {
                break;
            }
            let (displacement, pressure) = (state.displacement.clone(), state.pressure.clone());
            let tried = self.advance_together(model, state, &here, start.dt, report)?;
            self.passes += 1;
            before = Some(Departure {
                displacement,
                pressure,
                place: here,
                tried,
            });
        }
        Err(watch.failure(state.time, self.plan.tolerance, self.passes as usize))
    }

    /// Whether a pass with the exact tangent left too much of the forces out of balance, or of all where passes make no
    /// progress: near balance they may go round in circles of two to five for good.
    fn led_astray(&self, from: &Place<D>, to: &Place<D>, watch: &PassMonitor) -> bool {
        let tolerance = self.plan.tolerance;
        let circles = watch.is_stuck() && to.off > LEFT * from.off;
        circles || to.forces > tolerance.max(LEFT * from.forces)
    }

    /// Brings coefficients to the state and measures what is out of balance.
    fn place(
        &mut self,
        model: &mut Model<D>,
        start: &StepStart<'_>,
        state: &mut State,
    ) -> Result<Place<D>, StepError> {
        model.boil(&self.is_fixed, &mut state.pressure);
        let mut at = self.evaluate(model, state)?;
        let mut forces = self.imbalance(&at, state.time)?;
        let mut rewetted = false;
        // Far from balance a pass may break much that does not stay so: nothing becomes wet by it.
        if forces <= NEAR {
            let before = model.wet_points();
            let fields = (&state.displacement[..], &state.walls[..]);
            let spreading = std::mem::replace(&mut self.spreading, Spreading::Further);
            model.follow_fractures(&at.response, fields, spreading);
            rewetted = before != model.wet_points();
            let boils = model.boil(&self.is_fixed, &mut state.pressure);
            if rewetted || boils {
                at = self.evaluate(model, state)?;
                forces = self.imbalance(&at, state.time)?;
            }
        } else {
            model.follow_openings(&at.response);
        }
        let (mass, taken) = self.mass_residual(model, start, state, &at.response)?;
        let voids = model.voids();
        let moved = self.moved(model, start, state, taken)?;
        let mass_off = mass.iter().map(|m| m.abs()).sum::<f64>() / moved;
        let off = (forces / self.plan.tolerance).max(mass_off / BALANCED_MASS);
        Ok(Place {
            at,
            mass,
            voids,
            forces,
            off,
            rewetted,
        })
    }

    /// A place that was left, with the coefficients that it had.
    fn return_to(&mut self, model: &mut Model<D>, place: Place<D>) -> Result<Place<D>, StepError> {
        model.follow_openings(&place.at.response);
        model.set_voids(&place.voids);
        Ok(place)
    }

    /// Scale of the fluid that moves in a step in which points took up `taken` (Σ of absolutes), m^D. What strain and
    /// pressure move in opposite ways counts as well, and rounding of all that is held.
    fn moved(
        &self,
        model: &Model<D>,
        start: &StepStart<'_>,
        state: &State,
        taken: f64,
    ) -> Result<f64, StepError> {
        let flow = flow_of(model)?;
        let size = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let step = state.since(start.state);
        let strained = size(&model.content(&step.displacement, &step.walls));
        let pairs = flow.capacity.iter().zip(&step.pressure);
        let squeezed: f64 = pairs.map(|(capacity, p)| (capacity * p).abs()).sum();
        let gross = start.dt * flow.flows(&state.pressure, state.time).gross;
        let rounding = ROUNDING / BALANCED_MASS * size(&start.held);
        let moved = taken + strained + squeezed + gross;
        Ok(moved.max(rounding).max(f64::MIN_POSITIVE))
    }

    /// Solves the linear system of both fields and moves the state by what it tells; gives its tangent.
    fn advance_together(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        here: &Place<D>,
        dt: f64,
        report: &mut StepReport,
    ) -> Result<TangentKind, StepError> {
        // At fixed damage a pass never leads up; with a part of the softening it may.
        let mut softening = match self.policy.next(here.forces) {
            TangentKind::Bounded => TangentKind::Secant,
            softening => softening,
        };
        let from = (&here.at, &here.mass[..]);
        let mut solved = self.solve_together(model, state, from, (dt, softening), report);
        if softening == TangentKind::Consistent && solved.is_err() {
            self.policy.failed();
            self.reuse.forget();
            softening = TangentKind::Secant;
            solved = self.solve_together(model, state, from, (dt, softening), report);
        }
        let change = solved?.ok_or(StepError::Missing {
            part: "the matrix of both fields",
        })?;
        let add = |to: &mut [f64], by: &[f64]| to.iter_mut().zip(by).for_each(|(t, b)| *t += b);
        add(&mut state.displacement, &change.displacement);
        add(&mut state.pressure, &change.pressure);
        Ok(softening)
    }
}
