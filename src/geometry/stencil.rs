//! Places between points: which points and mirror images give the values there, and how much each counts.
//!
//! A point counts at a place within its own horizon with
//!
//!   w = ((1 − q²) / q²)²,  q = distance / horizon,
//!
//! which is smooth, ends at the horizon and is infinite at the point itself. What is blended with these
//! weights is therefore continuous, and has the value of a point at the point (Franke and Nielson 1980).

use super::families::World;
use super::{Cloud, Cutter, GeometryError, ImageTable, Locator, Vector};

/// A point, or an image of one, that counts at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term<const D: usize> {
    /// The real point.
    pub point: usize,
    /// Number of its image; 0 is the point itself.
    pub image: u8,
    /// From the real point to where that image mirrors the place to, m.
    pub arm: Vector<D>,
    /// How much it counts beside the others.
    pub weight: f64,
}

/// A place with all that counts there.
#[derive(Debug, Clone, PartialEq)]
pub struct Stencil<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// At least one term of a real point.
    pub terms: Vec<Term<D>>,
}

/// Squared distance over squared horizon below which a place is that of the point.
const AT_POINT: f64 = 1e-12;

/// Finds what counts at places.
pub struct Stencils<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    horizon: &'a [f64],
    images: ImageTable<D>,
    world: World<D>,
    locator: Locator<'a, D>,
    cutter: Option<Cutter<D>>,
    reach: f64,
}

impl<'a, const D: usize> Stencils<'a, D> {
    /// Prepares the search in a cloud with the given horizons (m, shape `(n,)`); `cracks` makes what hides
    /// points from places behind it.
    ///
    /// # Errors
    /// [`GeometryError::TooManyImages`] for a domain too thin for the horizon.
    pub fn new(
        cloud: &'a Cloud<D>,
        horizon: &'a [f64],
        cracks: impl FnOnce(&ImageTable<D>) -> Option<Cutter<D>>,
    ) -> Result<Self, GeometryError> {
        let reach = horizon.iter().copied().fold(0.0, f64::max);
        let typical = horizon.iter().sum::<f64>() / horizon.len().max(1) as f64;
        let images = ImageTable::new(&cloud.domain, reach)?;
        Ok(Stencils {
            world: World::new(cloud, &images, reach, typical, None),
            cutter: cracks(&images),
            locator: Locator::new(cloud),
            cloud,
            horizon,
            images,
            reach,
        })
    }

    /// What counts at a place; the nearest points where it is within no horizon, or all are hidden.
    pub fn at(&self, at: Vector<D>) -> Stencil<D> {
        let mut terms = Vec::new();
        self.world.within(&at, self.reach, |index, squared| {
            let (point, number) = self.world.origin(index);
            let q = squared / self.horizon[point].powi(2);
            if q >= 1.0 || self.is_hidden(&at, point, number) {
                return;
            }
            terms.push(Term {
                point,
                image: number,
                arm: self.images.get(number).inverse(&at) - self.cloud.position[point],
                weight: ((1.0 - q) / (q + AT_POINT)).powi(2),
            });
        });
        terms.sort_unstable_by_key(|term| (term.point, term.image));
        if terms.iter().all(|term| term.image != 0) {
            let nearest = self.locator.place(at).nearest.into_iter();
            let term = |point: usize| Term {
                point,
                image: 0,
                arm: at - self.cloud.position[point],
                weight: 1.0,
            };
            terms = nearest.map(term).collect();
        }
        Stencil { at, terms }
    }

    fn is_hidden(&self, at: &Vector<D>, point: usize, image: u8) -> bool {
        let place = self.images.get(image).place(&self.cloud.position[point]);
        let cutter = self.cutter.as_ref();
        cutter.is_some_and(|cutter| cutter.first(at, &place).is_some())
    }
}

/// The points of some stencils, ascending, each once.
pub fn sources<'a, const D: usize>(
    stencils: impl IntoIterator<Item = &'a Stencil<D>>,
) -> Vec<usize> {
    let terms = stencils.into_iter().flat_map(|stencil| &stencil.terms);
    let mut points: Vec<usize> = terms.map(|term| term.point).collect();
    points.sort_unstable();
    points.dedup();
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::{jitter, lattice};

    fn cloud() -> Cloud<2> {
        let mut cloud = lattice(Vector::zeros(), Vector::repeat(1.0), [12, 12]).unwrap();
        jitter(&mut cloud, 0.3, 5);
        cloud
    }

    /// Share of every term, and where its mirrored arm leads back to.
    #[test]
    fn weights_pass_to_a_point_at_its_place_and_fade_out_at_the_horizon() {
        let cloud = cloud();
        let horizon = vec![0.2; cloud.len()];
        let stencils = Stencils::new(&cloud, &horizon, |_| None).unwrap();
        let at = stencils.at(cloud.position[40]);
        let all: f64 = at.terms.iter().map(|term| term.weight).sum();
        let own = at
            .terms
            .iter()
            .find(|term| term.point == 40 && term.image == 0);
        assert!(1.0 - own.unwrap().weight / all < 1e-12);
        let corner = stencils.at(Vector::<2>::new(0.01, 0.02));
        assert!(corner.terms.iter().any(|term| term.image != 0));
        for term in &corner.terms {
            let mirrored = cloud.position[term.point] + term.arm;
            let back = stencils.images.get(term.image).place(&mirrored);
            assert!((back - corner.at).norm() < 1e-14);
            assert!(term.weight > 0.0);
        }
    }

    #[test]
    fn a_cut_hides_the_points_behind_it() {
        let cloud = cloud();
        let horizon = vec![0.2; cloud.len()];
        let points = vec![Vector::<2>::new(0.0, 0.5), Vector::<2>::new(1.0, 0.5)];
        let crack = crate::geometry::Crack { points };
        let cut = |images: &ImageTable<2>| Some(Cutter::new(&[crack], images));
        let stencils = Stencils::new(&cloud, &horizon, cut).unwrap();
        let above = stencils.at(Vector::<2>::new(0.5, 0.505));
        assert!(
            above
                .terms
                .iter()
                .all(|term| cloud.position[term.point][1] > 0.5)
        );
        assert!(!stencils.at(Vector::<2>::new(0.5, 0.5)).terms.is_empty());
    }
}
