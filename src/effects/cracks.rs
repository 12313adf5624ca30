//! Pressure in cracks that are cut: it acts on their faces.

use super::solid::{SolidContext, SolidLoad};
use super::{Effect, EffectError};
use crate::operators::face_areas;

/// Pressures of the cracks that have one.
pub fn crack_pressures<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let elastic = context.elastic;
    let sign = |axis: usize, image: u8| elastic.extension[axis].sign(image);
    let cracks = (0_u16..).zip(&context.plan.cracks);
    let pressed = cracks.filter_map(|(number, crack)| Some((number, crack.pressure.as_ref()?)));
    let mut effects: Vec<Box<dyn Effect>> = Vec::new();
    for (crack, load) in pressed {
        let areas = face_areas(&elastic.around, crack..crack + 1, sign);
        let components = areas.iter().flatten().flat_map(|area| area.iter());
        let acting = (0_u32..).zip(components).filter(|(_, area)| **area != 0.0);
        effects.push(Box::new(SolidLoad {
            name: "crack-pressure",
            share: acting.map(|(unknown, area)| (unknown, -area)).collect(),
            load: load.clone(),
        }));
    }
    Ok(effects)
}
