//! Prescribed flux through plane sides, where families see no images.
//!
//! It is spread over the layer at the side as the operator spreads it: a uniform flux is then in
//! balance with a linear pressure to rounding, whatever the operator.

use super::side_area::acting_area;
use super::{Context, Effect, EffectError, sides_with};
use crate::geometry::Side;
use crate::operators::Parity;
use crate::plan::Load;
use crate::plan::SideCondition;

/// One side: its flux over time and the area that every point presents to it.
struct Flux {
    flux: Load,
    area: Vec<(u32, f64)>,
    total: f64,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(flow) = &context.plan.flow else {
        return Ok(Vec::new());
    };
    let mut effects: Vec<Box<dyn Effect>> = Vec::new();
    for side in sides_with(context.extension, Parity::OneSided) {
        let SideCondition::Flux(flux) = &flow.sides[side.index()] else {
            continue;
        };
        let area = areas(context, side)?;
        let total = area.iter().map(|(_, area)| area).sum();
        effects.push(Box::new(Flux {
            flux: flux.clone(),
            area,
            total,
        }));
    }
    Ok(effects)
}

/// Area that every point presents to a side: what the operator itself makes of the linear function
/// normal to the side, for unit mobility, adding up to the area of the side that points touch.
fn areas<const D: usize>(
    context: &Context<'_, D>,
    side: Side,
) -> Result<Vec<(u32, f64)>, EffectError> {
    let around = context.operator.neighbourhood();
    let (cloud, horizon) = (&around.cloud, &around.families.horizon);
    let normal = |owner: usize, bond: usize| around.bond_vector(owner, bond)[side.axis];
    let force = context
        .operator
        .force(context.extension, &vec![1.0; around.len()], &normal);
    // Points feel a side through points one horizon away, which themselves see one horizon further.
    let layer = |point: usize| {
        (cloud.position[point][side.axis] - cloud.domain.plane(side)).abs() < 2.0 * horizon[point]
    };
    let mut area: Vec<(u32, f64)> = (0..around.len())
        .filter(|&point| layer(point))
        .map(|point| (point as u32, side.outward() * force[point]))
        .collect();
    // What is rounding error inside the layer is none of the side's.
    let largest = area.iter().map(|(_, area)| area.abs()).fold(0.0, f64::max);
    area.retain(|(_, area)| area.abs() > 1e-12 * largest);
    let found = area.iter().map(|(_, area)| area).sum::<f64>();
    let scale = acting_area(cloud, side, found)? / found;
    area.iter_mut().for_each(|(_, area)| *area *= scale);
    Ok(area)
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
