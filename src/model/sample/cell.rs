//! What one sampled cell of the path operator costs and how fast it exchanges.

use std::collections::BTreeSet;

use super::family::largest_over_waves;
use crate::geometry::{Cloud, Sampler, Vector};
use crate::operators::{Arm, Cells, cell_faces};

/// The cell of one sampled point.
pub(super) struct LocalCell {
    /// Bonds to cells that touch, images included.
    pub(super) bonds: usize,
    /// Points at their ends, its own included.
    pub(super) neighbours: usize,
    /// Largest eigenvalue of the operator on an endless cloud of such cells, in units of the squared
    /// spacing and the mobility.
    pub(super) eigenvalue: f64,
}

impl LocalCell {
    /// Looks up the cell of `point`. Where mobilities differ (`varies`) the faces may conduct what bonds
    /// across edges do elsewhere.
    pub(super) fn new<const D: usize>(
        cloud: &Cloud<D>,
        sampler: &Sampler<'_, D>,
        cells: Cells,
        point: usize,
        varies: bool,
    ) -> Self {
        let family = sampler.family(point);
        let arms: Vec<Arm<D>> = family.iter().map(|(end, _, xi)| (*end, *xi)).collect();
        let cell = cell_faces(cloud, cells, point, &arms);
        let mut neighbours: BTreeSet<usize> = (cell.faces.iter())
            .map(|face| family[face.bond].0)
            .collect();
        neighbours.insert(point);
        let carried: Vec<(Vector<D>, f64)> = (cell.faces.iter())
            .map(|face| {
                let xi = arms[face.bond].1;
                let conductance = match varies {
                    true => face.area / xi.norm(),
                    false => face.conductance,
                };
                (xi, conductance / cell.volume)
            })
            .collect();
        let spacing = cloud.spacing(point);
        let symbol = |wave: &Vector<D>| {
            let bonds = carried.iter();
            bonds.map(|(xi, c)| c * (1.0 - wave.dot(xi).cos())).sum()
        };
        LocalCell {
            bonds: cell.faces.len(),
            neighbours: neighbours.len(),
            eigenvalue: largest_over_waves(spacing, symbol) * spacing * spacing,
        }
    }
}
