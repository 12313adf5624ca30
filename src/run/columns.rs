//! Columns of history.csv: what a scene does not name has none.
//!
//! Every heading ends in the unit. A plane is a slab of `geometry.thickness`; what leaves through a side is
//! the rate at the time of the row, and so is that of a well, what leaves where a pressure is held is the mean over the
//! step.

use crate::geometry::{Place, Side};
use crate::model::{Faces, Model, MovingWall};
use crate::plan::{MechanicsPlan, Plan, Support, TimeMode, exact_opening};
use crate::report::Balance;
use crate::schemes::{Rejection, State, StepReport};

use super::finish::{extremes, in_slab, largest};
use super::fracture::{self, Fractures};
use super::rejections::Rejections;

/// Names of the axes.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// Columns before those of probes.
pub(super) const FIRST: [&str; 3] = ["time_s", "step_s", "iterations"];

/// Heading of the pressure at a probe.
pub(super) fn pressure_at(probe: &str) -> String {
    format!("pressure_{probe}_Pa")
}

/// Heading of a component of the displacement at a probe.
pub(super) fn displacement_at(axis: &str, probe: &str) -> String {
    format!("displacement_{axis}_{probe}_m")
}

/// Heading of the largest opening of a crack.
fn opening_of(crack: &str) -> String {
    format!("opening_{crack}_m")
}

/// Opening and sliding at the places along a crack, m.
pub fn openings<const D: usize>(model: &Model<D>, state: &State, crack: usize) -> Vec<[f64; 2]> {
    let Some(solid) = &model.solid else {
        return Vec::new();
    };
    let (displacement, walls) = (state.shown_displacement(), state.shown_walls());
    let moved = |place: &Place<D>| solid.displacement_at(&displacement, &walls, place);
    let jump = |faces: &Faces<D>| faces.jump([0, 1].map(|side| moved(&faces.sides[side])));
    model.places.cracks[crack].iter().map(jump).collect()
}

/// Exact opening at the places along a crack, if the plan knows it, m.
pub(super) fn exact_openings<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
    state: &State,
    crack: usize,
) -> Option<Vec<f64>> {
    let exact = exact_opening(plan).ok().flatten()?;
    let pressure = plan.cracks[crack].pressure.as_ref()?.at(state.time);
    let places = model.places.cracks[crack].iter();
    Some(
        places
            .map(|faces| exact.opening(faces.on.at.as_slice(), pressure))
            .collect(),
    )
}

/// Headings of a well whose bottom-hole pressure is known.
pub(super) fn of_well(well: &str) -> [String; 2] {
    [
        format!("well_rate_{well}_m3_per_s"),
        format!("well_pressure_{well}_Pa"),
    ]
}

/// Headings for a plan of dimension `D`.
pub(super) fn names<const D: usize>(plan: &Plan) -> Vec<String> {
    let mut columns = FIRST.map(str::to_owned).to_vec();
    let probes = || plan.output.probes.iter();
    if plan.flow.is_some() {
        columns.extend(["pressure_min_Pa", "pressure_max_Pa"].map(str::to_owned));
        columns.extend(probes().map(|probe| pressure_at(&probe.name)));
    }
    if let Some(mechanics) = &plan.mechanics {
        columns.push("displacement_max_m".to_owned());
        for probe in probes() {
            let component = |axis: &&str| displacement_at(axis, &probe.name);
            columns.extend(AXES[..D].iter().map(component));
        }
        columns.extend(plates::<D>(mechanics).map(|side| format!("plate_{side}_m")));
        columns.extend(plan.cracks.iter().map(|crack| opening_of(&crack.name)));
        if plan.damage.is_some() {
            columns.extend(fracture::names::<D>(plan, mechanics));
        }
        columns.extend(["energy_J", "potential_J", "momentum_balance"].map(str::to_owned));
        if mechanics.inertia {
            columns.extend(["kinetic_J", "work_J", "energy_balance"].map(str::to_owned));
        }
    }
    if plan.flow.is_some() {
        columns.extend(Side::all(D).map(|side| format!("outflow_{side}_m3_per_s")));
        columns.extend(held(plan).map(|name| format!("outflow_{name}_m3_per_s")));
        let known = plan.wells.iter().filter(|well| well.bore.is_some());
        columns.extend(known.flat_map(|well| of_well(&well.name)));
        let amount = match plan.time.mode {
            TimeMode::Transient => "m3",
            TimeMode::Steady => "m3_per_s",
        };
        let names = ["injected", "fixed", "outflow", "stored"];
        columns.extend(names.map(|name| format!("{name}_{amount}")));
        columns.push("mass_balance".to_owned());
    }
    columns.extend(Rejection::ALL.map(|reason| format!("rejected_{}", reason.name())));
    columns
}

