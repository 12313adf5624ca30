//! Internal forces of a solid with damage (Eq. 58 with Eqs. 30, 31 and 53).

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::Elastic;
use crate::geometry::{Matrix, Vector};
use crate::material::{DamageLaw, HourglassRule, PointAnswer, Softening, Tangent};
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

/// What a damaged solid answers to a displacement.
#[derive(Debug, Clone)]
pub struct Answer<const D: usize> {
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
    pub rough: Vec<f64>,
    /// Energy of strain and what damage took, without what is in `rough`, J (per metre of thickness in
    /// 2-D).
    pub bulk: f64,
}

impl<const D: usize> Answer<D> {
    /// Energy with the given shares of the hourglass term left (shape `(n,)`), J.
    ///
    /// Where Eq. 53 weakens that term without being driven by its energy, the force is the derivative of
    /// this energy at fixed shares only.
    pub fn energy(&self, hourglass: &[f64]) -> f64 {
        let rough = self
            .rough
            .iter()
            .zip(hourglass)
            .map(|(rough, left)| left * rough);
        self.bulk + rough.sum::<f64>()
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

    /// Answer of one point with the hourglass energy `rough` of its family, J.
    pub fn at(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        owner: usize,
        strain: &Matrix<D>,
        rough: f64,
    ) -> PointAnswer<D> {
        let (lame, toughness) = (elastic.lame[owner], self.toughness[owner]);
        let rough = rough / elastic.around.cloud.volume[owner];
        self.law
            .answer(lame, toughness, history[owner], strain, rough)
    }

    /// Answer to bond differences `difference(owner, bond)` in m after `history` (shape `(n,)`, J/m³).
    pub fn answer(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        difference: impl Fn(usize, usize) -> Vector<D> + Sync,
    ) -> Answer<D> {
        let families = &elastic.around.families;
        let mut forces = vec![Vector::zeros(); families.bonds()];
        let points = by_ranges(families.offsets(), &mut forces, |owner, forces| {
            let mut seen = None;
            let difference = |bond| difference(owner, bond);
            let answer = |strain: &Matrix<D>, rough: f64| {
                let point = self.at(elastic, history, owner, strain, rough);
                seen = Some((*strain, point));
                (point.stress, self.law.hourglass(point.damage))
            };
            let rough = elastic.family_answer(owner, difference, answer, forces);
            (seen, rough)
        });
        let mut answer = Answer {
            forces,
            strain: Vec::with_capacity(points.len()),
            driving: Vec::with_capacity(points.len()),
            damage: Vec::with_capacity(points.len()),
            hourglass: Vec::with_capacity(points.len()),
            rough: Vec::with_capacity(points.len()),
            bulk: 0.0,
        };
        let mut evaluated = 0;
        for (owner, (seen, rough)) in points.into_iter().enumerate() {
            let Some((strain, point)) = seen else {
                continue;
            };
            evaluated += 1;
            let volume = elastic.around.cloud.volume[owner];
            answer.bulk += volume * point.energy;
            answer.hourglass.push(self.law.hourglass(point.damage));
            answer.rough.push(match self.law.hourglass {
                HourglassRule::Variational => 0.0,
                HourglassRule::Linear => rough,
            });
            answer.strain.push(strain);
            answer.driving.push(point.driving);
            answer.damage.push(point.damage);
        }
        self.evaluations.fetch_add(evaluated, Ordering::Relaxed);
        answer
    }

    /// Tangents at an answer.
    pub fn tangents(
        &self,
        elastic: &Elastic<D>,
        history: &[f64],
        answer: &Answer<D>,
        softening: Softening,
    ) -> Vec<Tangent<D>> {
        let at = |(owner, strain): (usize, &Matrix<D>)| {
            let (lame, toughness) = (elastic.lame[owner], self.toughness[owner]);
            let seen = (history[owner], answer.driving[owner]);
            self.law.tangent(lame, toughness, seen, strain, softening)
        };
        answer.strain.par_iter().enumerate().map(at).collect()
    }

    /// Derivative of the driving energy of a family, J, by its bond differences, m, into `drive`, which
    /// has one vector per bond of the family, N.
    pub fn drive(
        &self,
        elastic: &Elastic<D>,
        answer: &Answer<D>,
        owner: usize,
        drive: &mut [Vector<D>],
    ) {
        let parts = self.law.parts(elastic.lame[owner], &answer.strain[owner]);
        let volume = elastic.around.cloud.volume[owner];
        let (breaking, lasting) = (parts.breaking * volume, parts.lasting * volume);
        let left = self.law.degradation(answer.damage[owner]);
        let family = elastic.around.families.family(owner);
        for (bond, drive) in family.zip(drive) {
            let weight = &elastic.gradient.weight[bond];
            *drive = match self.law.hourglass {
                HourglassRule::Variational => (answer.forces[bond] - lasting * weight) / left,
                HourglassRule::Linear => breaking * weight,
            };
        }
    }

    /// Raises `history` (J/m³, shape `(n,)`) to what an answer drove.
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
