//! Distributed solves: this program starts itself under `mpirun` with 1 to 4 processes.

#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};
use std::sync::Arc;

use perifrac_solvers::{
    Communicator, Coordinates, CsrMatrix, NearNullspace, Partition, Problem, SolveError,
    SolverSpec, Symmetry, norm2, petsc_abort as abort, petsc_finish as finish, petsc_status,
    petsc_team,
};

/// Set where PETSc and `mpirun` must be there; elsewhere this test is skipped.
const REQUIRED: &str = "PERIFRAC_REQUIRE_PETSC";
/// Set in the processes that `mpirun` starts.
const WORKER: &str = "PERIFRAC_TEST_WORKER";
/// What a worker says before the reason why it cannot work.
const UNAVAILABLE: &str = "unavailable: ";
const HORIZON: f64 = 2.3;
const COLUMNS: usize = 23;

/// Deterministic numbers in [−1, 1].
fn noise(index: usize) -> f64 {
    let hash = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((hash ^ (hash >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A jittered grid in an order that mixes its regions.
fn cloud() -> Vec<f64> {
    let points = COLUMNS * 17;
    let shuffled = (0..points).map(|index| index * 7 % points);
    shuffled
        .flat_map(|point| {
            let (column, row) = (point % COLUMNS, point / COLUMNS);
            let shift = |part| 0.2 * noise(2 * point + part);
            [column as f64 + shift(0), row as f64 + shift(1)]
        })
        .collect()
}

/// Adds `action(a, b, unit vector)` for every pair of neighbours, both ways round.
fn for_each_bond(cloud: &[f64], mut action: impl FnMut(usize, usize, [f64; 2])) {
    let points = cloud.len() / 2;
    for a in 0..points {
        for b in (0..points).filter(|b| *b != a) {
            let bond = [0, 1].map(|axis| cloud[2 * b + axis] - cloud[2 * a + axis]);
            let length = bond[0].hypot(bond[1]);
            if length < HORIZON {
                action(a, b, bond.map(|part| part / length));
            }
        }
    }
}

/// What the tests solve.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Case {
    Flow,
    Elasticity,
    Monolithic,
}

impl Case {
    fn per_point(self) -> usize {
        match self {
            Self::Flow => 1,
            Self::Elasticity => 2,
            Self::Monolithic => 3,
        }
    }

    /// Springs that carry a pressure or resist stretching, held at the left.
    fn matrix(self, cloud: &[f64]) -> CsrMatrix {
        let (points, u) = (cloud.len() / 2, self.per_point());
        let mut triplets = sprs::TriMatI::<f64, u32>::new((points * u, points * u));
        let fluid = u - 1;
        for_each_bond(cloud, |a, b, unit| {
            for i in 0..2 {
                for j in 0..2 {
                    if self != Self::Flow {
                        let value = unit[i] * unit[j];
                        triplets.add_triplet(u * a + i, u * b + j, -value);
                        triplets.add_triplet(u * a + i, u * a + j, value);
                    }
                }
                if self == Self::Monolithic {
                    triplets.add_triplet(u * b + fluid, u * a + i, -unit[i]);
                    triplets.add_triplet(u * a + i, u * b + fluid, -unit[i]);
                }
            }
            if self != Self::Elasticity {
                let sign = if self == Self::Flow { 1.0 } else { -1.0 };
                triplets.add_triplet(u * a + fluid, u * b + fluid, -sign);
                triplets.add_triplet(u * a + fluid, u * a + fluid, sign);
            }
        });
        for a in 0..points {
            let hold = if cloud[2 * a] < 1.5 { 5.0 } else { 1e-3 };
            for part in 0..u {
                let sign = if self == Self::Monolithic && part == fluid {
                    -1.0
                } else {
                    1.0
                };
                triplets.add_triplet(u * a + part, u * a + part, sign * hold);
            }
        }
        triplets.to_csr()
    }

    fn problem<'a>(self, matrix: &'a CsrMatrix, cloud: &'a [f64]) -> Problem<'a> {
        let symmetry = match self {
            Self::Monolithic => Symmetry::QuasiDefinite,
            _ => Symmetry::PositiveDefinite,
        };
        Problem {
            coordinates: Some(Coordinates {
                dimension: 2,
                values: cloud,
            }),
            near_nullspace: match self {
                Self::Flow => NearNullspace::Constants,
                _ => NearNullspace::RigidModes,
            },
            ..Problem::new(matrix.view(), symmetry, self.per_point())
        }
    }
}

/// The rows of the points of this process; the others are empty.
fn own_rows(matrix: &CsrMatrix, mask: &[bool], per_point: usize) -> CsrMatrix {
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for (row, vector) in matrix.outer_iterator().enumerate() {
        if mask[row / per_point] {
            columns.extend(vector.indices());
            values.extend(vector.data());
        }
        starts.push(columns.len() as u32);
    }
    CsrMatrix::new(matrix.shape(), starts, columns, values)
}

fn reference(problem: &Problem<'_>, matrix: &CsrMatrix, rhs: &[f64]) -> Vec<f64> {
    let name = match problem.symmetry {
        Symmetry::PositiveDefinite => "faer-llt",
        _ => "faer-ldlt",
    };
    let mut solver = name.parse::<SolverSpec>().unwrap().build().unwrap();
    solver.analyse(problem).unwrap();
    solver.refresh(matrix.view()).unwrap();
    let mut x = vec![0.0; rhs.len()];
    solver.solve(matrix.view(), rhs, &mut x).unwrap();
    x
}

/// Whether all processes have the same bits.
fn is_the_same_everywhere(team: &dyn Communicator, values: &[f64]) -> bool {
    let number = values.iter().fold(0_u64, |hash, value| {
        (hash ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3)
    });
    // 53 bits of the hash survive in a number.
    let mut board = vec![0.0; team.size()];
    board[team.rank()] = (number >> 11) as f64;
    team.sum(&mut board);
    board
        .iter()
        .all(|other| other.to_bits() == board[0].to_bits())
}

fn the_solution_is_that_of_one_process(team: &Arc<dyn Communicator>, case: Case, flags: &str) {
    let (cloud, per_point) = (cloud(), case.per_point());
    let mut whole = case.matrix(&cloud);
    let problem = case.problem(&whole, &cloud);
    let partition = Partition::bisection(team.clone(), &problem.coordinates.unwrap());
    let mask = partition.mask();
    let part = own_rows(&whole, &mask, per_point);
    let spec: SolverSpec = format!("petsc{flags}").parse().unwrap();
    let mut solver = spec.build().unwrap();
    let distributed = Problem {
        pattern: part.view(),
        partition: Some(&partition),
        ..problem
    };
    solver.analyse(&distributed).unwrap();
    let rhs: Vec<f64> = (0..whole.rows()).map(|i| noise(3 * i)).collect();
    let mut x = vec![0.0; whole.rows()];
    for round in 1..3 {
        whole
            .data_mut()
            .iter_mut()
            .for_each(|value| *value *= round as f64);
        let part = own_rows(&whole, &mask, per_point);
        solver.refresh(part.view()).unwrap();
        let report = solver.solve(part.view(), &rhs, &mut x);
        let report = report.unwrap_or_else(|error| panic!("{case:?} {spec}: {error}"));
        assert!(report.true_residual <= 1e-12, "{case:?} {spec} {report:?}");
        let exact = reference(&case.problem(&whole, &cloud), &whole, &rhs);
        let error: Vec<f64> = x.iter().zip(&exact).map(|(x, exact)| x - exact).collect();
        let error = norm2(&error) / norm2(&exact);
        assert!(error < 1e-8, "{case:?} {spec}: {error:e}");
        assert!(is_the_same_everywhere(&**team, &x), "{case:?} {spec}");
        let residuals = [report.true_residual, report.scaled_residual];
        assert!(is_the_same_everywhere(&**team, &residuals));
    }
}

fn an_error_of_one_process_is_that_of_all(team: &Arc<dyn Communicator>) {
    let cloud = cloud();
    let whole = Case::Flow.matrix(&cloud);
    let problem = Case::Flow.problem(&whole, &cloud);
    let partition = Partition::bisection(team.clone(), &problem.coordinates.unwrap());
    let part = own_rows(&whole, &partition.mask(), 1);
    let mut solver = "petsc".parse::<SolverSpec>().unwrap().build().unwrap();
    let distributed = Problem {
        pattern: part.view(),
        partition: Some(&partition),
        ..problem
    };
    solver.analyse(&distributed).unwrap();
    let row = *partition.order().last().unwrap() as usize;
    let with = |value: f64| {
        let mut bad = part.clone();
        let entries = bad.indptr().outer_inds_sz(row);
        bad.data_mut()[entries].fill(value);
        bad
    };
    assert_eq!(
        solver.refresh(with(0.0).view()),
        Err(SolveError::Singular { row })
    );
    let diagonal = -1.0;
    assert_eq!(
        solver.refresh(with(diagonal).view()),
        Err(SolveError::NotPositiveDefinite { row, diagonal })
    );
    let undefined = solver.refresh(with(f64::NAN).view()).unwrap_err();
    assert!(matches!(undefined, SolveError::NotFinite { row: found, .. } if found == row));
    solver.refresh(part.view()).unwrap();
    solver
        .solve(
            part.view(),
            &vec![1.0; part.rows()],
            &mut vec![0.0; part.rows()],
        )
        .unwrap();
}

fn sums_are_taken_in_the_order_of_processes(team: &dyn Communicator) {
    let rank = team.rank() as f64;
    let mut values = [rank + 0.1, 1e17 * (1.0 - 2.0 * (rank % 2.0)), f64::NAN];
    team.sum(&mut values);
    let exact: f64 = (0..team.size()).map(|rank| rank as f64 + 0.1).sum();
    assert_eq!(values[0].to_bits(), exact.to_bits());
    assert!(is_the_same_everywhere(team, &values[..2]) && values[2].is_nan());
}

/// What every process of a team does.
#[test]
fn worker() {
    if std::env::var_os(WORKER).is_none() {
        return;
    }
    let team = match petsc_team() {
        Ok(team) => team,
        Err(error) => {
            println!("{UNAVAILABLE}{error}");
            return;
        }
    };
    sums_are_taken_in_the_order_of_processes(&*team);
    an_error_of_one_process_is_that_of_all(&team);
    for (case, flags) in [
        (Case::Flow, ""),
        (Case::Flow, ":-ksp_type cg -pc_type gamg"),
        (Case::Flow, ":-pc_type bjacobi -sub_pc_type icc"),
        (Case::Elasticity, ""),
        (Case::Elasticity, ":-pc_type gamg"),
        (Case::Elasticity, ":-pc_type hypre"),
        (Case::Monolithic, ""),
        (Case::Monolithic, ":-pc_type fieldsplit"),
    ] {
        let hypre = flags.contains("hypre");
        if !hypre || petsc_status().unwrap().packages.contains(&"hypre") {
            the_solution_is_that_of_one_process(&team, case, flags);
        }
    }
    finish();
}

/// What every process does where one of them fails alone: the others wait for it in vain.
#[test]
fn stopper() {
    if std::env::var_os(WORKER).is_none() {
        return;
    }
    match petsc_team() {
        Err(error) => println!("{UNAVAILABLE}{error}"),
        Ok(team) if team.rank() == 1 => abort(3),
        Ok(team) => team.sum(&mut [1.0]),
    }
}

#[test]
fn solutions_do_not_depend_on_the_number_of_processes() {
    if std::env::var_os(WORKER).is_some() {
        return;
    }
    for processes in 1..=4 {
        let Some(output) = start("worker", processes) else {
            return;
        };
        let told = String::from_utf8_lossy(&output.stdout);
        let failed = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "{processes} processes\n{told}\n{failed}"
        );
        assert_eq!(
            told.matches("1 passed").count(),
            processes,
            "{told}\n{failed}"
        );
    }
}

#[test]
fn one_process_can_stop_all() {
    if std::env::var_os(WORKER).is_some() {
        return;
    }
    if let Some(output) = start("stopper", 3) {
        assert_eq!(output.status.code(), Some(3), "{output:?}");
    }
}

/// Runs a test of this program in so many processes; nothing where PETSc or `mpirun` is missing.
fn start(test: &str, processes: usize) -> Option<Output> {
    let output = Command::new("mpirun")
        .args(["--oversubscribe", "--timeout", "300", "-n"])
        .arg(processes.to_string())
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env(WORKER, "1")
        .env("RAYON_NUM_THREADS", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_mpi_yield_when_idle", "1")
        .output();
    let unavailable = match &output {
        Err(error) => Some(format!("mpirun: {error}")),
        Ok(output) => {
            let told = String::from_utf8_lossy(&output.stdout);
            let reason = told.split_once(UNAVAILABLE);
            reason.map(|(_, reason)| reason.lines().next().unwrap_or("").into())
        }
    };
    if let Some(reason) = unavailable {
        let required = std::env::var_os(REQUIRED).is_some();
        assert!(!required, "{REQUIRED} is set, but {reason}");
        eprintln!("skipped: {reason}");
        return None;
    }
    output.ok()
}