/// Names of what is held at a pressure, in the order of the flow model's loads: regions by their number
/// in the scene, then cracks.
fn held(plan: &Plan) -> impl Iterator<Item = String> + '_ {
    let regions = plan.flow.iter().flat_map(|flow| 1..=flow.regions.len());
    let cracks = plan.cracks.iter().filter(|crack| crack.pressure.is_some());
    let cracks = cracks.map(|crack| format!("crack_{}", crack.name));
    regions
        .map(|number| format!("region_{number}"))
        .chain(cracks)
}

fn plates<const D: usize>(mechanics: &MechanicsPlan) -> impl Iterator<Item = Side> + '_ {
    Side::all(D).filter(|side| matches!(mechanics.sides[side.index()], Support::Plate(_)))
}

/// Values under the headings.
pub(super) fn row<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
    state: &State,
    (dt, report, rejections): (f64, &StepReport, Rejections),
    balance: &Balance,
    fractures: Option<&Fractures>,
) -> Vec<f64> {
    let mut row = vec![state.time, dt, report.iterations as f64];
    let balance = &in_slab(plan, balance);
    let probes = &model.places.probes;
    if let Some(flow) = &model.flow {
        row.extend(extremes(&state.pressure));
        row.extend(flow.pressures_at(&state.pressure, state.time, probes));
    }
    if let (Some(solid), Some(mechanics)) = (&model.solid, &plan.mechanics) {
        let (displacement, walls) = (state.shown_displacement(), state.shown_walls());
        row.push(largest::<D>(&displacement));
        let moved = solid.displacements_at(&displacement, &walls, probes);
        row.extend(moved.iter().flat_map(|moved| moved.iter()));
        let place = |side: Side| {
            let on = |wall: &MovingWall| wall.side == side && wall.component == side.axis;
            let wall = solid.walls.iter().position(on);
            wall.and_then(|k| walls.get(k).copied()).unwrap_or(0.0)
        };
        row.extend(plates::<D>(mechanics).map(place));
        for crack in 0..plan.cracks.len() {
            let jumps = openings(model, state, crack);
            row.push(jumps.iter().map(|jump| jump[0]).fold(0.0, f64::max));
        }
        row.extend(fractures.map(fracture::row).unwrap_or_default());
        let own = [balance.energy, balance.potential, balance.momentum];
        row.extend(own.map(|value| value.unwrap_or(0.0)));
        if mechanics.inertia {
            let own = [balance.kinetic, balance.work, balance.energy_error];
            row.extend(own.map(|value| value.unwrap_or(0.0)));
        }
    }
    if let Some(flow) = &model.flow {
        let rates = flow.outflow(&state.pressure, state.time).into_iter();
        row.extend(rates.map(|rate| plan.thickness * rate));
        // Volumes of a step; rates of a steady state.
        let span = if dt > 0.0 { dt } else { 1.0 };
        let brought = |load| report.flows.held.get(load).copied().unwrap_or(0.0);
        row.extend((0..held(plan).count()).map(|load| -plan.thickness * brought(load) / span));
        let wells = flow.wells_now(&state.pressure, state.time).into_iter();
        row.extend(wells.flat_map(|now| [plan.thickness * now.rate, now.pressure]));
        row.extend([
            balance.injected,
            balance.fixed,
            balance.outflow,
            balance.stored,
            balance.mass,
        ]);
    }
    row.extend(Rejection::ALL.map(|reason| rejections.of(reason) as f64));
    row
}
