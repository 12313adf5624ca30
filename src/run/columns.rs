//! Columns of history.csv: what a scene does not name has none.

use crate::geometry::Side;
use crate::model::{Model, MovingWall};
use crate::plan::{MechanicsPlan, Plan, Support};
use crate::report::Balance;
use crate::schemes::State;

use super::finish::{extremes, largest};

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Columns before those of probes.
pub const FIRST: [&str; 3] = ["time_s", "step_s", "iterations"];

/// Heading of the pressure at a probe.
pub fn pressure_at(probe: &str) -> String {
    format!("pressure_{probe}_Pa")
}

/// Heading of a component of the displacement at a probe.
pub fn displacement_at(axis: &str, probe: &str) -> String {
    format!("displacement_{axis}_{probe}_m")
}

/// Headings for a plan of dimension `D`.
pub fn names<const D: usize>(plan: &Plan) -> Vec<String> {
    let mut columns = FIRST.map(str::to_owned).to_vec();
    let probes = || plan.output.probes.iter();
    let volume = format!("m{D}");
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
        columns.extend(["energy_J", "potential_J", "momentum_balance"].map(str::to_owned));
    }
    if plan.flow.is_some() {
        columns.extend(Side::all(D).map(|side| format!("outflow_{side}_{volume}_per_s")));
        columns.extend(["injected", "outflow", "stored"].map(|name| format!("{name}_{volume}")));
        columns.push("mass_balance".to_owned());
    }
    columns
}

fn plates<const D: usize>(mechanics: &MechanicsPlan) -> impl Iterator<Item = Side> + '_ {
    Side::all(D).filter(|side| matches!(mechanics.sides[side.index()], Support::Plate(_)))
}

/// Values under the headings.
pub fn row<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
    state: &State,
    (dt, iterations): (f64, usize),
    balance: &Balance,
) -> Vec<f64> {
    let mut row = vec![state.time, dt, iterations as f64];
    let places = &model.places.probes;
    if let Some(flow) = &model.flow {
        row.extend(extremes(&state.pressure));
        row.extend(
            places
                .iter()
                .map(|at| flow.pressure_at(&state.pressure, state.time, at)),
        );
    }
    if let (Some(solid), Some(mechanics)) = (&model.solid, &plan.mechanics) {
        row.push(largest::<D>(&state.displacement));
        for at in places {
            row.extend(
                solid
                    .displacement_at(&state.displacement, &state.walls, at)
                    .iter(),
            );
        }
        let place = |side: Side| {
            let on = |wall: &MovingWall| wall.side == side && wall.component == side.axis;
            let wall = solid.walls.iter().position(on);
            wall.and_then(|k| state.walls.get(k).copied())
                .unwrap_or(0.0)
        };
        row.extend(plates::<D>(mechanics).map(place));
        let own = [balance.energy, balance.potential, balance.momentum];
        row.extend(own.map(|value| value.unwrap_or(0.0)));
    }
    if let Some(flow) = &model.flow {
        row.extend(flow.outflow(&state.pressure, state.time));
        row.extend([
            balance.injected,
            balance.outflow,
            balance.stored,
            balance.mass,
        ]);
    }
    row
}
