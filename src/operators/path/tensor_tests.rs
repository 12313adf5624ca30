#![allow(clippy::float_cmp)]
use std::sync::Arc;

use super::*;
use crate::geometry::generate::lattice;
use crate::geometry::{Horizon, Influence, Vector, horizons};
use crate::operators::BondForm;
use crate::operators::path::{Cells, Path, Tessellation};

/// Tensor of principal values k1 and k2, the first at `degrees` to x.
fn turned(k1: f64, k2: f64, degrees: f64) -> PlaneTensor {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let (s, c) = (sine * sine, cosine * cosine);
    [k1 * c + k2 * s, k1 * s + k2 * c, (k1 - k2) * sine * cosine]
}

fn path(cells: [usize; 2], size: Vector<2>, kind: Cells) -> Path<2> {
    let cloud = lattice(Vector::zeros(), size, cells).unwrap();
    let horizon = horizons(&cloud, Horizon::Ratio(1.8)).unwrap();
    let families = Families::search(&cloud, horizon).unwrap();
    let found = Tessellation::new(&cloud, families, kind).unwrap();
    let influence = Influence::default();
    Path::new(
        &Arc::new(cloud),
        &found,
        true,
        influence,
        |_| true,
        |_, _| None,
    )
    .unwrap()
}

/// Rate out of every point for the differences of the pressure along its bonds (owner, bond).
fn rates(form: &Path<2>, difference: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let families = &form.neighbourhood().families;
    let mobility = vec![1.0; families.len()];
    let mut rate = vec![0.0; families.len()];
    for owner in 0..families.len() {
        let family = families.family(owner);
        let mut conductance = vec![0.0; family.len()];
        form.conductances(owner, &mobility, &mut conductance);
        for (bond, conductance) in family.zip(conductance) {
            let flow = conductance * difference(owner, bond);
            rate[owner] -= flow;
            rate[families.neighbour(bond)] += flow;
        }
    }
    rate
}

/// Those of a pressure at the points, with even images.
fn sealed(form: &Path<2>, pressure: impl Fn(&Vector<2>) -> f64) -> Vec<f64> {
    let around = form.neighbourhood();
    let at = |point: usize| pressure(&around.cloud.position[point]);
    rates(form, |owner, bond| {
        at(around.families.neighbour(bond)) - at(owner)
    })
}

fn inside(form: &Path<2>, point: usize) -> [bool; 2] {
    let (cloud, edges) = (
        &form.neighbourhood().cloud,
        form.neighbourhood().cloud.cell[point],
    );
    let (x, size) = (cloud.position[point], cloud.domain.size());
    [0, 1].map(|axis| x[axis] > edges[axis] && x[axis] < size[axis] - edges[axis])
}

const TENSORS: [[f64; 3]; 5] = [
    [1.0, 0.2, 30.0],
    [1.0, 0.001, 30.0],
    [1.0, 0.01, -72.0],
    [3.0, 1.0, 90.0],
    [1.0, 1e-4, 45.0],
];

/// Linear pressures leave no source inside and have the velocity K g; beside sealed sides those along which
/// nothing flows out do so too, whatever the shape of the cells and however oblique the tensor.
#[test]
fn uniform_flow_is_exact_up_to_sealed_sides() {
    for size in [
        Vector::<2>::new(7.0, 6.0),
        Vector::<2>::new(70.0, 6.0),
        Vector::<2>::new(3.0, 9.0),
    ] {
        for [k1, k2, angle] in TENSORS {
            let k = turned(k1, k2, angle);
            let form = path([7, 6], size, Cells::Oblique).with_tensors(&[k; 42]);
            let slope = Vector::<2>::new(0.7, -0.4);
            let rate = sealed(&form, |x| slope.dot(x));
            for point in (0..42).filter(|point| inside(&form, *point) == [true; 2]) {
                let scale = (size[0] + size[1]) * (size[0] / size[1] + size[1] / size[0]);
                assert!(
                    rate[point].abs() < 1e-14 * scale,
                    "{angle}: {}",
                    rate[point]
                );
                let along = |bond: usize| slope.dot(&form.neighbourhood().bond_vector(point, bond));
                let velocity = form.flux(point, &[1.0; 42], &along);
                let exact = -Vector::<2>::new(
                    k[0] * slope[0] + k[2] * slope[1],
                    k[2] * slope[0] + k[1] * slope[1],
                );
                assert!((velocity - exact).amax() < 1e-12, "{velocity} {exact}");
            }
            // Nothing crosses the sides at the bottom and at the top where K_xy g_x + K_yy g_y = 0.
            let slope = Vector::<2>::new(1.0, -k[2] / k[1]);
            let rate = sealed(&form, |x| slope.dot(x));
            for point in (0..42).filter(|point| inside(&form, *point)[0]) {
                let scale = k[0] * size[1] / size[0] + k[1] * size[0] / size[1];
                assert!(
                    rate[point].abs() < 1e-12 * scale * 70.0,
                    "{angle}: {}",
                    rate[point]
                );
            }
        }
    }
}

