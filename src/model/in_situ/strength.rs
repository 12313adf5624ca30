//! Whether the rock bears its in-situ stress.

use super::super::{Model, ModelError};
use crate::material::{DamageModel, eigen};

/// Refuses a tension above the strength of the rock, most often a compression with the wrong sign: what is broken
/// at rest would not be seen in anything that counts from there.
///
/// # Errors
/// [`ModelError::BrokenAtRest`] with the point that is furthest beyond.
pub(super) fn check<const D: usize>(model: &Model<D>) -> Result<(), ModelError> {
    let damaged = model.solid.as_ref().and_then(|solid| {
        let damage = solid.damage.as_ref()?;
        (damage.law.model == DamageModel::Split).then_some((solid, damage))
    });
    let Some((solid, damage)) = damaged else {
        return Ok(());
    };
    let tension = |point: usize| eigen(&damage.prestress[point]).0.max();
    let strength = |point: usize| {
        let lame = solid.elastic.lame[point];
        let modulus = lame.lambda + 2.0 * lame.mu;
        (2.0 * modulus * damage.law.peak_driving(damage.toughness[point])).sqrt()
    };
    let sound = |point: &usize| damage.initial[*point] <= 0.0;
    let beyond = (0..damage.prestress.len())
        .filter(sound)
        .map(|point| (point, tension(point), strength(point)))
        .filter(|(_, tension, strength)| tension > strength)
        .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)));
    match beyond {
        None => Ok(()),
        Some((point, tension, strength)) => Err(ModelError::BrokenAtRest {
            tension,
            strength,
            at: model.cloud.position[point].as_slice().to_vec(),
        }),
    }
}
