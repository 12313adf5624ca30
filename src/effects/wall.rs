//! Prescribed pressure on plane sides, as the affine part of the odd mirror images.

use super::{Context, Effect, EffectError, sides_with};
use crate::operators::Parity;
use crate::plan::SideCondition;
use crate::plan::Load;

/// One side: its pressure over time and what one pascal of it does to every point.
struct Wall {
    pressure: Load,
    response: Vec<(u32, f64)>,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(flow) = &context.plan.flow else { return Ok(Vec::new()) };
    let mut effects: Vec<Box<dyn Effect>> = Vec::new();
    for side in sides_with(context.extension, Parity::Odd) {
        let SideCondition::Pressure { value, .. } = &flow.sides[side.index()] else { continue };
        let mut walls = vec![0.0; 2 * D];
        walls[side.index()] = 1.0;
        let families = &context.operator.neighbourhood().families;
        let offset =
            |_: usize, bond: usize| context.extension.wall_offset(families.image(bond), &walls);
        let force = context.operator.force(context.extension, context.mobility, &offset);
        let response = (0_u32..).zip(force).filter(|(_, f)| *f != 0.0).map(|(i, f)| (i, -f));
        effects.push(Box::new(Wall { pressure: value.clone(), response: response.collect() }));
    }
    Ok(effects)
}

impl Effect for Wall {
    fn name(&self) -> &'static str {
        "prescribed-pressure"
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        let pressure = self.pressure.at(time);
        for &(point, response) in &self.response {
            rate[point as usize] += pressure * response;
        }
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.pressure.breakpoints().to_vec()
    }

    fn bytes(&self) -> usize {
        self.response.len() * size_of::<(u32, f64)>()
    }
}
