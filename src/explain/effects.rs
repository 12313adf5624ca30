//! Which effects run, and with which operators.

use super::{Reason, reason};
use crate::geometry::Side;
use crate::model::Sample;
use crate::plan::{CrackPlan, Load, MechanicsPlan, OperatorChoice, Plan, Support};

/// Effects of the plan and what in the scene calls for them.
pub(super) fn effects(plan: &Plan) -> Vec<Reason> {
    let mut effects = Vec::new();
    if plan.flow.is_some() {
        effects.push(reason("flow", "[flow] is there"));
        if plan.gravity.is_some() {
            effects.push(reason("gravity", "[gravity] is there"));
        }
    }
    if !plan.wells.is_empty() {
        let names: Vec<&str> = plan.wells.iter().map(|well| well.name.as_str()).collect();
        effects.push(reason(
            "wells",
            format!("[wells] names {}", names.join(", ")),
        ));
    }
    if let Some(mechanics) = &plan.mechanics {
        let motion = if mechanics.inertia {
            "dynamic"
        } else {
            "quasi-static"
        };
        effects.push(reason(
            "mechanics",
            format!("[mechanics] is there, {motion}"),
        ));
        effects.extend(sides(mechanics, plan.dimension));
        effects.extend(forces(plan, mechanics));
        effects.extend(cracks(plan));
    }
    if let Some(coupling) = &plan.coupling {
        let start = match coupling.undrained_start {
            true => "from the undrained answer to the first loads",
            false => "from the initial pressure",
        };
        effects.push(reason("coupling", format!("[coupling] is there, {start}")));
    }
    effects
}

/// Whether a load is ever anything but zero.
fn acts(load: &Load) -> bool {
    load.values().iter().any(|value| value.abs() > 0.0)
}

/// Loads and motions of whole sides.
fn sides(mechanics: &MechanicsPlan, dimension: usize) -> Vec<Reason> {
    let kind = |support: &Support| match support {
        Support::Traction(loads) if loads.iter().any(acts) => Some("traction"),
        Support::Roller(load) if acts(load) => Some("normal displacement"),
        Support::Prescribed(loads) if loads.iter().any(acts) => Some("displacement"),
        Support::Plate(_) => Some("plate"),
        _ => None,
    };
    ["traction", "normal displacement", "displacement", "plate"]
        .into_iter()
        .filter_map(|name| {
            let sides: Vec<&str> = Side::all(dimension)
                .filter(|side| kind(&mechanics.sides[side.index()]) == Some(name))
                .map(Side::name)
                .collect();
            let why = format!("[mechanics.boundary] has one on {}", sides.join(", "));
            (!sides.is_empty()).then(|| reason(name, why))
        })
        .collect()
}

/// Cracks, and what presses on their faces.
fn cracks(plan: &Plan) -> Vec<Reason> {
    let names = |wanted: fn(&&CrackPlan) -> bool| -> Vec<&str> {
        let cracks = plan.cracks.iter().filter(wanted);
        cracks.map(|crack| crack.name.as_str()).collect()
    };
    let all = names(|_| true);
    let pressed = names(|crack| crack.pressure.as_ref().is_some_and(acts));
    let mut reasons = Vec::new();
    if !all.is_empty() {
        let why = format!("[cracks] names {}", all.join(", "));
        reasons.push(reason("cracks", why));
    }
    if !pressed.is_empty() {
        let why = format!("there is a pressure in {}", pressed.join(", "));
        reasons.push(reason("crack-pressure", why));
    }
    reasons
}

/// Loads on parts of sides, and forces inside.
fn forces(plan: &Plan, mechanics: &MechanicsPlan) -> Vec<Reason> {
    let mut forces = Vec::new();
    let loads: Vec<&str> = (mechanics.loads.iter())
        .filter(|load| load.traction.iter().any(acts))
        .map(|load| load.name.as_str())
        .collect();
    if !loads.is_empty() {
        let why = format!("[mechanics.loads] names {}", loads.join(", "));
        forces.push(reason("loads", why));
    }
    if mechanics.body_force.is_some() {
        forces.push(reason("body-force", "mechanics.body_force is there"));
    }
    if plan.gravity.is_some() {
        forces.push(reason(
            "weight",
            "[gravity] is there, and the rock has a density",
        ));
    }
    if mechanics.initial_stress.is_some() {
        forces.push(reason(
            "initial-stress",
            "mechanics.initial_stress is there",
        ));
    }
    forces
}

/// The diffusion operator.
pub(super) fn operator(plan: &Plan, sample: &Sample) -> Option<Reason> {
    let (choice, flow) = (plan.flow.as_ref()?.operator, sample.flow.as_ref()?);
    let reach = match flow.second_hop {
        true => "two hops",
        false if choice == OperatorChoice::Bond => "one hop, harmonic mean per bond",
        false => {
            "one hop: its second hop vanishes on isotropic families with this hourglass factor"
        }
    };
    let name = match choice {
        OperatorChoice::Correspondence => "correspondence",
        OperatorChoice::Bond => "bond",
    };
    Some(reason(name, format!("{reach}{}", gradient(flow.corrected))))
}

/// The elastic operator.
pub(super) fn elasticity(sample: &Sample) -> Option<Reason> {
    let gradient = gradient(sample.solid.as_ref()?.corrected);
    Some(reason("elastic", format!("two hops{gradient}")))
}

fn gradient(corrected: bool) -> &'static str {
    if corrected {
        ", divergence-consistent gradient"
    } else {
        ""
    }
}
