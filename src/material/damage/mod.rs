//! Variational damage of one point (Eqs. 20 to 35): energy, stress and tangent.
//!
//! With the driving energy D = ψ⁺ + σ⁰:ε, its largest value so far H, and c = G_c/ℓ the damage is
//! local, s = 1/(1 + c/((1 − k) H)), and the energy density
//!
//!   w = g(s) D + ψ⁻ + c s²,  g(s) = (1 − k)(1 − s)² + k,
//!
//! is smallest at that s. Its derivative is the stress g (σ⁺ + σ⁰) + σ⁻ of Eq. 31 less the pressure;
//! Eq. 30 is taken, not Eq. 52, which drops k.

mod split;
mod tangent;

use serde::Serialize;

use super::Lame;
use crate::geometry::Matrix;

pub use tangent::{Tangent, TangentKind};

/// Splits of the elastic energy into what breaks the rock and what does not (Eq. 24).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnergySplit {
    /// Positive principal strains and expansion.
    Spectral,
    /// Expansion and all change of shape.
    VolumetricDeviatoric,
    /// All of it.
    None,
}

impl EnergySplit {
    /// Name as in scenes.
    pub fn name(self) -> &'static str {
        match self {
            EnergySplit::Spectral => "spectral",
            EnergySplit::VolumetricDeviatoric => "volumetric-deviatoric",
            EnergySplit::None => "none",
        }
    }
}

/// How damage weakens the hourglass term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum HourglassRule {
    /// Its energy drives damage and is weakened by g(s) like the rest: forces are the derivative of an
    /// energy, and a crack takes what damage takes.
    Variational,
    /// By 1 − s, Eq. 53, and its energy drives nothing: what it held is lost as rock breaks, and a crack
    /// takes more than damage tells.
    Linear,
}

/// The law of damage, the same at all points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DamageLaw<const D: usize> {
    /// Which part of the energy breaks the rock.
    pub split: EnergySplit,
    /// Share k of the stiffness that is never lost.
    pub residual_stiffness: f64,
    /// Effective stress σ⁰ before the run, Pa, tension positive.
    pub prestress: Matrix<D>,
    /// How damage weakens the hourglass term.
    pub hourglass: HourglassRule,
}

/// How a point with damage responds to a strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResponse<const D: usize> {
    /// Effective stress, Pa; it does work on strains.
    pub stress: Matrix<D>,
    /// Driving energy D, J/m³.
    pub driving: f64,
    /// Damage s.
    pub damage: f64,
    /// Energy density w, what damage took included, J/m³.
    pub energy: f64,
}

impl<const D: usize> DamageLaw<D> {
    /// Damage of a point whose driving energy was `history` (J/m³) at most, with `toughness` G_c/ℓ in
    /// J/m³ (Eq. 48b).
    pub fn damage(&self, history: f64, toughness: f64) -> f64 {
        let drive = (1.0 - self.residual_stiffness) * history.max(0.0);
        drive / (drive + toughness)
    }

    /// History at which the damage is `damage`, J/m³.
    pub fn history(&self, damage: f64, toughness: f64) -> f64 {
        damage / (1.0 - damage) * toughness / (1.0 - self.residual_stiffness)
    }

    /// Share of the stiffness that is left, Eq. 25.
    pub fn degradation(&self, damage: f64) -> f64 {
        let k = self.residual_stiffness;
        (1.0 - k) * (1.0 - damage).powi(2) + k
    }

    /// Share of the hourglass stiffness that is left.
    pub fn hourglass(&self, damage: f64) -> f64 {
        match self.hourglass {
            HourglassRule::Variational => self.degradation(damage),
            HourglassRule::Linear => 1.0 - damage,
        }
    }

    /// Part of a hourglass energy that drives damage.
    pub fn driving_part(&self, hourglass_energy: f64) -> f64 {
        match self.hourglass {
            HourglassRule::Variational => hourglass_energy,
            HourglassRule::Linear => 0.0,
        }
    }

    /// Response to `strain` and to a hourglass energy density (J/m³) of a point that has seen
    /// `history`.
    pub fn response(
        &self,
        lame: Lame,
        toughness: f64,
        history: f64,
        strain: &Matrix<D>,
        hourglass_energy: f64,
    ) -> PointResponse<D> {
        let parts = self.parts(lame, strain);
        let driving = parts.tensile_energy + self.driving_part(hourglass_energy);
        let damage = self.damage(history.max(driving), toughness);
        let left = self.degradation(damage);
        PointResponse {
            stress: parts.degraded_stress * left + parts.intact_stress,
            driving,
            damage,
            energy: left * driving + parts.compressive_energy + toughness * damage * damage,
        }
    }
}

#[cfg(test)]
mod tests;
