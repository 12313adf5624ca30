//! Which scheme a plan gets, and which linear systems it solves.

use perifrac_solvers::Symmetry;

use crate::plan::types::{Plan, SchemeChoice, SolidMethod, TimeMode};

/// What a scheme becomes with the effects of a plan.
///
/// Without mechanics there is nothing to couple: every implicit scheme is the implicit flow scheme. Without
/// flow every implicit scheme solves for equilibrium, every explicit one relaxes to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// One solve, no time loop.
    Steady,
    /// Explicit steps of the pressure.
    ForwardEuler,
    /// Implicit steps of the pressure.
    ImplicitFlow,
    /// Equilibrium by relaxation, with damage or without.
    Relaxation,
    /// Equilibrium by a linear system.
    Equilibrium,
    /// Equilibrium with damage by linear systems.
    Fracture,
    /// Dynamics; the pressure, if there is one, in explicit steps.
    Verlet,
    /// Dynamics with implicit steps of the pressure.
    VerletWithFlow,
    /// Explicit steps of the pressure, after each of which the solid relaxes.
    RelaxedExplicit,
    /// Implicit steps of the pressure with lagged strain, after each of which the solid relaxes.
    RelaxedImplicit,
    /// A system for each field, in turns.
    Staggered,
    /// One system for both fields.
    Monolithic,
    /// Flow in fractures at the coefficients of the last step; then the solid relaxes.
    LaggedFracture,
    /// Flow and fracture in turns.
    StaggeredFracture,
    /// Flow and fracture in one system.
    MonolithicFracture,
}

/// The method of a plan that is not refused.
pub fn method(plan: &Plan) -> Method {
    let relaxes = matches!(
        plan.scheme,
        SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_)
    );
    let inertia = (plan.mechanics.as_ref()).is_some_and(|mechanics| mechanics.inertia);
    let parts = (plan.flow.is_some(), plan.mechanics.is_some());
    match (plan.scheme, parts) {
        _ if plan.time.mode == TimeMode::Steady => Method::Steady,
        (SchemeChoice::SemiImplicit(_), (true, _)) if inertia => Method::VerletWithFlow,
        _ if inertia => Method::Verlet,
        (SchemeChoice::Explicit, (true, false)) => Method::ForwardEuler,
        (_, (true, false)) => Method::ImplicitFlow,
        (_, (false, _)) if relaxes => Method::Relaxation,
        (_, (false, _)) if plan.damage.is_some() => Method::Fracture,
        (_, (false, _)) => Method::Equilibrium,
        (scheme, (true, true)) if plan.damage.is_some() => match scheme {
            SchemeChoice::Staggered(_) => Method::StaggeredFracture,
            _ if relaxes => Method::LaggedFracture,
            _ => Method::MonolithicFracture,
        },
        (SchemeChoice::Explicit, _) if plan.scheme_options.solid == SolidMethod::Verlet => {
            Method::Verlet
        }
        (SchemeChoice::Explicit, _) => Method::RelaxedExplicit,
        (SchemeChoice::SemiImplicit(_), _) => Method::RelaxedImplicit,
        (SchemeChoice::Staggered(_), _) => Method::Staggered,
        (SchemeChoice::Implicit(_) | SchemeChoice::Monolithic(_), _) => Method::Monolithic,
    }
}

/// Whether the solid moves by steps of its own, one a step of the pressure (Algorithm 1), though inertia does not
/// matter: its mass is then what makes such steps stable.
pub fn scales_mass(plan: &Plan) -> bool {
    let rests = (plan.mechanics.as_ref()).is_some_and(|mechanics| !mechanics.inertia);
    rests && method(plan) == Method::Verlet
}

/// Whether the stiffness of the solid is held as a matrix. Where nothing solves for it or looks at its entries
/// forces come from bonds.
pub fn holds_stiffness(plan: &Plan) -> bool {
    !matches!(
        method(plan),
        Method::Relaxation
            | Method::Verlet
            | Method::VerletWithFlow
            | Method::RelaxedExplicit
            | Method::RelaxedImplicit
            | Method::LaggedFracture
    )
}

/// A linear system and the fields that it is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum System {
    /// Pressure.
    Flow,
    /// Displacement.
    Mechanics,
    /// Both in one.
    Monolithic,
}

impl System {
    /// Name for people.
    pub const fn name(self) -> &'static str {
        match self {
            System::Flow => "flow",
            System::Mechanics => "mechanics",
            System::Monolithic => "monolithic",
        }
    }

    /// Kind of its matrix.
    pub fn symmetry(self) -> Symmetry {
        match self {
            System::Flow | System::Mechanics => Symmetry::PositiveDefinite,
            System::Monolithic => Symmetry::QuasiDefinite,
        }
    }

    /// Unknowns per point.
    pub fn width(self, dimension: usize) -> usize {
        match self {
            System::Flow => 1,
            System::Mechanics => dimension,
            System::Monolithic => dimension + 1,
        }
    }
}

/// The linear systems that the method of a plan solves in its steps.
///
/// Where flow and fracture are one system, that of flow is solved beside it, by a solver that suits.
pub fn systems(plan: &Plan) -> Vec<System> {
    match method(plan) {
        Method::Steady => {
            let parts = [
                plan.flow.as_ref().map(|_| System::Flow),
                plan.mechanics.as_ref().map(|_| System::Mechanics),
            ];
            parts.into_iter().flatten().collect()
        }
        Method::ForwardEuler | Method::Relaxation | Method::Verlet | Method::RelaxedExplicit => {
            Vec::new()
        }
        Method::LaggedFracture if plan.scheme == SchemeChoice::Explicit => Vec::new(),
        Method::ImplicitFlow
        | Method::VerletWithFlow
        | Method::RelaxedImplicit
        | Method::LaggedFracture => vec![System::Flow],
        Method::Equilibrium | Method::Fracture => vec![System::Mechanics],
        Method::Staggered | Method::StaggeredFracture => vec![System::Flow, System::Mechanics],
        Method::Monolithic | Method::MonolithicFracture => vec![System::Monolithic],
    }
}
