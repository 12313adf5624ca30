//! Values of the assembled elastic operator, row by row: rows are owned, so threads never meet.

use std::cell::RefCell;

use super::Pattern;
use super::scalar::by_rows;
use crate::geometry::Vector;
use crate::operators::{Elastic, Lame};

thread_local! {
    /// Column → place in the current row of points; one per thread.
    static PLACE: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

/// Fills `values` with the stiffness matrix K of `elastic`.
///
/// `points` is the pattern over points, every family coupled; `values` has the layout of
/// `points.expanded(D)`: all columns of a point's first component, then of the next. Rows are summed
/// in a fixed order, so the bits do not depend on the number of threads.
pub fn fill_stiffness<const D: usize>(elastic: &Elastic<D>, points: &Pattern, values: &mut [f64]) {
    values.fill(0.0);
    let offsets: Vec<u32> = points.offsets.iter().map(|o| o * (D * D) as u32).collect();
    by_rows(&offsets, values, |point, values| {
        PLACE.with_borrow_mut(|place| {
            place.resize(place.len().max(points.rows()), 0);
            let columns = &points.columns[points.row(point)];
            for (k, &column) in columns.iter().enumerate() {
                place[column as usize] = k as u32;
            }
            let width = columns.len() * D;
            let mut row = Row {
                elastic,
                place,
                width,
                values,
            };
            row.own(point);
            for (owner, bond) in elastic.around.families.dual(point) {
                row.dual(owner, bond);
            }
        });
    });
}

/// The rows of one point's components.
struct Row<'a, const D: usize> {
    elastic: &'a Elastic<D>,
    place: &'a [u32],
    width: usize,
    values: &'a mut [f64],
}

/// How the row's point enters the family of `owner`.
struct Share<const D: usize> {
    owner: usize,
    /// Weight in the strain of the family.
    strain: Vector<D>,
    /// Weight in the plain gradient, times the shape tensor and h.
    hourglass: Vector<D>,
    sign: Vector<D>,
}

impl<const D: usize> Row<'_, D> {
    /// The point as the owner of its family, with minus the sum of all bonds.
    fn own(&mut self, point: usize) {
        let elastic = self.elastic;
        let around = &elastic.around;
        let family = around.families.family(point);
        let (_, stiffness) = elastic.hourglass(point);
        let (mut strain, mut hourglass) = (Vector::zeros(), Vector::zeros());
        for bond in family {
            let own = stiffness * around.measure[bond];
            strain -= elastic.gradient.weight[bond];
            hourglass -= around.bond_vector(point, bond) * own;
            self.stretch(point, bond, elastic.signs(bond), own, Vector::repeat(-1.0));
        }
        let sign = Vector::repeat(1.0);
        self.couple(&Share {
            owner: point,
            strain,
            hourglass,
            sign,
        });
    }

    /// The point as the end of a bond.
    fn dual(&mut self, owner: usize, bond: usize) {
        let elastic = self.elastic;
        let (_, stiffness) = elastic.hourglass(owner);
        let own = stiffness * elastic.around.measure[bond];
        let sign = elastic.signs(bond);
        self.stretch(owner, bond, sign, own, sign);
        self.couple(&Share {
            owner,
            strain: elastic.gradient.weight[bond],
            hourglass: elastic.around.bond_vector(owner, bond) * own,
            sign,
        });
    }

    /// Adds the diagonal part of the hourglass energy of one bond to a row with weights `row`.
    fn stretch(
        &mut self,
        owner: usize,
        bond: usize,
        sign: Vector<D>,
        stiffness: f64,
        row: Vector<D>,
    ) {
        let end = self.elastic.around.families.neighbour(bond);
        let (end, own) = (self.place[end] as usize, self.place[owner] as usize);
        for axis in 0..D {
            let force = stiffness * row[axis];
            self.values[axis * self.width + end * D + axis] += force * sign[axis];
            self.values[axis * self.width + own * D + axis] -= force;
        }
    }

    /// Adds what couples the row's point to all points of one family.
    fn couple(&mut self, share: &Share<D>) {
        let elastic = self.elastic;
        let families = &elastic.around.families;
        let volume = elastic.around.cloud.volume[share.owner];
        let Lame { lambda, mu } = elastic.lame[share.owner];
        let lame = Lame {
            lambda: lambda * volume,
            mu: mu * volume,
        };
        let (plain, _) = elastic.hourglass(share.owner);
        let mut own = [[0.0; D]; D];
        for bond in families.family(share.owner) {
            let weight = &elastic.gradient.weight[bond];
            let rest = share.hourglass.dot(&plain.weight[bond]);
            let place = self.place[families.neighbour(bond)] as usize;
            let sign = elastic.signs(bond);
            let shear = lame.mu * share.strain.dot(weight);
            for a in 0..D {
                let row = &mut self.values[a * self.width + place * D..][..D];
                for b in 0..D {
                    let mut entry = lame.lambda * share.strain[a] * weight[b]
                        + lame.mu * share.strain[b] * weight[a];
                    if a == b {
                        entry += shear - rest;
                    }
                    entry *= share.sign[a];
                    row[b] += entry * sign[b];
                    own[a][b] -= entry;
                }
            }
        }
        let place = self.place[share.owner] as usize;
        for (a, own) in own.iter().enumerate() {
            let row = &mut self.values[a * self.width + place * D..][..D];
            row.iter_mut()
                .zip(own)
                .for_each(|(entry, own)| *entry += own);
        }
    }
}
