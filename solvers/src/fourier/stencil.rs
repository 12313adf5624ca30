//! The stencil of every row of a line, read from a matrix by undoing the reflections at the sides.
//!
//! Along an axis across the lines an endless lattice has entries a(o) for offsets o, with a(−o) = a(o) between
//! two sines or two cosines and −a(o) between a sine and a cosine. Reflection at the upper side adds to the
//! entry between the last point and the one m before it, which therefore is ±(a(m) + σ a(m + 1)), σ being the
//! mirror of the row's unknown. From the farthest m on this tells all a; those of offsets N and more, whose
//! reflections no row can tell from nearer ones, are taken to be 0.

use std::collections::HashMap;
use std::ops::Range;

use crate::CsrView;
use crate::matrix::Rows;

use super::layout::Layout;

/// An entry of a row of the endless lattice.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// Points along the line, from the row's to the column's.
    pub(super) along: isize,
    /// Unknown of the column.
    pub(super) unknown: usize,
    /// Points across the lines, not negative.
    pub(super) across: [usize; 2],
    /// The entry.
    pub(super) value: f64,
}

/// The stencils of all rows of a line.
pub(super) struct Stencil {
    /// Terms of all rows that differ, one row after the other.
    terms: Vec<Term>,
    /// Which of them are those of every row, shape `(rows,)`.
    ranges: Vec<Range<usize>>,
}

/// Farthest columns from their rows, in points along the lines and across.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reach {
    pub(super) along: usize,
    pub(super) across: [usize; 2],
}

/// The last point across the lines, from which stencils are read. A grounded point, the first of all, is not it.
pub(super) fn edge(layout: &Layout) -> [usize; 2] {
    [0, 1].map(|number| layout.count(number) - 1)
}

impl Reach {
    /// Reach of the rows that stencils are read from.
    pub(super) fn of(layout: &Layout, pattern: CsrView<'_>) -> Self {
        let (rows, edge) = (Rows::new(&pattern), edge(layout));
        let mut reach = Reach::default();
        for row in 0..layout.rows() {
            let along = row / layout.unknowns;
            let point = layout.point(along, edge);
            let (columns, _) = rows.row(point * layout.unknowns + row % layout.unknowns);
            for column in columns {
                let (other, places) = layout.places(*column as usize / layout.unknowns);
                reach.along = reach.along.max(along.abs_diff(other));
                for number in 0..2 {
                    let own = &mut reach.across[number];
                    *own = (*own).max(edge[number] - places[number]);
                }
            }
        }
        reach
    }
}

/// −1 between a sine and a cosine along the axis of this number, else 1.
fn turn(layout: &Layout, number: usize, one: usize, other: usize) -> f64 {
    let Some(across) = layout.across.get(number) else {
        return 1.0;
    };
    match across.transform.is_sine(one) == across.transform.is_sine(other) {
        true => 1.0,
        false => -1.0,
    }
}

impl Stencil {
    /// Reads the stencils of a matrix.
    pub(super) fn read(layout: &Layout, reach: &Reach, matrix: CsrView<'_>) -> Self {
        let mut stencil = Stencil {
            terms: Vec::new(),
            ranges: Vec::with_capacity(layout.rows()),
        };
        let sizes = reach.across.map(|own| own + 1);
        let plane = sizes[0] * sizes[1];
        let mut entries = vec![0.0; (2 * reach.along + 1) * layout.unknowns * plane];
        for row in 0..layout.rows() {
            if repeats(layout, matrix, row) {
                stencil
                    .ranges
                    .push(stencil.ranges[row - layout.unknowns].clone());
                continue;
            }
            let start = stencil.terms.len();
            entries.fill(0.0);
            gather(layout, reach, matrix, row, &mut entries);
            let unknown = row % layout.unknowns;
            for (number, own) in entries.chunks_exact_mut(plane).enumerate() {
                let other = number % layout.unknowns;
                unfold(layout, [unknown, other], sizes, own);
                let terms = own.iter().enumerate().filter(|(_, value)| **value != 0.0);
                stencil.terms.extend(terms.map(|(place, value)| Term {
                    along: (number / layout.unknowns) as isize - reach.along as isize,
                    unknown: other,
                    across: [place % sizes[0], place / sizes[0]],
                    value: *value,
                }));
            }
            stencil.ranges.push(start..stencil.terms.len());
        }
        stencil
    }

    /// Terms of a row of the line.
    pub(super) fn row(&self, row: usize) -> &[Term] {
        &self.terms[self.ranges[row].clone()]
    }

    /// Whether two rows have the same terms because they are the same row of the matrix.
    pub(super) fn is_same(&self, row: usize, other: usize) -> bool {
        self.ranges[row] == self.ranges[other]
    }

