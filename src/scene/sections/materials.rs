//! `[materials.NAME]`: what the rock is like, and where.

use schemars::JsonSchema;
use serde::Deserialize;

use super::fields::{
    Field, FieldDistribution, FieldFile, ReadField, Typed, check_distribution, check_file,
};
use super::geometry::Geometry;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{
    Angle, Density, FractureEnergy, InversePressure, Number, Permeability, Pressure,
};
use crate::scene::range::{Range, within};
use crate::scene::shape::Shape;
use crate::scene::span::{Entry, Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A rock. Where regions overlap, the later material in the file wins.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Where it lies; everywhere else than the others if absent (at most one such).
    pub region: Option<Spanned<Shape>>,
    /// Intrinsic permeability K, m²; needed where there is flow.
    pub permeability: Option<Spanned<PermeabilityField>>,
    /// Storage s, 1/Pa. Excludes `porosity` and `bulk_modulus`.
    pub storage: Option<Spanned<Field<InversePressure>>>,
    /// Porosity n; fields are above 0.
    #[schemars(transform = within(&POROSITY))]
    pub porosity: Option<Spanned<Field<Number>>>,
    /// Biot coefficient α, from the porosity to 1; needed where flow and mechanics are coupled.
    #[schemars(transform = within(&BIOT_COEFFICIENT))]
    pub biot_coefficient: Option<Spanned<ReadField<Number>>>,
    /// Bulk modulus of the rock, Pa.
    pub bulk_modulus: Option<Spanned<ReadField<Pressure>>>,
    /// Young's modulus E of the drained rock, Pa; needed where there is mechanics. Where it is a field, families have
    /// the layers of the cells of their points (`mechanics.interfaces`).
    pub youngs_modulus: Option<Spanned<Field<Pressure>>>,
    /// Poisson's ratio ν of the drained rock, from 0, below 0.5; needed where there is mechanics.
    #[schemars(extend("minimum" = 0, "exclusiveMaximum" = 0.5))]
    pub poissons_ratio: Option<Spanned<ReadField<Number>>>,
    /// Density of the rock with its fluid, kg/m³; needed where its weight or inertia acts.
    pub density: Option<Spanned<Field<Density>>>,
    /// Energy G_c that a crack takes per area, J/m²; needed where there is damage.
    pub fracture_energy: Option<Spanned<Field<FractureEnergy>>>,
}

/// Intrinsic permeability, m²: one value, from a file, drawn at random, or a tensor.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "PermeabilityField by key", rename_all = "kebab-case")]
#[schemars(rename = "PermeabilityField", untagged)]
pub enum PermeabilityField {
    /// The same everywhere, m².
    Value(Permeability),
    /// From a file: one value for each point, or for each cell of an array laid over the domain.
    File(FieldFile),
    /// A random field.
    Distribution(FieldDistribution<Permeability>),
    /// A tensor by its principal permeabilities.
    K1(PrincipalPermeability),
    /// A tensor by its components.
    Xx(PermeabilityTensor),
}

impl PermeabilityField {
    /// Whether it depends on the direction of flow.
    pub fn is_tensor(&self) -> bool {
        matches!(self, Self::K1(_) | Self::Xx(_))
    }
}

/// A permeability that depends on the direction of flow, in the plane, by its principal axes.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrincipalPermeability {
    /// Along the first principal axis, m².
    pub k1: Permeability,
    /// Along the second one, at right angles to the first, m².
    pub k2: Permeability,
    /// Angle from x to the first principal axis, counted towards y.
    pub angle: Angle,
}

/// A permeability that depends on the direction of flow, in the plane, by the components of its tensor.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PermeabilityTensor {
    /// xx component, m².
    pub xx: Permeability,
    /// yy component, m².
    pub yy: Permeability,
    /// xy component, m²; its square must be below xx times yy.
    pub xy: Permeability,
}

const POROSITY: Range = Range {
    key: "porosity",
    low: 0.0,
    high: 1.0,
    why: "it is a share of the volume",
};
const BIOT_COEFFICIENT: Range = Range {
    key: "biot_coefficient",
    low: 0.0,
    high: 1.0,
    why: "the pressure of the fluid acts on the rock by no more than all of itself",
};
impl Material {
    /// The files of its properties.
    pub fn files(&self) -> impl Iterator<Item = &FieldFile> {
        let permeability = match self.permeability.as_deref() {
            Some(PermeabilityField::File(file)) => Some(file),
            _ => None,
        };
        let all = [
            permeability,
            self.storage.as_ref().and_then(|own| own.typed().file()),
            self.porosity.as_ref().and_then(|own| own.typed().file()),
            (self.biot_coefficient.as_ref()).and_then(|own| own.typed().file()),
            (self.bulk_modulus.as_ref()).and_then(|own| own.typed().file()),
            (self.youngs_modulus.as_ref()).and_then(|own| own.typed().file()),
            (self.poissons_ratio.as_ref()).and_then(|own| own.typed().file()),
            self.density.as_ref().and_then(|own| own.typed().file()),
            (self.fracture_energy.as_ref()).and_then(|own| own.typed().file()),
        ];
        all.into_iter().flatten()
    }
}

