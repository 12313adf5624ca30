//! What a plan says about the deformation of the rock.

use super::{GradientChoice, InterfaceChoice, Load};
use crate::geometry::{Shape, Side};

/// Linear elastic deformation.
#[derive(Debug, Clone, PartialEq)]
pub struct MechanicsPlan {
    /// Whether mass resists; forces balance at all times otherwise.
    pub inertia: bool,
    /// Hourglass coefficient, in units of the shear modulus.
    pub hourglass: f64,
    /// Which gradient the displacement gets.
    pub gradient: GradientChoice,
    /// What families make of moduli that vary within them.
    pub interfaces: InterfaceChoice,
    /// Force per volume in addition to gravity, N/m³, one component per axis.
    pub body_force: Option<Vec<f64>>,
    /// What holds on the sides: six entries, in the order of [`Side::index`].
    pub sides: Vec<Support>,
    /// Loads on parts of sides, in the scene's order.
    pub loads: Vec<TractionPlan>,
}

impl MechanicsPlan {
    /// Whether the gradient is made divergence-consistent on a cloud that is irregular or not and
    /// has planes or not.
    pub fn corrects_gradient(&self, irregular: bool, planes: bool) -> bool {
        self.gradient.corrects(irregular, planes)
    }

    /// Whether families have layers where moduli vary within them, in rock that breaks or not.
    pub fn has_layers(&self, breaks: bool) -> bool {
        match self.interfaces {
            InterfaceChoice::Auto => !breaks,
            InterfaceChoice::Laminate => true,
            InterfaceChoice::Pointwise => false,
        }
    }
}

/// Mechanical condition on a side.
#[derive(Debug, Clone, PartialEq)]
pub enum Support {
    /// No force.
    Free,
    /// Force per area on the body along the axes, Pa.
    Traction(Vec<Load>),
    /// Displacement along the positive axis normal to the side, m; no force along the side.
    Roller(Load),
    /// Displacement along the axes, m.
    Prescribed(Vec<Load>),
    /// Rigid plate without friction: one normal displacement for the whole side. Resultant force
    /// on the body along the positive axis, N (N/m per metre of thickness in 2-D).
    Plate(Load),
}

impl Support {
    /// Whether it is a rigid plate.
    pub fn is_plate(&self) -> bool {
        matches!(self, Support::Plate(_))
    }

    /// Whether it prescribes a displacement that is not always zero.
    pub fn moves(&self) -> bool {
        match self {
            Support::Free | Support::Traction(_) | Support::Plate(_) => false,
            Support::Roller(load) => !load.is_zero(),
            Support::Prescribed(loads) => !loads.iter().all(Load::is_zero),
        }
    }
}

/// A force per area on a part of a side, in addition to the side's own traction.
#[derive(Debug, Clone, PartialEq)]
pub struct TractionPlan {
    /// Name in the scene.
    pub name: String,
    /// The side.
    pub side: Side,
    /// Which part of it; `None` for all.
    pub region: Option<Shape>,
    /// Force per area on the body along the axes, Pa.
    pub traction: Vec<Load>,
}

/// The two ways between pressure and strain (Biot).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CouplingPlan {
    /// Whether the run starts from the undrained answer to the first loads.
    pub undrained_start: bool,
    /// Factor of the storage that only rough pressures feel; 0 for none.
    pub stabilisation: f64,
}
