//! Steps in which rock breaks and fluid flows in what is broken, one after the other (Algorithm 3).
//!
//! The coefficients of flow are those of the fractures at the start of the step, and the strain of the last
//! step stands in for that of this one:
//!
//!   (S + B + a L) Δp = Δt (q − L p) − [QΔu]_last + B Δp_last,
//!
//! with a = 0 for explicit and a = Δt for semi-implicit steps. Then the solid relaxes at the new pressure.
//! B is the compliance of the fractures, see [`Compliance`]; without it, which is the form of the paper, a
//! full crack answers to its own opening with a pressure that is wrong a thousand times over.

use perifrac_solvers::norm2;

use super::compliance::Compliance;
use super::flow::{check_scene, close};
use crate::model::{FlowModel, Model};
use crate::plan::{Plan, SchemeChoice, SchemeOptions};
use crate::schemes::limits::lagged_limit;
use crate::schemes::quasi_static::{advance, growth};
use crate::schemes::{
    ImplicitSystem, Relaxation, Scheme, SchemeCounters, SolidSolver, State, StepError, StepLimit,
    StepReport, coupling_of, flow_of, solid_of,
};

/// Flow, then fracture, once a step.
pub struct LaggedFracture<const D: usize> {
    name: String,
    /// The matrix of flow; `None` for explicit steps.
    system: Option<ImplicitSystem>,
    solid: Box<dyn SolidSolver<D>>,
    options: SchemeOptions,
    compliance: Compliance,
    limit: Option<StepLimit>,
    /// Of the last accepted step and of the trial.
    last: Option<Lag>,
    trial: Option<Lag>,
    /// Largest rate of the pressure in the first steps, in the norm of the storage.
    usual: f64,
    steps: usize,
    products: u64,
}

/// What a step of `dt` seconds did.
struct Lag {
    dt: f64,
    /// Pa, shape `(n,)`.
    pressure: Vec<f64>,
    /// Pore volume gained by strain, m^D, shape `(n,)`.
    content: Vec<f64>,
}

/// Steps that show how fast pressures change in this scene.
const FIRST: usize = 5;
/// Growth over that which loads do not cause.
const UNSTABLE: f64 = 1e4;

impl<const D: usize> LaggedFracture<D> {
    /// Chooses the solver of flow, if there is one.
    ///
    /// # Errors
    /// [`StepError`] if it is refused, or if the scene has what this scheme cannot do.
    pub fn new(plan: &Plan, model: &Model<D>) -> Result<Self, StepError> {
        check_scene(plan, model)?;
        if coupling_of(model)?.undrained_start {
            return Err(StepError::Refused {
                scheme: plan.scheme.name(),
                reason: "fractures have no undrained start in it; set coupling.undrained_start = false, or \
                         use --scheme monolithic",
            });
        }
        let flow = flow_of(model)?;
        let system = match plan.scheme {
            SchemeChoice::Explicit => None,
            _ => Some(ImplicitSystem::new(&plan.stage_demand(), flow)?),
        };
        let solid = Box::new(Relaxation::new(plan.scheme_options));
        let integrator = if system.is_some() {
            "backward-euler"
        } else {
            "forward-euler"
        };
        Ok(LaggedFracture {
            name: format!(
                "{} ({integrator}, damage, {})",
                plan.scheme.name(),
                SolidSolver::<D>::name(&*solid)
            ),
            limit: system.is_none().then(|| lagged_limit(flow, &flow.capacity)),
            system,
            solid,
            options: plan.scheme_options,
            compliance: Compliance::default(),
            last: None,
            trial: None,
            usual: 0.0,
            steps: 0,
            products: 0,
        })
    }

    /// S + B per point, m^D/Pa.
    fn storage(&self, flow: &FlowModel<D>) -> Vec<f64> {
        let pairs = flow.capacity.iter().zip(&self.compliance.storage);
        pairs.map(|(s, b)| s + b).collect()
    }

