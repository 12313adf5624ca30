//! The area of a side that points touch, against what an operator makes of it.

use super::EffectError;
use crate::geometry::{Cloud, Locator, Side, Vector, Voids};

/// Share by which the area that acts may differ from the area that points touch.
const TRUSTED: f64 = 0.05;

/// The area of `side` that loads act on, m^(D−1), where the operator presents `found`.
///
/// Where the cells fill the domain it is that of the side, where they leave voids that of the cells on the
/// side, which a mesh knows. What the operator found is no more than a check: near a void it also holds the void's surface.
///
/// # Errors
/// [`EffectError::SideArea`] if the load would act on another area than the cells touch.
pub(super) fn acting_area<const D: usize>(
    cloud: &Cloud<D>,
    side: Side,
    found: f64,
) -> Result<f64, EffectError> {
    let told = cloud.outline.as_ref();
    let told = told.and_then(|own| own.side_area.get(side.index()).copied());
    let whole = told.unwrap_or_else(|| cloud.domain.area(side));
    let refuse = |touched: f64| EffectError::SideArea {
        side: side.name(),
        found,
        touched,
    };
    if Voids::find(cloud).is_empty() {
        // What is left of a correction is scaled away.
        return match found > 0.5 * whole && whole > 0.0 {
            true => Ok(whole),
            false => Err(refuse(whole)),
        };
    }
    let touched = told.unwrap_or_else(|| touched_area(cloud, side));
    match (found - touched).abs() <= TRUSTED * touched {
        true => Ok(touched),
        false => Err(refuse(touched)),
    }
}

/// Faces on the side of the cells that touch it.
///
/// Cells are taken for cubes where the points lie half an edge inside, for cells of the height that the
/// points tell elsewhere; those of about the same size together, so that jitter evens out.
fn touched_area<const D: usize>(cloud: &Cloud<D>, side: Side) -> f64 {
    let gap = |i: usize| (cloud.position[i][side.axis] - cloud.domain.plane(side)).abs();
    let mut first: Vec<(i32, usize)> = nearest_to(cloud, side)
        .into_iter()
        .map(|i| (cloud.spacing(i).log2().round() as i32, i))
        .collect();
    first.sort_unstable();
    let area = |own: &[(i32, usize)]| -> f64 {
        let count = own.len() as f64;
        let height = 2.0 * own.iter().map(|(_, i)| gap(*i)).sum::<f64>() / count;
        let edge = own.iter().map(|(_, i)| cloud.spacing(*i)).sum::<f64>() / count;
        let cubes = (height / edge - 1.0).abs() < 0.25;
        let face = |i: usize| cloud.volume[i] / if cubes { cloud.spacing(i) } else { height };
        own.iter().map(|(_, i)| face(*i)).sum()
    };
    first.chunk_by(|a, b| a.0 == b.0).map(area).sum()
}

/// Points with no other point between them and the side, and not farther than about a cell.
fn nearest_to<const D: usize>(cloud: &Cloud<D>, side: Side) -> Vec<usize> {
    let gap = |i: usize| (cloud.position[i][side.axis] - cloud.domain.plane(side)).abs();
    let near: Vec<usize> = (0..cloud.len())
        .filter(|&i| gap(i) < 1.25 * cloud.spacing(i))
        .collect();
    let locator = Locator::new(cloud);
    let foot = |i: &usize| -> Vector<D> {
        let mut foot = cloud.position[*i];
        foot[side.axis] = cloud.domain.plane(side);
        foot
    };
    let is_first = |i: &usize| locator.place(foot(i)).nearest.contains(i);
    near.into_iter().filter(is_first).collect()
}
