//! Elementwise vector updates, parallel over the entries.

use crate::parallel;

/// Entries per parallel task: large enough to hide the cost of a task.
const ENTRIES_PER_TASK: usize = 4096;

/// y ← y + a x.
pub(super) fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    update(y, x, |y, x| y + a * x);
}

/// y ← b y + a x.
pub(super) fn combine(y: &mut [f64], b: f64, a: f64, x: &[f64]) {
    update(y, x, |y, x| b * y + a * x);
}

/// y ← a x.
pub(super) fn set_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    update(y, x, |_, x| a * x);
}

/// y ← a y.
pub(super) fn scale(y: &mut [f64], a: f64) {
    parallel::chunks(y, ENTRIES_PER_TASK, 1, |_, y| {
        y.iter_mut().for_each(|y| *y *= a);
    });
}

fn update(y: &mut [f64], x: &[f64], new: impl Fn(f64, f64) -> f64 + Sync) {
    parallel::chunks(y, ENTRIES_PER_TASK, 1, |task, y| {
        let x = &x[task * ENTRIES_PER_TASK..];
        y.iter_mut().zip(x).for_each(|(y, x)| *y = new(*y, *x));
    });
}
