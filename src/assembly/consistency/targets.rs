//! The column sums that the corrected gradient shall have.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::Planes;
use crate::geometry::{Side, Vector, Voids};
use crate::operators::{Neighbourhood, Parity};

/// Points whose column sums feel one of the `sides`, beyond which there are no images: those whose own
/// horizon, or that of a point that sees them, crosses it.
pub fn boundary_layer<const D: usize>(around: &Neighbourhood<D>, sides: &[Side]) -> Vec<bool> {
    feeling(around, |point| crosses_side(around, sides, point))
}

/// Points whose column sums feel the free surface of one of the `voids`.
pub fn surface_layer<const D: usize>(around: &Neighbourhood<D>, voids: &Voids<D>) -> Vec<bool> {
    layer(around, &[], voids)
}

/// Points whose column sums feel one of the `sides` or the surface of a void.
pub(super) fn layer<const D: usize>(
    around: &Neighbourhood<D>,
    sides: &[Side],
    voids: &Voids<D>,
) -> Vec<bool> {
    // A mirrored void is farther away than the void itself.
    let (position, horizon) = (&around.cloud.position, &around.families.horizon);
    let crosses_surface = |point: usize| voids.within(&position[point], horizon[point]);
    feeling(around, |point| {
        crosses_side(around, sides, point) || crosses_surface(point)
    })
}

fn crosses_side<const D: usize>(around: &Neighbourhood<D>, sides: &[Side], point: usize) -> bool {
    let domain = &around.cloud.domain;
    sides.iter().any(|side| {
        let gap = (around.cloud.position[point][side.axis] - domain.plane(*side)).abs();
        gap < around.families.horizon[point]
    })
}

/// Points whose own horizon crosses a surface, and those that such a point sees.
fn feeling<const D: usize>(
    around: &Neighbourhood<D>,
    crosses: impl Fn(usize) -> bool,
) -> Vec<bool> {
    let crossing: Vec<bool> = (0..around.len()).map(crosses).collect();
    let feels = |point: usize| {
        let mut seen_by = around.families.dual(point);
        crossing[point] || seen_by.any(|(owner, _)| crossing[owner])
    };
    let mut layer: Vec<f64> = (0..around.len())
        .map(|point| f64::from(u8::from(feels(point))))
        .collect();
    // Across a crack a side is felt all the same: what the faces take is told apart.
    for bond in around.families.severed.iter().flatten() {
        if crossing[bond.owner as usize] {
            layer[bond.neighbour as usize] = 1.0;
        }
    }
    around.families.share.complete(&mut layer, 1);
    layer.into_iter().map(|own| own > 0.5).collect()
}

/// Column sums wanted: zero inside, the layer's own at one-sided planes, adjusted so that the
/// divergence theorem holds for the functions in `basis`, every linear one that the planes allow.
pub(super) fn targets(basis: &[Vec<f64>], layer: &[bool], sums: &[f64]) -> Vec<f64> {
    let mut target: Vec<f64> = sums
        .iter()
        .zip(layer)
        .map(|(sum, layer)| if *layer { *sum } else { 0.0 })
        .collect();
    if basis.is_empty() {
        return target;
    }
    let size = basis.len();
    let weight: Vec<f64> = target.iter().map(|t| t.abs()).collect();
    let weighted = |f: &[f64], g: &[f64]| -> f64 {
        weight
            .iter()
            .zip(f)
            .zip(g)
            .map(|((w, f), g)| w * f * g)
            .sum()
    };
    let matrix = DMatrix::from_fn(size, size, |a, b| weighted(&basis[a], &basis[b]));
    let rhs = DVector::from_fn(size, |a, _| {
        basis[a]
            .iter()
            .zip(sums.iter().zip(&target))
            .map(|(f, (s, t))| f * (s - t))
            .sum()
    });
    if let Some(solution) = matrix.lu().solve(&rhs) {
        for (function, &amount) in basis.iter().zip(solution.iter()) {
            for ((t, w), f) in target.iter_mut().zip(&weight).zip(function) {
                *t += amount * w * f;
            }
        }
    }
    target
}

/// Values of the linear functions that the hourglass matrix of this component cannot see: those that
/// vanish on odd planes and do not change across even ones.
pub(super) fn null_functions<const D: usize>(
    around: &Neighbourhood<D>,
    axis: usize,
    planes: &Planes,
) -> Vec<Vec<f64>> {
    let domain = &around.cloud.domain;
    let (centre, size) = ((domain.lower + domain.upper) * 0.5, domain.size());
    // Coefficients of 1 and of the coordinates from the centre, each over half the edge.
    let mut rules: Vec<Vec<f64>> = Vec::new();
    let unit = |k: usize| {
        (0..=D)
            .map(|i| f64::from(u8::from(i == k)))
            .collect::<Vec<f64>>()
    };
    for side in Side::all(D) {
        match planes.parity(axis, side) {
            Parity::OneSided => {}
            Parity::Even => rules.push(unit(1 + side.axis)),
            Parity::Odd => {
                rules.extend((0..D).filter(|&a| a != side.axis).map(|a| unit(1 + a)));
                let mut on_plane = unit(0);
                on_plane[1 + side.axis] = side.outward();
                rules.push(on_plane);
            }
        }
    }
    let normal = rules
        .iter()
        .fold(DMatrix::zeros(D + 1, D + 1), |sum, rule| {
            let rule = DVector::from_column_slice(rule);
            sum + &rule * rule.transpose()
        });
    let modes = SymmetricEigen::new(normal);
    let free = (0..=D).filter(|&k| modes.eigenvalues[k] < 1e-10);
    let value = |x: &Vector<D>, mode: usize| {
        let coefficient = modes.eigenvectors.column(mode);
        let along = |a: usize| coefficient[1 + a] * 2.0 * (x[a] - centre[a]) / size[a];
        coefficient[0] + (0..D).map(along).sum::<f64>()
    };
    free.map(|mode| {
        around
            .cloud
            .position
            .iter()
            .map(|x| value(x, mode))
            .collect()
    })
    .collect()
}
