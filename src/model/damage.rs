//! Damage as a plan asks for it, and what a solid with damage answers.

use crate::geometry::Matrix;
use crate::material::DamageLaw;
use crate::operators::{Damage, Elastic, Response};
use crate::plan::Plan;

use super::bands::Bands;
use super::properties::Properties;
use super::{MovingWall, SolidModel};

/// Damage of points in cracks that are there from the start.
const BROKEN: f64 = 0.9999;

/// Damage with the strength of the materials, broken in the bands; `None` if the plan does not name it. The
/// initial effective stress (Pa) is the same at all points.
pub(super) fn build<const D: usize>(
    plan: &Plan,
    prestress: Option<&Matrix<D>>,
    elastic: &Elastic<D>,
    points: &Properties,
    bands: &Bands,
) -> Option<Damage<D>> {
    let damage = plan.damage.as_ref()?;
    let law = DamageLaw {
        split: damage.split,
        residual_stiffness: damage.residual_stiffness,
        hourglass: damage.hourglass,
        prestress: prestress.copied().unwrap_or_else(Matrix::zeros),
    };
    let horizon = &elastic.around.families.horizon;
    // A band as wide as the horizon sees takes 2δ G_c/ℓ per area, not G_c.
    let share = |i: usize| match damage.normalise {
        true => damage.length_scale / (2.0 * horizon[i]),
        false => 1.0,
    };
    let energies = points.fracture_energy.iter().enumerate();
    let toughness: Vec<f64> = energies
        .map(|(i, energy)| share(i) * energy / damage.length_scale)
        .collect();
    let mut initial = vec![0.0; toughness.len()];
    for point in bands.all() {
        let point = point as usize;
        initial[point] = law.history(BROKEN, toughness[point]);
    }
    Some(Damage::new(law, toughness, initial))
}

impl<const D: usize> SolidModel<D> {
    /// Response of a solid with damage to a displacement after `history`, J/m³; `None` without damage.
    pub fn response(
        &self,
        displacement: &[f64],
        walls: &[f64],
        history: &[f64],
    ) -> Option<Response<D>> {
        let difference = |owner, bond| self.difference(displacement, walls, owner, bond);
        let damage = self.damage.as_ref()?;
        let response = || damage.response(&self.elastic, history, difference);
        Some(self.timers.time("laws", response))
    }

    /// Takes the internal force off `force`, shape `(n·D,)`, N, with damage after `history` if there is
    /// any.
    pub fn subtract_force(
        &self,
        displacement: &[f64],
        walls: &[f64],
        history: &[f64],
        force: &mut [f64],
    ) {
        match self.response(displacement, walls, history) {
            Some(response) => self.subtract_internal_force(&response, force),
            None => self.subtract_internal(displacement, walls, force),
        }
    }

    /// Takes the internal force of a response off `force`, shape `(n·D,)`, N.
    pub fn subtract_internal_force(&self, response: &Response<D>, force: &mut [f64]) {
        let internal = self.elastic.gather(&response.forces);
        force
            .iter_mut()
            .zip(&internal)
            .for_each(|(f, own)| *f -= own);
    }

    /// Force that holds each wall where it is, N, by a response.
    pub fn wall_forces(&self, response: &Response<D>) -> Vec<f64> {
        let force = |wall: &MovingWall| -> f64 {
            let bonds = wall.bonds.iter();
            bonds
                .map(|&(bond, offset)| offset * response.forces[bond as usize][wall.component])
                .sum()
        };
        self.walls.iter().map(force).collect()
    }
}
