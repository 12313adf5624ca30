//! How large the pressures and stresses are that balance each other: what rounding is relative to.

use super::FlowModel;
use crate::plan::{MechanicsPlan, Plan, Support};

/// Largest pressure or stress that the data of the problem name, Pa.
pub(super) fn level<const D: usize>(plan: &Plan, flow: Option<&FlowModel<D>>) -> f64 {
    let start = flow.iter().flat_map(|flow| flow.initial.iter().copied());
    let prescribed = flow.into_iter().flat_map(|flow| {
        let walls = flow.walls.iter().map(|wall| &wall.pressure);
        walls
            .chain(&flow.fixed_loads)
            .flat_map(|load| load.values())
    });
    let stresses = plan.mechanics.iter().flat_map(stresses);
    let wells = flow.into_iter().flat_map(|flow| flow.wells.pressures());
    let all = start
        .chain(prescribed.copied())
        .chain(wells)
        .chain(stresses);
    all.fold(0.0, |most, value| value.abs().max(most))
}

/// Stresses that act on the rock or in it, Pa.
fn stresses(mechanics: &MechanicsPlan) -> impl Iterator<Item = f64> + '_ {
    let sides = mechanics.sides.iter().flat_map(|side| match side {
        Support::Traction(loads) => &loads[..],
        _ => &[],
    });
    let loads = sides.chain(mechanics.loads.iter().flat_map(|load| &load.traction));
    loads.flat_map(|load| load.values().iter().copied())
}
