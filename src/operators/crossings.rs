//! Which bonds run through the cells of points.
//!
//! A bond carries its flux along all of its length, also through cells of points it does not end at. The
//! length is shared by samples, each of which lies in the cell of the nearest point among the bond's owner
//! and its family. Where that is an image, the mirrored bond lies in the cell of the real point.

use super::Neighbourhood;
use crate::geometry::Vector;
use crate::parallel;

/// A part of a bond in the cell of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    /// Number of the cell in the list of points asked for.
    pub cell: u32,
    /// Number of the bond's owner in [`Crossings::owners`].
    pub owner: u32,
    /// The bond.
    pub bond: u32,
    /// Image of the point in whose cell it lies.
    pub image: u8,
    /// Part of its length.
    pub share: f64,
}

/// All bonds through some cells.
#[derive(Debug, Clone, Default)]
pub(crate) struct Crossings {
    /// Points whose families have such bonds, ascending.
    pub owners: Vec<u32>,
    /// The parts, by owner and bond.
    pub parts: Vec<Crossing>,
}

/// Difference of squared distances, relative to them, of a sample on the border of two cells.
const BORDER: f64 = 1e-9;

impl Crossings {
    /// Finds all bonds through the cells of `points`.
    pub(crate) fn of<const D: usize>(around: &Neighbourhood<D>, points: &[u32]) -> Self {
        let families = &around.families;
        let mut cell = vec![u32::MAX; families.len()];
        for (number, &point) in (0_u32..).zip(points) {
            cell[point as usize] = number;
        }
        let seen = |&point: &u32| families.dual(point as usize).map(|(owner, _)| owner as u32);
        let mut owners: Vec<u32> = points.iter().flat_map(seen).collect();
        owners.extend(points);
        owners.sort_unstable();
        owners.dedup();
        let parts = parallel::gather(owners.len(), |number, parts| {
            let owner = owners[number] as usize;
            cells_along(around, owner, |bond, (point, image), share| {
                if cell[point] != u32::MAX {
                    parts.push(Crossing {
                        cell: cell[point],
                        owner: number as u32,
                        bond: bond as u32,
                        image,
                        share,
                    });
                }
            });
        });
        Crossings { owners, parts }
    }
}

/// Calls `visit(bond, (point, image), share)` for the cells along the bonds of a family.
pub(crate) fn cells_along<const D: usize>(
    around: &Neighbourhood<D>,
    owner: usize,
    mut visit: impl FnMut(usize, (usize, u8), f64),
) {
    let families = &around.families;
    let family = families.family(owner);
    let arms: Vec<Vector<D>> = (family.clone())
        .map(|bond| around.bond_vector(owner, bond))
        .collect();
    let end = |bond: usize| (families.neighbour(bond), families.image(bond));
    for (bond, arm) in family.clone().zip(&arms) {
        let samples = samples(around, owner, bond, arm);
        let share = 1.0 / samples as f64;
        visit(bond, (owner, 0), share);
        visit(bond, end(bond), share);
        for sample in 1..samples - 1 {
            let at = arm * ((sample as f64 + 0.5) * share);
            let gaps = arms.iter().map(|arm| (arm - at).norm_squared());
            let nearest = gaps.clone().fold(at.norm_squared(), f64::min);
            let limit = nearest + BORDER * arm.norm_squared();
            let own = (at.norm_squared() <= limit).then_some((owner, 0));
            let others = family.clone().zip(gaps).filter(|(_, gap)| *gap <= limit);
            let cells: Vec<(usize, u8)> = own
                .into_iter()
                .chain(others.map(|(other, _)| end(other)))
                .collect();
            let part = share / cells.len() as f64;
            cells.into_iter().for_each(|cell| visit(bond, cell, part));
        }
    }
}

/// Twice the number of cells that a bond spans along one axis: on a lattice no border of cells that are
/// met by an edge of another lies within a sample then.
fn samples<const D: usize>(
    around: &Neighbourhood<D>,
    owner: usize,
    bond: usize,
    arm: &Vector<D>,
) -> usize {
    let cell = &around.cloud.cell;
    let edges = cell[owner].inf(&cell[around.families.neighbour(bond)]);
    let spans = (0..D).map(|axis| arm[axis].abs() / edges[axis]);
    2 * spans.fold(1.0, f64::max).round().min(MOST_SPANS) as usize
}

/// Cells along a bond that are told apart: next to a much finer part of a cloud there are more.
const MOST_SPANS: f64 = 12.0;

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::generate::{jitter, lattice};
    use crate::geometry::{Families, Horizon, Influence, horizons};

    fn neighbourhood(amount: f64) -> Neighbourhood<2> {
        let mut cloud = lattice(Vector::zeros(), Vector::repeat(1.0), [9, 9]).unwrap();
        jitter(&mut cloud, amount, 3);
        let horizon = horizons(&cloud, Horizon::Ratio(2.3)).unwrap();
        let families = Families::search(&cloud, horizon).unwrap();
        Neighbourhood::new(Arc::new(cloud), Arc::new(families), Influence::default()).unwrap()
    }

    #[test]
    fn the_parts_of_every_bond_add_up_to_its_length() {
        let around = neighbourhood(0.3);
        let points: Vec<u32> = (0..81).collect();
        let crossings = Crossings::of(&around, &points);
        let mut length = vec![0.0; around.families.bonds()];
        for part in &crossings.parts {
            length[part.bond as usize] += part.share;
        }
        assert!(length.iter().all(|length| (length - 1.0).abs() < 1e-12));
    }

    /// Of the bond over two cells along an axis half lies in the cell between.
    #[test]
    fn a_bond_over_two_cells_lies_in_the_one_between_for_half_its_length() {
        let around = neighbourhood(0.0);
        let crossings = Crossings::of(&around, &[40]);
        let families = &around.families;
        let over = families
            .family(39)
            .find(|bond| families.neighbour(*bond) == 41);
        let parts = crossings
            .parts
            .iter()
            .filter(|part| Some(part.bond as usize) == over);
        let shares: Vec<f64> = parts.map(|part| part.share).collect();
        assert!(
            (shares.iter().sum::<f64>() - 0.5).abs() < 1e-15,
            "{shares:?}"
        );
    }
}
