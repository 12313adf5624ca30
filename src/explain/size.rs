//! Sizes of matrices, factors and everything else that is held.

use super::scheme::{choice, outline};
use super::{MatrixSize, Memory};
use crate::model::{LAYERED, Sample, SolidSample};
use crate::plan::Plan;
use crate::plan::capability::{System, holds_stiffness, systems};

/// Points that a point of a system is coupled to, its own included.
fn neighbours(system: System, sample: &Sample) -> f64 {
    let flow = sample.flow.as_ref().map_or(0.0, |flow| flow.nonzeros);
    let solid = sample.solid.as_ref().map_or(0.0, |solid| solid.neighbours);
    match system {
        System::Flow => flow,
        System::Mechanics => solid,
        System::Monolithic => flow.max(solid),
    }
}

/// Nonzeros per row.
pub(super) fn row(system: System, dimension: usize, sample: &Sample) -> f64 {
    system.width(dimension) as f64 * neighbours(system, sample)
}

/// Every matrix that is held: the operators, and the one system of both.
pub(super) fn matrices(plan: &Plan, sample: &Sample) -> Vec<MatrixSize> {
    let solved = systems(plan);
    let operators = [
        sample.flow.as_ref().map(|_| System::Flow),
        (sample.solid.as_ref())
            .filter(|_| holds_stiffness(plan))
            .map(|_| System::Mechanics),
    ];
    let both = solved.contains(&System::Monolithic);
    let held = operators.into_iter().flatten();
    let held = held.chain(both.then_some(System::Monolithic));
    held.map(|system| matrix(plan, sample, system, solved.contains(&system)))
        .collect()
}

fn matrix(plan: &Plan, sample: &Sample, system: System, solved: bool) -> MatrixSize {
    let unknowns = system.width(plan.dimension) * sample.points;
    let nonzeros = row(system, plan.dimension, sample) * unknowns as f64;
    let bytes = match system {
        // The operator, and the system's own values beside its own.
        System::Flow if solved => 20.0,
        System::Flow => 12.0,
        // The pattern over points is held beside the one over unknowns.
        System::Mechanics => 12.0 + 4.0 / (plan.dimension * plan.dimension) as f64,
        System::Monolithic => 20.0,
    };
    let name = choice(plan, sample, system).name;
    let factor = || 12.0 * nonzeros * fill(plan.dimension, sample, system);
    let whole = || flops(plan, sample, system);
    let (factor, factor_flops) = match Held::by(&name) {
        _ if !solved => (0.0, 0.0),
        Held::Factor => (factor(), whole()),
        Held::HalfFactor => (0.5 * factor(), whole()),
        Held::Bands => {
            let width = band(system, plan.dimension, sample);
            let unknowns = unknowns as f64;
            (8.0 * width * unknowns, width.powi(2) * unknowns)
        }
        Held::Hierarchy(per_nonzero) => {
            let levels = per_nonzero * nonzeros + HIERARCHY_PER_UNKNOWN * unknowns as f64;
            (levels, 0.0)
        }
        Held::Unknown => (0.0, 0.0),
    };
    MatrixSize {
        name: system.name(),
        unknowns,
        nonzeros: nonzeros as u64,
        solved,
        bytes: (bytes * nonzeros) as u64,
        factor: factor as u64,
        factor_flops,
    }
}

/// Entries of a row of a banded factor: those of the points as far as rows reach, in a square or cube.
fn band(system: System, dimension: usize, sample: &Sample) -> f64 {
    let across = neighbours(system, sample).powf(1.0 / dimension as f64);
    system.width(dimension) as f64 * 0.5 * (across + 1.0)
}

/// What a solver holds beside the matrix.
enum Held {
    /// A factor in double precision.
    Factor,
    /// A factor in single precision.
    HalfFactor,
    /// Banded factors of all wavenumbers.
    Bands,
    /// Levels of multigrid, so many bytes per nonzero of the matrix.
    Hierarchy(f64),
    /// Little, or what another program knows.
    Unknown,
}

/// Bytes of a hierarchy per unknown: blocks of the smoother, vectors, prolongation.
const HIERARCHY_PER_UNKNOWN: f64 = 300.0;

impl Held {
    /// By the solver's text; sizes of hierarchies are fitted to measured ones.
    fn by(solver: &str) -> Self {
        let has = |word: &str| solver.contains(word);
        match solver {
            "fourier" => Held::Bands,
            _ if has("preconditioner=amg") => Held::Hierarchy(9.0),
            _ if has("=schur") || has("=fixed-stress") => Held::Hierarchy(24.0),
            _ if has("preconditioner=f32") => Held::HalfFactor,
            _ if has("llt") || has("ldlt") || has("preconditioner=stale") => Held::Factor,
            _ => Held::Unknown,
        }
    }
}

