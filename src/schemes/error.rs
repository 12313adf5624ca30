//! How a step can fail.

use perifrac_solvers::{SolveError, SpecError};

use crate::assembly::PatternError;
use crate::plan::capability::Refusal;

/// Why a step was rejected: the measure that it did not meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rejection {
    /// The error estimate of the step, or values that left all bounds.
    Error,
    /// Growth of damage within the step.
    Growth,
    /// The linear solver or the relaxation that stands in for it.
    Solver,
    /// Passes between the fields, or between damage and displacement.
    Coupling,
    /// Balance of mass, momentum or energy.
    Balance,
}

impl Rejection {
    /// All reasons, in the order of reports.
    pub const ALL: [Rejection; 5] = [
        Rejection::Error,
        Rejection::Growth,
        Rejection::Solver,
        Rejection::Coupling,
        Rejection::Balance,
    ];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Rejection::Error => "error",
            Rejection::Growth => "growth",
            Rejection::Solver => "solver",
            Rejection::Coupling => "coupling",
            Rejection::Balance => "balance",
        }
    }
}

/// What every step conserves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conserved {
    /// Mass of the fluid.
    Mass,
    /// Momentum: forces balance, inertia included.
    Momentum,
    /// Energy: none comes from nowhere.
    Energy,
}

impl Conserved {
    /// What a loss is measured against.
    fn whole(self) -> &'static str {
        match self {
            Conserved::Mass => "the fluid that moved is lost or made",
            Conserved::Momentum => "all forces are out of balance",
            Conserved::Energy => "the energy supplied or stored comes from nowhere",
        }
    }

    /// What to do about it.
    fn remedy(self) -> &'static str {
        match self {
            Conserved::Mass => {
                "take smaller steps (time.step, time.max_step), lower scheme.coupling_tolerance, or use \
                 --scheme monolithic, which balances to rounding"
            }
            Conserved::Momentum => {
                "lower scheme.adr_tolerance or damage.tolerance, or use an implicit scheme"
            }
            Conserved::Energy => "take smaller steps, or use an implicit scheme",
        }
    }
}

impl std::fmt::Display for Conserved {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Conserved::Mass => "mass",
            Conserved::Momentum => "momentum",
            Conserved::Energy => "energy",
        })
    }
}

