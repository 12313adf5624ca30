//! A Poisson problem on a square, −∇²u = f with u = 0 on the boundary, by several solvers.
//!
//! `cargo run --release -p perifrac-solvers --example poisson`

use std::time::Instant;

use perifrac_solvers::{Coordinates, CsrMatrix, Problem, SolverSpec, Symmetry};

type Failure = Box<dyn std::error::Error>;

/// Solvers to compare.
pub const SPECS: [&str; 5] = [
    "auto",
    "faer-llt",
    "faer-cg",
    "faer-cg:preconditioner=ic0",
    "faer-cg:preconditioner=amg,tolerance=1e-10",
];

/// The five-point matrix of `n` × `n` places inside the square, and their coordinates.
fn matrix(n: usize) -> (CsrMatrix, Vec<f64>) {
    let (mut starts, mut columns, mut values) = (vec![0_u32], Vec::new(), Vec::new());
    let spacing = 1.0 / (n as f64 + 1.0);
    let mut places = Vec::new();
    for row in 0..n * n {
        let (i, j) = (row % n, row / n);
        places.extend([(i + 1) as f64 * spacing, (j + 1) as f64 * spacing]);
        let near = [
            (j > 0).then(|| row - n),
            (i > 0).then(|| row - 1),
            Some(row),
            (i + 1 < n).then(|| row + 1),
            (j + 1 < n).then(|| row + n),
        ];
        for column in near.into_iter().flatten() {
            columns.push(column as u32);
            let entry = if column == row { 4.0 } else { -1.0 };
            values.push(entry / (spacing * spacing));
        }
        starts.push(columns.len() as u32);
    }
    let matrix = CsrMatrix::new((n * n, n * n), starts, columns, values);
    (matrix, places)
}

/// Solves the problem on `n` × `n` places by the solver of a text; the largest error, u being (x − x⁵)(y − y²).
pub fn solve(text: &str, n: usize) -> Result<f64, Failure> {
    let (matrix, places) = matrix(n);
    let pairs = || places.chunks_exact(2).map(|place| (place[0], place[1]));
    let exact = |(x, y): (f64, f64)| (x - x.powi(5)) * (y - y * y);
    let source = |(x, y): (f64, f64)| 20.0 * x.powi(3) * (y - y * y) + 2.0 * (x - x.powi(5));
    let source: Vec<f64> = pairs().map(source).collect();
    let problem = Problem {
        coordinates: Some(Coordinates {
            dimension: 2,
            values: &places,
        }),
        ..Problem::new(matrix.view(), Symmetry::PositiveDefinite, 1)
    };
    let started = Instant::now();
    let mut solver = text.parse::<SolverSpec>()?.build()?;
    solver.analyse(&problem)?;
    solver.refresh(matrix.view())?;
    let mut u = vec![0.0; source.len()];
    let report = solver.solve(matrix.view(), &source, &mut u)?;
    let errors = pairs().zip(&u).map(|(place, u)| (u - exact(place)).abs());
    let largest = errors.fold(0.0, f64::max);
    println!(
        "{text:44} {:>8}: error {largest:.3e}, residual {:.0e}, {:3} iterations, {:.3} s",
        solver.name(),
        report.true_residual,
        report.iterations,
        started.elapsed().as_secs_f64()
    );
    Ok(largest)
}

fn main() -> Result<(), Failure> {
    for text in SPECS {
        solve(text, 150)?;
    }
    Ok(())
}
