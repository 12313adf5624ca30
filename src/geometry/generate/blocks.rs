//! 2:1 blocks: cells of a coarse lattice split into halves where refinement is asked for.

use std::collections::BTreeMap;

use super::{GenerateError, check_count, divide};
use crate::geometry::{Cloud, Domain, Shape, Vector};

/// Cells that touch the region are halved until they are `levels` times halved.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
    /// Where.
    pub region: Shape,
    /// Number of halvings.
    pub levels: u32,
}

/// Grid place of a cell: coordinates at its own level.
type Key<const D: usize> = (u32, [i64; D]);

/// Cloud of cells of the coarsest `spacing` (metres), halved by `refinements`, with neighbouring
/// cells differing by one level at most.
///
/// # Errors
/// [`GenerateError::NotDivisible`] unless the spacing divides every edge;
/// [`GenerateError::TooMany`].
pub fn blocks<const D: usize>(
    origin: Vector<D>,
    size: Vector<D>,
    spacing: f64,
    refinements: &[Refinement],
) -> Result<Cloud<D>, GenerateError> {
    let mut cells = [0_usize; D];
    for axis in 0..D {
        cells[axis] = divide(size[axis], spacing, axis)?;
    }
    check_count(cells.iter().map(|&n| n as f64).product())?;
    let edge = Vector::from_fn(|axis, _| size[axis] / cells[axis] as f64);
    let tree = Tree {
        origin,
        edge,
        cells,
    };
    let leaves = tree.balance(tree.refine(refinements)?)?;
    let irregular = leaves.keys().any(|&(level, _)| level > 0);
    let mut order: Vec<Key<D>> = leaves.into_keys().collect();
    order.sort_by_cached_key(|&key| tree.curve(key));
    let cell: Vec<Vector<D>> = order.iter().map(|&(level, _)| tree.width(level)).collect();
    Ok(Cloud {
        domain: Domain {
            lower: origin,
            upper: origin + size,
            planes: true,
        },
        position: order.iter().map(|&key| tree.centre(key)).collect(),
        volume: cell.iter().map(Vector::product).collect(),
        cell,
        irregular,
        filled: true,
        outline: None,
    })
}

struct Tree<const D: usize> {
    origin: Vector<D>,
    edge: Vector<D>,
    cells: [usize; D],
}

type Leaves<const D: usize> = BTreeMap<Key<D>, ()>;

impl<const D: usize> Tree<D> {
    fn width(&self, level: u32) -> Vector<D> {
        self.edge / f64::from(1_u32 << level)
    }

    fn centre(&self, (level, at): Key<D>) -> Vector<D> {
        let width = self.width(level);
        Vector::from_fn(|axis, _| self.origin[axis] + (at[axis] as f64 + 0.5) * width[axis])
    }

    /// Place along a Z-order curve at the finest level, so that near cells have near indices.
    fn curve(&self, (level, at): Key<D>) -> (u128, u32) {
        let shift = 20 - level.min(20);
        let mut code = 0_u128;
        for bit in (0..40).rev() {
            for &k in at.iter().rev() {
                code = code << 1 | ((k as u128) << shift >> bit & 1);
            }
        }
        (code, level)
    }

    fn refine(&self, refinements: &[Refinement]) -> Result<Leaves<D>, GenerateError> {
        let total: usize = self.cells.iter().product();
        let mut open: Vec<Key<D>> = (0..total).map(|index| (0, self.place(index))).collect();
        let mut leaves = Leaves::new();
        let mut touched = vec![false; refinements.len()];
        while let Some(key) = open.pop() {
            let mut levels = 0;
            for (refinement, touched) in refinements.iter().zip(&mut touched) {
                if self.touches(key, &refinement.region) {
                    (*touched, levels) = (true, levels.max(refinement.levels));
                }
            }
            if levels > key.0 {
                open.extend(children(key));
            } else {
                leaves.insert(key, ());
            }
            check_count((open.len() + leaves.len()) as f64)?;
        }
        match touched.iter().position(|touched| !touched) {
            None => Ok(leaves),
            Some(first) => Err(GenerateError::EmptyRefinement { number: first + 1 }),
        }
    }

