//! The end of a run: errors against the exact solution, counters, summary.

use std::collections::BTreeMap;
use std::time::Instant;

use super::columns::{exact_openings, openings};
use super::summary::Name;
use super::summary::units;
use super::time_loop::{Effort, Run};
use super::{CouplingReport, FieldError, RunError, Summary, TimedErrors, WellReport};
use crate::geometry::{Families, Side, Vector};
use crate::model::{Faces, FlowModel};
use crate::parallel;
use crate::plan::{
    CrackKind, Plan, ReferenceKind, SchemeChoice, TimeMode, exact_displacement, exact_flux,
    exact_pressure, exact_well_pressure,
};
use crate::reference::{ErrorNorms, ExactDisplacement};
use crate::report::{Balance, Counters};
use crate::schemes::{Rejection, SchemeCounters, State};

/// Mass balance, relative to the turnover, that is worth a warning.
const POOR_BALANCE: f64 = 1e-8;
/// Rate of storage, relative to all rates, below which a transient counts as settled.
const SETTLED: f64 = 1e-4;
/// Overlap of a crack's faces, relative to their largest jump, that is worth a warning.
const OVERLAP: f64 = 1e-6;
/// Damage from which rock is no face of a crack any more.
const NO_FACE: f64 = 0.1;
/// Coupling safety factor of Eq. 71.
const COUPLING_SAFETY: f64 = 0.5;

