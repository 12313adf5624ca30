//! Forward Euler for the pressure (Eq. 62, with the same operator as the implicit schemes).

use perifrac_solvers::norm2;
use rayon::prelude::*;

use super::{Scheme, SchemeCounters, State, StepError, StepLimit, StepReport, diffusion_limit};
use crate::model::{FlowModel, Model, exchange};

/// Forward Euler.
pub struct ForwardEuler {
    limit: StepLimit,
    counters: SchemeCounters,
    /// Rate q, kept while all loads are constant.
    rate: Vec<f64>,
    constant: bool,
    rate_time: Option<f64>,
    watch: Watch,
}

/// Watches the imbalance ‖q − L p‖ in the C⁻¹ norm. Stable steps never let it grow by more than the
/// loads change, so growth means instability, long before values overflow.
#[derive(Debug, Default)]
struct Watch {
    steps: usize,
    largest: f64,
}

/// Steps between two looks.
const INTERVAL: usize = 32;
/// Growth over the largest legitimate imbalance that counts as unstable.
const UNSTABLE: f64 = 10.0;

impl ForwardEuler {
    /// Scheme with the stability limit of the model.
    pub fn new<const D: usize>(model: &Model<D>) -> Self {
        ForwardEuler {
            limit: diffusion_limit(&model.flow),
            counters: SchemeCounters::default(),
            rate: vec![0.0; model.flow.points()],
            constant: model.flow.is_constant(),
            rate_time: None,
            watch: Watch::default(),
        }
    }

    fn update_rate<const D: usize>(&mut self, flow: &FlowModel<D>, time: f64) {
        if self.rate_time.is_none() || !self.constant {
            flow.rate(time, &mut self.rate);
            self.rate_time = Some(time);
        }
    }

    fn check<const D: usize>(
        &mut self,
        flow: &FlowModel<D>,
        old: &State,
        trial: &State,
        dt: f64,
    ) -> Result<(), StepError> {
        self.watch.steps += 1;
        let due = self.watch.steps == 1 || self.watch.steps.is_multiple_of(INTERVAL);
        // Beyond the limit a few steps are enough to ruin everything: look at each.
        if !due && dt <= self.limit.dt {
            return Ok(());
        }
        if let Some(point) = trial.pressure.iter().position(|p| !p.is_finite()) {
            return Err(StepError::NotFinite {
                point,
                time: trial.time,
            });
        }
        // C (p₁ − p₀)/Δt is the imbalance; its C⁻¹ norm is that of √C (p₁ − p₀)/Δt.
        let change: Vec<f64> = (trial.pressure.iter().zip(&old.pressure).zip(&flow.capacity))
            .map(|((new, old), capacity)| (new - old) * capacity.sqrt() / dt)
            .collect();
        let size = norm2(&change);
        if self.watch.steps == 1 || !self.constant {
            self.watch.largest = self.watch.largest.max(size);
        }
        // Varying loads raise the imbalance by themselves; only growth beyond reason counts there.
        let reference = if self.constant { UNSTABLE } else { 1e6 } * self.watch.largest;
        if size > reference && dt > self.limit.dt {
            let growth = size / self.watch.largest;
            return Err(StepError::Unstable {
                time: trial.time,
                growth,
                dt,
                limit: self.limit.dt,
            });
        }
        Ok(())
    }
}

/// p₁ = p₀ + Δt C⁻¹ (q − L p₀) in one pass over the matrix.
fn advance<const D: usize>(
    flow: &FlowModel<D>,
    rate: &[f64],
    (time, dt): (f64, f64),
    old: &[f64],
    new: &mut [f64],
) {
    let (pattern, conductance) = (&flow.pattern, &flow.conductance);
    new.par_iter_mut()
        .enumerate()
        .with_min_len(1024)
        .for_each(|(row, new)| {
            let imbalance = rate[row] - exchange(pattern, conductance, old, row);
            *new = old[row] + dt * imbalance / flow.capacity[row];
        });
    for wall in &flow.walls {
        wall.each_rate(time, old, |point, rate| {
            new[point] += dt * rate / flow.capacity[point]
        });
    }
}

impl<const D: usize> Scheme<D> for ForwardEuler {
    fn name(&self) -> &'static str {
        "explicit (forward-euler)"
    }

    fn local_order(&self) -> f64 {
        2.0
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
        let flow = &model.flow;
        self.update_rate(flow, old.time);
        advance(
            flow,
            &self.rate,
            (old.time, dt),
            &old.pressure,
            &mut trial.pressure,
        );
        self.counters.products += 1;
        trial.time = old.time + dt;
        let mut flows = crate::report::Flows::default();
        flows.add(dt, &flow.flows(&old.pressure, old.time));
        for fixed in &flow.fixed {
            let free = trial.pressure[fixed.point];
            trial.pressure[fixed.point] = flow.fixed_loads[fixed.load].at(trial.time);
            flows.fixed += (trial.pressure[fixed.point] - free) * flow.capacity[fixed.point];
        }
        self.check(flow, old, trial, dt)?;
        Ok(StepReport {
            iterations: 0,
            error: None,
            flows,
        })
    }

    fn counters(&self) -> SchemeCounters {
        self.counters.clone()
    }
}
