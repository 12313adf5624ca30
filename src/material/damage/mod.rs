//! Variational damage of one point: energy, stress and tangent.
//!
//! Damage is local and eliminated. With the driving energy Y, its largest value so far H, the strength
//! c and the degradation g(s) = (1 − k)(1 − s)^m + k the energy density is smallest at the s of
//! [`DamageLaw::damage`]. Two models tell what is driven and what is lost:
//!
//! - [`DamageModel::Split`]: a broken point is rock cut by a plane, see [`plane`]. Of the energy
//!   ½ ε:C₀:ε + σ⁰:ε the part (1 − g) Y is lost.
//! - [`DamageModel::Paper`]: with Y = ψ⁺ + σ⁰:ε of a split of the strain (Eqs. 20 to 35), w = g Y + ψ⁻ and
//!   the stress g (σ⁺ + σ⁰) + σ⁻ of Eq. 31; Eq. 30 is taken, not Eq. 52, which drops k.

mod plane;
mod softening;
mod split;
mod tangent;

use serde::Serialize;

use super::Lame;
use crate::geometry::{Matrix, Vector};

pub(crate) use plane::CrackPlane;
#[cfg(test)]
use plane::across;
pub use softening::Exponent;
pub(crate) use tangent::{Tangent, TangentKind};

/// What damage does to rock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DamageModel {
    /// A broken point is cut by a plane: it loses the traction there, to which the fluid adds.
    Split,
    /// A part of the strain's energy is lost (Eqs. 20 to 35).
    Paper,
}

impl DamageModel {
    /// Name as in scenes.
    pub fn name(self) -> &'static str {
        match self {
            DamageModel::Split => "split",
            DamageModel::Paper => "paper",
        }
    }
}

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
pub struct DamageLaw {
    /// What is driven and what is lost.
    pub model: DamageModel,
    /// How fast stiffness goes with damage.
    pub exponent: Exponent,
    /// Coefficient of friction f of faces that touch, in the split model.
    pub friction: f64,
    /// Which part of the energy breaks the rock, in the model of the paper.
    pub split: EnergySplit,
    /// Share k of the stiffness that is never lost.
    pub residual_stiffness: f64,
    /// How damage weakens the hourglass term, in the model of the paper.
    pub hourglass: HourglassRule,
}

impl DamageLaw {
    /// Driving energy at which a bar of strength `toughness` carries most, J/m³: the largest √Y g(s(Y)).
    pub fn peak_driving(&self, toughness: f64) -> f64 {
        toughness
            * match self.exponent {
                Exponent::Two => 1.0 / 3.0,
                Exponent::ThreeHalves => 0.451,
            }
    }
}

/// What a point is, and what it has been through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointState<const D: usize> {
    /// Elastic constants.
    pub lame: Lame,
    /// Strength c, J/m³: G_c over the width of what breaks.
    pub toughness: f64,
    /// Largest driving energy so far, J/m³.
    pub history: f64,
    /// Effective stress σ⁰ of the undeformed rock, Pa, tension positive.
    pub prestress: Matrix<D>,
    /// Normal of the crack once it is settled.
    pub normal: Option<Vector<D>>,
    /// What the fluid adds to the effective traction on a crack, p^c − α p, Pa: its pressure in the crack
    /// less its share in the total stress.
    pub fluid: f64,
}

/// How a point with damage responds to a strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointResponse<const D: usize> {
    /// Effective stress, σ⁰ included, Pa; it does work on strains.
    pub stress: Matrix<D>,
    /// Driving energy Y, J/m³.
    pub driving: f64,
    /// Damage s.
    pub damage: f64,
    /// Share of the hourglass stiffness that is left.
    pub hourglass: f64,
    /// Energy density, what damage took included, J/m³. The hourglass energy is part of it where that drives
    /// damage.
    pub energy: f64,
    /// The plane of the crack, in the split model.
    pub plane: CrackPlane<D>,
}

impl DamageLaw {
    /// Damage of a point whose driving energy was `history` (J/m³) at most, with the strength
    /// `toughness` in J/m³ (Eq. 48b).
    pub fn damage(&self, history: f64, toughness: f64) -> f64 {
        let drive = (1.0 - self.residual_stiffness) * history.max(0.0);
        self.exponent.damage(drive, toughness)
    }

    /// History at which the damage is `damage`, J/m³.
    pub fn history(&self, damage: f64, toughness: f64) -> f64 {
        self.exponent.drive(damage, toughness) / (1.0 - self.residual_stiffness)
    }

    /// Share of the stiffness that is left, Eq. 25.
    pub fn degradation(&self, damage: f64) -> f64 {
        let k = self.residual_stiffness;
        (1.0 - k) * self.exponent.integrity(damage) + k
    }

    /// −dg/dY where the driving energy is the largest so far, m³/J.
    pub fn softening(&self, history: f64, toughness: f64) -> f64 {
        let kept = 1.0 - self.residual_stiffness;
        kept * kept * self.exponent.softening(kept * history.max(0.0), toughness)
    }

    /// Whether hourglass energy drives damage, so that all forces are the derivative of an energy.
    pub fn is_variational(&self) -> bool {
        self.model == DamageModel::Split || self.hourglass == HourglassRule::Variational
    }

    /// Response to `strain` and to a hourglass energy density, J/m³.
    pub fn response<const D: usize>(
        &self,
        point: &PointState<D>,
        strain: &Matrix<D>,
        hourglass_energy: f64,
    ) -> PointResponse<D> {
        match self.model {
            DamageModel::Split => self.cut_response(point, strain, hourglass_energy),
            DamageModel::Paper => self.paper_response(point, strain, hourglass_energy),
        }
    }

    fn paper_response<const D: usize>(
        &self,
        point: &PointState<D>,
        strain: &Matrix<D>,
        hourglass_energy: f64,
    ) -> PointResponse<D> {
        let parts = self.parts(point, strain);
        let linear = self.hourglass == HourglassRule::Linear;
        let driven = if linear { 0.0 } else { hourglass_energy };
        let driving = parts.tensile_energy + driven;
        let damage = self.damage(point.history.max(driving), point.toughness);
        let left = self.degradation(damage);
        PointResponse {
            stress: parts.degraded_stress * left + parts.intact_stress,
            driving,
            damage,
            hourglass: if linear { 1.0 - damage } else { left },
            energy: left * driving + parts.compressive_energy + point.toughness * damage * damage,
            plane: CrackPlane::default(),
        }
    }
}

#[cfg(test)]
mod tests;
