//! Constants of the walk to equilibrium of rock that breaks.

use serde::{Deserialize, Serialize};

/// Constants of the walk to equilibrium of rock that breaks, alone or with fluid in its fractures.
///
/// They change how many passes a step takes, not where it ends: that is bounded by the tolerance of `[damage]` for the
/// forces, and by the last four for the fluid.
/// What each of them buys is measured by `cargo bench --bench descent`, and the table is in `benches/descent.md`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DescentSettings {
    /// Share of the largest force of accepted states that still counts as a scale of forces.
    pub remembered_scale: f64,
    /// Forces out of balance, relative to all forces, from which passes are taken to contract: Newton's tangent is
    /// tried, passes are accelerated, and fluid follows what breaks.
    pub near_balance: f64,
    /// Share of a Newton step below which the exact tangent has failed.
    pub least_newton_step: f64,
    /// Passes without the exact tangent after it failed.
    pub newton_rest: usize,
    /// Change of a tangent, relative to the intact moduli, below which its rows are kept.
    pub refill_threshold: f64,
    /// Change of the weakest modulus, relative to itself, above which they are not.
    pub weak_refill_threshold: f64,
    /// Residual of linear systems of the displacement alone, relative to the forces out of balance.
    pub solid_forcing: f64,
    /// The same of displacement and pressure at first, and the smallest. A crack that is full answers to a wrong
    /// volume with a pressure that is wrong by the ratio of its compliance to that of the fluid.
    pub coupled_forcing: f64,
    /// See `coupled_forcing`.
    pub least_forcing: f64,
    /// Iterations wasted by a preconditioner that lags after which it is renewed.
    pub preconditioner_renewal: usize,
    /// Part of the decrease of the potential that its slope promises and that must be kept.
    pub sufficient_decrease: f64,
    /// Most cuts of a step along a direction.
    pub most_cuts: usize,
    /// Slope left over, relative to that at the start, from which a longer step is tried.
    pub curvature_condition: f64,
    /// Longest step: near the load at which rock begins to run the potential is nearly straight.
    pub longest_step: f64,
    /// Change of the potential, relative to energy and work, that is rounding.
    pub rounding: f64,
    /// How far along a direction that leads nowhere points that close are looked for, in units of it.
    pub closing_probe: f64,
    /// Share of the imbalance before a pass that may be left by it before linear systems are solved more sharply.
    pub slow_contraction: f64,
    /// Growth of the imbalance in a pass from which what earlier passes taught is forgotten.
    pub divergence: f64,
    /// Passes without progress after which they are shortened by a half, where the pressure answers to the strain.
    pub stagnant_passes: usize,
    /// Passes without progress after which a step is given up.
    pub most_stagnant_passes: usize,
    /// Shortest share of a pass.
    pub least_relaxation: f64,
    /// Damage, summed over points, that counts as progress of a crack that runs.
    pub damage_progress: f64,
    /// Growth of damage over the one that is allowed from which a step is given up at once.
    pub growth_cutoff: f64,
    /// Passes that Anderson's method remembers where coefficients lag.
    pub anderson_depth: usize,
    /// The same where the pressure has modes of its own, which the compliance fits more or less.
    pub compliant_anderson_depth: usize,
    /// How far a pass may be carried on beyond its end, in passes, and by how much more each time that has gone well.
    pub extrapolation: f64,
    /// See `extrapolation`.
    pub extrapolation_growth: f64,
    /// Share of the tolerance at which forces are as balanced as they get, so that the pressure alone moves on.
    pub force_floor: f64,
    /// Share of what a pass with the exact tangent of both fields found out of balance that it may leave.
    pub sufficient_reduction: f64,
    /// Growth of all forces in such a pass from which it has gone too far.
    pub force_growth: f64,
    /// Compliance of fractures over the storage in them below which the pressure is brought to the strain in every pass.
    pub compliance_threshold: f64,
    /// Rounds in which more points may begin to boil in a pass of pressures alone.
    pub cavitation_rounds: usize,
    /// Times that a start is brought to where its fluid is.
    pub start_rounds: usize,
    /// Fluid out of balance, relative to what moves in the step, that counts as none where displacement and pressure are
    /// solved together.
    pub mass_tolerance: f64,
    /// Fluid that rounding may lose in a step, relative to all that points hold: where nothing moves passes cannot do
    /// better.
    pub mass_rounding: f64,
    /// Volume that the pressure still owes the strain where fields take turns, relative to what the pores take up, that
    /// is none.
    pub splitting_tolerance: f64,
    /// The same once passes make no progress any more: the audit allows a thousand times as much.
    pub stagnant_splitting_tolerance: f64,
}

impl Default for DescentSettings {
    fn default() -> Self {
        DescentSettings {
            remembered_scale: 1e-2,
            near_balance: 3e-2,
            least_newton_step: 0.05,
            newton_rest: 4,
            refill_threshold: 1e-3,
            weak_refill_threshold: 0.1,
            solid_forcing: 1e-3,
            coupled_forcing: 1e-5,
            least_forcing: 1e-8,
            preconditioner_renewal: 16,
            sufficient_decrease: 1e-4,
            most_cuts: 12,
            curvature_condition: 0.3,
            longest_step: 64.0,
            rounding: 1e-14,
            closing_probe: 1e-4,
            slow_contraction: 0.7,
            divergence: 2.0,
            stagnant_passes: 8,
            most_stagnant_passes: 100,
            least_relaxation: 0.125,
            damage_progress: 0.5,
            growth_cutoff: 2.5,
            anderson_depth: 4,
            compliant_anderson_depth: 16,
            extrapolation: 8.0,
            extrapolation_growth: 4.0,
            force_floor: 1e-3,
            sufficient_reduction: 0.9,
            force_growth: 100.0,
            compliance_threshold: 0.1,
            cavitation_rounds: 20,
            start_rounds: 4,
            mass_tolerance: 5e-7,
            mass_rounding: 1e-12,
            splitting_tolerance: 1e-7,
            stagnant_splitting_tolerance: 1e-5,
        }
    }
}
