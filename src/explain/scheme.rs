//! How steps are taken, and what solves their systems.

use perifrac_solvers::{Outline, choose};

use super::size::row;
use super::{Reason, reason};
use crate::model::Sample;
use crate::plan::capability::{Method, System, method, scales_mass, systems};
use crate::plan::{Plan, SchemeChoice, SolidMethod, StepRule};

/// The scheme and the rule of its steps.
pub(super) fn scheme(plan: &Plan) -> Reason {
    let steps = steps(plan);
    let (name, how) = match method(plan) {
        Method::Steady => return steady(plan),
        Method::ForwardEuler | Method::ImplicitFlow => (pressure(plan), ""),
        Method::Verlet if plan.flow.is_none() => ("explicit (verlet)".to_owned(), ""),
        Method::Verlet if scales_mass(plan) => (
            "explicit (forward-euler, verlet, scaled mass)".to_owned(),
            "",
        ),
        Method::Verlet => ("explicit (forward-euler, verlet)".to_owned(), ""),
        Method::VerletWithFlow => ("semi-implicit (backward-euler, verlet)".to_owned(), ""),
        Method::Relaxation | Method::Equilibrium | Method::Fracture => {
            let how = match &plan.damage {
                None => "equilibrium after each step, ",
                Some(_) => "equilibrium with damage after each step, ",
            };
            (format!("quasi-static ({})", solid(plan)), how)
        }
        Method::RelaxedExplicit | Method::RelaxedImplicit | Method::LaggedFracture => {
            let how = match plan.scheme.integrator() {
                None => "the solid relaxes after each step, ",
                Some(_) => "the solid relaxes after each solve, ",
            };
            (pressure(plan), how)
        }
        Method::Staggered | Method::StaggeredFracture => {
            (pressure(plan), "flow and solid in turn until they agree, ")
        }
        Method::Monolithic | Method::MonolithicFracture => {
            let integrator = plan.scheme.integrator().map_or("", |own| own.name());
            (
                format!("monolithic {integrator}"),
                "flow and solid in one system, ",
            )
        }
    };
    reason(name, format!("{how}{}{steps}", iterations(plan)))
}

fn steady(plan: &Plan) -> Reason {
    let how = match &plan.damage {
        None => "one solve, no time loop".to_owned(),
        Some(damage) => format!(
            "one equilibrium with damage ({}), no time loop",
            damage.method.name()
        ),
    };
    reason("steady", format!("time.mode = \"steady\": {how}"))
}

/// How damage is found beside flow, where the solid does not relax.
fn iterations(plan: &Plan) -> String {
    match (method(plan), &plan.damage) {
        (Method::StaggeredFracture | Method::MonolithicFracture, Some(damage)) => {
            format!("damage by {}, ", damage.method.name())
        }
        _ => String::new(),
    }
}

/// Name of the scheme of the pressure.
fn pressure(plan: &Plan) -> String {
    match plan.scheme.integrator() {
        None => "explicit forward-euler".to_owned(),
        Some(integrator) => format!("{} {}", plan.scheme.name(), integrator.name()),
    }
}

/// How the solid comes to rest.
fn solid(plan: &Plan) -> &'static str {
    match (method(plan), &plan.damage, plan.scheme_options.solid) {
        (Method::Relaxation, _, SolidMethod::Verlet) => "verlet",
        (Method::Relaxation, _, SolidMethod::Adr) => "adr",
        (Method::Relaxation, _, SolidMethod::Switched) => "adr, switched",
        (_, Some(damage), _) => damage.method.name(),
        _ => "newton",
    }
}

fn steps(plan: &Plan) -> String {
    let steps = undamaged_steps(plan);
    let keeps_to_limit = plan.scheme == SchemeChoice::Explicit && plan.flow.is_some();
    match (plan.time.step, &plan.damage) {
        (StepRule::Adaptive, Some(damage)) if !keeps_to_limit => format!(
            "{steps}, cut where damage grows by more than {} in one",
            damage.largest_increment
        ),
        _ => steps,
    }
}

fn undamaged_steps(plan: &Plan) -> String {
    let inertia = (plan.mechanics.as_ref()).is_some_and(|mechanics| mechanics.inertia);
    let at_rest = plan.flow.is_none() && !inertia;
    match plan.time.step {
        StepRule::Fixed(dt) => format!("constant steps of {dt:.3e} s"),
        _ if at_rest => "steps free to grow".to_owned(),
        _ if inertia || plan.scheme == SchemeChoice::Explicit => {
            format!("steps of {} × the stability limit", plan.time.safety)
        }
        _ => format!(
            "adaptive steps, error of a step ≤ {:.1e} of the range",
            plan.time.tolerance
        ),
    }
}

/// The linear solvers of all systems, and why.
pub(super) fn solver(plan: &Plan, sample: &Sample) -> Reason {
    let systems = systems(plan);
    let chosen: Vec<(System, Reason)> = (systems.iter())
        .map(|&system| (system, choice(plan, sample, system)))
        .collect();
    match &chosen[..] {
        [] if plan.flow.is_some() => reason("none", "explicit steps solve no system"),
        [] => reason("none", "no system is solved"),
        [(_, only)] => only.clone(),
        [(_, first), ..] if plan.solver.name() != "auto" => first.clone(),
        several => {
            let mut names: Vec<&str> = several.iter().map(|(_, own)| own.name.as_str()).collect();
            names.dedup();
            let whys: Vec<String> = (several.iter())
                .map(|(system, own)| format!("{}: {}", system.name(), own.why))
                .collect();
            reason(names.join(" + "), whys.join("; "))
        }
    }
}

/// The linear solver of one system.
pub(super) fn choice(plan: &Plan, sample: &Sample, system: System) -> Reason {
    if plan.solver.name() != "auto" {
        return reason(plan.solver.to_string(), "asked for");
    }
    match choose(&outline(plan, sample, system)) {
        Ok(choice) => reason(choice.spec.to_string(), choice.reason),
        Err(error) => reason("auto", error.to_string()),
    }
}

/// What is known of a system from the sample.
pub(super) fn outline(plan: &Plan, sample: &Sample, system: System) -> Outline {
    let flow = sample.flow.as_ref();
    let contrast = flow.map_or(1.0, |flow| flow.mobility[1] / flow.mobility[0]);
    let solid = sample.solid.as_ref().map_or(1.0, |solid| solid.contrast);
    Outline {
        symmetry: system.symmetry(),
        points: sample.points,
        unknowns_per_point: system.width(plan.dimension),
        entries_per_row: row(system, plan.dimension, sample),
        dimension: plan.dimension,
        solves: match system {
            System::Mechanics | System::Monolithic if plan.damage.is_some() => {
                plan.fracture_demand().solves
            }
            System::Mechanics => plan.solid_demand().solves,
            System::Flow | System::Monolithic => plan.stage_demand().solves,
        },
        lags: system == System::Monolithic && plan.fracture_flow.is_some(),
        contrast: match system {
            System::Mechanics => solid,
            System::Flow => contrast,
            System::Monolithic => contrast.max(plan.expected_contrast()),
        },
        volume_stiffness: match (system, &sample.solid) {
            (System::Flow, _) | (_, None) => 1.0,
            (_, Some(solid)) => solid.volume_stiffness,
        },
        separates: sample.separates.contains(&system),
        processes: 1,
    }
}
