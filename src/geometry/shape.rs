//! Regions of space by which scenes name groups of points.

use std::cmp::Ordering;
use std::sync::Arc;

/// A region; the boundary belongs to it. Coordinates in metres, as many as the dimension.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// An axis-parallel box.
    Box {
        /// Smallest coordinates.
        min: Vec<f64>,
        /// Largest coordinates.
        max: Vec<f64>,
    },
    /// A disc in 2-D, a ball in 3-D.
    Disc {
        /// Centre.
        centre: Vec<f64>,
        /// Radius.
        radius: f64,
    },
    /// A simple polygon in x and y; a prism of any height in 3-D.
    Polygon {
        /// Corners in order.
        vertices: Vec<[f64; 2]>,
    },
    /// Points of a named set, by their exact places.
    Set {
        /// Name of the set.
        name: String,
        /// Their places, ascending.
        places: Arc<[Vec<f64>]>,
    },
    /// All points with (x − point)·normal ≤ 0.
    HalfPlane {
        /// A point of the boundary.
        point: Vec<f64>,
        /// Direction that leaves the region; its length does not matter.
        normal: Vec<f64>,
    },
}

impl Shape {
    /// A set by the places of its points.
    pub fn set(name: &str, mut places: Vec<Vec<f64>>) -> Self {
        places.sort_unstable_by(|a, b| compared(a, b));
        Shape::Set {
            name: name.to_owned(),
            places: places.into(),
        }
    }

    /// Whether the region contains `x`.
    pub fn contains(&self, x: &[f64]) -> bool {
        match self {
            Shape::Box { min, max } => x
                .iter()
                .zip(min)
                .zip(max)
                .all(|((x, low), high)| low <= x && x <= high),
            Shape::Disc { centre, radius } => {
                let squared: f64 = x.iter().zip(centre).map(|(a, b)| (a - b).powi(2)).sum();
                squared <= radius * radius
            }
            Shape::Polygon { vertices } => polygon_contains(vertices, x[0], x[1]),
            Shape::Set { places, .. } => {
                let order = |place: &Vec<f64>| compared(place, x);
                places.binary_search_by(order).is_ok()
            }
            Shape::HalfPlane { point, normal } => {
                let along: f64 = x
                    .iter()
                    .zip(point)
                    .zip(normal)
                    .map(|((x, p), n)| (x - p) * n)
                    .sum();
                along <= 0.0
            }
        }
    }
}

/// Order of places by their coordinates.
fn compared(a: &[f64], b: &[f64]) -> Ordering {
    let mut axes = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
    axes.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

/// Even-odd rule, with points on an edge inside.
fn polygon_contains(vertices: &[[f64; 2]], x: f64, y: f64) -> bool {
    let mut inside = false;
    for (k, &[x1, y1]) in vertices.iter().enumerate() {
        let [x0, y0] = vertices[(k + vertices.len() - 1) % vertices.len()];
        let cross = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
        let within = (x - x0) * (x - x1) <= 0.0 && (y - y0) * (y - y1) <= 0.0;
        if cross == 0.0 && within {
            return true;
        }
        if (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0) {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_l_shaped_polygon_holds_its_arms_and_edges_but_not_its_notch() {
        let corners = vec![
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        let shape = Shape::Polygon { vertices: corners };
        assert!(shape.contains(&[0.5, 1.5]) && shape.contains(&[1.5, 0.5]));
        assert!(shape.contains(&[0.0, 1.0]) && shape.contains(&[1.0, 1.5, 7.0]));
        assert!(!shape.contains(&[1.5, 1.5]) && !shape.contains(&[-0.1, 0.5]));
    }

    #[test]
    fn a_set_holds_its_points_and_nothing_beside_them() {
        let places = vec![vec![0.5, 0.25], vec![0.1, 0.3], vec![0.1, 0.2]];
        let set = Shape::set("plug", places);
        assert!(
            set.contains(&[0.1, 0.2]) && set.contains(&[0.1, 0.3]) && set.contains(&[0.5, 0.25])
        );
        assert!(!set.contains(&[0.5, 0.250_000_001]) && !set.contains(&[0.1, 0.25]));
    }

    #[test]
    fn a_half_plane_leaves_along_its_normal() {
        let shape = Shape::HalfPlane {
            point: vec![0.5, 0.0],
            normal: vec![2.0, 0.0],
        };
        assert!(shape.contains(&[0.5, 9.0]) && shape.contains(&[0.4, 0.0]));
        assert!(!shape.contains(&[0.6, 0.0]));
    }
}
