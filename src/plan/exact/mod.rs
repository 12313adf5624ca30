//! The exact solution that a plan names, with its parameters taken from the plan itself.

mod fracture;
mod poroelastic;
mod well;

pub use fracture::exact_opening;
pub use well::exact_well_pressure;

use super::types::{
    GeometryPlan, MaterialPlan, PermeabilityPlan, Plan, ReferenceKind, SideCondition, TimeMode,
    WellPlan,
};
use crate::geometry::{Shape, Side};
use crate::material::Elasticity;
use crate::reference::{
    Axis, Ends, ExactDisplacement, ExactPressure, FiveSpot, FiveSpotTransient, InjectorCorner,
    Layer, Manufactured, TimeFactor, TwoLayer, TwoLayerParameters,
};

/// The exact pressure the plan names, if any.
///
/// # Errors
/// A message that says what of the plan the solution does not cover.
pub fn exact_pressure(plan: &Plan) -> Result<Option<Box<dyn ExactPressure>>, String> {
    let Some(reference) = &plan.reference else {
        return Ok(None);
    };
    Ok(Some(match reference.kind {
        ReferenceKind::FiveSpot => match plan.time.mode {
            TimeMode::Steady => Box::new(five_spot(plan)?),
            TimeMode::Transient => Box::new(five_spot_transient(plan)?),
        },
        ReferenceKind::TwoLayer => Box::new(two_layer(plan)?),
        ReferenceKind::Theis => well::theis(plan)?,
        ReferenceKind::Manufactured => match manufactured(plan)? {
            Some(solution) => Box::new(solution),
            None => return Ok(None),
        },
        ReferenceKind::Terzaghi => Box::new(poroelastic::terzaghi(plan)?),
        ReferenceKind::Mandel => Box::new(poroelastic::mandel(plan)?),
        ReferenceKind::Sneddon => return Ok(None),
    }))
}

/// The exact displacement the plan names, if any.
///
/// # Errors
/// As [`exact_pressure`].
pub fn exact_displacement(plan: &Plan) -> Result<Option<Box<dyn ExactDisplacement>>, String> {
    Ok(match plan.reference.map(|reference| reference.kind) {
        Some(ReferenceKind::Terzaghi) => Some(Box::new(poroelastic::terzaghi(plan)?)),
        Some(ReferenceKind::Mandel) => Some(Box::new(poroelastic::mandel(plan)?)),
        _ => None,
    })
}

/// Exact rate through the domain along x in m^D/s, for the two-layer reference in steady state.
pub fn exact_flux(plan: &Plan) -> Option<f64> {
    plan.reference
        .filter(|reference| reference.kind == ReferenceKind::TwoLayer)?;
    let (_, size) = domain(plan).ok()?;
    Some(two_layer(plan).ok()?.steady_flux() * size[1..].iter().product::<f64>())
}

/// The manufactured solution, if the plan names it.
///
/// # Errors
/// A message that says what does not fit.
pub fn manufactured(plan: &Plan) -> Result<Option<Manufactured>, String> {
    if plan
        .reference
        .is_none_or(|reference| reference.kind != ReferenceKind::Manufactured)
    {
        return Ok(None);
    }
    let (mobility, storage) = uniform(plan)?;
    let (origin, size) = domain(plan)?;
    let sides = sides(plan)?;
    let axes: Result<Vec<Axis>, String> = (0..plan.dimension)
        .map(|axis| {
            let pair = [0, 1].map(|k| &sides[2 * axis + k]);
            let zero = |side: &SideCondition| matches!(side, SideCondition::Pressure { value, .. } if value.values().iter().all(|v| *v == 0.0));
            let ends = match pair {
                [SideCondition::Sealed, SideCondition::Sealed] => Ends::Sealed,
                [a, b] if zero(a) && zero(b) => Ends::Prescribed,
                _ => {
                    return Err(format!(
                        "the manufactured solution needs both sides of axis {axis} sealed or both at \
                         pressure 0"
                    ));
                }
            };
            Ok(Axis { origin: origin[axis], size: size[axis], ends, half_waves: 1 })
        })
        .collect();
    let factor = match plan.time.mode {
        TimeMode::Steady => TimeFactor::Steady,
        TimeMode::Transient => TimeFactor::Oscillation {
            angular_frequency: std::f64::consts::TAU / plan.time.end,
        },
    };
    let amplitude = 1.0;
    Manufactured::new(&axes?, mobility, storage, amplitude, factor)
        .map(Some)
        .map_err(text)
}

