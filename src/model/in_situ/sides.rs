//! The in-situ state against what is prescribed on sides.

use super::InSitu;
use crate::geometry::{Side, Vector};
use crate::model::{Drive, ModelError, SolidModel};
use crate::plan::{Load, Plan, Support};

/// Share of the largest stress by which a prescribed one may differ.
const SAME: f64 = 1e-6;

/// Tractions of the in-situ state on the sides that prescribe one, Pa. At the start of a run that goes on from
/// no other one they are those prescribed.
///
/// # Errors
/// [`ModelError::InitialTraction`] if they differ.
pub(super) fn tractions<const D: usize>(
    plan: &Plan,
    state: &InSitu<'_, D>,
) -> Result<Vec<(Side, Vector<D>)>, ModelError> {
    let Some(mechanics) = &plan.mechanics else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for side in Side::all(D) {
        let Support::Traction(loads) = &mechanics.sides[side.index()] else {
            continue;
        };
        if plan.start.is_none() {
            check(state, side, loads)?;
        }
        found.push((side, state.mean_traction(side)));
    }
    Ok(found)
}

/// Refuses a traction that differs from the in-situ one, with both where they differ most.
fn check<const D: usize>(
    state: &InSitu<'_, D>,
    side: Side,
    loads: &[Load],
) -> Result<(), ModelError> {
    let given: Vector<D> = Vector::from_fn(|axis, _| loads[axis].at(0.0));
    let accepted = SAME * state.level();
    let apart = |point: &usize| {
        let (x, stress) = state.on_side(*point, side);
        ((stress - given).amax(), stress, x)
    };
    let points = state.beside(side).into_iter();
    let most = points
        .map(|point| apart(&point))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, stress, x)) = most.filter(|(apart, ..)| *apart > accepted) else {
        return Ok(());
    };
    Err(ModelError::InitialTraction {
        side: side.name(),
        stress: stress.iter().copied().collect(),
        traction: given.iter().copied().collect(),
        at: x.iter().copied().collect(),
    })
}

/// Force of each wall that is a plate in the in-situ state, N along its axis; `None` for other walls.
///
/// # Errors
/// [`ModelError::InitialPlate`] if the plate begins with another force.
pub(super) fn plates<const D: usize>(
    plan: &Plan,
    state: &InSitu<'_, D>,
    solid: &SolidModel<D>,
) -> Result<Vec<Option<f64>>, ModelError> {
    let area = |side: Side| state.cloud.domain.area(side);
    let mut forces = Vec::new();
    for wall in &solid.walls {
        let Drive::Force(load) = &wall.drive else {
            forces.push(None);
            continue;
        };
        let (side, given) = (wall.side, load.at(0.0));
        let force = state.mean_traction(side)[side.axis] * area(side);
        let apart = (force - given).abs() > SAME * state.level() * area(side);
        if apart && plan.start.is_none() {
            return Err(ModelError::InitialPlate {
                side: side.name(),
                force,
                given,
            });
        }
        forces.push(Some(if plan.start.is_some() { force } else { given }));
    }
    Ok(forces)
}

impl<const D: usize> InSitu<'_, D> {
    /// Points whose cells touch a side.
    fn beside(&self, side: Side) -> Vec<usize> {
        let (cloud, plane) = (&self.cloud, self.cloud.domain.plane(side));
        let near = |i: &usize| {
            (cloud.position[*i][side.axis] - plane).abs() < 0.51 * cloud.cell[*i][side.axis]
        };
        let touching: Vec<usize> = (0..cloud.len()).filter(near).collect();
        match touching.is_empty() {
            false => touching,
            true => (0..cloud.len())
                .filter(|i| (cloud.position[*i][side.axis] - plane).abs() < cloud.spacing(*i))
                .collect(),
        }
    }

    /// Foot of a point on a side, m, and the traction σ **n** there, Pa.
    fn on_side(&self, point: usize, side: Side) -> (Vector<D>, Vector<D>) {
        let mut foot = self.cloud.position[point];
        foot[side.axis] = self.cloud.domain.plane(side);
        let stress = self.total_at(point, &foot);
        (foot, stress.column(side.axis) * side.outward())
    }

    /// Mean traction of a side, by the area of the cells that touch it, Pa.
    fn mean_traction(&self, side: Side) -> Vector<D> {
        let face = |i: usize| self.cloud.volume[i] / self.cloud.cell[i][side.axis];
        let mut sum = (Vector::zeros(), 0.0);
        for point in self.beside(side) {
            sum.0 += self.on_side(point, side).1 * face(point);
            sum.1 += face(point);
        }
        sum.0 / sum.1.max(f64::MIN_POSITIVE)
    }
}
