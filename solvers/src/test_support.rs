//! Small matrices and helpers shared by the unit tests.

use crate::{Coordinates, CsrMatrix, Problem, SolverSpec, Symmetry};

/// Points with their coordinates.
#[derive(Debug)]
pub(crate) struct Cloud {
    pub(crate) dimension: usize,
    pub(crate) coordinates: Vec<f64>,
}

impl Cloud {
    pub(crate) fn points(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let d = self.dimension;
        let (a, b) = (
            &self.coordinates[a * d..][..d],
            &self.coordinates[b * d..][..d],
        );
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    }
}

/// Deterministic numbers in [−1, 1].
pub(crate) fn noise(index: usize) -> f64 {
    let hash = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((hash ^ (hash >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A grid of unit spacing, each point moved by at most `jitter`.
pub(crate) fn jittered_grid(columns: usize, rows: usize, jitter: f64) -> Cloud {
    let mut coordinates = Vec::new();
    for point in 0..columns * rows {
        coordinates.push((point % columns) as f64 + jitter * noise(2 * point));
        coordinates.push((point / columns) as f64 + jitter * noise(2 * point + 1));
    }
    Cloud {
        dimension: 2,
        coordinates,
    }
}

/// Symmetric positive definite matrix on a cloud: each pair nearer than `horizon` is a spring
/// between all `per_point` unknowns, and every unknown is held by a weak spring.
pub(crate) fn wide_stencil(
    cloud: &Cloud,
    per_point: usize,
    horizon: f64,
    seed: usize,
) -> CsrMatrix {
    let points = cloud.points();
    let mut triplets = sprs::TriMatI::<f64, u32>::new((points * per_point, points * per_point));
    for a in 0..points {
        for row in 0..per_point {
            triplets.add_triplet(a * per_point + row, a * per_point + row, 0.05);
        }
        for b in (0..points).filter(|b| *b > a && cloud.distance(a, *b) < horizon) {
            let stiffness = 1.0 + 0.5 * noise(seed + a * points + b);
            for row in 0..per_point {
                for column in 0..per_point {
                    let value = stiffness * if row == column { 1.0 } else { 0.2 };
                    let (i, j) = (a * per_point + row, b * per_point + column);
                    let (p, q) = (a * per_point + column, b * per_point + row);
                    triplets.add_triplet(i, j, -value);
                    triplets.add_triplet(j, i, -value);
                    triplets.add_triplet(i, p, value);
                    triplets.add_triplet(b * per_point + column, q, value);
                }
            }
        }
    }
    triplets.to_csr()
}

/// [K, −Qᵀ; −Q, −S] with unknowns (u, v, p) at each point. K is a wide stencil times `stiffness`;
/// Q is a discrete gradient, whose entries within a point are 0; S is `storage` times 1.
pub(crate) fn biot(cloud: &Cloud, stiffness: f64, storage: f64) -> CsrMatrix {
    const HORIZON: f64 = 2.3;
    let points = cloud.points();
    let mut triplets = sprs::TriMatI::<f64, u32>::new((3 * points, 3 * points));
    for (value, (row, column)) in wide_stencil(cloud, 2, HORIZON, 4).iter() {
        let unknown = |index: u32| (index / 2 * 3 + index % 2) as usize;
        triplets.add_triplet(unknown(row), unknown(column), stiffness * value);
    }
    for a in 0..points {
        triplets.add_triplet(3 * a + 2, 3 * a + 2, -storage);
        for b in (0..points).filter(|b| *b != a) {
            let bond = [0, 1].map(|c| cloud.coordinates[2 * b + c] - cloud.coordinates[2 * a + c]);
            let length = bond[0].hypot(bond[1]);
            for (component, part) in bond.iter().enumerate().filter(|_| length < HORIZON) {
                triplets.add_triplet(3 * b + 2, 3 * a + component, -part / length);
                triplets.add_triplet(3 * a + component, 3 * b + 2, -part / length);
            }
        }
    }
    triplets.to_csr()
}

/// Upwind transport and diffusion on a grid: not symmetric, but solvable by every method.
pub(crate) fn transport(columns: usize, rows: usize) -> CsrMatrix {
    let mut a = grid_laplacian(columns, rows, 0.1);
    for (row, mut vector) in a.outer_iterator_mut().enumerate() {
        for (column, value) in vector.iter_mut() {
            if column + 1 == row {
                *value -= 0.7 + 0.2 * noise(row);
            } else if column == row {
                *value += 1.0;
            }
        }
    }
    a
}

/// A tridiagonal matrix with these entries left, on and right of the diagonal.
pub(crate) fn tridiagonal(size: usize, left: f64, centre: f64, right: f64) -> CsrMatrix {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((size, size));
    for i in 0..size {
        triplets.add_triplet(i, i, centre + 0.1 * noise(i));
        if i + 1 < size {
            triplets.add_triplet(i + 1, i, left);
            triplets.add_triplet(i, i + 1, right);
        }
    }
    triplets.to_csr()
}

/// A matrix from its dense rows; zeros are not stored, except on the diagonal.
pub(crate) fn from_dense<const N: usize>(rows: [[f64; N]; N]) -> CsrMatrix {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((N, N));
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            if i == j || value.abs() > 0.0 {
                triplets.add_triplet(i, j, *value);
            }
        }
    }
    triplets.to_csr()
}

/// A solver that has analysed and refreshed a problem; its pattern is the matrix.
pub(crate) fn ready(
    spec: &str,
    problem: &Problem<'_>,
) -> Result<Box<dyn crate::LinearSolver>, crate::SolveError> {
    let mut solver = spec.parse::<SolverSpec>().unwrap().build().unwrap();
    solver.analyse(problem)?;
    solver.refresh(problem.pattern)?;
    Ok(solver)
}

/// Five-point Laplacian on a grid with zero values around it, plus `shift` on the diagonal.
pub(crate) fn grid_laplacian(columns: usize, rows: usize, shift: f64) -> CsrMatrix {
    let points = columns * rows;
    let mut triplets = sprs::TriMatI::<f64, u32>::new((points, points));
    for point in 0..points {
        triplets.add_triplet(point, point, 4.0 + shift);
        if point % columns + 1 < columns {
            triplets.add_triplet(point, point + 1, -1.0);
            triplets.add_triplet(point + 1, point, -1.0);
        }
        if point + columns < points {
            triplets.add_triplet(point, point + columns, -1.0);
            triplets.add_triplet(point + columns, point, -1.0);
        }
    }
    triplets.to_csr()
}

/// Multiplies every coupling by a symmetric factor and sets the diagonal to the sum of the
/// couplings of its row plus `hold(row)`.
pub(crate) fn damage(
    matrix: &mut CsrMatrix,
    factor: impl Fn(usize, usize) -> f64,
    hold: impl Fn(usize) -> f64,
) {
    for (row, mut vector) in matrix.outer_iterator_mut().enumerate() {
        let mut sum = hold(row);
        for (column, value) in vector.iter_mut().filter(|(column, _)| *column != row) {
            *value *= factor(row, column);
            sum += value.abs();
        }
        if let Some(diagonal) = vector.get_mut(row) {
            *diagonal = sum;
        }
    }
}

/// Adds a value to every diagonal entry.
pub(crate) fn add_to_diagonal(matrix: &mut CsrMatrix, value: impl Fn(usize) -> f64) {
    for row in 0..matrix.rows() {
        if let Some(position) = matrix.nnz_index(row, row) {
            matrix.data_mut()[position.0] += value(row);
        }
    }
}

/// A positive definite problem, with coordinates if a cloud is given.
pub(crate) fn positive_definite<'a>(
    matrix: &'a CsrMatrix,
    cloud: Option<&'a Cloud>,
    unknowns_per_point: usize,
) -> Problem<'a> {
    let coordinates = cloud.map(|cloud| Coordinates {
        dimension: cloud.dimension,
        values: &cloud.coordinates,
    });
    Problem {
        coordinates,
        ..Problem::new(
            matrix.view(),
            Symmetry::PositiveDefinite,
            unknowns_per_point,
        )
    }
}

