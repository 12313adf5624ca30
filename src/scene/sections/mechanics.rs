//! `[mechanics]`: the deformation of the rock; its presence makes the effect exist.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::flow::Gradient;
use super::sides::{Boundary, Side, check_side};
use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{Dimension, ForceDensity, Number, Pressure, dimension};
use crate::scene::range::{Range, within};
use crate::scene::shape::Shape;
use crate::scene::span::{Entry, Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Deformation of the rock, linear elastic.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Mechanics {
    /// Without or with inertia.
    pub mode: Spanned<Motion>,
    /// Coefficient of the hourglass term, in units of the shear modulus.
    #[schemars(transform = within(&HOURGLASS))]
    pub hourglass: Number,
    /// Gradient of the displacement. `auto` is plain where cracks are cut and in the damage model of the paper.
    pub gradient: Spanned<Gradient>,
    /// What families make of moduli that vary within them.
    pub interfaces: Spanned<Interfaces>,
    /// Force per volume on all points, N/m³, in addition to gravity.
    pub body_force: Option<Spanned<Vec<ForceDensity>>>,
    /// Effective stress before the run, uniform: short for `initial.stress`.
    pub initial_stress: Option<Spanned<InitialStress>>,
    /// What holds on the sides; a side that is not named is free.
    pub boundary: Boundary<Support>,
    /// Loads on parts of free sides.
    pub loads: Named<TractionLoad>,
}

/// Sneddon's crack: root-mean-square error of the opening 0.052 at 1, 0.044 at 0.1, 0.19 at 10 (largest
/// 0.22), but 0.33 at 30 and 0.95 at 1e6; below 0.1 its largest error grows to 0.21 and more, and the
/// factor stagnates (52 s instead of 1 s at 1e-6).
const HOURGLASS: Range = Range {
    key: "hourglass",
    low: 0.1,
    high: 10.0,
    why: "less lets the displacement alternate from point to point, more stiffens the rock where \
          strain changes, such as at tips of cracks",
};

impl Default for Mechanics {
    fn default() -> Self {
        Self {
            mode: Spanned::default(),
            hourglass: Number::si(1.0),
            gradient: Spanned::default(),
            interfaces: Spanned::default(),
            body_force: None,
            initial_stress: None,
            boundary: Boundary::default(),
            loads: Named::default(),
        }
    }
}

/// What a family makes of moduli that vary within it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interfaces {
    /// Layers, where rock does not break.
    #[default]
    Auto,
    /// Layers: tractions across them are the same, the strain across them jumps.
    Laminate,
    /// The moduli of its point.
    Pointwise,
}

/// Whether mass resists.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Forces balance at all times.
    #[default]
    QuasiStatic,
    /// Unbalanced forces accelerate the rock.
    Dynamic,
}

/// A symmetric stress, Pa, tension positive; a component that is not named is zero.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct InitialStress {
    /// Normal stress along x, Pa.
    pub xx: Option<Pressure>,
    /// Normal stress along y, Pa.
    pub yy: Option<Pressure>,
    /// Normal stress along z, Pa.
    pub zz: Option<Pressure>,
    /// Shear stress, Pa.
    pub xy: Option<Pressure>,
    /// Shear stress, Pa. Not in a plane.
    pub yz: Option<Pressure>,
    /// Shear stress, Pa. Not in a plane.
    pub xz: Option<Pressure>,
}

impl InitialStress {
    /// Components xx, yy, zz, xy, yz, xz in Pa.
    pub fn resolved(&self) -> [f64; 6] {
        [self.xx, self.yy, self.zz, self.xy, self.yz, self.xz]
            .map(|component| component.map_or(0.0, |value| value.value()))
    }
}

/// What holds on a side: exactly one of `free`, `clamped`, `roller`, `traction`, `displacement`,
/// `normal_displacement`, `plate`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(
    rename = "Support by key",
    rename_all = "snake_case",
    deny_unknown_fields
)]
#[schemars(rename = "Support", untagged)]
pub enum Support {
    /// No force.
    Free {
        /// Always `true`.
        free: Spanned<bool>,
    },
    /// No displacement.
    Clamped {
        /// Always `true`.
        clamped: Spanned<bool>,
    },
    /// No displacement across the side, no force along it: a plane of symmetry.
    Roller {
        /// Always `true`.
        roller: Spanned<bool>,
    },
    /// A prescribed force per area.
    Traction {
        /// Force per area on the rock along the axes, Pa.
        traction: Spanned<Vec<Load<dimension::Pressure>>>,
    },
    /// A prescribed displacement.
    Displacement {
        /// Displacement along the axes, m.
        displacement: Spanned<Vec<Load<dimension::Length>>>,
    },
    /// A prescribed displacement across the side, no force along it.
    NormalDisplacement {
        /// Displacement along the axis the side is normal to, m.
        normal_displacement: Load<dimension::Length>,
    },
    /// A rigid plate without friction: the whole side moves by the same distance across it.
    Plate {
        /// Resultant force on the rock along the axis the side is normal to, N (N/m per metre of
        /// thickness in a plane).
        plate: Load<dimension::Force>,
    },
}

/// A force per area on a part of a free side, in addition to the traction of the side.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TractionLoad {
    /// The side.
    pub side: Spanned<Side>,
    /// Which part of the side; all of it if absent.
    pub region: Option<Spanned<Shape>>,
    /// Force per area on the rock along the axes, Pa.
    pub traction: Spanned<Vec<Load<dimension::Pressure>>>,
}

