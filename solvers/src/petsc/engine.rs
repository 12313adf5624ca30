//! The objects of PETSc behind one solver. They live on the thread of PETSc.

use std::borrow::Cow;

use perifrac_petsc_sys::{
    Comm, FactorSize, Failure, IndexSet, Kind, Matrix, PetscError, Rows, Session, Solver, Vector,
    run,
};

use super::layout::{Layout, Pattern};
use super::options::{Flags, Nature, knows_true_residual};
use super::outcome::petsc_error;
use crate::SolveError;
use crate::problem::{Problem, Symmetry};

/// Aggregates of an earlier matrix are kept until convergence slows down by this factor.
const SLOWER: f64 = 1.5;

/// Runs work on the thread of PETSc.
pub(crate) fn on_thread<R: Send>(
    flags: &Flags,
    work: impl FnOnce(&'static Session) -> Result<R, PetscError> + Send,
) -> Result<R, SolveError> {
    run(work)
        .and_then(|result| result)
        .map_err(|error| petsc_error(error, flags))
}

/// Matrix, vectors and method.
pub(crate) struct Engine {
    matrix: Matrix,
    solver: Solver,
    rhs: Vector,
    x: Vector,
    direct: bool,
    /// Whether unused flags have been looked for after a set-up and after a solve.
    checked: [bool; 2],
    aggregates: Aggregates,
    recipe: Recipe,
}

/// How the solver was made, but for blocks.
struct Recipe {
    session: &'static Session,
    comm: Comm,
    defaults: Vec<(&'static str, String)>,
    given: String,
    /// Whether convergence is judged by the true residual.
    true_residual: bool,
}

/// Whether `gamg` may keep its aggregates.
struct Aggregates {
    /// There are some, and no flag of the user decides.
    managed: bool,
    /// They have been made.
    made: bool,
    /// They stem from an earlier matrix.
    kept: bool,
    /// Iterations per decade with fresh aggregates, and in the last solve.
    fresh: Option<f64>,
    last: f64,
}

/// How a set-up ended.
pub(crate) struct SetUp {
    pub(crate) failure: Option<Failure>,
    pub(crate) factor: Option<FactorSize>,
    pub(crate) direct: bool,
    /// Flags that nothing reads.
    pub(crate) missed: Vec<String>,
}

/// How a solve ended.
pub(crate) struct Solved {
    pub(crate) iterations: usize,
    pub(crate) failure: Option<Failure>,
    /// The preconditioner was set up anew on the way.
    pub(crate) rebuilt: bool,
    /// Flags that nothing reads.
    pub(crate) missed: Vec<String>,
}

impl Engine {
    pub(crate) fn new(
        session: &'static Session,
        flags: &Flags,
        problem: &Problem<'_>,
        layout: &Layout,
        pattern: &Pattern,
    ) -> Result<Self, PetscError> {
        let packages = &session.info().packages;
        let nature = Nature::of(problem, check_team(session, problem)?, packages);
        let comm = layout.comm();
        let mut matrix = Matrix::new(
            session,
            comm,
            &rows(layout, pattern),
            kind(problem.symmetry),
        )?;
        let mut recipe = Recipe {
            session,
            comm,
            defaults: flags.defaults(&nature),
            given: flags.text.clone(),
            true_residual: false,
        };
        let mut solver = Solver::new(session, comm, &recipe.defaults, &recipe.given)?;
        solver.set_matrix(&matrix)?;
        if nature.rigid_modes {
            matrix.set_rigid_modes(&coordinates(session, problem, layout)?)?;
        }
        if nature.blocks && wants_blocks(flags, &nature) {
            add_blocks(session, &mut solver, problem, layout)?;
        }
        solver.configure()?;
        let method = solver.method()?;
        recipe.true_residual = knows_true_residual(&method) && !flags.has("-ksp_norm_type");
        if recipe.true_residual {
            solver.use_true_residual()?;
        }
        let preconditioner = solver.preconditioner()?;
        let vector = || Vector::new(session, comm, layout.rows(), layout.per_point());
        Ok(Self {
            direct: is_direct(&method, &preconditioner),
            matrix,
            solver,
            rhs: vector()?,
            x: vector()?,
            checked: [false; 2],
            aggregates: Aggregates::new(flags, &preconditioner),
            recipe,
        })
    }

    /// Whether the solution is that of a factorisation.
    pub(crate) fn is_direct(&self) -> bool {
        self.direct
    }

    /// Takes new values and sets up for them.
    pub(crate) fn refresh(
        &mut self,
        flags: &Flags,
        values: Cow<'_, [f64]>,
    ) -> Result<SetUp, PetscError> {
        self.matrix.set_values(&values)?;
        // The set-up is when most memory is in use.
        drop(values);
        let aggregates = &mut self.aggregates;
        if aggregates.managed {
            let good = |fresh: f64| aggregates.last <= SLOWER * fresh;
            aggregates.kept = aggregates.fresh.is_some_and(good);
            if aggregates.kept {
                self.solver.keep_aggregates(true)?;
            } else if std::mem::replace(&mut aggregates.made, true) {
                self.start_afresh()?;
            }
        }
        let failure = self.set_up()?;
        let mut missed = self.missed(flags, 0)?;
        // The solvers of blocks are set up by the first solve.
        missed.retain(|flag| !flag.starts_with("-fieldsplit_"));
        let factor = match failure {
            None => self.solver.factor_size()?,
            Some(_) => None,
        };
        Ok(SetUp {
            failure,
            factor,
            direct: self.direct,
            missed,
        })
    }

    /// Keeps no aggregates of an earlier matrix in the next set-up.
    pub(crate) fn begin_anew(&mut self) {
        self.aggregates.fresh = None;
    }

    /// Flags that nothing has read, looked for once at each of the two stages.
    fn missed(&mut self, flags: &Flags, stage: usize) -> Result<Vec<String>, PetscError> {
        if std::mem::replace(&mut self.checked[stage], true) {
            return Ok(Vec::new());
        }
        Ok(flags.missed(&self.solver.unused_flags()?))
    }

    /// Sets up now: PETSc would put it off to the next solve unless told of the matrix again.
    fn set_up(&mut self) -> Result<Option<Failure>, PetscError> {
        self.solver.set_matrix(&self.matrix)?;
        self.solver.set_up()
    }

    /// Makes the solver anew: a hierarchy that was kept once keeps the sizes of its levels, and PETSc
    /// (3.18) refuses others.
    fn start_afresh(&mut self) -> Result<(), PetscError> {
        self.aggregates.kept = false;
        self.aggregates.fresh = None;
        let Recipe {
            session,
            comm,
            defaults,
            given,
            true_residual,
        } = &self.recipe;
        let mut solver = Solver::new(session, *comm, defaults, given)?;
        solver.set_matrix(&self.matrix)?;
        solver.configure()?;
        if *true_residual {
            solver.use_true_residual()?;
        }
        self.solver = solver;
        Ok(())
    }

    /// Solves for one right-hand side of norm 1 to a relative residual. Where kept aggregates
    /// fail, they are made anew.
    pub(crate) fn solve(
        &mut self,
        flags: &Flags,
        aim: f64,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<Solved, PetscError> {
        self.rhs.set(rhs)?;
        self.solver.set_tolerance(aim)?;
        let mut outcome = self.solver.solve(&self.rhs, &mut self.x)?;
        let mut iterations = outcome.iterations;
        let rebuilt = outcome.failure.is_some() && self.aggregates.kept;
        if rebuilt {
            self.start_afresh()?;
            self.set_up()?;
            self.solver.set_tolerance(aim)?;
            outcome = self.solver.solve(&self.rhs, &mut self.x)?;
            iterations += outcome.iterations;
        }
        self.aggregates.note(outcome.iterations, aim);
        self.x.get(x)?;
        Ok(Solved {
            iterations,
            failure: outcome.failure,
            rebuilt,
            missed: self.missed(flags, 1)?,
        })
    }
}

impl Aggregates {
    fn new(flags: &Flags, preconditioner: &str) -> Self {
        Self {
            managed: preconditioner == "gamg" && !flags.has("-pc_gamg_reuse_interpolation"),
            made: false,
            kept: false,
            fresh: None,
            last: 0.0,
        }
    }

    fn note(&mut self, iterations: usize, aim: f64) {
        self.last = iterations as f64 / -aim.log10();
        self.fresh.get_or_insert(self.last);
    }
}

/// Number of processes that hold the problem.
fn check_team(session: &Session, problem: &Problem<'_>) -> Result<usize, PetscError> {
    let Some(partition) = problem.partition else {
        return Ok(1);
    };
    let (info, team) = (session.info(), partition.team());
    if (info.rank, info.size) == (team.rank(), team.size()) {
        return Ok(info.size);
    }
    Err(PetscError::Input(format!(
        "the partition is for process {} of {}, but MPI says {} of {}",
        team.rank(),
        team.size(),
        info.rank,
        info.size
    )))
}

/// Whether a solution is that of a factorisation.
fn is_direct(method: &str, preconditioner: &str) -> bool {
    method == "preonly" && ["lu", "cholesky"].contains(&preconditioner)
}

fn rows<'a>(layout: &Layout, pattern: &'a Pattern) -> Rows<'a> {
    Rows {
        starts: &pattern.starts,
        columns: &pattern.columns,
        size: layout.size(),
        block: layout.per_point(),
    }
}

fn kind(symmetry: Symmetry) -> Kind {
    match symmetry {
        Symmetry::PositiveDefinite => Kind::PositiveDefinite,
        Symmetry::QuasiDefinite | Symmetry::Indefinite => Kind::Symmetric,
        Symmetry::General => Kind::General,
    }
}

/// Coordinates of the points of this process.
fn coordinates(
    session: &'static Session,
    problem: &Problem<'_>,
    layout: &Layout,
) -> Result<Vector, PetscError> {
    let (dimension, values) = problem
        .coordinates
        .map_or((1, &[][..]), |found| (found.dimension, found.values));
    let own = layout.at_points(values, dimension);
    let mut vector = Vector::new(session, layout.comm(), own.len(), dimension)?;
    vector.set(&own)?;
    Ok(vector)
}

fn wants_blocks(flags: &Flags, nature: &Nature) -> bool {
    let defaults = flags.defaults(nature);
    let default = defaults.iter().find(|(flag, _)| *flag == "-pc_type");
    let chosen = flags
        .value("-pc_type")
        .or(default.map(|(_, value)| value.as_str()));
    chosen == Some("fieldsplit")
}

/// Names the displacements `u` and the pressures `p`.
fn add_blocks(
    session: &'static Session,
    solver: &mut Solver,
    problem: &Problem<'_>,
    layout: &Layout,
) -> Result<(), PetscError> {
    let dimension = layout.per_point() - 1;
    let solid = layout.numbers(0..dimension);
    let mut solid = IndexSet::new(session, layout.comm(), &solid, dimension)?;
    solid.set_rigid_modes(&coordinates(session, problem, layout)?)?;
    solver.add_block("u", &solid)?;
    let fluid = layout.numbers(dimension..dimension + 1);
    solver.add_block("p", &IndexSet::new(session, layout.comm(), &fluid, 1)?)
}