/// A solver that has analysed and refreshed a matrix.
pub(crate) fn prepared(
    spec: &str,
    matrix: &CsrMatrix,
    cloud: Option<&Cloud>,
    unknowns_per_point: usize,
) -> Box<dyn crate::LinearSolver> {
    let mut solver = spec.parse::<SolverSpec>().unwrap().build().unwrap();
    solver
        .analyse(&positive_definite(matrix, cloud, unknowns_per_point))
        .unwrap();
    solver.refresh(matrix.view()).unwrap();
    solver
}

/// Solution by a dense factorisation with partial pivoting.
pub(crate) fn dense_solution(matrix: &CsrMatrix, rhs: &[f64]) -> Vec<f64> {
    use faer::prelude::Solve;
    let mut dense = faer::Mat::<f64>::zeros(matrix.rows(), matrix.cols());
    for (row, vector) in matrix.outer_iterator().enumerate() {
        vector
            .iter()
            .for_each(|(column, value)| dense[(row, column)] = *value);
    }
    let solution = dense.partial_piv_lu().solve(faer::ColRef::from_slice(rhs));
    solution.iter().copied().collect()
}

/// A right-hand side without structure.
pub(crate) fn noisy_vector(length: usize) -> Vec<f64> {
    (0..length).map(|i| noise(7 * i + 3)).collect()
}

/// ‖a − b‖₂ / ‖b‖₂.
pub(crate) fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    crate::norm2(&difference) / crate::norm2(b)
}

/// Runs on a pool of so many threads.
pub(crate) fn in_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
        .install(work)
}
