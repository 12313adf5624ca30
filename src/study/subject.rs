//! The case of a study: its scene as typed, its plan, and the grids it can have.

use std::sync::OnceLock;

use crate::model::sample;
use crate::plan::capability::systems;
use crate::plan::{GeometryPlan, Integrator, Plan, SchemeChoice};
use crate::scene::{Geometry, LoadedScene, SchemeName};

use super::{Method, Options};

/// What a study is about.
#[derive(Debug, Clone)]
pub(crate) struct StudyCase {
    /// Path or name of the case, as typed.
    pub scene: String,
    /// Overrides of all runs.
    pub overrides: Vec<String>,
    /// The plan without those of the variants.
    pub plan: Plan,
    fingerprint: u64,
    by_spacing: bool,
    /// Schemes that transforms suit, once asked for.
    transformed: OnceLock<Vec<SchemeName>>,
}

/// A cloud of the case, coarser or finer than its own.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grid {
    /// Largest spacing, m.
    pub spacing: f64,
    /// Points.
    pub points: usize,
    /// Points along the longest side.
    pub along: usize,
    /// Override that makes it; none for the case's own.
    pub overrides: Option<String>,
}

/// Schemes all of whose systems transforms take apart; none where a plan cannot be sampled, which its runs will tell.
fn transformed(plan: &Plan) -> Vec<SchemeName> {
    let integrator = Integrator::TrBdf2;
    let schemes = [
        SchemeChoice::Implicit(integrator),
        SchemeChoice::SemiImplicit(integrator),
        SchemeChoice::Staggered(integrator),
        SchemeChoice::Monolithic(integrator),
    ];
    let suits = |scheme: &SchemeChoice| {
        let scheme = *scheme;
        let plan = Plan {
            scheme,
            ..plan.clone()
        };
        let sampled = match plan.dimension {
            2 => sample::<2>(&plan),
            _ => sample::<3>(&plan),
        };
        let separates = sampled.map_or_else(|_| Vec::new(), |sample| sample.separates);
        let systems = systems(&plan);
        !systems.is_empty() && systems.iter().all(|system| separates.contains(system))
    };
    let suited = schemes.into_iter().filter(suits);
    suited.map(SchemeChoice::scheme).collect()
}

impl StudyCase {
    /// The case as typed, with the overrides of all runs.
    pub(crate) fn new(
        scene: &str,
        loaded: &LoadedScene,
        plan: Plan,
        overrides: Vec<String>,
    ) -> Self {
        let lattice = match &loaded.scene.geometry.value {
            Geometry::Lattice(lattice) => lattice.spacing.is_some(),
            _ => false,
        };
        StudyCase {
            scene: scene.to_owned(),
            overrides,
            transformed: OnceLock::new(),
            plan,
            fingerprint: fingerprint(&loaded.resolved_toml()),
            by_spacing: lattice,
        }
    }

    /// What tells a run from all others: the build of the program, the scene's text, the overrides.
    pub(crate) fn key(&self, build: &str, overrides: &[String]) -> String {
        format!("{build} {:016x} {}", self.fingerprint, overrides.join(" "))
    }

    /// Whether flow and mechanics feel each other.
    pub(crate) fn is_coupled(&self) -> bool {
        self.plan.coupling.is_some()
    }

    /// Schemes that suit the case, as far as the user wants them, with their integrators.
    pub(crate) fn methods(&self, options: &Options) -> Vec<Method> {
        let method = Method::new;
        let (second, first) = (Some("tr-bdf2"), Some("backward-euler"));
        let all = match self.is_coupled() {
            true if self.plan.damage.is_some() => vec![
                method("monolithic", first),
                method("staggered", first),
                method("semi-implicit", first),
                method("explicit", None),
            ],
            true => vec![
                method("monolithic", second),
                method("monolithic", first),
                method("staggered", second),
                method("semi-implicit", second),
                method("explicit", None),
            ],
            false => vec![
                method("implicit", second),
                method("implicit", first),
                method("explicit", None),
            ],
        };
        all.into_iter()
            .filter(|method| options.wants_scheme(method.scheme))
            .collect()
    }