/// Across layers of two tensors the normal flux and the slope along them are continuous.
#[test]
fn layers_of_tensors_are_exact_at_every_contrast() {
    for contrast in [1e-8, 1e-2, 1.0, 1e3, 1e8] {
        for (first, second) in [
            ([1.0, 0.2, 30.0], [1.0, 1.0, 0.0]),
            ([1.0, 0.01, 60.0], [1.0, 0.1, -20.0]),
        ] {
            let a = turned(first[0], first[1], first[2]);
            let b = turned(second[0], second[1], second[2]).map(|own| own * contrast);
            for n in 0..2 {
                let t = 1 - n;
                let layer = |x: &Vector<2>| if x[n] < 3.0 { a } else { b };
                let form = path([6, 6], Vector::repeat(6.0), Cells::Oblique);
                let position = &form.neighbourhood().cloud.position;
                let tensors: Vec<PlaneTensor> = position.iter().map(layer).collect();
                let form = form.with_tensors(&tensors);
                let (flux, along) = (1e-3 * contrast.min(1.0), 0.3);
                let slope = |k: &PlaneTensor| (flux - k[2] * along) / k[n];
                let rate = sealed(&form, |x| slope(&layer(x)) * (x[n] - 3.0) + along * x[t]);
                let scale = 1.0 + contrast;
                for point in (0..36).filter(|point| inside(&form, *point) == [true; 2]) {
                    assert!(
                        rate[point].abs() < 1e-14 * scale,
                        "{contrast:e}: {}",
                        rate[point]
                    );
                }
            }
        }
    }
}

/// A tensor without direction is the isotropic operator.
#[test]
fn equal_principal_values_give_the_isotropic_operator() {
    let size = Vector::<2>::new(6.0, 5.0);
    let plain = path([6, 5], size, Cells::Lattice);
    let form = path([6, 5], size, Cells::Oblique).with_tensors(&[turned(1.0, 1.0, 17.0); 30]);
    let value = |x: &Vector<2>| (1.3 * x[0]).sin() * (0.7 * x[1]).cos();
    let pairs = sealed(&plain, value).into_iter().zip(sealed(&form, value));
    pairs.for_each(|(plain, own)| assert!((plain - own).abs() < 1e-14));
}

/// On squares all conductances are positive while |K_xy| is below K_xx and K_yy: at least up to
/// k1/k2 = (1 + √2)² = 5.83, the least over all angles, at 22.5°; further along the axes and the diagonals.
#[test]
fn conductances_are_positive_as_far_as_eight_neighbours_allow() {
    let signed = |k: PlaneTensor| {
        path([5, 5], Vector::repeat(5.0), Cells::Oblique)
            .with_tensors(&[k; 25])
            .signed(&[1.0; 25])
    };
    for degrees in (-90..90).map(f64::from) {
        assert_eq!(signed(turned(1.0, 1.0 / 5.8, degrees)), 0, "{degrees}");
    }
    assert_eq!(signed(turned(1.0, 1.0 / 5.85, 22.5)), 25);
    assert_eq!(signed(turned(1.0, 1.0 / 6.4, 30.0)), 0);
    assert_eq!(signed(turned(1.0, 1.0 / 6.6, 30.0)), 25);
    assert_eq!(
        signed(turned(1.0, 1e-6, 0.0)) + signed(turned(1.0, 1e-6, -45.0)),
        0
    );
}

/// Σ over the six bonds of c (difference)².
fn energy(square: &Square, p: [f64; 4]) -> f64 {
    let [own, along, up, across] = p;
    let edges = [along - own, across - up, up - own, across - along];
    let diagonals = [across - own, up - along];
    let edges = square.edges.iter().zip(edges);
    let all = edges.chain(square.diagonals.iter().zip(diagonals));
    all.map(|(c, d)| c * d * d).sum()
}

/// No pressures have a negative energy, for pairs of tensors in layers and for any four; those that are not in
/// layers have positive bonds.
#[test]
fn squares_never_have_negative_energy() {
    let mut state = 7_u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for _ in 0..2000 {
        let mut draw = || {
            let k1 = 10_f64.powf(6.0 * random() - 3.0);
            turned(k1, k1 * 10_f64.powf(-3.0 * random()), 180.0 * random())
        };
        let [a, b, c, d] = [draw(), draw(), draw(), draw()];
        for tensors in [
            [a; 4],
            [a, b, a, b],
            [a, a, b, b],
            [a, a, a, b],
            [a, b, c, d],
        ] {
            let square = Square::new(tensors);
            let scale: f64 = tensors.iter().map(|k| k[0] + k[1]).sum();
            for _ in 0..20 {
                let p = [random(), random(), random(), random()];
                assert!(energy(&square, p) > -1e-13 * scale, "{tensors:?} {p:?}");
            }
            let layered = tensors[0] == tensors[1] && tensors[2] == tensors[3]
                || tensors[0] == tensors[2] && tensors[1] == tensors[3];
            assert!(layered || !square.is_signed(), "{tensors:?}");
        }
    }
}
