//! Wells: what drives them, and their holes.

use crate::plan::Load;

/// A well (Eqs. 77 and 78).
#[derive(Debug, Clone, PartialEq)]
pub struct WellPlan {
    /// Name in the scene.
    pub name: String,
    /// Position, m.
    pub at: Vec<f64>,
    /// What it is held at.
    pub drive: WellDrive,
    /// Radius λ over which the source is spread, m; `None` for Eq. 77.
    pub radius: Option<f64>,
    /// The hole, if the bottom-hole pressure is to be known.
    pub bore: Option<Wellbore>,
}

/// What a well is held at, and where that ends.
#[derive(Debug, Clone, PartialEq)]
pub enum WellDrive {
    /// A rate.
    Rate {
        /// Full-plane injection rate, m³/s; m²/s per metre of thickness in 2-D.
        rate: Load,
        /// Lowest bottom-hole pressure while it produces, Pa.
        pressure_min: Option<f64>,
        /// Highest bottom-hole pressure while it injects, Pa.
        pressure_max: Option<f64>,
    },
    /// A bottom-hole pressure.
    Pressure {
        /// The pressure, Pa.
        pressure: Load,
        /// Largest full-plane rate in or out, m³/s; m²/s per metre of thickness in 2-D.
        rate_max: Option<f64>,
    },
}

/// The hole of a well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wellbore {
    /// Radius r_w, m.
    pub radius: f64,
    /// Skin factor: resistance next to the hole in units of μ/(2πk) per metre.
    pub skin: f64,
}

impl WellPlan {
    /// The rate, of a well that is given one.
    pub fn rate(&self) -> Option<&Load> {
        match &self.drive {
            WellDrive::Rate { rate, .. } => Some(rate),
            WellDrive::Pressure { .. } => None,
        }
    }

    /// What is prescribed over time: a rate or a pressure.
    pub fn load(&self) -> &Load {
        match &self.drive {
            WellDrive::Rate { rate, .. } => rate,
            WellDrive::Pressure { pressure, .. } => pressure,
        }
    }

    /// Whether it is ever held at a pressure: the matrix of flow then has a term of it.
    pub fn holds(&self) -> bool {
        match &self.drive {
            WellDrive::Rate {
                pressure_min,
                pressure_max,
                ..
            } => pressure_min.or(*pressure_max).is_some(),
            WellDrive::Pressure { .. } => true,
        }
    }

    /// Whether what it is held at may change with the state.
    pub fn is_limited(&self) -> bool {
        match &self.drive {
            WellDrive::Rate { .. } => self.holds(),
            WellDrive::Pressure { rate_max, .. } => rate_max.is_some(),
        }
    }
}
