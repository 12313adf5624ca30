//! The in-situ state: stress and pore pressure that are in equilibrium before the run.
//!
//! With the total stress σ = σ′ − α p I it holds ∇·σ + ρ **g** + **b** = 0 inside, and the tractions σ **n** on
//! all sides. The first is checked, the second is implied: what is left of the discrete forces at u = 0 is
//! balanced once, so that nothing moves as long as nothing changes, and displacements count from here.

mod balance;
mod field;
mod overburden;
mod sides;
mod strength;

pub(super) use field::InSitu;

use std::sync::Arc;

use super::{Model, ModelError, SolidModel};
use crate::effects::{initial_force, loaded_side, released_faces};
use crate::geometry::{Side, Vector};
use crate::plan::Plan;

/// Loads that belong to the in-situ state; all others are added to it.
const PARTS: [&str; 3] = ["traction", "body-force", "weight"];

/// Checks the in-situ state of a model and balances it.
///
/// # Errors
/// [`ModelError::UnbalancedStress`] if it is not in equilibrium inside, [`ModelError::BrokenAtRest`] if rock does not
/// bear it, [`ModelError::InitialTraction`] and
/// [`ModelError::InitialPlate`] if not with what is prescribed on a side.
pub(super) fn balance<const D: usize>(
    plan: &Plan,
    state: &InSitu<'_, D>,
    model: &mut Model<D>,
) -> Result<(), ModelError> {
    balance::check(plan, state)?;
    strength::check(model)?;
    let Some(solid) = &model.solid else {
        return Ok(());
    };
    // A run that goes on from another one begins with loads that have changed since the in-situ state.
    let tractions = sides::tractions(plan, state)?;
    let tractions = plan.start.as_ref().map(|_| &tractions[..]);
    let implied = implied(plan, state, model, solid, tractions)?;
    let plates = sides::plates(plan, state, solid)?;
    let coupled = model.coupling.as_ref().and(model.flow.as_ref());
    let pressure = coupled.map_or(&[][..], |flow| &flow.initial);
    let rest = (vec![0.0; solid.unknowns()], vec![0.0; solid.walls.len()]);
    let held = solid.internal_wall_force(&rest.0, &rest.1, pressure);
    let Some(solid) = model.solid.as_mut().and_then(Arc::get_mut) else {
        return Ok(());
    };
    solid.implied = implied;
    solid.in_situ_force = state.force();
    for ((wall, held), plate) in solid.walls.iter_mut().zip(held).zip(plates) {
        wall.implied = plate.map_or(0.0, |force| held - force);
    }
    model.level = model.level.max(state.level());
    Ok(())
}

/// What balances the forces at u = 0 and the pressure at the start, shape `(n·D,)`, N. `tractions` stand in for
/// those that sides have at the start of this run.
fn implied<const D: usize>(
    plan: &Plan,
    state: &InSitu<'_, D>,
    model: &Model<D>,
    solid: &SolidModel<D>,
    tractions: Option<&[(Side, Vector<D>)]>,
) -> Result<Vec<f64>, ModelError> {
    let mut force = vec![0.0; solid.unknowns()];
    for effect in solid.effects.iter().map(|effect| effect.effect()) {
        let stands_in = tractions.is_some() && effect.name() == "traction";
        if PARTS.contains(&effect.name()) && !stands_in {
            effect.add_rate(0.0, &mut force);
        }
    }
    for (side, traction) in tractions.unwrap_or_default() {
        let area = loaded_side(&solid.elastic, *side)?;
        let pushes = area
            .iter()
            .flat_map(|a| traction.iter().map(move |t| a * t));
        force
            .iter_mut()
            .zip(pushes)
            .for_each(|(f, push)| *f += push);
    }
    if let (Some(coupling), Some(flow)) = (&model.coupling, &model.flow) {
        coupling.add_pressure_force(solid, &flow.initial, &mut force);
    }
    // Only the law of damage contains the initial stress; K u is its change.
    if solid.damage.is_some() {
        let stress = initial_force(&solid.elastic, &solid.initial_stress);
        force.iter_mut().zip(stress).for_each(|(f, own)| *f += own);
    }
    let released = released_faces(plan, &solid.elastic, |point| state.total_tensor(point));
    let pairs = force.into_iter().zip(released);
    Ok(pairs.map(|(force, released)| released - force).collect())
}
