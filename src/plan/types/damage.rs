//! What a plan says about damage and about flow in what is broken.

use serde::Serialize;

use super::DescentSettings;

pub use crate::material::{DamageModel, EnergySplit, Exponent, HourglassRule};

/// Variational damage (Eqs. 20 to 35).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DamagePlan {
    /// What damage does to rock.
    pub model: DamageModel,
    /// How fast stiffness goes with damage.
    pub exponent: Exponent,
    /// Coefficient of friction of faces that touch.
    pub friction: f64,
    /// Length scale ℓ, m; only needed where strength follows from it.
    pub length_scale: Option<f64>,
    /// Which part of the energy breaks the rock.
    pub split: EnergySplit,
    /// Share k of the stiffness that is never lost.
    pub residual_stiffness: f64,
    /// How damage weakens the hourglass term.
    pub hourglass: HourglassRule,
    /// What the fracture energy is scaled by, so that a crack costs what it should.
    pub normalise: Normalise,
    /// How equilibrium with damage is found.
    pub method: DamageMethod,
    /// Forces out of balance, relative to all forces, that count as equilibrium.
    pub tolerance: f64,
    /// Largest number of iterations of a step.
    pub iterations: usize,
    /// Growth of damage at a point, in one step, above which an adaptive step is cut.
    pub largest_increment: f64,
    /// Shortest adaptive step, s: growth that goes on in it is accepted however fast it is.
    pub shortest_step: f64,
    /// Constants of the walk to equilibrium; no scene names them.
    pub descent: DescentSettings,
}

/// What the fracture energy G_c over the length scale ℓ is scaled by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Normalise {
    /// Nothing: c = G_c/ℓ.
    Off,
    /// ℓ/2δ: c = G_c/2δ.
    Horizon,
    /// ℓ over the mean effective width W̄ of the family: c = G_c/W̄.
    Mean,
}

/// Ways to equilibrium with damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DamageMethod {
    /// Newton's method where it works, alternate minimisation elsewhere.
    Auto,
    /// Damage eliminated, exact tangent.
    Newton,
    /// Displacement at fixed damage, then damage.
    Alternate,
}

impl DamageMethod {
    /// The iterations, in words.
    pub fn name(self) -> &'static str {
        match self {
            DamageMethod::Auto => "newton or alternate",
            DamageMethod::Newton => "newton",
            DamageMethod::Alternate => "alternate",
        }
    }
}

/// Flow in what is broken (Eqs. 40 to 46).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FractureFlowPlan {
    /// Hydraulic aperture of a closed fracture, m.
    pub residual_aperture: f64,
    /// How the opening is found.
    pub aperture: ApertureRule,
    /// What the permeability of a crack stands for.
    pub transmissivity: TransmissivityRule,
    /// Damage c₁ up to which rock is intact.
    pub lower_threshold: f64,
    /// Damage c₂ from which it is a fracture.
    pub upper_threshold: f64,
    /// Storage coefficient in fractures, 1/Pa; that of the rock if `None`.
    pub storage: Option<f64>,
    /// Biot coefficient in fractures.
    pub biot_coefficient: f64,
    /// Viscosity in fractures, Pa s; that of the fluid if `None`.
    pub viscosity: Option<f64>,
    /// Permeability of fractures, m², instead of that of their opening.
    pub permeability: Option<f64>,
    /// Pressure at which fluid in cracks boils, Pa; −∞ where it never does.
    pub cavitation_pressure: f64,
}

/// Ways to find the opening of a crack from bonds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ApertureRule {
    /// Opening along each bond divided by the cosine to the normal of the crack.
    Normal,
    /// Plain mean over the bonds, Eq. 42 as printed.
    Mean,
}

impl ApertureRule {
    /// Name as in scenes.
    pub fn name(self) -> &'static str {
        match self {
            ApertureRule::Normal => "normal",
            ApertureRule::Mean => "mean",
        }
    }
}

/// What the permeability of a crack stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TransmissivityRule {
    /// w²/12 scaled by w/2δ, so that the band conducts w³/12.
    Cubic,
    /// w²/12 in the whole band, as printed.
    Paper,
}

impl TransmissivityRule {
    /// Name as in scenes.
    pub fn name(self) -> &'static str {
        match self {
            TransmissivityRule::Cubic => "cubic",
            TransmissivityRule::Paper => "paper",
        }
    }
}
