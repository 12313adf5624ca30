//! The two passes over blocks of points on a lattice, see [`super::lattice`].
#![allow(
    clippy::needless_range_loop,
    reason = "kernels over several arrays at once"
)]

use super::Work;
use super::lattice::LatticeForce;
use super::stencil::{Rows, add_up, gather, product, spread};
use crate::operators::Elastic;

impl<const D: usize> LatticeForce<D> {
    /// T of the families of a line of points, and what each does to its own point.
    #[inline(always)]
    pub(super) fn respond<const LANES: usize>(
        &self,
        elastic: &Elastic<D>,
        field: &[f64],
        (line, first): (usize, usize),
        stress: &mut [f64],
        rest: &mut [f64],
    ) {
        let (length, reach) = (self.padding.length(), self.padding.reach[0]);
        let count = self.padding.counts[0];
        let both = if self.springs.is_empty() { 2.0 } else { 1.0 };
        for block in (0..count).step_by(LANES / D) {
            let start = D * (reach + block);
            let at = D * line * length + start;
            let (slopes, sum) = gather::<D, LANES>(&self.pairs, field, at);
            for lane in 0..(LANES / D).min(count - block) {
                let (point, place) = (first + block + lane, D * lane);
                if !self.regular[point] {
                    continue;
                }
                let (lever, measure) = (self.lever[point], self.measure[point]);
                let mut moment = [[0.0; D]; D];
                for a in 0..D {
                    for b in 0..D {
                        moment[a][b] = slopes[b][place + a] - field[at + place + a] * lever[b];
                    }
                }
                let (traction, h) = response(elastic, point, &moment);
                for a in 0..D {
                    let mut pull = 0.0;
                    for b in 0..D {
                        stress[b * D * length + start + place + a] = traction[a][b];
                        pull += traction[a][b] * lever[b];
                    }
                    let spring = measure * field[at + place + a] - sum[place + a];
                    rest[start + place + a] = both * h * spring - pull;
                }
            }
        }
    }

    /// K u of a line of points.
    #[inline(always)]
    pub(super) fn collect<const LANES: usize>(
        &self,
        work: &Work<D>,
        first: usize,
        result: &mut [f64],
    ) {
        let site = self.padding.site_of(first);
        let (stress, column) = (self.stress_at(site, 0), D * self.padding.length());
        for start in (0..result.len()).step_by(LANES / D * D) {
            let at = D * site + start;
            let sum = spread::<D, LANES>(&self.pairs, &work.stress, (stress + start, column));
            let lanes = (LANES / D * D).min(result.len() - start);
            for k in 0..lanes {
                result[start + k] = sum[k] + work.rest[at + k];
            }
            if !self.springs.is_empty() {
                let sum = add_up::<D, LANES>(&self.pairs, &work.stiff, at);
                for k in 0..lanes {
                    let spring = self.springs[first + (start + k) / D];
                    result[start + k] += spring * work.displacement[at + k] - sum[k];
                }
            }
        }
    }
}

/// T of a family from its moment Σ ω V d ξᵀ, N/m, and its h.
#[inline(always)]
fn response<const D: usize>(
    elastic: &Elastic<D>,
    point: usize,
    moment: &Rows<D>,
) -> (Rows<D>, f64) {
    // Symmetric, so that columns are rows.
    let inverse = &elastic.around.inverse_shape[point].data.0;
    let slope = product(moment, inverse);
    let (lame, volume) = (elastic.lame[point], elastic.around.cloud.volume[point]);
    let (mu, lambda) = (volume * lame.mu, volume * lame.lambda);
    let mut trace = 0.0;
    for a in 0..D {
        trace += slope[a][a];
    }
    let mut stress = [[0.0; D]; D];
    for a in 0..D {
        for b in 0..D {
            stress[a][b] = mu * (slope[a][b] + slope[b][a]);
        }
        stress[a][a] += lambda * trace;
    }
    let h = elastic.hourglass(point).1;
    let mut traction = product(&stress, inverse);
    for a in 0..D {
        for b in 0..D {
            traction[a][b] -= slope[a][b] * h;
        }
    }
    (traction, h)
}
