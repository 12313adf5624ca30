//! The law against its own differences, and a bar by hand.

use proptest::prelude::*;

use super::*;
use crate::geometry::Vector;

const ROCK: Lame = Lame {
    lambda: 4e9,
    mu: 3e9,
};
const TOUGHNESS: f64 = 2e4;
const SPLITS: [EnergySplit; 3] = [
    EnergySplit::Spectral,
    EnergySplit::VolumetricDeviatoric,
    EnergySplit::None,
];

fn law<const D: usize>(split: EnergySplit, prestress: f64) -> DamageLaw<D> {
    DamageLaw {
        split,
        residual_stiffness: 1e-3,
        hourglass: HourglassRule::Variational,
        prestress: Matrix::from_fn(|a, b| prestress * if a == b { 1.0 } else { 0.2 }),
    }
}

fn symmetric<const D: usize>(entries: &[f64]) -> Matrix<D> {
    let full: Matrix<D> = Matrix::from_fn(|a, b| entries[a * D + b]);
    (full + full.transpose()) * 0.5
}

/// The stress is the derivative of the energy, and the exact tangent that of the stress.
fn check<const D: usize>(law: &DamageLaw<D>, history: f64, strain: &Matrix<D>, way: &Matrix<D>) {
    let response = |e: &Matrix<D>| law.response(ROCK, TOUGHNESS, history, e, 0.0);
    let step = 1e-6;
    let (ahead, behind) = (
        response(&(strain + way * step)),
        response(&(strain - way * step)),
    );
    let here = response(strain);
    let slope = (ahead.energy - behind.energy) / (2.0 * step);
    let scale = ROCK.mu * strain.norm() * way.norm();
    assert!(
        (slope - here.stress.dot(way)).abs() < 1e-4 * scale,
        "{law:?}: {slope}"
    );
    let tangent = law.tangent(
        ROCK,
        TOUGHNESS,
        (history, here.driving),
        strain,
        TangentKind::Consistent,
    );
    let slope = (ahead.stress - behind.stress) / (2.0 * step);
    let error = (slope - tangent.stress(way)).amax();
    assert!(
        error < 2e-3 * ROCK.mu * way.norm(),
        "{law:?} {strain}: {error}"
    );
}

/// Strains away from the kinks of the splits, where derivatives exist.
fn smooth<const D: usize>(strain: &Matrix<D>) -> bool {
    let (values, _) = crate::material::eigen::eigen(strain);
    let far = 3e-5;
    values.iter().all(|v| v.abs() > far) && strain.trace().abs() > far
}

proptest! {
    #[test]
    fn stress_and_tangent_are_derivatives_in_a_plane(
        entries in prop::array::uniform4(-3e-3..3e-3_f64),
        way in prop::array::uniform4(-1.0..1.0_f64),
        split in 0..3_usize,
        prestress in prop::sample::select(vec![0.0, -2e6, 3e6]),
    ) {
        let strain = symmetric::<2>(&entries);
        prop_assume!(smooth(&strain));
        check(&law(SPLITS[split], prestress), 0.0, &strain, &symmetric(&way));
    }

    #[test]
    fn stress_and_tangent_are_derivatives_in_space(
        entries in prop::array::uniform9(-3e-3..3e-3_f64),
        way in prop::array::uniform9(-1.0..1.0_f64),
        split in 0..3_usize,
    ) {
        let strain = symmetric::<3>(&entries);
        prop_assume!(smooth(&strain));
        check(&law(SPLITS[split], 0.0), 0.0, &strain, &symmetric(&way));
    }

    #[test]
    fn bounded_softening_leaves_every_point_positive(
        entries in prop::array::uniform9(-3e-2..3e-2_f64),
        way in prop::array::uniform9(-1.0..1.0_f64),
        split in 0..3_usize,
    ) {
        let (strain, way) = (symmetric::<3>(&entries), symmetric::<3>(&way));
        let law = law(SPLITS[split], 0.0);
        for strain in [strain, way * 1e-3] {
            let driving = law.parts(ROCK, &strain).tensile_energy;
            let tangent =
                law.tangent(ROCK, TOUGHNESS, (0.0, driving), &strain, TangentKind::Bounded);
            prop_assert!(tangent.stress(&way).dot(&way) > 0.0);
        }
    }

    #[test]
    fn the_parts_add_up_to_the_whole(
        entries in prop::array::uniform4(-3e-3..3e-3_f64),
        split in 0..3_usize,
    ) {
        let strain = symmetric::<2>(&entries);
        let parts = law(SPLITS[split], 0.0).parts(ROCK, &strain);
        let stress = ROCK.stress(&strain);
        prop_assert!((parts.degraded_stress + parts.intact_stress - stress).amax() < 1e-6 * stress.norm());
        let whole = parts.tensile_energy + parts.compressive_energy;
        prop_assert!((whole - 0.5 * stress.dot(&strain)).abs() < 1e-12 * whole);
    }
}

