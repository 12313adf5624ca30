//! Pressure in cracks: it acts on the faces of a cut, and in the pores of a damaged band.

use super::solid::{SolidContext, SolidLoad};
use super::{Effect, EffectError};
use crate::operators::{Divergence, Elastic, face_areas};
use crate::plan::CrackKind;

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
        let kind = context.plan.cracks[usize::from(crack)].kind;
        let push: Vec<f64> = match kind {
            CrackKind::Cut => {
                let areas = face_areas(&elastic.around, crack..crack + 1, sign);
                areas
                    .iter()
                    .flatten()
                    .flat_map(|area| area.iter().map(|a| -a))
                    .collect()
            }
            // With flow the pressure is that of the fluid, and acts wherever fluid is.
            CrackKind::Damaged if context.plan.flow.is_some() => continue,
            CrackKind::Damaged => push_of(elastic, &context.bands[usize::from(crack)]),
        };
        let acting = (0_u32..).zip(push).filter(|(_, push)| *push != 0.0);
        effects.push(Box::new(SolidLoad {
            name: "crack-pressure",
            share: acting.collect(),
            load: load.clone(),
        }));
    }
    Ok(effects)
}

/// Forces of a unit pressure in the pores of some points, m^(D−1), shape `(n·D,)`.
fn push_of<const D: usize>(elastic: &Elastic<D>, points: &[u32]) -> Vec<f64> {
    let (mut weight, mut push) = (vec![0.0; elastic.points()], vec![0.0; D * elastic.points()]);
    for &point in points {
        weight[point as usize] = elastic.around.cloud.volume[point as usize];
    }
    let ones = vec![1.0; elastic.points()];
    Divergence { weight }.add_adjoint(elastic, &ones, &mut push);
    push
}
