//! How far a uniform flow through a uniform medium is off with a scalar operator.
//!
//! With the linear function x along an axis the operator leaves the forces r = L x where there should
//! be none (a first moment that does not vanish), and gives it the energy xᵀ L x (the second moment).
//! The pressure gives way by φ with L φ = r, so that the flux between two sides of the domain is
//! (xᵀ L x − rᵀ φ)/Σ V times the exact one. rᵀ φ grows with every step of conjugate gradients.

use perifrac_solvers::dot;

use super::consistency::{Planes, boundary_layer, natural_extension, surface_layer};
use super::force::{bond_force, force};
use crate::geometry::{Side, Voids};
use crate::operators::{BondForm, MirrorContinuation, Neighbourhood, Parity};

/// Share of rᵀ φ by which a step must add to it for another one.
const GROWTH: f64 = 0.01;
/// Most steps of conjugate gradients; jittered clouds need few, gradings more.
const STEPS: usize = 30;
/// Forces below this share of a cell's face are rounding errors.
const ROUNDING: f64 = 1e-12;

/// Largest relative error over the axes. Sides in `one_sided` have families without images.
pub(crate) fn uniform_flow_error<const D: usize, F: BondForm<D>>(
    form: &F,
    one_sided: &[bool],
) -> f64 {
    let around = form.neighbourhood();
    let free = free_points(around, one_sided);
    let planes = Planes::natural(one_sided);
    (0..D)
        .map(|axis| {
            let natural = natural_extension(around, axis, &planes);
            error_along(form, &natural, axis, &free)
        })
        .fold(0.0, f64::max)
}

/// Points that feel a boundary without images or a void: what they leave over is what flows through it.
fn free_points<const D: usize>(around: &Neighbourhood<D>, one_sided: &[bool]) -> Vec<bool> {
    let sides: Vec<Side> = Side::all(D).filter(|s| one_sided[s.index()]).collect();
    let voids = Voids::find(&around.cloud);
    let mut layer = boundary_layer(around, &sides);
    if !voids.is_empty() {
        let surface = surface_layer(around, &voids);
        layer
            .iter_mut()
            .zip(&surface)
            .for_each(|(own, feels)| *own |= feels);
    }
    layer
}

fn error_along<const D: usize, F: BondForm<D>>(
    form: &F,
    natural: &MirrorContinuation<D>,
    axis: usize,
    free: &[bool],
) -> f64 {
    let around = form.neighbourhood();
    let families = &around.families;
    let ones = vec![1.0; around.len()];
    let along = |owner: usize, bond: usize| around.bond_vector(owner, bond)[axis];
    let (mut total, mut forces) = ([0.0, 0.0], Vec::new());
    for owner in (0..around.len()).filter(|owner| families.share.owns(*owner)) {
        let differences: Vec<f64> = families.family(owner).map(|b| along(owner, b)).collect();
        forces.clear();
        bond_force(form, owner, &ones, &differences, &mut forces);
        total[0] += dot(&forces, &differences);
        total[1] += around.cloud.volume[owner];
    }
    families.share.sum(&mut total);
    let mut left = force(form, natural, &ones, &along);
    left.iter_mut()
        .zip(free)
        .filter(|(_, free)| **free)
        .for_each(|(r, _)| *r = 0.0);
    if Side::all(D).all(|side| natural.parity(side) != Parity::Odd) {
        let mean = left.iter().sum::<f64>() / left.len() as f64;
        left.iter_mut().for_each(|r| *r -= mean);
    }
    let apply = |values: &[f64]| {
        let difference = |owner: usize, bond: usize| {
            natural.sign(families.image(bond)) * values[families.neighbour(bond)] - values[owner]
        };
        force(form, natural, &ones, &difference)
    };
    let release = released(around, &left, apply);
    ((total[0] - release) / total[1] - 1.0).abs()
}

/// rᵀ L⁻¹ r from below, by conjugate gradients scaled with the cells' faces over their spacing.
fn released<const D: usize>(
    around: &Neighbourhood<D>,
    force: &[f64],
    apply: impl Fn(&[f64]) -> Vec<f64>,
) -> f64 {
    let cloud = &around.cloud;
    let scale: Vec<f64> = (0..cloud.len())
        .map(|i| cloud.spacing(i).powi(2 - D as i32))
        .collect();
    let face = |i: usize| cloud.volume[i] / cloud.spacing(i);
    let noise: f64 = (0..cloud.len())
        .map(|i| (ROUNDING * face(i)).powi(2) * scale[i])
        .sum();
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&scale).map(|(r, s)| r * s).collect() };
    let mut residual = force.to_vec();
    let mut direction = scaled(&residual);
    let (mut size, mut release) = (dot(&residual, &direction), 0.0);
    for _ in 0..STEPS {
        let image = apply(&direction);
        let curvature = dot(&direction, &image);
        if size <= noise || curvature <= 0.0 {
            break;
        }
        let step = size / curvature;
        release += step * size;
        if step * size < GROWTH * release {
            break;
        }
        residual
            .iter_mut()
            .zip(&image)
            .for_each(|(r, a)| *r -= step * a);
        let next = scaled(&residual);
        let grown = dot(&residual, &next);
        direction
            .iter_mut()
            .zip(&next)
            .for_each(|(d, n)| *d = n + grown / size * *d);
        size = grown;
    }
    release
}
