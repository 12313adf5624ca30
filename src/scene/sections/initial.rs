//! `[initial]`: the in-situ state, in which the rock and its fluid are at rest before anything is done to them.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize};

use super::mechanics::InitialStress;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{ForceDensity, Length, Number, Pressure};
use crate::scene::shape::Shape;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// The in-situ state: stress and pore pressure that are in equilibrium before the run. Displacements count from
/// it; what balances it on sides without a `traction` is implied.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Initial {
    /// Whether the stresses here are effective or total ones.
    pub kind: Spanned<StressKind>,
    /// Stress at the datum.
    pub stress: Option<Spanned<InitialStress>>,
    /// What a metre of depth below the datum adds to the stress.
    pub stress_gradient: Option<Spanned<StressGradient>>,
    /// Height from which depth counts, m: the coordinate against gravity, along the last axis where none acts.
    /// That of the highest corner of the domain if absent.
    pub datum: Option<Length>,
    /// Ratio of horizontal to vertical effective stress; the vertical one is that of the weight of the rock
    /// below the datum. Needs `[gravity]`.
    pub k0: Option<Number>,
    /// Uniform stresses of parts of the domain, in place of the others; later ones replace earlier ones.
    pub regions: Vec<StressRegion>,
    /// Pore pressure, Pa: a uniform one, or `"hydrostatic"`, the weight of the fluid below the datum.
    pub pressure: Option<InitialPressure>,
}

/// Which stresses are given.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressKind {
    /// What the rock carries: the total stress plus α p.
    #[default]
    Effective,
    /// What rock and fluid carry together.
    Total,
}

/// Change of a stress with depth, Pa/m; a component that is not named does not change.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StressGradient {
    /// Normal stress along x, Pa/m.
    pub xx: Option<ForceDensity>,
    /// Normal stress along y, Pa/m.
    pub yy: Option<ForceDensity>,
    /// Normal stress along z, Pa/m.
    pub zz: Option<ForceDensity>,
    /// Shear stress, Pa/m.
    pub xy: Option<ForceDensity>,
    /// Shear stress, Pa/m. Not in a plane.
    pub yz: Option<ForceDensity>,
    /// Shear stress, Pa/m. Not in a plane.
    pub xz: Option<ForceDensity>,
}

impl StressGradient {
    /// Components xx, yy, zz, xy, yz, xz in Pa/m.
    pub fn resolved(&self) -> [f64; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.yz, self.xz]
            .map(|component| component.map_or(0.0, |value| value.value()))
    }
}

/// A uniform stress in a part of the domain.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StressRegion {
    /// Where.
    pub region: Spanned<Shape>,
    /// The stress there.
    pub stress: Spanned<InitialStress>,
}

/// Pore pressure of the in-situ state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialPressure {
    /// The same everywhere.
    Uniform(Pressure),
    /// The weight of the fluid below the datum.
    Hydrostatic(Span),
}

/// The word for a pressure that grows with depth.
const HYDROSTATIC: &str = "hydrostatic";

impl InitialPressure {
    /// Where it was typed.
    pub fn span(&self) -> Span {
        match self {
            Self::Uniform(pressure) => pressure.span(),
            Self::Hydrostatic(span) => *span,
        }
    }

    /// The pressure at the datum, Pa.
    pub fn value(&self) -> f64 {
        match self {
            Self::Uniform(pressure) => pressure.value(),
            Self::Hydrostatic(_) => 0.0,
        }
    }

    /// Whether it grows with depth.
    pub fn is_hydrostatic(&self) -> bool {
        matches!(self, Self::Hydrostatic(_))
    }
}

impl<'de> Deserialize<'de> for InitialPressure {
    fn deserialize<R: Deserializer<'de>>(reader: R) -> Result<Self, R::Error> {
        let Spanned { value, span } = Spanned::<Typed>::deserialize(reader)?;
        Ok(match value {
            Typed::Word => Self::Hydrostatic(span),
            Typed::Number(value) => Self::Uniform(Pressure::si(value).at(span)),
        })
    }
}

/// A pressure before its place is known.
enum Typed {
    Word,
    Number(f64),
}

impl<'de> Deserialize<'de> for Typed {
    fn deserialize<R: Deserializer<'de>>(reader: R) -> Result<Self, R::Error> {
        reader.deserialize_any(TypedVisitor)
    }
}

struct TypedVisitor;

