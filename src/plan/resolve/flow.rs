//! Flow and what drives it.

use crate::plan::types::{FlowPlan, GravityPlan, RegionPressure, SideCondition, WellPlan};
use crate::scene::quantity::values;
use crate::scene::{self, Condition};

pub(super) fn flow_plan(flow: &scene::Flow, scene: &scene::Scene) -> FlowPlan {
    let initial = scene.initial.as_deref();
    let pressure = initial.and_then(|own| own.pressure);
    let mut sides = vec![SideCondition::Sealed; 6];
    for (side, condition) in flow.boundary.iter() {
        sides[side.resolved().index()] = match &condition.value {
            Condition::Sealed(_) => SideCondition::Sealed,
            Condition::Flux(flux) => SideCondition::Flux(flux.flux.resolved()),
            Condition::Pressure(pressure) => SideCondition::Pressure {
                value: pressure.pressure.resolved(),
                hydrostatic: pressure.hydrostatic.value,
            },
        };
    }
    FlowPlan {
        operator: flow.operator.value,
        hourglass: flow.hourglass.value(),
        gradient: flow.gradient.value,
        initial_pressure: pressure.map_or(flow.initial_pressure.value(), |own| own.value()),
        hydrostatic_start: pressure
            .map_or(flow.hydrostatic_start.value, |own| own.is_hydrostatic()),
        datum: pressure.and(initial.and_then(|own| own.datum.map(|datum| datum.value()))),
        suction: flow.suction,
        sides,
        regions: flow
            .regions
            .iter()
            .map(|region| RegionPressure {
                region: region.region.resolved(),
                pressure: region.pressure.resolved(),
            })
            .collect(),
    }
}

pub(super) fn gravity(gravity: &scene::Gravity) -> GravityPlan {
    GravityPlan {
        acceleration: values(&gravity.acceleration),
    }
}

pub(super) fn wells(scene: &scene::Scene, thickness: f64) -> Vec<WellPlan> {
    let well = |entry: &scene::Entry<scene::Well>| WellPlan {
        name: entry.name.clone(),
        at: values(&entry.value.at),
        rate: entry.value.rate.per_thickness(thickness),
        radius: entry.value.radius.map(|radius| radius.value()),
    };
    scene.wells.iter().map(well).collect()
}
