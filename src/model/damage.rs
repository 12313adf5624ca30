//! Damage as a plan asks for it, and what a solid with damage answers.

use crate::effects::tensor;
use crate::geometry::{Cloud, Families, Matrix};
use crate::material::DamageLaw;
use crate::operators::{BandLaw, Damage, Elastic, FamilyWidths, Response};
use crate::plan::{MechanicsPlan, Normalise, Plan};

use super::bands::Bands;
use super::properties::Properties;
use super::{MovingWall, SolidModel};

/// Damage of points in cracks that are there from the start.
const BROKEN: f64 = 0.9999;

/// The law of damage of a plan; `None` if the plan does not name it.
pub(super) fn law<const D: usize>(plan: &Plan, mechanics: &MechanicsPlan) -> Option<DamageLaw<D>> {
    let damage = plan.damage.as_ref()?;
    Some(DamageLaw {
        split: damage.split,
        residual_stiffness: damage.residual_stiffness,
        hourglass: damage.hourglass,
        prestress: (mechanics.initial_stress.as_ref()).map_or_else(Matrix::zeros, tensor),
    })
}

/// What breaking costs by `law`.
pub(super) fn band_law<const D: usize>(law: DamageLaw<D>, mechanics: &MechanicsPlan) -> BandLaw {
    let energy = move |driving: f64| {
        let damage = law.damage(driving, 1.0);
        law.degradation(damage) * driving + damage * damage
    };
    BandLaw {
        hourglass: mechanics.hourglass * law.driving_part(1.0),
        energy: Box::new(energy),
    }
}

/// Effective widths of the families, where strength follows from them; `families` have all their images.
pub(super) fn widths<const D: usize>(
    plan: &Plan,
    mechanics: &MechanicsPlan,
    cloud: &Cloud<D>,
    families: &Families<D>,
    points: &Properties,
) -> Option<FamilyWidths<D>> {
    match plan.damage.as_ref()?.normalise {
        Normalise::Off | Normalise::Horizon => None,
        Normalise::Mean => {
            let law = band_law(law::<D>(plan, mechanics)?, mechanics);
            let (influence, lame) = (plan.influence, &points.lame);
            Some(FamilyWidths::new(cloud, families, influence, lame, &law))
        }
    }
}

/// Damage with the strength of the materials, broken in the bands; `None` if the plan does not name it.
pub(super) fn build<const D: usize>(
    plan: &Plan,
    mechanics: &MechanicsPlan,
    elastic: &Elastic<D>,
    widths: Option<&FamilyWidths<D>>,
    points: &Properties,
    bands: &Bands,
) -> Option<Damage<D>> {
    let damage = plan.damage.as_ref()?;
    let law = law(plan, mechanics)?;
    let horizon = &elastic.around.families.horizon;
    // A band as wide as the horizon sees takes c 2δ per area, or c W by what its points hold.
    let width = |i: usize| match (damage.normalise, widths) {
        (Normalise::Off, _) => damage.length_scale,
        (Normalise::Mean, Some(widths)) => widths.mean(i),
        (Normalise::Horizon | Normalise::Mean, _) => 2.0 * horizon[i],
    };
    let energies = points.fracture_energy.iter().enumerate();
    let toughness: Vec<f64> = energies.map(|(i, energy)| energy / width(i)).collect();
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
