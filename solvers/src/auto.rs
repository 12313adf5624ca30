//! Backend `auto`: chooses by the estimated cost of a factor and of multigrid, then hands over.

use crate::estimate::{Cost, FactorEstimate, Outline};
use crate::problem::{Problem, Symmetry};
use crate::registry::{Backend, Options};
use crate::{
    CsrView, LinearSolver, SolveError, SolveReport, SolverCounters, SolverSpec, SpecError,
};

const NAME: &str = "auto";
/// Entries of a factor beyond which its memory is not asked for: 12 GB of values.
const LARGEST_FACTOR: f64 = 1.5e9;
/// Unknowns up to which a system without symmetry is factored.
const LARGEST_LU: usize = 10_000;
/// Unknowns, and operations of a factor, up to which it costs next to nothing, whatever the estimates say: 1,700 points of
/// a coupled system in the plane take 2e8. In space 1,000 points take 2e10, and passes that share a factor in single
/// precision there were 1.6 times as fast.
const SMALL: (usize, f64) = (5_000, 1e9);

/// The entry of this backend in the table.
pub(crate) const BACKEND: Backend = Backend {
    name: NAME,
    summary: "chooses a backend from lattice, size, stencil, symmetry, contrast, solves per matrix, processes",
    symmetries: &[
        Symmetry::PositiveDefinite,
        Symmetry::QuasiDefinite,
        Symmetry::Indefinite,
        Symmetry::General,
    ],
    distributed: true,
    lattices_only: false,
    options: &[],
    build,
};

/// The backend chosen for a problem, with the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// What to build.
    pub spec: SolverSpec,
    /// Why, in one sentence.
    pub reason: String,
}

/// Chooses a backend for a system of which only the outline is known.
///
/// # Errors
/// None in practice: the specifications chosen from are valid.
pub fn choose(outline: &Outline) -> Result<Choice, SolveError> {
    let (text, reason) = match outline.symmetry {
        _ if outline.processes > 1 => (
            "petsc",
            format!("{} processes share the matrix", outline.processes),
        ),
        Symmetry::PositiveDefinite => by_cost(outline, &DEFINITE),
        Symmetry::QuasiDefinite => by_cost(outline, &COUPLED),
        Symmetry::Indefinite | Symmetry::General if outline.unknowns() <= LARGEST_LU => {
            ("faer-lu", "no definite structure, and small".to_owned())
        }
        Symmetry::Indefinite | Symmetry::General => (
            "gmres:preconditioner=ilu0",
            "no definite structure, and too large for an unsymmetric factor".to_owned(),
        ),
    };
    let spec = text.parse().map_err(|error: SpecError| invalid(&error))?;
    let (unknowns, width) = (outline.unknowns(), outline.entries_per_row);
    let reason = format!("{unknowns} unknowns with {width:.0} entries a row: {reason}");
    Ok(Choice { spec, reason })
}

/// The ways to solve a kind of system.
struct Ways {
    direct: &'static str,
    multilevel: &'static str,
    /// Cost of the second one.
    cost: fn(&Outline) -> Cost,
    /// With a factor of an earlier matrix, where that may serve.
    kept: Option<&'static str>,
}

const DEFINITE: Ways = Ways {
    direct: "faer-llt",
    multilevel: "faer-cg:preconditioner=amg",
    cost: Cost::multilevel,
    kept: None,
};

/// A quasi-definite matrix has an LDLᵀ factor without pivoting.
const COUPLED: Ways = Ways {
    direct: "faer-ldlt",
    multilevel: "fgmres:preconditioner=schur",
    cost: Cost::blocks,
    kept: Some("fgmres:preconditioner=f32"),
};

