//! Prescribed flux through plane sides, spread by the area vectors of the one-sided families.
//!
//! A uniform flux is then in balance with a linear pressure to rounding.

use super::{Context, Effect, EffectError, sides_with};
use crate::operators::{Gradient, Parity, area_vectors};
use crate::plan::SideCondition;
use crate::plan::Load;

/// One side: its flux over time and the area that every point presents to it.
struct Flux {
    flux: Load,
    area: Vec<(u32, f64)>,
    total: f64,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(flow) = &context.plan.flow else { return Ok(Vec::new()) };
    let around = context.operator.neighbourhood();
    let mut effects: Vec<Box<dyn Effect>> = Vec::new();
    for side in sides_with(context.extension, Parity::OneSided) {
        let SideCondition::Flux(flux) = &flow.sides[side.index()] else { continue };
        let vectors = area_vectors(around, &Gradient::plain(around), context.extension);
        let layer = |point: usize| {
            let gap = around.cloud.position[point][side.axis] - around.cloud.domain.plane(side);
            // Columns feel points one horizon away, which themselves see one horizon further.
            gap.abs() < 2.0 * around.families.horizon[point]
        };
        let mut area: Vec<(u32, f64)> = (0..around.len())
            .filter(|&point| layer(point))
            .map(|point| (point as u32, side.outward() * vectors[point][side.axis]))
            .filter(|(_, area)| *area != 0.0)
            .collect();
        let exact = around.cloud.domain.area(side);
        let total: f64 = area.iter().map(|(_, a)| a).sum();
        area.iter_mut().for_each(|(_, a)| *a *= exact / total);
        effects.push(Box::new(Flux { flux: flux.clone(), area, total: exact }));
    }
    Ok(effects)
}

impl Effect for Flux {
    fn name(&self) -> &'static str {
        "prescribed-flux"
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        let flux = self.flux.at(time);
        for &(point, area) in &self.area {
            rate[point as usize] += flux * area;
        }
    }

    fn injection(&self, time: f64) -> f64 {
        self.flux.at(time) * self.total
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.flux.breakpoints().to_vec()
    }

    fn bytes(&self) -> usize {
        self.area.len() * size_of::<(u32, f64)>()
    }
}
