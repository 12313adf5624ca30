//! Elastic bodies, and conjugate gradients in their plainest form.

use crate::preconditioner::Preconditioner;
use crate::preconditioner::amg::{AmgOptions, SmoothedAggregation};
use crate::problem::NearNullspace;
use crate::test_support::{Cloud, jittered_grid, noise, positive_definite};
use crate::{CsrMatrix, CsrView, Problem, dot, multiply, norm2};

/// A grid of n³ points, each moved by at most `jitter`.
pub(crate) fn jittered_cube(n: usize, jitter: f64) -> Cloud {
    let index = |point: usize| [point % n, point / n % n, point / (n * n)];
    let coordinates = (0..n * n * n)
        .flat_map(|point| (0..3).map(move |axis| (3 * point + axis, index(point)[axis])))
        .map(|(seed, position)| position as f64 + jitter * noise(seed))
        .collect();
    Cloud {
        dimension: 3,
        coordinates,
    }
}

/// A square cloud of n² points.
pub(crate) fn square(n: usize) -> Cloud {
    jittered_grid(n, n, 0.2)
}

/// Bond-based body: a spring of the given stiffness between each pair nearer than `horizon`
/// resists stretch along the bond. It resists no rigid motion.
pub(crate) fn free_body(
    cloud: &Cloud,
    horizon: f64,
    stiffness: impl Fn(usize, usize) -> f64,
) -> CsrMatrix {
    let d = cloud.dimension;
    let unknowns = cloud.points() * d;
    let mut triplets = sprs::TriMatI::<f64, u32>::new((unknowns, unknowns));
    let position = |point: usize| &cloud.coordinates[point * d..][..d];
    (0..unknowns).for_each(|unknown| triplets.add_triplet(unknown, unknown, 0.0));
    for a in 0..cloud.points() {
        for b in 0..a {
            let bond: Vec<f64> = (0..d).map(|i| position(b)[i] - position(a)[i]).collect();
            let length = norm2(&bond);
            if length >= horizon {
                continue;
            }
            for (i, j) in (0..d * d).map(|entry| (entry / d, entry % d)) {
                let value = stiffness(a, b) * bond[i] * bond[j] / length.powi(2);
                triplets.add_triplet(a * d + i, a * d + j, value);
                triplets.add_triplet(b * d + i, b * d + j, value);
                triplets.add_triplet(a * d + i, b * d + j, -value);
                triplets.add_triplet(b * d + i, a * d + j, -value);
            }
        }
    }
    triplets.to_csr()
}

/// Replaces rows and columns of the chosen unknowns by their diagonal; the pattern stays.
pub(crate) fn fix(matrix: &mut CsrMatrix, fixed: impl Fn(usize) -> bool) {
    for (row, mut vector) in matrix.outer_iterator_mut().enumerate() {
        for (column, value) in vector.iter_mut() {
            if column != row && (fixed(row) || fixed(column)) {
                *value = 0.0;
            }
        }
    }
}

/// A body held at its left end.
pub(crate) fn held_body(
    cloud: &Cloud,
    horizon: f64,
    stiffness: impl Fn(usize, usize) -> f64,
) -> CsrMatrix {
    let mut matrix = free_body(cloud, horizon, stiffness);
    let d = cloud.dimension;
    fix(&mut matrix, |unknown| {
        cloud.coordinates[unknown / d * d] < 0.5
    });
    matrix
}

/// The stiffness of bonds that touch a horizontal band in the middle of a square of side n.
pub(crate) fn band(cloud: &Cloud, n: usize, soft: f64) -> impl Fn(usize, usize) -> f64 {
    let inside: Vec<bool> = cloud
        .coordinates
        .chunks_exact(cloud.dimension)
        .map(|at| (at[1] - 0.5 * n as f64).abs() < 1.0 && at[0] > 0.25 * n as f64)
        .collect();
    move |a, b| if inside[a] || inside[b] { soft } else { 1.0 }
}

/// The problem of an elastic body.
pub(crate) fn elastic<'a>(matrix: &'a CsrMatrix, cloud: &'a Cloud) -> Problem<'a> {
    Problem {
        near_nullspace: NearNullspace::RigidModes,
        ..positive_definite(matrix, Some(cloud), cloud.dimension)
    }
}

/// Options that give small matrices several levels.
pub(crate) fn small() -> AmgOptions {
    AmgOptions {
        coarsest: 40,
        ..AmgOptions::default()
    }
}

/// A hierarchy of several levels for the values of the problem.
pub(crate) fn built(problem: &Problem<'_>) -> SmoothedAggregation {
    let mut amg = SmoothedAggregation::new(small());
    amg.analyse(problem).unwrap();
    amg.refresh(problem.pattern).unwrap();
    amg
}

/// Iterations of conjugate gradients from zero to a true relative residual of 1e-10.
pub(crate) fn iterations(matrix: CsrView<'_>, inverse: &mut dyn Preconditioner) -> usize {
    let n = matrix.rows();
    let rhs: Vec<f64> = (0..n).map(|i| 1.0 + noise(i)).collect();
    let (mut x, mut residual) = (vec![0.0; n], rhs.clone());
    let (mut scaled, mut product) = (vec![0.0; n], vec![0.0; n]);
    inverse.apply(&residual, &mut scaled);
    let mut direction = scaled.clone();
    let mut size = dot(&residual, &scaled);
    for iteration in 1..=1000 {
        multiply(matrix, &direction, &mut product);
        let step = size / dot(&direction, &product);
        x.iter_mut()
            .zip(&direction)
            .for_each(|(x, d)| *x += step * d);
        residual
            .iter_mut()
            .zip(&product)
            .for_each(|(r, p)| *r -= step * p);
        crate::residual(matrix, &x, &rhs, &mut product);
        if norm2(&product) <= 1e-10 * norm2(&rhs) {
            return iteration;
        }
        inverse.apply(&residual, &mut scaled);
        let next = dot(&residual, &scaled);
        let ratio = next / size;
        direction
            .iter_mut()
            .zip(&scaled)
            .for_each(|(d, s)| *d = s + ratio * *d);
        size = next;
    }
    panic!("no convergence in 1000 iterations");
}
