//! The rules: what cannot be combined, why, and what to do about it.

use super::feature::{Feature, Feature::*};
use crate::scene::SchemeName::{self, Explicit, Implicit, Monolithic, SemiImplicit, Staggered};

/// One thing that cannot be combined.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// Schemes that it is about; all if empty.
    pub schemes: &'static [SchemeName],
    /// What must all be asked for. The place of the first is underlined in the scene.
    pub with: &'static [Feature],
    /// What must all be absent.
    pub without: &'static [Feature],
    /// Why not. `{scheme}` stands for the name of the scheme.
    pub reason: &'static str,
    /// What to do.
    pub remedy: &'static str,
    /// A place to underline before that of the first feature, if it was typed.
    pub before: Option<Place>,
    /// A second place, and what to say there.
    pub also: Option<(Place, &'static str)>,
}

impl Rule {
    /// Whether the rule asks for something that is absent.
    pub fn is_need(&self) -> bool {
        !self.without.is_empty() && !self.without.contains(&Steady) && !self.with.contains(&Steady)
    }
}

/// A place in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The name of the scheme.
    Scheme,
    /// Where a feature is asked for.
    Of(Feature),
}

/// Schemes that solve no linear system for the displacement.
const RELAXING: &[SchemeName] = &[Explicit, SemiImplicit];
/// Schemes that solve linear systems for all fields.
const SOLVING: &[SchemeName] = &[Implicit, Staggered, Monolithic];

const fn refuse(with: &'static [Feature], reason: &'static str, remedy: &'static str) -> Rule {
    Rule {
        schemes: &[],
        with,
        without: &[],
        reason,
        remedy,
        before: None,
        also: None,
    }
}