impl<const D: usize> Run<'_, D> {
    pub(super) fn finish(
        mut self,
        (counters, solver, limit): Effort,
        wall: f64,
    ) -> Result<(Summary, State), RunError> {
        self.warn_of_imbalance();
        self.warn_of_failed_solves();
        self.warn_of_overlap();
        self.tell_of_thinning();
        self.show_end();
        let model = &self.model;
        let flow = model.flow.as_ref();
        let solid = model.solid.as_ref();
        let partition = model.subdomain().partition();
        let [bonds, nonzeros] = self.sizes();
        let prescribed = flow.map_or(0, |flow| flow.fixed.len());
        let mut summary = Summary {
            case: self.plan.case.clone(),
            version: env!("CARGO_PKG_VERSION").into(),
            scheme: self.scheme_name.clone(),
            solver: solver.as_ref().map(|(name, _)| name.clone()),
            solver_reason: solver.map(|(_, reason)| reason),
            operator: flow.map_or("none", |flow| flow.operator.name()).into(),
            dimension: D,
            processes: partition.map_or(1, |own| own.team().size()),
            thickness: (D == 2).then_some(self.plan.thickness),
            units: units(D, self.plan.time.mode),
            columns: Vec::new(),
            points: model.cloud.len(),
            unknowns: flow.map_or(0, FlowModel::points) - prescribed
                + solid.map_or(0, |solid| solid.unknowns()),
            bonds,
            nonzeros,
            second_hops: flow.map_or(0, |flow| flow.operator.second_hops()),
            steps: self.steps,
            rejected: self.rejections.total(),
            rejections: self.rejections.named(),
            wall_s: wall,
            t_end: self.state.time,
            limit,
            errors: self.last_errors(),
            errors_over_time: self.timed_errors.clone(),
            outflow: self.outflow().unwrap_or_default(),
            pressure_range: flow.map(|_| extremes(&self.state.pressure)),
            displacement_max: solid.map(|_| largest::<D>(&self.state.shown_displacement())),
            wells: self.wells(),
            coupling: self.coupling(&counters),
            results: self.plan.damage.map(|_| {
                let pumped = self.plan.thickness * self.balance.injected;
                self.tracker.results.clone().with_injected(pumped)
            }),
            balance: in_slab(self.plan, &self.balance),
            consistency: flow
                .and_then(|flow| flow.consistency)
                .or(solid.and_then(|solid| solid.consistency)),
            counters: self.counters(counters),
            timers: self.timers.clone(),
            warnings: self.warnings.clone(),
        };
        self.timers.end();
        if let Some(writer) = &mut self.writer {
            let start = Instant::now();
            let draw = || writer.finish(self.plan, &self.model, &self.tracker);
            let drawn = self.timers.time("plots", draw);
            self.agree(drawn)?;
            summary.wall_s += start.elapsed().as_secs_f64();
            if let Some(writer) = &self.writer {
                let told = writer.columns(self.plan);
                self.agree(told.map(|columns| summary.columns = columns))?;
                self.agree(writer.summary(&summary))?;
            }
        }
        Ok((summary, self.state))
    }

    /// Bonds and matrix entries of all processes.
    fn sizes(&self) -> [usize; 2] {
        let model = &self.model;
        let families = match (&model.flow, &model.solid) {
            (Some(flow), _) => Some(&flow.operator.neighbourhood().families),
            (None, solid) => solid.as_deref().map(|solid| &solid.elastic.around.families),
        };
        let own = |families: &Families<D>| -> usize {
            let points = (0..families.len()).filter(|point| families.share.owns(*point));
            points.map(|point| families.family(point).len()).sum()
        };
        let flow = model
            .flow
            .as_ref()
            .map_or(0, |flow| flow.pattern.nonzeros());
        let solid = model
            .solid
            .as_ref()
            .map_or(0, |solid| solid.stiffness.nnz());
        let mut sizes = [families.map_or(0, |f| own(f)), flow + solid].map(|size| size as f64);
        model.subdomain().sum(&mut sizes);
        sizes.map(|size| size as usize)
    }

    /// A balance this poor means that the linear systems are beyond what double precision resolves; where cracks hold
    /// fluid, steps are solved no better, and audits hold them to it.
    fn warn_of_imbalance(&mut self) {
        let mass = self.balance.mass;
        if mass <= POOR_BALANCE || self.model.has_crack_content() {
            return;
        }
        let coupled = self.model.coupling.is_some();
        let remedy = match self.plan.scheme {
            SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_) if coupled => {
                "strain lags behind the pressure in this scheme; smaller steps or --scheme staggered \
                 balance better"
            }
            SchemeChoice::Staggered(_) if coupled => {
                "flow and mechanics agree to scheme.coupling_tolerance only; lower it, or use --scheme \
                 monolithic"
            }
            _ => {
                "the permeability contrast leaves the pressure too few digits; trust the pressure, not \
                 the side rates"
            }
        };
        let message = format!("mass is balanced to {mass:.1e} of the turnover only: {remedy}");
        self.observer.warn(&message);
        self.warnings.push(message);
    }

    fn tell_of_thinning(&mut self) {
        if let Some(message) = self.writer.as_ref().and_then(|writer| writer.thinned()) {
            self.observer.warn(&message);
            self.warnings.push(message);
        }
    }

    /// Steps that are shorter for the solver's sake are no property of the problem.
    fn warn_of_failed_solves(&mut self) {
        let failed = self.rejections.of(Rejection::Solver);
        if failed == 0 {
            return;
        }
        let message = format!(
            "{failed} of {} tried steps were cut because the solver failed, not because of their error; \
             another --solver may take longer steps",
            self.steps + self.rejections.total()
        );
        self.observer.warn(&message);
        self.warnings.push(message);
    }

    /// Faces that are pressed together go through each other: nothing stops them yet. Rock that has broken is no face.
    fn warn_of_overlap(&mut self) {
        let cracks = self.plan.cracks.iter().enumerate();
        let damage = self
            .model
            .solid
            .as_ref()
            .and_then(|solid| solid.damage.as_ref());
        let damage = damage.map_or_else(Vec::new, |damage| damage.of(&self.state.history));
        let whole = |point: &usize| damage.get(*point).is_none_or(|damage| *damage < NO_FACE);
        let is_face = |faces: &Faces<D>| {
            faces
                .sides
                .iter()
                .all(|side| side.nearest.iter().all(whole))
        };
        for (number, crack) in cracks.filter(|(_, crack)| crack.kind == CrackKind::Cut) {
            let faces = self.model.places.cracks[number].iter();
            let jumps = openings(&self.model, &self.state, number);
            let jumps: Vec<[f64; 2]> = (faces.zip(jumps))
                .filter_map(|(faces, jump)| is_face(faces).then_some(jump))
                .collect();
            let deepest = jumps.iter().map(|jump| jump[0]).fold(0.0, f64::min);
            let sizes = jumps.iter().flatten().map(|jump| jump.abs());
            if deepest < -OVERLAP * sizes.fold(0.0, f64::max) {
                let message = format!(
                    "the faces of crack \"{}\" overlap by up to {:.3e} m: they do not feel each other; \
                     give the crack a pressure that opens it, or leave it out where it is closed",
                    crack.name, -deepest
                );
                self.observer.warn(&message);
                self.warnings.push(message);
            }
        }
    }

    /// Rate of outflow per side now, m³/s.
    fn outflow(&self) -> Option<BTreeMap<Name, f64>> {
        let flow = self.model.flow.as_ref()?;
        let rates = flow.outflow(&self.state.pressure, self.state.time);
        Some(
            Side::all(D)
                .map(|side| {
                    (
                        side.name().into(),
                        self.plan.thickness * rates[side.index()],
                    )
                })
                .collect(),
        )
    }

    /// Wells whose bottom-hole pressure is known, at the end.
    fn wells(&self) -> BTreeMap<String, WellReport> {
        let Some(flow) = &self.model.flow else {
            return BTreeMap::new();
        };
        let now = flow.wells_now(&self.state.pressure, self.state.time);
        let wells = flow.wells.iter().zip(now).zip(&self.state.wells);
        let report = wells.map(|((well, now), state)| {
            let report = WellReport {
                rate: self.plan.thickness * now.rate,
                pressure: now.pressure,
                control: state.control.name().into(),
                switches: state.switches,
                index: self.plan.thickness * well.index,
                equivalent_radius: well.equivalent_radius,
            };
            (well.name.clone(), report)
        });
        report.collect()
    }

    /// Keeps the errors at this output.
    pub(super) fn record_errors(&mut self) {
        let errors = self.errors();
        if !errors.is_empty() {
            let time = self.state.time;
            self.timed_errors.push(TimedErrors { time, errors });
        }
    }

    /// Errors at the end, which is always an output.
    fn last_errors(&self) -> BTreeMap<Name, FieldError> {
        let now = self.state.time.to_bits();
        let last = self
            .timed_errors
            .last()
            .filter(|at| at.time.to_bits() == now);
        last.map(|at| at.errors.clone()).unwrap_or_default()
    }

    /// Errors of all fields of which the plan names an exact solution, now.
    fn errors(&self) -> BTreeMap<Name, FieldError> {
        let mut errors = BTreeMap::new();
        if !self.state.is_unlimited() {
            return errors;
        }
        errors.extend(self.opening_error().map(|e| ("opening".into(), e)));
        errors.extend(self.well_error().map(|e| ("well_pressure".into(), e)));
        let Ok(Some(exact)) = exact_pressure(self.plan) else {
            return errors;
        };
        let cloud = &self.model.cloud;
        let steady = self.plan.time.mode == TimeMode::Steady;
        if exact.steady_only() && !steady && !self.is_settled() {
            return errors;
        }
        let manufactured = self
            .plan
            .reference
            .is_some_and(|r| r.kind == ReferenceKind::Manufactured);
        let time = if steady && !manufactured {
            f64::INFINITY
        } else {
            self.state.time
        };
        let left_out = exact.excluded();
        let excluded = |x: &Vector<D>| left_out.iter().any(|place| place.contains(x.as_slice()));
        let excluded: Vec<bool> = cloud.position.iter().map(excluded).collect();
        let exact = self.everywhere(1, |x, values| values[0] = exact.pressure(x, time));
        let pressure = &self.state.pressure;
        if let Ok(norms) = ErrorNorms::compare(pressure, &exact, &cloud.volume, &excluded) {
            errors.insert("pressure".into(), FieldError::of(&norms, self.model.level));
        }
        if let (Ok(Some(exact)), Some(_)) = (exact_displacement(self.plan), &self.model.solid) {
            errors.extend(
                self.displacement_error(&*exact, time)
                    .map(|e| ("displacement".into(), e)),
            );
        }
        if steady {
            errors.extend(self.flux_error().map(|e| ("flux".into(), e)));
        }
        errors
    }

    /// Values of a function at all points; every process works out those of its own.
    fn everywhere(&self, per_point: usize, value: impl Fn(&[f64], &mut [f64]) + Sync) -> Vec<f64> {
        let (cloud, share) = (&self.model.cloud, self.model.subdomain());
        let mut values = vec![0.0; per_point * cloud.len()];
        parallel::chunks(&mut values, per_point, 1, |point, values| {
            if share.owns(point) {
                value(cloud.position[point].as_slice(), values);
            }
        });
        share.complete(&mut values, per_point);
        values
    }

    /// Error of all components of the displacement together.
    fn displacement_error(&self, exact: &dyn ExactDisplacement, time: f64) -> Option<FieldError> {
        let cloud = &self.model.cloud;
        let exact = self.everywhere(D, |x, values| {
            values.copy_from_slice(&exact.displacement(x, time));
        });
        let volume: Vec<f64> = cloud.volume.iter().flat_map(|v| [*v; D]).collect();
        let norms =
            ErrorNorms::compare(&self.state.shown_displacement(), &exact, &volume, &[]).ok()?;
        Some(norms.into())
    }

    /// Error of the opening along the crack of which the plan names the exact solution.
    fn opening_error(&self) -> Option<FieldError> {
        let exact = exact_openings(self.plan, &self.model, &self.state, 0)?;
        let computed = openings(&self.model, &self.state, 0);
        let computed: Vec<f64> = computed.iter().map(|jump| jump[0]).collect();
        let norms = ErrorNorms::compare(&computed, &exact, &vec![1.0; exact.len()], &[]).ok()?;
        Some(norms.into())
    }

    /// Error of the bottom-hole pressure of the well of which the plan names the exact one, relative to the largest change since
    /// the start so far.
    fn well_error(&self) -> Option<FieldError> {
        let (exact, range) = exact_well_pressure(self.plan, self.state.time)?;
        let flow = self.model.flow.as_ref()?;
        let now = flow.wells_now(&self.state.pressure, self.state.time);
        let off = (now.first()?.pressure - exact).abs();
        Some(FieldError {
            l2: off / range,
            l2_over_norm: off / exact.abs(),
            max: off / range,
            range,
            compared: 1,
            excluded: 0,
        })
    }

    fn flux_error(&self) -> Option<FieldError> {
        let exact = exact_flux(self.plan)?;
        let right = self.outflow()?.get("right").copied()? / self.plan.thickness;
        let error = (right - exact).abs() / exact.abs();
        Some(FieldError {
            l2: error,
            l2_over_norm: error,
            max: error,
            range: exact.abs(),
            compared: 1,
            excluded: 0,
        })
    }

    /// Whether storage takes up next to nothing any more, so that a steady solution may be compared.
    fn is_settled(&self) -> bool {
        let (Some(flow), state) = (&self.model.flow, &self.state) else {
            return true;
        };
        let mut imbalance = vec![0.0; state.pressure.len()];
        flow.imbalance(state.time, &state.pressure, &mut imbalance);
        let taken: f64 = imbalance.iter().map(|rate| rate.abs()).sum();
        taken <= SETTLED * flow.flows(&state.pressure, state.time).gross
    }

    /// How strongly flow and mechanics feel each other.
    fn coupling(&self, counters: &SchemeCounters) -> Option<CouplingReport> {
        let (flow, coupling) = (self.model.flow.as_ref()?, self.model.coupling.as_ref()?);
        let cloud = &self.model.cloud;
        let storage = |i: usize| flow.capacity[i] + coupling.oedometric[i];
        let diffusivity = |i: usize| flow.mobility[i] * cloud.volume[i] / storage(i);
        let limit = |i: usize| COUPLING_SAFETY * cloud.spacing(i).powi(2) / diffusivity(i);
        Some(CouplingReport {
            strength: coupling.strength(&flow.capacity),
            consolidation: (0..cloud.len()).map(diffusivity).fold(0.0, f64::max),
            step_limit: (0..cloud.len()).map(limit).fold(f64::INFINITY, f64::min),
            passes: counters.coupling_iterations,
            contraction: counters.contraction,
        })
    }

    /// Evaluations of the effects of this process, by name.
    pub(super) fn evaluations(&self) -> BTreeMap<&'static str, u64> {
        let model = &self.model;
        let flow = model.flow.iter().flat_map(|flow| flow.effects.iter());
        let solid = model.solid.iter().flat_map(|solid| &solid.effects);
        let mut evaluations = BTreeMap::new();
        for effect in flow.chain(solid) {
            *evaluations.entry(effect.effect().name()).or_insert(0) += effect.evaluations();
        }
        let damage = model.solid.as_ref().and_then(|solid| solid.damage.as_ref());
        evaluations.extend(damage.map(|damage| ("damage", damage.evaluations())));
        let cracks = model.fracture_flow.as_ref();
        evaluations.extend(cracks.map(|cracks| ("aperture", cracks.evaluations())));
        let wells = model
            .flow
            .as_ref()
            .and_then(|flow| flow.wells.evaluations());
        evaluations.extend(wells.map(|count| ("held-wells", count)));
        evaluations
    }

    fn counters(&self, scheme: SchemeCounters) -> Counters {
        let model = &self.model;
        let before = &self.before.evaluations;
        let mut evaluations = self.evaluations();
        for (name, count) in &mut evaluations {
            *count += before.get(*name).copied().unwrap_or(0);
        }
        Counters {
            steps: self.steps,
            rejected: self.rejections.total(),
            operator_products: scheme.products,
            refills: self.all_refills(),
            stiffness_refills: model.solid.as_ref().map_or(0, |solid| solid.refills),
            solver: scheme.solver,
            mechanics: scheme.mechanics,
            newton_iterations: scheme.newton_iterations,
            coupling_iterations: scheme.coupling_iterations,
            relaxation_iterations: scheme.relaxation_iterations,
            single_steps: scheme.single_steps,
            fallbacks: scheme.fallbacks,
            searches: scheme.searches,
            refilled_families: scheme.refilled_families,
            evaluations: named(evaluations),
            field_bytes: named(self.state.fields()),
            bytes: named(model.bytes()),
        }
    }
}

/// Figures by name.
fn named<T>(figures: impl IntoIterator<Item = (&'static str, T)>) -> BTreeMap<Name, T> {
    let named = figures.into_iter();
    named.map(|(name, figure)| (name.into(), figure)).collect()
}

/// A balance per metre of thickness as that of the slab that a plane stands for.
pub(super) fn in_slab(plan: &Plan, balance: &Balance) -> Balance {
    let whole = |value: f64| plan.thickness * value;
    Balance {
        injected: whole(balance.injected),
        outflow: whole(balance.outflow),
        fixed: whole(balance.fixed),
        stored: whole(balance.stored),
        turnover: whole(balance.turnover),
        energy: balance.energy.map(whole),
        potential: balance.potential.map(whole),
        kinetic: balance.kinetic.map(whole),
        work: balance.work.map(whole),
        ..balance.clone()
    }
}

/// Smallest and largest value.
pub(super) fn extremes(values: &[f64]) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    values
        .iter()
        .fold(start, |[low, high], &v| [low.min(v), high.max(v)])
}

/// Largest length of a vector field.
pub(super) fn largest<const D: usize>(field: &[f64]) -> f64 {
    let length = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    field.chunks(D).map(length).fold(0.0, f64::max)
}
