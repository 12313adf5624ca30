//! Stress and pore pressure of the in-situ state as functions of place.

use std::sync::Arc;

use super::overburden::Overburden;
use crate::effects::{tensor, vector};
use crate::geometry::{Cloud, Matrix, Side, Vector};
use crate::model::ModelError;
use crate::model::properties::Properties;
use crate::plan::{FlowPlan, InitialPlan, Plan};

/// Components xx, yy, zz, xy, yz, xz.
type Stress = [f64; 6];

/// The in-situ state on a cloud.
pub(crate) struct InSitu<'a, const D: usize> {
    pub(super) initial: &'a InitialPlan,
    pub(super) cloud: Arc<Cloud<D>>,
    /// Unit vector along which depth grows.
    pub(super) down: Vector<D>,
    /// Depth of the origin below the datum of stresses, m.
    depth: f64,
    flow: Option<&'a FlowPlan>,
    /// Depth of the origin below the datum of the pressure, m.
    pressure_depth: f64,
    /// Weight of the fluid where it grows with depth, Pa/m.
    pub(super) fluid_weight: f64,
    /// Biot's coefficient per point; zero without coupling.
    pub(super) biot: Vec<f64>,
    /// Weight of the rock per point, N/m³; zero without gravity.
    pub(super) weight: Vec<f64>,
    overburden: Option<Overburden>,
    /// Which of the regions holds each point.
    pub(super) region: Vec<Option<usize>>,
}

impl<'a, const D: usize> InSitu<'a, D> {
    /// The in-situ state of a plan; `None` if it names none.
    ///
    /// # Errors
    /// [`ModelError`] for regions without points and weights that K₀ cannot follow.
    pub(crate) fn of(
        plan: &'a Plan,
        cloud: &Arc<Cloud<D>>,
        points: &Properties,
    ) -> Result<Option<Self>, ModelError> {
        let Some(initial) = &plan.initial else {
            return Ok(None);
        };
        let (down, gravity) = depth_of(plan);
        let corner = highest(cloud, &down);
        let origin = |datum: Option<f64>| datum.unwrap_or(-down.dot(&corner));
        let depth = origin(initial.datum);
        let flow = plan.flow.as_ref().filter(|_| plan.coupling.is_some());
        let deep = flow.is_some_and(|flow| flow.hydrostatic_start);
        let weight: Vec<f64> = match points.density.is_empty() {
            true => vec![0.0; cloud.len()],
            false => points.density.iter().map(|own| own * gravity).collect(),
        };
        let overburden = match initial.k0 {
            Some(_) => Some(Overburden::of(cloud, &down, depth, &weight)?),
            None => None,
        };
        Ok(Some(InSitu {
            initial,
            cloud: cloud.clone(),
            down,
            depth,
            pressure_depth: origin(flow.and_then(|flow| flow.datum)),
            flow,
            fluid_weight: if deep {
                plan.fluid.density * gravity
            } else {
                0.0
            },
            biot: match points.biot_coefficient.is_empty() {
                true => vec![0.0; cloud.len()],
                false => points.biot_coefficient.clone(),
            },
            weight,
            overburden,
            region: regions(initial, cloud)?,
        }))
    }

    /// Pore pressure at a place, Pa; zero without coupling.
    fn pressure(&self, x: &Vector<D>) -> f64 {
        let depth = self.pressure_depth + self.down.dot(x);
        (self.flow).map_or(0.0, |flow| {
            flow.initial_pressure + self.fluid_weight * depth
        })
    }

    /// Stress at a place with the properties and the region of a point, Pa, and whether it is a total one.
    fn given(&self, point: usize, x: &Vector<D>) -> (Stress, bool) {
        let depth = self.depth + self.down.dot(x);
        if let Some(region) = self.region[point] {
            return (self.initial.regions[region].1, self.initial.total);
        }
        if let (Some(k0), Some(overburden)) = (self.initial.k0, &self.overburden) {
            let vertical = self.biot[point] * self.pressure(x) - overburden.weight(depth);
            return (self.at_rest(k0, vertical), false);
        }
        let linear = |k: usize| self.initial.stress[k] + self.initial.gradient[k] * depth;
        (std::array::from_fn(linear), self.initial.total)
    }

