//! Which effects run, and with which operators.

use super::{Reason, reason};
use crate::geometry::Side;
use crate::model::{Form, LAYERED, Sample};
use crate::plan::{
    CrackKind, CrackPlan, DamageModel, FractureFlowPlan, Load, MechanicsPlan, Normalise, Plan,
    Support,
};

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
        let held: Vec<&str> = (plan.wells.iter())
            .filter(|well| well.holds())
            .map(|well| well.name.as_str())
            .collect();
        if !held.is_empty() {
            let why = format!("a pressure is given or a limit for {}", held.join(", "));
            effects.push(reason("held-wells", why));
        }
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
        effects.extend(damage(plan));
    }
    if let Some(coupling) = &plan.coupling {
        let start = match coupling.undrained_start {
            true => "from the undrained answer to the first loads",
            false => "from the equilibrium at the initial pressure",
        };
        effects.push(reason("coupling", format!("[coupling] is there, {start}")));
    }
    effects.extend(fracture_flow(plan));
    let own = |_| reason("own effect", "the program hands it in");
    effects.extend(plan.own_effects.iter().map(own));
    effects
}

/// Whether a load is ever anything but zero.
fn acts(load: &Load) -> bool {
    !load.is_zero()
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

/// Names of the cracks that are wanted.
fn names(plan: &Plan, wanted: impl Fn(&CrackPlan) -> bool) -> Option<String> {
    let cracks = plan.cracks.iter().filter(|crack| wanted(crack));
    let names: Vec<&str> = cracks.map(|crack| crack.name.as_str()).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Cracks by their kind, and what presses on their faces.
fn cracks(plan: &Plan) -> Vec<Reason> {
    let cut = names(plan, |crack| crack.kind == CrackKind::Cut);
    let damaged = names(plan, |crack| crack.kind == CrackKind::Damaged);
    // In a fluid zero is a pressure like any other.
    let pressed = |load: &Load| plan.flow.is_some() || acts(load);
    let pressed = names(plan, |crack| crack.pressure.as_ref().is_some_and(pressed));
    let pressure = match plan.flow {
        Some(_) => "the pressure of the fluid is prescribed in",
        None => "there is a pressure in",
    };
    [
        ("cracks", "[cracks] names", cut),
        ("damaged-cracks", "[cracks] names, as damaged,", damaged),
        ("crack-pressure", pressure, pressed),
    ]
    .into_iter()
    .filter_map(|(name, why, cracks)| Some(reason(name, format!("{why} {}", cracks?))))
    .collect()
}

/// Breaking of the rock.
fn damage(plan: &Plan) -> Option<Reason> {
    let damage = plan.damage.as_ref()?;
    let normalised = match damage.normalise {
        Normalise::Off => "",
        Normalise::Horizon => ", normalised",
        Normalise::Mean => ", normalised by mean widths of families",
    };
    let model = match damage.model {
        DamageModel::Split => "model split".to_owned(),
        DamageModel::Paper => format!(
            "model of the paper, split {} (known against it: in-situ stress breaks rock under compression, a crack \
             holds 6 to 27 % more than was pumped, and its pressure is 11 to 40 % too large)",
            damage.split.name()
        ),
    };
    let why = format!("[damage] is there, {model}{normalised}");
    Some(reason("damage", why))
}

/// What cracks that hold what they open by conduct and hold.
fn in_split_cracks(flow: &FractureFlowPlan) -> String {
    let boils = match flow.cavitation_pressure.is_finite() {
        true => format!("fluid boils at {} Pa", flow.cavitation_pressure),
        false => "fluid never boils".to_owned(),
    };
    format!("residual aperture {:e} m, {boils}", flow.residual_aperture)
}

/// Flow in what is broken, and fluid that is pumped into it.
fn fracture_flow(plan: &Plan) -> Vec<Reason> {
    let flow = plan.fracture_flow.as_ref().map(|flow| {
        let split = (plan.damage).is_some_and(|damage| damage.model == DamageModel::Split);
        let how = match split {
            true => in_split_cracks(flow),
            false => format!(
                "aperture {}, transmissivity {}",
                flow.aperture.name(),
                flow.transmissivity.name()
            ),
        };
        reason("fracture-flow", format!("[fracture_flow] is there, {how}"))
    });
    let injected = names(plan, |crack| crack.injection.is_some());
    let injection =
        injected.map(|cracks| reason("injection", format!("there is an injection into {cracks}")));
    flow.into_iter().chain(injection).collect()
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
    if plan.initial.is_some() {
        forces.push(reason(
            "initial-stress",
            "[initial] or mechanics.initial_stress is there, and what balances it",
        ));
    }
    forces
}

/// The diffusion operator.
pub(super) fn operator(sample: &Sample) -> Option<Reason> {
    let flow = sample.flow.as_ref()?;
    let chosen = &flow.operator;
    let reach = match (flow.second_hop, chosen.form) {
        (true, _) => "two hops",
        (false, Form::Path(_)) => "cells that touch, harmonic mean along the way",
        (false, Form::Bond) => "one hop, harmonic mean per bond",
        (false, Form::Correspondence) => {
            "one hop: its second hop vanishes on isotropic families with this hourglass factor"
        }
    };
    let name = chosen.form.name();
    let gradient = gradient(flow.corrected);
    Some(reason(name, format!("{reach}{gradient}; {}", chosen.why)))
}

/// The elastic operator.
pub(super) fn elasticity(plan: &Plan, sample: &Sample) -> Option<Reason> {
    let solid = sample.solid.as_ref()?;
    let gradient = gradient(solid.corrected);
    let layers = plan.mechanics.as_ref()?.has_layers(plan.damage.is_some());
    let interfaces = match solid.contrast > LAYERED {
        false => String::new(),
        true if layers => "; layers in families whose moduli vary".into(),
        true if plan.has_elastic_fields() => format!(
            "; moduli of points, which vary by a factor of {:.3}: stresses converge where they vary smoothly",
            solid.contrast
        ),
        true => format!(
            "; moduli of points, which vary by a factor of {:.3}: stresses beside interfaces do not converge",
            solid.contrast
        ),
    };
    Some(reason("elastic", format!("two hops{gradient}{interfaces}")))
}

fn gradient(corrected: bool) -> &'static str {
    if corrected {
        ", divergence-consistent gradient"
    } else {
        ""
    }
}
