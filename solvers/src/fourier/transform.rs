//! Sine and cosine transforms of the values along one axis of a lattice.
//!
//! | lower/upper side | even/even | odd/odd | even/odd | odd/even |
//! |---|---|---|---|---|
//! | transform | DCT-II | DST-II | DCT-IV | DST-IV |
//! | wavenumber | πk/N, k = 0 … N − 1 | πk/N, k = 1 … N | π(k + ½)/N | π(k + ½)/N |
//!
//! Forward and backward together give N/2 times the values.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::sync::Arc;

use rustdct::{DctPlanner, TransformType2And3, TransformType4};

use crate::lattice::Mirror;

thread_local! {
    /// Values of a line that do not lie side by side, gathered.
    static LINE: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
    /// Working memory of the transforms of this thread.
    static SCRATCH: RefCell<Vec<f64>> = const { RefCell::new(Vec::new()) };
}

/// The transforms of all unknowns along one axis.
pub(super) struct Transform {
    /// Points along the axis.
    pub(super) count: usize,
    /// Wavenumbers along the axis, those of all unknowns together.
    pub(super) slots: usize,
    /// Whether wavenumbers are whole multiples of π/N, not shifted by half of it.
    whole: bool,
    /// Mirrors of every unknown.
    mirrors: Vec<[Mirror; 2]>,
    kernel: Kernel,
}

enum Kernel {
    /// Types II and III.
    Whole(Arc<dyn TransformType2And3<f64>>),
    /// Type IV.
    Half(Arc<dyn TransformType4<f64>>),
}

impl Transform {
    /// The transforms of unknowns with these mirrors, at least one, on `count` points.
    pub(super) fn new(count: usize, mirrors: &[[Mirror; 2]]) -> Self {
        let whole = mirrors.iter().all(|own| own[0] == own[1]);
        let all_even = mirrors.iter().all(|own| own[0] == Mirror::Even);
        let mut planner = DctPlanner::new();
        Transform {
            count,
            // Cosines have a constant, sines the shortest wave instead.
            slots: count + usize::from(whole && !all_even),
            whole,
            mirrors: mirrors.to_vec(),
            kernel: match whole {
                true => Kernel::Whole(planner.plan_dct2(count)),
                false => Kernel::Half(planner.plan_dct4(count)),
            },
        }
    }

    /// First wavenumber of an unknown, which has as many as there are points.
    pub(super) fn first(&self, unknown: usize) -> usize {
        usize::from(self.whole && self.is_sine(unknown))
    }

    /// Whether an unknown is made of sines.
    pub(super) fn is_sine(&self, unknown: usize) -> bool {
        self.mirrors[unknown][0] == Mirror::Odd
    }

    /// How an unknown goes on beyond the upper side: 1 or −1.
    pub(super) fn upper(&self, unknown: usize) -> f64 {
        match self.mirrors[unknown][1] {
            Mirror::Even => 1.0,
            Mirror::Odd => -1.0,
        }
    }

    /// Change of phase from a point to the next.
    pub(super) fn angle(&self, slot: usize) -> f64 {
        let shift = if self.whole { 0.0 } else { 0.5 };
        PI * (slot as f64 + shift) / self.count as f64
    }

    /// Values of an unknown at all points in a row to its wavenumbers, in place.
    pub(super) fn forward(&self, unknown: usize, values: &mut [f64]) {
        self.run(|scratch| match (&self.kernel, self.is_sine(unknown)) {
            (Kernel::Whole(kernel), false) => kernel.process_dct2_with_scratch(values, scratch),
            (Kernel::Whole(kernel), true) => kernel.process_dst2_with_scratch(values, scratch),
            (Kernel::Half(kernel), false) => kernel.process_dct4_with_scratch(values, scratch),
            (Kernel::Half(kernel), true) => kernel.process_dst4_with_scratch(values, scratch),
        });
    }

    /// The way back, N/2 times as large.
    pub(super) fn backward(&self, unknown: usize, values: &mut [f64]) {
        self.run(|scratch| match (&self.kernel, self.is_sine(unknown)) {
            (Kernel::Whole(kernel), false) => kernel.process_dct3_with_scratch(values, scratch),
            (Kernel::Whole(kernel), true) => kernel.process_dst3_with_scratch(values, scratch),
            (Kernel::Half(kernel), false) => kernel.process_dct4_with_scratch(values, scratch),
            (Kernel::Half(kernel), true) => kernel.process_dst4_with_scratch(values, scratch),
        });
    }

    /// Calls `work` with the values at these places, as many as there are points.
    pub(super) fn at_places(
        &self,
        values: &mut [f64],
        places: impl Iterator<Item = usize> + Clone,
        work: impl FnOnce(&mut [f64]),
    ) {
        LINE.with_borrow_mut(|line| {
            line.clear();
            line.extend(places.clone().map(|place| values[place]));
            work(line);
            places
                .zip(line.iter())
                .for_each(|(place, value)| values[place] = *value);
        });
    }

    fn run(&self, work: impl FnOnce(&mut [f64])) {
        let length = match &self.kernel {
            Kernel::Whole(kernel) => kernel.get_scratch_len(),
            Kernel::Half(kernel) => kernel.get_scratch_len(),
        };
        SCRATCH.with_borrow_mut(|scratch| {
            if scratch.len() < length {
                scratch.resize(length, 0.0);
            }
            work(&mut scratch[..length]);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Mirror::{Even, Odd};
    use crate::test_support::noisy_vector;

    /// Values that are one wave come out at its wavenumber alone, and go back to what they were.
    #[test]
    fn a_wave_of_either_parity_has_one_wavenumber() {
        for count in [1, 2, 3, 7, 10, 20] {
            for mirrors in [[Even, Even], [Odd, Odd], [Even, Odd], [Odd, Even]] {
                let transform = Transform::new(count, &[mirrors]);
                let first = transform.first(0);
                for wave in 0..count {
                    let angle = transform.angle(wave + first);
                    let value = |place: usize| match mirrors[0] {
                        Even => (angle * (place as f64 + 0.5)).cos(),
                        Odd => (angle * (place as f64 + 0.5)).sin(),
                    };
                    let mut values: Vec<f64> = (0..count).map(value).collect();
                    transform.forward(0, &mut values);
                    let size = values[wave].abs();
                    values[wave] = 0.0;
                    assert!(size > 0.49 * count as f64);
                    assert!(values.iter().all(|rest| rest.abs() < 1e-13 * size));
                }
                let original = noisy_vector(count);
                let mut values = original.clone();
                transform.forward(0, &mut values);
                transform.backward(0, &mut values);
                for (back, start) in values.iter().zip(&original) {
                    assert!((back * 2.0 / count as f64 - start).abs() < 1e-14);
                }
            }
        }
    }
}
