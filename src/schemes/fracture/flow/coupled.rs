//! Passes of displacement and pressure together, in the split model.
//!
//! The pressure in a crack and the displacement belong to one potential, smallest over displacements and largest
//! over pressures. Every pass solves its linear system with the damage, the normals and the wet points as they are:
//! such a pass never leads up, as the potential at fixed damage lies above. Near the end the exact tangent, with the
//! damage eliminated, is tried instead. The residual covers the forces and the mass, with the content of pores and
//! cracks as a function of the state.

use perifrac_solvers::norm2;

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
        let mut tried = TangentKind::Secant;
        let mut before: Option<(Vec<f64>, Place<D>)> = None;
        self.spreading = Spreading::Anew;
        for pass in 0..=self.plan.iterations {
            let mut here = self.place(model, start, state)?;
            // The exact tangent may have led astray.
            if let (TangentKind::Consistent, Some((from, place))) = (tried, before.take())
                && !here.rewetted
                && self.led_astray(&place, &here, &watch)
            {
                self.policy.failed();
                self.set_unknowns(&from, state);
                here = self.return_to(model, place)?;
            }
            report.passes = pass;
            report.residual = Some(here.forces);
            if here.off <= 1.0 {
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
            let from = self.unknowns(state);
            tried = self.advance_together(model, state, &here, start.dt, report)?;
            self.passes += 1;
            before = Some((from, here));
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
        if norm2(&state.displacement) > 0.0 && norm2(&state.pressure) > 0.0 {
            self.unit = norm2(&state.displacement) / norm2(&state.pressure);
        }
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
