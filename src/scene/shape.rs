//! Shapes that select points: boxes, discs, polygons and half-planes.

use schemars::JsonSchema;
use serde::Deserialize;

use super::quantity::{Length, Number, values};
use super::span::Spanned;
use crate::geometry;

/// A part of space; its boundary belongs to it.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(tag = "type")]
pub enum Shape {
    /// A rectangle or a cuboid along the axes.
    Box(BoxShape),
    /// A disc, or a ball in three dimensions.
    #[serde(alias = "ball")]
    Disc(DiscShape),
    /// A polygon in x and y, at any z.
    Polygon(PolygonShape),
    /// Everything on one side of a line or plane.
    HalfPlane(HalfPlaneShape),
    /// A set of the mesh that the geometry is read from.
    Set(SetShape),
}

/// A rectangle or a cuboid along the axes.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxShape {
    /// Lowest corner, m.
    pub min: Spanned<Vec<Length>>,
    /// Highest corner, m.
    pub max: Spanned<Vec<Length>>,
}

/// A disc, or a ball in three dimensions.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscShape {
    /// Centre, m.
    pub centre: Spanned<Vec<Length>>,
    /// Radius, m.
    pub radius: Length,
}

/// A polygon in x and y, at any z; inside by the even-odd rule.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolygonShape {
    /// Corners in order, m, `[x, y]` each. The last one joins the first.
    pub vertices: Spanned<Vec<[Length; 2]>>,
}

/// The points **x** with (**x** − point)·normal ≤ 0.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfPlaneShape {
    /// A point on the plane, m.
    pub point: Spanned<Vec<Length>>,
    /// Direction out of the half-plane; of any length but zero.
    pub normal: Spanned<Vec<Number>>,
}

/// A set of the mesh that the geometry is read from.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetShape {
    /// Name of a physical group (Gmsh) or of a set of elements or nodes (Abaqus).
    pub name: Spanned<String>,
}

impl Shape {
    /// The shape in SI numbers; a set has its points only once the mesh is read.
    pub fn resolved(&self) -> geometry::Shape {
        match self {
            Self::Set(shape) => geometry::Shape::set(&shape.name, Vec::new()),
            Self::Box(shape) => geometry::Shape::Box {
                min: values(&shape.min),
                max: values(&shape.max),
            },
            Self::Disc(shape) => geometry::Shape::Disc {
                centre: values(&shape.centre),
                radius: shape.radius.value(),
            },
            Self::Polygon(shape) => geometry::Shape::Polygon {
                vertices: shape
                    .vertices
                    .iter()
                    .map(|v| v.map(|x| x.value()))
                    .collect(),
            },
            Self::HalfPlane(shape) => geometry::Shape::HalfPlane {
                point: values(&shape.point),
                normal: values(&shape.normal),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::quantity::Quantity;

    fn point<D>(values: &[f64]) -> Spanned<Vec<Quantity<D>>> {
        Spanned::nowhere(values.iter().map(|&value| Quantity::si(value)).collect())
    }

    fn check(shape: &Shape, inside: &[&[f64]], outside: &[&[f64]]) {
        for position in inside {
            assert!(
                shape.resolved().contains(position),
                "{position:?} is in {shape:?}"
            );
        }
        for position in outside {
            assert!(
                !shape.resolved().contains(position),
                "{position:?} is not in {shape:?}"
            );
        }
    }

    #[test]
    fn a_box_contains_its_corners() {
        let shape = Shape::Box(BoxShape {
            min: point(&[0.0, 1.0]),
            max: point(&[2.0, 3.0]),
        });
        check(
            &shape,
            &[&[0.0, 1.0], &[2.0, 3.0], &[1.0, 2.0]],
            &[&[-0.1, 2.0], &[1.0, 3.1]],
        );
    }

    #[test]
    fn a_disc_contains_its_rim_and_a_ball_its_surface() {
        let disc = Shape::Disc(DiscShape {
            centre: point(&[1.0, 1.0]),
            radius: Length::si(5.0),
        });
        check(&disc, &[&[4.0, 5.0], &[1.0, 1.0]], &[&[4.1, 5.0]]);
        let centre = point(&[0.0, 0.0, 0.0]);
        let ball = Shape::Disc(DiscShape {
            centre,
            radius: Length::si(3.0),
        });
        check(&ball, &[&[1.0, 2.0, 2.0]], &[&[2.0, 2.0, 2.0]]);
    }

    #[test]
    fn a_polygon_with_a_notch_leaves_the_notch_out() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let vertices = Spanned::nowhere(corners.map(|c| c.map(Length::si)).to_vec());
        let shape = Shape::Polygon(PolygonShape { vertices });
        let inside: &[&[f64]] = &[
            &[2.0, 0.5],
            &[0.5, 3.0],
            &[2.0, 1.0],
            &[2.0, 0.0],
            &[4.0, 4.0],
        ];
        check(
            &shape,
            inside,
            &[&[2.0, 1.5], &[5.0, 0.0], &[-1.0, 0.0], &[2.0, 4.0]],
        );
        assert!(
            shape.resolved().contains(&[2.0, 0.5, 99.0]),
            "z does not matter"
        );
    }

    #[test]
    fn a_half_plane_lies_against_its_normal() {
        let shape = Shape::HalfPlane(HalfPlaneShape {
            point: point(&[1.0, 0.0]),
            normal: point(&[2.0, 0.0]),
        });
        check(&shape, &[&[1.0, 7.0], &[-3.0, 0.0]], &[&[1.1, 0.0]]);
    }
}
