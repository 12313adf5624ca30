//! Sneddon's crack, with its parameters taken from the plan.

use super::{domain, elasticity, require, text};
use crate::plan::{CrackPlan, Plan, ReferenceKind, Support};
use crate::reference::Sneddon;

/// The exact opening of the only crack, if the plan names Sneddon's.
///
/// # Errors
/// A message that says what of the plan the solution does not cover.
pub fn exact_opening(plan: &Plan) -> Result<Option<Sneddon>, String> {
    if plan.reference.map(|reference| reference.kind) != Some(ReferenceKind::Sneddon) {
        return Ok(None);
    }
    let [crack] = plan.cracks.as_slice() else {
        return Err("Sneddon's solution needs exactly one crack".to_owned());
    };
    require(
        crack.pressure.is_some(),
        "Sneddon's solution needs a `pressure` in the crack",
    )?;
    let [material] = plan.materials.as_slice() else {
        return Err("Sneddon's solution needs exactly one material".to_owned());
    };
    let rock = elasticity(material, "Sneddon's solution needs elastic moduli")?;
    let (middle, half_length) = extent(plan, crack)?;
    Sneddon::new(
        middle,
        half_length,
        rock.youngs_modulus,
        rock.poissons_ratio,
    )
    .map(Some)
    .map_err(text)
}

/// Middle and half length of the whole crack; a tip on a side of symmetry is its middle.
fn extent(plan: &Plan, crack: &CrackPlan) -> Result<([f64; 2], f64), String> {
    let [first, last] = crack.points() else {
        return Err("Sneddon's solution needs a straight crack of two points".to_owned());
    };
    let length = (0..2)
        .map(|axis| (last[axis] - first[axis]).powi(2))
        .sum::<f64>()
        .sqrt();
    let (lower, size) = domain(plan)?;
    let mirrors = |tip: &[f64; 2], other: &[f64; 2]| {
        let sides = plan.mechanics.as_ref().map(|mechanics| &mechanics.sides);
        (0..2).any(|axis| {
            let on = |plane: f64| (tip[axis] - plane).abs() <= 1e-9 * size[axis];
            let across = (tip[1 - axis] - other[1 - axis]).abs() <= 1e-9 * length;
            let planes = [lower[axis], lower[axis] + size[axis]];
            planes.iter().enumerate().any(|(k, plane)| {
                let roller =
                    |sides: &Vec<Support>| matches!(sides[2 * axis + k], Support::Roller(_));
                on(*plane) && across && sides.is_some_and(roller)
            })
        })
    };
    Ok(match (mirrors(first, last), mirrors(last, first)) {
        (true, false) => (*first, length),
        (false, true) => (*last, length),
        (true, true) => return Err("Sneddon's crack does not go through the domain".to_owned()),
        (false, false) => (
            [0, 1].map(|axis| 0.5 * (first[axis] + last[axis])),
            0.5 * length,
        ),
    })
}