    /// Brings coefficients, compliance and limit to the fractures of a state.
    fn follow(&mut self, model: &mut Model<D>, state: &State) -> Result<usize, StepError> {
        let solid = solid_of(model)?;
        let answer = solid
            .answer(&state.displacement, &state.walls, &state.history)
            .ok_or(StepError::Missing { part: "[damage]" })?;
        model.follow_fractures(&answer, &state.displacement, &state.walls);
        let (solid, relaxation) = (&mut self.solid, self.options.relaxation);
        let iterations = self.compliance.follow(model, state, relaxation, |raised| {
            solid.equilibrate(model, raised)
        })?;
        let flow = flow_of(model)?;
        if self.limit.is_some() {
            self.limit = Some(lagged_limit(flow, &self.storage(flow)));
        }
        if let Some(system) = &mut self.system {
            system.forget(flow);
        }
        Ok(iterations)
    }

    /// Moves the pressure of `trial` on by one step; gives the iterations of the linear solver.
    fn move_pressure(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<usize, StepError> {
        let flow = flow_of(model)?;
        let storage = self.storage(flow);
        let time = if self.system.is_some() {
            trial.time
        } else {
            old.time
        };
        let mut right = vec![0.0; flow.points()];
        flow.imbalance(time, &old.pressure, &mut right);
        self.products += 1;
        right.iter_mut().for_each(|r| *r *= dt);
        if let Some(last) = &self.last {
            let share = dt / last.dt;
            for (i, right) in right.iter_mut().enumerate() {
                let strain = self.compliance.storage[i] * last.pressure[i] - last.content[i];
                *right += share * strain;
            }
        }
        let mut change = vec![0.0; right.len()];
        flow.fix(trial.time, &old.pressure, &mut change);
        let iterations = match &mut self.system {
            Some(system) => {
                system.prepare(flow, &storage, dt, &[])?;
                system.solve(flow, &right, &mut change)?
            }
            None => {
                for (i, change) in change.iter_mut().enumerate() {
                    *change = right[i] / storage[i];
                }
                flow.fix(trial.time, &old.pressure, &mut change);
                0
            }
        };
        let pairs = trial.pressure.iter_mut().zip(&change);
        pairs.for_each(|(p, c)| *p += c);
        Ok(iterations)
    }

    /// Refuses pressures that run away.
    fn check(&mut self, model: &Model<D>, dt: f64, trial: &State) -> Result<(), StepError> {
        trial.check()?;
        let (Some(lag), flow) = (&self.trial, flow_of(model)?) else {
            return Ok(());
        };
        let terms = lag.pressure.iter().zip(&flow.capacity);
        let rate: Vec<f64> = terms.map(|(p, s)| p * s.sqrt() / dt).collect();
        let size = norm2(&rate);
        if self.steps < FIRST {
            self.usual = self.usual.max(size);
            return Ok(());
        }
        match size > UNSTABLE * self.usual {
            true => Err(StepError::CouplingUnstable {
                time: trial.time,
                growth: size / self.usual,
                relaxation: self.options.relaxation,
                strength: coupling_of(model)?.strength(&flow.capacity),
            }),
            false => Ok(()),
        }
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

    fn start(&mut self, model: &mut Model<D>, state: &mut State) -> Result<(), StepError> {
        flow_of(model)?.fix_values(state.time, &mut state.pressure);
        self.solid.equilibrate(model, state)?;
        advance(model, state);
        self.follow(model, state)?;
        Ok(())
    }

    fn step(
        &mut self,
        model: &mut Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport::default();
        trial.clone_from(old);
        trial.time = old.time + dt;
        report.iterations = self.follow(model, old)?;
        report.iterations += self.move_pressure(model, old, dt, trial)?;
        report.iterations += self.solid.equilibrate(model, trial)?;
        let step = trial.since(old);
        let content = model.content(&step.displacement, &step.walls);
        let pressure = step.pressure;
        self.trial = Some(Lag {
            dt,
            pressure,
            content,
        });
        self.check(model, dt, trial)?;
        let at = if self.system.is_some() { &*trial } else { old };
        close(model, old, trial, (dt, at), &mut report)?;
        advance(model, trial);
        report.growth = growth(model, old, trial);
        Ok(report)
    }

    fn accept(&mut self) {
        self.last = self.trial.take();
        self.steps += 1;
    }

    fn counters(&self) -> SchemeCounters {
        let solver = self.system.as_ref().map(|system| system.counters().clone());
        let own = self.solid.counters();
        SchemeCounters {
            products: own.products + self.products,
            solver: solver.unwrap_or_default(),
            ..own
        }
    }

    fn solver(&self) -> Option<(String, String)> {
        self.system.as_ref().map(|system| system.chosen().clone())
    }
}
