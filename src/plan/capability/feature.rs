//! What a plan may ask for, as far as it decides what can be combined.

use std::collections::BTreeSet;

use crate::material::DamageModel;
use crate::plan::types::{
    CrackKind, DamagePlan, GradientChoice, Integrator, InterfaceChoice, OperatorChoice, Plan,
    SideCondition, TimeMode, WellPlan,
};

/// One thing that a plan may ask for: an effect, an option of one, or the way of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// Flow of a single fluid.
    Flow,
    /// An initial pressure that grows with depth.
    HydrostaticStart,
    /// A pressure on a side that grows with depth.
    HydrostaticSide,
    /// The path operator, asked for by name.
    PathOperator,
    /// A permeability that depends on the direction of flow.
    PermeabilityTensor,
    /// Wells.
    Wells,
    /// Wells whose bottom-hole pressure is known, which may be held at one.
    KnownWells,
    /// Gravity.
    Gravity,
    /// Deformation.
    Mechanics,
    /// Inertia.
    Dynamic,
    /// A rigid plate on a side.
    Plate,
    /// A side of prescribed displacement that is not zero.
    MovingSide,
    /// A load on a part of a side.
    Loads,
    /// A force per volume beside gravity.
    BodyForce,
    /// Stress before the run.
    InitialStress,
    /// Stress before the run that differs from point to point.
    InitialField,
    /// The divergence-consistent gradient of the displacement, asked for by name.
    ConsistentGradient,
    /// Layers in families whose moduli vary, asked for by name.
    Layers,
    /// Flow and deformation feel each other.
    Coupling,
    /// The run starts from the undrained answer to the first loads.
    UndrainedStart,
    /// Storage that only rough pressures feel.
    Stabilisation,
    /// Damage.
    Damage,
    /// Damage as in the paper, where broken rock has properties between those of rock and of a crack.
    MixedRock,
    /// Flow in what is broken.
    FractureFlow,
    /// A crack whose bonds do not exist.
    CutCrack,
    /// A crack whose points are broken.
    DamagedCrack,
    /// A pressure in a crack.
    CrackPressure,
    /// Fluid that is pumped into a crack.
    Injection,
    /// The steady state instead of steps.
    Steady,
    /// Stages of second order.
    TrBdf2,
    /// Several processes.
    Processes,
}

/// What a plan asks for.
pub type Features = BTreeSet<Feature>;

impl Feature {
    /// All of them, in the order of the table.
    pub const ALL: [Feature; 31] = [
        Feature::Flow,
        Feature::HydrostaticStart,
        Feature::HydrostaticSide,
        Feature::PathOperator,
        Feature::PermeabilityTensor,
        Feature::Wells,
        Feature::KnownWells,
        Feature::Gravity,
        Feature::Mechanics,
        Feature::Dynamic,
        Feature::Plate,
        Feature::MovingSide,
        Feature::Loads,
        Feature::BodyForce,
        Feature::InitialStress,
        Feature::InitialField,
        Feature::ConsistentGradient,
        Feature::Layers,
        Feature::Coupling,
        Feature::UndrainedStart,
        Feature::Stabilisation,
        Feature::Damage,
        Feature::MixedRock,
        Feature::FractureFlow,
        Feature::CutCrack,
        Feature::DamagedCrack,
        Feature::CrackPressure,
        Feature::Injection,
        Feature::Steady,
        Feature::TrBdf2,
        Feature::Processes,
    ];

    /// The words that ask for it: in a scene, or around the command.
    pub fn name(self) -> &'static str {
        match self {
            Feature::Flow => "[flow]",
            Feature::HydrostaticStart => "flow.hydrostatic_start = true",
            Feature::HydrostaticSide => "flow.boundary.SIDE.hydrostatic = true",
            Feature::PathOperator => "flow.operator = \"path\"",
            Feature::PermeabilityTensor => "materials.NAME.permeability.k1",
            Feature::Wells => "[wells]",
            Feature::KnownWells => "wells.NAME.wellbore_radius",
            Feature::Gravity => "[gravity]",
            Feature::Mechanics => "[mechanics]",
            Feature::Dynamic => "mechanics.mode = \"dynamic\"",
            Feature::Plate => "mechanics.boundary.SIDE.plate",
            Feature::MovingSide => "mechanics.boundary.SIDE.displacement",
            Feature::Loads => "[mechanics.loads]",
            Feature::BodyForce => "mechanics.body_force",
            Feature::InitialStress => "[initial]",
            Feature::InitialField => "initial.stress_gradient",
            Feature::ConsistentGradient => "mechanics.gradient = \"divergence-consistent\"",
            Feature::Layers => "mechanics.interfaces = \"laminate\"",
            Feature::Coupling => "[coupling]",
            Feature::UndrainedStart => "coupling.undrained_start = true",
            Feature::Stabilisation => "coupling.stabilisation > 0",
            Feature::Damage => "[damage]",
            Feature::MixedRock => "damage.model = \"paper\"",
            Feature::FractureFlow => "[fracture_flow]",
            Feature::CutCrack => "cracks.NAME.kind = \"cut\"",
            Feature::DamagedCrack => "cracks.NAME.kind = \"damaged\"",
            Feature::CrackPressure => "cracks.NAME.pressure",
            Feature::Injection => "cracks.NAME.injection",
            Feature::Steady => "time.mode = \"steady\"",
            Feature::TrBdf2 => "time.integrator = \"tr-bdf2\"",
            Feature::Processes => "mpirun -n 2",
        }
    }

    /// The features of which this one is an option: one of them must be there. Empty if it stands alone.
    pub fn part_of(self) -> &'static [Feature] {
        match self {
            Feature::HydrostaticStart
            | Feature::HydrostaticSide
            | Feature::PathOperator
            | Feature::PermeabilityTensor => &[Feature::Flow],
            Feature::Dynamic
            | Feature::Plate
            | Feature::MovingSide
            | Feature::Loads
            | Feature::BodyForce
            | Feature::InitialStress
            | Feature::ConsistentGradient
            | Feature::Layers => &[Feature::Mechanics],
            Feature::KnownWells => &[Feature::Wells],
            Feature::InitialField => &[Feature::InitialStress],
            Feature::MixedRock => &[Feature::Damage],
            Feature::UndrainedStart | Feature::Stabilisation => &[Feature::Coupling],
            Feature::Injection => &[Feature::DamagedCrack],
            Feature::CrackPressure => &[Feature::CutCrack, Feature::DamagedCrack],
            _ => &[],
        }
    }
}

