//! Effects that a program hands in, beside those that a scene names.

use std::fmt;
use std::sync::Arc;

/// A contribution to the right-hand side of a field: the rate of volume at the points for flow, the
/// force on the displacement unknowns for mechanics.
///
/// A program adds its own with [`OwnEffect`].
pub trait Effect: Send + Sync {
    /// Name in scenes and reports.
    fn name(&self) -> &'static str;

    /// Adds the rate at `time` to `rate`: shape `(n,)` in m^D/s, or `(n·D,)` in N.
    fn add_rate(&self, time: f64, rate: &mut [f64]);

    /// Total rate of fluid brought in at `time`, m^D/s; zero for what only moves fluid about.
    fn injection(&self, _time: f64) -> f64 {
        0.0
    }

    /// Sum of the absolute rates at `time`, m^D/s: the scale of balances.
    fn gross(&self, time: f64) -> f64 {
        self.injection(time).abs()
    }

    /// Times at which the rate's slope jumps; steps end there.
    fn breakpoints(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Whether the rate is the same at all times.
    fn is_constant(&self) -> bool {
        self.breakpoints().is_empty()
    }

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// The points of a run, as an own effect sees them while it is built.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Points<'a> {
    /// 2 or 3.
    pub dimension: usize,
    /// Coordinates point by point, m. Shape `(n·D,)`.
    pub position: &'a [f64],
    /// Volume of the cell of each point, m^D. Shape `(n,)`.
    pub volume: &'a [f64],
}

/// The equation an own effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsOn {
    /// Balance of fluid: rates in m^D/s, one per point.
    Flow,
    /// Balance of forces: forces in N (per metre of thickness in the plane), D per point.
    Solid,
}

type Build = dyn Fn(&Points<'_>) -> Box<dyn Effect> + Send + Sync;

/// An [`Effect`] of the program itself, and how it is built once the points are known. It goes into
/// [`Plan::own_effects`](super::Plan::own_effects), for which there is
/// [`Setup::effect`](super::Setup::effect).
///
/// ```
/// use perifrac::prelude::*;
///
/// /// A leak into every point, by its volume.
/// struct Leak(Vec<f64>);
///
/// impl Effect for Leak {
///     fn name(&self) -> &'static str {
///         "leak"
///     }
///     fn add_rate(&self, _time: f64, rate: &mut [f64]) {
///         rate.iter_mut().zip(&self.0).for_each(|(rate, volume)| *rate += 1e-6 * volume);
///     }
///     fn injection(&self, _time: f64) -> f64 {
///         1e-6 * self.0.iter().sum::<f64>()
///     }
///     fn bytes(&self) -> usize {
///         size_of_val(&self.0[..])
///     }
/// }
///
/// let scene = r#"
///     title = "A closed square"
///     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
///     fluid.viscosity = "1 mPa s"
///     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
///     flow = {}
///     time.end = "1 s"
/// "#;
/// let leak = OwnEffect::on_flow(|points| Leak(points.volume.to_vec()));
/// let plan = Setup::text(scene).effect(leak).plan()?;
/// let (_, state) = run(&plan, None, &mut (), &Interrupt::default())?;
/// // A rate of 1e-6 over a storage of 1e-9 is 1000 Pa a second.
/// assert!(state.pressure.iter().all(|p| (p - 1e3).abs() < 1e-3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct OwnEffect {
    acts_on: ActsOn,
    build: Arc<Build>,
}

impl OwnEffect {
    /// A source of fluid, built by `build` from the points.
    pub fn on_flow<E: Effect + 'static>(
        build: impl Fn(&Points<'_>) -> E + Send + Sync + 'static,
    ) -> Self {
        Self::new(ActsOn::Flow, build)
    }

    /// A force on the rock, built by `build` from the points.
    pub fn on_solid<E: Effect + 'static>(
        build: impl Fn(&Points<'_>) -> E + Send + Sync + 'static,
    ) -> Self {
        Self::new(ActsOn::Solid, build)
    }

    fn new<E: Effect + 'static>(
        acts_on: ActsOn,
        build: impl Fn(&Points<'_>) -> E + Send + Sync + 'static,
    ) -> Self {
        OwnEffect {
            acts_on,
            build: Arc::new(move |points| Box::new(build(points))),
        }
    }

    /// The equation it acts on.
    pub fn acts_on(&self) -> ActsOn {
        self.acts_on
    }

    /// Builds it on these points.
    pub fn on(&self, points: &Points<'_>) -> Box<dyn Effect> {
        (self.build)(points)
    }
}

impl fmt::Debug for OwnEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnEffect")
            .field("acts_on", &self.acts_on)
            .finish_non_exhaustive()
    }
}
