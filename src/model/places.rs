//! Where the plan wants values that are not at points.

use crate::effects::vector;
use crate::geometry::{Cloud, Locator, Place};
use crate::plan::{Plan, Profile};

/// Probes and profiles on a cloud.
#[derive(Debug, Clone, Default)]
pub struct Places<const D: usize> {
    /// One place per probe.
    pub probes: Vec<Place<D>>,
    /// The places along every profile.
    pub profiles: Vec<Vec<Place<D>>>,
}

impl<const D: usize> Places<D> {
    /// Finds the places of a plan.
    pub fn find(plan: &Plan, cloud: &Cloud<D>) -> Self {
        let output = &plan.output;
        if output.probes.is_empty() && output.profiles.is_empty() {
            return Self::default();
        }
        let locator = Locator::new(cloud);
        let place = |at: &[f64]| locator.place(vector(at));
        let along = |profile: &Profile| profile.places().iter().map(|at| place(at)).collect();
        Places {
            probes: output.probes.iter().map(|probe| place(&probe.at)).collect(),
            profiles: output.profiles.iter().map(along).collect(),
        }
    }

    /// Points that give the values.
    pub fn points(&self) -> Vec<usize> {
        let places = self.probes.iter().chain(self.profiles.iter().flatten());
        places.flat_map(|place| &place.nearest).copied().collect()
    }
}
