//! Where in the scene stands what a rule of [`capability`](crate::plan::capability) refuses.

use crate::plan::capability::{Feature, Place, Rule};
use crate::scene::{
    Condition, Crack, CrackKind, Diagnostic, Entry, Flow, Material, Mechanics, Named, Scene, Span,
    Spanned, Support,
};

/// The faults of a broken rule: one for each place of its first feature.
pub(super) fn diagnostics(rule: &Rule, scene: &Scene) -> Vec<Diagnostic> {
    let reason = rule.reason_for(scene.scheme.name.value.name());
    let fault = |at: Span| {
        let fault = Diagnostic::new(&*reason).at(at).help(rule.remedy);
        match rule.also {
            Some((place, words)) => fault.also(first(scene, place), words),
            None => fault,
        }
    };
    let before = rule
        .before
        .map_or(Span::NOWHERE, |place| first(scene, place));
    if before.is_somewhere() {
        return vec![fault(before)];
    }
    let places = (rule.with.first()).map_or_else(Vec::new, |own| places(scene, *own));
    match places.is_empty() {
        true => vec![fault(Span::NOWHERE)],
        false => places.into_iter().map(fault).collect(),
    }
}

fn first(scene: &Scene, place: Place) -> Span {
    match place {
        Place::Scheme => scene.scheme.name.span,
        Place::Of(feature) => places(scene, feature).first().copied().unwrap_or_default(),
    }
}

/// Everywhere that a feature is asked for.
fn places(scene: &Scene, feature: Feature) -> Vec<Span> {
    match feature {
        Feature::Gravity => section(&scene.gravity),
        Feature::Coupling => section(&scene.coupling),
        Feature::Damage | Feature::MixedRock => section(&scene.damage),
        Feature::FractureFlow => section(&scene.fracture_flow),
        Feature::Wells => vec![scene.wells.span],
        Feature::KnownWells => {
            let holes = scene
                .wells
                .iter()
                .filter_map(|own| own.value.wellbore_radius);
            holes.map(|hole| hole.span()).collect()
        }
        Feature::Steady => vec![scene.time.mode.span],
        Feature::TrBdf2 => vec![scene.time.integrator.span],
        Feature::Processes => Vec::new(),
        Feature::InitialStress | Feature::InitialField => match &scene.initial {
            Some(initial) => vec![initial.span],
            None => part(&scene.mechanics, |own| {
                own.initial_stress
                    .iter()
                    .map(|stress| stress.span)
                    .collect()
            }),
        },
        Feature::Flow
        | Feature::HydrostaticStart
        | Feature::HydrostaticSide
        | Feature::PathOperator => part(&scene.flow, |flow| of_flow(flow, feature)),
        Feature::PermeabilityTensor => tensors(&scene.materials),
        Feature::UndrainedStart => section(&scene.coupling),
        Feature::Stabilisation => part(&scene.coupling, |own| vec![own.stabilisation.span()]),
        Feature::CutCrack | Feature::DamagedCrack | Feature::CrackPressure | Feature::Injection => {
            let cracks = scene.cracks.iter();
            cracks
                .filter_map(|crack| of_crack(crack, feature))
                .collect()
        }
        Feature::Mechanics
        | Feature::Dynamic
        | Feature::Plate
        | Feature::MovingSide
        | Feature::Loads
        | Feature::BodyForce
        | Feature::ConsistentGradient
        | Feature::Layers => part(&scene.mechanics, |own| of_mechanics(own, feature)),
    }
}

/// Permeabilities that are tensors.
fn tensors(materials: &Named<Material>) -> Vec<Span> {
    let typed = materials
        .iter()
        .filter_map(|entry| entry.value.permeability.as_ref());
    typed
        .filter(|own| own.is_tensor())
        .map(|own| own.span)
        .collect()
}

fn section<T>(section: &Option<Spanned<T>>) -> Vec<Span> {
    section.iter().map(|section| section.span).collect()
}

/// Places within a section; its heading, if they were not typed.
fn part<T>(section: &Option<Spanned<T>>, places: impl Fn(&Spanned<T>) -> Vec<Span>) -> Vec<Span> {
    let Some(section) = section else {
        return Vec::new();
    };
    let typed: Vec<Span> = (places(section).into_iter())
        .filter(|place| place.is_somewhere())
        .collect();
    match typed.is_empty() {
        true => vec![section.span],
        false => typed,
    }
}

fn of_flow(flow: &Flow, feature: Feature) -> Vec<Span> {
    let deep = |condition: &Spanned<Condition>| match &condition.value {
        Condition::Pressure(given) if given.hydrostatic.value => Some(given.hydrostatic.span),
        _ => None,
    };
    match feature {
        Feature::HydrostaticStart => vec![flow.hydrostatic_start.span],
        Feature::PathOperator => vec![flow.operator.span],
        Feature::HydrostaticSide => {
            let sides = flow.boundary.iter();
            sides.filter_map(|(_, condition)| deep(condition)).collect()
        }
        _ => Vec::new(),
    }
}

fn of_mechanics(mechanics: &Mechanics, feature: Feature) -> Vec<Span> {
    let sides = |wanted: fn(&Support) -> bool| {
        let sides = mechanics.boundary.iter();
        let wanted = sides.filter(|(_, support)| wanted(&support.value));
        wanted.map(|(_, support)| support.span).collect()
    };
    match feature {
        Feature::Dynamic => vec![mechanics.mode.span],
        Feature::Plate => sides(|support| matches!(support, Support::Plate { .. })),
        Feature::MovingSide => sides(moves),
        Feature::ConsistentGradient => vec![mechanics.gradient.span],
        Feature::Layers => vec![mechanics.interfaces.span],
        _ => Vec::new(),
    }
}

/// As [`plan::Support::moves`](crate::plan::Support::moves).
fn moves(support: &Support) -> bool {
    match support {
        Support::Displacement { displacement } => {
            displacement.iter().any(|load| !load.resolved().is_zero())
        }
        Support::NormalDisplacement {
            normal_displacement,
        } => !normal_displacement.resolved().is_zero(),
        _ => false,
    }
}

/// Where a crack asks for a feature: its own key, or its name.
fn of_crack(entry: &Entry<Crack>, feature: Feature) -> Option<Span> {
    let crack = &entry.value;
    let kind = match crack.kind.span.is_somewhere() {
        true => crack.kind.span,
        false => entry.span,
    };
    match feature {
        Feature::CutCrack => (crack.kind.value == CrackKind::Cut).then_some(kind),
        Feature::DamagedCrack => (crack.kind.value == CrackKind::Damaged).then_some(kind),
        Feature::CrackPressure => crack.pressure.as_ref().map(|load| load.span()),
        Feature::Injection => crack.injection.as_ref().map(|injection| injection.span),
        _ => None,
    }
}
