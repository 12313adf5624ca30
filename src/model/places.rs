//! Where the plan wants values that are not at points.

use super::ModelError;
use super::cloud::{cracks, cut_cracks};
use crate::effects::vector;
use crate::geometry::{
    Cloud, Crack, Cutter, ImageTable, Locator, OnCrack, Place, Side, Stencil, Stencils, Vector,
    sources,
};
use crate::plan::{CrackKind, CrackPlace, CrackPlan, Plan, Profile, Support};

use super::disc::Disc;

/// Places along each crack at which it is measured.
const ALONG: usize = 50;

/// Probes, profiles and cracks on a cloud.
#[derive(Debug, Clone, Default)]
pub struct Places<const D: usize> {
    /// One place per probe.
    pub probes: Vec<Stencil<D>>,
    /// The places along every profile.
    pub profiles: Vec<Vec<Stencil<D>>>,
    /// The places along every crack.
    pub cracks: Vec<Vec<Faces<D>>>,
}

/// A place on a crack with the points that give the values on either face.
#[derive(Debug, Clone)]
pub struct Faces<const D: usize> {
    /// The place.
    pub on: OnCrack<D>,
    /// On the side into which the normal points, and on the other; on a plane of symmetry both are the
    /// side in the domain.
    pub sides: [Place<D>; 2],
    /// +1 or −1 for the side in the domain where the other one is its mirror image, else 0.
    pub mirrored: f64,
}

impl<const D: usize> Faces<D> {
    /// Values of faces come from the rock next to a cut, or beyond a damaged band of half width `band`, and go on
    /// from there to the crack with its gradient: what the rock in the band is strained by is no opening. `mirror`
    /// tells that the crack lies on a plane of symmetry.
    fn find(locator: &Locator<'_, D>, on: OnCrack<D>, band: f64, mirror: bool) -> Option<Self> {
        let side = |sign: f64| {
            let off = |x: &Vector<D>| {
                let beyond = (x - on.at).dot(&on.normal) * sign;
                beyond > 0.0 && beyond >= band
            };
            locator.place_among(on.at, off)
        };
        let (sides, mirrored) = match (side(1.0), side(-1.0)) {
            (Some(one), Some(other)) if !mirror => ([one, other], 0.0),
            (Some(one), None) if mirror => ([one.clone(), one], 1.0),
            (None, Some(other)) if mirror => ([other.clone(), other], -1.0),
            _ => return None,
        };
        Some(Faces {
            on,
            sides,
            mirrored,
        })
    }

    /// Opening and sliding (m) from the displacements of the two faces; sliding is positive where the
    /// side of the normal moves along the tangent.
    pub fn jump(&self, faces: [Vector<D>; 2]) -> [f64; 2] {
        if self.mirrored != 0.0 {
            return [2.0 * self.mirrored * faces[0].dot(&self.on.normal), 0.0];
        }
        let jump = faces[0] - faces[1];
        [jump.dot(&self.on.normal), jump.dot(&self.on.tangent)]
    }
}

impl<const D: usize> Places<D> {
    /// Finds the places of a plan in a cloud with the given horizons (m, shape `(n,)`).
    ///
    /// # Errors
    /// [`ModelError::CrackAtBoundary`]; [`ModelError::Geometry`] for a domain too thin for the horizon.
    pub fn find(plan: &Plan, cloud: &Cloud<D>, horizon: &[f64]) -> Result<Self, ModelError> {
        let output = &plan.output;
        let mut places = Places::default();
        if !output.probes.is_empty() || !output.profiles.is_empty() {
            let cutter = |images: &ImageTable<D>| cutter(plan, images);
            let stencils = Stencils::new(cloud, horizon, cutter)?;
            let place = |at: &Vec<f64>| stencils.at(vector(at));
            let along = |profile: &Profile| profile.places().iter().map(place).collect();
            places.probes = output.probes.iter().map(|probe| place(&probe.at)).collect();
            places.profiles = output.profiles.iter().map(along).collect();
        }
        let locator = Locator::new(cloud);
        for (crack, own) in cracks(plan).into_iter().zip(&plan.cracks) {
            let faces = faces(plan, &locator, cloud, horizon, (&crack, own))?;
            places.cracks.push(faces);
        }
        Ok(places)
    }

