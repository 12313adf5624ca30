//! What the benches share: the operators that are measured, fair medians, and the memory triad.
#![allow(dead_code, reason = "every bench uses its own part")]

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use perifrac::model::{FlowModel, Model};
use perifrac::plan::{Plan, resolve};
use perifrac::report::Timers;
use perifrac::run::{Interrupt, Summary, run};
use perifrac::schemes::{ForwardEuler, Scheme, State};
use perifrac::{cases, scene};
use rayon::prelude::*;

/// One operator whose hot loops are measured.
pub struct Operator {
    /// Name in tables.
    pub name: &'static str,
    /// Bundled case it comes from.
    pub case: &'static str,
    /// 2 or 3.
    pub dimension: usize,
    /// `--set` values.
    pub overrides: &'static [&'static str],
    /// `--set` value that makes it small, for a run that only checks that the bench works.
    pub small: &'static str,
}

/// Small plane lattice for runs that only check.
const SMALL_PLANE: &str = "geometry.points=[20, 20]";
/// Small solid lattice for runs that only check.
const SMALL_SOLID: &str = "geometry.points=[10, 10, 10]";

/// Operators of the hot-loop benches.
pub const OPERATORS: [Operator; 5] = [
    Operator {
        name: "2-D 200x200, correspondence, one hop",
        case: "five-spot",
        dimension: 2,
        overrides: &[],
        small: SMALL_PLANE,
    },
    Operator {
        name: "2-D 200x200, correspondence, two hops",
        case: "five-spot",
        dimension: 2,
        overrides: &["flow.hourglass=0.5"],
        small: SMALL_PLANE,
    },
    Operator {
        name: "2-D 200x200, bond",
        case: "five-spot",
        dimension: 2,
        overrides: &["flow.operator=bond"],
        small: SMALL_PLANE,
    },
    Operator {
        name: "3-D 40x40x40, correspondence, two hops",
        case: "reservoir-3d",
        dimension: 3,
        overrides: &[
            "geometry.points=[40, 40, 40]",
            "geometry.size=[100, 100, 100]",
        ],
        small: SMALL_SOLID,
    },
    Operator {
        name: "3-D 40x40x40, correspondence, one hop",
        case: "reservoir-3d",
        dimension: 3,
        overrides: &[
            "geometry.points=[40, 40, 40]",
            "geometry.size=[100, 100, 100]",
            "flow.hourglass=1.5",
        ],
        small: SMALL_SOLID,
    },
];

impl Operator {
    /// Plan of the operator, small if `quick`.
    pub fn plan(&self, quick: bool) -> Result<Plan> {
        let mut overrides = self.overrides.to_vec();
        if quick {
            overrides.retain(|text| !text.starts_with("geometry.points"));
            overrides.push(self.small);
        }
        plan(self.case, &overrides)
    }
}

/// Whether this is only a check that the bench works: cargo gives `--bench` to real runs.
pub fn quick() -> bool {
    !std::env::args().any(|argument| argument == "--bench")
}

/// Plan of a bundled case with `--set` values.
pub fn plan(case: &str, overrides: &[&str]) -> Result<Plan> {
    let text = cases::find(case)
        .with_context(|| format!("no bundled case {case}"))?
        .scene;
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let loaded = scene::load_str(case, text, Path::new(""), &overrides)
        .map_err(|errors| anyhow!("{errors}"))?;
    resolve(&loaded, case).map_err(|errors| anyhow!("{errors}"))
}

/// Model of a plan.
pub fn model<const D: usize>(plan: &Plan) -> Result<Model<D>> {
    Ok(Model::build(plan, &mut Timers::default())?)
}

/// Runs a plane plan without writing anything.
pub fn summary(plan: &Plan) -> Result<Summary> {
    Ok(run(plan, None, &mut (), &Interrupt::default())?.0)
}

/// Seconds that `work` takes.
pub fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// Seconds per call over `calls` calls in a row.
pub fn seconds_each(calls: usize, mut work: impl FnMut()) -> f64 {
    seconds(|| (0..calls).for_each(|_| work())) / calls as f64
}

/// Middle of the samples; the mean of the two middle ones of an even number.
pub fn median(samples: &[f64]) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() % 2 {
        1 => sorted[middle],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    }
}

/// A figure in bytes under `key` of a process's status file, such as `VmHWM:`.
pub fn memory(path: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024)
}

/// A pressure field with a share of every mode, in Pa around 1 MPa, shape `(n,)`.
pub fn rough_pressure(points: usize) -> Vec<f64> {
    (0..points)
        .map(|i| 1e6 * (1.0 + 0.1 * (0.37 * i as f64).sin()))
        .collect()
}

/// The flow part of a model.
pub fn flow<const D: usize>(model: &Model<D>) -> Result<&FlowModel<D>> {
    model.flow.as_ref().context("the plan names flow")
}

/// Fills the flow matrix anew.
pub fn refill<const D: usize>(model: &mut Model<D>) {
    model.flow.iter_mut().for_each(FlowModel::refill);
}

/// Forward Euler steps at nine tenths of the stability limit.
pub struct Marcher<const D: usize> {
    scheme: ForwardEuler<D>,
    dt: f64,
    old: State,
    trial: State,
}

impl<const D: usize> Marcher<D> {
    /// Starts from the model's initial state.
    pub fn new(model: &Model<D>) -> Result<Self> {
        let scheme = ForwardEuler::new(model)?;
        let limit = scheme.limit().context("forward Euler has a limit")?.dt;
        let old = State::initial(model);
        Ok(Marcher {
            scheme,
            dt: 0.9 * limit,
            trial: old.clone(),
            old,
        })
    }

    /// One step.
    pub fn step(&mut self, model: &mut Model<D>) -> Result<()> {
        self.scheme
            .step(model, &self.old, self.dt, &mut self.trial)?;
        std::mem::swap(&mut self.old, &mut self.trial);
        Ok(())
    }
}

/// Bytes a forward Euler step must move: matrix, row offsets, and old, new, rate and capacity.
pub fn step_bytes<const D: usize>(flow: &FlowModel<D>) -> u64 {
    (12 * flow.pattern.nonzeros() + (4 + 4 * 8) * flow.points()) as u64
}

/// Bytes a product must move: matrix, row offsets, and both vectors.
pub fn product_bytes<const D: usize>(flow: &FlowModel<D>) -> u64 {
    (12 * flow.pattern.nonzeros() + (4 + 2 * 8) * flow.points()) as u64
}

/// The memory triad a = b + s c on arrays far larger than any cache.
pub struct Triad {
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
}

impl Triad {
    /// Numbers per array: 64 MiB.
    const LENGTH: usize = 8 << 20;
    /// Numbers per parallel task.
    const TASK: usize = 1 << 14;

    /// Three arrays, first written by the threads that will use them.
    pub fn new() -> Self {
        let array = |value: f64| (0..Self::LENGTH).into_par_iter().map(|_| value).collect();
        Triad {
            a: array(0.0),
            b: array(1.0),
            c: array(2.0),
        }
    }

    /// Runs the loop once.
    pub fn run(&mut self) {
        let scale = black_box(3.0);
        let (b, c) = (self.b.par_chunks(Self::TASK), self.c.par_chunks(Self::TASK));
        self.a
            .par_chunks_mut(Self::TASK)
            .zip(b)
            .zip(c)
            .for_each(|((a, b), c)| {
                for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                    *a = b + scale * c;
                }
            });
        black_box(&mut self.a);
    }

    /// Bytes the loop moves: two arrays read, one written.
    pub fn bytes() -> u64 {
        (3 * 8 * Self::LENGTH) as u64
    }
}
