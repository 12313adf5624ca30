//! `[cracks.NAME]`: cracks that are there from the start.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::geometry::Bounds;
use super::wells::check_rate_unit;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Length, Number, dimension, values};
use crate::scene::span::{Entry, Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A crack that is there from the start, at exactly one of `points` and `disc`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crack {
    /// How it is made.
    #[serde(default)]
    pub kind: Spanned<CrackKind>,
    /// In a plane: places from one tip over the corners to the other tip, m, `[x, y]` each.
    pub points: Option<Spanned<Vec<[Length; 2]>>>,
    /// In three dimensions: a flat disc. Needs kind = "damaged".
    pub disc: Option<Spanned<CrackDisc>>,
    /// Pressure in it, Pa; positive opens the crack. Without flow it presses on both faces, with
    /// flow it is that of the fluid in the crack.
    pub pressure: Option<Load<dimension::Pressure>>,
    /// Fluid that is pumped into it. Needs `[flow]`; excludes `pressure`.
    pub injection: Option<Spanned<Injection>>,
}

/// Ways to make a crack.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CrackKind {
    /// Bonds across it are cut, so that its faces are free.
    #[default]
    Cut,
    /// Points within one horizon of it are broken. Needs `[damage]`.
    Damaged,
}

/// A flat disc in space.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackDisc {
    /// Centre, m, `[x, y, z]`.
    pub centre: Spanned<Vec<Length>>,
    /// Direction across the disc; of any length but zero.
    pub normal: Spanned<Vec<Number>>,
    /// Radius, m.
    pub radius: Length,
}

/// Fluid that is pumped into a crack.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Injection {
    /// Volume rate into the crack, m³/s, or m²/s per metre of `geometry.thickness` in a plane, for the whole
    /// plane: a place on a side of symmetry takes half of it.
    pub rate: Load<dimension::FlowRate>,
    /// Where, m.
    pub at: Spanned<Vec<Length>>,
}

impl CrackDisc {
    /// The normal, of length one.
    pub fn unit_normal(&self) -> Vec<f64> {
        let normal = values(&self.normal);
        let length = normal.iter().copied().fold(0.0, f64::hypot);
        normal.iter().map(|x| x / length).collect()
    }

    fn check(&self, scene: &Context<'_>, report: &mut Report) {
        report.positive("radius", self.radius);
        let complete = [
            report.vector("centre", &self.centre, Some(3)),
            report.vector("normal", &self.normal, Some(3)),
        ];
        let directed = self.normal.iter().any(|x| x.value().abs() > 0.0);
        if !directed {
            let fault = Diagnostic::new("`normal` must not be zero");
            report.add(fault.at(self.normal.span));
        }
        if let Some(bounds) = scene.bounds()
            && bounds.min.len() == 3
            && complete == [true, true]
            && directed
            && self.leaves(&bounds)
        {
            let fault = Diagnostic::new("the crack leaves the domain").at(self.centre.span);
            report.add(fault.help(format!("the domain is {bounds}")));
        }
    }

    /// A centre on a side, as planes of symmetry have it, leaves half a disc.
    fn leaves(&self, bounds: &Bounds) -> bool {
        let mut ends = [values(&self.centre), values(&self.centre)];
        for (axis, along) in self.unit_normal().into_iter().enumerate() {
            let x = ends[0][axis];
            let slack = 1e-9 * (bounds.max[axis] - bounds.min[axis]);
            let reach = self.radius.value() * (1.0 - along * along).max(0.0).sqrt();
            if (x - bounds.min[axis]).abs() > slack {
                ends[0][axis] = x - reach;
            }
            if (x - bounds.max[axis]).abs() > slack {
                ends[1][axis] = x + reach;
            }
        }
        !ends.iter().all(|end| bounds.contain(end))
    }
}

impl Crack {
    /// Where its place was typed.
    pub fn span(&self) -> Span {
        let points = self.points.as_ref().map(|points| points.span);
        points
            .or(self.disc.as_ref().map(|disc| disc.span))
            .unwrap_or_default()
    }

    /// The chain of places in SI numbers; empty without one.
    pub fn chain(&self) -> Vec<[f64; 2]> {
        let points = self.points.as_ref().map_or(&[][..], |points| &points.value);
        points.iter().map(|x| x.map(|x| x.value())).collect()
    }

    fn check_place(&self, name: Span, scene: &Context<'_>, report: &mut Report) {
        let points = self.points.as_ref().map(|points| points.span);
        let disc = self.disc.as_ref().map(|disc| disc.span);
        if points.is_none() && disc.is_none() {
            let fault = Diagnostic::new("a crack needs `points` or a `disc`").at(name);
            report.add(fault.help("in a plane: points = [[x, y], [x, y]]"));
        }
        report.at_most_one(&[("points", points), ("disc", disc)]);
        let dimension = scene.dimension();
        if let Some(place) = points.filter(|_| dimension == Some(3)) {
            report.add(points_in_space(place));
        } else if let Some(points) = &self.points {
            self.check_chain(points.span, scene, report);
        }
        if let Some(place) = disc.filter(|_| dimension == Some(2)) {
            report.add(disc_in_plane(place));
        } else if let Some(disc) = &self.disc {
            disc.check(scene, report);
        }
        if let Some(place) = disc.filter(|_| self.kind.value == CrackKind::Cut) {
            let fault = Diagnostic::new("a `disc` needs kind = \"damaged\"").at(place);
            report.add(fault.help("set kind = \"damaged\", and add [damage]"));
        }
    }

    fn check_chain(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        let places = self.chain();
        if places.len() < 2 {
            let fault = Diagnostic::new("a crack needs at least two `points`");
            report.add(fault.at(place));
        }
        let same =
            |pair: &[[f64; 2]]| (0..2).all(|axis| pair[0][axis].total_cmp(&pair[1][axis]).is_eq());
        if places.windows(2).any(same) {
            let fault = Diagnostic::new("two `points` of a crack in a row are the same");
            report.add(fault.at(place).help("remove one"));
        }
        if let Some(bounds) = scene.bounds()
            && !places.iter().all(|place| bounds.contain(place))
        {
            let fault = Diagnostic::new("the crack leaves the domain").at(place);
            report.add(fault.help(format!("the domain is {bounds}")));
        }
    }

    fn check_fluid(&self, scene: &Context<'_>, report: &mut Report) {
        let pressure = self.pressure.as_ref();
        pressure
            .into_iter()
            .for_each(|load| report.load(load, scene));
        let Some(Spanned { value, span }) = &self.injection else {
            return;
        };
        let pressed = pressure.map(Load::span);
        report.at_most_one(&[("pressure", pressed), ("injection", Some(*span))]);
        report.position("at", &value.at, scene);
        report.load(&value.rate, scene);
        check_rate_unit(&value.rate, scene, report);
    }
}

/// The fault of `points` in three dimensions, at their place.
pub(crate) fn points_in_space(place: Span) -> Diagnostic {
    let fault = Diagnostic::new("the `points` of a crack are for planes").at(place);
    fault.help("in three dimensions give a `disc`, with kind = \"damaged\"")
}

/// The fault of a `disc` in a plane, at its place.
pub(crate) fn disc_in_plane(place: Span) -> Diagnostic {
    let fault = Diagnostic::new("the `disc` of a crack is for three dimensions").at(place);
    fault.help("in a plane give `points`")
}

impl Section for Named<Crack> {
    const NAME: &'static str = "cracks";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.names(self);
        for Entry { span, value, .. } in self {
            value.check_place(*span, scene, report);
            value.check_fluid(scene, report);
        }
    }
}
