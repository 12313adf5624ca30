//! The derivative of the stress.

use super::{DamageLaw, DamageModel, EnergySplit, PointState};
use crate::geometry::{Matrix, Vector};
use crate::material::eigen::eigen;
use crate::material::{Lame, unit_strain};

/// Stiffness of one point: λ tr(X) I + Q (Θ ∘ QᵀXQ) Qᵀ + r (N:X) N + q (S:X) S for a strain X.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent<const D: usize> {
    /// λ, Pa.
    pub lambda: f64,
    /// Q as columns: the principal axes of the strain, or the normal of a crack and axes of its plane.
    pub basis: Matrix<D>,
    /// Θ, Pa; symmetric.
    pub shear: Matrix<D>,
    /// r, 1/Pa, not positive: what a crack releases at fixed damage.
    pub release: f64,
    /// N, Pa.
    pub cut: Matrix<D>,
    /// q, 1/Pa, not positive: the damage that a strain brings.
    pub softening: f64,
    /// S, Pa: the derivative of the driving energy without hourglass.
    pub direction: Matrix<D>,
}

/// How much of the damage that a strain brings enters the tangent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TangentKind {
    /// None: the tangent at fixed damage, positive.
    Secant,
    /// As much as leaves the tangent of every point positive.
    Bounded,
    /// All: the exact tangent, which may be indefinite.
    Consistent,
}

/// Share of the positive part of a tangent that bounded softening may take.
pub(super) const BOUND: f64 = 0.9;

impl<const D: usize> Tangent<D> {
    /// Tangent of a point without damage.
    pub fn elastic(lame: Lame) -> Self {
        Tangent {
            lambda: lame.lambda,
            basis: Matrix::identity(),
            shear: Matrix::repeat(2.0 * lame.mu),
            release: 0.0,
            cut: Matrix::zeros(),
            softening: 0.0,
            direction: Matrix::zeros(),
        }
    }

    /// Stress that a symmetric strain adds, Pa.
    pub fn stress(&self, strain: &Matrix<D>) -> Matrix<D> {
        let inner = (self.basis.transpose() * strain * self.basis).component_mul(&self.shear);
        Matrix::identity() * (self.lambda * strain.trace())
            + self.basis * inner * self.basis.transpose()
            + self.cut * (self.release * self.cut.dot(strain))
            + self.direction * (self.softening * self.direction.dot(strain))
    }

    /// The tangent at fixed damage.
    pub fn firm(self) -> Self {
        Tangent {
            softening: 0.0,
            ..self
        }
    }

    /// Stresses of the strains that a displacement along each axis causes where `weight` (1/m) is its
    /// weight in the gradient, Pa/m.
    pub fn stresses(&self, weight: &Vector<D>, scale: f64) -> [Matrix<D>; D] {
        let scaled = weight * scale;
        std::array::from_fn(|axis| self.stress(&unit_strain(axis, &scaled)))
    }

    /// Largest difference of the moduli to those of another tangent, over the largest modulus of
    /// `lame`.
    pub fn distance(&self, other: &Self, lame: Lame) -> f64 {
        let own =
            self.basis * self.shear.component_mul(&Matrix::identity()) * self.basis.transpose();
        let its =
            other.basis * other.shear.component_mul(&Matrix::identity()) * other.basis.transpose();
        let soft = |t: &Self| {
            t.direction * t.direction.norm() * t.softening + t.cut * t.cut.norm() * t.release
        };
        let moved = (self.lambda - other.lambda).abs()
            + (own - its).amax()
            + (self.shear - other.shear).amax()
            + (soft(self) - soft(other)).amax();
        moved / (lame.lambda + 2.0 * lame.mu)
    }
}

impl DamageLaw {
    /// Tangent at `strain` of a point whose driving energy is `driving`, J/m³. Hourglass energy in the driving
    /// one softens too, but not by stress.
    pub fn tangent<const D: usize>(
        &self,
        point: &PointState<D>,
        driving: f64,
        strain: &Matrix<D>,
        softening: TangentKind,
    ) -> Tangent<D> {
        match self.model {
            DamageModel::Split => self.cut_tangent(point, driving, strain, softening),
            DamageModel::Paper => self.paper_tangent(point, driving, strain, softening),
        }
    }

    fn paper_tangent<const D: usize>(
        &self,
        point: &PointState<D>,
        driving: f64,
        strain: &Matrix<D>,
        softening: TangentKind,
    ) -> Tangent<D> {
        let (lame, toughness, history) = (point.lame, point.toughness, point.history);
        let parts = self.parts(point, strain);
        let damage = self.damage(history.max(driving), toughness);
        let left = self.degradation(damage);
        let mut tangent = match self.split {
            EnergySplit::Spectral => spectral(lame, strain, left),
            EnergySplit::VolumetricDeviatoric => volumetric(lame, strain, left),
            EnergySplit::None => Tangent::elastic(Lame {
                lambda: left * lame.lambda,
                mu: left * lame.mu,
            }),
        };
        if driving > history && softening != TangentKind::Secant {
            let exact = self.softening(driving, toughness);
            // S:C⁻¹:S is at most this, C being the positive part of the tangent without its factor.
            let size = parts.degraded_stress.norm_squared() / (2.0 * lame.mu);
            let pure = point.prestress.norm_squared() <= 0.0;
            let size = if pure {
                2.0 * parts.tensile_energy
            } else {
                size
            };
            // The same of hourglass energy, a square too.
            let size = size + 2.0 * (driving - parts.tensile_energy).max(0.0);
            let bound = BOUND * left / size.max(f64::MIN_POSITIVE);
            tangent.direction = parts.degraded_stress;
            tangent.softening = match softening {
                TangentKind::Bounded => -exact.min(bound),
                _ => -exact,
            };
        }
        tangent
    }
}

/// Differences of principal strains, relative to the largest one, that count as none.
const EQUAL: f64 = 1e-10;

fn spectral<const D: usize>(lame: Lame, strain: &Matrix<D>, left: f64) -> Tangent<D> {
    let (values, basis) = eigen(strain);
    let positive = |value: f64| if value > 0.0 { 1.0 } else { 0.0 };
    let scale = values.amax();
    let share = |a: usize, b: usize| {
        let gap = values[a] - values[b];
        match gap.abs() > EQUAL * scale {
            true => (values[a].max(0.0) - values[b].max(0.0)) / gap,
            false => 0.5 * (positive(values[a]) + positive(values[b])),
        }
    };
    let degraded = |open: f64| left * open + (1.0 - open);
    Tangent {
        lambda: lame.lambda * degraded(positive(strain.trace())),
        basis,
        shear: Matrix::from_fn(|a, b| 2.0 * lame.mu * degraded(share(a, b))),
        ..Tangent::elastic(lame)
    }
}

fn volumetric<const D: usize>(lame: Lame, strain: &Matrix<D>, left: f64) -> Tangent<D> {
    let bulk = lame.lambda + 2.0 / 3.0 * lame.mu;
    let open = if strain.trace() > 0.0 { left } else { 1.0 };
    Tangent {
        lambda: open * bulk - left * 2.0 / 3.0 * lame.mu,
        ..Tangent::elastic(Lame {
            lambda: 0.0,
            mu: left * lame.mu,
        })
    }
}
