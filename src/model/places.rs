//! Where the plan wants values that are not at points.

use super::ModelError;
use super::cloud::cracks;
use crate::effects::vector;
use crate::geometry::{Cloud, Crack, Locator, OnCrack, Place, Vector, horizons};
use crate::plan::{CrackKind, CrackPlan, Plan, Profile};

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
    /// Faces are next to a cut; a damaged band of half width `band` ends at them.
    fn find(locator: &Locator<'_, D>, on: OnCrack<D>, band: f64) -> Option<Self> {
        let side = |sign: f64| {
            let off = |x: &Vector<D>| {
                let beyond = (x - on.at).dot(&on.normal) * sign;
                beyond > 0.0 && beyond >= band
            };
            let mut place = locator.place_among(on.at, off)?;
            place.at += on.normal * (sign * band);
            Some(place)
        };
        let sides = [side(1.0)?, side(-1.0)?];
        Some(Faces { on, sides })
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
    ///
    /// # Errors
    /// [`ModelError::CrackAtBoundary`].
    pub fn find(plan: &Plan, cloud: &Cloud<D>) -> Result<Self, ModelError> {
        let output = &plan.output;
        if output.probes.is_empty() && output.profiles.is_empty() && plan.cracks.is_empty() {
            return Ok(Self::default());
        }
        let locator = Locator::new(cloud);
        let place = |at: &[f64]| locator.place(vector(at));
        let along = |profile: &Profile| profile.places().iter().map(|at| place(at)).collect();
        let horizon = match plan.cracks.iter().any(|own| own.kind == CrackKind::Damaged) {
            true => horizons(cloud, plan.horizon)?,
            false => Vec::new(),
        };
        let faces = |(crack, own): (Crack<D>, &CrackPlan)| -> Result<Vec<Faces<D>>, ModelError> {
            let middles = crack.middles(ALONG).into_iter();
            let face = |on: OnCrack<D>| {
                let band = match own.kind {
                    CrackKind::Cut => 0.0,
                    CrackKind::Damaged => {
                        let nearest = locator.place(on.at).nearest;
                        nearest.iter().map(|i| horizon[*i]).fold(0.0, f64::max)
                    }
                };
                Faces::find(&locator, on, band).ok_or_else(|| ModelError::CrackAtBoundary {
                    name: own.name.clone(),
                    at: on.at.iter().copied().collect(),
                })
            };
            middles.map(face).collect()
        };
        let cracks = cracks(plan).into_iter().zip(&plan.cracks).map(faces);
        Ok(Places {
            probes: output.probes.iter().map(|probe| place(&probe.at)).collect(),
            profiles: output.profiles.iter().map(along).collect(),
            cracks: cracks.collect::<Result<_, _>>()?,
        })
    }

    /// Points that give the values.
    pub fn points(&self) -> Vec<usize> {
        let faces = self.cracks.iter().flatten().flat_map(|faces| &faces.sides);
        let places = self.probes.iter().chain(self.profiles.iter().flatten());
        let places = places.chain(faces);
        places.flat_map(|place| &place.nearest).copied().collect()
    }
}
