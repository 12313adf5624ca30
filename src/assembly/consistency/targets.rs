//! The column sums that the corrected gradient shall have.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::Planes;
use crate::geometry::{Side, Vector, Voids};
use crate::operators::{Neighbourhood, Parity};

/// Points whose column sums feel one of the `sides`, beyond which there are no images: those whose own
/// horizon, or that of a point that sees them, crosses it.
pub(crate) fn boundary_layer<const D: usize>(
    around: &Neighbourhood<D>,
    sides: &[Side],
) -> Vec<bool> {
    feeling(around, |point| crosses_side(around, sides, point))
}

/// Points whose column sums feel the free surface of one of the `voids`.
pub(crate) fn surface_layer<const D: usize>(
    around: &Neighbourhood<D>,
    voids: &Voids<D>,
) -> Vec<bool> {
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

/// What the targets of some points shall add up to.
pub(super) struct Total {
    /// One for the points that count, zero for the others.
    pub member: Vec<f64>,
    /// Area, m^(D−1), positive along the axis.
    pub area: f64,
}

/// Gap between the sum of all volumes and the volume of the domain, in spacings on a side, up to which the layer
/// at the side can present its whole area: beyond, the layer would have to lie elsewhere than its points.
const FITS: f64 = 0.1;

/// The areas that one-sided `sides` present, where cells fill the domain and no crack has faces there.
pub(super) fn totals<const D: usize>(
    around: &Neighbourhood<D>,
    sides: &[Side],
    voids: &Voids<D>,
) -> Vec<Total> {
    if !voids.is_empty() || around.families.severed.is_some() {
        return Vec::new();
    }
    let cloud = &around.cloud;
    let volume: f64 = cloud.volume.iter().sum();
    let spacing = (volume / cloud.len() as f64).powf(1.0 / D as f64);
    let excess = (volume - cloud.domain.size().product()).abs();
    let fits = |side: &Side| excess <= FITS * cloud.domain.area(*side) * spacing;
    let of = |side: &Side| Total {
        member: side_layer(around, *side)
            .into_iter()
            .map(|own| f64::from(u8::from(own)))
            .collect(),
        area: side.outward() * cloud.domain.area(*side),
    };
    sides.iter().filter(|side| fits(side)).map(of).collect()
}

/// Points whose column sums feel a side, and are nearer to it than to the opposite one.
pub(crate) fn side_layer<const D: usize>(around: &Neighbourhood<D>, side: Side) -> Vec<bool> {
    let domain = &around.cloud.domain;
    let opposite = Side {
        axis: side.axis,
        upper: !side.upper,
    };
    let near = |(point, felt): (usize, bool)| {
        let x = around.cloud.position[point][side.axis];
        felt && (x - domain.plane(side)).abs() < (x - domain.plane(opposite)).abs()
    };
    let layer = boundary_layer(around, &[side]);
    layer.into_iter().enumerate().map(near).collect()
}

/// Column sums wanted: zero inside, the layer's own at one-sided planes, adjusted so that the divergence theorem
/// holds for the functions in `basis`, every linear one that the planes allow, and that sides present their
/// `totals`.
pub(super) fn targets(
    basis: &[Vec<f64>],
    totals: &[Total],
    layer: &[bool],
    sums: &[f64],
) -> Vec<f64> {
    let mut target: Vec<f64> = sums
        .iter()
        .zip(layer)
        .map(|(sum, layer)| if *layer { *sum } else { 0.0 })
        .collect();
    let dot = |f: &[f64], g: &[f64]| -> f64 { f.iter().zip(g).map(|(f, g)| f * g).sum() };
    let by_theorem = basis.iter().map(|f| (f, dot(f, sums)));
    let by_area = totals.iter().map(|total| (&total.member, total.area));
    let wanted: Vec<(&Vec<f64>, f64)> = by_theorem.chain(by_area).collect();
    if wanted.is_empty() {
        return target;
    }
    let weight: Vec<f64> = target.iter().map(|t| t.abs()).collect();
    let weighted = |f: &[f64], g: &[f64]| -> f64 {
        let pairs = f.iter().zip(g);
        weight.iter().zip(pairs).map(|(w, (f, g))| w * f * g).sum()
    };
    let size = wanted.len();
    let matrix = DMatrix::from_fn(size, size, |a, b| weighted(wanted[a].0, wanted[b].0));
    let rhs = DVector::from_fn(size, |a, _| wanted[a].1 - dot(wanted[a].0, &target));
    // Sides that face each other make the constant function twice.
    let bound = f64::EPSILON * matrix.amax();
    if let Ok(solution) = matrix.svd(true, true).solve(&rhs, 1e3 * bound) {
        for ((function, _), &amount) in wanted.iter().zip(solution.iter()) {
            for ((t, w), f) in target.iter_mut().zip(&weight).zip(*function) {
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
