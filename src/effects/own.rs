//! Effects that the program hands in with the plan.

use super::{Context, Effect, EffectError, SolidContext};
use crate::geometry::Cloud;
use crate::plan::{ActsOn, Plan, Points};

pub(super) fn of_flow<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let cloud = &context.operator.neighbourhood().cloud;
    Ok(build(context.plan, cloud, ActsOn::Flow))
}

pub(super) fn of_solid<const D: usize>(
    context: &SolidContext<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let cloud = &context.elastic.around.cloud;
    Ok(build(context.plan, cloud, ActsOn::Solid))
}

fn build<const D: usize>(plan: &Plan, cloud: &Cloud<D>, acts_on: ActsOn) -> Vec<Box<dyn Effect>> {
    let wanted = |effect: &&crate::plan::OwnEffect| effect.acts_on() == acts_on;
    let position = match plan.own_effects.is_empty() {
        true => return Vec::new(),
        false => cloud.flat_positions(),
    };
    let points = Points {
        dimension: D,
        position: &position,
        volume: &cloud.volume,
    };
    let own = plan.own_effects.iter().filter(wanted);
    own.map(|effect| effect.on(&points)).collect()
}
