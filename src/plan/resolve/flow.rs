//! Flow and what drives it.

use crate::plan::types::{
    FlowPlan, GravityPlan, RegionPressure, SideCondition, WellDrive, WellPlan, Wellbore,
};
use crate::scene::quantity::{Pressure, values};
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
    let well = |entry: &scene::Entry<scene::Well>| {
        let own = &entry.value;
        Some(WellPlan {
            name: entry.name.clone(),
            at: values(&own.at),
            drive: drive(own, thickness)?,
            radius: own.radius.map(|radius| radius.value()),
            bore: own.wellbore_radius.map(|radius| Wellbore {
                radius: radius.value(),
                skin: own.skin.map_or(0.0, |skin| skin.value()),
            }),
        })
    };
    scene.wells.iter().filter_map(well).collect()
}

/// What a well is held at; a scene without faults tells exactly one of rate and pressure.
fn drive(well: &scene::Well, thickness: f64) -> Option<WellDrive> {
    let limit = |pressure: Option<Pressure>| pressure.map(|own| own.value());
    let rate = well.rate.as_ref().map(|rate| WellDrive::Rate {
        rate: rate.per_thickness(thickness),
        pressure_min: limit(well.pressure_min),
        pressure_max: limit(well.pressure_max),
    });
    let pressure = || {
        Some(WellDrive::Pressure {
            pressure: well.pressure.as_ref()?.resolved(),
            rate_max: well.rate_max.map(|most| most.per_thickness(thickness)),
        })
    };
    rate.or_else(pressure)
}
