//! Values of an assembled scalar operator, row by row: rows are owned, so threads never meet.

use std::cell::RefCell;

use rayon::prelude::*;

use super::Pattern;
use crate::operators::{BondForm, Coupling, Extension};

thread_local! {
    /// Column → place in the current row; one per thread, reused by every refill.
    static PLACE: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

const CHUNK: usize = 512;

/// Fills `values` (shape `(nonzeros,)`) with the matrix of `form` for `mobility` (shape `(n,)`).
///
/// The field's continuation decides the signs of images; what wall values add is not part of the
/// matrix. Rows are summed in a fixed order, so the bits do not depend on the number of threads.
pub fn fill<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &Extension<D>,
    mobility: &[f64],
    pattern: &Pattern,
    values: &mut [f64],
) {
    let rows = pattern.rows();
    let mut rest = values;
    let mut chunks = Vec::with_capacity(rows.div_ceil(CHUNK));
    for first in (0..rows).step_by(CHUNK) {
        let last = (first + CHUNK).min(rows);
        let length = (pattern.offsets[last] - pattern.offsets[first]) as usize;
        let (chunk, tail) = rest.split_at_mut(length);
        chunks.push((first..last, chunk));
        rest = tail;
    }
    chunks.into_par_iter().for_each(|(range, chunk)| {
        PLACE.with_borrow_mut(|place| {
            place.resize(place.len().max(rows), 0);
            let start = pattern.offsets[range.start] as usize;
            for row in range {
                let at = pattern.row(row);
                let slice = &mut chunk[at.start - start..at.end - start];
                for (k, &column) in pattern.columns[at].iter().enumerate() {
                    place[column as usize] = k as u32;
                }
                Row {
                    form,
                    extension,
                    mobility,
                    row,
                    place,
                    values: slice,
                }
                .fill();
            }
        });
    });
}

struct Row<'a, const D: usize, F> {
    form: &'a F,
    extension: &'a Extension<D>,
    mobility: &'a [f64],
    row: usize,
    place: &'a [u32],
    values: &'a mut [f64],
}

impl<const D: usize, F: BondForm<D>> Row<'_, D, F> {
    fn fill(mut self) {
        self.values.fill(0.0);
        let families = &self.form.neighbourhood().families;
        let mut diagonal = 0.0;
        for bond in families.family(self.row) {
            let conductance = self.form.conductance(self.row, bond, self.mobility);
            diagonal += conductance;
            self.add(
                families.neighbour(bond),
                -self.extension.sign(families.image(bond)) * conductance,
            );
        }
        self.couple(self.row, None);
        for (owner, bond) in families.dual(self.row) {
            let conductance = self.form.conductance(owner, bond, self.mobility);
            diagonal += conductance;
            self.add(
                owner,
                -self.extension.sign(families.image(bond)) * conductance,
            );
            self.couple(owner, Some(bond));
        }
        self.add(self.row, diagonal);
    }

    fn add(&mut self, column: usize, value: f64) {
        self.values[self.place[column] as usize] += value;
    }

    /// Adds the coupling terms of the family of `owner`, seen from the end of `bond` or, without
    /// one, from the owner itself.
    fn couple(&mut self, owner: usize, bond: Option<usize>) {
        if self.form.couples(owner) {
            for term in self
                .form
                .coupling(owner, self.mobility)
                .into_iter()
                .flatten()
            {
                self.couple_term(owner, bond, &term);
            }
        }
    }

    fn couple_term(&mut self, owner: usize, bond: Option<usize>, term: &Coupling<'_, D>) {
        let families = &self.form.neighbourhood().families;
        let family = families.family(owner);
        let own = match bond {
            Some(bond) => {
                term.weight[bond - family.start] * self.extension.sign(families.image(bond))
            }
            None => -term.weight.iter().sum::<crate::geometry::Vector<D>>(),
        };
        let force = term.stiffness * own;
        let mut total = 0.0;
        for (bond, weight) in family.zip(term.weight) {
            let entry = force.dot(weight);
            total += entry;
            self.add(
                families.neighbour(bond),
                self.extension.sign(families.image(bond)) * entry,
            );
        }
        self.add(owner, -total);
    }
}
