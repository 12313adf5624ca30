//! What a plan says about how steps are taken.

use serde::Serialize;

use crate::scene::SchemeName;
pub use crate::scene::{Acceleration, AdrDamping, Integrator, SchemeStart, SolidMethod};

/// Time scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SchemeChoice {
    /// Forward Euler.
    Explicit,
    /// Implicit, with the given integrator.
    Implicit(Integrator),
    /// Implicit pressure, with the given integrator; the solid moves without a linear system.
    SemiImplicit(Integrator),
    /// Implicit fields in turns until they agree (Eq. 72), with the given integrator.
    Staggered(Integrator),
    /// Implicit, one system for all fields, with the given integrator.
    Monolithic(Integrator),
}

impl SchemeChoice {
    /// Name as on the command line.
    pub fn name(self) -> &'static str {
        self.scheme().name()
    }

    /// The scheme, whatever its integrator.
    pub fn scheme(self) -> SchemeName {
        match self {
            SchemeChoice::Explicit => SchemeName::Explicit,
            SchemeChoice::Implicit(_) => SchemeName::Implicit,
            SchemeChoice::SemiImplicit(_) => SchemeName::SemiImplicit,
            SchemeChoice::Staggered(_) => SchemeName::Staggered,
            SchemeChoice::Monolithic(_) => SchemeName::Monolithic,
        }
    }

    /// Integrator of the linear systems; `None` without any.
    pub fn integrator(self) -> Option<Integrator> {
        match self {
            SchemeChoice::Explicit => None,
            SchemeChoice::Implicit(integrator)
            | SchemeChoice::SemiImplicit(integrator)
            | SchemeChoice::Staggered(integrator)
            | SchemeChoice::Monolithic(integrator) => Some(integrator),
        }
    }
}

/// Settings of the schemes that join fields or move the solid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SchemeOptions {
    /// Factor of the fixed-stress term; 0 is the form of the paper (Eq. 72).
    pub relaxation: f64,
    /// How the iterations between flow and mechanics are sped up.
    pub acceleration: Acceleration,
    /// Relative change at which those iterations end.
    pub coupling_tolerance: f64,
    /// Largest number of those iterations in a step.
    pub coupling_iterations: usize,
    /// Whether the semi-implicit scheme passes once whatever flow and mechanics disagree by.
    pub single_pass: bool,
    /// How the solid moves where it has no linear system.
    pub solid: SolidMethod,
    /// How the explicit scheme finds the equilibrium it starts from.
    pub start: SchemeStart,
    /// Relative imbalance of forces at which dynamic relaxation ends.
    pub adr_tolerance: f64,
    /// Whether it ends as well when little is left of what a step threw out of balance.
    pub adr_follows: bool,
    /// Largest number of iterations of dynamic relaxation in a step.
    pub adr_iterations: usize,
    /// What damps dynamic relaxation.
    pub adr_damping: AdrDamping,
    /// Weight of the newest local damping in dynamic relaxation.
    pub adr_smoothing: f64,
}
