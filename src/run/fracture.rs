//! What breaks in a run: figures of every step, and those of the whole run.

use serde::Serialize;

use crate::geometry::Side;
use crate::model::{Model, driven_walls};
use crate::plan::{CrackPlan, MechanicsPlan, Plan};
use crate::schemes::{State, StepReport};

use super::columns::AXES;
use super::crack_length::{grown, started};
use super::rejections::Verdict;
use super::scale::Scale;
use super::time_loop::Run;

/// Damage from which a point counts as broken.
const BROKEN: f64 = 0.9;

/// What damage has done until a time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fractures {
    /// Damage per point, shape `(n,)`.
    pub damage: Vec<f64>,
    /// Length of cracks from the start and of what broke since, m (area in 3-D, m²); the latter within
    /// about a tenth.
    pub crack_length: f64,
    /// Energy that damage took, J (per metre of thickness in 2-D).
    pub dissipated: f64,
    /// Place of each driven wall, m, and the force that holds it there, N (N/m in 2-D).
    pub walls: Vec<[f64; 2]>,
    /// Pressure in each crack that has one, Pa: prescribed, or where fluid is pumped in.
    pub pressure: Vec<f64>,
    /// Largest opening that fluid flows through, m; with flow in fractures.
    pub aperture: Option<f64>,
}

impl Fractures {
    /// Measures a state; `None` without damage.
    pub fn of<const D: usize>(plan: &Plan, model: &Model<D>, state: &State) -> Option<Self> {
        let solid = model.solid.as_ref()?;
        let damage = solid.damage.as_ref()?;
        let now = damage.of(&state.history);
        let fresh = |i: usize| now[i] >= BROKEN && state.history[i] > damage.initial[i];
        let length = started(plan, model) + grown(solid, fresh, |i| now[i] >= BROKEN);
        let forces = match solid.walls.is_empty() {
            true => Vec::new(),
            false => {
                let answer = solid.answer(&state.displacement, &state.walls, &state.history)?;
                solid.wall_forces(&answer)
            }
        };
        let pressure = |(number, crack): (usize, &CrackPlan)| match &crack.injection {
            Some(_) => model.injection_pressure(number, &state.pressure),
            None => crack
                .pressure
                .as_ref()
                .map(|pressure| pressure.at(state.time)),
        };
        let largest = |openings: &[f64]| openings.iter().copied().fold(0.0, f64::max);
        Some(Fractures {
            aperture: model.fracture_flow.as_ref().map(|f| largest(&f.aperture)),
            crack_length: length,
            dissipated: damage.dissipated(&model.cloud.volume, &state.history),
            walls: state
                .walls
                .iter()
                .zip(forces)
                .map(|(at, force)| [*at, force])
                .collect(),
            pressure: plan
                .cracks
                .iter()
                .enumerate()
                .filter_map(pressure)
                .collect(),
            damage: now,
        })
    }
}

/// Headings of the figures in history.csv.
pub fn names<const D: usize>(plan: &Plan, mechanics: &MechanicsPlan) -> Vec<String> {
    let wall = |(side, axis): (Side, usize)| {
        let name = format!("{side}_{}", AXES[axis]);
        [format!("motion_{name}_m"), format!("force_{name}_N")]
    };
    let mut names: Vec<String> = driven_walls::<D>(mechanics)
        .into_iter()
        .flat_map(wall)
        .collect();
    let pressed = |crack: &&CrackPlan| crack.pressure.is_some() || crack.injection.is_some();
    let cracks = plan.cracks.iter().filter(pressed);
    names.extend(cracks.map(|crack| format!("crack_pressure_{}_Pa", crack.name)));
    names.push(
        if D == 2 {
            "crack_length_m"
        } else {
            "crack_area_m2"
        }
        .to_owned(),
    );
    names.push("dissipated_J".to_owned());
    if plan.fracture_flow.is_some() {
        names.push("aperture_max_m".to_owned());
    }
    names
}

/// Values under the headings.
pub fn row(fractures: &Fractures) -> Vec<f64> {
    let mut row: Vec<f64> = fractures.walls.iter().flatten().copied().collect();
    row.extend(&fractures.pressure);
    row.extend([fractures.crack_length, fractures.dissipated]);
    row.extend(fractures.aperture);
    row
}

