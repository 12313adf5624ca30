//! The in-situ state.

use crate::plan::types::InitialPlan;
use crate::scene::{Scene, StressKind};

/// The stress of the in-situ state, by its section or by the short form in `[mechanics]`; none without
/// deformation.
pub(super) fn initial(scene: &Scene) -> Option<InitialPlan> {
    let mechanics = scene.mechanics.as_ref()?;
    let short = mechanics.initial_stress.as_ref();
    let Some(own) = &scene.initial else {
        return short.map(|stress| InitialPlan {
            stress: stress.resolved(),
            ..InitialPlan::default()
        });
    };
    let stress = own.stress.as_ref().or(short);
    let gradient = own.stress_gradient.as_ref();
    let regions = own.regions.iter();
    Some(InitialPlan {
        total: own.kind.value == StressKind::Total,
        stress: stress.map_or([0.0; 6], |stress| stress.resolved()),
        gradient: gradient.map_or([0.0; 6], |gradient| gradient.resolved()),
        datum: own.datum.map(|datum| datum.value()),
        k0: own.k0.map(|k0| k0.value()),
        regions: regions
            .map(|own| (own.region.resolved(), own.stress.resolved()))
            .collect(),
    })
}
