//! What breaks in a run: figures of every step, and those of the whole run.

use serde::{Deserialize, Serialize};

use crate::effects::vector;
use crate::geometry::{Side, Vector};
use crate::model::{Model, driven_walls};
use crate::plan::{CrackPlace, CrackPlan, DamageModel, MechanicsPlan, Plan};
use crate::report::lenient;
use crate::schemes::{State, StepReport};

use super::columns::AXES;
use super::crack_length::{faces_of_bands, grown, started};
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
    /// Length of cracks from the start and of what broke since, m (area in 3-D, m²): by what damage took over G_c where
    /// strength follows from widths of families, else from the points that broke; within about a tenth.
    pub crack_length: f64,
    /// Energy that damage took, J.
    pub dissipated: f64,
    /// Place of each driven wall, m, and the force that holds it there, N.
    pub walls: Vec<[f64; 2]>,
    /// Cracks that have a pressure, and that pressure, Pa: prescribed, or where fluid is pumped in.
    pub pressure: Vec<(usize, f64)>,
    /// Largest opening that fluid flows through, m; with flow in fractures.
    pub aperture: Option<f64>,
    /// Fluid in cracks, m³ (per metre of thickness as the plan has it); with flow in fractures in the split model.
    pub volume: Option<f64>,
    /// Voids in them, m³; likewise.
    pub voids: Option<f64>,
}