fn text(error: impl ToString) -> String {
    error.to_string()
}

fn five_spot_transient(plan: &Plan) -> Result<FiveSpotTransient, String> {
    let (mobility, storage) = uniform(plan)?;
    let start = (plan.flow.as_ref()).map_or(0.0, |flow| flow.initial_pressure);
    FiveSpotTransient::new(five_spot(plan)?, mobility / storage, start).map_err(text)
}

fn five_spot(plan: &Plan) -> Result<FiveSpot, String> {
    let (mobility, _) = uniform(plan)?;
    let (origin, size) = domain(plan)?;
    require(
        size.len() == 2 && (size[0] - size[1]).abs() <= 1e-12 * size[0],
        "the five-spot needs a square",
    )?;
    let sealed = |side: &SideCondition| *side == SideCondition::Sealed;
    require(
        sides(plan)?.iter().take(4).all(sealed),
        "the five-spot needs sealed sides",
    )?;
    let [first, second] = plan.wells.as_slice() else {
        return Err("the five-spot needs exactly two wells".to_owned());
    };
    let (first_rate, second_rate) = (constant(first)?, constant(second)?);
    let (injector, producer, rate) = match first_rate > 0.0 {
        true => (first, second, first_rate),
        false => (second, first, second_rate),
    };
    let balanced = (first_rate + second_rate).abs() <= 1e-12 * rate.abs();
    require(
        balanced,
        "the five-spot needs wells of equal and opposite rates",
    )?;
    let corner = |well: &WellPlan| -> Option<[bool; 2]> {
        let at = |axis: usize| (well.at[axis] - origin[axis]) / size[axis];
        let is_corner = |x: f64| x.abs() < 1e-9 || (x - 1.0).abs() < 1e-9;
        (is_corner(at(0)) && is_corner(at(1))).then(|| [at(0) > 0.5, at(1) > 0.5])
    };
    let (Some(from), Some(to)) = (corner(injector), corner(producer)) else {
        return Err("the five-spot needs its wells on two corners".to_owned());
    };
    require(
        from[0] != to[0] && from[1] != to[1],
        "the five-spot needs wells on opposite corners",
    )?;
    let corner = match from {
        [false, false] => InjectorCorner::LowerLeft,
        [true, false] => InjectorCorner::LowerRight,
        [false, true] => InjectorCorner::UpperLeft,
        [true, true] => InjectorCorner::UpperRight,
    };
    let scale = FiveSpot::pressure_scale(rate, mobility);
    FiveSpot::new(size[0], [origin[0], origin[1]], scale, corner).map_err(text)
}

fn two_layer(plan: &Plan) -> Result<TwoLayer, String> {
    let (origin, size) = domain(plan)?;
    let [a, b] = plan.materials.as_slice() else {
        return Err("the two-layer solution needs exactly two materials".to_owned());
    };
    let (cut, near, far) = match (interface(a), interface(b)) {
        (Some((x, true)), _) => (x, a, b),
        (Some((x, false)), _) => (x, b, a),
        (None, Some((x, true))) => (x, b, a),
        (None, Some((x, false))) => (x, a, b),
        (None, None) => {
            return Err(
                "the two-layer solution needs a material whose region is a half-plane \
                        across x"
                    .to_owned(),
            );
        }
    };
    let sides = sides(plan)?;
    let end = |side: usize| match &sides[side] {
        SideCondition::Pressure {
            value,
            hydrostatic: false,
        } if value.is_constant() => Ok(value.at(0.0)),
        _ => Err(format!(
            "the two-layer solution needs a constant pressure on side {}",
            Side::from_index(side)
        )),
    };
    let layer = |material: &MaterialPlan, thickness: f64| -> Result<Layer, String> {
        let mobility = permeability(material)? / plan.fluid.viscosity;
        Ok(Layer {
            thickness,
            mobility,
            storage: storage(material)?,
        })
    };
    let first = cut - origin[0];
    TwoLayer::new(TwoLayerParameters {
        layers: [layer(near, first)?, layer(far, size[0] - first)?],
        end_pressures: [end(0)?, end(1)?],
        initial_pressure: plan.flow.as_ref().map_or(0.0, |flow| flow.initial_pressure),
        origin: origin[0],
        axis: 0,
    })
    .map_err(text)
}

