//! Pressure in cracks: it acts on the faces of a cut, and in the pores of a damaged band.

use super::solid::{SolidContext, SolidLoad};
use super::{Effect, EffectError};
use crate::geometry::Matrix;
use crate::operators::{Divergence, Elastic, face_areas};
use crate::plan::{CrackKind, Plan};

/// Pressures of the cracks that have one.
pub(crate) fn crack_pressures<const D: usize>(
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

/// Forces that the initial stress exerts on the faces of cuts with a pressure, shape `(n·D,)`, N: the faces carry
/// that pressure alone. Faces without one are closed, and carry the stress on.
pub(crate) fn released_faces<const D: usize>(
    plan: &Plan,
    elastic: &Elastic<D>,
    stress: impl Fn(usize) -> Matrix<D>,
) -> Vec<f64> {
    let sign = |axis: usize, image: u8| elastic.extension[axis].sign(image);
    let mut force = vec![0.0; D * elastic.points()];
    for (number, crack) in (0_u16..).zip(&plan.cracks) {
        if crack.kind != CrackKind::Cut || crack.pressure.is_none() {
            continue;
        }
        let areas = face_areas(&elastic.around, number..number + 1, sign);
        for (point, area) in areas.iter().flatten().enumerate() {
            let released = stress(point) * area;
            (0..D).for_each(|axis| force[point * D + axis] -= released[axis]);
        }
    }
    force
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