impl Section for Named<Material> {
    const NAME: &'static str = "materials";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        report.names(self);
        if self.is_empty() {
            report.add(
                Diagnostic::new("[materials] is empty")
                    .at(place)
                    .help(EXAMPLE),
            );
        }
        if self.len() > MOST_MATERIALS {
            let message = format!("at most {MOST_MATERIALS} materials, found {}", self.len());
            report.add(Diagnostic::new(message).at(place));
        }
        // A file may tell the material of every point.
        let told = matches!(
            scene.sound(&scene.draft.geometry),
            Some(Geometry::File(_) | Geometry::Mesh(_))
        );
        let mut background = self.iter().filter(|entry| entry.value.region.is_none());
        if let Some(first) = background.next().filter(|_| !told) {
            for second in background {
                let fault = Diagnostic::new("only one material can go without a `region`");
                let fault = fault.at(second.span).also(first.span, "has none either");
                report.add(fault.help("give one of them a region"));
            }
        }
        for entry in self {
            let material = &entry.value;
            if let Some(region) = &material.region {
                report.shape(region, scene);
            }
            if let Some(field) = &material.permeability {
                check_permeability(field, report);
            }
            check_solid(material, report);
            check_needs(entry, scene, report);
            check_storage(entry, scene, report);
        }
    }
}

/// Points number their materials by 16 bits, of which one number stands for none.
const MOST_MATERIALS: usize = u16::MAX as usize - 1;

/// Remedy for a scene without materials.
pub(super) const EXAMPLE: &str = "add [materials.rock] with `permeability` and `storage`";

fn check_permeability(field: &PermeabilityField, report: &mut Report) {
    match field {
        PermeabilityField::Value(value) => report.positive("permeability", *value),
        PermeabilityField::File(source) => check_file(source, report),
        PermeabilityField::Distribution(random) => check_distribution(random, report),
        PermeabilityField::K1(principal) => {
            report.positive("k1", principal.k1);
            report.positive("k2", principal.k2);
            let turns = principal.angle.value().abs() / std::f64::consts::TAU;
            if turns > 1.0 {
                let fault = Diagnostic::new("`angle` is more than a whole turn");
                let fault = fault.at(principal.angle.span());
                report.add(fault.help("a bare number is in rad; write angle = \"30 deg\""));
            }
        }
        PermeabilityField::Xx(tensor) => {
            report.positive("xx", tensor.xx);
            report.positive("yy", tensor.yy);
            let [xx, yy, xy] = [tensor.xx, tensor.yy, tensor.xy].map(|part| part.value());
            if xx > 0.0 && yy > 0.0 && xy.abs() >= xx.sqrt() * yy.sqrt() {
                let fault = Diagnostic::new("a permeability tensor needs xy² below xx yy");
                let help = "else fluid would flow towards higher pressure; correct a component";
                report.add(fault.at(tensor.xy.span()).help(help));
            }
        }
    }
}

fn check_solid(material: &Material, report: &mut Report) {
    if let Some(modulus) = &material.youngs_modulus {
        let positive = |own, report: &mut Report| report.positive("youngs_modulus", own);
        modulus.typed().check(report, positive);
    }
    if let Some(ratio) = &material.poissons_ratio {
        ratio.typed().check(report, check_ratio);
    }
    if let Some(density) = &material.density {
        let positive = |own, report: &mut Report| report.positive("density", own);
        density.typed().check(report, positive);
    }
    if let Some(energy) = &material.fracture_energy {
        let positive = |own, report: &mut Report| report.positive("fracture_energy", own);
        energy.typed().check(report, positive);
    }
}

fn check_ratio(ratio: Number, report: &mut Report) {
    report.not_negative("poissons_ratio", ratio);
    if ratio.value() >= 0.5 {
        let fault = Diagnostic::new("`poissons_ratio` must be below 0.5").at(ratio.span());
        report.add(fault.help("for rock that keeps its volume: poissons_ratio = 0.49"));
    }
}

