//! Values of an assembled scalar operator, row by row: rows are owned, so threads never meet.
//!
//! Operators whose bonds depend on their ends alone are refilled in the order of the pattern, from factors
//! summed per entry once. All others, and those with a second hop, are collected family by family, through
//! places in the rows that are found once per pattern.

use std::cell::RefCell;

use super::Pattern;
use crate::geometry::Vector;
use crate::operators::{BondForm, Coupling, MirrorContinuation};
use crate::parallel::by_ranges;

thread_local! {
    /// Column → place in the current row; one per thread, reused by every row that couples.
    static PLACE: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

/// What refills of one pattern share.
#[derive(Debug, Clone)]
pub enum Refill {
    /// For operators of one hop whose bonds depend on their ends alone.
    OneHop(OneHop),
    /// For all others.
    ByFamily(ByFamily),
}

impl Default for Refill {
    fn default() -> Self {
        Refill::OneHop(OneHop::default())
    }
}

/// Geometric factors per entry of the matrix, signs included.
#[derive(Debug, Clone, Default)]
pub struct OneHop {
    /// Factors of the bonds from the row's point to the column's, shape `(nonzeros,)`.
    forward: Vec<f64>,
    /// Factors of the bonds from the column's point to the row's, shape `(nonzeros,)`.
    backward: Vec<f64>,
    /// Owner, end and factor of the bonds to odd images, which leave the domain.
    odd: Vec<(u32, u32, f64)>,
}

/// Places in rows.
#[derive(Debug, Clone, Default)]
pub struct ByFamily {
    /// Place of the neighbour of every bond in the row of its owner, shape `(bonds,)`.
    own: Vec<u16>,
    /// Place of the owner in the row of the neighbour, in the order of the dual families.
    dual: Vec<u16>,
}

impl Refill {
    /// Prepares refills of `pattern`.
    pub fn new<const D: usize, F: BondForm<D>>(
        form: &F,
        extension: &MirrorContinuation<D>,
        pattern: &Pattern,
    ) -> Self {
        let points = form.neighbourhood().len();
        match !form.pairwise() || (0..points).any(|owner| form.couples(owner)) {
            true => Refill::ByFamily(ByFamily::new(form, pattern)),
            false => Refill::OneHop(OneHop::new(form, extension, pattern)),
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        match self {
            Refill::OneHop(plan) => {
                8 * (plan.forward.len() + plan.backward.len())
                    + size_of::<(u32, u32, f64)>() * plan.odd.len()
            }
            Refill::ByFamily(plan) => 2 * (plan.own.len() + plan.dual.len()),
        }
    }
}

/// Place of a column in the row of a pattern.
fn place(pattern: &Pattern, row: usize, column: usize) -> usize {
    let columns = &pattern.columns[pattern.row(row)];
    columns.partition_point(|&c| (c as usize) < column)
}

impl OneHop {
    fn new<const D: usize, F: BondForm<D>>(
        form: &F,
        extension: &MirrorContinuation<D>,
        pattern: &Pattern,
    ) -> Self {
        let families = &form.neighbourhood().families;
        let signed =
            |owner, bond| extension.sign(families.image(bond)) * form.geometric(owner, bond);
        let mut plan = OneHop {
            forward: vec![0.0; pattern.nonzeros()],
            backward: vec![0.0; pattern.nonzeros()],
            odd: Vec::new(),
        };
        by_rows(&pattern.offsets, &mut plan.forward, |row, entries| {
            for bond in families.family(row) {
                entries[place(pattern, row, families.neighbour(bond))] += signed(row, bond);
            }
        });
        by_rows(&pattern.offsets, &mut plan.backward, |row, entries| {
            for (owner, bond) in families.dual(row) {
                entries[place(pattern, row, owner)] += signed(owner, bond);
            }
        });
        for owner in 0..families.len() {
            for bond in families.family(owner) {
                if extension.sign(families.image(bond)) < 0.0 {
                    let end = families.neighbour(bond) as u32;
                    plan.odd
                        .push((owner as u32, end, form.geometric(owner, bond)));
                }
            }
        }
        plan
    }

    /// Off-diagonal entries in the order of the pattern; the diagonal closes each row, and what
    /// leaves through odd images comes on top.
    fn fill<const D: usize, F: BondForm<D>>(
        &self,
        form: &F,
        mobility: &[f64],
        pattern: &Pattern,
        values: &mut [f64],
    ) {
        by_rows(&pattern.offsets, values, |row, values| {
            let range = pattern.row(row);
            let columns = &pattern.columns[range.clone()];
            let factors = self.forward[range.clone()]
                .iter()
                .zip(&self.backward[range]);
            let (own, mut sum, mut diagonal) = (mobility[row], 0.0, 0);
            for (k, ((&column, (forward, backward)), value)) in columns
                .iter()
                .zip(factors)
                .zip(values.iter_mut())
                .enumerate()
            {
                if column as usize == row {
                    diagonal = k;
                    continue;
                }
                let other = mobility[column as usize];
                *value = -(forward * form.mean(own, other) + backward * form.mean(other, own));
                sum += *value;
            }
            values[diagonal] = -sum;
        });
        for &(owner, end, factor) in &self.odd {
            let mean = form.mean(mobility[owner as usize], mobility[end as usize]);
            for point in [owner as usize, end as usize] {
                if !pattern.row(point).is_empty() {
                    values[pattern.diagonal(point)] += 2.0 * factor * mean;
                }
            }
        }
    }
}

impl ByFamily {
    fn new<const D: usize, F: BondForm<D>>(form: &F, pattern: &Pattern) -> Self {
        let families = &form.neighbourhood().families;
        let bonds = families.bonds();
        let mut plan = ByFamily {
            own: vec![0; bonds],
            dual: vec![0; bonds],
        };
        by_rows(families.offsets(), &mut plan.own, |row, places| {
            for (bond, own) in families.family(row).zip(places) {
                *own = place(pattern, row, families.neighbour(bond)) as u16;
            }
        });
        by_rows(families.dual_offsets(), &mut plan.dual, |row, places| {
            for ((owner, _), dual) in families.dual(row).zip(places) {
                *dual = place(pattern, row, owner) as u16;
            }
        });
        plan
    }
}

/// Calls `work(row, its part of data)` for all rows, whose parts start at `offsets`, in parallel.
pub(super) fn by_rows<T: Send>(
    offsets: &[u32],
    data: &mut [T],
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    by_ranges(offsets, data, |row, part| {
        // Rows of other processes are empty.
        if !part.is_empty() {
            work(row, part);
        }
    });
}

/// Fills `values` (shape `(nonzeros,)`) with the matrix of `form` for `mobility` (shape `(n,)`).
///
/// The field's continuation decides the signs of images; what wall values add is not part of the
/// matrix. Rows are summed in a fixed order, so the bits do not depend on the number of threads.
pub(crate) fn fill<const D: usize, F: BondForm<D>>(
    form: &F,
    extension: &MirrorContinuation<D>,
    mobility: &[f64],
    pattern: &Pattern,
    plan: &Refill,
    values: &mut [f64],
) {
    let plan = match plan {
        Refill::OneHop(plan) => return plan.fill(form, mobility, pattern, values),
        Refill::ByFamily(plan) => plan,
    };
    let families = &form.neighbourhood().families;
    let mut conductance = vec![0.0; families.bonds()];
    by_rows(families.offsets(), &mut conductance, |owner, own| {
        form.conductances(owner, mobility, own);
    });
    by_rows(&pattern.offsets, values, |row, values| {
        let mut row = Row {
            form,
            extension,
            mobility,
            conductance: &conductance,
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
    extension: &'a MirrorContinuation<D>,
    mobility: &'a [f64],
    /// Per bond, shape `(bonds,)`.
    conductance: &'a [f64],
    pattern: &'a Pattern,
    plan: &'a ByFamily,
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
            let conductance = self.conductance[bond];
            diagonal += conductance;
            self.values[usize::from(place)] -=
                self.extension.sign(families.image(bond)) * conductance;
        }
        let start = families.dual_offsets()[self.row] as usize;
        for ((_, bond), &place) in families.dual(self.row).zip(&self.plan.dual[start..]) {
            let conductance = self.conductance[bond];
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
