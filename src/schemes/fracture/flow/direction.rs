//! Where the potential falls, and how far.

use perifrac_solvers::{dot, multiply};

use super::{FractureFlowStep, Trial};
use crate::material::TangentKind;
use crate::model::Model;
use crate::schemes::fracture::closing::{NEXT_TO_HERE, keep_broken};
use crate::schemes::fracture::damage_of;
use crate::schemes::fracture::line_search::{LineSearch, line_search};
use crate::schemes::{Increment, State, StepError, StepReport, coupling_of, flow_of, solid_of};

/// Residual of the linear systems of the displacement alone, relative to the forces out of balance.
const FORCING_ALONE: f64 = 1e-2;
/// Change of the potential, relative to the energy, that is rounding error.
const ROUNDING: f64 = 1e-13;

/// A straight way from a balanced pressure to another.
pub(super) struct SearchDirection {
    displacement: Vec<f64>,
    pressure: Vec<f64>,
    /// Slope and half the curvature of ½ pᵀMp along it.
    bend: [f64; 2],
}

impl<const D: usize> FractureFlowStep<D> {
    /// Brings the tangents to a trial.
    fn follow_tangent(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        softening: TangentKind,
    ) -> Result<(), StepError> {
        let solid = solid_of(model)?;
        let (response, damage) = (&at.response, damage_of(solid)?);
        let fields = state.view().damage(&response.fluid);
        self.tangent
            .update(solid, damage, fields, response, softening);
        Ok(())
    }

    /// Changes of displacement and pressure that balance forces and fluid as far as the tangent tells; `mass`
    /// is what points must still take up, m^D, empty where that is nothing. `None` where fields take turns.
    pub(super) fn solve_together(
        &mut self,
        model: &Model<D>,
        state: &State,
        (at, mass): (&Trial<D>, &[f64]),
        (dt, softening): (f64, TangentKind),
        report: &mut StepReport,
    ) -> Result<Option<Increment>, StepError> {
        self.follow_tangent(model, state, at, softening)?;
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let Some(block) = &mut self.block else {
            return Ok(None);
        };
        let tangent = &self.tangent;
        let fill = || {
            let parts = (coupling, model.cracks());
            block.fill(tangent.matrix.data(), solid, flow, parts, dt);
            if let Some(cracks) = model.cracks() {
                block.add_cracks(solid, cracks, coupling, tangent, &at.response);
                block.hold_pressures(model.void_points());
            }
        };
        model.timers.time("assembly", fill);
        let (width, scale) = (D + 1, block.layout.scale);
        let mut rhs = vec![0.0; block.matrix.rows()];
        for (own, force) in rhs.chunks_mut(width).zip(at.force.chunks(D)) {
            own[..D].copy_from_slice(force);
        }
        for (own, mass) in rhs.chunks_mut(width).zip(mass) {
            own[D] = -scale * mass;
        }
        let mut x = vec![0.0; rhs.len()];
        let solver = &mut *self.solver;
        let matrix = block.matrix.view();
        report.iterations += (self.reuse).solve(solver, matrix, &rhs, &mut x, self.forcing)?;
        let unknowns = x.chunks(width);
        Ok(Some(Increment {
            displacement: unknowns.clone().flat_map(|own| own[..D].to_vec()).collect(),
            pressure: unknowns.map(|own| scale * own[D]).collect(),
            walls: Vec::new(),
        }))
    }

    /// Change of the displacement alone that balances the forces as far as the tangent tells, m.
    fn solve_alone(
        &mut self,
        force: &[f64],
        report: &mut StepReport,
    ) -> Result<Vec<f64>, StepError> {
        let matrix = self.tangent.matrix.view();
        let mut displacement = vec![0.0; force.len()];
        let solver = &mut *self.solver;
        report.iterations +=
            (self.reuse).solve(solver, matrix, force, &mut displacement, FORCING_ALONE)?;
        Ok(displacement)
    }