/// What has been driven further before keeps its damage: the stress is linear there.
#[test]
fn unloading_keeps_the_damage() {
    let law = law::<2>(EnergySplit::Spectral, 0.0);
    let strain = Matrix::from_diagonal(&Vector::<2>::new(1e-3, 5e-4));
    let loaded = law.response(ROCK, TOUGHNESS, 0.0, &(strain * 3.0), 0.0);
    let back = law.response(ROCK, TOUGHNESS, loaded.driving, &strain, 0.0);
    assert!((back.damage - loaded.damage).abs() < 1e-15);
    assert!((back.stress * 3.0 - loaded.stress).amax() < 1e-6);
    check(&law, loaded.driving, &strain, &Matrix::identity());
}

/// Plane compression is not weakened by damage in the split that keeps it.
#[test]
fn closed_cracks_carry_compression() {
    let law = law::<2>(EnergySplit::Spectral, 0.0);
    let strain = Matrix::from_diagonal(&Vector::<2>::new(-1e-3, -2e-3));
    let broken = law.history(0.999, TOUGHNESS);
    let response = law.response(ROCK, TOUGHNESS, broken, &strain, 0.0);
    assert!((response.damage - 0.999).abs() < 1e-12);
    assert!((response.stress - ROCK.stress(&strain)).amax() < 1e-3);
}

/// REFERENCES.md, damage bar: σ_c = (3√3/16)√(2EG_c/ℓ) at ε_c = √(2G_c/3Eℓ); ν = 0 and uniaxial strain.
#[test]
fn a_bar_breaks_at_the_peak_of_the_closed_form() {
    let modulus = 2e10;
    let rock = Lame {
        lambda: 0.0,
        mu: 0.5 * modulus,
    };
    let law = DamageLaw::<2> {
        split: EnergySplit::Spectral,
        residual_stiffness: 1e-12,
        prestress: Matrix::zeros(),
        hourglass: HourglassRule::Variational,
    };
    let critical = (2.0 * TOUGHNESS / (3.0 * modulus)).sqrt();
    let strength = 3.0 * 3.0_f64.sqrt() / 16.0 * (2.0 * modulus * TOUGHNESS).sqrt();
    let stress = |strain: f64| {
        let strain = Matrix::from_diagonal(&Vector::<2>::new(strain, 0.0));
        law.response(rock, TOUGHNESS, 0.0, &strain, 0.0).stress[(0, 0)]
    };
    assert!((stress(critical) / strength - 1.0).abs() < 1e-9);
    assert!(stress(0.99 * critical) < strength && stress(1.01 * critical) < strength);
    let steps = 400_000;
    let width = 400.0 * critical / f64::from(steps);
    let work: f64 = (0..steps)
        .map(|k| stress((f64::from(k) + 0.5) * width) * width)
        .sum();
    assert!((work / TOUGHNESS - 1.0).abs() < 1e-3, "{work}");
}

/// Plane strain is strain in space without a third component.
#[test]
fn the_stress_across_a_plane_is_that_of_space() {
    for split in SPLITS {
        for entries in [[1e-3, 4e-4, 4e-4, -3e-4], [-1e-3, 2e-4, 2e-4, 1e-4]] {
            let plane = symmetric::<2>(&entries);
            let space = Matrix::<3>::from_fn(|a, b| if a.max(b) < 2 { plane[(a, b)] } else { 0.0 });
            let [degraded_stress, intact_stress] = law::<2>(split, 0.0).across(ROCK, &plane);
            let parts = law::<3>(split, 0.0).parts(ROCK, &space);
            assert!(
                (degraded_stress - parts.degraded_stress[(2, 2)]).abs() < 1e-3,
                "{split:?}"
            );
            assert!(
                (intact_stress - parts.intact_stress[(2, 2)]).abs() < 1e-3,
                "{split:?}"
            );
        }
    }
}