    /// The first row of a matrix that is not what the stencil says by more than `tolerance` of its largest
    /// entry, with the difference relative to it.
    pub(super) fn misfit(
        &self,
        layout: &Layout,
        matrix: CsrView<'_>,
        tolerance: f64,
    ) -> Option<(usize, f64)> {
        let rows = Rows::new(&matrix);
        let mut entries = HashMap::new();
        (0..matrix.rows()).find_map(|row| {
            self.fold(layout, row, &mut entries);
            let largest = entries
                .values()
                .fold(0.0, |most: f64, own: &f64| most.max(own.abs()));
            let (columns, values) = rows.row(row);
            for (column, value) in columns.iter().zip(values) {
                *entries.entry(*column as usize).or_insert(0.0) -= value;
            }
            let off = entries
                .values()
                .fold(0.0, |most: f64, own: &f64| most.max(own.abs()));
            (off > tolerance * largest).then(|| (row, off / largest))
        })
    }

    /// The entries of a row of the matrix by columns: its stencil, reflected at the sides.
    pub(super) fn fold(&self, layout: &Layout, row: usize, entries: &mut HashMap<usize, f64>) {
        entries.clear();
        let unknown = row % layout.unknowns;
        let (along, places) = layout.places(row / layout.unknowns);
        for term in self.row(along * layout.unknowns + unknown) {
            for first in signed(term.across[0]) {
                for second in signed(term.across[1]) {
                    let (mut value, mut target) = (term.value, places);
                    for (number, step) in [first, second].into_iter().enumerate() {
                        if step < 0 {
                            value *= turn(layout, number, unknown, term.unknown);
                        }
                        let (place, sign) =
                            reflect(layout, number, term.unknown, places[number], step);
                        target[number] = place;
                        value *= sign;
                    }
                    let other = layout.point((along as isize + term.along) as usize, target);
                    *entries
                        .entry(other * layout.unknowns + term.unknown)
                        .or_insert(0.0) += value;
                }
            }
        }
    }
}

fn signed(step: usize) -> impl Iterator<Item = isize> {
    let step = step as isize;
    [step, -step]
        .into_iter()
        .take(if step == 0 { 1 } else { 2 })
}

/// The point that a step along an axis leads to, reflected at the sides, and the sign of an unknown there.
fn reflect(
    layout: &Layout,
    number: usize,
    unknown: usize,
    place: usize,
    step: isize,
) -> (usize, f64) {
    let Some(across) = layout.across.get(number) else {
        return (place, 1.0);
    };
    let transform = &across.transform;
    let (count, mut place, mut sign) = (transform.count as isize, place as isize + step, 1.0);
    let lower = if transform.is_sine(unknown) {
        -1.0
    } else {
        1.0
    };
    loop {
        match place {
            below if below < 0 => (place, sign) = (-1 - place, sign * lower),
            above if above >= count => {
                (place, sign) = (2 * count - 1 - place, sign * transform.upper(unknown));
            }
            inside => return (inside as usize, sign),
        }
    }
}

/// Whether the row at the upper edge is that of the point before on the line, one point further, to the last bit.
fn repeats(layout: &Layout, matrix: CsrView<'_>, row: usize) -> bool {
    let (along, unknown) = (row / layout.unknowns, row % layout.unknowns);
    let Some(before) = along.checked_sub(1) else {
        return false;
    };
    let (rows, edge) = (Rows::new(&matrix), edge(layout));
    let at = |along: usize| rows.row(layout.point(along, edge) * layout.unknowns + unknown);
    let ((columns, values), (others, theirs)) = (at(along), at(before));
    let step = (layout.stride * layout.unknowns) as u32;
    let mut entries = columns.iter().zip(others).zip(values.iter().zip(theirs));
    columns.len() == others.len()
        && entries.all(|((own, other), (value, their))| {
            *own == *other + step && value.to_bits() == their.to_bits()
        })
}

/// Adds the entries of the row at the upper edge to `entries`, by offsets along the line, unknowns and
/// places before the edge.
fn gather(layout: &Layout, reach: &Reach, matrix: CsrView<'_>, row: usize, entries: &mut [f64]) {
    let (along, edge) = (row / layout.unknowns, edge(layout));
    let sizes = reach.across.map(|own| own + 1);
    let of_matrix = layout.point(along, edge) * layout.unknowns + row % layout.unknowns;
    let (columns, values) = Rows::new(&matrix).row(of_matrix);
    for (column, value) in columns.iter().zip(values) {
        let (point, unknown) = (
            *column as usize / layout.unknowns,
            *column as usize % layout.unknowns,
        );
        let (other, places) = layout.places(point);
        let before = [0, 1].map(|number| edge[number] - places[number]);
        let number = (other + reach.along - along) * layout.unknowns + unknown;
        entries[(number * sizes[1] + before[1]) * sizes[0] + before[0]] += value;
    }
}

/// Turns entries at the upper edge into those of the endless lattice, along both axes across.
fn unfold(layout: &Layout, [unknown, other]: [usize; 2], sizes: [usize; 2], entries: &mut [f64]) {
    for (number, stride) in [(0, 1), (1, sizes[0])] {
        let Some(across) = layout.across.get(number) else {
            continue;
        };
        let sign = turn(layout, number, unknown, other);
        let mirror = across.transform.upper(unknown);
        for start in 0..sizes[1 - number] {
            let start = start * if number == 0 { sizes[0] } else { 1 };
            let mut farther = 0.0;
            for place in (0..sizes[number]).rev() {
                let entry = &mut entries[start + place * stride];
                *entry = sign * *entry - mirror * farther;
                farther = *entry;
            }
        }
    }
}
