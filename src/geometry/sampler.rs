//! Families of single points, found on demand: for estimates before anything large is built.

use super::families::World;
use super::{Cloud, GeometryError, Horizon, ImageTable, Vector, horizons};

/// Finds families one by one.
pub struct Sampler<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    horizon: Vec<f64>,
    images: ImageTable<D>,
    world: World<D>,
}

/// A bond found by a [`Sampler`]: neighbour, whether it is a mirror image, and bond vector in metres.
pub(super) type SampledBond<const D: usize> = (usize, bool, Vector<D>);

impl<'a, const D: usize> Sampler<'a, D> {
    /// Prepares the search.
    ///
    /// # Errors
    /// As [`horizons`].
    pub fn new(cloud: &'a Cloud<D>, horizon: Horizon) -> Result<Self, GeometryError> {
        let horizon = horizons(cloud, horizon)?;
        let reach = horizon.iter().copied().fold(0.0, f64::max);
        let images = ImageTable::new(&cloud.domain, reach)?;
        let world = World::new(cloud, &images, reach, reach, None);
        Ok(Sampler {
            cloud,
            horizon,
            images,
            world,
        })
    }

    /// Horizon of every point in metres.
    pub fn horizon(&self) -> &[f64] {
        &self.horizon
    }

    /// Family of one point.
    pub fn family(&self, point: usize) -> Vec<SampledBond<D>> {
        let x = self.cloud.position[point];
        let mut bonds = Vec::new();
        self.world.within(&x, self.horizon[point], |index, _| {
            let (neighbour, image) = self.world.origin(index);
            if (neighbour, image) != (point, 0) {
                let end = self
                    .images
                    .get(image)
                    .place(&self.cloud.position[neighbour]);
                bonds.push((neighbour, image != 0, end - x));
            }
        });
        bonds
    }
}