/// A step that cannot be accepted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The linear solver gave up.
    #[error("linear solver: {0}")]
    Solve(#[from] SolveError),
    /// The solver could not be built.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The coupled matrix is too large.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A value is no longer a number.
    #[error("the {field} at point {point} is not finite at t = {time} s")]
    NotFinite {
        /// The field.
        field: &'static str,
        /// The point.
        point: usize,
        /// Time, s.
        time: f64,
    },
    /// The scheme needs a part that the scene does not have.
    #[error(
        "the scheme needs {part}, which the scene does not name; add it or choose another scheme"
    )]
    MissingPart {
        /// The section.
        part: &'static str,
    },
    /// What the plan asks for cannot be combined.
    #[error(transparent)]
    Refused(Refusal),
    /// Newton's method left forces out of balance.
    #[error(
        "no mechanical equilibrium at t = {time:.6e} s: forces are out of balance by {residual:.1e} of \
         the loads after {iterations} iterations; reduce the contrast of the stiffness, or Poisson's \
         ratio if it is close to 0.5"
    )]
    NoEquilibrium {
        /// Time, s.
        time: f64,
        /// Forces out of balance over all forces.
        residual: f64,
        /// Iterations done.
        iterations: usize,
    },
    /// No equilibrium with damage was found.
    #[error(
        "no equilibrium with damage at t = {time:.6e} s: forces are out of balance by {residual:.1e} of \
         all forces after {iterations} passes of the step, wanted {tolerance:.1e}; raise \
         damage.iterations or damage.tolerance, or take smaller steps"
    )]
    DamageNotConverged {
        /// Time, s.
        time: f64,
        /// Smallest forces out of balance over all forces.
        residual: f64,
        /// The one wanted.
        tolerance: f64,
        /// Iterations done.
        iterations: usize,
    },
    /// Forces balance, but what pores and cracks took up is not what pressure and strain say.
    #[error(
        "pressure and strain do not agree in the fractures at t = {time:.6e} s: {splitting_residual:.1e} of the fluid taken \
         up is not where they say after {iterations} passes of the step, allowed {allowed:.1e}; take smaller steps, or use \
         --scheme monolithic if another one is in use"
    )]
    SplittingNotConverged {
        /// Time, s.
        time: f64,
        /// Smallest share that strain owed while forces balanced.
        splitting_residual: f64,
        /// The one allowed.
        allowed: f64,
        /// Passes done.
        iterations: usize,
    },
    /// Damage grows too much in a step that may be cut.
    #[error(
        "damage grows by more than {most} within the step to t = {time:.6e} s, and the step cannot be cut \
         further; raise damage.shortest_step, in which rock may break as it does"
    )]
    DamageGrowth {
        /// Time, s.
        time: f64,
        /// Growth that is allowed.
        most: f64,
    },
    /// More fluid leaves a crack than it holds.
    #[error(
        "more fluid leaves the crack at {at:.4?} m than it holds: {owed:.1e} of what moves in the step to t = {time:.6e} s; \
         pump less out of it, or end the run before"
    )]
    FluidExhausted {
        /// Time, s.
        time: f64,
        /// Place of the point that lacks most, m.
        at: Vec<f64>,
        /// Fluid that is drawn there over what moves in the step.
        owed: f64,
    },
    /// A crack is without fluid where the scheme knows no voids.
    #[error(
        "a crack is without fluid at {at:.4?} m in the step to t = {time:.6e} s, and this scheme holds no voids; --scheme \
         monolithic and staggered do; set flow.suction = true where pressures count from another zero"
    )]
    UnsupportedVoid {
        /// Time, s.
        time: f64,
        /// Place, m.
        at: Vec<f64>,
    },
    /// Fluid in a crack would boil where the scheme knows no voids.
    #[error(
        "the pressure in a crack falls to {pressure:.3e} Pa in the step to t = {time:.6e} s, below \
         fluid.cavitation_pressure = {limit:.3e} Pa: fluid boils there and lags behind the tip; --scheme monolithic and \
         staggered follow it; set flow.suction = true where pressures count from another zero"
    )]
    Cavitation {
        /// Time, s.
        time: f64,
        /// Lowest pressure in cracks, Pa.
        pressure: f64,
        /// Pressure at which the fluid boils, Pa.
        limit: f64,
    },
    /// Relaxation ran out of iterations.
    #[error(
        "dynamic relaxation did not settle at t = {time:.6e} s: residual {residual:.1e} after \
         {iterations} iterations, wanted {tolerance:.1e}; raise scheme.adr_iterations or \
         scheme.adr_tolerance, or use --scheme staggered"
    )]
    RelaxationNotConverged {
        /// Time, s.
        time: f64,
        /// Iterations done.
        iterations: usize,
        /// Residual of Eq. 70.
        residual: f64,
        /// The one wanted.
        tolerance: f64,
    },
    /// A rigid plate that nothing resists.
    #[error(
        "a rigid plate meets no resistance: nothing holds the body against it; clamp the opposite side \
         or put a roller there"
    )]
    UnsupportedPlate,
    /// Flow and mechanics do not come to agree.
    #[error(
        "the coupling iteration did not converge at t = {time:.6e} s: disagreement {residual:.1e} after \
         {passes} passes; coupling strength α²/(s(λ+2μ)) = {strength:.3} with scheme.relaxation = \
         {relaxation}{}", remedy(*.relaxation)
    )]
    CouplingDiverged {
        /// Time, s.
        time: f64,
        /// Passes done.
        passes: usize,
        /// Disagreement over the scale of the mass balance.
        residual: f64,
        /// Factor of the fixed-stress term.
        relaxation: f64,
        /// α²/(s(λ+2μ)).
        strength: f64,
    },
    /// Lagged strain amplifies itself.
    #[error(
        "coupling unstable at t = {time:.6e} s: lagged strain feeds on itself, the pressure change grew \
         {growth:.1e} times; coupling strength α²/(s(λ+2μ)) = {strength:.3} (lagged strain alone is \
         stable below 1) with scheme.relaxation = {relaxation}{}", remedy(*.relaxation)
    )]
    CouplingUnstable {
        /// Time, s.
        time: f64,
        /// Growth of the pressure change.
        growth: f64,
        /// Factor of the fixed-stress term.
        relaxation: f64,
        /// α²/(s(λ+2μ)).
        strength: f64,
    },
    /// Strain that lags behind the pressure of a fracture would amplify itself.
    #[error(
        "coupling unstable at t = {time:.6e} s: fractures yield {strength:.1e} times as much to their \
         fluid as it gives way itself, and strain that lags behind feeds on itself with \
         scheme.relaxation = {relaxation}; set scheme.relaxation = 1, or use --scheme monolithic"
    )]
    FractureUnstable {
        /// Time, s.
        time: f64,
        /// Factor of the term that stands in for the strain.
        relaxation: f64,
        /// Compliance of the fractures over the storage in them.
        strength: f64,
    },
    /// Explicit steps amplify errors.
    #[error(
        "explicit step unstable at t = {time:.6e} s: the imbalance grew {growth:.1e} times; Δt = \
         {dt:.6e} s is above the stability limit of {limit:.6e} s; use a smaller time.step, leave it \
         out, or use --scheme implicit"
    )]
    Unstable {
        /// Time, s.
        time: f64,
        /// Growth of the imbalance over its largest legitimate value.
        growth: f64,
        /// The step, s.
        dt: f64,
        /// The limit, s.
        limit: f64,
    },
    /// A balance misses its limit.
    #[error(
        "{quantity} is not conserved in the step to t = {time:.6e} s: {found:.1e} of {}, more than \
         audit.{quantity} = {limit:.1e} allows; {}", quantity.whole(), quantity.remedy()
    )]
    Unbalanced {
        /// Time, s.
        time: f64,
        /// What is out of balance.
        quantity: Conserved,
        /// How far, relative to its scale.
        found: f64,
        /// What is allowed.
        limit: f64,
    },
    /// Strain that lags has left swings of the pressure that did not wear off.
    #[error(
        "strain that lags behind the pressure leaves {found:.1e} of the range of the pressure unsettled at \
         t = {time:.6e} s, more than audit.lag = {limit:.1e} allows: pressures that no strain answers swing until \
         the storage of the rock has worn them down; take many more steps (time.safety, time.step), or use \
         --scheme semi-implicit"
    )]
    LaggedStrainOscillation {
        /// Time, s.
        time: f64,
        /// Root mean square over the range.
        found: f64,
        /// What is allowed.
        limit: f64,
    },
    /// Steps have become too small to get anywhere.
    #[error(
        "the step fell to {dt:.3e} s at t = {time:.6e} s without meeting the tolerance; raise \
         time.tolerance, or look for values that are out of range"
    )]
    TooSmall {
        /// Time, s.
        time: f64,
        /// The step, s.
        dt: f64,
    },
    /// A well finds no control that suits.
    #[error(
        "well \"{name}\" goes to and fro between its rate and its limit at t = {time:.6e} s: held at either the other \
         one suits; take smaller steps (time.step, time.max_step), use time.integrator = \"backward-euler\", or change \
         the limit"
    )]
    OscillatingWell {
        /// Name.
        name: String,
        /// Time, s.
        time: f64,
    },
    /// No steady state exists.
    #[error(
        "no steady state: the part of the domain around point {point} is sealed, and {net:.3e} m³/s \
         net (per metre in 2-D) are brought into it; prescribe a pressure somewhere or balance the wells"
    )]
    NoSteadyState {
        /// A point of the part.
        point: usize,
        /// Net rate brought in.
        net: f64,
    },
}