/// Operations of one factorisation: nested dissection, or a sweep where the cloud is slender.
fn flops(plan: &Plan, sample: &Sample, system: System) -> f64 {
    let own = system.width(plan.dimension) as f64;
    let depth = neighbours(system, sample).powf(1.0 / plan.dimension as f64);
    let front = own * depth * sample.across.powi(plan.dimension as i32 - 1);
    let sweep = own * sample.points as f64 * front.powi(2);
    outline(plan, sample, system).factor().flops.min(sweep)
}

/// Fill of a factor with nested dissection per nonzero of the matrix, from measured factors.
fn fill(dimension: usize, sample: &Sample, system: System) -> f64 {
    let points = sample.points as f64;
    let fill = match (system, dimension) {
        // One hop: about n log n in 2-D and n^(4/3) in 3-D.
        (System::Flow, 2) => 0.31 * points.log2(),
        (System::Flow, _) => 0.14 * points.cbrt(),
        // Two hops: separators are as thick as rows are long, and no wider than the cloud.
        (_, 2) => {
            let across = 1.3 * sample.across.powi(2) / neighbours(system, sample);
            return (0.41 * across.log2()).max(0.6);
        }
        (_, _) => sample.across / neighbours(system, sample).cbrt(),
    };
    fill.max(1.0)
}

/// Resident memory at its highest, over what is held in the end: families and matrices are put together
/// beside their parts. Measured on 17 runs of bundled cases from 22 to 400 MB (factors, multigrid, Schur;
/// two and three dimensions; damage): 0.71 to 1.04 of what is told so.
const PEAK: f64 = 1.6;
/// What the program takes without a model, bytes.
const PROGRAM: u64 = 16_000_000;

/// Contrast of moduli from which families may have weights of their own besides (`model/laminate.rs`).
const CHANGED: f64 = 10.0;

/// Layers of the families of a field of moduli, bytes per point: three numbers per bond, D⁴ and the layers themselves per
/// family. Layers beside interfaces of regions are of few families.
fn layers(plan: &Plan, solid: &SolidSample) -> f64 {
    let named = (plan.mechanics.as_ref()).is_some_and(|own| own.has_layers(plan.damage.is_some()));
    if !(named && plan.has_elastic_fields() && solid.contrast > LAYERED) {
        return 0.0;
    }
    let dimension = plan.dimension as f64;
    let changed = match solid.contrast > CHANGED {
        true => 8.0 * dimension,
        false => 0.0,
    };
    (24.0 + changed) * solid.bonds + 8.0 * dimension.powi(4) + 64.0
}

/// Estimated memory of a model and its matrices.
pub(super) fn memory(plan: &Plan, sample: &Sample, matrices: &[MatrixSize]) -> Memory {
    let (points, dimension) = (sample.points as f64, plan.dimension as f64);
    let per_point = 8.0 * (dimension * dimension + 1.0) + 20.0;
    let families = |bonds: f64| 25.0 * bonds * points + points * per_point;
    let weights = |bonds: f64, kept: usize| kept as f64 * bonds * points * 8.0 * dimension;
    let (mut bonds, mut gradients, mut fields) = (0.0, 0.0, 0.0);
    if let Some(flow) = &sample.flow {
        let kept = usize::from(flow.second_hop) * (1 + usize::from(flow.corrected));
        bonds += families(flow.bonds);
        gradients += weights(flow.bonds, kept);
        fields += points * 8.0 * (2.0 * dimension + 16.0);
    }
    if let Some(solid) = &sample.solid {
        bonds += families(solid.bonds);
        gradients += weights(solid.bonds, 1 + usize::from(solid.corrected));
        gradients += points * layers(plan, solid);
        fields += points * 8.0 * 16.0 * dimension;
        if !holds_stiffness(plan) {
            // Forces from bonds: fields of displacements and stresses by sites.
            fields += points * 8.0 * (dimension * dimension + 4.0 * dimension + 2.0);
        }
    }
    let held: u64 = matrices.iter().map(|matrix| matrix.bytes).sum();
    let factors: u64 = matrices.iter().map(|matrix| matrix.factor).sum();
    let total = (bonds + gradients + fields) as u64 + held + factors;
    Memory {
        bonds: bonds as u64,
        gradients: gradients as u64,
        matrices: held,
        factor: factors,
        fields: fields as u64,
        total,
        peak: (PEAK * total as f64) as u64 + PROGRAM,
    }
}
