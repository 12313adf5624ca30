//! Passes of displacement and pressure together, in the split model.
//!
//! The pressure in a crack and the displacement belong to one potential, smallest over displacements and largest
//! over pressures. Every pass solves its linear system with the damage, the normals and the wet points as they are:
//! such a pass never leads up, as the potential at fixed damage lies above. Near the end the exact tangent, with the
//! damage eliminated, is tried instead. The residual covers the forces and the mass, with the content of pores and
//! cracks as a function of the state.

use super::{FractureFlowStep, StepStart};
use crate::material::TangentKind;
use crate::model::{Model, Spreading, Voids};
use crate::plan::DescentSettings;
use crate::schemes::descent::{Advance, Direction, PassMonitor, Passes, Residuals, Trial};
use crate::schemes::{State, StepError, flow_of};

/// Where a pass stands.
pub(super) struct Iterate<const D: usize> {
    at: Trial<D>,
    /// What points must still take up, m^D.
    mass: Vec<f64>,
    /// Voids in cracks, m^D.
    voids: Voids,
    /// What is out of balance.
    left: Residuals,
    /// Whether the pressure of cracks has come to act elsewhere, so that it does not compare with the place before.
    rewetted: bool,
}

/// Where the last pass started.
struct Departure<const D: usize> {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    place: Iterate<D>,
    /// The tangent of the pass.
    tried: TangentKind,
}

impl<const D: usize> Departure<D> {
    /// Share of the pass to leave where it made all forces very much larger; `None` where it did not. The tangent of a
    /// closed crack knows nothing of how far it opens: what is pumped into it would be squeezed into its pores, and from
    /// where that leads passes return by any way.
    fn strayed(&self, to: &Iterate<D>, settings: &DescentSettings) -> Option<f64> {
        let grown = to.at.scale / self.place.at.scale;
        (grown > settings.force_growth && grown.is_finite()).then(|| grown.recip())
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

/// Passes of both fields.
pub(super) struct CoupledPasses<'a, const D: usize> {
    step: &'a mut FractureFlowStep<D>,
    /// The model with the coefficients of the last place.
    model: &'a mut Model<D>,
    start: &'a StepStart<'a>,
    before: Option<Departure<D>>,
    /// How far the pressure of cracks may reach in the next pass; no further once it was taken back.
    spreading: Option<Spreading>,
}

impl<'a, const D: usize> CoupledPasses<'a, D> {
    /// Before the first pass, with the model at the coefficients of the step's start.
    pub(crate) fn new(
        step: &'a mut FractureFlowStep<D>,
        model: &'a mut Model<D>,
        start: &'a StepStart<'a>,
    ) -> Self {
        CoupledPasses {
            step,
            model,
            start,
            before: None,
            spreading: Some(Spreading::Anew),
        }
    }

    fn settings(&self) -> &DescentSettings {
        &self.step.descent.settings
    }

    /// Whether a pass with the exact tangent left too much of the forces out of balance, or of all where passes make no
    /// progress: near balance they may go round in circles of two to five for good.
    fn led_astray(&self, from: &Iterate<D>, to: &Iterate<D>, monitor: &PassMonitor) -> bool {
        let (tolerance, share) = (
            self.step.plan.tolerance,
            self.settings().sufficient_reduction,
        );
        let off = |place: &Iterate<D>| monitor.off(&place.left);
        let circles = monitor.is_stuck() && off(to) > share * off(from);
        circles || to.left.forces > tolerance.max(share * from.left.forces)
    }

    /// A trial at a state, with the forces it leaves out of balance relative to all.
    fn try_at(&mut self, state: &State) -> Result<(Trial<D>, f64), StepError> {
        let at = Trial::of(self.model, state)?;
        self.step.descent.searches += 1;
        let forces = at.imbalance(self.step.scale(), state)?;
        Ok((at, forces))
    }

    /// Brings coefficients to the state and measures what is out of balance.
    fn measure(&mut self, state: &mut State) -> Result<Iterate<D>, StepError> {
        self.boil(state);
        let (mut at, mut forces) = self.try_at(state)?;
        let mut rewetted = false;
        // Far from balance a pass may break much that does not stay so: nothing becomes wet by it.
        if let Some(spreading) = self.spreading
            && forces <= self.settings().near_balance
        {
            let before = self.model.wet_points();
            let fields = (&state.displacement[..], &state.walls[..]);
            self.spreading = Some(Spreading::Further);
            self.model.follow_fractures(&at.response, fields, spreading);
            rewetted = before != self.model.wet_points();
            let boils = self.boil(state);
            if rewetted || boils {
                (at, forces) = self.try_at(state)?;
            }
        } else {
            self.model.follow_openings(&at.response);
        }
        let (model, start) = (&mut *self.model, self.start);
        let (mass, taken) = self.step.mass_residual(model, start, state, &at.response)?;
        let moved = self.moved(state, taken)?;
        let owed = mass.iter().map(|m| m.abs()).sum::<f64>() / moved;
        Ok(Iterate {
            at,
            mass,
            voids: self.model.voids(),
            left: Residuals {
                forces,
                mass: owed,
                allowed: [self.settings().mass_tolerance; 2],
            },
            rewetted,
        })
    }

