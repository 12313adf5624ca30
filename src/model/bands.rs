//! Points of cracks that are damaged from the start.

use crate::effects::vector;
use crate::geometry::{Cloud, Crack, GeometryError, Vector, horizons};
use crate::plan::{CrackKind, CrackPlace, CrackPlan, Plan};

/// Points within one horizon of every crack, in the order of the plan; none for cracks that are cut.
///
/// A band that ends before the horizon would leave bonds across the crack that keep it shut.
#[derive(Debug, Clone, Default)]
pub struct Bands {
    /// Points per crack, ascending.
    pub points: Vec<Vec<u32>>,
}

impl Bands {
    /// Finds the bands of a plan.
    ///
    /// # Errors
    /// [`GeometryError`] if the cloud has too few points for its horizon.
    pub fn find<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<Self, GeometryError> {
        let damaged = |crack: &CrackPlan| crack.kind == CrackKind::Damaged;
        if !plan.cracks.iter().any(damaged) {
            return Ok(Bands {
                points: vec![Vec::new(); plan.cracks.len()],
            });
        }
        let horizon = horizons(cloud, plan.horizon)?;
        let band = |crack: &CrackPlan| -> Vec<u32> {
            if !damaged(crack) {
                return Vec::new();
            }
            let inside = |i: &u32| {
                let i = *i as usize;
                gap(crack, &cloud.position[i]).is_some_and(|gap| gap < horizon[i])
            };
            (0..cloud.len() as u32).filter(inside).collect()
        };
        Ok(Bands {
            points: plan.cracks.iter().map(band).collect(),
        })
    }

    /// All points of all bands, ascending, each once.
    pub fn all(&self) -> Vec<u32> {
        let mut all: Vec<u32> = self.points.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// Distance from a crack to a place beside it, m; `None` beyond its tips or rim.
fn gap<const D: usize>(crack: &CrackPlan, x: &Vector<D>) -> Option<f64> {
    match &crack.place {
        CrackPlace::Chain(points) => {
            let points = points.iter().map(|x| vector(x)).collect();
            Crack { points }.gap(x)
        }
        CrackPlace::Disc {
            centre,
            normal,
            radius,
        } => {
            let (arm, normal) = (x - vector(centre), vector::<D>(normal));
            let along = arm.dot(&normal);
            ((arm - normal * along).norm() <= *radius).then_some(along.abs())
        }
    }
}
