//! Whether the points of a plan are where the plan thinks they are: bounds, volumes, probes.

use crate::effects::vector;
use crate::geometry::{Cloud, Locator, Side, Voids, neighbour_distances};
use crate::plan::{ActsOn, CrackKind, CrackPlan, DamageModel, GeometryPlan, Plan};

use super::{Bands, ModelError};

/// Median of V over the D-th power of the distance to the nearest other point that is believed. It is 1
/// on lattices, 4 and 8 in the plane and in space on jittered ones, 16 for cells of 4 : 4 : 1.
const DENSITY: [f64; 2] = [0.25, 40.0];
/// Share of the bounds that the cells may miss or exceed where there is no void.
const VOLUME: f64 = 0.1;
/// Spacings between a probe and the nearest point that are believed: corners of cubes are at 0.87.
const PROBE: f64 = 1.5;

/// Refuses own effects on a field that is not computed.
///
/// # Errors
/// [`ModelError::NothingToActOn`].
pub(super) fn check_effects(plan: &Plan) -> Result<(), ModelError> {
    for effect in &plan.own_effects {
        let (there, section) = match effect.acts_on() {
            ActsOn::Flow => (plan.flow.is_some(), "[flow]"),
            ActsOn::Solid => (plan.mechanics.is_some(), "[mechanics]"),
        };
        if !there {
            return Err(ModelError::NothingToActOn { section });
        }
    }
    Ok(())
}

/// Refuses points that do not fill the bounds or have other volumes, and probes where no point is.
///
/// # Errors
/// [`ModelError`], which says what does not fit.
pub(super) fn check<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<(), ModelError> {
    // The cells of a mesh are what they are, and its bounds are theirs.
    if let GeometryPlan::Points {
        path,
        any_volume,
        mesh: None,
        ..
    } = &plan.geometry
    {
        let refuse = |message: String| ModelError::Points {
            path: path.clone(),
            message,
        };
        if !any_volume {
            density(cloud).map_err(refuse)?;
            filling(cloud).map_err(refuse)?;
        }
        reach(cloud).map_err(refuse)?;
    }
    check_crack_fluid(plan, cloud)?;
    probes(plan, cloud)
}

/// Refuses fluid in broken rock where a uniform pressure would not be in equilibrium: broken points have next to no stiffness
/// across their crack and go where it drives them.
///
/// # Errors
/// [`ModelError::UnbalancedFluid`].
fn check_crack_fluid<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<(), ModelError> {
    let (Some(damage), Some(mechanics)) = (&plan.damage, &plan.mechanics) else {
        return Ok(());
    };
    // Fluid in a crack that is cut presses on its faces, not on broken points.
    let pressed = |crack: &CrackPlan| crack.kind == CrackKind::Damaged && crack.pressure.is_some();
    let wet = plan.fracture_flow.is_some() || plan.cracks.iter().any(pressed);
    let balanced = mechanics.corrects_gradient(cloud.irregular, cloud.domain.planes);
    if damage.model == DamageModel::Paper || !wet || balanced || !cloud.irregular {
        return Ok(());
    }
    let cut = plan.cracks.iter().any(|crack| crack.kind == CrackKind::Cut);
    Err(ModelError::UnbalancedFluid {
        remedy: match cut {
            true => "make all cracks kind = \"damaged\", or use a lattice",
            false => "set mechanics.gradient = \"divergence-consistent\", or use a lattice",
        },
    })
}

/// Volumes in another unit than positions do not fit the distances between the points.
fn density<const D: usize>(cloud: &Cloud<D>) -> Result<(), String> {
    let distance = neighbour_distances(cloud);
    let ratio = |(volume, distance): (&f64, &f64)| volume / distance.powi(D as i32);
    // A single point has no neighbour.
    let pairs = cloud
        .volume
        .iter()
        .zip(&distance)
        .filter(|(_, d)| d.is_finite());
    let mut ratios: Vec<f64> = pairs.map(ratio).collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let Some(&median) = ratios.get(ratios.len() / 2) else {
        return Ok(());
    };
    if (DENSITY[0]..DENSITY[1]).contains(&median) {
        return Ok(());
    }
    Err(format!(
        "the volumes do not fit the distances between the points: at half of them a volume is less than \
         {median:.1e} times the distance to the nearest point, to the power {D}; give volumes in m^{D} \
         where positions are in m, or set geometry.any_volume = true if this is meant"
    ))
}

