//! Internal forces of a solid with damage (Eq. 58 with Eqs. 30, 31 and 53).

use std::sync::atomic::{AtomicU64, Ordering};

use super::{Elastic, point_value};
use crate::geometry::{Matrix, Vector};
use crate::material::{
    CrackPlane, DamageLaw, DamageModel, PointResponse, PointState, Tangent, TangentKind,
};
use crate::parallel::{self, by_ranges};

/// Damage at all points.
#[derive(Debug)]
pub struct Damage<const D: usize> {
    /// The law.
    pub law: DamageLaw,
    /// Strength c per point, J/m³, shape `(n,)`.
    pub toughness: Vec<f64>,
    /// G_c per point, J/m², shape `(n,)`; empty where the length of cracks does not follow from what they took.
    pub fracture_energy: Vec<f64>,
    /// Effective stress before the run, Pa, shape `(n,)`; empty where there is none.
    pub prestress: Vec<Matrix<D>>,
    /// Largest driving energy before the run, J/m³, shape `(n,)`: cracks that are there from the start.
    pub initial: Vec<f64>,
    /// Normals of those cracks, shape `(n·D,)`, zero elsewhere; empty in the model of the paper.
    pub initial_normal: Vec<f64>,
    evaluations: AtomicU64,
}

/// What a state tells about the damage of its points.
#[derive(Debug, Clone, Copy)]
pub struct DamageFields<'a> {
    /// Largest driving energy, J/m³, shape `(n,)`.
    pub history: &'a [f64],
    /// Settled normals of cracks, shape `(n·D,)`, zero where they are not; may be empty.
    pub normal: &'a [f64],
    /// What the fluid adds to the effective traction on a crack, Pa, shape `(n,)`; empty without fluid.
    pub fluid: &'a [f64],
}

/// How a damaged solid responds to a displacement.
#[derive(Debug, Clone)]
pub struct Response<const D: usize> {
    /// Forces on the ends of all bonds, N, shape `(bonds,)`.
    pub forces: Vec<Vector<D>>,
    /// Strain per point, shape `(n,)`.
    pub strain: Vec<Matrix<D>>,
    /// Effective stress per point, Pa, shape `(n,)`.
    pub stress: Vec<Matrix<D>>,
    /// Driving energy per point, J/m³, shape `(n,)`.
    pub driving: Vec<f64>,
    /// Damage per point, shape `(n,)`.
    pub damage: Vec<f64>,
    /// What the fluid added to the effective traction on a crack, Pa, shape `(n,)`; empty without fluid.
    pub fluid: Vec<f64>,
    /// Planes of cracks, shape `(n,)`; empty in the model of the paper.
    pub planes: Vec<CrackPlane<D>>,
    /// Share of the hourglass stiffness that is left per family, shape `(n,)`.
    pub hourglass: Vec<f64>,
    /// Hourglass energy per family that drives no damage, J, shape `(n,)`.
    pub hourglass_energy: Vec<f64>,
    /// Energy of strain and what damage took, without what is in `hourglass_energy`, J (per metre of thickness in
    /// 2-D).
    pub bulk: f64,
}

impl<const D: usize> Response<D> {
    /// Energy with the given shares of the hourglass term left (shape `(n,)`), J.
    ///
    /// Where Eq. 53 weakens that term without being driven by its energy, the force is the derivative of
    /// this energy at fixed shares only.
    pub fn energy(&self, hourglass: &[f64]) -> f64 {
        let hourglass_energy = self
            .hourglass_energy
            .iter()
            .zip(hourglass)
            .map(|(hourglass_energy, left)| left * hourglass_energy);
        self.bulk + hourglass_energy.sum::<f64>()
    }

    /// A response of no points yet.
    fn with_capacity(forces: Vec<Vector<D>>, points: usize) -> Self {
        Response {
            forces,
            strain: Vec::with_capacity(points),
            stress: Vec::with_capacity(points),
            driving: Vec::with_capacity(points),
            damage: Vec::with_capacity(points),
            fluid: Vec::new(),
            planes: Vec::new(),
            hourglass: Vec::with_capacity(points),
            hourglass_energy: Vec::with_capacity(points),
            bulk: 0.0,
        }
    }
}

impl<const D: usize> Damage<D> {
    /// Damage with the given law and strength.
    pub fn new(law: DamageLaw, toughness: Vec<f64>, initial: Vec<f64>) -> Self {
        Damage {
            law,
            toughness,
            fracture_energy: Vec::new(),
            prestress: Vec::new(),
            initial,
            initial_normal: Vec::new(),
            evaluations: AtomicU64::new(0),
        }
    }

    /// What a point is and what it has been through.
    pub fn point(
        &self,
        elastic: &Elastic<D>,
        fields: DamageFields<'_>,
        owner: usize,
    ) -> PointState<D> {
        let normal: Vector<D> = match fields.normal.is_empty() {
            true => Vector::zeros(),
            false => point_value(fields.normal, owner),
        };
        PointState {
            lame: elastic.lame[owner],
            toughness: self.toughness[owner],
            history: fields.history[owner],
            prestress: (self.prestress.get(owner).copied()).unwrap_or_else(Matrix::zeros),
            normal: (normal.norm_squared() > 0.0).then_some(normal),
            fluid: fields.fluid.get(owner).copied().unwrap_or(0.0),
        }
    }