    fn place(&self, mut index: usize) -> [i64; D] {
        std::array::from_fn(|axis| {
            let k = index % self.cells[axis];
            index /= self.cells[axis];
            k as i64
        })
    }

    /// Whether the cell's centre or one of its corners (drawn in a little) lies in the region.
    fn touches(&self, key: Key<D>, region: &Shape) -> bool {
        let (centre, half) = (self.centre(key), self.width(key.0) * 0.499);
        region.contains(centre.as_slice())
            || (0..1_usize << D).any(|corner| {
                let sign = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
                let x = Vector::<D>::from_fn(|axis, _| centre[axis] + sign(axis) * half[axis]);
                region.contains(x.as_slice())
            })
    }

    /// Splits cells until face, edge and corner neighbours differ by one level at most.
    fn balance(&self, mut leaves: Leaves<D>) -> Result<Leaves<D>, GenerateError> {
        loop {
            let coarse: Leaves<D> = leaves
                .keys()
                .filter(|&&(level, _)| level >= 2)
                .flat_map(|&key| self.coarse_neighbours(key, &leaves))
                .map(|key| (key, ()))
                .collect();
            if coarse.is_empty() {
                return Ok(leaves);
            }
            for &key in coarse.keys() {
                leaves.remove(&key);
                leaves.extend(children(key).map(|child| (child, ())));
            }
            check_count(leaves.len() as f64)?;
        }
    }

    /// Leaves two or more levels coarser that touch the cell.
    fn coarse_neighbours(&self, (level, at): Key<D>, leaves: &Leaves<D>) -> Vec<Key<D>> {
        let mut found = Vec::new();
        for direction in 0..3_usize.pow(D as u32) {
            let mut rest = direction;
            let near: [i64; D] = std::array::from_fn(|axis| {
                let step = (rest % 3) as i64 - 1;
                rest /= 3;
                at[axis] + step
            });
            for up in 2..=level {
                let key = (level - up, near.map(|k| k >> up));
                if leaves.contains_key(&key) {
                    found.push(key);
                }
            }
        }
        found
    }
}

fn children<const D: usize>((level, at): Key<D>) -> impl Iterator<Item = Key<D>> {
    (0..1_usize << D).map(move |corner| {
        (
            level + 1,
            std::array::from_fn(|axis| 2 * at[axis] + (corner >> axis & 1) as i64),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refined() -> Cloud<2> {
        let region = Shape::Box {
            min: vec![0.0, 0.0],
            max: vec![0.05, 1.0],
        };
        let size = Vector::<2>::new(1.0, 0.5);
        blocks(
            Vector::zeros(),
            size,
            0.125,
            &[Refinement { region, levels: 3 }],
        )
        .unwrap()
    }

    #[test]
    fn blocks_fill_the_box_and_reach_the_level_asked_for() {
        let cloud = refined();
        assert!((cloud.volume.iter().sum::<f64>() - 0.5).abs() < 1e-14);
        let smallest = cloud
            .cell
            .iter()
            .map(|c| c[0])
            .fold(f64::INFINITY, f64::min);
        assert!((smallest - 0.125 / 8.0).abs() < 1e-15);
    }

    #[test]
    fn touching_blocks_differ_by_a_factor_two_at_most() {
        let cloud = refined();
        for i in 0..cloud.len() {
            for j in 0..i {
                let gap = (cloud.position[i] - cloud.position[j]).abs()
                    - (cloud.cell[i] + cloud.cell[j]) / 2.0;
                if gap.max() < 1e-12 {
                    let ratio = cloud.cell[i][0] / cloud.cell[j][0];
                    assert!((0.49..2.01).contains(&ratio), "{ratio}");
                }
            }
        }
    }

    #[test]
    fn without_refinement_the_blocks_are_the_lattice() {
        let cloud = blocks(Vector::<3>::zeros(), Vector::repeat(1.0), 0.25, &[]).unwrap();
        assert!(!cloud.irregular && cloud.len() == 64);
    }
}
