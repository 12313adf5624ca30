//! Steps in which rock breaks and fluid flows in what is broken, one after the other (Algorithm 3).
//!
//! The coefficients of flow are those of the fractures at the start of the step, and the strain of the last
//! step stands in for that of this one:
//!
//!   (S + B + a L) Δp = Δt (q − L p) − [QΔu]_last + B Δp_last,
//!
//! with a = 0 for explicit and a = Δt for semi-implicit steps. Then the solid relaxes at the new pressure.
//! Where that strain turns out to be no fair guess, both pass again, so that no fluid is lost.
//! B is the compliance of the fractures, see [`Compliance`]; without it, which is the form of the paper, a
//! full crack answers to its own opening with a pressure that is wrong a thousand times over.

use super::compliance::Compliance;
use super::flow::{StepStart, close, fill_broken};
use crate::model::{Model, Spreading};
use crate::plan::{Plan, SchemeChoice, SchemeOptions};
use crate::schemes::limits::lagged_limit;
use crate::schemes::memory::{Memory, Rates};
use crate::schemes::quasi_static::{advance, growth};
use crate::schemes::stage::{Stage, Target};
use crate::schemes::{
    ImplicitSystem, Relaxation, Scheme, SchemeCounters, SolidSolver, Staggered, State, StepError,
    StepLimit, StepReport, coupling_of, flow_of,
};

/// Flow, then fracture, until both agree.
pub struct LaggedFracture<const D: usize> {
    name: String,
    explicit: bool,
    passes: Staggered<D>,
    options: SchemeOptions,
    compliance: Compliance,
    limit: Option<StepLimit>,
    products: u64,
}

impl<const D: usize> LaggedFracture<D> {
    /// Chooses the solver of flow, if there is one.
    ///
    /// # Errors
    /// [`StepError`] if it is refused.
    pub fn new(plan: &Plan, model: &Model<D>) -> Result<Self, StepError> {
        let parts = (flow_of(model)?, coupling_of(model)?);
        let options = plan.scheme_options;
        let solid = Box::new(Relaxation::new(options));
        let motion = SolidSolver::<D>::name(&*solid);
        let explicit = plan.scheme == SchemeChoice::Explicit;
        let (integrator, passes) = match explicit {
            true => (
                "forward-euler",
                Staggered::pointwise(solid, parts, options, false),
            ),
            false => {
                let system = ImplicitSystem::new(&plan.stage_demand(), parts.0)?;
                let passes = Staggered::lagged(system, solid, parts, options);
                ("backward-euler", passes)
            }
        };
        let scheme = plan.scheme.name();
        Ok(LaggedFracture {
            name: format!("{scheme} ({integrator}, damage, {motion})"),
            limit: explicit.then(|| lagged_limit(parts.0, &parts.0.capacity)),
            explicit,
            passes,
            options,
            compliance: Compliance::default(),
            products: 0,
        })
    }

    /// Brings coefficients, compliance and limit to the fractures of a state.
    fn follow(&mut self, model: &mut Model<D>, state: &State) -> Result<usize, StepError> {
        let response = model
            .response(&state.view())
            .ok_or(StepError::MissingPart { part: "[damage]" })?;
        let fields = (&state.displacement[..], &state.walls[..]);
        model.follow_fractures(&response, fields, Spreading::Anew);
        let (solid, relaxation) = (self.passes.solid(), self.options.relaxation);
        let iterations = self.compliance.follow(model, state, relaxation, |raised| {
            solid.equilibrate(model, raised)
        })?;
        let flow = flow_of(model)?;
        self.passes.set_split(flow, &self.compliance.storage);
        if self.limit.is_some() {
            self.limit = Some(lagged_limit(flow, self.passes.storage()));
        }
        Ok(iterations)
    }

    /// Enters into a state the coefficients that led to it, and what the next step needs.
    fn remember(&self, now: &Model<D>, state: &mut State) {
        state.coefficients = now.coefficients();
        state.memory.compliance = self.compliance.measured;
        state.memory.limit.clone_from(&self.limit);
        Stage::remember(&self.passes, &mut state.memory);
    }
}

