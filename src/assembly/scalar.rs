//! Values of an assembled scalar operator, row by row: rows are owned, so threads never meet.
//!
//! A refill has two passes. The first computes the conductance of every bond once, in order. The
//! second collects each row from its own bonds and from those that end at it, through places in the
//! row that are found once per pattern.

use std::cell::RefCell;

use rayon::prelude::*;

use super::Pattern;
use crate::geometry::Vector;
use crate::operators::{BondForm, Coupling, Extension};

thread_local! {
    /// Column → place in the current row; one per thread, reused by every row that couples.
    static PLACE: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

const CHUNK: usize = 512;

/// What refills of one pattern share: places in rows, and room for the conductances.
#[derive(Debug, Clone, Default)]
pub struct Refill {
    /// Place of the neighbour of every bond in the row of its owner, shape `(bonds,)`.
    own: Vec<u16>,
    /// Place of the owner in the row of the neighbour, in the order of the dual families.
    dual: Vec<u16>,
    /// Conductance of every bond, shape `(bonds,)`.
    conductance: Vec<f64>,
}

impl Refill {
    /// Finds all places.
    pub fn new<const D: usize, F: BondForm<D>>(form: &F, pattern: &Pattern) -> Self {
        let families = &form.neighbourhood().families;
        let bonds = families.bonds();
        let mut plan = Refill {
            own: vec![0; bonds],
            dual: vec![0; bonds],
            conductance: vec![0.0; bonds],
        };
        let place = |row: usize, column: usize| {
            let columns = &pattern.columns[pattern.row(row)];
            columns.partition_point(|&c| (c as usize) < column) as u16
        };
        by_rows(families.offsets(), &mut plan.own, |row, places| {
            for (bond, own) in families.family(row).zip(places) {
                *own = place(row, families.neighbour(bond));
            }
        });
        by_rows(families.dual_offsets(), &mut plan.dual, |row, places| {
            for ((owner, _), dual) in families.dual(row).zip(places) {
                *dual = place(row, owner);
            }
        });
        plan
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        2 * (self.own.len() + self.dual.len()) + 8 * self.conductance.len()
    }
}

/// Calls `work(row, its part of data)` for all rows, whose parts start at `offsets`, in parallel.
fn by_rows<T: Send>(offsets: &[u32], data: &mut [T], work: impl Fn(usize, &mut [T]) + Sync) {
    let rows = offsets.len() - 1;
    let mut rest = data;
    let mut chunks = Vec::with_capacity(rows.div_ceil(CHUNK));
    for first in (0..rows).step_by(CHUNK) {
        let last = (first + CHUNK).min(rows);
        let (chunk, tail) = rest.split_at_mut((offsets[last] - offsets[first]) as usize);
        chunks.push((first..last, chunk));
        rest = tail;
    }
    chunks.into_par_iter().for_each(|(range, mut chunk)| {
        for row in range {
            let (part, tail) = chunk.split_at_mut((offsets[row + 1] - offsets[row]) as usize);
            work(row, part);
            chunk = tail;
        }
    });
}

/// Fills `values` (shape `(nonzeros,)`) with the matrix of `form` for `mobility` (shape `(n,)`).
///
/// The field's continuation decides the signs of images; what wall values add is not part of the
/// matrix. Rows are summed in a fixed order, so the bits do not depend on the number of threads.
pub fn fill<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &Extension<D>,
    mobility: &[f64],
    pattern: &Pattern,
    plan: &mut Refill,
    values: &mut [f64],
) {
    let families = &form.neighbourhood().families;
    by_rows(
        families.offsets(),
        &mut plan.conductance,
        |owner, conductances| {
            form.conductances(owner, mobility, conductances);
        },
    );
    let plan = &*plan;
    by_rows(&pattern.offsets, values, |row, values| {
        let mut row = Row {
            form,
            extension,
            mobility,
            pattern,
            plan,
            row,
            values,
        };
        row.conduct();
        row.couple_all();
    });
}

struct Row<'a, const D: usize, F> {
    form: &'a F,
    extension: &'a Extension<D>,
    mobility: &'a [f64],
    pattern: &'a Pattern,
    plan: &'a Refill,
    row: usize,
    values: &'a mut [f64],
}

impl<const D: usize, F: BondForm<D>> Row<'_, D, F> {
    /// Sets the row to its conductances.
    fn conduct(&mut self) {
        self.values.fill(0.0);
        let families = &self.form.neighbourhood().families;
        let mut diagonal = 0.0;
        let family = families.family(self.row);
        for (bond, &place) in family.clone().zip(&self.plan.own[family]) {
            let conductance = self.plan.conductance[bond];
            diagonal += conductance;
            self.values[usize::from(place)] -=
                self.extension.sign(families.image(bond)) * conductance;
        }
        let start = families.dual_offsets()[self.row] as usize;
        for ((_, bond), &place) in families.dual(self.row).zip(&self.plan.dual[start..]) {
            let conductance = self.plan.conductance[bond];
            diagonal += conductance;
            self.values[usize::from(place)] -=
                self.extension.sign(families.image(bond)) * conductance;
        }
        let own = self.pattern.diagonal(self.row) - self.pattern.row(self.row).start;
        self.values[own] += diagonal;
    }

    /// Adds the coupling terms of all families that the row's point belongs to.
    fn couple_all(&mut self) {
        let families = &self.form.neighbourhood().families;
        let mut couples = std::iter::once(self.row).chain(families.dual(self.row).map(|(i, _)| i));
        if !couples.any(|owner| self.form.couples(owner)) {
            return;
        }
        PLACE.with_borrow_mut(|place| {
            place.resize(place.len().max(self.pattern.rows()), 0);
            for (k, &column) in self.pattern.columns[self.pattern.row(self.row)]
                .iter()
                .enumerate()
            {
                place[column as usize] = k as u32;
            }
            self.couple(self.row, None, place);
            for (owner, bond) in families.dual(self.row) {
                self.couple(owner, Some(bond), place);
            }
        });
    }

    /// Adds the coupling terms of the family of `owner`, seen from the end of `bond` or, without
    /// one, from the owner itself.
    fn couple(&mut self, owner: usize, bond: Option<usize>, place: &[u32]) {
        if self.form.couples(owner) {
            for term in self
                .form
                .coupling(owner, self.mobility)
                .into_iter()
                .flatten()
            {
                self.couple_term(owner, bond, &term, place);
            }
        }
    }

    fn couple_term(
        &mut self,
        owner: usize,
        bond: Option<usize>,
        term: &Coupling<'_, D>,
        place: &[u32],
    ) {
        let families = &self.form.neighbourhood().families;
        let family = families.family(owner);
        let own = match bond {
            Some(bond) => {
                term.weight[bond - family.start] * self.extension.sign(families.image(bond))
            }
            None => -term.weight.iter().sum::<Vector<D>>(),
        };
        let force = term.stiffness * own;
        let mut total = 0.0;
        for (bond, weight) in family.zip(term.weight) {
            let entry = force.dot(weight);
            total += entry;
            let at = place[families.neighbour(bond)] as usize;
            self.values[at] += self.extension.sign(families.image(bond)) * entry;
        }
        self.values[place[owner] as usize] -= total;
    }
}
