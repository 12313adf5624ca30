//! What can be wrong with a plan once its points are known.

use crate::assembly::{ConsistencyError, PatternError};
use crate::effects::EffectError;
use crate::geometry::{GenerateError, GeometryError};
use crate::plan::FileError;

/// A plan that cannot become a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// No effect is named.
    #[error("the scene names no effect; add [flow] or [mechanics]")]
    NothingToDo,
    /// An own effect acts on a field that is not computed.
    #[error("an own effect acts on a field that is not computed; add {section} to the scene")]
    NothingToActOn {
        /// The section that is missing.
        section: &'static str,
    },
    /// The cloud could not be generated.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// Points that cannot be used.
    #[error("{path}: {message}")]
    Points {
        /// The file.
        path: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// Cells too small for their distance from the origin.
    #[error(
        "the cell of point {point} is {edge:.3e} m wide, too little beside coordinates up to \
         {reach:.3e} m, which round it away; move the domain to the origin, or make cells more alike"
    )]
    Unresolved {
        /// The point.
        point: usize,
        /// Shortest edge of its cell, m.
        edge: f64,
        /// Largest coordinate of the domain, m.
        reach: f64,
    },
    /// Families could not be built.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A point on a crack has no side.
    #[error(
        "crack \"{name}\" goes through point {point} at {position:?}; move it off the points, such as by \
         half the spacing, or change the number of points"
    )]
    CrackThroughPoint {
        /// Name of the crack.
        name: String,
        /// Index of the point.
        point: usize,
        /// Its position, m.
        position: Vec<f64>,
    },
    /// A crack that separates nothing.
    #[error(
        "crack \"{name}\" has no point on one side of {at:?}: it lies along the boundary of the cloud or \
         outside; move it inside"
    )]
    CrackAtBoundary {
        /// Name of the crack.
        name: String,
        /// A place on it, m.
        at: Vec<f64>,
    },
    /// A crack that is damaged from the start, away from all points.
    #[error(
        "crack \"{name}\" is to be damaged from the start, but no point is within its horizon of it; \
         move it onto the points"
    )]
    EmptyBand {
        /// Name of the crack.
        name: String,
    },
    /// A probe or profile where no point is.
    #[error(
        "{what}.{name}: no point is near {at:?}, so there is no value; move it onto the points or end it \
         beside the void"
    )]
    ProbeOffPoints {
        /// Probes or profiles.
        what: &'static str,
        /// Name in the scene.
        name: String,
        /// Position, m.
        at: Vec<f64>,
    },
    /// A material's region holds no point.
    #[error("the region of material \"{material}\" holds no point; enlarge it or refine the cloud")]
    EmptyRegion {
        /// Name of the material.
        material: String,
    },
    /// A material whose points all belong to later materials.
    #[error(
        "all points in the region of material \"{material}\" lie in regions of later materials, which \
         replace it; reorder the materials or change the regions"
    )]
    CoveredRegion {
        /// Name of the material.
        material: String,
    },
    /// A porosity above the Biot coefficient of its point.
    #[error(
        "the porosity of material \"{material}\" is {porosity:.4} at point {point} at {position:?}, above its \
         Biot coefficient {biot:.4} (Eq. 38); raise `biot_coefficient`, correct the file, or of a random field lower \
         `median` or `log10_std` or clip it with `decades`"
    )]
    PorosityAboveBiot {
        /// Name of the material.
        material: String,
        /// Index of the point.
        point: usize,
        /// Its position, m.
        position: Vec<f64>,
        /// The porosity there.
        porosity: f64,
        /// The Biot coefficient there.
        biot: f64,
    },
    /// A points file that names materials, beside regions.
    #[error(
        "the file names the material of every point, so the region of material \"{material}\" reaches nothing; \
         remove the region, or what names materials in the file: a column of points, groups of a mesh"
    )]
    UnusedRegion {
        /// Name of the material.
        material: String,
    },
    /// A points file does not tell which of several materials without a region its points are of.
    #[error(
        "neither \"{first}\" nor \"{second}\" has a region, and the file tells no materials; add a column `material` to \
         points, name a group of a mesh like each material, or give one of them a region"
    )]
    UntoldMaterial {
        /// A material without a region.
        first: String,
        /// Another one.
        second: String,
    },
    /// A region with prescribed pressure holds no point.
    #[error("flow.regions #{number} holds no point; enlarge it or refine the cloud")]
    EmptyPressureRegion {
        /// Which region, from 1.
        number: usize,
    },
    /// A region with prescribed pressure whose points all belong to later regions or to cracks.
    #[error(
        "all points of flow.regions #{number} lie in later regions or in cracks with a pressure, which \
         replace it; reorder the regions or change them"
    )]
    CoveredPressureRegion {
        /// Which region, from 1.
        number: usize,
    },
    /// A region of the in-situ stress holds no point of its own.
    #[error(
        "initial.regions #{number} holds no point, or later regions hold all of them; enlarge it, reorder the \
         regions, or refine the cloud"
    )]
    EmptyStressRegion {
        /// Which region, from 1.
        number: usize,
    },
    /// K₀ with a weight that is no function of depth.
    #[error(
        "initial.k0 needs a weight of the rock that depends on depth only, in layers along an axis of a lattice: \
         there are {:.6e} and {:.6e} N/m^3; give initial.stress and initial.stress_gradient instead",
        weights[0], weights[1]
    )]
    UnevenWeight {
        /// Two weights that differ, N/m³.
        weights: [f64; 2],
    },
    /// An in-situ stress that is not in equilibrium inside.
    #[error(
        "the initial stress is not in equilibrium: div(total stress) + weight + body force leaves {residual:.6e} \
         Pa/m at {at:?}, where the rock weighs {weight:.6e} N/m^3; correct initial.stress_gradient (per metre of \
         depth; effective stress changes by alpha times the weight of the fluid less), or use initial.k0"
    )]
    UnbalancedStress {
        /// What is left, Pa/m.
        residual: f64,
        /// Weight of the rock there, N/m³.
        weight: f64,
        /// Position, m.
        at: Vec<f64>,
    },
    /// An in-situ stress that breaks the rock.
    #[error(
        "the initial effective stress pulls with {tension:.4e} Pa at {at:?}, and the rock breaks at {strength:.4e} Pa: it \
         would be broken before anything happens; compression is negative"
    )]
    BrokenAtRest {
        /// Largest principal effective stress, Pa.
        tension: f64,
        /// Strength there, Pa.
        strength: f64,
        /// Position, m.
        at: Vec<f64>,
    },
    /// A traction that is not that of the in-situ stress.
    #[error(
        "the initial total stress exerts the traction {stress:?} Pa on side {side} at {at:?}, but \
         mechanics.boundary.{side}.traction is {traction:?} Pa at the start; a traction is the total one: begin \
         with that of the stress and change it in time, leave it out, or add a load in [mechanics.loads]"
    )]
    InitialTraction {
        /// The side.
        side: &'static str,
        /// Traction of the total stress, Pa.
        stress: Vec<f64>,
        /// The prescribed one, Pa.
        traction: Vec<f64>,
        /// Where they differ most, m.
        at: Vec<f64>,
    },
    /// A plate whose force is not that of the in-situ stress.
    #[error(
        "the initial total stress exerts {force:.8e} N on the plate of side {side}, but \
         mechanics.boundary.{side}.plate is {given:.8e} N at the start; begin with the force of the stress and \
         change it in time"
    )]
    InitialPlate {
        /// The side.
        side: &'static str,
        /// Force of the total stress along the axis, N.
        force: f64,
        /// The prescribed one, N.
        given: f64,
    },
    /// Points without a material.
    #[error(
        "{count} points have no material, the first at {position:?}; add a material without a \
         region as the background"
    )]
    NoMaterial {
        /// How many.
        count: usize,
        /// Position of the first, m.
        position: Vec<f64>,
    },
    /// A material lacks what an effect needs.
    #[error("material \"{material}\" has no {property}, which an effect of the scene needs")]
    MissingProperty {
        /// Name of the material.
        material: String,
        /// What is missing.
        property: &'static str,
    },
    /// A point file names a material that the scene does not define.
    #[error("the points file names the material \"{name}\", which the scene does not define")]
    UnknownMaterial {
        /// The name.
        name: String,
    },
    /// A permeability file that does not fit the cloud.
    #[error(transparent)]
    Table(#[from] FileError),
    /// An effect does not fit.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The gradient could not be corrected.
    #[error(transparent)]
    Consistency(#[from] ConsistencyError),
    /// The path operator on points whose cells are not known.
    #[error(
        "the path operator needs the cells of the points, which are not known with geometry.any_volume, nor \
         where jittered cells are ten times as long as they are thick; use flow.operator = \"bond\", give \
         volumes in the unit of the positions, or leave the jitter out"
    )]
    PathWithoutCells,
    /// The bond operator on families that are too uneven for it.
    #[error(
        "the bond operator is not consistent on this cloud: a uniform flow would be off by {:.0} % \
         ({uneven} of {points} families are too uneven for positive weights); \
         use flow.operator = \"correspondence\", or a more even cloud or a larger horizon",
        100.0 * error
    )]
    InconsistentBonds {
        /// Relative error of the flux.
        error: f64,
        /// Families without exact second moment.
        uneven: usize,
        /// Points of the cloud.
        points: usize,
    },
    /// The plain gradient on a cloud that is too uneven for it.
    #[error(
        "the plain gradient is not consistent on this cloud: a uniform field would be off by {:.0} %; \
         use {owner}.gradient = \"divergence-consistent\", or a more even cloud",
        100.0 * error
    )]
    InconsistentGradient {
        /// Section that asks for it.
        owner: &'static str,
        /// Relative error of a uniform flux.
        error: f64,
    },
    /// Fluid in broken rock on a cloud on which its pressure is not in equilibrium.
    #[error(
        "fluid in broken rock needs the divergence-consistent gradient where points are uneven: with the plain one its \
         pressure moves broken points about, and cracks opened by up to 45 % too little; {remedy}"
    )]
    UnbalancedFluid {
        /// What to do.
        remedy: &'static str,
    },
    /// The matrix is too large.
    #[error(transparent)]
    Pattern(#[from] PatternError),
}
