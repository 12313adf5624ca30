//! `[horizon]`: how far a point sees, and how strongly.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::damage::{Damage, DamageModel};
use crate::scene::quantity::{Length, Number};
use crate::scene::range::{Range, within};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// How far a point sees (δ), and how strongly (ω). At most one of `neighbours`,
/// `radius`, `ratio` and `length_scale_ratio`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Horizon {
    /// δ is the distance to this many nearest points; 15 if no size is given, but 2.3 spacings where rock breaks in
    /// the split model.
    #[schemars(transform = within(&NEIGHBOURS))]
    pub neighbours: Option<Spanned<u64>>,
    /// δ, m.
    pub radius: Option<Length>,
    /// δ over the spacing of the points.
    #[schemars(transform = within(&RATIO))]
    pub ratio: Option<Number>,
    /// δ over the length scale ℓ of damage. Needs `[damage]`.
    #[schemars(transform = within(&LENGTH_SCALE_RATIO))]
    pub length_scale_ratio: Option<Number>,
    /// Influence function ω of the bond length.
    pub influence: Influence,
}

/// The confined five-spot on 40 × 40 points: error 1.1e-5 with 15, 1.6e-3 with 250 (largest 1.4 %),
/// 1.3e-2 with 1000 (largest 13 %). Fewer than the dimension plus one cannot span the space.
const NEIGHBOURS: Range = Range {
    key: "neighbours",
    low: 3.0,
    high: 500.0,
    why: "fewer bonds cannot span the space (three dimensions need 4), and wide families smear what is \
          narrower than they are",
};
/// As for the neighbours: error 2.0e-5 at 3, 1.9e-3 at 10 (largest 1.5 %), 7.7e-3 at 15 (largest 8.6 %).
const RATIO: Range = Range {
    key: "ratio",
    low: 1.0,
    high: 10.0,
    why: "below 1 a point has no neighbours, and wide families smear what is narrower than they are; 2.3 \
          gives about 20 neighbours in a plane",
};
const LENGTH_SCALE_RATIO: Range = Range {
    key: "length_scale_ratio",
    low: 0.1,
    high: 5.0,
    why: "a crack takes 2δ/ℓ times its fracture energy, which is right at 0.5",
};

/// δ/Δx at which cracks take the same in all directions: 0.87 to 0.95 of 2δ c (see `ratio_warning`).
const ROUND: f64 = 2.3;

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
    /// nothing was typed, or 2.3 spacings where rock breaks in the split model.
    pub fn size(&self, damage: Option<&Damage>) -> HorizonSize {
        let length = damage.and_then(|damage| damage.length_scale);
        if let (Some(ratio), Some(length)) = (self.length_scale_ratio, length) {
            return HorizonSize::Radius(ratio.value() * length.value());
        }
        match (self.neighbours, self.radius, self.ratio) {
            (_, Some(radius), _) => HorizonSize::Radius(radius.value()),
            (_, _, Some(ratio)) => HorizonSize::Ratio(ratio.value()),
            (Some(n), ..) => {
                HorizonSize::Neighbours(usize::try_from(n.value).unwrap_or(usize::MAX))
            }
            _ if damage.is_some_and(|damage| damage.model == DamageModel::Split) => {
                HorizonSize::Ratio(ROUND)
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
            NEIGHBOURS.check_count(neighbours, report);
            if scene.dimension() == Some(3) && neighbours.value == 3 {
                report.at_least("neighbours", neighbours, 4);
            }
        }
        if let Some(ratio) = self.length_scale_ratio {
            LENGTH_SCALE_RATIO.check(ratio, report);
            let damage = scene.has(&scene.draft.damage);
            // Damage may do without a length scale, a ratio to it may not.
            let missing = (scene.sound(&scene.draft.damage))
                .is_some_and(|damage| damage.length_scale.is_none());
            report.needs(
                "`length_scale_ratio`",
                ratio.span(),
                &[("[damage]", damage), ("damage.length_scale", !missing)],
            );
        }
        if let Some(radius) = self.radius {
            report.positive("radius", radius);
        }
        self.ratio
            .into_iter()
            .for_each(|ratio| RATIO.check(ratio, report));
    }
}