impl<const D: usize> Scheme<D> for LaggedFracture<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn local_order(&self) -> f64 {
        2.0
    }

    fn limit(&self) -> Option<&StepLimit> {
        self.limit.as_ref()
    }

    fn recall(&mut self, memory: &Memory) {
        self.compliance.measured = memory.compliance;
        if memory.limit.is_some() {
            self.limit.clone_from(&memory.limit);
        }
        Stage::recall(&mut self.passes, memory);
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        // At its pressure a crack that is taken over may run for ever; the first step brings it to new loads.
        if !model.has_fluid_in_cracks() {
            self.passes.solid().equilibrate(model, state)?;
            advance(model, state);
        }
        let mut now = model.clone();
        let response = now.crack_response(&state.view());
        fill_broken(&mut now, response.as_ref(), state, false);
        self.follow(&mut now, state)?;
        self.remember(&now, state);
        Ok(())
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        self.recall(&old.memory);
        let start = StepStart::new(model, old, dt);
        let mut now = model.clone();
        let mut report = StepReport {
            iterations: self.follow(&mut now, old)?,
            ..StepReport::default()
        };
        let model = &now;
        let end = old.time + dt;
        let (from, length) = match self.explicit {
            true => (old.time, 0.0),
            false => (end, dt),
        };
        let flow = flow_of(model)?;
        let mut moved = vec![0.0; flow.points()];
        flow.imbalance(from, &old.pressure, &mut moved);
        self.products += 1;
        moved.iter_mut().for_each(|rate| *rate *= dt);
        Stage::prepare(&mut self.passes, model, length)?;
        let target = Target {
            base: old,
            time: end,
            dt,
            slot: 0,
        };
        let step = self.passes.solve(model, target, moved, &mut report)?;
        trial.clone_from(old);
        trial.time = end;
        trial.set_sum(old, 1.0, &step);
        trial.check()?;
        check_boiling(model, trial)?;
        let at = if self.explicit { old } else { &*trial };
        let response = model.crack_response(&trial.view());
        let response = response.as_ref();
        close(model, &start, (trial, response), (dt, at), &mut report)?;
        advance(model, trial);
        report.growth = growth(model, old, trial);
        report.error = Rates::judge(model, response, (old, trial), dt)?;
        fill_broken(&mut now, response, trial, true);
        check_voids(&now, trial.time)?;
        self.remember(&now, trial);
        Ok(report)
    }

    fn counters(&self) -> SchemeCounters {
        let own = Stage::counters(&self.passes);
        SchemeCounters {
            products: own.products + self.products,
            ..own
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        Stage::solver(&self.passes)
    }
}

/// Refuses a pressure in cracks at which the fluid would boil by more than rounding, as nothing here holds a void.
fn check_boiling<const D: usize>(model: &Model<D>, state: &State) -> Result<(), StepError> {
    let Some((lowest, limit)) = model.lowest_in_cracks(&state.pressure) else {
        return Ok(());
    };
    match lowest < limit - ROUNDING * model.level {
        true => Err(StepError::Cavitation {
            time: state.time,
            pressure: lowest,
            limit,
        }),
        false => Ok(()),
    }
}

/// Refuses points of cracks without fluid, as nothing here fills them.
fn check_voids<const D: usize>(model: &Model<D>, time: f64) -> Result<(), StepError> {
    match model.voids().keys().next() {
        Some(point) => Err(StepError::UnsupportedVoid {
            time,
            at: (model.cloud.position[*point as usize].iter().copied()).collect(),
        }),
        None => Ok(()),
    }
}

/// Pressure below the limit that is none, relative to the largest that the data name: what relaxation leaves.
const ROUNDING: f64 = 1e-7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Setup;

    const PUMPED: &str = r#"title = "A crack in which fluid boils"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
fluid.viscosity = "1 mPa s"
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2", permeability = "1e-20 m^2", storage = "1e-10 1/Pa", biot_coefficient = 0 }
mechanics.boundary = { left = { clamped = true }, right = { clamped = true } }
flow.initial_pressure = "1 MPa"
damage = {}
fracture_flow = {}
coupling.undrained_start = false
scheme.name = "semi-implicit"
time.end = "1 s"
[cracks.main]
kind = "damaged"
points = [["0.3 m", "0.5 m"], ["0.7 m", "0.5 m"]]
injection = { rate = "1e-6 m^2/s", at = ["0.5 m", "0.5 m"] }
"#;

    /// Only pressures in cracks count, and only from rounding on.
    #[test]
    fn a_pressure_in_a_crack_at_which_fluid_boils_is_refused()
    -> Result<(), Box<dyn std::error::Error>> {
        let plan = Setup::text(PUMPED).plan()?;
        let mut model = Model::<2>::of(&plan)?;
        let mut state = State::initial(&model);
        let response = model.crack_response(&state.view());
        fill_broken(&mut model, response.as_ref(), &mut state, false);
        let (wet, dry): (Vec<usize>, Vec<usize>) =
            (0..model.cloud.len()).partition(|i| model.filled_points().any(|wet| wet == *i));
        assert!(wet.len() >= 8, "{wet:?}");
        state.pressure[dry[0]] = -1e6;
        state.pressure[wet[0]] = -1e-9;
        check_boiling(&model, &state)?;
        check_voids(&model, 0.0)?;
        model.boil(&[false; 100], &mut state.pressure);
        let refused = check_voids(&model, 0.0).map_err(|error| error.to_string());
        assert!(refused.is_err_and(|error| error.contains("holds no voids")));
        state.pressure[wet[0]] = -1e6;
        let refused = check_boiling(&model, &state);
        assert!(
            matches!(refused, Err(StepError::Cavitation { pressure, .. }) if (pressure + 1e6).abs() < 1.0)
        );
        Ok(())
    }
}
