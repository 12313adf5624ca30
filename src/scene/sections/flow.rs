//! `[flow]`: single-phase flow in the pores; its presence makes the effect exist.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sides::{Boundary, Side, check_side};
use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Number, Pressure, dimension};
use crate::scene::range::{Range, within};
use crate::scene::shape::Shape;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Single-phase flow in the pores.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Flow {
    /// Discrete operator of the pressure equation.
    pub operator: Spanned<Operator>,
    /// Coefficient of the hourglass term, in units of the mobility.
    #[schemars(transform = within(&HOURGLASS))]
    pub hourglass: Number,
    /// Gradient of the correspondence operator.
    pub gradient: Spanned<Gradient>,
    /// Pressure at the start, Pa.
    pub initial_pressure: Pressure,
    /// Adds the weight of the fluid to the pressure at the start. Needs `[gravity]`.
    pub hydrostatic_start: Spanned<bool>,
    /// Whether pressures below zero are meant: suction, or pressures that count from another one than
    /// zero. Without it the first one is a warning.
    pub suction: bool,
    /// Conditions on the sides; a side that is not named is sealed.
    pub boundary: Boundary<Condition>,
    /// Prescribed pressure in parts of the domain.
    pub regions: Vec<PressureRegion>,
}

/// The confined five-spot on 30 × 30 points: root-mean-square error 2.5e-5 of the range at 1, 2.6e-3
/// at 0.1, 8.5e-3 at 10, but 2.5e-2 at 0.01, 2.7e-2 at 30, and 28 times the range at 1e-6.
const HOURGLASS: Range = Range {
    key: "hourglass",
    low: 0.1,
    high: 10.0,
    why: "less lets the pressure alternate from point to point, more stands in the way of flow \
          (1 cancels the second hop on isotropic families)",
};

impl Default for Flow {
    fn default() -> Self {
        Self {
            operator: Spanned::default(),
            hourglass: Number::si(1.0),
            gradient: Spanned::default(),
            initial_pressure: Pressure::si(0.0),
            hydrostatic_start: Spanned::default(),
            suction: false,
            boundary: Boundary::default(),
            regions: Vec::new(),
        }
    }
}

/// Discrete operators of the pressure equation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Operator {
    /// Path; correspondence where `gradient` is named. With `[fracture_flow]`, and on points of `any_volume`,
    /// bond where permeabilities differ by a factor of more than 3 (10 on irregular clouds) or fractures
    /// conduct, correspondence elsewhere.
    #[default]
    Auto,
    /// Conductances between cells that touch, from what lies on the way between their points. Right across
    /// and along layers, channels and barriers of any contrast; second order on every cloud.
    Path,
    /// Nonlocal gradient, its transpose, and an hourglass term. Second order on every cloud with a
    /// divergence-consistent gradient; behaves like an arithmetic mean where permeabilities meet.
    Correspondence,
    /// A conductance for each bond of a family, from the harmonic mean of the permeabilities at its ends.
    /// Right across thick layers; thin ones and channels are not seen; on irregular clouds it has an error
    /// that does not fall with the spacing.
    Bond,
}

/// Gradients of the correspondence operator.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gradient {
    /// Plain on uniform clouds, divergence-consistent on others.
    #[default]
    Auto,
    /// As in Eq. 57.
    Plain,
    /// Corrected so that the discrete divergence theorem holds.
    DivergenceConsistent,
}

/// What holds on a side: exactly one of `pressure`, `flux`, `sealed`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename = "Condition by key", rename_all = "kebab-case")]
#[schemars(rename = "Condition", untagged)]
pub enum Condition {
    /// A prescribed pressure.
    Pressure(PressureCondition),
    /// A prescribed flux.
    Flux(FluxCondition),
    /// No flux.
    Sealed(SealedCondition),
}

/// A prescribed pressure.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureCondition {
    /// Pressure, Pa; with `hydrostatic` at the highest point of the side.
    pub pressure: Load<dimension::Pressure>,
    /// Adds the weight of the fluid along the side. Needs `[gravity]`.
    #[serde(default)]
    pub hydrostatic: Spanned<bool>,
}

/// A prescribed flux.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluxCondition {
    /// Volume per area and time into the domain, m/s.
    pub flux: Load<dimension::Flux>,
}

/// No flux.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SealedCondition {
    /// Always `true`.
    pub sealed: Spanned<bool>,
}

/// A prescribed pressure on all points in a region.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureRegion {
    /// Where.
    pub region: Spanned<Shape>,
    /// Pressure, Pa.
    pub pressure: Load<dimension::Pressure>,
}

impl Section for Flow {
    const NAME: &'static str = "flow";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        if !scene.has(&scene.draft.fluid) {
            let fault = Diagnostic::new("[flow] needs a fluid").at(place);
            report.add(fault.help("add [fluid] with viscosity = \"1 cP\""));
        }
        self.check_operator(report);
        for (side, condition) in self.boundary.iter() {
            check_condition(side, condition, scene, report);
        }
        for region in &self.regions {
            report.shape(&region.region, scene);
            report.load(&region.pressure, scene);
        }
    }
}

impl Flow {
    fn check_operator(&self, report: &mut Report) {
        HOURGLASS.check(self.hourglass, report);
        let name = match self.operator.value {
            Operator::Auto | Operator::Correspondence => return,
            Operator::Path => "path",
            Operator::Bond => "bond",
        };
        if self.gradient.value != Gradient::Auto {
            let fault = Diagnostic::new(format!("the {name} operator has no gradient to choose"));
            let fault = fault.at(self.gradient.span);
            report.add(fault.help("remove `gradient`, or use operator = \"correspondence\""));
        }
    }
}

fn check_condition(
    side: Side,
    condition: &Spanned<Condition>,
    scene: &Context<'_>,
    report: &mut Report,
) {
    check_side(side, condition.span, scene, report);
    match &condition.value {
        Condition::Pressure(given) => {
            report.load(&given.pressure, scene);
        }
        Condition::Flux(given) => report.load(&given.flux, scene),
        Condition::Sealed(given) if !given.sealed.value => {
            let fault = Diagnostic::new("`sealed` can only be true").at(given.sealed.span);
            report.add(fault.help("write `pressure` or `flux` for an open side"));
        }
        Condition::Sealed(_) => {}
    }
}
