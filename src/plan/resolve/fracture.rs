//! Cracks, damage, and flow in what is broken.

use super::Resolver;
use crate::plan::types::{
    ApertureRule, CrackPlace, CrackPlan, DamageMethod, DamageModel, DamagePlan, DescentSettings,
    EnergySplit, Exponent, FractureFlowPlan, HourglassRule, InjectionPlan, Normalise,
    TransmissivityRule,
};
use crate::scene::quantity::values;
use crate::scene::{self, disc_in_plane, points_in_space};

/// Shortest step over the length of the run, where none is given.
const SHORTEST_STEP: f64 = 1e-2;

impl Resolver<'_> {
    /// Points from a file tell the dimension only now.
    pub(super) fn check_cracks(&mut self, dimension: usize) {
        for entry in &*self.loaded.scene.cracks {
            let crack = &entry.value;
            if let (Some(points), 3) = (&crack.points, dimension) {
                self.faults.push(points_in_space(points.span));
            }
            if let (Some(disc), 2) = (&crack.disc, dimension) {
                self.faults.push(disc_in_plane(disc.span));
            }
            if let Some(injection) = &crack.injection
                && injection.at.len() != dimension
            {
                let found = injection.at.len();
                let message = format!("`at` needs {dimension} components, found {found}");
                self.fault::<()>(injection.at.span, message);
            }
        }
    }
}

pub(super) fn cracks(scene: &scene::Scene, thickness: f64) -> Vec<CrackPlan> {
    let crack = |entry: &scene::Entry<scene::Crack>| CrackPlan {
        name: entry.name.clone(),
        kind: entry.value.kind.value,
        place: place(&entry.value),
        pressure: entry.value.pressure.as_ref().map(scene::Load::resolved),
        injection: (entry.value.injection.as_deref()).map(|own| injection(own, thickness)),
    };
    scene.cracks.iter().map(crack).collect()
}

fn place(crack: &scene::Crack) -> CrackPlace {
    let Some(disc) = &crack.disc else {
        return CrackPlace::Chain(crack.chain());
    };
    let triple = |values: Vec<f64>| std::array::from_fn(|axis| values[axis]);
    CrackPlace::Disc {
        centre: triple(values(&disc.centre)),
        normal: triple(disc.unit_normal()),
        radius: disc.radius.value(),
    }
}

fn injection(injection: &scene::Injection, thickness: f64) -> InjectionPlan {
    InjectionPlan {
        at: values(&injection.at),
        rate: injection.rate.per_thickness(thickness),
    }
}

/// Damage, if the scene names it, in a run to the time `end`, s.
pub(super) fn damage(scene: &scene::Scene, end: f64) -> Option<DamagePlan> {
    let damage = scene.damage.as_deref()?;
    let model = match damage.model {
        scene::DamageModel::Split => DamageModel::Split,
        scene::DamageModel::Paper => DamageModel::Paper,
    };
    let exponent = match (damage.exponent.map(|m| m.value()), model) {
        (Some(2.0), _) | (None, DamageModel::Paper) => Exponent::Two,
        _ => Exponent::ThreeHalves,
    };
    Some(DamagePlan {
        model,
        exponent,
        friction: damage.friction.value(),
        length_scale: damage.length_scale.map(|length| length.value()),
        split: match damage.split {
            scene::EnergySplit::Spectral => EnergySplit::Spectral,
            scene::EnergySplit::VolumetricDeviatoric => EnergySplit::VolumetricDeviatoric,
            scene::EnergySplit::None => EnergySplit::None,
        },
        residual_stiffness: damage.residual_stiffness.value(),
        hourglass: match damage.hourglass {
            scene::Hourglass::Variational => HourglassRule::Variational,
            scene::Hourglass::Linear => HourglassRule::Linear,
        },
        normalise: match damage.normalisation() {
            scene::Normalise::Off => Normalise::Off,
            scene::Normalise::Horizon => Normalise::Horizon,
            scene::Normalise::Mean => Normalise::Mean,
        },
        method: match damage.method {
            scene::DamageMethod::Auto => DamageMethod::Auto,
            scene::DamageMethod::Newton => DamageMethod::Newton,
            scene::DamageMethod::Alternate => DamageMethod::Alternate,
        },
        tolerance: damage.tolerance.value(),
        iterations: usize::try_from(damage.iterations.value).unwrap_or(usize::MAX),
        largest_increment: damage.largest_increment.value(),
        shortest_step: damage
            .shortest_step
            .map_or(SHORTEST_STEP * end, |step| step.value()),
        descent: DescentSettings::default(),
    })
}

pub(super) fn fracture_flow(scene: &scene::Scene) -> Option<FractureFlowPlan> {
    let flow = scene.fracture_flow.as_deref()?;
    let suction = scene.flow.as_ref().is_some_and(|flow| flow.suction);
    let boils_at = if suction { f64::NEG_INFINITY } else { 0.0 };
    let given = scene.fluid.as_ref().and_then(|own| own.cavitation_pressure);
    Some(FractureFlowPlan {
        residual_aperture: flow.residual_aperture.value(),
        aperture: match flow.aperture {
            scene::Aperture::Normal => ApertureRule::Normal,
            scene::Aperture::Mean => ApertureRule::Mean,
        },
        transmissivity: match flow.transmissivity {
            scene::Transmissivity::Cubic => TransmissivityRule::Cubic,
            scene::Transmissivity::Paper => TransmissivityRule::Paper,
        },
        lower_threshold: flow.lower_threshold.value(),
        upper_threshold: flow.upper_threshold.value(),
        storage: flow.storage.map(|storage| storage.value()),
        biot_coefficient: flow.biot_coefficient.value(),
        viscosity: flow.viscosity.map(|viscosity| viscosity.value()),
        permeability: flow.permeability.map(|permeability| permeability.value()),
        cavitation_pressure: given.map_or(boils_at, |pressure| pressure.value()),
    })
}