fn remedy(relaxation: f64) -> &'static str {
    match relaxation < 1.0 {
        true => "; set scheme.relaxation = 1, or use --scheme monolithic",
        false => "; use a smaller step, or --scheme monolithic",
    }
}

impl StepError {
    /// Whether the user stopped the step, which says nothing of the scheme.
    pub fn is_interruption(&self) -> bool {
        matches!(self, StepError::Solve(SolveError::Interrupted))
    }

    /// What the step did not meet.
    pub fn reason(&self) -> Rejection {
        match self {
            StepError::Solve(_)
            | StepError::Spec(_)
            | StepError::Pattern(_)
            | StepError::RelaxationNotConverged { .. } => Rejection::Solver,
            StepError::DamageGrowth { .. } => Rejection::Growth,
            StepError::DamageNotConverged { .. }
            | StepError::SplittingNotConverged { .. }
            | StepError::Cavitation { .. }
            | StepError::UnsupportedVoid { .. }
            | StepError::FluidExhausted { .. }
            | StepError::CouplingDiverged { .. }
            | StepError::CouplingUnstable { .. }
            | StepError::FractureUnstable { .. } => Rejection::Coupling,
            StepError::NoEquilibrium { .. }
            | StepError::Unbalanced { .. }
            | StepError::LaggedStrainOscillation { .. }
            | StepError::UnsupportedPlate
            | StepError::OscillatingWell { .. }
            | StepError::NoSteadyState { .. } => Rejection::Balance,
            StepError::NotFinite { .. }
            | StepError::Unstable { .. }
            | StepError::TooSmall { .. }
            | StepError::MissingPart { .. }
            | StepError::Refused(_) => Rejection::Error,
        }
    }

    /// Whether a smaller step cannot help.
    pub fn is_final(&self) -> bool {
        // Strain that lags without its full counterweight amplifies itself in steps of any length.
        if let StepError::CouplingDiverged { relaxation, .. } = self {
            return *relaxation < 1.0;
        }
        matches!(
            self,
            StepError::Unstable { .. }
                | StepError::CouplingUnstable { .. }
                | StepError::FractureUnstable { .. }
                | StepError::MissingPart { .. }
                | StepError::Refused(_)
                | StepError::UnsupportedPlate
                | StepError::FluidExhausted { .. }
                | StepError::UnsupportedVoid { .. }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_solve_and_passes_that_do_not_meet_are_told_apart() {
        let singular = StepError::Solve(SolveError::Singular { row: 3 });
        let apart = StepError::DamageNotConverged {
            time: 1.0,
            residual: 0.1,
            tolerance: 1e-4,
            iterations: 9,
        };
        let runs = StepError::DamageGrowth {
            time: 1.0,
            most: 0.1,
        };
        let reasons = [&singular, &apart, &runs].map(|error| error.reason().name());
        assert_eq!(reasons, ["solver", "coupling", "growth"]);
    }
}
