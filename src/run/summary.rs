//! What a run reports at its end; `--json` prints it and summary.json keeps it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::fracture::Results;
use super::tables::WrittenColumn;
use crate::plan::TimeMode;
use crate::reference::ErrorNorms;
use crate::report::{Balance, Counters, Timers, lenient};
use crate::schemes::StepLimit;

/// A name that this program knows, or one that was read.
pub type Name = Cow<'static, str>;

/// Result of a run. What an older summary did not tell is absent, zero or none.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct Summary {
    /// Name of the case.
    pub case: String,
    /// Version of the program.
    pub version: Name,
    /// Scheme with its integrator.
    pub scheme: String,
    /// Linear solver, if one was used.
    pub solver: Option<String>,
    /// Why this solver.
    pub solver_reason: Option<String>,
    /// Diffusion operator.
    pub operator: Name,
    /// 2 or 3.
    pub dimension: usize,
    /// Processes that worked on it.
    pub processes: usize,
    /// Extent across the plane, m: forces, rates, volumes and energies are those of a slab this thick.
    /// `None` in space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness: Option<f64>,
    /// Unit of every figure that has one, by its place in this summary.
    pub units: BTreeMap<Name, Name>,
    /// Every column of every table that the run has written.
    pub columns: Vec<WrittenColumn>,
    /// Points.
    pub points: usize,
    /// Unknowns of the linear system.
    pub unknowns: usize,
    /// Bonds, images included.
    pub bonds: usize,
    /// Nonzeros of the matrix.
    pub nonzeros: usize,
    /// Points whose families reach a second hop.
    pub second_hops: usize,
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps.
    pub rejected: u64,
    /// The same by reason: `error`, `growth`, `solver`, `coupling`, `balance`.
    pub rejections: BTreeMap<Name, u64>,
    /// Wall time of the run, s.
    #[serde(deserialize_with = "lenient")]
    pub wall_s: f64,
    /// Time reached, s.
    #[serde(deserialize_with = "lenient")]
    pub t_end: f64,
    /// Stability limit of an explicit scheme.
    pub limit: Option<StepLimit>,
    /// Errors per field, where an exact solution is named.
    pub errors: BTreeMap<Name, FieldError>,
    /// The same at every output time, the end included.
    pub errors_over_time: Vec<TimedErrors>,
    /// Rate of outflow per side at the end, m³/s.
    pub outflow: BTreeMap<Name, f64>,
    /// Smallest and largest pressure at the end, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_range: Option<[f64; 2]>,
    /// Largest displacement at the end, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_max: Option<f64>,
    /// Wells whose bottom-hole pressure is known, at the end.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub wells: BTreeMap<String, WellReport>,
    /// How strongly flow and mechanics feel each other, if both are there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling: Option<CouplingReport>,
    /// What broke, with damage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub results: Option<Results>,
    /// Mass balance.
    pub balance: Balance,
    /// What the divergence-consistent gradient achieved, if it was used.
    pub consistency: Option<crate::assembly::Consistency>,
    /// Effort.
    pub counters: Counters,
    /// Wall time per phase, s.
    pub timers: Timers,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Units of the figures of a summary; those of flow in steady states are rates.
pub(super) fn units(dimension: usize, mode: TimeMode) -> BTreeMap<Name, Name> {
    let volume = match mode {
        TimeMode::Transient => "m^3",
        TimeMode::Steady => "m^3/s",
    };
    let mut units = BTreeMap::from([
        ("wall_s", "s"),
        ("t_end", "s"),
        ("thickness", "m"),
        ("limit.dt", "s"),
        ("outflow", "m^3/s"),
        ("pressure_range", "Pa"),
        ("displacement_max", "m"),
        ("wells.NAME.rate", "m^3/s"),
        ("wells.NAME.pressure", "Pa"),
        ("wells.NAME.index", "m^3/(Pa s)"),
        ("wells.NAME.equivalent_radius", "m"),
        ("coupling.consolidation", "m^2/s"),
        ("coupling.step_limit", "s"),
        ("results.peak_force_kN", "kN"),
        ("results.peak_displacement_mm", "mm"),
        ("results.initial_stiffness", "kN/mm"),
        ("results.dissipated_energy", "J"),
        ("results.onset_pressure", "Pa"),
        ("results.peak_injection_pressure", "Pa"),
        ("results.crack_volume", "m^3"),
        ("results.void_volume", "m^3"),
        ("results.leaked_volume", "m^3"),
        ("balance.energy", "J"),
        ("balance.potential", "J"),
        ("balance.kinetic", "J"),
        ("balance.work", "J"),
        ("timers", "s"),
        ("errors.pressure.range", "Pa"),
        ("errors.well_pressure.range", "Pa"),
        ("errors.displacement.range", "m"),
        ("errors.opening.range", "m"),
        ("counters.bytes", "B"),
        ("counters.field_bytes", "B"),
    ]);
    let places = [
        "balance.injected",
        "balance.outflow",
        "balance.fixed",
        "balance.stored",
        "balance.turnover",
    ];
    units.extend(places.map(|place| (place, volume)));
    let length = if dimension == 2 { "m" } else { "m^2" };
    units.insert("results.crack_length", length);
    let named = |(place, unit): (&'static str, &'static str)| (place.into(), unit.into());
    units.into_iter().map(named).collect()
}

