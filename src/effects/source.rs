//! The volumetric source that a manufactured solution needs.

use super::{Context, Effect, EffectError};
use crate::geometry::Vector;
use crate::plan::manufactured;
use crate::reference::{ExactPressure, Manufactured};

/// Source S ∂p/∂t − κ∇²p of the manufactured pressure, sampled at the points.
pub(crate) struct ManufacturedSource<const D: usize> {
    solution: Manufactured,
    position: Vec<Vector<D>>,
    volume: Vec<f64>,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(solution) = manufactured(context.plan).map_err(EffectError::Manufactured)? else {
        return Ok(Vec::new());
    };
    let cloud = &context.operator.neighbourhood().cloud;
    let source = ManufacturedSource {
        solution,
        position: cloud.position.clone(),
        volume: cloud.volume.clone(),
    };
    Ok(vec![Box::new(source)])
}

impl<const D: usize> ManufacturedSource<D> {
    fn at(&self, point: usize, time: f64) -> f64 {
        self.volume[point]
            * self
                .solution
                .source(self.position[point].as_slice(), time)
                .unwrap_or(0.0)
    }
}

impl<const D: usize> Effect for ManufacturedSource<D> {
    fn name(&self) -> &'static str {
        "manufactured-source"
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        rate.iter_mut()
            .enumerate()
            .for_each(|(point, own)| *own += self.at(point, time));
    }

    fn injection(&self, time: f64) -> f64 {
        (0..self.volume.len())
            .map(|point| self.at(point, time))
            .sum()
    }

    fn gross(&self, time: f64) -> f64 {
        (0..self.volume.len())
            .map(|point| self.at(point, time).abs())
            .sum()
    }

    fn is_constant(&self) -> bool {
        false
    }

    fn bytes(&self) -> usize {
        8 * (D + 1) * self.volume.len()
    }
}
