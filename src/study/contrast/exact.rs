//! What flows at a contrast: exactly through layers in series and across a cylinder, else between two points per face.

use crate::geometry::{Shape, Side, Vector, border};
use crate::model::{Model, material_at};
use crate::plan::{GeometryPlan, Plan, SideCondition};
use crate::reference::{square_array_of_cylinders, two_point_flow};
use crate::report::Timers;

/// What the flux of runs is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// The flux through layers in series, which is exact.
    Series,
    /// The flux across a square array of cylinders, which is exact.
    Cylinders,
    /// The flux between two points per face, on the same points.
    TwoPoint,
}

/// Rates of steady flow from one side of a plane lattice to the opposite one, m²/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
    /// The measure.
    pub(super) measure: Measure,
    /// Its rate.
    pub(super) rate: f64,
    /// The rate of the flux between two points.
    pub(super) two_point: f64,
}

/// The axis along which pressures on two sides drive the flow of a plane lattice, and their difference, Pa;
/// `None` where that is not all that drives it.
pub(super) fn driven(plan: &Plan) -> Option<(usize, f64)> {
    let flow = plan.flow.as_ref()?;
    let alone = plan.dimension == 2
        && plan.wells.is_empty()
        && plan.gravity.is_none()
        && plan.coupling.is_none()
        && flow.regions.is_empty()
        && matches!(plan.geometry, GeometryPlan::Lattice { jitter, .. } if jitter <= 0.0);
    let pressure = |side: &SideCondition| match side {
        SideCondition::Pressure {
            value,
            hydrostatic: false,
        } if value.is_constant() => Some(value.at(0.0)),
        _ => None,
    };
    let sealed = |side: &SideCondition| matches!(side, SideCondition::Sealed);
    let along = |axis: usize| {
        let across = 2 * (1 - axis);
        let closed = flow.sides[across..across + 2].iter().all(sealed);
        let ends = [0, 1].map(|end| pressure(&flow.sides[2 * axis + end]));
        match ends {
            [Some(low), Some(high)] if closed => Some((axis, low - high)),
            _ => None,
        }
    };
    (0..2).filter(|_| alone).find_map(along)
}

/// The side through which the flow of [`driven`] leaves.
pub(super) fn outlet(axis: usize) -> &'static str {
    Side { axis, upper: true }.name()
}

/// What flows by a plan; `None` if it has no such flow.
pub(super) fn known(plan: &Plan) -> Option<Known> {
    let (axis, drop) = driven(plan)?;
    let GeometryPlan::Lattice { size, cells, .. } = &plan.geometry else {
        return None;
    };
    let cells = [cells[0], cells[1]];
    let model: Model<2> = Model::build(plan, &mut Timers::default()).ok()?;
    let flow = model.flow.as_ref()?;
    let edges = [0, 1].map(|k| size[k] / cells[k] as f64);
    let two_point = drop * plan.thickness * two_point_flow(cells, edges, &flow.mobility, axis);
    let places = &flow.operator.neighbourhood().cloud.position;
    let drive = drop * plan.thickness;
    let (measure, rate) = if let Some(resistance) = series(plan, places, cells, axis) {
        (Measure::Series, drive * size[1 - axis] / resistance)
    } else if let Some(mobility) = cylinder(plan, size) {
        (Measure::Cylinders, drive * mobility)
    } else {
        (Measure::TwoPoint, two_point)
    };
    Some(Known {
        measure,
        rate,
        two_point,
    })
}

/// Mobility of a square with one cylinder in its middle, m²/(Pa s); `None` for all other scenes, and where the cylinder nearly touches the
/// sides. Sealed sides and sides
/// of one pressure mirror it, so that it is one of a square array.
fn cylinder(plan: &Plan, size: &[f64]) -> Option<f64> {
    let [rock, other] = &plan.materials[..] else {
        return None;
    };
    let (None, Some(Shape::Disc { centre, radius })) = (&rock.region, &other.region) else {
        return None;
    };
    let edge = size[0];
    let same = |one: f64, two: f64| (one - two).abs() <= 1e-9 * edge;
    let (lower, upper) = plan.geometry.bounds()?;
    let middle = (lower.iter().zip(&upper)).map(|(low, high)| 0.5 * (low + high));
    let central = middle.zip(centre).all(|(middle, own)| same(middle, *own));
    if !same(edge, size[1]) || !central {
        return None;
    }
    let [around, within] = [rock, other].map(|own| own.permeability.as_ref()?.uniform());
    let (around, within) = (around?, within?);
    let relative = square_array_of_cylinders(radius / edge, within / around)?;
    Some(relative * around / plan.fluid.viscosity)
}

/// ∫ ds/κ along an axis through the regions of the materials, s Pa/m; `None` unless all points in a row
/// across it are of one material with one value.
fn series(plan: &Plan, places: &[Vector<2>], cells: [usize; 2], axis: usize) -> Option<f64> {
    let stride = [1, cells[0]];
    let material = |x: &Vector<2>| material_at(plan, x);
    let row = |k: usize| &places[k * stride[axis]];
    for k in 0..cells[axis] {
        let across = (0..cells[1 - axis]).map(|m| &places[k * stride[axis] + m * stride[1 - axis]]);
        if across.map(material).any(|own| own != material(row(k))) {
            return None;
        }
    }
    let resistivity = |own: Option<u16>| {
        let permeability = plan.materials[usize::from(own?)].permeability.as_ref()?;
        Some(plan.fluid.viscosity / permeability.uniform()?)
    };
    let (lower, upper) = plan.geometry.bounds()?;
    let (mut sum, mut from) = (0.0, lower[axis]);
    for k in 1..cells[axis] {
        let (own, next) = (material(row(k - 1)), material(row(k)));
        if own == next {
            continue;
        }
        let (start, end) = (*row(k - 1), *row(k));
        let share = border((0.0, 1.0), |share| {
            material(&start.lerp(&end, share)) == own
        });
        let interface = start.lerp(&end, share)[axis];
        sum += (interface - from) * resistivity(own)?;
        from = interface;
    }
    let last = material(row(cells[axis] - 1));
    Some(sum + (upper[axis] - from) * resistivity(last)?)
}