/// Every rule: first what an effect needs beside it, then what effects do not go together with, then what
/// schemes cannot do, and at last what several processes cannot.
pub static RULES: &[Rule] = &[
    Rule {
        without: &[Flow, Mechanics],
        ..refuse(
            &[],
            "the scene names no effect, so nothing would happen",
            "add one of [flow], [mechanics]",
        )
    },
    Rule {
        without: &[Flow, Mechanics],
        ..refuse(
            &[Gravity],
            "[gravity] has nothing to act on",
            "add [flow] or [mechanics], or leave [gravity] out",
        )
    },
    Rule {
        without: &[Gravity],
        ..refuse(
            &[HydrostaticStart],
            "`hydrostatic_start` needs [gravity]",
            "add [gravity] with `acceleration`",
        )
    },
    Rule {
        without: &[Gravity],
        ..refuse(
            &[HydrostaticSide],
            "`hydrostatic` needs [gravity]",
            "add [gravity] with `acceleration`",
        )
    },
    Rule {
        without: &[Flow],
        ..refuse(
            &[Wells],
            "[wells] need [flow]",
            "add [flow], or leave [wells] out",
        )
    },
    Rule {
        without: &[Coupling],
        ..refuse(
            &[Mechanics, Flow],
            "flow and mechanics without [coupling] would not feel each other",
            "add [coupling], or run them as two scenes",
        )
    },
    Rule {
        without: &[Flow],
        ..refuse(
            &[Coupling],
            "[coupling] needs [flow]",
            "add [flow], or leave [coupling] out",
        )
    },
    Rule {
        without: &[Mechanics],
        ..refuse(
            &[Coupling],
            "[coupling] needs [mechanics]",
            "add [mechanics], or leave [coupling] out",
        )
    },
    Rule {
        without: &[Mechanics],
        ..refuse(
            &[Damage],
            "[damage] needs [mechanics]",
            "add [mechanics], or leave [damage] out",
        )
    },
    Rule {
        without: &[Damage],
        ..refuse(
            &[FractureFlow],
            "[fracture_flow] needs [damage]",
            "add [damage], or leave [fracture_flow] out",
        )
    },
    Rule {
        without: &[Flow],
        ..refuse(
            &[FractureFlow],
            "[fracture_flow] needs [flow]",
            "add [flow], or leave [fracture_flow] out",
        )
    },
    Rule {
        without: &[Coupling],
        ..refuse(
            &[FractureFlow],
            "[fracture_flow] needs [coupling]",
            "add [coupling], or leave [fracture_flow] out",
        )
    },
    Rule {
        without: &[FractureFlow, DamagedCrack, CutCrack, Steady],
        ..refuse(
            &[Damage, Flow],
            "[damage] and [flow] need [fracture_flow]",
            "add [fracture_flow], or leave [flow] or [damage] out",
        )
    },
    Rule {
        without: &[Mechanics],
        ..refuse(
            &[CutCrack],
            "[cracks] need [mechanics]",
            "add [mechanics], or leave [cracks] out",
        )
    },
    Rule {
        without: &[Damage],
        ..refuse(
            &[DamagedCrack],
            "a damaged crack needs [damage]",
            "add [damage], or set kind = \"cut\"",
        )
    },
    Rule {
        without: &[FractureFlow],
        ..refuse(
            &[DamagedCrack, Flow],
            "a damaged crack and [flow] need [fracture_flow]",
            "add [fracture_flow], or leave [flow] out",
        )
    },
    Rule {
        without: &[Flow],
        ..refuse(
            &[Injection],
            "an `injection` needs [flow]",
            "add [flow], or give the crack's `pressure` instead",
        )
    },
    refuse(
        &[PathOperator, MixedRock, FractureFlow],
        "the path operator does not know what rock conducts that is partly a crack",
        "set flow.operator = \"bond\", or leave it out",
    ),
    refuse(
        &[PermeabilityTensor, MixedRock, FractureFlow],
        "rock that is partly a crack does not know permeability tensors",
        "give one value for the permeability, or set damage.model = \"split\"",
    ),
    refuse(
        &[CutCrack, Flow],
        "a cut crack and [flow] do not go together",
        "set kind = \"damaged\", with [damage] and [fracture_flow]",
    ),
    Rule {
        without: &[InitialField],
        ..refuse(
            &[InitialStress, Gravity],
            "a uniform initial stress does not balance the weight of the rock",
            "give initial.k0 or initial.stress_gradient, or leave the stress or [gravity] out",
        )
    },
    Rule {
        without: &[InitialField],
        ..refuse(
            &[InitialStress, BodyForce],
            "a uniform initial stress does not balance `body_force`",
            "give initial.stress_gradient, or leave the stress or `body_force` out",
        )
    },
    refuse(
        &[Layers, Damage],
        "rock that breaks has the moduli of its points, not those of layers",
        "set interfaces = \"pointwise\", or leave it out",
    ),
    refuse(
        &[ConsistentGradient, CutCrack],
        "the divergence-consistent gradient does not go together with cracks that are cut",
        "set gradient = \"plain\", or kind = \"damaged\" for the cracks",
    ),
    Rule {
        also: Some((Place::Of(Damage), "the damage")),
        ..refuse(
            &[Dynamic, Damage],
            "damage needs quasi-static mechanics",
            "set mechanics.mode = \"quasi-static\", or leave [damage] out",
        )
    },
    Rule {
        also: Some((Place::Of(Damage), "the damage")),
        ..refuse(
            &[Plate, Damage],
            "a rigid `plate` and [damage] do not go together",
            "give the side a `traction`, or without [fracture_flow] a `normal_displacement`",
        )
    },
    Rule {
        also: Some((Place::Of(FractureFlow), "the flow in fractures")),
        ..refuse(
            &[MovingSide, FractureFlow],
            "sides do not move where fluid flows in fractures",
            "hold the side by `roller` or `clamped`, or give it a `traction`",
        )
    },
    Rule {
        also: Some((Place::Of(FractureFlow), "the flow in fractures")),
        ..refuse(
            &[Gravity, FractureFlow],
            "gravity does not act on flow in fractures yet",
            "leave [gravity] or [fracture_flow] out",
        )
    },
    Rule {
        also: Some((Place::Of(FractureFlow), "the flow in fractures")),
        ..refuse(
            &[Stabilisation, FractureFlow],
            "flow in fractures has no `stabilisation`",
            "set coupling.stabilisation = 0",
        )
    },
    Rule {
        also: Some((Place::Of(FractureFlow), "the flow in fractures")),
        ..refuse(
            &[TrBdf2, FractureFlow],
            "flow in fractures needs backward-euler: its coefficients change within a step",
            "set time.integrator = \"backward-euler\", or leave it out",
        )
    },
    refuse(
        &[KnownWells, Damage],
        "no index of a well is known where rock breaks",
        "leave out wellbore_radius and hold the well at a `rate`, or leave out [damage]",
    ),
    Rule {
        also: Some((Place::Of(Steady), "steady here")),
        ..refuse(
            &[FractureFlow, Steady],
            "a steady run has no flow in fractures",
            "give the run an `end`, or leave [fracture_flow] out",
        )
    },
    Rule {
        without: &[FractureFlow],
        also: Some((Place::Of(Steady), "steady here")),
        ..refuse(
            &[Damage, Flow, Steady],
            "a steady run with [flow] has no [damage]",
            "give the run an `end`, or leave [flow] or [damage] out",
        )
    },
    Rule {
        also: Some((Place::Of(Steady), "steady here")),
        ..refuse(
            &[Dynamic, Steady],
            "a steady run cannot be dynamic",
            "use mode = \"quasi-static\", or a transient run",
        )
    },
    Rule {
        schemes: RELAXING,
        before: Some(Place::Scheme),
        also: Some((Place::Of(Steady), "steady here")),
        ..refuse(
            &[Steady],
            "a steady run has no {scheme} scheme",
            "use name = \"implicit\", or a transient run to a late `end`",
        )
    },
    Rule {
        schemes: SOLVING,
        without: &[Steady],
        before: Some(Place::Scheme),
        ..refuse(
            &[Dynamic],
            "`{scheme}` has no inertia",
            "use scheme.name = \"explicit\" or \"semi-implicit\", or mode = \"quasi-static\"",
        )
    },
    Rule {
        schemes: RELAXING,
        without: &[Steady],
        also: Some((Place::Of(Dynamic), "dynamic here")),
        ..refuse(
            &[Plate, Dynamic],
            "a rigid `plate` has no mass",
            "use mode = \"quasi-static\", or a `traction` on the side",
        )
    },
    Rule {
        schemes: &[SemiImplicit],
        without: &[Steady],
        also: Some((Place::Of(Dynamic), "dynamic here")),
        ..refuse(
            &[TrBdf2, Dynamic, Flow],
            "dynamics take the pressure by backward Euler",
            "set time.integrator = \"backward-euler\", or leave it out",
        )
    },
    Rule {
        schemes: &[Explicit],
        also: Some((Place::Scheme, "there is none here")),
        ..refuse(
            &[Stabilisation],
            "`stabilisation` needs a linear system",
            "set stabilisation = 0, or use an implicit scheme",
        )
    },
    Rule {
        schemes: RELAXING,
        also: Some((Place::Scheme, "relaxed here")),
        ..refuse(
            &[FractureFlow, UndrainedStart],
            "fractures have no undrained start with the {scheme} scheme",
            "set coupling.undrained_start = false, or use --scheme monolithic",
        )
    },
    Rule {
        without: &[Damage],
        ..refuse(
            &[Processes, Dynamic],
            "dynamics work in one process",
            "start it without mpirun",
        )
    },
    refuse(
        &[Processes, KnownWells],
        "wells whose bottom-hole pressure is known work in one process",
        "start it without mpirun, or leave out wellbore_radius",
    ),
    refuse(
        &[Processes, Damage],
        "damage works in one process",
        "start it without mpirun",
    ),
    Rule {
        schemes: RELAXING,
        without: &[Dynamic, Damage, Steady],
        before: Some(Place::Scheme),
        ..refuse(
            &[Processes],
            "the {scheme} scheme works in one process",
            "start it without mpirun, or use --scheme implicit, staggered or monolithic",
        )
    },
];