/// The cheapest one of a factor, a factor that is kept, and multigrid.
fn by_cost(outline: &Outline, ways: &Ways) -> (&'static str, String) {
    let (direct, multilevel) = (ways.direct, ways.multilevel);
    let FactorEstimate { nonzeros, flops } = outline.factor();
    if outline.unknowns() <= SMALL.0 && flops <= SMALL.1 {
        return (direct, "small, so a factor is cheapest".to_owned());
    }
    if outline.separates {
        let reason = "the rows repeat, so transforms are cheapest";
        return ("fourier", reason.to_owned());
    }
    if nonzeros > LARGEST_FACTOR {
        let gigabytes = 8e-9 * nonzeros;
        return (multilevel, format!("a factor would take {gigabytes:.0} GB"));
    }
    let solves = outline.solves.max(1);
    let direct_s = Cost::direct(outline).total(solves);
    let cycles_s = (ways.cost)(outline).total(solves);
    let times = if solves == 1 { "solve" } else { "solves" };
    if let Some(kept) = ways.kept.filter(|_| outline.lags) {
        let kept_s = Cost::kept(outline).total(solves);
        if kept_s < direct_s.min(cycles_s) {
            let reason = format!(
                "for {solves} {times} a matrix a factor in single precision that serves several matrices is cheapest \
                 (about {kept_s:.1e} s; a factor {direct_s:.1e} s, multigrid {cycles_s:.1e} s)"
            );
            return (kept, reason);
        }
    }
    let (text, word) = match direct_s <= cycles_s {
        true => (direct, "a factor is cheaper"),
        false => (multilevel, "multigrid is cheaper"),
    };
    let reason = format!(
        "for {solves} {times} a matrix {word} (about {direct_s:.1e} s against {cycles_s:.1e} s)"
    );
    (text, reason)
}

fn invalid(error: &SpecError) -> SolveError {
    SolveError::InvalidProblem {
        reason: error.to_string(),
    }
}

fn build(_options: &Options<'_>) -> Result<Box<dyn LinearSolver>, SpecError> {
    Ok(Box::new(Auto {
        chosen: None,
        idle: SolverCounters::default(),
    }))
}

struct Auto {
    chosen: Option<Box<dyn LinearSolver>>,
    idle: SolverCounters,
}

impl Auto {
    fn chosen(&mut self) -> Result<&mut Box<dyn LinearSolver>, SolveError> {
        let missing = SolveError::NotAnalysed {
            solver: NAME,
            missing: "analyse",
        };
        self.chosen.as_mut().ok_or(missing)
    }
}

