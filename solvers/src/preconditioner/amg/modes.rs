//! The near-nullspace on the finest level: constants or rigid-body modes.

use crate::problem::{Coordinates, NearNullspace, Problem};

/// Fields that the coarse levels must carry: `count` values for each unknown.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Modes {
    pub(super) count: usize,
    /// Mode after mode for the first unknown, then for the next.
    pub(super) values: Vec<f64>,
}

impl Modes {
    /// The modes a problem asks for; constants where rigid modes need coordinates it lacks.
    pub(super) fn of(problem: &Problem<'_>) -> Self {
        let size = problem.unknowns_per_point;
        match (problem.near_nullspace, problem.coordinates) {
            (NearNullspace::RigidModes, Some(coordinates)) if coordinates.dimension <= size => {
                Self::rigid(&coordinates, problem.points(), size)
            }
            _ => Self::constants(problem.points(), size),
        }
    }

    fn zeros(points: usize, size: usize, count: usize) -> Self {
        let values = vec![0.0; points * size * count];
        Self { count, values }
    }

    fn constants(points: usize, size: usize) -> Self {
        let mut modes = Self::zeros(points, size, size);
        for unknown in 0..points * size {
            modes.values[unknown * size + unknown % size] = 1.0;
        }
        modes
    }

    /// Constants of all unknowns first, then the rotations about the middle of the cloud, in
    /// units of its size, so that all modes are of order one.
    fn rigid(coordinates: &Coordinates<'_>, points: usize, size: usize) -> Self {
        let dimension = coordinates.dimension;
        let planes = rotation_planes(dimension);
        let mut modes = Self::zeros(points, size, size + planes.len());
        let (middle, unit) = frame(coordinates, points);
        for point in 0..points {
            let position: Vec<f64> = (0..dimension)
                .map(|axis| (coordinates.along(axis, point as u32) - middle[axis]) / unit)
                .collect();
            let rows = &mut modes.values[point * size * modes.count..][..size * modes.count];
            for (local, row) in rows.chunks_exact_mut(modes.count).enumerate() {
                row[local] = 1.0;
                for (mode, (from, to)) in planes.iter().enumerate() {
                    if local == *from {
                        row[size + mode] = -position[*to];
                    } else if local == *to {
                        row[size + mode] = position[*from];
                    }
                }
            }
        }
        modes
    }
}

/// The planes in which a body can turn, as pairs of axes.
fn rotation_planes(dimension: usize) -> &'static [(usize, usize)] {
    match dimension {
        2 => &[(0, 1)],
        3 => &[(1, 2), (2, 0), (0, 1)],
        _ => &[],
    }
}

/// Middle of the bounding box and its largest half width, 1 if all points coincide.
fn frame(coordinates: &Coordinates<'_>, points: usize) -> (Vec<f64>, f64) {
    let mut middle = vec![0.0; coordinates.dimension];
    let mut unit = 0.0_f64;
    for (axis, middle) in middle.iter_mut().enumerate() {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in 0..points {
            let value = coordinates.along(axis, point as u32);
            (low, high) = (low.min(value), high.max(value));
        }
        *middle = low + 0.5 * (high - low);
        unit = unit.max(0.5 * (high - low));
    }
    (middle, if unit > 0.0 { unit } else { 1.0 })
}
