//! A few iterations of conjugate gradients on the displacements.

use crate::preconditioner::Preconditioner;
use crate::{CsrView, dot, multiply};

/// Memory of the iteration.
pub(super) struct Inner {
    step: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl Inner {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            step: vec![0.0; unknowns],
            direction: vec![0.0; unknowns],
            image: vec![0.0; unknowns],
        }
    }

    /// Sets `x` to `count` iterations for `residual`, which is used up. With one iteration it is a
    /// multiple of what the preconditioner gives.
    pub(super) fn solve(
        &mut self,
        matrix: CsrView<'_>,
        preconditioner: &mut dyn Preconditioner,
        residual: &mut [f64],
        x: &mut [f64],
        count: usize,
    ) {
        let Self {
            step,
            direction,
            image,
        } = self;
        x.fill(0.0);
        preconditioner.apply(residual, step);
        direction.copy_from_slice(step);
        let mut size = dot(residual, step);
        for left in (0..count).rev() {
            multiply(matrix, direction, image);
            let curvature = dot(direction, image);
            if curvature <= 0.0 || size <= 0.0 {
                return;
            }
            let length = size / curvature;
            add(x, length, direction);
            if left == 0 {
                return;
            }
            add(residual, -length, image);
            preconditioner.apply(residual, step);
            let next = dot(residual, step);
            let kept = next / size;
            size = next;
            for (direction, step) in direction.iter_mut().zip(&*step) {
                *direction = step + kept * *direction;
            }
        }
    }
}

fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
}
