//! `[flow]`: single-phase flow in the pores; its presence makes the effect exist.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Number, Pressure, dimension};
use crate::scene::shape::Shape;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Single-phase flow in the pores.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Flow {
    /// Discrete operator of the pressure equation.
    pub operator: Operator,
    /// Coefficient of the hourglass term, in units of the mobility.
    pub hourglass: Number,
    /// Gradient of the correspondence operator.
    pub gradient: Spanned<Gradient>,
    /// Pressure at the start, Pa.
    pub initial_pressure: Pressure,
    /// Adds the weight of the fluid to the pressure at the start. Needs `[gravity]`.
    pub hydrostatic_start: Spanned<bool>,
    /// Conditions on the sides; a side that is not named is sealed.
    pub boundary: Boundary,
    /// Prescribed pressure in parts of the domain.
    pub regions: Vec<PressureRegion>,
}

impl Default for Flow {
    fn default() -> Self {
        Self {
            operator: Operator::default(),
            hourglass: Number::si(1.0),
            gradient: Spanned::default(),
            initial_pressure: Pressure::si(0.0),
            hydrostatic_start: Spanned::default(),
            boundary: Boundary::default(),
            regions: Vec::new(),
        }
    }
}

/// Discrete operators of the pressure equation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Operator {
    /// Nonlocal gradient, its transpose, and an hourglass term.
    #[default]
    Correspondence,
    /// A conductance for each bond, from the harmonic mean of the permeabilities.
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

/// Conditions on the sides of the domain; a side that is not named is sealed.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Boundary {
    /// Low x.
    pub left: Option<Spanned<Condition>>,
    /// High x.
    pub right: Option<Spanned<Condition>>,
    /// Low y.
    pub bottom: Option<Spanned<Condition>>,
    /// High y.
    pub top: Option<Spanned<Condition>>,
    /// Low z.
    pub front: Option<Spanned<Condition>>,
    /// High z.
    pub back: Option<Spanned<Condition>>,
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

/// A side of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// Low x.
    Left,
    /// High x.
    Right,
    /// Low y.
    Bottom,
    /// High y.
    Top,
    /// Low z.
    Front,
    /// High z.
    Back,
}

impl Side {
    /// All sides, low before high, x before y before z.
    pub const ALL: [Self; 6] = [
        Self::Left,
        Self::Right,
        Self::Bottom,
        Self::Top,
        Self::Front,
        Self::Back,
    ];

    /// The axis the side is normal to: 0, 1, 2.
    pub const fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the side is at the high end of its axis.
    pub const fn is_high(self) -> bool {
        self as usize % 2 == 1
    }

    /// Name as typed.
    pub const fn name(self) -> &'static str {
        ["left", "right", "bottom", "top", "front", "back"][self as usize]
    }
}

impl Boundary {
    /// The condition on a side, if one was typed.
    pub fn get(&self, side: Side) -> Option<&Spanned<Condition>> {
        let sides = [
            &self.left,
            &self.right,
            &self.bottom,
            &self.top,
            &self.front,
            &self.back,
        ];
        sides[side as usize].as_ref()
    }

    /// The sides with a condition.
    pub fn iter(&self) -> impl Iterator<Item = (Side, &Spanned<Condition>)> {
        Side::ALL
            .into_iter()
            .filter_map(|side| Some((side, self.get(side)?)))
    }
}

impl Flow {
    /// Whether any pressure is prescribed.
    pub fn prescribes_pressure(&self) -> bool {
        !self.regions.is_empty()
            || self
                .boundary
                .iter()
                .any(|(_, side)| matches!(side.value, Condition::Pressure(_)))
    }
}

impl Section for Flow {
    const NAME: &'static str = "flow";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        if !scene.has(&scene.draft.fluid) {
            let fault = Diagnostic::new("[flow] needs a fluid").at(place);
            report.add(fault.help("add [fluid] with viscosity = \"1 cP\""));
        }
        self.check_operator(report);
        check_hydrostatic("hydrostatic_start", self.hydrostatic_start, scene, report);
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
        match self.operator {
            // Without it the checkerboard pressure costs nothing and the matrix is singular.
            Operator::Correspondence => report.positive("hourglass", self.hourglass),
            Operator::Bond => {
                report.not_negative("hourglass", self.hourglass);
                if self.gradient.value != Gradient::Auto {
                    let fault = Diagnostic::new("the bond operator has no gradient to choose");
                    let fault = fault.at(self.gradient.span);
                    report
                        .add(fault.help("remove `gradient`, or use operator = \"correspondence\""));
                }
            }
        }
    }
}

fn check_condition(
    side: Side,
    condition: &Spanned<Condition>,
    scene: &Context<'_>,
    report: &mut Report,
) {
    if scene
        .dimension()
        .is_some_and(|dimension| side.axis() >= dimension)
    {
        let message = format!("a plane domain has no side `{}`", side.name());
        let fault = Diagnostic::new(message).at(condition.span);
        report.add(fault.help("its sides are `left`, `right`, `bottom` and `top`"));
    }
    match &condition.value {
        Condition::Pressure(given) => {
            report.load(&given.pressure, scene);
            check_hydrostatic("hydrostatic", given.hydrostatic, scene, report);
        }
        Condition::Flux(given) => report.load(&given.flux, scene),
        Condition::Sealed(given) if !given.sealed.value => {
            let fault = Diagnostic::new("`sealed` can only be true").at(given.sealed.span);
            report.add(fault.help("write `pressure` or `flux` for an open side"));
        }
        Condition::Sealed(_) => {}
    }
}

fn check_hydrostatic(name: &str, typed: Spanned<bool>, scene: &Context<'_>, report: &mut Report) {
    if typed.value && !scene.has(&scene.draft.gravity) {
        let fault = Diagnostic::new(format!("`{name}` needs [gravity]")).at(typed.span);
        report.add(fault.help("add [gravity] with `acceleration`"));
    }
}