    /// Solution of the linear system at a trial whose pressure is balanced.
    fn solution(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        dt: f64,
        softening: TangentKind,
        report: &mut StepReport,
    ) -> Result<SearchDirection, StepError> {
        let both = self.solve_together(model, state, (at, &[]), (dt, softening), report)?;
        let Some(Increment {
            displacement,
            pressure,
            ..
        }) = both
        else {
            // The pressure stands still and is brought to the displacement in the next pass.
            return Ok(SearchDirection {
                displacement: self.solve_alone(&at.force, report)?,
                pressure: vec![0.0; state.pressure.len()],
                bend: [0.0; 2],
            });
        };
        let flow = flow_of(model)?;
        // ½ pᵀMp is that of the free pressures; the push of the prescribed ones is a load.
        let free = |i: usize, value: f64| if self.is_fixed[i] { 0.0 } else { value };
        let product = |p: &[f64]| {
            let free_p: Vec<f64> = (0..p.len()).map(|i| free(i, p[i])).collect();
            let mut result = vec![0.0; p.len()];
            multiply(flow.matrix(), &free_p, &mut result);
            let held = |i: usize| dt * result[i] + flow.capacity[i] * free_p[i];
            (0..p.len()).map(|i| free(i, held(i))).collect::<Vec<f64>>()
        };
        let along = product(&pressure);
        let bend = [dot(&along, &state.pressure), 0.5 * dot(&along, &pressure)];
        Ok(SearchDirection {
            displacement,
            pressure,
            bend,
        })
    }

    /// Direction in which the potential falls, with its tangent.
    pub(super) fn direction(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        dt: f64,
        imbalance: f64,
        report: &mut StepReport,
    ) -> Result<(SearchDirection, TangentKind), StepError> {
        let softening = self.policy.next(imbalance);
        let solved = self.solution(model, state, at, dt, softening, report);
        if softening != TangentKind::Consistent {
            return Ok((solved?, softening));
        }
        if let Ok(way) = solved
            && dot(&at.force, &way.displacement) > 0.0
        {
            return Ok((way, softening));
        }
        self.policy.failed();
        self.reuse.forget();
        let way = self.solution(model, state, at, dt, TangentKind::Bounded, report)?;
        Ok((way, TangentKind::Bounded))
    }

    /// Walks along a way until the potential has fallen enough; `None` if it does not.
    pub(super) fn search(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        at: &Trial<D>,
        way: &SearchDirection,
    ) -> Result<Option<LineSearch<Trial<D>>>, StepError> {
        let external = self.external(model, state);
        let (start, balanced) = (state.displacement.clone(), state.pressure.clone());
        let place = |state: &mut State, length: f64| {
            let step = |to: &mut Vec<f64>, from: &[f64], by: &[f64]| {
                to.clear();
                to.extend(from.iter().zip(by).map(|(from, by)| from + length * by));
            };
            step(&mut state.displacement, &start, &way.displacement);
            step(&mut state.pressure, &balanced, &way.pressure);
        };
        let work = dot(&external, &way.displacement);
        let shares = &at.response.hourglass;
        let high = at.response.energy(shares);
        let slope = dot(&at.force, &way.displacement);
        let reached = line_search(slope, ROUNDING * high.abs(), |length| {
            place(state, length);
            let found = self.evaluate(model, state)?;
            let flow = length * (way.bend[0] + length * way.bend[1]);
            Ok(LineSearch {
                length,
                fallen: high - found.response.energy(shares) + length * work - flow,
                left: dot(&found.force, &way.displacement),
                found,
            })
        })?;
        place(
            state,
            reached.as_ref().map_or(0.0, |reached| reached.length),
        );
        Ok(reached)
    }

    /// Keeps the damage that opening brought to points that close next to where a way begins; whether there are any.
    pub(super) fn keep_what_broke(
        &mut self,
        model: &Model<D>,
        state: &mut State,
        at: &Trial<D>,
        way: &SearchDirection,
    ) -> Result<bool, StepError> {
        let (displacement, pressure) = (state.displacement.clone(), state.pressure.clone());
        let step = |to: &mut Vec<f64>, by: &[f64]| {
            to.iter_mut()
                .zip(by)
                .for_each(|(to, by)| *to += NEXT_TO_HERE * by);
        };
        step(&mut state.displacement, &way.displacement);
        step(&mut state.pressure, &way.pressure);
        let there = self.evaluate(model, state)?;
        (state.displacement, state.pressure) = (displacement, pressure);
        Ok(keep_broken(
            &at.response,
            &there.response,
            &mut state.history,
        ))
    }

    /// Loads, and the push of pressures that do not change along a way.
    fn external(&self, model: &Model<D>, state: &State) -> Vec<f64> {
        let still = |i: usize| self.block.is_none() || self.is_fixed[i];
        let prescribed = |i: usize| if still(i) { state.pressure[i] } else { 0.0 };
        let pressure: Vec<f64> = (0..state.pressure.len()).map(prescribed).collect();
        model.external_force(state.time, &pressure)
    }
}