/// Cells that are too many for the bounds, or too few where no part of them is left out.
fn filling<const D: usize>(cloud: &Cloud<D>) -> Result<(), String> {
    if !cloud.domain.planes {
        return Ok(());
    }
    let (filled, whole) = (
        cloud.volume.iter().sum::<f64>(),
        cloud.domain.size().product(),
    );
    let share = filled / whole;
    let why = match share {
        share if share > 1.0 + VOLUME => "more than there is room for",
        share if share < 1.0 - VOLUME && Voids::find(cloud).is_empty() => {
            "less, although the points leave no part of them out"
        }
        _ => return Ok(()),
    };
    Err(format!(
        "geometry.bounds hold {whole:.4e} m^{D}, and the volumes of the points add up to \
         {filled:.4e} m^{D}, {why}; correct the bounds or the volumes, or set geometry.any_volume = \
         true if this is meant"
    ))
}

/// A side farther than a spacing from all points acts on none.
fn reach<const D: usize>(cloud: &Cloud<D>) -> Result<(), String> {
    if !cloud.domain.planes {
        return Ok(());
    }
    // Volumes may be in another unit.
    let distance = neighbour_distances(cloud);
    for side in Side::all(D) {
        let gap = |i: usize| (cloud.position[i][side.axis] - cloud.domain.plane(side)).abs();
        let by_spacing = |i: &usize| gap(*i) / cloud.spacing(*i).max(distance[*i]);
        let nearest = (0..cloud.len()).min_by(|a, b| by_spacing(a).total_cmp(&by_spacing(b)));
        let Some(nearest) = nearest.filter(|i| by_spacing(i) > 1.0) else {
            continue;
        };
        return Err(format!(
            "no point reaches side {side} at {:.6} m: the nearest, at {:?}, is {:.1} spacings away, and \
             points are cell centres, half a cell inside the boundary; correct geometry.bounds",
            cloud.domain.plane(side),
            cloud.position[nearest].as_slice(),
            by_spacing(&nearest)
        ));
    }
    Ok(())
}

fn probes<const D: usize>(plan: &Plan, cloud: &Cloud<D>) -> Result<(), ModelError> {
    let output = &plan.output;
    // Generated clouds fill their box, and the scene has been checked against it.
    let read = matches!(plan.geometry, GeometryPlan::Points { .. });
    if !read || output.probes.is_empty() && output.profiles.is_empty() {
        return Ok(());
    }
    let locator = Locator::new(cloud);
    let check = |what: &'static str, name: &str, at: &[f64]| {
        let near = |i: &usize| (cloud.position[*i] - vector(at)).norm() < PROBE * cloud.spacing(*i);
        match locator.place(vector(at)).nearest.iter().any(near) {
            true => Ok(()),
            false => Err(ModelError::ProbeOffPoints {
                what,
                name: name.to_owned(),
                at: at.to_vec(),
            }),
        }
    };
    for probe in &output.probes {
        check("output.probes", &probe.name, &probe.at)?;
    }
    for profile in &output.profiles {
        for at in profile.places() {
            check("output.profiles", &profile.name, &at)?;
        }
    }
    Ok(())
}

/// Refuses cracks that are damaged from the start where there is no point.
///
/// # Errors
/// [`ModelError::EmptyBand`].
pub(super) fn check_bands(plan: &Plan, bands: &Bands) -> Result<(), ModelError> {
    let empty = |(crack, band): &(&crate::plan::CrackPlan, &Vec<u32>)| {
        crack.kind == CrackKind::Damaged && band.is_empty()
    };
    match plan.cracks.iter().zip(&bands.points).find(empty) {
        None => Ok(()),
        Some((crack, _)) => Err(ModelError::EmptyBand {
            name: crack.name.clone(),
        }),
    }
}
