//! `[horizon]`: how far a point sees, and how strongly.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::damage::Damage;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, Number};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How far a point sees (δ), and how strongly (ω). At most one of `neighbours`,
/// `radius`, `ratio` and `length_scale_ratio`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Horizon {
    /// δ is the distance to this many nearest points; 15 if no size is given.
    pub neighbours: Option<Spanned<u64>>,
    /// δ, m.
    pub radius: Option<Length>,
    /// δ over the spacing of the points.
    pub ratio: Option<Number>,
    /// δ over the length scale ℓ of damage. Needs `[damage]`.
    pub length_scale_ratio: Option<Number>,
    /// Influence function ω of the bond length.
    pub influence: Influence,
}

/// Influence function ω(|ξ|).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Influence {
    /// 1/|ξ|².
    #[default]
    InverseSquare,
    /// 1/|ξ|.
    Inverse,
    /// 1.
    Constant,
    /// A Gaussian of |ξ|/δ.
    Gaussian,
}

/// How the horizon's size is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HorizonSize {
    /// Distance to the n-th nearest point.
    Neighbours(usize),
    /// A length, m.
    Radius(f64),
    /// A multiple of the spacing of the points.
    Ratio(f64),
}

impl Horizon {
    /// The size, with the damage that a ratio to its length scale refers to; 15 neighbours if
    /// nothing was typed.
    pub fn size(&self, damage: Option<&Damage>) -> HorizonSize {
        if let (Some(ratio), Some(damage)) = (self.length_scale_ratio, damage) {
            return HorizonSize::Radius(ratio.value() * damage.length_scale.value());
        }
        match (self.neighbours, self.radius, self.ratio) {
            (_, Some(radius), _) => HorizonSize::Radius(radius.value()),
            (_, _, Some(ratio)) => HorizonSize::Ratio(ratio.value()),
            (Some(n), ..) => {
                HorizonSize::Neighbours(usize::try_from(n.value).unwrap_or(usize::MAX))
            }
            _ => HorizonSize::Neighbours(15),
        }
    }

    /// Where the size was typed.
    pub fn span(&self) -> Span {
        let neighbours = self.neighbours.map(|neighbours| neighbours.span);
        let typed = self
            .radius
            .map(|r| r.span())
            .or(self.ratio.map(|r| r.span()))
            .or(self.length_scale_ratio.map(|r| r.span()))
            .or(neighbours);
        typed.unwrap_or_default()
    }
}

impl Section for Horizon {
    const NAME: &'static str = "horizon";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.at_most_one(&[
            (
                "neighbours",
                self.neighbours.map(|neighbours| neighbours.span),
            ),
            ("radius", self.radius.map(|radius| radius.span())),
            ("ratio", self.ratio.map(|ratio| ratio.span())),
            (
                "length_scale_ratio",
                self.length_scale_ratio.map(|ratio| ratio.span()),
            ),
        ]);
        if let Some(neighbours) = self.neighbours {
            // Fewer bonds than this cannot span the space.
            report.at_least(
                "neighbours",
                neighbours,
                scene.dimension().unwrap_or(2) as u64 + 1,
            );
        }
        if let Some(ratio) = self.length_scale_ratio {
            report.positive("length_scale_ratio", ratio);
            let damage = scene.has(&scene.draft.damage);
            report.needs(
                "`length_scale_ratio`",
                ratio.span(),
                &[("[damage]", damage)],
            );
        }
        if let Some(radius) = self.radius {
            report.positive("radius", radius);
        }
        if let Some(ratio) = self.ratio
            && ratio.value() < 1.0
        {
            let fault = Diagnostic::new("`ratio` below 1 leaves every point without neighbours");
            report.add(
                fault
                    .at(ratio.span())
                    .help("2.3 gives about 20 neighbours in a plane"),
            );
        }
    }
}
