//! What the cells of a mesh have on the sides of their bounds, and where they end elsewhere.

use std::collections::HashMap;

use super::Mesh;
use super::topology::Topology;

/// The border of the cells of a mesh.
pub(super) struct Border {
    /// Area on each side of the bounds, m^(D−1); shape `(2D,)`, low and high side of each axis.
    pub(super) side_area: Vec<f64>,
    /// Balls that touch the other faces of the border from outside: centre and radius, m.
    pub(super) surface: Vec<(Vec<f64>, f64)>,
}

impl Topology {
    /// The border of the cells in a box from its lowest to its highest corner; faces nearer than `near` to one of its sides
    /// lie on it.
    pub(super) fn border(
        &self,
        mesh: &Mesh,
        bounds: [[f64; 3]; 2],
        near: f64,
        unit: f64,
    ) -> Border {
        let dimension = self.dimension;
        let mut border = Border {
            side_area: vec![0.0; 2 * dimension],
            surface: Vec::new(),
        };
        for (point, side) in self.open_sides(mesh) {
            let corners: Vec<[f64; 3]> =
                side.iter().map(|node| mesh.nodes[*node as usize]).collect();
            let area = face_area(&corners);
            let on = |number: &usize| {
                let (axis, plane) = (number / 2, bounds[number % 2][number / 2]);
                corners.iter().all(|x| (x[axis] - plane).abs() <= near)
            };
            if let Some(number) = (0..2 * dimension).find(on) {
                border.side_area[number] += area * unit.powi(dimension as i32 - 1);
                continue;
            }
            let cell = &mesh.elements[self.cells[point as usize] as usize];
            let inside = mean(cell.nodes.iter().map(|node| mesh.nodes[*node as usize]));
            // As wide as the face: a point below it is as far from the ball as from the face.
            let radius = 0.5 * area.powf(1.0 / (dimension as f64 - 1.0));
            let centre = beyond(&corners, &inside, radius);
            let scaled = centre[..dimension].iter().map(|x| x * unit).collect();
            border.surface.push((scaled, radius * unit));
        }
        border
    }

    /// Sides that a single cell has, with its point.
    fn open_sides(&self, mesh: &Mesh) -> Vec<(u32, Vec<u32>)> {
        let mut count: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut sides = Vec::new();
        for (point, cell) in (0_u32..).zip(&self.cells) {
            for side in Self::sides(&mesh.elements[*cell as usize]) {
                *count.entry(sorted(&side)).or_default() += 1;
                sides.push((point, side));
            }
        }
        sides.retain(|(_, side)| count.get(&sorted(side)) == Some(&1));
        sides
    }
}

fn sorted(side: &[u32]) -> Vec<u32> {
    let mut side = side.to_vec();
    side.sort_unstable();
    side
}

fn mean(places: impl ExactSizeIterator<Item = [f64; 3]>) -> [f64; 3] {
    let count = places.len() as f64;
    let sum = places.fold([0.0; 3], |sum, x| std::array::from_fn(|k| sum[k] + x[k]));
    sum.map(|sum| sum / count)
}

/// Normal of a face times its area; of an edge in the plane, times its length.
fn area_vector(corners: &[[f64; 3]]) -> [f64; 3] {
    let minus = |a: &[f64; 3], b: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a[k] - b[k]) };
    if let [a, b] = corners {
        let along = minus(b, a);
        return [along[1], -along[0], 0.0];
    }
    let mut sum = [0.0; 3];
    for pair in corners[1..].windows(2) {
        let [a, b] = [minus(&pair[0], &corners[0]), minus(&pair[1], &corners[0])];
        for (k, sum) in sum.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *sum += (a[i] * b[j] - a[j] * b[i]) / 2.0;
        }
    }
    sum
}

/// Length of an edge, or area of a face.
fn face_area(corners: &[[f64; 3]]) -> f64 {
    area_vector(corners)
        .iter()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt()
}

/// The place so far from the middle of a face, on the side on which the cell is not.
fn beyond(corners: &[[f64; 3]], inside: &[f64; 3], distance: f64) -> [f64; 3] {
    let middle = mean(corners.iter().copied());
    let (normal, area) = (area_vector(corners), face_area(corners));
    let along: f64 = (0..3).map(|k| normal[k] * (middle[k] - inside[k])).sum();
    let step = if area > 0.0 {
        distance * along.signum() / area
    } else {
        0.0
    };
    std::array::from_fn(|k| middle[k] + step * normal[k])
}