/// What a run with damage found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Results {
    /// Largest force on the wall that was driven furthest, kN (per millimetre of thickness in 2-D).
    #[serde(rename = "peak_force_kN", skip_serializing_if = "Option::is_none")]
    pub peak_force: Option<f64>,
    /// Place of that wall then, mm.
    #[serde(
        rename = "peak_displacement_mm",
        skip_serializing_if = "Option::is_none"
    )]
    pub peak_displacement: Option<f64>,
    /// Force over displacement of the first step, kN/mm (per millimetre of thickness in 2-D).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_stiffness: Option<f64>,
    /// Energy that damage took, J (per metre of thickness in 2-D).
    pub dissipated_energy: f64,
    /// Length of all cracks, m (area in 3-D, m²).
    pub crack_length: f64,
    /// Pressure in the first crack that has one when rock began to break, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub onset_pressure: Option<f64>,
    /// Largest pressure where fluid is pumped in, Pa.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_injection_pressure: Option<f64>,
}

/// Follows what breaks.
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    /// The figures until now.
    pub results: Results,
    /// Time at which each point broke, s; 0 for those broken from the start, infinite for the others.
    pub broken_at: Vec<f64>,
    /// The last figures.
    pub last: Option<Fractures>,
    pumped: bool,
}

impl Tracker {
    /// Follows nothing yet.
    pub fn new(plan: &Plan) -> Self {
        Tracker {
            pumped: plan.cracks.iter().any(|crack| crack.injection.is_some()),
            ..Tracker::default()
        }
    }

    /// Takes in the figures of an accepted state.
    pub fn follow(&mut self, dimension: usize, time: f64, now: Option<Fractures>) {
        let Some(now) = now else { return };
        let first = self.broken_at.is_empty();
        self.broken_at.resize(now.damage.len(), f64::INFINITY);
        let mut broke = false;
        for (at, damage) in self.broken_at.iter_mut().zip(&now.damage) {
            if at.is_infinite() && *damage >= BROKEN {
                *at = time;
                broke = true;
            }
        }
        let results = &mut self.results;
        results.dissipated_energy = now.dissipated;
        results.crack_length = now.crack_length;
        if broke && !first && results.onset_pressure.is_none() {
            results.onset_pressure = now.pressure.first().copied();
        }
        if let Some(pressure) = now.pressure.first().filter(|_| self.pumped) {
            let peak = results.peak_injection_pressure.get_or_insert(*pressure);
            *peak = peak.max(*pressure);
        }
        let furthest = now
            .walls
            .iter()
            .max_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
        if let Some([place, force]) = furthest.filter(|wall| wall[0].abs() > 0.0) {
            // A plane is a slice of one metre; its forces are given per millimetre.
            let thickness = if dimension == 2 { 1e-3 } else { 1.0 };
            let (millimetres, force) = (1e3 * place.abs(), 1e-3 * thickness * force.abs());
            results.initial_stiffness.get_or_insert(force / millimetres);
            if results.peak_force.is_none_or(|peak| force > peak) {
                results.peak_force = Some(force);
                results.peak_displacement = Some(millimetres);
            }
        }
        self.last = Some(now);
    }
}

impl<const D: usize> Run<'_, D> {
    /// Error of a step and growth of damage in it: what breaks in the shortest step breaks.
    pub(super) fn judged(
        &self,
        scale: &Scale,
        report: &StepReport,
        trial: &State,
        dt: f64,
    ) -> Verdict {
        let relative = |error| scale.relative(&self.model, error, &trial.pressure);
        let growth = self.plan.damage.as_ref().and_then(|damage| {
            let share = report.growth? / damage.largest_increment;
            let most = if dt <= damage.shortest_step {
                1.0
            } else {
                share
            };
            Some(share.min(most) * self.plan.time.tolerance)
        });
        Verdict {
            error: report.error.map(relative),
            growth,
        }
    }

    /// Whether cracks have grown enough since the last output for another one.
    pub(super) fn has_grown(&mut self) -> bool {
        let length = self.tracker.results.crack_length;
        let grown = self
            .plan
            .output
            .crack_increment
            .is_some_and(|by| length >= self.drawn + by.powi(D as i32 - 1));
        if grown {
            self.drawn = length;
        }
        grown
    }
}
