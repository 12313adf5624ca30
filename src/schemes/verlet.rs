//! Dynamics by velocity Verlet (Algorithm 1), with the pressure between drift and kick.
//!
//! Positions at the end of the step are known before the forces there, so the pressure can take the
//! strain of this very step (Eq. 62 as printed), and nothing lags.

use super::memory::Timed;
use super::relaxation::Relaxation;
use super::solid::SolidSolver;
use super::start::ExplicitStart;
use super::{
    ImplicitSystem, Memory, Scheme, SchemeCounters, State, StepError, StepLimit, StepReport,
    flow_of, solid_of,
};
use crate::model::{Model, SHARE, SolidModel, undrained_modulus};
use crate::plan::{Plan, SchemeOptions, SolidMethod};

/// Velocity Verlet.
pub struct Verlet {
    limit: StepLimit,
    name: &'static str,
    /// Implicit flow, if the scheme is semi-implicit.
    flow: Option<ImplicitSystem>,
    /// The equilibrium to start from, where inertia does not matter, and what relaxes to it.
    start: Option<(ExplicitStart, Relaxation)>,
    products: u64,
}

impl Verlet {
    /// Scheme for a model with inertia; `flow` makes the pressure implicit, otherwise it is explicit.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without mechanics.
    pub fn new<const D: usize>(
        model: &Model<D>,
        flow: Option<ImplicitSystem>,
    ) -> Result<Self, StepError> {
        let mut limit = wave_limit(model, solid_of(model)?);
        if let (Some(own), None) = (&model.flow, &flow) {
            let diffusion = super::diffusion_limit(own, &own.capacity);
            if diffusion.dt < limit.dt {
                limit = diffusion;
            }
        }
        Ok(Verlet {
            limit,
            name: match (&model.flow, &flow) {
                (None, _) => "explicit (verlet)",
                (Some(_), None) => "explicit (forward-euler, verlet)",
                (Some(_), Some(_)) => "semi-implicit (backward-euler, verlet)",
            },
            flow,
            start: None,
            products: 0,
        })
    }

    /// The same for a model whose mass is scaled, from the equilibrium that the scene asks for.
    #[must_use]
    pub fn with_scaled_mass<const D: usize>(mut self, plan: &Plan, model: &Model<D>) -> Self {
        let options = SchemeOptions {
            solid: SolidMethod::Adr,
            ..plan.scheme_options
        };
        self.name = "explicit (forward-euler, verlet, scaled mass)";
        self.start = Some((ExplicitStart::new(plan, model), Relaxation::new(options)));
        self
    }

    fn accelerations<const D: usize>(
        &mut self,
        model: &Model<D>,
        solid: &SolidModel<D>,
        state: &State,
    ) -> Vec<f64> {
        let (mut force, _) = model.unbalanced(state.time, &state.view());
        self.products += 1;
        for (point, mass) in solid.mass.iter().enumerate() {
            force[point * D..(point + 1) * D]
                .iter_mut()
                .for_each(|f| *f /= mass);
        }
        force
    }

    /// Pressure at the end of the step for the strain content gained in it.
    fn flow_step<const D: usize>(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let flow = flow_of(model)?;
        let step = trial.since(old);
        let content = model.content(&step.displacement, &step.walls);
        let mut imbalance = vec![0.0; content.len()];
        let at = if self.flow.is_some() {
            trial.time
        } else {
            old.time
        };
        flow.imbalance(at, &old.pressure, &mut imbalance);
        let rhs: Vec<f64> = imbalance
            .iter()
            .zip(&content)
            .map(|(r, c)| dt * r - c)
            .collect();
        let mut change = vec![0.0; rhs.len()];
        match &mut self.flow {
            None => {
                for (change, (rhs, own)) in change.iter_mut().zip(rhs.iter().zip(&flow.capacity)) {
                    *change = rhs / own;
                }
                flow.fix(trial.time, &old.pressure, &mut change);
            }
            Some(system) => {
                flow.fix(trial.time, &old.pressure, &mut change);
                system.prepare(flow, &flow.capacity, dt, &[])?;
                report.iterations += system.solve(flow, &rhs, &mut change)?;
            }
        }
        let moved = old.pressure.iter().zip(&change).map(|(o, c)| o + c);
        trial.pressure.clear();
        trial.pressure.extend(moved);
        // Fluxes of the pressure that the step used.
        let used = if self.flow.is_some() {
            flow.imbalance(at, &trial.pressure, &mut imbalance);
            &trial.pressure
        } else {
            &old.pressure
        };
        report.flows.add(dt, &flow.flows(used, at));
        let gain = |i: usize| flow.capacity[i] * change[i] + content[i] - dt * imbalance[i];
        for fixed in &flow.fixed {
            report.flows.hold(fixed.load, gain(fixed.point));
        }
        Ok(())
    }
}

