//! How the run goes, what it writes, and what it is compared with.

use crate::plan::types::{
    AuditPlan, Integrator, OutputPlan, Probe, Profile, ReferencePlan, SchemeChoice, SchemeOptions,
    SchemeStart, StepRule, TimePlan,
};
use crate::scene::quantity::values;
use crate::scene::{self, Spanned};

/// Error of a step over the range of the pressure, where none is given.
const TOLERANCE: f64 = 1e-5;
/// The same in fractures, where steps are of first order. The peak pressure of `natural-fractures/smoke` is
/// then 1.2 % below that at 1e-4, in 24 steps; at 1e-3 0.4 %, in 63; judged by damage alone 3.4 %, in 7.
const TOLERANCE_IN_FRACTURES: f64 = 1e-2;

pub(super) fn time(time: &scene::TimeControl, fractures: bool) -> TimePlan {
    let tolerance = match fractures {
        true => TOLERANCE_IN_FRACTURES,
        false => TOLERANCE,
    };
    let steady = time.is_steady();
    TimePlan {
        mode: time.mode.value,
        start: 0.0,
        end: time.end.filter(|_| !steady).map_or(0.0, |end| end.value()),
        step: time
            .step
            .map_or(StepRule::Adaptive, |step| StepRule::Fixed(step.value())),
        tolerance: time.tolerance.map_or(tolerance, |own| own.value()),
        first_step: time.first_step.map(|step| step.value()),
        max_step: time.max_step.map(|step| step.value()),
        safety: time.safety.value(),
        max_steps: usize::try_from(time.max_steps.value).unwrap_or(usize::MAX),
    }
}

pub(super) fn scheme(scene: &scene::Scene) -> SchemeChoice {
    // Coefficients of fractures change within a step, which stages of higher order do not bear; inertia
    // takes whole steps.
    let inertia = (scene.mechanics.as_ref()).is_some_and(|mechanics| mechanics.is_dynamic());
    let whole = scene.fracture_flow.is_some() || inertia;
    let typed = scene.time.integrator.span.is_somewhere();
    let integrator = match scene.time.integrator.value {
        Integrator::TrBdf2 if typed || !whole => Integrator::TrBdf2,
        _ => Integrator::BackwardEuler,
    };
    match scene.scheme.name.value {
        scene::SchemeName::Explicit => SchemeChoice::Explicit,
        scene::SchemeName::Implicit => SchemeChoice::Implicit(integrator),
        scene::SchemeName::SemiImplicit => SchemeChoice::SemiImplicit(integrator),
        scene::SchemeName::Staggered => SchemeChoice::Staggered(integrator),
        scene::SchemeName::Monolithic => SchemeChoice::Monolithic(integrator),
    }
}

pub(super) fn scheme_options(scheme: &scene::Scheme, dimension: usize) -> SchemeOptions {
    let count = |number: Spanned<u64>| usize::try_from(number.value).unwrap_or(usize::MAX);
    SchemeOptions {
        relaxation: scheme.relaxation.value(),
        acceleration: scheme.acceleration,
        coupling_tolerance: scheme.coupling_tolerance.value(),
        coupling_iterations: count(scheme.coupling_iterations),
        single_pass: scheme.single_pass,
        solid: scheme.solid,
        start: scheme.start.unwrap_or(match dimension {
            2 => SchemeStart::Assembled,
            // 97 kB a point of matrix and more of factor, where forces take 0.3 kB.
            _ => SchemeStart::Relaxed,
        }),
        adr_tolerance: scheme
            .adr_tolerance
            .map_or(ADR_TOLERANCE, |own| own.value()),
        adr_follows: scheme.adr_tolerance.is_none(),
        adr_iterations: count(scheme.adr_iterations),
        adr_damping: scheme.adr_damping,
        adr_smoothing: scheme.adr_smoothing.value(),
    }
}

/// Relative imbalance of forces at which dynamic relaxation ends, where none is given.
const ADR_TOLERANCE: f64 = 1e-6;

/// Fluid that may be lost or made, where no limit is given.
const MASS: f64 = 1e-2;
/// The same in the outputs of explicit steps, whose strain lags: Terzaghi's column at 0.5 m owes 3 % in an output
/// whose pressure is good to 1.2 %, 12 % in one that is 9 % off.
const MASS_WITH_LAG: f64 = 0.1;

pub(super) fn audit(scene: &scene::Scene) -> AuditPlan {
    let audit = &scene.audit;
    let explicit = scene.scheme.name.value == scene::SchemeName::Explicit;
    let usual = match explicit && scene.coupling.is_some() {
        true => MASS_WITH_LAG,
        false => MASS,
    };
    AuditPlan {
        mass: audit.mass.map_or(usual, |limit| limit.value()),
        momentum: audit.momentum.value(),
        energy: audit.energy.value(),
        lag: audit.lag.value(),
    }
}

pub(super) fn output(output: &scene::Output, time: &scene::TimeControl) -> OutputPlan {
    let end = time.end.map_or(0.0, |end| end.value());
    let mut times = output
        .times
        .as_ref()
        .map_or_else(Vec::new, |times| values(times));
    if let Some(every) = output.every {
        let count = (end / every.value() * (1.0 + 1e-12)).floor() as usize;
        times = (1..=count).map(|k| k as f64 * every.value()).collect();
    }
    OutputPlan {
        times,
        crack_increment: output.crack_increment.map(|growth| growth.value()),
        vtu: output.vtu && output.format.value == scene::Format::Vtu,
        vtkhdf: output.vtu && output.format.value == scene::Format::Vtkhdf,
        plots: output.plots,
        probes: output
            .probes
            .iter()
            .map(|entry| Probe {
                name: entry.name.clone(),
                at: values(&entry.value.at),
            })
            .collect(),
        profiles: output
            .profiles
            .iter()
            .map(|entry| Profile {
                name: entry.name.clone(),
                from: values(&entry.value.from),
                to: values(&entry.value.to),
                points: entry.value.points.value as usize,
            })
            .collect(),
    }
}

pub(super) fn reference_plan(reference: &scene::Reference) -> ReferencePlan {
    ReferencePlan {
        kind: reference.kind.value,
        exclude: reference.exclude.map(|radius| radius.value()),
    }
}