    /// Vertical stress σ and K₀ σ in all directions across it.
    fn at_rest(&self, k0: f64, vertical: f64) -> Stress {
        let along = |axis: usize| if axis < D { self.down[axis] } else { 0.0 };
        let component = |a: usize, b: usize| {
            let across = if a == b { k0 } else { 0.0 };
            vertical * (across + (1.0 - k0) * along(a) * along(b))
        };
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].map(|(a, b)| component(a, b))
    }

    /// Effective stress of a point, Pa.
    pub(crate) fn effective(&self, point: usize) -> Stress {
        let x = &self.cloud.position[point];
        let (stress, total) = self.given(point, x);
        let push = if total { self.push(point, x) } else { 0.0 };
        shifted(stress, push)
    }

    /// Total stress at a place beside a point, such as its foot on a side, Pa.
    pub(crate) fn total_at(&self, point: usize, x: &Vector<D>) -> Matrix<D> {
        let (stress, total) = self.given(point, x);
        let push = if total { 0.0 } else { self.push(point, x) };
        tensor(&shifted(stress, -push))
    }

    /// Total stress of a point, Pa.
    pub(crate) fn total_tensor(&self, point: usize) -> Matrix<D> {
        self.total_at(point, &self.cloud.position[point])
    }

    /// α p, Pa.
    fn push(&self, point: usize, x: &Vector<D>) -> f64 {
        self.biot[point] * self.pressure(x)
    }

    /// Largest total or effective stress, Pa.
    pub(crate) fn level(&self) -> f64 {
        let at = |point: usize| {
            let effective = self.effective(point).into_iter();
            let own = effective.fold(0.0_f64, |most, value| most.max(value.abs()));
            own.max(self.total_tensor(point).amax())
        };
        (0..self.cloud.len()).map(at).fold(0.0, f64::max)
    }

    /// The level times the surface of the domain, N: a scale for what is left of forces in balance.
    pub(crate) fn force(&self) -> f64 {
        let domain = &self.cloud.domain;
        self.level() * Side::all(D).map(|side| domain.area(side)).sum::<f64>()
    }
}

/// A stress with a pressure added to its normal components.
fn shifted(mut stress: Stress, by: f64) -> Stress {
    stress[..3].iter_mut().for_each(|own| *own += by);
    stress
}

/// The direction of depth and the strength of gravity, m/s².
fn depth_of<const D: usize>(plan: &Plan) -> (Vector<D>, f64) {
    let gravity = plan.gravity.as_ref();
    let acceleration: Vector<D> =
        gravity.map_or_else(Vector::zeros, |gravity| vector(&gravity.acceleration));
    match acceleration.norm() {
        strength if strength > 0.0 => (acceleration / strength, strength),
        _ => (
            Vector::from_fn(|a, _| if a + 1 == D { -1.0 } else { 0.0 }),
            0.0,
        ),
    }
}

/// The corner of the domain that is highest.
fn highest<const D: usize>(cloud: &Cloud<D>, down: &Vector<D>) -> Vector<D> {
    let (lower, upper) = (&cloud.domain.lower, &cloud.domain.upper);
    Vector::from_fn(|a, _| if down[a] < 0.0 { upper[a] } else { lower[a] })
}

/// The last of the regions that holds each point.
fn regions<const D: usize>(
    initial: &InitialPlan,
    cloud: &Cloud<D>,
) -> Result<Vec<Option<usize>>, ModelError> {
    let holds = |x: &Vector<D>| {
        let mut regions = initial.regions.iter();
        regions.rposition(|(region, _)| region.contains(x.as_slice()))
    };
    let found: Vec<Option<usize>> = cloud.position.iter().map(holds).collect();
    match (0..initial.regions.len()).find(|own| !found.contains(&Some(*own))) {
        Some(lost) => Err(ModelError::EmptyStressRegion { number: lost + 1 }),
        None => Ok(found),
    }
}
