//! The weight of the rock above, for K₀.

use crate::geometry::{Cloud, Vector};
use crate::model::ModelError;

/// Share by which weights may differ within a layer, and depths of its points from each other.
const SAME: f64 = 1e-9;

/// Weight of the rock above per area, a function of depth: straight lines through layers.
pub(super) struct Overburden {
    /// Depth of the upper edge of a layer below the datum, m, the weight above it, Pa, and its own, N/m³.
    layers: Vec<(f64, f64, f64)>,
}

impl Overburden {
    /// The overburden of points of the given weights, N/m³; `origin` is the depth of the origin, m. Above the
    /// domain, up to the datum, the rock is that of the uppermost layer.
    ///
    /// # Errors
    /// [`ModelError::UnevenWeight`] if it changes with more than depth, or on a cloud without layers.
    pub(crate) fn of<const D: usize>(
        cloud: &Cloud<D>,
        down: &Vector<D>,
        origin: f64,
        weight: &[f64],
    ) -> Result<Self, ModelError> {
        let first = weight.first().copied().unwrap_or(0.0);
        let differs = |own: &&f64| (*own - first).abs() > SAME * first.abs();
        let Some(other) = weight.iter().find(differs) else {
            return Ok(Overburden {
                layers: vec![(0.0, 0.0, first)],
            });
        };
        let uneven = || ModelError::UnevenWeight {
            weights: [first, *other],
        };
        let axis = (0..D).find(|axis| down[*axis].abs() > 1.0 - SAME);
        let axis = axis.filter(|_| !cloud.irregular && cloud.filled);
        let axis = axis.ok_or_else(uneven)?;
        let size = cloud.domain.size();
        let area = size.product() / size[axis];
        let top = if down[axis] < 0.0 {
            cloud.domain.upper[axis]
        } else {
            cloud.domain.lower[axis]
        };
        let mut points: Vec<(f64, usize)> = (0..cloud.len())
            .map(|point| (down.dot(&cloud.position[point]), point))
            .collect();
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut layers = Vec::new();
        let mut edge = origin + down[axis] * top;
        let mut above = None;
        for layer in points.chunk_by(|a, b| (a.0 - b.0).abs() <= SAME * size[axis]) {
            let own = weight[layer[0].1];
            if layer
                .iter()
                .any(|(_, i)| (weight[*i] - own).abs() > SAME * own.abs())
            {
                return Err(uneven());
            }
            let load = *above.get_or_insert(edge * own);
            layers.push((edge, load, own));
            let height = layer.iter().map(|(_, i)| cloud.volume[*i]).sum::<f64>() / area;
            edge += height;
            above = Some(load + height * own);
        }
        Ok(Overburden { layers })
    }

    /// Weight above a depth below the datum, Pa.
    pub(crate) fn weight(&self, depth: f64) -> f64 {
        let below = self.layers.partition_point(|layer| layer.0 <= depth);
        let (edge, above, own) = self.layers[below.saturating_sub(1)];
        above + own * (depth - edge)
    }
}
