//! Damage as a plan asks for it.

use crate::effects::tensor;
use crate::geometry::Matrix;
use crate::material::DamageLaw;
use crate::operators::{Damage, Elastic};
use crate::plan::{MechanicsPlan, Plan};

use super::bands::Bands;
use super::properties::Properties;

/// Damage of points in cracks that are there from the start.
const BROKEN: f64 = 0.9999;

/// Damage with the strength of the materials, broken in the bands; `None` if the plan does not name it.
pub(super) fn build<const D: usize>(
    plan: &Plan,
    mechanics: &MechanicsPlan,
    elastic: &Elastic<D>,
    points: &Properties,
    bands: &Bands,
) -> Option<Damage<D>> {
    let damage = plan.damage.as_ref()?;
    let law = DamageLaw {
        split: damage.split,
        residual_stiffness: damage.residual_stiffness,
        hourglass: damage.hourglass,
        prestress: (mechanics.initial_stress.as_ref()).map_or_else(Matrix::zeros, tensor),
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