/// What the effects of the scene need to know of a material, besides its storage.
fn check_needs(entry: &Entry<Material>, scene: &Context<'_>, report: &mut Report) {
    let (draft, material) = (scene.draft, &entry.value);
    let flow = scene.has(&draft.flow).then_some("[flow]");
    let mechanics = scene.has(&draft.mechanics).then_some("[mechanics]");
    let coupling = scene.has(&draft.coupling).then_some("[coupling]");
    let damage = scene.has(&draft.damage).then_some("[damage]");
    let gravity = mechanics.and(scene.has(&draft.gravity).then_some("[gravity]"));
    let inertia = scene
        .sound(&draft.mechanics)
        .filter(|mechanics| mechanics.is_dynamic())
        .map(|_| "mode = \"dynamic\"");
    let needs = [
        ("permeability", flow, material.permeability.is_some()),
        (
            "youngs_modulus",
            mechanics,
            material.youngs_modulus.is_some(),
        ),
        (
            "poissons_ratio",
            mechanics,
            material.poissons_ratio.is_some(),
        ),
        ("density", gravity.or(inertia), material.density.is_some()),
        (
            "biot_coefficient",
            coupling,
            material.biot_coefficient.is_some(),
        ),
        (
            "fracture_energy",
            damage,
            material.fracture_energy.is_some(),
        ),
    ];
    for (key, needed_by, typed) in needs {
        let Some(effect) = needed_by.filter(|_| !typed) else {
            continue;
        };
        let fault = Diagnostic::new(format!("material `{}` has no `{key}`", entry.name));
        let help = format!("{effect} needs it: add `{key}` to the material");
        report.add(fault.at(entry.span).help(help));
    }
}

fn check_storage(entry: &Entry<Material>, scene: &Context<'_>, report: &mut Report) {
    let material = &entry.value;
    if let Some(storage) = &material.storage {
        let positive = |own, report: &mut Report| report.positive("storage", own);
        storage.typed().check(report, positive);
    }
    if let Some(modulus) = &material.bulk_modulus {
        let positive = |own, report: &mut Report| report.positive("bulk_modulus", own);
        modulus.typed().check(report, positive);
    }
    check_pores(material, report);
    let parts = [
        ("porosity", material.porosity.as_ref().map(|own| own.span)),
        (
            "biot_coefficient",
            material.biot_coefficient.as_ref().map(|own| own.span),
        ),
        (
            "bulk_modulus",
            material.bulk_modulus.as_ref().map(|own| own.span),
        ),
    ];
    match &material.storage {
        Some(storage) => {
            let [porosity, _, modulus] = parts;
            let part = [porosity, modulus]
                .into_iter()
                .find(|(_, span)| span.is_some());
            part.map(|part| report.at_most_one(&[("storage", Some(storage.span)), part]));
        }
        None => check_derived_storage(entry, &parts, scene, report),
    }
}

fn check_pores(material: &Material, report: &mut Report) {
    let porosity = material.porosity.as_ref().map(|own| own.typed());
    if let Some(porosity) = porosity {
        porosity.check(report, |own, report| POROSITY.check(own, report));
    }
    let biot = (material.biot_coefficient.as_ref()).map(|own| own.typed());
    if let Some(biot) = biot {
        biot.check(report, |own, report| BIOT_COEFFICIENT.check(own, report));
    }
    if let (Some(porosity), Some(biot)) =
        (porosity.and_then(Typed::value), biot.and_then(Typed::value))
        && (0.0..porosity.value()).contains(&biot.value())
    {
        let fault = Diagnostic::new("`biot_coefficient` must not be below `porosity` (Eq. 38)");
        report.add(fault.at(biot.span()).also(porosity.span(), "the porosity"));
    }
}

fn check_derived_storage(
    entry: &Entry<Material>,
    parts: &[(&str, Option<Span>)],
    scene: &Context<'_>,
    report: &mut Report,
) {
    let missing: Vec<&str> = parts
        .iter()
        .filter(|(_, span)| span.is_none())
        .map(|(name, _)| *name)
        .collect();
    let transient = scene
        .sound(&scene.draft.time)
        .is_some_and(|time| !time.is_steady());
    // A Biot coefficient alone belongs to the coupling.
    let untouched = ["porosity", "bulk_modulus"]
        .iter()
        .all(|name| missing.contains(name));
    if untouched {
        if transient && scene.has(&scene.draft.flow) {
            let message = format!("material `{}` has no storage", entry.name);
            report.add(Diagnostic::new(message).at(entry.span).help(
                "add `storage`, or `porosity`, `biot_coefficient` and `bulk_modulus` (Eq. 38)",
            ));
        }
    } else if !missing.is_empty() {
        let missing: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
        let message = format!("storage by Eq. 38 needs {} too", missing.join(" and "));
        report.add(Diagnostic::new(message).at(entry.span));
    } else if scene
        .sound(&scene.draft.fluid)
        .is_some_and(|fluid| fluid.bulk_modulus.is_none())
    {
        let fault = Diagnostic::new("storage by Eq. 38 needs `fluid.bulk_modulus`").at(entry.span);
        report.add(fault.help("for water: bulk_modulus = \"2.2 GPa\""));
    }
}