    /// Response to bond differences `difference(owner, bond)` in m.
    pub fn response(
        &self,
        elastic: &Elastic<D>,
        fields: DamageFields<'_>,
        difference: impl Fn(usize, usize) -> Vector<D> + Sync,
    ) -> Response<D> {
        let families = &elastic.around.families;
        let mut forces = vec![Vector::zeros(); families.bonds()];
        let points = by_ranges(families.offsets(), &mut forces, |owner, forces| {
            let mut seen = None;
            let difference = |bond| difference(owner, bond);
            let response = |strain: &Matrix<D>, hourglass_energy: f64| {
                let point = self.point(elastic, fields, owner);
                let density = hourglass_energy / elastic.around.cloud.volume[owner];
                let response = self.law.response(&point, strain, density);
                seen = Some((*strain, response));
                (response.stress, response.hourglass)
            };
            let hourglass_energy = elastic.family_response(owner, difference, response, forces);
            (seen, hourglass_energy)
        });
        let mut response = Response::with_capacity(forces, points.len());
        response.fluid.extend_from_slice(fields.fluid);
        let (mut evaluated, variational) = (0, self.law.is_variational());
        for (owner, (seen, hourglass_energy)) in points.into_iter().enumerate() {
            let Some((strain, point)) = seen else {
                continue;
            };
            evaluated += 1;
            let volume = elastic.around.cloud.volume[owner];
            response.bulk += volume * point.energy;
            let apart = if variational { 0.0 } else { hourglass_energy };
            response.hourglass_energy.push(apart);
            response.strain.push(strain);
            self.take(&mut response, point);
        }
        self.evaluations.fetch_add(evaluated, Ordering::Relaxed);
        response
    }

    fn take(&self, response: &mut Response<D>, point: PointResponse<D>) {
        response.stress.push(point.stress);
        response.hourglass.push(point.hourglass);
        response.driving.push(point.driving);
        response.damage.push(point.damage);
        if self.law.model == DamageModel::Split {
            response.planes.push(point.plane);
        }
    }

    /// Tangents at a response.
    pub fn tangents(
        &self,
        elastic: &Elastic<D>,
        fields: DamageFields<'_>,
        response: &Response<D>,
        softening: TangentKind,
    ) -> Vec<Tangent<D>> {
        let at = |owner: usize| {
            let point = self.point(elastic, fields, owner);
            self.law.tangent(
                &point,
                response.driving[owner],
                &response.strain[owner],
                softening,
            )
        };
        parallel::map(response.strain.len(), at)
    }

    /// Derivative of the driving energy of a family, J, by its bond differences, m, into `drive`, which
    /// has one vector per bond of the family, N.
    pub fn drive(
        &self,
        elastic: &Elastic<D>,
        fields: DamageFields<'_>,
        response: &Response<D>,
        owner: usize,
        drive: &mut [Vector<D>],
    ) {
        let volume = elastic.around.cloud.volume[owner];
        let direction = match response.planes.get(owner) {
            Some(plane) => plane.released,
            None => {
                let point = self.point(elastic, fields, owner);
                self.law
                    .parts(&point, &response.strain[owner])
                    .degraded_stress
            }
        } * volume;
        let stress = response.stress[owner] * volume;
        let left = response.hourglass[owner];
        let family = elastic.around.families.family(owner);
        for (bond, drive) in family.zip(drive) {
            let weight = &elastic.gradient.weight[bond];
            *drive = direction * weight;
            if self.law.is_variational() {
                *drive += (response.forces[bond] - stress * weight) / left;
            }
        }
    }

    /// Raises `history` (J/m³, shape `(n,)`) to what a response drove.
    pub fn advance(&self, driving: &[f64], history: &mut [f64]) {
        for (history, driving) in history.iter_mut().zip(driving) {
            *history = history.max(*driving);
        }
    }

    /// Settles the normals (shape `(n·D,)`) of points that a response has broken.
    pub fn settle(&self, response: &Response<D>, normal: &mut [f64]) {
        let own = normal.chunks_mut(D).zip(&response.planes);
        for ((own, plane), damage) in own.zip(&response.damage) {
            if *damage > SETTLED && own.iter().all(|n| *n == 0.0) {
                own.copy_from_slice(plane.normal.as_slice());
            }
        }
    }

    /// Damage per point after `history`, shape `(n,)`.
    pub fn of(&self, history: &[f64]) -> Vec<f64> {
        let pairs = history.iter().zip(&self.toughness);
        pairs
            .map(|(history, toughness)| self.law.damage(*history, *toughness))
            .collect()
    }

    /// Energy that damage took since the start, Σ V c s² without that of the initial cracks, J
    /// (per metre of thickness in 2-D).
    pub fn dissipated(&self, volume: &[f64], history: &[f64]) -> f64 {
        let taken = |i: usize| {
            let at = |history: f64| self.law.damage(history, self.toughness[i]).powi(2);
            volume[i] * self.toughness[i] * (at(history[i]) - at(self.initial[i]))
        };
        (0..volume.len()).map(taken).sum()
    }

    /// Area of new cracks by what damage took, Σ V c s²/G_c, m² (length in 2-D, m); `None` where strength does not follow
    /// from G_c and the widths of families.
    pub fn area(&self, volume: &[f64], history: &[f64]) -> Option<f64> {
        let taken = |(i, energy): (usize, &f64)| {
            let at = |history: f64| self.law.damage(history, self.toughness[i]).powi(2);
            let grown = (at(history[i]) - at(self.initial[i])).max(0.0);
            volume[i] * self.toughness[i] * grown / energy
        };
        let energies = self.fracture_energy.iter().enumerate();
        (!self.fracture_energy.is_empty()).then(|| energies.map(taken).sum())
    }

    /// How often points were evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let scalars = self.toughness.len()
            + self.fracture_energy.len()
            + self.initial.len()
            + self.initial_normal.len();
        8 * (scalars + D * D * self.prestress.len())
    }
}

/// Damage beyond which the normal of a crack no longer turns. Cracks are the same with normals that turn for ever
/// *(prototype)*.
const SETTLED: f64 = 2.0 / 3.0;