/// Errors at one output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimedErrors {
    /// Time, s.
    #[serde(deserialize_with = "lenient")]
    pub time: f64,
    /// Errors per field.
    #[serde(flatten)]
    pub errors: BTreeMap<Name, FieldError>,
}

/// A well whose bottom-hole pressure is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WellReport {
    /// Rate into the rock, for the whole plane as in the scene, m³/s.
    #[serde(deserialize_with = "lenient")]
    pub rate: f64,
    /// Bottom-hole pressure, Pa.
    #[serde(deserialize_with = "lenient")]
    pub pressure: f64,
    /// What it is held at: `given`, `pressure-min`, `pressure-max`, `rate-max`, or `shut`, where it would flow the other way.
    pub control: Name,
    /// How often that has changed.
    pub switches: u32,
    /// Index WI: rate per pascal between the bottom and the mean of the well's points, m³/(Pa s).
    #[serde(deserialize_with = "lenient")]
    pub index: f64,
    /// Radius at which the exact pressure is that mean, m.
    #[serde(deserialize_with = "lenient")]
    pub equivalent_radius: f64,
}

/// Figures of the coupling.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CouplingReport {
    /// Largest α²/(s(λ+2μ)): beyond 1 a split with lagged strain diverges.
    #[serde(deserialize_with = "lenient")]
    pub strength: f64,
    /// Largest consolidation coefficient κ/(s + α²/(λ+2μ)), m²/s.
    #[serde(deserialize_with = "lenient")]
    pub consolidation: f64,
    /// Restriction of the step by Eq. 71 with ½ and the spacing as the length, s. The implicit schemes
    /// need not keep it.
    #[serde(deserialize_with = "lenient")]
    pub step_limit: f64,
    /// Passes between flow and mechanics over the run.
    pub passes: u64,
    /// Largest contraction between the first two passes of a stage; only without acceleration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contraction: Option<f64>,
}

/// Error of a field against the exact solution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FieldError {
    /// Root mean square error relative to the range of the exact field.
    #[serde(deserialize_with = "lenient")]
    pub l2: f64,
    /// Norm of the error over the norm of the exact field (both root mean square).
    #[serde(deserialize_with = "lenient")]
    pub l2_over_norm: f64,
    /// Largest error relative to the range of the exact field.
    #[serde(deserialize_with = "lenient")]
    pub max: f64,
    /// Range of the exact field over the compared points.
    #[serde(deserialize_with = "lenient")]
    pub range: f64,
    /// Points compared.
    pub compared: usize,
    /// Points left out, near wells.
    pub excluded: usize,
}

/// Range of an exact field, relative to the level of the data, below which it is as good as constant.
const CONSTANT: f64 = 1e-9;

impl FieldError {
    /// Error of a field in a problem whose data have the given level, which is the scale where the range of the
    /// exact field vanishes.
    pub fn of(norms: &ErrorNorms, level: f64) -> Self {
        let usual = FieldError::from(*norms);
        match norms.range < CONSTANT * level {
            false => usual,
            true => FieldError {
                l2: norms.l2 / level,
                l2_over_norm: norms.l2 / level,
                max: norms.max / level,
                ..usual
            },
        }
    }
}

impl From<ErrorNorms> for FieldError {
    fn from(norms: ErrorNorms) -> Self {
        FieldError {
            l2: norms.l2_relative,
            l2_over_norm: norms.l2_over_norm,
            max: norms.max_relative,
            range: norms.range,
            compared: norms.compared,
            excluded: norms.excluded,
        }
    }
}
