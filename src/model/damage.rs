//! Damage as a plan asks for it, and what a solid with damage answers.

use crate::effects::vector;
use crate::geometry::{Cloud, Crack, Families, Matrix, Vector};
use crate::material::{CrackPlane, DamageLaw, DamageModel};
use crate::operators::{BandLaw, Damage, DamageFields, Elastic, FamilyWidths, Response};
use crate::plan::{CrackPlace, CrackPlan, MechanicsPlan, Normalise, Plan};

use super::bands::Bands;
use super::properties::Properties;
use super::{MovingWall, SolidModel};

/// Damage of points in cracks that are there from the start.
const BROKEN: f64 = 0.9999;

/// The law of damage of a plan; `None` if the plan does not name it.
pub(super) fn law(plan: &Plan) -> Option<DamageLaw> {
    let damage = plan.damage.as_ref()?;
    Some(DamageLaw {
        model: damage.model,
        exponent: damage.exponent,
        friction: damage.friction,
        split: damage.split,
        residual_stiffness: damage.residual_stiffness,
        hourglass: damage.hourglass,
    })
}

/// What breaking costs by `law`.
pub(super) fn band_law(law: DamageLaw, mechanics: &MechanicsPlan) -> BandLaw {
    let energy = move |driving: f64| {
        let damage = law.damage(driving, 1.0);
        law.degradation(damage) * driving + damage * damage
    };
    let drives = if law.is_variational() { 1.0 } else { 0.0 };
    BandLaw {
        hourglass: mechanics.hourglass * drives,
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
            let law = band_law(law(plan)?, mechanics);
            let (influence, lame) = (plan.influence, &points.lame);
            Some(FamilyWidths::new(cloud, families, influence, lame, &law))
        }
    }
}

/// Damage with the strength of the materials, broken in the bands; `None` if the plan does not name it.
pub(super) fn build<const D: usize>(
    plan: &Plan,
    prestress: &[Matrix<D>],
    elastic: &Elastic<D>,
    widths: Option<&FamilyWidths<D>>,
    points: &Properties,
    bands: &Bands,
) -> Option<Damage<D>> {
    let damage = plan.damage.as_ref()?;
    let law = law(plan)?;
    let horizon = &elastic.around.families.horizon;
    // A band as wide as the horizon sees takes c 2δ per area, or c W by what its points hold.
    let width = |i: usize| match (damage.normalise, widths) {
        (Normalise::Off, _) => damage.length_scale.unwrap_or(2.0 * horizon[i]),
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
    let mut built = Damage::new(law, toughness, initial);
    built.prestress = prestress.to_vec();
    if damage.normalise == Normalise::Mean {
        built.fracture_energy.clone_from(&points.fracture_energy);
    }
    if law.model == DamageModel::Split {
        built.initial_normal = normals(plan, elastic, bands);
    }
    Some(built)
}

/// Normals of the cracks that are there from the start, shape `(n·D,)`, zero elsewhere: that of the nearest one.
fn normals<const D: usize>(plan: &Plan, elastic: &Elastic<D>, bands: &Bands) -> Vec<f64> {
    let cloud = &elastic.around.cloud;
    let mut normals = vec![0.0; D * cloud.len()];
    let mut nearest = vec![f64::INFINITY; cloud.len()];
    for (crack, band) in plan.cracks.iter().zip(&bands.points) {
        for &point in band {
            let point = point as usize;
            let Some((distance, normal)) = crack_normal(crack, &cloud.position[point]) else {
                continue;
            };
            if distance < nearest[point] {
                nearest[point] = distance;
                normals[point * D..][..D].copy_from_slice(normal.as_slice());
            }
        }
    }
    normals
}

/// Distance to the nearest part of a crack, m, and the unit normal there.
fn crack_normal<const D: usize>(crack: &CrackPlan, x: &Vector<D>) -> Option<(f64, Vector<D>)> {
    match &crack.place {
        CrackPlace::Chain(points) => {
            let chain = Crack {
                points: points.iter().map(|x| vector(x)).collect(),
            };
            chain.nearest(x)
        }
        CrackPlace::Disc { centre, normal, .. } => {
            let normal = vector::<D>(normal);
            Some(((x - vector(centre)).dot(&normal).abs(), normal))
        }
    }
}

impl<const D: usize> SolidModel<D> {
    /// Response of a solid with damage to a displacement; `None` without damage.
    pub fn response(
        &self,
        displacement: &[f64],
        walls: &[f64],
        fields: DamageFields<'_>,
    ) -> Option<Response<D>> {
        let difference = |owner, bond| self.difference(displacement, walls, owner, bond);
        let damage = self.damage.as_ref()?;
        let response = || damage.response(&self.elastic, fields, difference);
        Some(self.timers.time("laws", response))
    }

    /// Forces that what cracks have released would exert on the points, shape `(n·D,)`, N: the push of the fluid in
    /// them and the stress that they lost. Empty where nothing is open, and in the model of the paper.
    pub fn crack_force(&self, response: &Response<D>) -> Vec<f64> {
        let is_open = |plane: &CrackPlane<D>| plane.open && plane.opening > 0.0;
        if !response.planes.iter().any(is_open) {
            return Vec::new();
        }
        let (elastic, families) = (&self.elastic, &self.elastic.around.families);
        let mut forces = vec![Vector::zeros(); families.bonds()];
        for (i, plane) in response.planes.iter().enumerate().filter(|(_, p)| p.open) {
            let lost = 1.0 - response.hourglass[i];
            let stress = plane.released * (lost * elastic.around.cloud.volume[i]);
            let family = families.family(i);
            let weights = &elastic.gradient.weight[family.clone()];
            for (force, weight) in forces[family].iter_mut().zip(weights) {
                *force = stress * weight;
            }
        }
        elastic.gather(&forces)
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