impl Visitor<'_> for TypedVisitor {
    type Value = Typed;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a pressure (Pa) or \"hydrostatic\"")
    }

    #[allow(clippy::cast_precision_loss)]
    fn visit_i64<E: Error>(self, number: i64) -> Result<Typed, E> {
        Pressure::read_number(number as f64).map(|pressure| Typed::Number(pressure.value()))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Typed, E> {
        Pressure::read_number(number).map(|pressure| Typed::Number(pressure.value()))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Typed, E> {
        match text {
            HYDROSTATIC => Ok(Typed::Word),
            _ => Pressure::read_text(text).map(|pressure| Typed::Number(pressure.value())),
        }
    }
}

impl JsonSchema for InitialPressure {
    fn schema_name() -> Cow<'static, str> {
        "InitialPressure".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<Pressure>();
        json_schema!({
            "description": "a uniform pressure, or \"hydrostatic\": the weight of the fluid below the datum",
            "anyOf": [{ "const": HYDROSTATIC }, value],
        })
    }
}

impl Section for Initial {
    const NAME: &'static str = "initial";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        let draft = scene.draft;
        if !scene.has(&draft.mechanics) && !scene.has(&draft.flow) {
            report.needs("[initial]", place, &[("[mechanics]", false)]);
        }
        self.check_stress(scene, report);
        self.check_k0(scene, report);
        if let Some(pressure) = &self.pressure {
            let needed = [("[flow]", scene.has(&draft.flow))];
            report.needs("initial.pressure", pressure.span(), &needed);
            self.check_single_pressure(pressure, scene, report);
        }
    }
}

impl Initial {
    /// The first place where a stress is told.
    fn stress_span(&self) -> Option<Span> {
        let own = self.stress.as_ref().map(|stress| stress.span);
        let gradient = || self.stress_gradient.as_ref().map(|own| own.span);
        let region = || self.regions.first().map(|own| own.stress.span);
        own.or_else(gradient)
            .or_else(|| self.k0.map(|k0| k0.span()))
            .or_else(region)
    }

    fn check_stress(&self, scene: &Context<'_>, report: &mut Report) {
        let mechanics = scene.sound(&scene.draft.mechanics);
        if let Some(place) = self.stress_span() {
            let there = scene.has(&scene.draft.mechanics);
            report.needs("a stress", place, &[("[mechanics]", there)]);
        }
        let older = mechanics.and_then(|own| own.initial_stress.as_ref());
        report.at_most_one(&[
            ("mechanics.initial_stress", older.map(|own| own.span)),
            ("a stress in [initial]", self.stress_span()),
        ]);
        if let Some(stress) = &self.stress {
            stress.check_plane(scene, report);
        }
        for region in &self.regions {
            report.shape(&region.region, scene);
            region.stress.check_plane(scene, report);
        }
        let (Some(gradient), Some(2)) = (&self.stress_gradient, scene.dimension()) else {
            return;
        };
        for (name, component) in [("yz", gradient.yz), ("xz", gradient.xz)] {
            let Some(component) = component else { continue };
            let message = format!("a plane domain has no component `{name}`");
            let fault = Diagnostic::new(message).at(component.span());
            report.add(fault.help("its components are `xx`, `yy`, `zz` and `xy`"));
        }
    }

    fn check_k0(&self, scene: &Context<'_>, report: &mut Report) {
        let Some(k0) = self.k0 else { return };
        report.positive("k0", k0);
        let gravity = scene.has(&scene.draft.gravity);
        report.needs("`k0`", k0.span(), &[("[gravity]", gravity)]);
        for (name, other) in [
            ("stress", self.stress.as_ref().map(|own| own.span)),
            (
                "stress_gradient",
                self.stress_gradient.as_ref().map(|own| own.span),
            ),
        ] {
            report.at_most_one(&[(name, other), ("k0", Some(k0.span()))]);
        }
    }

    /// The pressure at the start is told in one place.
    fn check_single_pressure(
        &self,
        pressure: &InitialPressure,
        scene: &Context<'_>,
        report: &mut Report,
    ) {
        if pressure.is_hydrostatic() {
            let needed = [("[gravity]", scene.has(&scene.draft.gravity))];
            report.needs("a hydrostatic pressure", pressure.span(), &needed);
        }
        let Some(flow) = scene.sound(&scene.draft.flow) else {
            return;
        };
        for (name, span) in [
            ("flow.initial_pressure", flow.initial_pressure.span()),
            ("flow.hydrostatic_start", flow.hydrostatic_start.span),
        ] {
            let typed = Some(span).filter(|span| span.is_somewhere());
            report.at_most_one(&[("initial.pressure", Some(pressure.span())), (name, typed)]);
        }
    }
}
