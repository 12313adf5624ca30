//! Points whose damage hardly grows in a step.
//!
//! They keep the damage and the tangent of the state in which all points were evaluated last, and are
//! evaluated again where the step seems to be at its end, which it is if forces balance then too. How far
//! a strain has moved since bounds what damage and stress can have done, so a point is stirred before
//! either is wrong by more than the growth that is allowed.

use crate::geometry::Matrix;
use crate::material::{PointAnswer, Softening, Tangent};

use super::{Answer, Damage, Elastic};

/// Which points rest, and what they were when all were evaluated last.
#[derive(Debug, Clone)]
pub struct Resting<const D: usize> {
    /// Growth of damage in a step below which a point rests; with 0 none does.
    growth: f64,
    rests: Vec<bool>,
    began: Vec<Began<D>>,
}

/// A point when all were evaluated last.
#[derive(Debug, Clone, Copy)]
struct Began<const D: usize> {
    strain: Matrix<D>,
    /// Hourglass energy that drives damage, J/m³.
    rough: f64,
    damage: f64,
    /// At fixed damage; its product with the strain is the stress.
    tangent: Tangent<D>,
}

impl<const D: usize> Resting<D> {
    /// Nobody rests before [`Resting::settle`]; afterwards those whose damage grows less than `growth`.
    pub fn new(growth: f64) -> Self {
        Resting {
            growth,
            rests: Vec::new(),
            began: Vec::new(),
        }
    }

    /// Begins anew at an answer for which every point was evaluated: those rest that would have rested
    /// since it began last.
    pub fn settle(
        &mut self,
        damage: &Damage<D>,
        elastic: &Elastic<D>,
        history: &[f64],
        at: &Answer<D>,
    ) {
        let moved = |(began, strain): (&Began<D>, &Matrix<D>)| began.strain != *strain;
        let first = self.began.is_empty();
        // Where nothing has moved the same points are stirred again.
        if self.is_off() || !(first || self.began.iter().zip(&at.strain).any(moved)) {
            return;
        }
        let nobody = Resting::new(0.0);
        let tangents = damage.tangents(elastic, history, &nobody, at, Softening::Fixed);
        let driven = |i: usize, strain| damage.law.parts(elastic.lame[i], strain).driving;
        let now = tangents.into_iter().enumerate().map(|(i, tangent)| Began {
            strain: at.strain[i],
            rough: at.driving[i] - driven(i, &at.strain[i]),
            damage: at.damage[i],
            tangent,
        });
        let now: Vec<Began<D>> = now.collect();
        let calm = |(i, now): (usize, &Began<D>)| {
            first || !self.stirs(damage, elastic, i, &now.strain, now.rough)
        };
        self.rests = now.iter().enumerate().map(calm).collect();
        self.began = now;
    }

    /// Whether a point rests.
    pub fn holds(&self, point: usize) -> bool {
        self.rests.get(point).copied().unwrap_or(false)
    }

    /// Whether no point ever rests.
    pub fn is_off(&self) -> bool {
        self.growth <= 0.0
    }

    /// Wakes points for the rest of the step.
    pub fn wake(&mut self, points: &[u32]) {
        for point in points {
            self.rests[*point as usize] = false;
        }
    }

    /// Tangent of a point that rests.
    pub fn tangent(&self, point: usize) -> Tangent<D> {
        self.began[point].tangent
    }

    /// Whether damage or stress of a point may have moved by more than is allowed since the step began.
    fn stirs(
        &self,
        damage: &Damage<D>,
        elastic: &Elastic<D>,
        point: usize,
        strain: &Matrix<D>,
        rough: f64,
    ) -> bool {
        let (began, lame) = (&self.began[point], elastic.lame[point]);
        let moved = (strain - began.strain).norm();
        let largest = lame.lambda * D as f64 + 2.0 * lame.mu;
        let push = largest * (began.strain.norm() + 0.5 * moved) + damage.law.prestress.norm();
        let driven = push * moved + (damage.law.driving_part(rough) - began.rough).max(0.0);
        let turned = 2.0 * began.damage * moved;
        driven > self.growth * damage.toughness[point] || turned > self.growth * strain.norm()
    }

    /// Answer of a point with the hourglass energy `rough` of its family, J; `None` unless it rests and
    /// may go on resting.
    ///
    /// Damage as it was makes the energy too large if anything, so a search that stirs a point goes down
    /// all the same.
    pub(super) fn answer(
        &self,
        damage: &Damage<D>,
        elastic: &Elastic<D>,
        history: &[f64],
        point: usize,
        strain: &Matrix<D>,
        rough: f64,
    ) -> Option<PointAnswer<D>> {
        let rough = rough / elastic.around.cloud.volume[point];
        if !self.holds(point) || self.stirs(damage, elastic, point, strain, rough) {
            return None;
        }
        let (began, law) = (&self.began[point], &damage.law);
        let left = law.degradation(began.damage);
        let stress = began.tangent.stress(strain);
        let driven = law.prestress.dot(strain) + law.driving_part(rough);
        Some(PointAnswer {
            stress: stress + law.prestress * left,
            driving: history[point],
            damage: began.damage,
            energy: 0.5 * stress.dot(strain)
                + left * driven
                + damage.toughness[point] * began.damage * began.damage,
        })
    }
}
