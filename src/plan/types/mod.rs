//! What a plan holds. Everything is in SI units; a missing option means the effect does not exist.

mod crack;
mod damage;
mod descent;
mod field;
mod initial;
mod material;
mod mechanics;
mod scheme;
mod well;

use std::path::PathBuf;

use perifrac_solvers::SolverSpec;

pub(crate) use crate::scene::Interfaces as InterfaceChoice;
pub use crate::scene::{
    Gradient as GradientChoice, Mode as TimeMode, Operator as OperatorChoice, ReferenceKind,
};
pub use crack::{CrackKind, CrackPlace, CrackPlan, InjectionPlan};
pub use damage::{
    ApertureRule, DamageMethod, DamageModel, DamagePlan, EnergySplit, Exponent, FractureFlowPlan,
    HourglassRule, Normalise, TransmissivityRule,
};
pub use descent::DescentSettings;
pub use field::FieldPlan;
pub(crate) use field::with_contrast;
pub use initial::InitialPlan;
pub use material::{ElasticityPlan, MaterialPlan, PermeabilityPlan, PorousPlan, StoragePlan};
pub use mechanics::{CouplingPlan, MechanicsPlan, Support, TractionPlan};
pub use scheme::{
    Acceleration, AdrDamping, Integrator, SchemeChoice, SchemeOptions, SchemeStart, SolidMethod,
};
pub use well::{WellDrive, WellPlan, Wellbore};

use super::Load;
use super::OwnEffect;
use super::files::{PointSet, PointTable};
use crate::geometry::generate::{Refinement, Segment};
use crate::geometry::{DualCells, Horizon, Influence, Shape};

/// A scene resolved to what will be computed.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Name of the case: the bundled name or the file's.
    pub case: String,
    /// Title from the scene.
    pub title: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Extent across the plane, m: a plane is computed per metre, and reported as a slab this thick. 1 in
    /// space.
    pub thickness: f64,
    /// How the cloud is made.
    pub geometry: GeometryPlan,
    /// How far points see.
    pub horizon: Horizon,
    /// How neighbours are weighed.
    pub influence: Influence,
    /// Materials; later ones replace earlier ones where their regions overlap.
    pub materials: Vec<MaterialPlan>,
    /// The pore fluid.
    pub fluid: FluidPlan,
    /// Flow, if the scene names it.
    pub flow: Option<FlowPlan>,
    /// Stress of the in-situ state, in which the rock is at rest before the run; none without deformation.
    pub initial: Option<InitialPlan>,
    /// Deformation, if the scene names it.
    pub mechanics: Option<MechanicsPlan>,
    /// How flow and deformation feel each other, if there are both.
    pub coupling: Option<CouplingPlan>,
    /// Damage, if the scene names it.
    pub damage: Option<DamagePlan>,
    /// Flow in what is broken, if the scene names it.
    pub fracture_flow: Option<FractureFlowPlan>,
    /// Gravity, if the scene names it.
    pub gravity: Option<GravityPlan>,
    /// Effects that the program hands in; none in the plan of a scene.
    pub own_effects: Vec<OwnEffect>,
    /// Cracks that are there from the start, in the scene's order.
    pub cracks: Vec<CrackPlan>,
    /// Wells, in the scene's order.
    pub wells: Vec<WellPlan>,
    /// The run that this one goes on from, if it does.
    pub start: Option<StartPlan>,
    /// Time.
    pub time: TimePlan,
    /// Time scheme.
    pub scheme: SchemeChoice,
    /// Settings of the schemes that join fields or move the solid.
    pub scheme_options: SchemeOptions,
    /// Linear solver.
    pub solver: SolverSpec,
    /// How well balances must close.
    pub audit: AuditPlan,
    /// What to write.
    pub output: OutputPlan,
    /// Exact solution to compare with, if any.
    pub reference: Option<ReferencePlan>,
    /// Things the user should know before the run.
    pub warnings: Vec<String>,
}

