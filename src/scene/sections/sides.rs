//! The sides of the domain, and what holds on each of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::geometry;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report};

/// A side of the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
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

    /// The side as the cloud numbers it.
    pub const fn resolved(self) -> geometry::Side {
        geometry::Side {
            axis: self.axis(),
            upper: self.is_high(),
        }
    }
}

/// Conditions on the sides of the domain; a side that is not named has the default one.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Boundary<C> {
    /// Low x.
    pub left: Option<Spanned<C>>,
    /// High x.
    pub right: Option<Spanned<C>>,
    /// Low y.
    pub bottom: Option<Spanned<C>>,
    /// High y.
    pub top: Option<Spanned<C>>,
    /// Low z.
    pub front: Option<Spanned<C>>,
    /// High z.
    pub back: Option<Spanned<C>>,
}

impl<C> Default for Boundary<C> {
    fn default() -> Self {
        Self {
            left: None,
            right: None,
            bottom: None,
            top: None,
            front: None,
            back: None,
        }
    }
}

impl<C> Boundary<C> {
    /// The condition on a side, if one was typed.
    pub fn get(&self, side: Side) -> Option<&Spanned<C>> {
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
    pub fn iter(&self) -> impl Iterator<Item = (Side, &Spanned<C>)> {
        Side::ALL
            .into_iter()
            .filter_map(|side| Some((side, self.get(side)?)))
    }
}

/// A plane domain has no sides across z.
pub(super) fn check_side(side: Side, place: Span, scene: &Context<'_>, report: &mut Report) {
    if scene
        .dimension()
        .is_some_and(|dimension| side.axis() >= dimension)
    {
        let message = format!("a plane domain has no side `{}`", side.name());
        let fault = Diagnostic::new(message).at(place);
        report.add(fault.help("its sides are `left`, `right`, `bottom` and `top`"));
    }
}
