//! `[damage]`: the rock breaks; its presence makes the effect exist.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, Number, Time};
use crate::scene::range::{Range, within};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Variational damage (Eqs. 20 to 35). Needs `[mechanics]`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damage {
    /// What damage does to rock.
    #[serde(default)]
    pub model: DamageModel,
    /// Exponent m of the degradation (1 − s)^m, 1.5 or 2; 1.5 in the split model and 2 in that of the paper if
    /// absent.
    pub exponent: Option<Number>,
    /// Coefficient of friction of the faces of cracks that touch; they open by as much of what they slide. Split
    /// model only.
    #[serde(default = "friction")]
    #[schemars(transform = within(&FRICTION))]
    pub friction: Number,
    /// Length scale ℓ over which damage is spread, m; needed where `normalise` is false and by
    /// `horizon.length_scale_ratio`.
    pub length_scale: Option<Length>,
    /// Which part of the elastic energy breaks the rock.
    #[serde(default)]
    pub split: EnergySplit,
    /// Share k of the stiffness that broken rock keeps.
    #[serde(default = "nearly_nothing")]
    #[schemars(transform = within(&RESIDUAL_STIFFNESS))]
    pub residual_stiffness: Number,
    /// How damage weakens the hourglass term.
    #[serde(default)]
    pub hourglass: Hourglass,
    /// Scales the fracture energy so that a crack takes G_c whatever the length scale is: `true` by ℓ/2δ,
    /// `"mean"` by ℓ over the mean effective width of the family, which makes up for the points it is made of.
    /// `"mean"` if absent in the split model, `false` in that of the paper.
    pub normalise: Option<Normalise>,
    /// How equilibrium with damage is found.
    #[serde(default)]
    pub method: DamageMethod,
    /// Forces out of balance, relative to all forces, that count as equilibrium.
    #[serde(default = "balance")]
    #[schemars(transform = within(&TOLERANCE))]
    pub tolerance: Number,
    /// The step fails beyond this many iterations.
    #[serde(default = "thousand")]
    #[schemars(transform = within(&ITERATIONS))]
    pub iterations: Spanned<u64>,
    /// Growth of damage at a point, in one step, above which an adaptive step is cut.
    #[serde(default = "third")]
    #[schemars(transform = within(&LARGEST_INCREMENT))]
    pub largest_increment: Number,
    /// Shortest adaptive step, s: growth that goes on in it is accepted however fast it is. A
    /// hundredth of the run if absent; cut to the run.
    pub shortest_step: Option<Time>,
}

/// The notched square: peak force higher by 0.2 % at 1e-3, by 3 % at 1e-2, by 40 % at 0.1; the pumped
/// crack: pressure higher by 0.4 %, 3.4 % and 30 %. From 1e-14 to 1e-6 both stay within 4e-6.
const RESIDUAL_STIFFNESS: Range = Range {
    key: "residual_stiffness",
    low: 1e-14,
    high: 1e-3,
    why: "rounding hides less, and with more a crack still carries load and holds its faces together",
};
/// The notched square: peak force the same within 5e-5 from 1e-12 to 1e-3, whose forces balance to
/// 1e-5; at 1e-2 they are out of balance by 1e-2, at 0.09 by 4.4e-2, with a peak 1 % higher.
const TOLERANCE: Range = Range {
    key: "tolerance",
    low: 1e-12,
    high: 1e-3,
    why: "rounding stops the iteration at less, and with more forces are out of balance while rock breaks",
};
const FRICTION: Range = Range {
    key: "friction",
    low: 0.0,
    high: 10.0,
    why: "faces that touch slide by less than all of what presses them, and rock has 0.4 to 1",
};
const ITERATIONS: Range = Range {
    key: "iterations",
    low: 1.0,
    high: 1e6,
    why: "an iteration that has not found equilibrium by then never does",
};
/// The notched square: the same peak force within 0.2 % from 1 (21 steps) to 0.01 (519 steps).
const LARGEST_INCREMENT: Range = Range {
    key: "largest_increment",
    low: 1e-3,
    high: 1.0,
    why: "damage ends at 1, and steps that let hardly any grow never break the rock",
};

/// What damage does to rock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DamageModel {
    /// A broken point is cut by a plane: it loses the traction there, to which the fluid in the crack adds, and keeps
    /// the stress along it. Compression never breaks it.
    #[default]
    Split,
    /// A part of the strain's energy is lost (Eqs. 20 to 35): what the paper does. In-situ stress breaks rock under
    /// compression, and the volume in a crack is not what was pumped.
    Paper,
}

/// Splits of the elastic energy into what breaks the rock and what does not (Eq. 24).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnergySplit {
    /// Positive principal strains and expansion break the rock.
    #[default]
    Spectral,
    /// Expansion and all change of shape break the rock.
    VolumetricDeviatoric,
    /// All of the energy breaks the rock.
    None,
}