/// How the cloud is made.
#[derive(Debug, Clone)]
pub enum GeometryPlan {
    /// Regular lattice.
    Lattice {
        /// Smallest corner, m.
        origin: Vec<f64>,
        /// Edges, m.
        size: Vec<f64>,
        /// Cells per axis.
        cells: Vec<usize>,
        /// Largest displacement of a point, in cells.
        jitter: f64,
        /// Seed of the displacements.
        seed: u64,
    },
    /// Tensor grading.
    Graded {
        /// Smallest corner, m.
        origin: Vec<f64>,
        /// Segments per axis.
        axes: Vec<Vec<Segment>>,
    },
    /// 2:1 blocks.
    Blocks {
        /// Smallest corner, m.
        origin: Vec<f64>,
        /// Edges, m.
        size: Vec<f64>,
        /// Coarsest spacing, m.
        spacing: f64,
        /// Where to refine.
        refinements: Vec<Refinement>,
    },
    /// Points from a file or from the program.
    Points {
        /// The file, or another name for messages.
        path: String,
        /// The points.
        table: PointTable,
        /// Boundary planes, if given: smallest and largest corner, m.
        bounds: Option<(Vec<f64>, Vec<f64>)>,
        /// Whether volumes that do not fit the points are believed.
        any_volume: bool,
        /// What else is known where the points are the cells of a mesh.
        mesh: Option<Box<MeshPlan>>,
    },
}

/// What a mesh tells of the points that its cells became.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPlan {
    /// Its groups.
    pub sets: Vec<PointSet>,
    /// Cells whose corners are the points.
    pub dual: DualCells,
    /// Corners of each cell of a plane mesh in their order, m; empty in space.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Area of the cells on each side of the bounds, m^(D−1); shape `(2D,)`, low and high side of each axis.
    pub side_area: Vec<f64>,
    /// Balls that touch the free surfaces from outside, one for each face: centre and radius, m.
    pub surface: Vec<(Vec<f64>, f64)>,
}

/// Ratio of the edges of scattered cells from which on their neighbours are not looked for: a ball as long as
/// the cell holds some 300 others in the plane and, by two such edges, 40 000 in space.
const FLAT: f64 = 10.0;

impl GeometryPlan {
    /// Points along each axis, where they form a lattice or a tensor grid that can be made.
    pub fn cells(&self) -> Option<Vec<usize>> {
        let along = |(axis, segments): (usize, &Vec<Segment>)| {
            let cells = segments.iter().map(|segment| segment.cells(axis).ok());
            cells.sum::<Option<usize>>()
        };
        match self {
            Self::Lattice { cells, .. } => Some(cells.clone()),
            Self::Graded { axes, .. } => axes.iter().enumerate().map(along).collect(),
            Self::Blocks { .. } | Self::Points { .. } => None,
        }
    }

    /// Whether the cells of the points can be known: their volumes are in the unit of their places, and where
    /// they are scattered no cell is so flat that it has thousands of others within its length.
    pub fn tells_cells(&self) -> bool {
        match self {
            Self::Points { any_volume, .. } => !any_volume,
            Self::Lattice {
                size,
                cells,
                jitter,
                ..
            } => {
                let edges = || size.iter().zip(cells).map(|(size, &n)| size / n as f64);
                let longest = edges().fold(0.0, f64::max);
                *jitter <= 0.0 || longest < FLAT * edges().fold(f64::INFINITY, f64::min)
            }
            Self::Graded { .. } | Self::Blocks { .. } => true,
        }
    }

    /// Number of points, where it is known before they are made.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Points { table, .. } => Some(table.volume.len()),
            _ => (self.cells()?.into_iter())
                .try_fold(1_usize, |product, cells| product.checked_mul(cells)),
        }
    }
}

/// The pore fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidPlan {
    /// Dynamic viscosity μ_f, Pa s.
    pub viscosity: f64,
    /// Density ρ_f, kg/m³.
    pub density: f64,
}

/// Flow of a single fluid.
#[derive(Debug, Clone)]
pub struct FlowPlan {
    /// Diffusion operator.
    pub operator: OperatorChoice,
    /// Hourglass coefficient c.
    pub hourglass: f64,
    /// Which gradient the operator uses.
    pub gradient: GradientChoice,
    /// Pressure at the start, Pa.
    pub initial_pressure: f64,
    /// Whether the weight of the fluid is added to the initial pressure.
    pub hydrostatic_start: bool,
    /// Height at which the initial pressure is given, m, counted against gravity from the origin; that of the
    /// highest corner of the domain if absent.
    pub datum: Option<f64>,
    /// Whether pressures below zero are meant.
    pub suction: bool,
    /// Condition per side, in the order of the sides' numbers.
    pub sides: Vec<SideCondition>,
    /// Prescribed pressures on regions.
    pub regions: Vec<RegionPressure>,
}

impl FlowPlan {
    /// Whether the gradient is made divergence-consistent on a cloud that is irregular or not and
    /// has planes or not.
    pub fn corrects_gradient(&self, irregular: bool, planes: bool) -> bool {
        self.gradient.corrects(irregular, planes)
    }
}

