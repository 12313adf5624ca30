//! Horizons: how far each point sees.

use serde::Serialize;

use super::families::World;
use super::near::Near;
use super::{Cloud, GeometryError, ImageTable, Lattice, Vector};
use crate::parallel;
use perifrac_solvers::Partition;

/// Rule that gives every point its horizon δ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Horizon {
    /// Distance to the n-th nearest point; all points at that distance belong to the family, so a
    /// lattice keeps its symmetry (15 gives the full 20-point shell of the square lattice).
    Neighbours(usize),
    /// The same radius in metres everywhere.
    Radius(f64),
    /// A multiple of the point's own spacing.
    Ratio(f64),
}

/// Room for points whose distance equals the horizon up to rounding.
const SLACK: f64 = 1.0 + 1e-6;

/// Horizon of every point, shape `(n,)`, in metres. Mirror images count as neighbours.
///
/// # Errors
/// [`GeometryError::TooFewPoints`] if the cloud cannot supply the neighbours asked for;
/// [`GeometryError::TooManyImages`] if it is too thin.
pub fn horizons<const D: usize>(
    cloud: &Cloud<D>,
    horizon: Horizon,
) -> Result<Vec<f64>, GeometryError> {
    horizons_in_parts(cloud, horizon, None)
}

/// As [`horizons`], but if there is a partition every process searches for its own points, and all
/// processes must call this together.
///
/// # Errors
/// As [`horizons`].
pub fn horizons_in_parts<const D: usize>(
    cloud: &Cloud<D>,
    horizon: Horizon,
    partition: Option<&Partition>,
) -> Result<Vec<f64>, GeometryError> {
    match horizon {
        Horizon::Radius(radius) => Ok(vec![radius * SLACK; cloud.len()]),
        Horizon::Ratio(ratio) => Ok((0..cloud.len())
            .map(|i| ratio * cloud.spacing(i) * SLACK)
            .collect()),
        Horizon::Neighbours(neighbours) => {
            let Some(partition) = partition else {
                return nearest_distances(cloud, neighbours, None);
            };
            let mut radii = nearest_distances(cloud, neighbours, Some(&partition.mask()))?;
            partition.complete(&mut radii, 1);
            Ok(radii)
        }
    }
}

/// Distances of the points that are wanted, of all without a mask; zeros for the others.
fn nearest_distances<const D: usize>(
    cloud: &Cloud<D>,
    neighbours: usize,
    mask: Option<&[bool]>,
) -> Result<Vec<f64>, GeometryError> {
    if !cloud.domain.planes && cloud.len() <= neighbours {
        return Err(GeometryError::TooFewPoints {
            points: cloud.len(),
            neighbours,
        });
    }
    // Radius, in spacings, of a ball that holds twice the neighbours wanted.
    let wide = match D {
        2 => (2.0 * (neighbours + 1) as f64 / std::f64::consts::PI).sqrt(),
        _ => (1.5 * (neighbours + 1) as f64 / std::f64::consts::PI).cbrt(),
    };
    if let (None, Some(lattice)) = (mask, Lattice::of(cloud)) {
        let distance = lattice.nearest_distance(neighbours, wide * cloud.spacing(0));
        if let Some(distance) = distance {
            return Ok(vec![distance * SLACK; cloud.len()]);
        }
    }
    let wanted = |point: &usize| mask.is_none_or(|mask| mask[*point]);
    let first: Vec<f64> = (0..cloud.len()).map(|i| wide * cloud.spacing(i)).collect();
    let widest = first.iter().copied().fold(0.0, f64::max);
    let mut reach = widest;
    loop {
        let images = ImageTable::new(&cloud.domain, reach)?;
        let near = mask.map(|_| {
            let points = (0..cloud.len()).filter(wanted);
            let positions: Vec<Vector<D>> = points.map(|point| cloud.position[point]).collect();
            Near::new(&positions, reach)
        });
        let world = World::new(cloud, &images, reach, reach.min(widest), near.as_ref());
        let radius = |distances: &mut Vec<f64>, point: usize| match wanted(&point) {
            true => world.nearest(cloud, point, neighbours, first[point], reach, distances),
            false => Some(0.0),
        };
        let found: Vec<Option<f64>> = parallel::map_with(cloud.len(), 1, Vec::new, radius);
        match found.into_iter().collect::<Option<Vec<f64>>>() {
            Some(radii) => return Ok(radii.into_iter().map(|radius| radius * SLACK).collect()),
            None => reach *= 2.0,
        }
    }
}

impl<const D: usize> World<D> {
    /// Distance to the `neighbours`-th nearest point, or `None` if it is beyond `reach`.
    fn nearest(
        &self,
        cloud: &Cloud<D>,
        point: usize,
        neighbours: usize,
        first: f64,
        reach: f64,
        squared: &mut Vec<f64>,
    ) -> Option<f64> {
        let mut radius = first.min(reach);
        loop {
            squared.clear();
            self.within(&cloud.position[point], radius, |_, distance| {
                squared.push(distance)
            });
            // The point itself is among them, at distance zero.
            if squared.len() > neighbours {
                let (_, &mut found, _) = squared.select_nth_unstable_by(neighbours, f64::total_cmp);
                return Some(found.sqrt());
            }
            if radius >= reach {
                return None;
            }
            radius = (1.5 * radius).min(reach);
        }
    }
}
