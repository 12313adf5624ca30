//! The banded matrix that every wavenumber leaves of a stencil.
//!
//! A term a(o) and its twin a(−o) act on a wave of angle θ a point as the factor 2 a cos θo between two sines
//! or two cosines; from a sine to a cosine as 2 a sin θo, and from a cosine to a sine as −2 a sin θo.

use super::bands::{Bands, Numbers, WIDE};
use super::layout::Layout;
use super::stencil::{Reach, Stencil};

/// Factors of all terms at all wavenumbers.
pub(super) struct Symbols<'a> {
    layout: &'a Layout,
    stencil: &'a Stencil,
    /// For each axis across: factors by offset, then wavenumber; between waves of one kind and of two.
    tables: [[Vec<f64>; 2]; 2],
    sizes: [usize; 2],
}

/// Factors of the lanes of a group.
struct Group {
    /// For each axis: those of one kind and of two, by offset.
    factors: [[Vec<Numbers>; 2]; 2],
    /// 1 where an unknown has the wavenumber, else 0.
    there: Vec<Numbers>,
}

impl<'a> Symbols<'a> {
    pub(super) fn new(layout: &'a Layout, reach: &Reach, stencil: &'a Stencil) -> Self {
        let table = |number: usize, cross: bool| -> Vec<f64> {
            let Some(own) = layout.across.get(number) else {
                return vec![1.0];
            };
            let value = |offset: usize, slot: usize| {
                let phase = own.transform.angle(slot) * offset as f64;
                match (offset, cross) {
                    (_, true) => 2.0 * phase.sin(),
                    (0, false) => 1.0,
                    (_, false) => 2.0 * phase.cos(),
                }
            };
            let offsets = 0..=reach.across[number];
            let all = offsets.flat_map(|o| (0..own.transform.slots).map(move |slot| (o, slot)));
            all.map(|(offset, slot)| value(offset, slot)).collect()
        };
        Symbols {
            layout,
            stencil,
            tables: [0, 1].map(|number| [table(number, false), table(number, true)]),
            sizes: reach.across.map(|own| own + 1),
        }
    }

    /// Slots of a lane along both axes; none for lanes that only fill a group.
    fn slots(&self, lane: usize) -> Option<[usize; 2]> {
        let slots = self.layout.slots(0);
        (lane < self.layout.lanes()).then(|| [lane % slots, lane / slots])
    }

    fn group(&self, group: usize) -> Group {
        let slots: [Option<[usize; 2]>; WIDE] =
            std::array::from_fn(|lane| self.slots(group * WIDE + lane));
        let factors = |number: usize, kind: usize| -> Vec<Numbers> {
            let (table, all) = (&self.tables[number][kind], self.layout.slots(number));
            let one = |offset: usize| {
                slots.map(|slot| slot.map_or(0.0, |slot| table[offset * all + slot[number]]))
            };
            (0..self.sizes[number]).map(one).collect()
        };
        let there = |unknown: usize| {
            slots.map(|slot| {
                let has = |number: usize, slot: usize| {
                    let first = self.layout.first(number, unknown);
                    (first..first + self.layout.count(number)).contains(&slot)
                };
                f64::from(slot.is_some_and(|slot| has(0, slot[0]) && has(1, slot[1])))
            })
        };
        Group {
            factors: [0, 1].map(|number| [factors(number, 0), factors(number, 1)]),
            there: (0..self.layout.unknowns).map(there).collect(),
        }
    }

    /// Fills the matrices of a group of lanes. Unknowns without the wavenumber have rows of the identity.
    pub(super) fn fill(&self, group: usize, bands: &mut Bands) {
        let group = self.group(group);
        let unknowns = self.layout.unknowns;
        for row in 0..self.layout.rows() {
            match row.checked_sub(unknowns) {
                Some(other) if self.stencil.is_same(row, other) => bands.copy_row(other, row),
                _ => self.fill_row(&group, row, bands.row_mut(row)),
            }
        }
    }

    fn fill_row(&self, group: &Group, row: usize, entries: &mut [Numbers]) {
        let unknowns = self.layout.unknowns;
        let unknown = row % unknowns;
        for term in self.stencil.row(row) {
            let before = -term.along * unknowns as isize + unknown as isize - term.unknown as isize;
            // The other half follows by symmetry.
            let Ok(before) = usize::try_from(before) else {
                continue;
            };
            let kinds = [0, 1].map(|number| self.kind(number, unknown, term.unknown));
            let value = term.value * kinds[0].1 * kinds[1].1;
            let first = &group.factors[0][kinds[0].0][term.across[0]];
            let second = &group.factors[1][kinds[1].0][term.across[1]];
            for lane in 0..WIDE {
                entries[before][lane] += value * first[lane] * second[lane];
            }
        }
        let own = &group.there[unknown];
        for (before, entries) in entries.iter_mut().enumerate() {
            let other = &group.there[(unknown + unknowns * before - before) % unknowns];
            for lane in 0..WIDE {
                entries[lane] *= own[lane] * other[lane];
            }
        }
        for lane in 0..WIDE {
            entries[0][lane] += 1.0 - own[lane];
        }
    }

    /// Which factors a term between two unknowns has along an axis, and their sign.
    fn kind(&self, number: usize, unknown: usize, other: usize) -> (usize, f64) {
        let sine = |unknown: usize| {
            let own = self.layout.across.get(number);
            own.is_some_and(|own| own.transform.is_sine(unknown))
        };
        match (sine(unknown), sine(other)) {
            (false, true) => (1, 1.0),
            (true, false) => (1, -1.0),
            _ => (0, 1.0),
        }
    }
}
