//! Terzaghi's and Mandel's solutions, with their parameters taken from the plan.

use super::{domain, elasticity, one_value, permeability, require, sides, storage, text};
use crate::geometry::Side;
use crate::load::Load;
use crate::material::Elasticity;
use crate::plan::{MechanicsPlan, Plan, SideCondition, Support};
use crate::reference::{Mandel, MandelParameters, Terzaghi, TerzaghiParameters};

/// The rock of a plan with one uniform poroelastic material.
struct Rock {
    elasticity: Elasticity,
    biot_coefficient: f64,
    storage: f64,
    mobility: f64,
}

fn rock(plan: &Plan) -> Result<Rock, String> {
    let [material] = plan.materials.as_slice() else {
        return Err("this reference needs exactly one material".to_owned());
    };
    Ok(Rock {
        elasticity: elasticity(material, "this reference needs elastic moduli")?,
        biot_coefficient: (material.biot_coefficient.as_ref())
            .ok_or("this reference needs [coupling]")?
            .uniform()
            .ok_or_else(|| one_value(material, "Biot coefficient"))?,
        storage: storage(material)?,
        mobility: permeability(material)? / plan.fluid.viscosity,
    })
}

fn mechanics(plan: &Plan) -> Result<&MechanicsPlan, String> {
    let mechanics = plan
        .mechanics
        .as_ref()
        .ok_or("this reference needs [mechanics]")?;
    require(
        !mechanics.inertia && mechanics.body_force.is_none() && plan.gravity.is_none(),
        "this reference needs quasi-static mechanics without body forces",
    )?;
    Ok(mechanics)
}

/// The only side with a prescribed pressure, which must be zero; all others must be sealed.
fn drained_side(plan: &Plan) -> Result<Side, String> {
    let message = "this reference needs pressure 0 on exactly one side and all others sealed";
    let zero = |side: &SideCondition| {
        matches!(side, SideCondition::Pressure { value, hydrostatic: false }
            if value.values().iter().all(|v| *v == 0.0))
    };
    let sides: Vec<(Side, &SideCondition)> =
        Side::all(plan.dimension).zip(sides(plan)?.iter()).collect();
    let mut drained = sides.iter().filter(|(_, condition)| zero(condition));
    let (Some((side, _)), None) = (drained.next(), drained.next()) else {
        return Err(message.to_owned());
    };
    let sealed = |(_, condition): &&(Side, &SideCondition)| **condition == SideCondition::Sealed;
    require(
        sides.iter().filter(sealed).count() + 1 == sides.len(),
        message,
    )?;
    Ok(*side)
}

/// Whether the side's normal displacement is held at zero.
fn is_held(support: &Support) -> bool {
    let zero = |load: &Load| load.values().iter().all(|v| *v == 0.0);
    match support {
        Support::Roller(load) => zero(load),
        Support::Prescribed(loads) => loads.iter().all(zero),
        _ => false,
    }
}

fn opposite(side: Side) -> Side {
    Side {
        axis: side.axis,
        upper: !side.upper,
    }
}

/// Terzaghi's column: loaded and drained at one end, held and sealed at the other.
///
/// # Errors
/// What of the plan the solution does not cover.
pub(super) fn terzaghi(plan: &Plan) -> Result<Terzaghi, String> {
    let (rock, mechanics, drained) = (rock(plan)?, mechanics(plan)?, drained_side(plan)?);
    let (origin, size) = domain(plan)?;
    let load = match &mechanics.sides[drained.index()] {
        Support::Traction(loads) if loads.iter().all(Load::is_constant) => {
            let other = |(axis, load): (usize, &Load)| axis == drained.axis || load.at(0.0) == 0.0;
            require(
                loads.iter().enumerate().all(other),
                "the Terzaghi solution needs a load normal to the drained side",
            )?;
            -drained.outward() * loads[drained.axis].at(0.0)
        }
        _ => {
            return Err(format!(
                "the Terzaghi solution needs a constant traction on the drained side {drained}"
            ));
        }
    };
    let held = |side: Side| side == drained || is_held(&mechanics.sides[side.index()]);
    require(
        Side::all(plan.dimension).all(held),
        "the Terzaghi solution needs rollers on all sides but the loaded one",
    )?;
    let end = |side: Side| origin[side.axis] + if side.upper { size[side.axis] } else { 0.0 };
    Terzaghi::new(TerzaghiParameters {
        axis: drained.axis,
        drained_end: end(drained),
        sealed_end: end(opposite(drained)),
        load,
        oedometer_modulus: rock.elasticity.oedometer_modulus(),
        biot_coefficient: rock.biot_coefficient,
        storage: rock.storage,
        mobility: rock.mobility,
    })
    .map_err(text)
}

/// A quarter of Mandel's strip: symmetry planes opposite the drained side and opposite the plate.
///
/// # Errors
/// What of the plan the solution does not cover.
pub(super) fn mandel(plan: &Plan) -> Result<Mandel, String> {
    require(plan.dimension == 2, "the Mandel solution is for the plane")?;
    let (rock, mechanics, drained) = (rock(plan)?, mechanics(plan)?, drained_side(plan)?);
    let (origin, size) = domain(plan)?;
    let plate = Side::all(2)
        .find(|side| matches!(mechanics.sides[side.index()], Support::Plate(_)))
        .filter(|side| side.axis != drained.axis)
        .ok_or("the Mandel solution needs a plate on a side next to the drained one")?;
    let force = match &mechanics.sides[plate.index()] {
        Support::Plate(load) if load.is_constant() => -plate.outward() * load.at(0.0),
        _ => return Err("the Mandel solution needs a constant force on its plate".to_owned()),
    };
    require(
        mechanics.sides[drained.index()] == Support::Free
            && [drained, plate]
                .iter()
                .all(|s| is_held(&mechanics.sides[opposite(*s).index()])),
        "the Mandel solution needs a free drained side, and rollers opposite it and the plate",
    )?;
    let mut centre = [0.0; 2];
    for side in [drained, plate] {
        let far = if side.upper { 0.0 } else { size[side.axis] };
        centre[side.axis] = origin[side.axis] + far;
    }
    Mandel::new(MandelParameters {
        half_width: size[drained.axis],
        height: size[plate.axis],
        origin: centre,
        drained_axis: drained.axis,
        force,
        lame_lambda: rock.elasticity.lambda(),
        shear_modulus: rock.elasticity.shear_modulus(),
        biot_coefficient: rock.biot_coefficient,
        storage: rock.storage,
        mobility: rock.mobility,
    })
    .map_err(text)
}
