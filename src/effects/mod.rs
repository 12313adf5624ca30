//! What acts at points: loads and sources, each built only if the plan names it.
//!
//! A new effect is one new file and one line in `registry`.

mod aperture;
mod cracks;
mod flux;
mod gravity;
mod injection;
mod moments;
mod opening;
mod own;
mod side_area;
mod solid;
mod source;
mod spread;
mod wells;

use std::sync::atomic::{AtomicU64, Ordering};

pub(crate) use aperture::aperture;
pub(crate) use cracks::released_faces;
pub(crate) use gravity::Column;
pub(crate) use injection::injection_shares;
pub(crate) use opening::{Opening, openings};
pub(crate) use solid::{SolidContext, build_solid, initial_force, loaded_side, tensor};
pub(crate) use wells::{WellSpread, known_wells};

pub(crate) use crate::plan::Effect;

use crate::assembly::ScalarOperator;
use crate::geometry::{Side, Vector};
use crate::operators::{MirrorContinuation, Parity};
use crate::plan::Plan;

/// Everything effects may look at while they are built.
pub(crate) struct Context<'a, const D: usize> {
    /// The plan.
    pub plan: &'a Plan,
    /// The flow operator.
    pub operator: &'a dyn ScalarOperator<D>,
    /// Continuation of the pressure across the sides.
    pub extension: &'a MirrorContinuation<D>,
    /// K/μ per point, m²/(Pa s).
    pub mobility: &'a [f64],
    /// Weight of the fluid, if gravity acts.
    pub column: Option<&'a Column<D>>,
    /// Points per crack that are damaged from the start.
    pub bands: &'a [Vec<u32>],
}

/// Why an effect could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectError {
    /// A well's support has no point of the cloud.
    #[error("well \"{name}\" at {at:?}: no point within its radius of {radius:.3e} m")]
    EmptyWell {
        /// Name.
        name: String,
        /// Position, m.
        at: Vec<f64>,
        /// Radius, m.
        radius: f64,
    },
    /// Two wells feed the same points.
    #[error(
        "wells \"{first}\" and \"{second}\" overlap: they are {distance:.3e} m apart, and their \
         radii add up to {radii:.3e} m; move them apart, refine the cloud or set smaller radii"
    )]
    OverlappingWells {
        /// Name.
        first: String,
        /// Name.
        second: String,
        /// Distance, m.
        distance: f64,
        /// Sum of radii, m.
        radii: f64,
    },
    /// The hole of a well reaches to where the operator tells the pressure around it.
    #[error(
        "well \"{name}\": with a hole of {radius:.3e} m and a skin of {skin} nothing is left between the bottom and \
         the points, which tell the pressure at {equivalent:.3e} m from the well; set a smaller wellbore_radius, a \
         greater skin, or coarsen the cloud"
    )]
    WideHole {
        /// Name.
        name: String,
        /// Radius of the hole, m.
        radius: f64,
        /// Its skin.
        skin: f64,
        /// Radius at which the exact pressure is the mean one of the well's points, m.
        equivalent: f64,
    },
    /// The exact pressure near a well is not known.
    #[error(
        "the bottom-hole pressure of well \"{name}\" at {at:?} cannot be told from the points within {reach:.3e} m: \
         {reason}; move the well, refine the cloud, or leave out wellbore_radius"
    )]
    CrampedWell {
        /// Name.
        name: String,
        /// Position, m.
        at: Vec<f64>,
        /// What is there.
        reason: &'static str,
        /// Distance, m.
        reach: f64,
    },
    /// A load's region touches no point of its side.
    #[error(
        "mechanics.loads.{name}: no point lies below its region on side {side}; enlarge the region or \
         refine the cloud"
    )]
    EmptyLoad {
        /// Name.
        name: String,
        /// The side.
        side: &'static str,
    },
    /// A load on a side that acts on another area than its points touch.
    #[error(
        "the points touch {touched:.4e} of side {side} (m, in space m^2), but a load on it would act on \
         {found:.4e}: a void is within two horizons of the side, or no point reaches it; move the void \
         or the load, or refine the cloud"
    )]
    SideArea {
        /// The side.
        side: &'static str,
        /// What the operator presents to a load, m^(D−1).
        found: f64,
        /// What cells touch, m^(D−1).
        touched: f64,
    },
    /// No broken point is near the place of an injection.
    #[error(
        "cracks.{name}.injection at {at:?}: no point of the crack within one horizon; move it onto the \
         crack"
    )]
    EmptyInjection {
        /// Name of the crack.
        name: String,
        /// Position, m.
        at: Vec<f64>,
    },
    /// The manufactured solution does not fit the scene.
    #[error("the manufactured source cannot be built: {0}")]
    Manufactured(String),
}

type Build<const D: usize> = fn(&Context<'_, D>) -> Result<Vec<Box<dyn Effect>>, EffectError>;

/// Every effect with the function that builds it, or nothing if the plan does not name it.
fn registry<const D: usize>() -> [Build<D>; 6] {
    [
        flux::build,
        gravity::build,
        wells::build,
        injection::build,
        source::build,
        own::of_flow,
    ]
}

/// Builds the effects the plan names and no others.
///
/// # Errors
/// [`EffectError`] if a named effect does not fit the cloud.
pub(crate) fn build<const D: usize>(context: &Context<'_, D>) -> Result<Vec<Counted>, EffectError> {
    let mut effects = Vec::new();
    for build in registry() {
        effects.extend(build(context)?.into_iter().map(Counted::new));
    }
    Ok(effects)
}

/// An effect with a counter of its evaluations.
pub struct Counted {
    effect: Box<dyn Effect>,
    evaluations: AtomicU64,
}

impl Counted {
    fn new(effect: Box<dyn Effect>) -> Self {
        Counted {
            effect,
            evaluations: AtomicU64::new(0),
        }
    }

    /// Adds the rate and counts.
    pub fn add_rate(&self, time: f64, rate: &mut [f64]) {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        self.effect.add_rate(time, rate);
    }

    /// How often the effect was evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// The effect itself.
    pub fn effect(&self) -> &dyn Effect {
        &*self.effect
    }
}

/// Sides whose parity is the given one.
fn sides_with<const D: usize>(
    extension: &MirrorContinuation<D>,
    parity: Parity,
) -> impl Iterator<Item = Side> {
    let found: Vec<Side> = Side::all(D)
        .filter(|&side| extension.parity(side) == parity)
        .collect();
    found.into_iter()
}

/// Vector from a slice of `D` numbers.
pub(crate) fn vector<const D: usize>(values: &[f64]) -> Vector<D> {
    Vector::from_fn(|axis, _| values.get(axis).copied().unwrap_or(0.0))
}