/// Place of a half-plane across x, and whether it holds the smaller coordinates.
fn interface(material: &MaterialPlan) -> Option<(f64, bool)> {
    match &material.region {
        Some(Shape::HalfPlane { point, normal })
            if normal[0] != 0.0 && normal[1..].iter().all(|n| *n == 0.0) =>
        {
            Some((point[0], normal[0] > 0.0))
        }
        _ => None,
    }
}

fn require(condition: bool, message: &str) -> Result<(), String> {
    if condition {
        Ok(())
    } else {
        Err(message.to_owned())
    }
}

/// Mobility and storage of a plan with one uniform material.
fn uniform(plan: &Plan) -> Result<(f64, f64), String> {
    let [material] = plan.materials.as_slice() else {
        return Err("this reference needs exactly one material".to_owned());
    };
    Ok((
        permeability(material)? / plan.fluid.viscosity,
        storage(material)?,
    ))
}

fn permeability(material: &MaterialPlan) -> Result<f64, String> {
    let field = material.permeability.as_ref();
    field
        .and_then(PermeabilityPlan::uniform)
        .ok_or_else(|| one_value(material, "permeability"))
}

/// Storage of a material, 1/Pa, if it is the same everywhere in it.
fn storage(material: &MaterialPlan) -> Result<f64, String> {
    let storage = material.storage.uniform();
    storage.ok_or_else(|| one_value(material, "storage"))
}

/// The elastic constants of a material, if they are the same everywhere in it; `absent` where it has none.
fn elasticity(material: &MaterialPlan, absent: &str) -> Result<Elasticity, String> {
    let elasticity = material.elasticity.as_ref().ok_or(absent)?;
    let uniform = elasticity.uniform();
    uniform.ok_or_else(|| one_value(material, "Young's modulus and Poisson's ratio"))
}

/// What an exact solution says to a field.
fn one_value(material: &MaterialPlan, property: &str) -> String {
    format!(
        "this reference needs a uniform {property} of \"{}\"",
        material.name
    )
}

fn constant(well: &WellPlan) -> Result<f64, String> {
    let rate = well.rate().filter(|rate| rate.is_constant());
    rate.map(|rate| rate.at(0.0))
        .ok_or_else(|| "this reference needs constant well rates".to_owned())
}

fn domain(plan: &Plan) -> Result<(Vec<f64>, Vec<f64>), String> {
    let bounds = plan
        .geometry
        .bounds()
        .ok_or("this reference needs a box-shaped domain")?;
    let size = bounds
        .0
        .iter()
        .zip(&bounds.1)
        .map(|(low, high)| high - low)
        .collect();
    Ok((bounds.0, size))
}

fn sides(plan: &Plan) -> Result<&[SideCondition], String> {
    let flow = plan.flow.as_ref().ok_or("this reference needs [flow]")?;
    Ok(&flow.sides)
}

impl GeometryPlan {
    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            GeometryPlan::Lattice { size, .. } | GeometryPlan::Blocks { size, .. } => size.len(),
            GeometryPlan::Graded { axes, .. } => axes.len(),
            GeometryPlan::Points { table, .. } => table.dimension,
        }
    }

    /// Smallest and largest corner of the domain in metres, where planes are known.
    pub fn bounds(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let add = |origin: &[f64], size: &[f64]| -> (Vec<f64>, Vec<f64>) {
            (
                origin.to_vec(),
                origin.iter().zip(size).map(|(o, s)| o + s).collect(),
            )
        };
        match self {
            GeometryPlan::Lattice { origin, size, .. }
            | GeometryPlan::Blocks { origin, size, .. } => Some(add(origin, size)),
            GeometryPlan::Graded { origin, axes } => {
                let length = |axis: &Vec<crate::geometry::generate::Segment>| {
                    axis.iter().map(|s| s.length).sum()
                };
                Some(add(origin, &axes.iter().map(length).collect::<Vec<f64>>()))
            }
            GeometryPlan::Points { bounds, .. } => bounds.clone(),
        }
    }
}