/// Eqs. 60 and 61 with the undrained modulus λ + 2μ + α²/s where fluid resists.
fn wave_limit<const D: usize>(model: &Model<D>, solid: &SolidModel<D>) -> StepLimit {
    let cloud = &model.cloud;
    let step = |point: usize| {
        let fluid = model.coupling.as_ref().zip(model.flow.as_ref());
        let modulus = undrained_modulus(cloud, solid, fluid, point);
        let density = solid.mass[point] / cloud.volume[point];
        SHARE * cloud.spacing(point) * (density / modulus).sqrt()
    };
    let point = (0..cloud.len())
        .min_by(|&a, &b| step(a).total_cmp(&step(b)))
        .unwrap_or(0);
    StepLimit {
        dt: step(point),
        reason: "waves (Eqs. 60 and 61, undrained modulus)".into(),
        point,
        position: cloud.position[point].iter().copied().collect(),
    }
}

impl<const D: usize> Scheme<D> for Verlet {
    fn name(&self) -> &str {
        self.name
    }

    fn recall(&mut self, memory: &Memory) {
        if let Some(system) = &mut self.flow {
            system.recall(memory);
        }
    }

    fn local_order(&self) -> f64 {
        2.0
    }

    fn start(&mut self, model: &Model<D>, state: &mut State) -> Result<(), StepError> {
        match &mut self.start {
            Some((start, relaxation)) => start.start(model, relaxation, state),
            None => Ok(()),
        }
    }

    fn limit(&self) -> Option<&StepLimit> {
        Some(&self.limit)
    }

    fn step(
        &mut self,
        model: &Model<D>,
        old: &State,
        dt: f64,
        trial: &mut State,
    ) -> Result<StepReport, StepError> {
        Scheme::<D>::recall(self, &old.memory);
        let solid = solid_of(model)?;
        let mut report = StepReport::default();
        let known = old.memory.acceleration.as_ref();
        let start = match known.and_then(|known| known.at(old.time)) {
            Some(acceleration) => acceleration.to_vec(),
            None => self.accelerations(model, solid, old),
        };
        trial.clone_from(old);
        trial.time = old.time + dt;
        trial
            .velocity
            .iter_mut()
            .zip(&start)
            .for_each(|(v, a)| *v += 0.5 * dt * a);
        let drift = trial.displacement.iter_mut().zip(&trial.velocity);
        drift.for_each(|(u, v)| *u += dt * v);
        solid.place_walls(trial.time, &mut trial.walls);
        if model.flow.is_some() {
            self.flow_step(model, old, dt, trial, &mut report)?;
        }
        let end = self.accelerations(model, solid, trial);
        trial
            .velocity
            .iter_mut()
            .zip(&end)
            .for_each(|(v, a)| *v += 0.5 * dt * a);
        trial.check()?;
        trial.memory.acceleration = Some(Timed {
            time: trial.time,
            values: end,
        });
        if let Some(system) = &self.flow {
            system.remember(&mut trial.memory);
        }
        Ok(report)
    }

    fn counters(&self) -> SchemeCounters {
        let mut counters = SchemeCounters {
            products: self.products,
            solver: self
                .flow
                .as_ref()
                .map(|flow| flow.counters().clone())
                .unwrap_or_default(),
            ..SchemeCounters::default()
        };
        if let Some((start, relaxation)) = &self.start {
            counters.add(start.counters());
            counters.add(&SolidSolver::<3>::counters(relaxation));
        }
        counters
    }

    fn solver(&self) -> Option<(String, String)> {
        self.flow.as_ref().map(|flow| flow.chosen().clone())
    }
}