/// What a plan asks for, run by so many processes.
pub fn features(plan: &Plan, processes: usize) -> Features {
    let integrator = plan.scheme.integrator();
    let asked = [
        (Feature::Gravity, plan.gravity.is_some()),
        (Feature::Wells, !plan.wells.is_empty()),
        (Feature::KnownWells, plan.wells.iter().any(knows)),
        (Feature::Damage, plan.damage.is_some()),
        (Feature::MixedRock, plan.damage.as_ref().is_some_and(mixes)),
        (Feature::FractureFlow, plan.fracture_flow.is_some()),
        (Feature::Steady, plan.time.mode == TimeMode::Steady),
        (Feature::TrBdf2, integrator == Some(Integrator::TrBdf2)),
        (Feature::Processes, processes > 1),
    ];
    let own = asked.into_iter().filter(|(_, asked)| *asked);
    let mut found: Features = own.map(|(feature, _)| feature).collect();
    found.extend(of_flow(plan));
    found.extend(of_mechanics(plan));
    found.extend(of_coupling(plan));
    found.extend(of_cracks(plan));
    found
}

fn mixes(damage: &DamagePlan) -> bool {
    damage.model == DamageModel::Paper
}

fn knows(well: &WellPlan) -> bool {
    well.bore.is_some()
}

fn of_flow(plan: &Plan) -> Vec<Feature> {
    let Some(flow) = &plan.flow else {
        return Vec::new();
    };
    let deep = |side: &SideCondition| matches!(side, SideCondition::Pressure { hydrostatic, .. } if *hydrostatic);
    let asked = [
        (Feature::Flow, true),
        (Feature::HydrostaticStart, flow.hydrostatic_start),
        (Feature::HydrostaticSide, flow.sides.iter().any(deep)),
        (Feature::PathOperator, flow.operator == OperatorChoice::Path),
        (Feature::PermeabilityTensor, plan.has_tensors()),
    ];
    chosen(&asked)
}

fn of_mechanics(plan: &Plan) -> Vec<Feature> {
    let Some(mechanics) = &plan.mechanics else {
        return Vec::new();
    };
    let sides = &mechanics.sides;
    let consistent = mechanics.gradient == GradientChoice::DivergenceConsistent;
    let layers = mechanics.interfaces == InterfaceChoice::Laminate;
    let varies = (plan.initial.as_ref()).is_some_and(|initial| !initial.is_uniform(plan));
    let asked = [
        (Feature::Mechanics, true),
        (Feature::Dynamic, mechanics.inertia),
        (Feature::Plate, sides.iter().any(|side| side.is_plate())),
        (Feature::MovingSide, sides.iter().any(|side| side.moves())),
        (Feature::Loads, !mechanics.loads.is_empty()),
        (Feature::BodyForce, mechanics.body_force.is_some()),
        (Feature::InitialStress, plan.initial.is_some()),
        (Feature::InitialField, varies),
        (Feature::ConsistentGradient, consistent),
        (Feature::Layers, layers),
    ];
    chosen(&asked)
}

fn of_coupling(plan: &Plan) -> Vec<Feature> {
    let Some(coupling) = &plan.coupling else {
        return Vec::new();
    };
    let asked = [
        (Feature::Coupling, true),
        (Feature::UndrainedStart, coupling.undrained_start),
        (Feature::Stabilisation, coupling.stabilisation > 0.0),
    ];
    chosen(&asked)
}

fn of_cracks(plan: &Plan) -> Vec<Feature> {
    let cracks = &plan.cracks;
    let of_kind = |kind| cracks.iter().any(|crack| crack.kind == kind);
    let asked = [
        (Feature::CutCrack, of_kind(CrackKind::Cut)),
        (Feature::DamagedCrack, of_kind(CrackKind::Damaged)),
        (
            Feature::CrackPressure,
            cracks.iter().any(|crack| crack.pressure.is_some()),
        ),
        (
            Feature::Injection,
            cracks.iter().any(|crack| crack.injection.is_some()),
        ),
    ];
    chosen(&asked)
}

fn chosen(asked: &[(Feature, bool)]) -> Vec<Feature> {
    let own = asked.iter().filter(|(_, asked)| *asked);
    own.map(|(feature, _)| *feature).collect()
}