    /// Solvers for a scheme: those of the user, else a factor and multigrid.
    pub(crate) fn solvers(&self, scheme: &str, options: &Options) -> Vec<String> {
        if !options.solvers.is_empty() {
            return options.solvers.clone();
        }
        let names: &[&str] = match scheme {
            "explicit" => &["-"],
            "monolithic" => &["faer-ldlt", "fgmres:preconditioner=schur"],
            _ => &["faer-llt", "faer-cg:preconditioner=amg"],
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    /// The solvers of [`Self::solvers`] after that by transforms, which is the fastest where it can be used.
    pub(crate) fn fastest_solvers(&self, scheme: &str, options: &Options) -> Vec<String> {
        let mut solvers = self.solvers(scheme, options);
        let suited = self.transformed.get_or_init(|| transformed(&self.plan));
        if options.solvers.is_empty() && suited.iter().any(|own| own.name() == scheme) {
            solvers.insert(0, "fourier".to_owned());
        }
        solvers
    }

    /// Lattices between `fewest` and `most` points that divide the domain as the case's own does,
    /// from coarse to fine; the case's own alone for other clouds.
    pub(crate) fn grids(&self, options: &Options, (fewest, most): (usize, usize)) -> Vec<Grid> {
        let GeometryPlan::Lattice { size, cells, .. } = &self.plan.geometry else {
            return vec![Grid {
                spacing: f64::NAN,
                points: 0,
                along: 0,
                overrides: None,
            }];
        };
        let common = cells.iter().copied().fold(0, divisor).max(1);
        let base: Vec<usize> = cells.iter().map(|n| n / common).collect();
        let edge = size[0] / cells[0] as f64;
        let grid = |multiple: usize| {
            let cells: Vec<usize> = base.iter().map(|n| n * multiple).collect();
            let spacing = edge * common as f64 / multiple as f64;
            let list = cells
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(", ");
            Grid {
                spacing,
                points: cells.iter().product(),
                along: cells.iter().copied().max().unwrap_or(0),
                overrides: Some(match self.by_spacing {
                    true => format!("geometry.spacing={spacing:?}"),
                    false => format!("geometry.points=[{list}]"),
                }),
            }
        };
        if !options.points.is_empty() {
            let longest = base.iter().copied().max().unwrap_or(1);
            let wish = |along: &usize| grid((along / longest).max(1));
            return options.points.iter().map(wish).collect();
        }
        // Halved spacings, through the case's own.
        let mut multiples: Vec<usize> = (0..12).map(|k| common << k).collect();
        multiples.extend(
            (1..12)
                .map(|k| common as f64 / f64::from(1 << k))
                .map_while(whole),
        );
        multiples.sort_unstable();
        let fits = |grid: &Grid| (fewest..=most).contains(&grid.points) && self.reaches(grid);
        multiples.into_iter().map(grid).filter(fits).collect()
    }

    /// The coarsest lattice of the case whose spacing is not above the one wanted.
    pub(crate) fn grid_within(&self, wanted: f64) -> Option<Grid> {
        let GeometryPlan::Lattice { size, cells, .. } = &self.plan.geometry else {
            return None;
        };
        let common = cells.iter().copied().fold(0, divisor).max(1);
        let base = cells[0] / common;
        // A little slack, so that a spacing that was run is found again.
        let along = (size[0] / wanted / base as f64 * (1.0 - 1e-9))
            .ceil()
            .max(1.0) as usize;
        let longest = cells.iter().copied().max()? / common;
        let points = vec![along * longest];
        let wish = Options {
            points,
            ..Options::default()
        };
        self.grids(&wish, (0, usize::MAX)).into_iter().next()
    }

    /// Whether the shortest side has two points, so that mirror images make whole families.
    fn reaches(&self, grid: &Grid) -> bool {
        let GeometryPlan::Lattice { size, .. } = &self.plan.geometry else {
            return true;
        };
        let shortest = size.iter().copied().fold(f64::INFINITY, f64::min);
        shortest / grid.spacing > 1.5
    }
}

fn whole(number: f64) -> Option<usize> {
    (number >= 1.0).then(|| number.round() as usize)
}

fn divisor(a: usize, b: usize) -> usize {
    match a {
        0 => b,
        a => divisor(b % a, a),
    }
}

/// FNV-1a: the same for the same text in every version of the compiler.
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