/// How damage weakens the hourglass term.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Hourglass {
    /// Like the stress, and its energy drives damage too.
    #[default]
    Variational,
    /// By 1 − s, as printed (Eq. 53): a crack then takes more energy than damage tells.
    Linear,
}

/// What the fracture energy is scaled by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Normalise {
    /// Nothing, `false`: a crack takes what its band makes of G_c/ℓ.
    #[default]
    Off,
    /// ℓ/2δ, `true`.
    Horizon,
    /// ℓ over the mean effective width of the family, `"mean"`.
    Mean,
}

impl<'de> Deserialize<'de> for Normalise {
    fn deserialize<R: Deserializer<'de>>(reader: R) -> Result<Self, R::Error> {
        reader.deserialize_any(NormaliseVisitor)
    }
}

struct NormaliseVisitor;

impl Visitor<'_> for NormaliseVisitor {
    type Value = Normalise;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("`true`, `false` or \"mean\"")
    }

    fn visit_bool<E: Error>(self, on: bool) -> Result<Normalise, E> {
        Ok(match on {
            true => Normalise::Horizon,
            false => Normalise::Off,
        })
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Normalise, E> {
        match text {
            "mean" => Ok(Normalise::Mean),
            _ => Err(E::custom(format!(
                "expected `true`, `false` or \"mean\", found \"{text}\""
            ))),
        }
    }
}

impl JsonSchema for Normalise {
    fn schema_name() -> Cow<'static, str> {
        "Normalise".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": [false, true, "mean"] })
    }
}

/// Ways to equilibrium with damage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DamageMethod {
    /// Newton's method where it works, alternate minimisation elsewhere.
    #[default]
    Auto,
    /// Newton's method with damage eliminated.
    Newton,
    /// Displacement at fixed damage, then damage, in turns.
    Alternate,
}

fn nearly_nothing() -> Number {
    Number::si(1e-9)
}

fn balance() -> Number {
    Number::si(1e-5)
}

fn friction() -> Number {
    Number::si(0.6)
}

fn thousand() -> Spanned<u64> {
    Spanned::nowhere(1000)
}

fn third() -> Number {
    Number::si(0.3)
}

impl Damage {
    /// How strength follows from the fracture energy.
    pub fn normalisation(&self) -> Normalise {
        self.normalise.unwrap_or(match self.model {
            DamageModel::Split => Normalise::Mean,
            DamageModel::Paper => Normalise::Off,
        })
    }
}

impl Damage {
    /// Refuses what the split model does not know.
    fn check_split(&self, place: Span, report: &mut Report) {
        let keys = [
            ("split", self.split != EnergySplit::default()),
            ("hourglass", self.hourglass != Hourglass::default()),
        ];
        for (key, _) in keys.into_iter().filter(|(_, typed)| *typed) {
            let fault = format!(
                "`{key}` belongs to damage.model = \"paper\": the split model cuts a point by a plane; leave it out, or \
                 set damage.model = \"paper\""
            );
            report.add(Diagnostic::new(fault).at(place));
        }
        FRICTION.check(self.friction, report);
    }
}

impl Damage {
    /// Refuses what the model of the paper does not know.
    fn check_paper(&self, report: &mut Report) {
        if (self.friction.value() - friction().value()).abs() > 0.0 {
            let fault = "`friction` belongs to damage.model = \"split\": faces of the model of the paper do not touch; leave \
                         it out, or set damage.model = \"split\"";
            report.add(Diagnostic::new(fault).at(self.friction.span()));
        }
    }
}

impl Section for Damage {
    const NAME: &'static str = "damage";

    fn check(&self, place: Span, _: &Context<'_>, report: &mut Report) {
        match self.model {
            DamageModel::Split => self.check_split(place, report),
            DamageModel::Paper => self.check_paper(report),
        }
        match self.length_scale {
            Some(length) => report.positive("length_scale", length),
            None if self.normalisation() == Normalise::Off => {
                let fault = "[damage] needs `length_scale`, or normalise = \"mean\"";
                report.add(Diagnostic::new(fault).at(place));
            }
            None => {}
        }
        if let Some(exponent) = self.exponent.filter(|m| ![1.5, 2.0].contains(&m.value())) {
            let fault = Diagnostic::new(format!(
                "`exponent` = {}: there are laws for 1.5 and 2 only",
                exponent.value()
            ));
            report.add(fault.at(exponent.span()));
        }
        RESIDUAL_STIFFNESS.check(self.residual_stiffness, report);
        TOLERANCE.check(self.tolerance, report);
        ITERATIONS.check_count(self.iterations, report);
        LARGEST_INCREMENT.check(self.largest_increment, report);
        let shortest = self.shortest_step;
        shortest
            .into_iter()
            .for_each(|step| report.positive("shortest_step", step));
    }
}