impl GradientChoice {
    /// Whether the gradient is made divergence-consistent on a cloud that is irregular or not and
    /// has planes or not.
    fn corrects(self, irregular: bool, planes: bool) -> bool {
        match self {
            GradientChoice::Plain => false,
            GradientChoice::DivergenceConsistent => true,
            GradientChoice::Auto => irregular && planes,
        }
    }
}

/// Flow condition on a side.
#[derive(Debug, Clone, PartialEq)]
pub enum SideCondition {
    /// No flux.
    Sealed,
    /// Prescribed pressure, Pa.
    Pressure {
        /// Value, at the highest point of the side where it is hydrostatic.
        value: Load,
        /// Whether it grows downwards with the weight of the fluid.
        hydrostatic: bool,
    },
    /// Prescribed flux into the domain, m/s.
    Flux(Load),
}

/// Prescribed pressure on all points of a region.
#[derive(Debug, Clone)]
pub struct RegionPressure {
    /// Where.
    pub region: Shape,
    /// Pressure, Pa.
    pub pressure: Load,
}

/// Gravity.
#[derive(Debug, Clone, PartialEq)]
pub struct GravityPlan {
    /// Acceleration, m/s².
    pub acceleration: Vec<f64>,
}

/// Time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimePlan {
    /// Transient or steady.
    pub mode: TimeMode,
    /// Start, s: 0, unless a run goes on with the clock of another.
    pub start: f64,
    /// End, s; 0 in steady mode.
    pub end: f64,
    /// How steps are chosen.
    pub step: StepRule,
    /// Accepted error of a step relative to the range of the pressure.
    pub tolerance: f64,
    /// First adaptive step, s.
    pub first_step: Option<f64>,
    /// Largest step, s.
    pub max_step: Option<f64>,
    /// Share of the stability limit that explicit steps use.
    pub safety: f64,
    /// Largest number of steps.
    pub max_steps: usize,
}

/// The state that another run left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StartPlan {
    /// Folder of that run, or a checkpoint.
    pub from: PathBuf,
    /// Whether time goes on from there; it begins at 0 otherwise.
    pub keeps_clock: bool,
    /// Whether the displacement counts from the state taken over.
    pub resets_displacement: bool,
}

/// How steps are chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepRule {
    /// Constant, s.
    Fixed(f64),
    /// From the error estimate (implicit) or the stability limit (explicit).
    Adaptive,
}

/// Limits of the balances after every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AuditPlan {
    /// Fluid lost or made over all that moved.
    pub mass: f64,
    /// Forces out of balance over all forces.
    pub momentum: f64,
    /// Energy that comes from nowhere over all that was supplied or stored.
    pub energy: f64,
    /// Pressure that strain which lags leaves unsettled in an output, over the range of the pressure.
    pub lag: f64,
}

/// What to write.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputPlan {
    /// Times of field output, s, increasing; the end is always one of them.
    pub times: Vec<f64>,
    /// Growth of the cracks after which fields are written too, m; in space its square counts.
    pub crack_increment: Option<f64>,
    /// Whether VTU files are written.
    pub vtu: bool,
    /// Whether one VTKHDF file is written.
    pub vtkhdf: bool,
    /// Whether pictures are drawn.
    pub plots: bool,
    /// Points whose history is kept.
    pub probes: Vec<Probe>,
    /// Lines along which profiles are drawn.
    pub profiles: Vec<Profile>,
}

/// A point whose history is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Name in the scene.
    pub name: String,
    /// Position, m.
    pub at: Vec<f64>,
}

/// A line along which the fields are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Name in the scene.
    pub name: String,
    /// Start, m.
    pub from: Vec<f64>,
    /// End, m.
    pub to: Vec<f64>,
    /// Number of places.
    pub points: usize,
}

impl Profile {
    /// The places, evenly spaced from one end to the other, m.
    pub fn places(&self) -> Vec<Vec<f64>> {
        let intervals = (self.points.max(2) - 1) as f64;
        let ends = || self.from.iter().zip(&self.to);
        let at = |k: usize| {
            let share = k as f64 / intervals;
            ends()
                .map(|(from, to)| from + (to - from) * share)
                .collect()
        };
        (0..self.points).map(at).collect()
    }
}

/// Exact solutions a scene may name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferencePlan {
    /// Which.
    pub kind: ReferenceKind,
    /// Radius around wells left out of the error norms, m; `None` for the solution's own.
    pub exclude: Option<f64>,
}