impl Mechanics {
    /// Whether mass resists.
    pub fn is_dynamic(&self) -> bool {
        self.mode.value == Motion::Dynamic
    }
}

impl Support {
    /// Whether forces alone act on the side, so that more of them can be added.
    fn takes_loads(&self) -> bool {
        matches!(self, Self::Free { .. } | Self::Traction { .. })
    }

    /// Whether a side normal to the axis `own` holds the displacement along `axis`.
    fn holds(&self, own: usize, axis: usize) -> bool {
        match self {
            Self::Clamped { .. } | Self::Displacement { .. } => true,
            Self::Roller { .. } | Self::NormalDisplacement { .. } => own == axis,
            Self::Free { .. } | Self::Traction { .. } | Self::Plate { .. } => false,
        }
    }
}

impl Section for Mechanics {
    const NAME: &'static str = "mechanics";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        HOURGLASS.check(self.hourglass, report);
        if let Some(force) = &self.body_force {
            report.vector("body_force", force, scene.dimension());
        }
        if let Some(stress) = &self.initial_stress {
            stress.check_plane(scene, report);
        }
        for (side, support) in self.boundary.iter() {
            check_side(side, support.span, scene, report);
            check_support(support, scene, report);
        }
        report.names(&self.loads);
        for entry in &self.loads {
            self.check_load(entry, scene, report);
        }
        self.check_held(place, scene, report);
    }
}

impl InitialStress {
    /// A plane domain has no shear out of its plane.
    pub(super) fn check_plane(&self, scene: &Context<'_>, report: &mut Report) {
        if scene.dimension() != Some(2) {
            return;
        }
        for (name, component) in [("yz", self.yz), ("xz", self.xz)] {
            let Some(component) = component else { continue };
            let message = format!("a plane domain has no component `{name}`");
            let fault = Diagnostic::new(message).at(component.span());
            report.add(fault.help("its components are `xx`, `yy`, `zz` and `xy`"));
        }
    }
}

impl Mechanics {
    fn check_load(&self, entry: &Entry<TractionLoad>, scene: &Context<'_>, report: &mut Report) {
        let load = &entry.value;
        check_side(load.side.value, load.side.span, scene, report);
        if let Some(region) = &load.region {
            report.shape(region, scene);
        }
        check_loads("traction", &load.traction, scene, report);
        let support = self.boundary.get(load.side.value);
        if let Some(support) = support.filter(|support| !support.takes_loads()) {
            let message = format!("`{}` is not free, so it takes no load", load.side.name());
            let fault = Diagnostic::new(message).at(load.side.span);
            report.add(
                fault
                    .also(support.span, "held here")
                    .help("load a side that is free or has a traction"),
            );
        }
    }

    /// Every axis needs a side that holds the displacement along it; a plate moves.
    fn check_held(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        if self.is_dynamic() {
            return;
        }
        for axis in 0..scene.dimension().unwrap_or(2) {
            let held =
                |(side, support): (Side, &Spanned<Support>)| support.holds(side.axis(), axis);
            if self.boundary.iter().any(held) {
                continue;
            }
            let name = ["x", "y", "z"][axis];
            let [low, high] = [Side::ALL[2 * axis], Side::ALL[2 * axis + 1]].map(Side::name);
            let fault = Diagnostic::new(format!("nothing holds the body along {name}")).at(place);
            let help = format!("add roller = true on {low} or {high}, or clamp a side");
            report.add(fault.help(help));
        }
    }
}

fn check_support(support: &Support, scene: &Context<'_>, report: &mut Report) {
    match support {
        Support::Free { free } => check_true("free", *free, report),
        Support::Clamped { clamped } => check_true("clamped", *clamped, report),
        Support::Roller { roller } => check_true("roller", *roller, report),
        Support::Traction { traction } => check_loads("traction", traction, scene, report),
        Support::Displacement { displacement } => {
            check_loads("displacement", displacement, scene, report);
        }
        Support::NormalDisplacement {
            normal_displacement,
        } => report.load(normal_displacement, scene),
        Support::Plate { plate } => check_plate(plate, scene, report),
    }
}

fn check_true(name: &str, typed: Spanned<bool>, report: &mut Report) {
    if !typed.value {
        let fault = Diagnostic::new(format!("`{name}` can only be true")).at(typed.span);
        report.add(fault.help("write what holds on the side instead"));
    }
}

/// One load for each axis.
fn check_loads<D: Dimension>(
    name: &str,
    loads: &Spanned<Vec<Load<D>>>,
    scene: &Context<'_>,
    report: &mut Report,
) {
    report.vector(name, loads, scene.dimension());
    loads.iter().for_each(|load| report.load(load, scene));
}

/// A force per metre of thickness belongs to a plane.
fn check_plate(plate: &Load<dimension::Force>, scene: &Context<'_>, report: &mut Report) {
    report.load(plate, scene);
    let per_metre = plate.values().iter().find(|value| value.accepted() == 1);
    if let (Some(value), Some(3)) = (per_metre, scene.dimension()) {
        let fault =
            Diagnostic::new("a force per metre of thickness has no meaning in three dimensions");
        report.add(fault.at(value.span()).help("give the whole force, in N"));
    }
}
