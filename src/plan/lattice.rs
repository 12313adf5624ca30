//! Along which axes of a lattice the rows of a linear system repeat, and how its unknowns go on across the sides.

use perifrac_solvers::{Lattice, LatticeAxis, Mirror};

use super::capability::System;
use super::{GeometryPlan, GradientChoice, Plan, Shape, SideCondition, Support, WellPlan};
use crate::geometry::Side;

/// The points of a plan as a lattice for a linear system, as far as the plan alone tells: what varies from
/// point to point is not known yet.
///
/// # Errors
/// Why rows repeat along no axis at all, in words that end a sentence.
pub fn lattice(plan: &Plan, system: System) -> Result<Lattice, String> {
    let GeometryPlan::Lattice { cells, jitter, .. } = &plan.geometry else {
        return Err("here cells differ in size or place".to_owned());
    };
    if let Some(reason) = uneven(plan, system, *jitter) {
        return Err(reason.to_owned());
    }
    let axes = cells.iter().enumerate().map(|(axis, &count)| LatticeAxis {
        count,
        mirrors: mirrors(plan, system, axis),
    });
    Ok(Lattice {
        axes: axes.collect(),
    })
}

/// What makes rows differ everywhere.
fn uneven(plan: &Plan, system: System, jitter: f64) -> Option<&'static str> {
    let flow = plan.flow.as_ref().filter(|_| system != System::Mechanics);
    let solid = (plan.mechanics.as_ref()).filter(|_| system != System::Flow);
    let corrected = [
        flow.map(|flow| flow.gradient),
        solid.map(|solid| solid.gradient),
    ];
    // Only regions along the axes can be layers; others end askew between points.
    let straight =
        (plan.materials.iter().filter_map(|own| own.region.as_ref())).all(|region| match region {
            Shape::Box { .. } => true,
            Shape::HalfPlane { normal, .. } => {
                normal.iter().filter(|part| part.abs() > 0.0).count() == 1
            }
            Shape::Disc { .. } | Shape::Polygon { .. } | Shape::Set { .. } => false,
        });
    if jitter > 0.0 {
        Some("here points are jittered")
    } else if plan.damage.is_some() {
        Some("here rock breaks")
    } else if !plan.cracks.is_empty() {
        Some("here cracks cut bonds")
    } else if flow.is_some_and(|flow| !flow.regions.is_empty()) {
        Some("here points have a prescribed pressure")
    } else if flow.is_some() && plan.has_tensors() {
        Some("here permeability is a tensor")
    } else if flow.is_some() && plan.wells.iter().any(WellPlan::holds) {
        Some("here a well holds a pressure")
    } else if corrected.contains(&Some(GradientChoice::DivergenceConsistent)) {
        Some("here the gradient is made divergence-consistent")
    } else if !straight {
        Some("here materials have regions with sides askew")
    } else {
        None
    }
}

/// Mirrors of all unknowns at both sides of an axis, or what stands against them.
fn mirrors(plan: &Plan, system: System, axis: usize) -> Result<Vec<[Mirror; 2]>, String> {
    let side = |upper: bool| mirror(plan, system, Side { axis, upper });
    let (lower, upper) = (side(false)?, side(true)?);
    Ok(lower.into_iter().zip(upper).map(|(l, u)| [l, u]).collect())
}

/// Mirrors of all unknowns at a side.
fn mirror(plan: &Plan, system: System, side: Side) -> Result<Vec<Mirror>, String> {
    let flow = plan.flow.as_ref().map(|flow| &flow.sides[side.index()]);
    let support = (plan.mechanics.as_ref()).map(|solid| &solid.sides[side.index()]);
    let displacement = || {
        let along = |axis: usize| {
            if axis == side.axis {
                Mirror::Odd
            } else {
                Mirror::Even
            }
        };
        (0..plan.dimension).map(along).collect::<Vec<_>>()
    };
    let held = match support {
        Some(Support::Free) => Some("free"),
        Some(Support::Traction(_)) => Some("under traction"),
        Some(Support::Prescribed(_)) => Some("clamped"),
        Some(Support::Roller(_) | Support::Plate(_)) | None => None,
    };
    let pressure = match flow {
        Some(SideCondition::Pressure { .. }) => Ok(Mirror::Odd),
        Some(SideCondition::Flux(_)) => Err(format!("`{side}` has a prescribed flux")),
        Some(SideCondition::Sealed) | None => Ok(Mirror::Even),
    };
    match (system, held) {
        (System::Flow, _) => Ok(vec![pressure?]),
        (_, Some(held)) => Err(format!("`{side}` is {held}")),
        (System::Mechanics, None) => Ok(displacement()),
        // A roller turns the displacement along it to itself, and with it only a pressure that is even.
        (System::Monolithic, None) => match pressure? {
            Mirror::Even => Ok([displacement(), vec![Mirror::Even]].concat()),
            Mirror::Odd => Err(format!("`{side}` slides and is drained")),
        },
    }
}
