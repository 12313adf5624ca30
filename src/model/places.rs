//! Where the plan wants values that are not at points.

use super::cloud::cracks;
use crate::effects::vector;
use crate::geometry::{Cloud, Crack, Locator, OnCrack, Place, Vector};
use crate::plan::{Plan, Profile};

/// Places along each crack at which it is measured.
const ALONG: usize = 50;

/// Probes, profiles and cracks on a cloud.
#[derive(Debug, Clone, Default)]
pub struct Places<const D: usize> {
    /// One place per probe.
    pub probes: Vec<Place<D>>,
    /// The places along every profile.
    pub profiles: Vec<Vec<Place<D>>>,
    /// The places along every crack.
    pub cracks: Vec<Vec<Faces<D>>>,
}

/// A place on a crack with the points that give the values on either face.
#[derive(Debug, Clone)]
pub struct Faces<const D: usize> {
    /// The place.
    pub on: OnCrack<D>,
    /// On the side into which the normal points, and on the other.
    pub sides: [Place<D>; 2],
}

impl<const D: usize> Faces<D> {
    fn find(cloud: &Cloud<D>, on: OnCrack<D>) -> Self {
        let side = |sign: f64| {
            let off = |point: &usize| (cloud.position[*point] - on.at).dot(&on.normal) * sign > 0.0;
            Place::find_among(cloud, on.at, off)
        };
        Faces {
            on,
            sides: [side(1.0), side(-1.0)],
        }
    }

    /// Opening and sliding (m) from the displacements of the two faces; sliding is positive where the
    /// side of the normal moves along the tangent.
    pub fn jump(&self, faces: [Vector<D>; 2]) -> [f64; 2] {
        let jump = faces[0] - faces[1];
        [jump.dot(&self.on.normal), jump.dot(&self.on.tangent)]
    }
}

impl<const D: usize> Places<D> {
    /// Finds the places of a plan.
    pub fn find(plan: &Plan, cloud: &Cloud<D>) -> Self {
        let output = &plan.output;
        let along = |crack: &Crack<D>| {
            let middles = crack.middles(ALONG);
            middles
                .into_iter()
                .map(|on| Faces::find(cloud, on))
                .collect()
        };
        let cracks: Vec<Vec<Faces<D>>> = cracks(plan).iter().map(along).collect();
        if output.probes.is_empty() && output.profiles.is_empty() {
            return Places {
                cracks,
                ..Self::default()
            };
        }
        let locator = Locator::new(cloud);
        let place = |at: &[f64]| locator.place(vector(at));
        let along = |profile: &Profile| profile.places().iter().map(|at| place(at)).collect();
        Places {
            probes: output.probes.iter().map(|probe| place(&probe.at)).collect(),
            profiles: output.profiles.iter().map(along).collect(),
            cracks,
        }
    }

    /// Points that give the values.
    pub fn points(&self) -> Vec<usize> {
        let faces = self.cracks.iter().flatten().flat_map(|faces| &faces.sides);
        let places = self.probes.iter().chain(self.profiles.iter().flatten());
        let places = places.chain(faces);
        places.flat_map(|place| &place.nearest).copied().collect()
    }
}