    /// Points whose families the values need: those on cracks, and those of probes and profiles if they
    /// are wanted.
    pub fn points(&self, between: bool) -> Vec<usize> {
        let faces = self.cracks.iter().flatten().flat_map(|faces| &faces.sides);
        let mut points: Vec<usize> = faces.flat_map(|place| &place.nearest).copied().collect();
        if between {
            let all = self.probes.iter().chain(self.profiles.iter().flatten());
            points.extend(sources(all));
        }
        points
    }
}

/// The cracks of a plan that cut bonds; `None` without any.
fn cutter<const D: usize>(plan: &Plan, images: &ImageTable<D>) -> Option<Cutter<D>> {
    let cut = cut_cracks(plan);
    (!cut.is_empty()).then(|| Cutter::new(&cut, images))
}

/// The places along a crack, or from the centre of a disc to its rim, with their faces.
fn faces<const D: usize>(
    plan: &Plan,
    locator: &Locator<'_, D>,
    cloud: &Cloud<D>,
    horizon: &[f64],
    (crack, own): (&Crack<D>, &CrackPlan),
) -> Result<Vec<Faces<D>>, ModelError> {
    let (along, mirror) = match &own.place {
        CrackPlace::Chain(_) => {
            let damaged = own.kind == CrackKind::Damaged;
            let mirror = damaged && on_symmetry(plan, cloud, &crack.points, None);
            (crack.middles(ALONG), mirror)
        }
        CrackPlace::Disc { .. } => {
            let disc = Disc::of(&own.place);
            let mirror = disc
                .as_ref()
                .is_some_and(|disc| on_symmetry(plan, cloud, &[disc.centre], Some(disc.normal)));
            (
                disc.map_or_else(Vec::new, |disc| disc.radius(&cloud.domain, ALONG)),
                mirror,
            )
        }
    };
    let face = |on: OnCrack<D>| {
        let band = match own.kind {
            CrackKind::Cut => 0.0,
            CrackKind::Damaged => {
                let nearest = locator.place(on.at).nearest;
                nearest.iter().map(|i| horizon[*i]).fold(0.0, f64::max)
            }
        };
        let found = Faces::find(locator, on, band, mirror);
        found.ok_or_else(|| ModelError::CrackAtBoundary {
            name: own.name.clone(),
            at: on.at.iter().copied().collect(),
        })
    };
    along.into_iter().map(face).collect()
}

/// The parts of a crack whose middles are its places, each as a chain of straight lines, m.
pub fn crack_parts<const D: usize>(
    plan: &Plan,
    model: &super::Model<D>,
    number: usize,
) -> Vec<Vec<Vector<D>>> {
    let places = &model.places.cracks[number];
    if let Some(crack) = cracks(plan).get(number)
        && !crack.points.is_empty()
    {
        return crack.parts(places.len());
    }
    // The places on a radius begin half a part from the centre.
    let half = places.first().map_or(0.0, |first| first.on.distance);
    let ends = |faces: &Faces<D>| [-half, half].map(|arm| faces.on.at + faces.on.tangent * arm);
    places.iter().map(|faces| ends(faces).to_vec()).collect()
}

/// Whether all of some points, and a plane with a normal if there is one, lie on a side on which the displacement
/// is symmetric.
fn on_symmetry<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    points: &[Vector<D>],
    normal: Option<Vector<D>>,
) -> bool {
    let Some(mechanics) = &plan.mechanics else {
        return false;
    };
    Side::all(D).any(|side| {
        let held =
            matches!(&mechanics.sides[side.index()], Support::Roller(load) if load.is_constant());
        let gap = |x: &Vector<D>| (x[side.axis] - cloud.domain.plane(side)).abs();
        let near = points
            .iter()
            .all(|x| gap(x) <= 1e-9 * cloud.domain.size()[side.axis]);
        let flat = normal.is_none_or(|normal| normal[side.axis].abs() > 1.0 - 1e-9);
        cloud.domain.planes && held && flat && near
    })
}