impl Fractures {
    /// Measures a state; `None` without damage.
    pub fn of<const D: usize>(plan: &Plan, model: &Model<D>, state: &State) -> Option<Self> {
        let solid = model.solid.as_ref()?;
        let damage = solid.damage.as_ref()?;
        let now = damage.of(&state.history);
        let fresh = |i: usize| now[i] >= BROKEN && state.history[i] > damage.initial[i];
        let taken = damage.area(&model.cloud.volume, &state.history);
        let grown = taken.unwrap_or_else(|| grown(solid, fresh, |i| now[i] >= BROKEN));
        let length = started(plan, model) + grown * faces_of_bands(model);
        let holds = model.has_crack_content();
        let response = match solid.walls.is_empty() && !holds {
            true => None,
            false => model.response(&state.view()),
        };
        let forces = (response.as_ref()).map_or_else(Vec::new, |own| solid.wall_forces(own));
        let volume = response
            .filter(|_| holds)
            .map(|own| model.crack_volume(&own));
        let pressure = |(number, crack): (usize, &CrackPlan)| {
            let pressure = match &crack.injection {
                Some(_) => model.injection_pressure(number, &state.pressure),
                None => (crack.pressure.as_ref()).map(|pressure| pressure.at(state.time)),
            };
            Some((number, pressure?))
        };
        let largest = |openings: &[f64]| openings.iter().copied().fold(0.0, f64::max);
        Some(Fractures {
            volume: volume.map(|volume| plan.thickness * volume),
            voids: (model.cracks()).map(|cracks| plan.thickness * cracks.void_volume()),
            aperture: model.fracture_flow.as_ref().map(|f| largest(&f.aperture)),
            crack_length: length,
            dissipated: plan.thickness * damage.dissipated(&model.cloud.volume, &state.history),
            walls: state
                .walls
                .iter()
                .zip(forces)
                .map(|(at, force)| [*at, plan.thickness * force])
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
pub(super) fn names<const D: usize>(plan: &Plan, mechanics: &MechanicsPlan) -> Vec<String> {
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
        if plan
            .damage
            .is_some_and(|damage| damage.model == DamageModel::Split)
        {
            names.push("crack_volume_m3".to_owned());
            names.push("crack_void_m3".to_owned());
        }
    }
    names
}

/// Values under the headings.
pub(super) fn row(fractures: &Fractures) -> Vec<f64> {
    let mut row: Vec<f64> = fractures.walls.iter().flatten().copied().collect();
    row.extend(fractures.pressure.iter().map(|(_, pressure)| pressure));
    row.extend([fractures.crack_length, fractures.dissipated]);
    row.extend(fractures.aperture);
    row.extend(fractures.volume);
    row.extend(fractures.voids);
    row
}

/// What a run with damage found.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Largest force on the wall that was driven furthest, kN.
    #[serde(
        rename = "peak_force_kN",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub peak_force: Option<f64>,
    /// Place of that wall then, mm.
    #[serde(
        rename = "peak_displacement_mm",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub peak_displacement: Option<f64>,
    /// Force over displacement of the first step, kN/mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_stiffness: Option<f64>,
    /// Energy that damage took, J.
    #[serde(deserialize_with = "lenient")]
    pub dissipated_energy: f64,
    /// Length of all cracks, m (area in 3-D, m²).
    #[serde(deserialize_with = "lenient")]
    pub crack_length: f64,
    /// Pressure when rock began to break, Pa: that of the crack nearest to where it broke, among the
    /// pumped ones, or without any among those of prescribed pressure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_pressure: Option<f64>,
    /// Name of that crack.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_crack: Option<String>,
    /// Largest pressure where fluid is pumped in, Pa.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_injection_pressure: Option<f64>,
    /// Fluid in cracks at the end, m³.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crack_volume: Option<f64>,
    /// Volume of cracks that fluid has not filled yet, m³.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub void_volume: Option<f64>,
    /// Fluid that was pumped in and is not in cracks, m³: what leaked into the pores and compressed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub leaked_volume: Option<f64>,
    /// Share of what was pumped in that is in cracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid_efficiency: Option<f64>,
    /// Name of the crack that it was pumped into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_injection_crack: Option<String>,
}

/// Follows what breaks.
#[derive(Debug, Clone, Default)]
pub struct CrackTracker {
    /// The figures until now.
    pub results: Results,
    /// Time at which each point broke, s; 0 for those broken from the start, infinite for the others.
    pub broken_at: Vec<f64>,
    /// The last figures.
    pub last: Option<Fractures>,
}

impl CrackTracker {
    /// Takes in the figures of an accepted state.
    pub fn follow<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        time: f64,
        now: Option<Fractures>,
    ) {
        let Some(now) = now else { return };
        let first = self.broken_at.is_empty();
        self.broken_at.resize(now.damage.len(), f64::INFINITY);
        let mut broke = Vec::new();
        for (point, (at, damage)) in self.broken_at.iter_mut().zip(&now.damage).enumerate() {
            if at.is_infinite() && *damage >= BROKEN {
                *at = time;
                broke.push(point);
            }
        }
        self.results.dissipated_energy = now.dissipated;
        self.results.crack_volume = now.volume;
        self.results.void_volume = now.voids;
        self.results.crack_length = now.crack_length;
        if !broke.is_empty() && !first && self.results.onset_pressure.is_none() {
            let places: Vec<Vector<D>> = broke.iter().map(|i| model.cloud.position[*i]).collect();
            self.note_onset(plan, &now, &places);
        }
        self.note_peak(plan, &now);
        self.note_force(&now);
        self.last = Some(now);
    }

    /// Keeps the pressure in the crack that is nearest to the `places` (m) that broke first.
    fn note_onset<const D: usize>(&mut self, plan: &Plan, now: &Fractures, places: &[Vector<D>]) {
        let pumped = |(crack, _): &&(usize, f64)| plan.cracks[*crack].injection.is_some();
        let any = now.pressure.iter().any(|own| pumped(&own));
        let gap = |(crack, _): &&(usize, f64)| {
            let to = |x: &Vector<D>| distance(&plan.cracks[*crack], x);
            places.iter().map(to).fold(f64::INFINITY, f64::min)
        };
        let candidates = now.pressure.iter().filter(|own| !any || pumped(own));
        let nearest = candidates.min_by(|a, b| gap(a).total_cmp(&gap(b)));
        self.results.onset_pressure = nearest.map(|(_, pressure)| *pressure);
        self.results.onset_crack = nearest.map(|(crack, _)| plan.cracks[*crack].name.clone());
    }

    fn note_peak(&mut self, plan: &Plan, now: &Fractures) {
        for (crack, pressure) in &now.pressure {
            let crack = &plan.cracks[*crack];
            let peak = &mut self.results.peak_injection_pressure;
            if crack.injection.is_some() && peak.is_none_or(|peak| *pressure > peak) {
                *peak = Some(*pressure);
                self.results.peak_injection_crack = Some(crack.name.clone());
            }
        }
    }

    fn note_force(&mut self, now: &Fractures) {
        let results = &mut self.results;
        let furthest = now
            .walls
            .iter()
            .max_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
        if let Some([place, force]) = furthest.filter(|wall| wall[0].abs() > 0.0) {
            let (millimetres, force) = (1e3 * place.abs(), 1e-3 * force.abs());
            results.initial_stiffness.get_or_insert(force / millimetres);
            if results.peak_force.is_none_or(|peak| force > peak) {
                results.peak_force = Some(force);
                results.peak_displacement = Some(millimetres);
            }
        }
    }
}

impl Results {
    /// The figures with what has become of the fluid that was pumped in, m³.
    #[must_use]
    pub fn with_injected(mut self, injected: f64) -> Self {
        if let Some(volume) = self.crack_volume.filter(|_| injected > 0.0) {
            self.leaked_volume = Some(injected - volume);
            self.fluid_efficiency = Some(volume / injected);
        }
        self
    }
}

/// Distance from a crack to a place, m.
fn distance<const D: usize>(crack: &CrackPlan, x: &Vector<D>) -> f64 {
    match &crack.place {
        CrackPlace::Chain(points) => {
            let ends = points.windows(2).map(|ends| {
                let [a, b] = [vector::<D>(&ends[0]), vector::<D>(&ends[1])];
                let along = b - a;
                let share = (x - a).dot(&along) / along.norm_squared();
                (x - a - along * share.clamp(0.0, 1.0)).norm()
            });
            ends.fold(f64::INFINITY, f64::min)
        }
        CrackPlace::Disc {
            centre,
            normal,
            radius,
        } => {
            let (arm, normal) = (x - vector(centre), vector::<D>(normal));
            let across = arm.dot(&normal);
            let beyond = ((arm - normal * across).norm() - radius).max(0.0);
            across.hypot(beyond)
        }
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
        let tolerance = self.plan.time.tolerance;
        let error = report
            .error
            .map(|error| scale.relative(&self.model, error, &trial.pressure));
        let Some((damage, growth)) = self.plan.damage.as_ref().zip(report.growth) else {
            let growth = None;
            return Verdict { error, growth };
        };
        let share = growth / damage.largest_increment;
        // A crack that runs does so in steps of any length.
        let most = match share > 1.0 && dt <= damage.shortest_step {
            true => tolerance,
            false => f64::INFINITY,
        };
        let capped = |value: f64| if value > most { most } else { value };
        Verdict {
            error: error.map(capped),
            growth: Some(capped(share * tolerance)),
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