impl LinearSolver for Auto {
    fn name(&self) -> &'static str {
        self.chosen.as_ref().map_or(NAME, |solver| solver.name())
    }

    fn analyse(&mut self, problem: &Problem<'_>) -> Result<(), SolveError> {
        self.chosen = None;
        problem.validate()?;
        let mut solver = choose(&Outline::of(problem))?
            .spec
            .build()
            .map_err(|error| invalid(&error))?;
        solver.analyse(problem)?;
        self.chosen = Some(solver);
        Ok(())
    }

    fn refresh(&mut self, matrix: CsrView<'_>) -> Result<(), SolveError> {
        self.chosen()?.refresh(matrix)
    }

    fn begin_anew(&mut self) {
        if let Some(solver) = &mut self.chosen {
            solver.begin_anew();
        }
    }

    fn solve_to(
        &mut self,
        matrix: CsrView<'_>,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
    ) -> Result<SolveReport, SolveError> {
        self.chosen()?.solve_to(matrix, rhs, x, tolerance)
    }

    fn is_direct(&self) -> bool {
        self.chosen
            .as_ref()
            .is_some_and(|solver| solver.is_direct())
    }

    fn counters(&self) -> &SolverCounters {
        self.chosen
            .as_ref()
            .map_or(&self.idle, |solver| solver.counters())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::{grid_laplacian, jittered_grid, noisy_vector, positive_definite};

    fn outline(points: usize, unknowns_per_point: usize, solves: usize) -> Outline {
        Outline {
            symmetry: match unknowns_per_point {
                3 => Symmetry::QuasiDefinite,
                _ => Symmetry::PositiveDefinite,
            },
            points,
            unknowns_per_point,
            entries_per_row: 63.0 * unknowns_per_point as f64,
            dimension: 2,
            solves,
            lags: false,
            contrast: 1.0,
            volume_stiffness: 1.0,
            separates: false,
            processes: 1,
        }
    }

    fn chosen(outline: &Outline) -> String {
        choose(outline).unwrap().spec.to_string()
    }

    #[test]
    fn many_solves_with_one_matrix_pay_for_a_factor() {
        let mut elasticity = outline(160_000, 2, 1);
        assert_eq!(chosen(&elasticity), "faer-cg:preconditioner=amg");
        elasticity.solves = 100;
        assert_eq!(chosen(&elasticity), "faer-llt");
        let reason = choose(&elasticity).unwrap().reason;
        assert!(
            reason.starts_with("320000 unknowns with 126 entries a row: for 100 solves a matrix"),
            "{reason}"
        );
    }

    #[test]
    fn small_systems_are_factored_and_huge_factors_avoided() {
        assert_eq!(chosen(&outline(4_000, 1, 1)), "faer-llt");
        assert_eq!(
            chosen(&outline(4_000_000, 2, 1000)),
            "faer-cg:preconditioner=amg"
        );
        assert_eq!(chosen(&outline(1_500, 3, 1)), "faer-ldlt");
        assert_eq!(
            chosen(&outline(1_000_000, 3, 1)),
            "fgmres:preconditioner=schur"
        );
    }

    /// Measured at 200² points: 10 s and 0.2 s a solve against 3.3 s and 0.5 s.
    #[test]
    fn coupled_systems_are_factored_if_the_factor_serves_often() {
        assert_eq!(
            chosen(&outline(40_000, 3, 2)),
            "fgmres:preconditioner=schur"
        );
        assert_eq!(chosen(&outline(40_000, 3, 200)), "faer-ldlt");
    }

    /// `natural-fractures` with 5,000 and 20,000 points, a pass: 0.29 and 2.1 s by a factor of its own, 0.1 and
    /// 1.2 s by one that is kept.
    #[test]
    fn matrices_that_change_by_little_share_a_factor_in_single_precision() {
        for points in [5_000, 20_000] {
            let mut cracks = Outline {
                lags: true,
                contrast: 1e4,
                ..outline(points, 3, 1)
            };
            cracks.entries_per_row = 147.0;
            assert_eq!(chosen(&cracks), "fgmres:preconditioner=f32");
            cracks.lags = false;
            assert_ne!(chosen(&cracks), "fgmres:preconditioner=f32");
        }
    }

    #[test]
    fn in_space_multigrid_pays_sooner() {
        let plane = outline(20_000, 1, 10);
        let space = Outline {
            dimension: 3,
            entries_per_row: 170.0,
            ..plane
        };
        assert_eq!(chosen(&plane), "faer-llt");
        assert_eq!(chosen(&space), "faer-cg:preconditioner=amg");
    }

    #[test]
    fn several_processes_and_other_symmetries_have_their_own() {
        let shared = Outline {
            processes: 2,
            ..outline(100, 1, 1)
        };
        assert_eq!(chosen(&shared), "petsc");
        let mut general = Outline {
            symmetry: Symmetry::General,
            ..outline(1_000, 1, 1)
        };
        assert_eq!(chosen(&general), "faer-lu");
        general.points = 100_000;
        assert_eq!(chosen(&general), "gmres:preconditioner=ilu0");
    }

    #[test]
    fn the_chosen_backend_does_the_work_and_the_counting() {
        let (a, cloud) = (grid_laplacian(12, 9, 0.0), jittered_grid(12, 9, 0.0));
        let mut solver = SolverSpec::default().build().unwrap();
        assert_eq!(solver.name(), "auto");
        assert_eq!(solver.counters(), &SolverCounters::default());
        solver
            .analyse(&positive_definite(&a, Some(&cloud), 1))
            .unwrap();
        solver.refresh(a.view()).unwrap();
        let mut x = vec![0.0; a.rows()];
        let report = solver
            .solve(a.view(), &noisy_vector(a.rows()), &mut x)
            .unwrap();
        assert!(report.true_residual < 1e-13);
        assert_eq!((solver.name(), solver.counters().solves), ("faer-llt", 1));
    }
}
