//! Opening of cracks in the split model: what broken points hold, summed across the crack.
//!
//! A point of the band holds V (1 − g) q_n/M of fluid. Summed over all points of the band with a weight of unit
//! integral along the crack this is the opening there; the same sum of volumes is the width of the band. Points
//! of cracks in other directions count by (n_i·n_j)², the share of their opening along n_i.

use serde::{Deserialize, Serialize};

use crate::geometry::{CellList, Vector};
use crate::operators::{Elastic, Response};
use crate::parallel;

/// Opening of a crack and width of its band, m.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Opening {
    /// w.
    pub opening: f64,
    /// W.
    pub width: f64,
}

/// Half width of the weight along the crack, in spacings: a hat of two sums to one on rows of a lattice, to 1.02 at
/// 45°.
const ALONG: f64 = 2.0;
/// Reach across the crack in horizons: from one edge of a band to the other.
const ACROSS: f64 = 2.0;

/// A point of a crack, or a mirror image of one.
struct Item<const D: usize> {
    at: Vector<D>,
    normal: Vector<D>,
    /// V (1 − g) q_n/M, m^D.
    content: f64,
    /// V where the point conducts, m^D.
    volume: f64,
}

/// Openings at the points that conduct, shape `(n,)`; zero elsewhere.
pub(crate) fn openings<const D: usize>(
    elastic: &Elastic<D>,
    response: &Response<D>,
    conducts: &[bool],
) -> Vec<Opening> {
    let cloud = &elastic.around.cloud;
    let horizon = &elastic.around.families.horizon;
    let reach = |i: usize| (ACROSS * horizon[i]).hypot(ALONG * cloud.spacing(i));
    let wet = (0..conducts.len()).filter(|i| conducts[*i]);
    let farthest = wet.map(reach).fold(0.0, f64::max);
    let mut openings = vec![Opening::default(); conducts.len()];
    if farthest <= 0.0 {
        return openings;
    }
    let items = items(elastic, response, conducts, farthest);
    let places: Vec<Vector<D>> = items.iter().map(|item| item.at).collect();
    let cells = CellList::new(&places, farthest);
    let at = |i: usize| {
        if !conducts[i] {
            return Opening::default();
        }
        let (x, normal) = (cloud.position[i], response.planes[i].normal);
        let (along, across) = (ALONG * cloud.spacing(i), ACROSS * horizon[i]);
        let mut near: Vec<u32> = Vec::new();
        cells.within(&x, reach(i), |k, _| near.push(k));
        // The sum must not depend on how cells are visited.
        near.sort_unstable();
        let mut sum = Opening::default();
        for item in near.iter().map(|k| &items[*k as usize]) {
            let arm = item.at - x;
            let off = arm.dot(&normal);
            let weight = hat::<D>((arm - normal * off).norm(), along);
            if off.abs() <= across && weight > 0.0 {
                let share = weight * item.normal.dot(&normal).powi(2);
                sum.opening += share * item.content;
                sum.width += share * item.volume;
            }
        }
        sum
    };
    parallel::each(&mut openings, 1, |i, own| *own = at(i));
    openings
}

/// All points of cracks, and their images within `reach` of the domain.
fn items<const D: usize>(
    elastic: &Elastic<D>,
    response: &Response<D>,
    conducts: &[bool],
    reach: f64,
) -> Vec<Item<D>> {
    let (cloud, images) = (&elastic.around.cloud, &elastic.around.families.images);
    let near = |x: &Vector<D>| {
        (0..D)
            .all(|k| x[k] >= cloud.domain.lower[k] - reach && x[k] <= cloud.domain.upper[k] + reach)
    };
    let mut items = Vec::new();
    for (i, plane) in response.planes.iter().enumerate() {
        let volume = cloud.volume[i];
        let content = volume * plane.opening;
        if content <= 0.0 && !conducts[i] {
            continue;
        }
        for number in 0..images.len() as u8 {
            let image = images.get(number);
            let at = image.place(&cloud.position[i]);
            if elastic.extension[0].keeps(number) && near(&at) {
                items.push(Item {
                    at,
                    normal: image.reflect(&plane.normal),
                    content,
                    volume: if conducts[i] { volume } else { 0.0 },
                });
            }
        }
    }
    items
}

/// A hat of unit integral over a line, or over a plane in space, 1/m^(D−1).
fn hat<const D: usize>(distance: f64, half: f64) -> f64 {
    let height = match D {
        2 => 1.0 / half,
        _ => 3.0 / (std::f64::consts::PI * half * half),
    };
    height * (1.0 - distance / half).max(0.0)
}
