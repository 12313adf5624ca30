//! Internal forces of a solid with damage (Eq. 58 with Eqs. 30, 31 and 53).

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::Elastic;
use crate::geometry::{Matrix, Vector};
use crate::material::{DamageLaw, HourglassRule, PointResponse, Tangent, TangentKind};
use crate::parallel::by_ranges;

/// Damage at all points.
#[derive(Debug)]
pub struct Damage<const D: usize> {
    /// The law.
    pub law: DamageLaw<D>,
    /// G_c/ℓ per point, J/m³, shape `(n,)`.
    pub toughness: Vec<f64>,
    /// Largest driving energy before the run, J/m³, shape `(n,)`: cracks that are there from the start.
    pub initial: Vec<f64>,
    evaluations: AtomicU64,
}

/// How a damaged solid responds to a displacement.
#[derive(Debug, Clone)]
pub struct Response<const D: usize> {
    /// Forces on the ends of all bonds, N, shape `(bonds,)`.
    pub forces: Vec<Vector<D>>,
    /// Strain per point, shape `(n,)`.
    pub strain: Vec<Matrix<D>>,
    /// Driving energy per point, J/m³, shape `(n,)`.
    pub driving: Vec<f64>,
    /// Damage per point, shape `(n,)`.
    pub damage: Vec<f64>,
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
}

impl<const D: usize> Damage<D> {
    /// Damage with the given law and strength.
    pub fn new(law: DamageLaw<D>, toughness: Vec<f64>, initial: Vec<f64>) -> Self {
        Damage {
            law,
            toughness,
            initial,
            evaluations: AtomicU64::new(0),
        }
    }

    /// Response of one point with the hourglass energy of its family, J.
    pub fn at(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        owner: usize,
        strain: &Matrix<D>,
        hourglass_energy: f64,
    ) -> PointResponse<D> {
        let (lame, toughness) = (elastic.lame[owner], self.toughness[owner]);
        let hourglass_energy = hourglass_energy / elastic.around.cloud.volume[owner];
        self.law
            .response(lame, toughness, history[owner], strain, hourglass_energy)
    }

    /// Response to bond differences `difference(owner, bond)` in m after `history` (shape `(n,)`, J/m³).
    pub fn response(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        difference: impl Fn(usize, usize) -> Vector<D> + Sync,
    ) -> Response<D> {
        let families = &elastic.around.families;
        let mut forces = vec![Vector::zeros(); families.bonds()];
        let points = by_ranges(families.offsets(), &mut forces, |owner, forces| {
            let mut seen = None;
            let difference = |bond| difference(owner, bond);
            let response = |strain: &Matrix<D>, hourglass_energy: f64| {
                let point = self.at(elastic, history, owner, strain, hourglass_energy);
                seen = Some((*strain, point));
                (point.stress, self.law.hourglass(point.damage))
            };
            let hourglass_energy = elastic.family_response(owner, difference, response, forces);
            (seen, hourglass_energy)
        });
        let mut response = Response {
            forces,
            strain: Vec::with_capacity(points.len()),
            driving: Vec::with_capacity(points.len()),
            damage: Vec::with_capacity(points.len()),
            hourglass: Vec::with_capacity(points.len()),
            hourglass_energy: Vec::with_capacity(points.len()),
            bulk: 0.0,
        };
        let mut evaluated = 0;
        for (owner, (seen, hourglass_energy)) in points.into_iter().enumerate() {
            let Some((strain, point)) = seen else {
                continue;
            };
            evaluated += 1;
            let volume = elastic.around.cloud.volume[owner];
            response.bulk += volume * point.energy;
            response.hourglass.push(self.law.hourglass(point.damage));
            response.hourglass_energy.push(match self.law.hourglass {
                HourglassRule::Variational => 0.0,
                HourglassRule::Linear => hourglass_energy,
            });
            response.strain.push(strain);
            response.driving.push(point.driving);
            response.damage.push(point.damage);
        }
        self.evaluations.fetch_add(evaluated, Ordering::Relaxed);
        response
    }

    /// Tangents at a response.
    pub fn tangents(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        response: &Response<D>,
        softening: TangentKind,
    ) -> Vec<Tangent<D>> {
        let at = |(owner, strain): (usize, &Matrix<D>)| {
            let (lame, toughness) = (elastic.lame[owner], self.toughness[owner]);
            let seen = (history[owner], response.driving[owner]);
            self.law.tangent(lame, toughness, seen, strain, softening)
        };
        response.strain.par_iter().enumerate().map(at).collect()
    }

    /// Derivative of the driving energy of a family, J, by its bond differences, m, into `drive`, which
    /// has one vector per bond of the family, N.
    pub fn drive(
        &self,
        elastic: &Elastic<D>,
        response: &Response<D>,
        owner: usize,
        drive: &mut [Vector<D>],
    ) {
        let parts = self.law.parts(elastic.lame[owner], &response.strain[owner]);
        let volume = elastic.around.cloud.volume[owner];
        let (degraded_stress, intact_stress) =
            (parts.degraded_stress * volume, parts.intact_stress * volume);
        let left = self.law.degradation(response.damage[owner]);
        let family = elastic.around.families.family(owner);
        for (bond, drive) in family.zip(drive) {
            let weight = &elastic.gradient.weight[bond];
            *drive = match self.law.hourglass {
                HourglassRule::Variational => {
                    (response.forces[bond] - intact_stress * weight) / left
                }
                HourglassRule::Linear => degraded_stress * weight,
            };
        }
    }

    /// Raises `history` (J/m³, shape `(n,)`) to what a response drove.
    pub fn advance(&self, driving: &[f64], history: &mut [f64]) {
        for (history, driving) in history.iter_mut().zip(driving) {
            *history = history.max(*driving);
        }
    }

    /// Damage per point after `history`, shape `(n,)`.
    pub fn of(&self, history: &[f64]) -> Vec<f64> {
        let pairs = history.iter().zip(&self.toughness);
        pairs
            .map(|(history, toughness)| self.law.damage(*history, *toughness))
            .collect()
    }

    /// Energy that damage took since the start, Σ V (G_c/ℓ) s² without that of the initial cracks, J
    /// (per metre of thickness in 2-D).
    pub fn dissipated(&self, volume: &[f64], history: &[f64]) -> f64 {
        let taken = |i: usize| {
            let at = |history: f64| self.law.damage(history, self.toughness[i]).powi(2);
            volume[i] * self.toughness[i] * (at(history[i]) - at(self.initial[i]))
        };
        (0..volume.len()).map(taken).sum()
    }

    /// How often points were evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        8 * (self.toughness.len() + self.initial.len())
    }
}