    fn boil(&mut self, state: &mut State) -> bool {
        self.model
            .boil(&self.step.system.is_fixed, &mut state.pressure)
    }

    /// Goes back to where a pass started, with the coefficients that it had.
    fn return_to(&mut self, state: &mut State, from: Departure<D>) -> Iterate<D> {
        (state.displacement, state.pressure) = (from.displacement, from.pressure);
        self.model.follow_openings(&from.place.at.response);
        self.model.set_voids(&from.place.voids);
        from.place
    }

    /// Scale of the fluid that moves in a step in which points took up `taken` (Σ of absolutes), m^D. What strain and
    /// pressure move in opposite ways counts as well, and rounding of all that is held.
    fn moved(&self, state: &State, taken: f64) -> Result<f64, StepError> {
        let flow = flow_of(self.model)?;
        let size = |values: &[f64]| values.iter().map(|value| value.abs()).sum::<f64>();
        let step = state.since(self.start.state);
        let strained = size(&self.model.content(&step.displacement, &step.walls));
        let pairs = flow.capacity.iter().zip(&step.pressure);
        let squeezed: f64 = pairs.map(|(capacity, p)| (capacity * p).abs()).sum();
        let gross = self.start.dt * flow.flows(&state.pressure, state.time).gross;
        let settings = self.settings();
        let rounding = settings.mass_rounding / settings.mass_tolerance * size(&self.start.held);
        let moved = taken + strained + squeezed + gross;
        Ok(moved.max(rounding).max(f64::MIN_POSITIVE))
    }

    /// Solves the linear system of both fields; gives its tangent.
    fn solve(
        &mut self,
        state: &State,
        here: &Iterate<D>,
    ) -> Result<(Direction, TangentKind), StepError> {
        // At fixed damage a pass never leads up; with a part of the softening it may.
        let mut tangent = match self.step.descent.policy.next(here.left.forces) {
            TangentKind::Bounded => TangentKind::Secant,
            tangent => tangent,
        };
        let (model, dt, from) = (&*self.model, self.start.dt, (&here.at, &here.mass[..]));
        let system = &mut self.step.system;
        let mut solved = system.solve_together(model, state, from, (dt, tangent));
        if tangent == TangentKind::Consistent && solved.is_err() {
            self.step.descent.policy.failed();
            tangent = TangentKind::Secant;
            solved = system.solve_together(model, state, from, (dt, tangent));
        }
        Ok((solved?, tangent))
    }
}

impl<const D: usize> Passes<D> for CoupledPasses<'_, D> {
    type Iterate = Iterate<D>;

    fn place(
        &mut self,
        state: &mut State,
        _found: Option<Trial<D>>,
        monitor: &PassMonitor,
    ) -> Result<(Iterate<D>, Residuals), StepError> {
        let mut here = self.measure(state)?;
        if let Some(from) = &self.before
            && let Some(share) = from.strayed(&here, &self.step.descent.settings)
        {
            from.shorten(state, share);
            here = self.measure(state)?;
        }
        // The exact tangent may have led astray.
        if let Some(from) = self.before.take()
            && from.tried == TangentKind::Consistent
            && !here.rewetted
            && self.led_astray(&from.place, &here, monitor)
        {
            self.step.descent.policy.failed();
            here = self.return_to(state, from);
        }
        let left = here.left;
        Ok((here, left))
    }

    fn trial<'a>(&self, place: &'a Iterate<D>) -> &'a Trial<D> {
        &place.at
    }

    fn check(&self, state: &State, place: &Iterate<D>) -> Result<(), StepError> {
        self.step
            .check_run(self.model, self.start, state, &place.at)
    }

    fn takes_back(&mut self, place: &Iterate<D>) -> bool {
        let withdrawn = self.model.withdraw_fluid(&place.at.response);
        if withdrawn {
            (self.spreading, self.before) = (None, None);
        }
        withdrawn
    }

    fn advance(
        &mut self,
        state: &mut State,
        place: Iterate<D>,
        _monitor: &PassMonitor,
    ) -> Result<Advance<D>, StepError> {
        let (displacement, pressure) = (state.displacement.clone(), state.pressure.clone());
        let (change, tried) = self.solve(state, &place)?;
        let add = |to: &mut [f64], by: &[f64]| to.iter_mut().zip(by).for_each(|(t, b)| *t += b);
        add(&mut state.displacement, &change.displacement);
        add(&mut state.pressure, &change.pressure);
        self.step.passes += 1;
        self.before = Some(Departure {
            displacement,
            pressure,
            place,
            tried,
        });
        Ok(Advance::Moved)
    }
}
