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

fn law(split: EnergySplit) -> DamageLaw {
    DamageLaw {
        model: DamageModel::Paper,
        exponent: Exponent::Two,
        friction: 0.6,
        split,
        residual_stiffness: 1e-3,
        hourglass: HourglassRule::Variational,
    }
}

fn cut(exponent: Exponent) -> DamageLaw {
    DamageLaw {
        model: DamageModel::Split,
        exponent,
        ..law(EnergySplit::Spectral)
    }
}

/// A point of `ROCK` that has seen `history`.
fn point<const D: usize>(prestress: f64, history: f64) -> PointState<D> {
    PointState {
        lame: ROCK,
        toughness: TOUGHNESS,
        history,
        prestress: Matrix::from_fn(|a, b| prestress * if a == b { 1.0 } else { 0.2 }),
        normal: None,
        fluid: 0.0,
    }
}

fn symmetric<const D: usize>(entries: &[f64]) -> Matrix<D> {
    let full: Matrix<D> = Matrix::from_fn(|a, b| entries[a * D + b]);
    (full + full.transpose()) * 0.5
}

/// The stress is the derivative of the energy, and the exact tangent that of the stress.
fn check<const D: usize>(
    law: &DamageLaw,
    point: &PointState<D>,
    strain: &Matrix<D>,
    way: &Matrix<D>,
) {
    let response = |e: &Matrix<D>| law.response(point, e, 0.0);
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
    let tangent = law.tangent(point, here.driving, strain, TangentKind::Consistent);
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
        let (law, point) = (law(SPLITS[split]), point(prestress, 0.0));
        // Stress of the rock at rest may drive nothing: first damage is a kink too.
        let driving = law.response(&point, &strain, 0.0).driving;
        prop_assume!(smooth(&strain) && driving.abs() > 100.0);
        check(&law, &point, &strain, &symmetric(&way));
    }

    #[test]
    fn stress_and_tangent_are_derivatives_in_space(
        entries in prop::array::uniform9(-3e-3..3e-3_f64),
        way in prop::array::uniform9(-1.0..1.0_f64),
        split in 0..3_usize,
    ) {
        let strain = symmetric::<3>(&entries);
        prop_assume!(smooth(&strain));
        check(&law(SPLITS[split]), &point(0.0, 0.0), &strain, &symmetric(&way));
    }

    #[test]
    fn bounded_softening_leaves_every_point_positive(
        entries in prop::array::uniform9(-3e-2..3e-2_f64),
        way in prop::array::uniform9(-1.0..1.0_f64),
        split in 0..3_usize,
    ) {
        let (strain, way) = (symmetric::<3>(&entries), symmetric::<3>(&way));
        let point = point(0.0, 0.0);
        for law in [law(SPLITS[split]), cut(Exponent::ThreeHalves)] {
            for strain in [strain, way * 1e-3] {
                let driving = law.response(&point, &strain, 0.0).driving;
                let tangent = law.tangent(&point, driving, &strain, TangentKind::Bounded);
                prop_assert!(tangent.stress(&way).dot(&way) > 0.0);
            }
        }
    }

    #[test]
    fn the_parts_add_up_to_the_whole(
        entries in prop::array::uniform4(-3e-3..3e-3_f64),
        split in 0..3_usize,
    ) {
        let strain = symmetric::<2>(&entries);
        let parts = law(SPLITS[split]).parts(&point(0.0, 0.0), &strain);
        let stress = ROCK.stress(&strain);
        prop_assert!((parts.degraded_stress + parts.intact_stress - stress).amax() < 1e-6 * stress.norm());
        let whole = parts.tensile_energy + parts.compressive_energy;
        prop_assert!((whole - 0.5 * stress.dot(&strain)).abs() < 1e-12 * whole);
    }
}

/// What has been driven further before keeps its damage: the stress is linear there.
#[test]
fn unloading_keeps_the_damage() {
    let strain = Matrix::from_diagonal(&Vector::<2>::new(1e-3, 5e-4));
    for law in [law(EnergySplit::Spectral), cut(Exponent::Two)] {
        let loaded = law.response(&point(0.0, 0.0), &(strain * 3.0), 0.0);
        let after = point(0.0, loaded.driving);
        let back = law.response(&after, &strain, 0.0);
        assert!((back.damage - loaded.damage).abs() < 1e-15);
        assert!((back.stress * 3.0 - loaded.stress).amax() < 1e-6);
        check(&law, &after, &strain, &Matrix::identity());
    }
}

/// Plane compression is not weakened by damage in the split that keeps it.
#[test]
fn closed_cracks_carry_compression() {
    let strain = Matrix::from_diagonal(&Vector::<2>::new(-1e-3, -2e-3));
    for law in [law(EnergySplit::Spectral), cut(Exponent::ThreeHalves)] {
        let broken = point(0.0, law.history(0.999, TOUGHNESS));
        let response = law.response(&broken, &strain, 0.0);
        assert!((response.damage - 0.999).abs() < 1e-12);
        assert!((response.stress - ROCK.stress(&strain)).amax() < 1e-3);
    }
}

/// REFERENCES.md, damage bar: σ_c = (3√3/16)√(2EG_c/ℓ) at ε_c = √(2G_c/3Eℓ); ν = 0 and uniaxial strain.
#[test]
fn a_bar_breaks_at_the_peak_of_the_closed_form() {
    let modulus = 2e10;
    let rock = Lame {
        lambda: 0.0,
        mu: 0.5 * modulus,
    };
    let law = DamageLaw {
        residual_stiffness: 1e-12,
        ..law(EnergySplit::Spectral)
    };
    let rock = PointState {
        lame: rock,
        ..point::<2>(0.0, 0.0)
    };
    let critical = (2.0 * TOUGHNESS / (3.0 * modulus)).sqrt();
    let strength = 3.0 * 3.0_f64.sqrt() / 16.0 * (2.0 * modulus * TOUGHNESS).sqrt();
    let stress = |strain: f64| {
        let strain = Matrix::from_diagonal(&Vector::<2>::new(strain, 0.0));
        law.response(&rock, &strain, 0.0).stress[(0, 0)]
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
            let [degraded_stress, intact_stress] = law(split).across(ROCK, &plane);
            let parts = law(split).parts(&point(0.0, 0.0), &space);
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

/// A cut point with everything that acts on it.
fn loaded<const D: usize>(
    entries: &[f64],
    normal: bool,
    fluid: f64,
    history: f64,
) -> PointState<D> {
    let normal = normal.then(|| Vector::<D>::from_fn(|k, _| 0.4 + entries[k] * 100.0).normalize());
    PointState {
        prestress: symmetric(entries) * 1e9,
        normal,
        fluid,
        ..point(0.0, history)
    }
}

/// Whether the response is smooth in a small neighbourhood: away from opening, closing, first damage after
/// unloading and equal principal stresses.
fn regular<const D: usize>(law: &DamageLaw, point: &PointState<D>, strain: &Matrix<D>) -> bool {
    let response = law.response(point, strain, 0.0);
    let stress = ROCK.stress(strain) + point.prestress;
    let (values, _) = crate::material::eigen::eigen(&stress);
    let largest = values.max();
    let apart = values.iter().filter(|v| largest - **v < 1e6).count() == 1;
    let edge = (response.driving - point.history).abs() > 0.05 * point.history;
    // The same faces all around.
    let same = [-2e4, 2e4].iter().all(|by| {
        let near = PointState {
            fluid: point.fluid + by,
            ..*point
        };
        let other = law.response(&near, strain, 0.0).plane;
        let kinds = [&other, &response.plane].map(|plane| {
            let sheared = plane.released - across(ROCK, &plane.normal) * plane.strain;
            (
                plane.open,
                sheared.norm() > 1e-6 * plane.released.norm(),
                plane.parting.norm(),
            )
        });
        let far = (kinds[0].2 - kinds[1].2).abs() > 0.05 * kinds[1].2;
        kinds[0].0 == kinds[1].0 && kinds[0].1 == kinds[1].1 && !far
    });
    same && edge && (point.normal.is_some() || apart)
}

/// The energy's derivative by what the fluid adds is minus the opening, and that of the opening is what yields and
/// what softens.
fn check_fluid<const D: usize>(law: &DamageLaw, point: &PointState<D>, strain: &Matrix<D>) {
    let at = |by: f64| {
        let fluid = point.fluid + by;
        law.response(&PointState { fluid, ..*point }, strain, 0.0)
    };
    let (step, here) = (1e2, at(0.0));
    let (ahead, behind) = (at(step), at(-step));
    let slope = (ahead.energy - behind.energy) / (2.0 * step);
    let size = here.plane.strain + 1e6 / ROCK.mu;
    assert!((slope + here.plane.opening).abs() < 1e-4 * size, "{slope}");
    let slope = (ahead.plane.opening - behind.plane.opening) / (2.0 * step);
    let softening = match here.driving > point.history {
        true => law.softening(here.driving, point.toughness),
        false => 0.0,
    };
    let exact = here.plane.yielding + softening * here.plane.strain.powi(2);
    assert!((slope - exact).abs() < 1e-4 / ROCK.mu, "{slope} {exact}");
}

proptest! {
    /// Open and closed, wet and dry, with a settled and a turning normal, loading and unloading.
    #[test]
    fn a_cut_point_has_an_energy_in_a_plane(
        entries in prop::array::uniform4(-3e-3..3e-3_f64),
        stress in prop::array::uniform4(-3e-3..3e-3_f64),
        way in prop::array::uniform4(-1.0..1.0_f64),
        normal in any::<bool>(),
        fluid in prop::sample::select(vec![0.0, -4e6, 9e6]),
        history in prop::sample::select(vec![0.0, 5e3, 1e5]),
        exponent in prop::sample::select(vec![Exponent::ThreeHalves, Exponent::Two]),
    ) {
        let (law, point) = (cut(exponent), loaded::<2>(&stress, normal, fluid, history));
        let strain = symmetric(&entries);
        prop_assume!(regular(&law, &point, &strain));
        check(&law, &point, &strain, &symmetric(&way));
        check_fluid(&law, &point, &strain);
    }

    #[test]
    fn a_cut_point_has_an_energy_in_space(
        entries in prop::array::uniform9(-3e-3..3e-3_f64),
        stress in prop::array::uniform9(-3e-3..3e-3_f64),
        way in prop::array::uniform9(-1.0..1.0_f64),
        normal in any::<bool>(),
        fluid in prop::sample::select(vec![0.0, 9e6]),
    ) {
        let law = cut(Exponent::ThreeHalves);
        let (point, strain) = (loaded::<3>(&stress, normal, fluid, 5e3), symmetric(&entries));
        prop_assume!(regular(&law, &point, &strain));
        check(&law, &point, &strain, &symmetric(&way));
        check_fluid(&law, &point, &strain);
    }
}

/// docs/theory.md, section 19, in the axes of the plane: nn is g σ_nn − (1 − g) p^c, nt is g σ_nt, and tt loses
/// (1 − g)(λ/M) q_n only.
#[test]
fn the_stress_of_a_cut_point_in_the_axes_of_its_plane() {
    let law = cut(Exponent::Two);
    let (pressure, left) = (7e6, law.degradation(0.9));
    let point = PointState::<2> {
        normal: Some(Vector::<2>::new(0.0, 1.0)),
        fluid: pressure,
        ..point(-1e6, law.history(0.9, TOUGHNESS))
    };
    let strain = Matrix::<2>::new(-2e-4, 1e-4, 1e-4, 3e-4);
    let whole = ROCK.stress(&strain) + point.prestress;
    let stress = law.response(&point, &strain, 0.0).stress;
    let lost = 1.0 - left;
    let share = ROCK.lambda / (ROCK.lambda + 2.0 * ROCK.mu);
    assert!((stress[(1, 1)] - (left * whole[(1, 1)] - lost * pressure)).abs() < 1.0);
    assert!((stress[(0, 1)] - left * whole[(0, 1)]).abs() < 1.0);
    let along = whole[(0, 0)] - lost * share * (whole[(1, 1)] + pressure);
    assert!((stress[(0, 0)] - along).abs() < 1.0);
}

/// docs/theory.md, section 19: compressed by 2e-4 and then pulled apart, sides held. Nothing breaks in compression, and the total
/// stress peaks at the same strength whatever the in-situ stress is: 0.573 √(M c).
#[test]
fn in_situ_stress_does_not_break_rock_and_leaves_its_strength() {
    let law = DamageLaw {
        residual_stiffness: 1e-9,
        ..cut(Exponent::ThreeHalves)
    };
    let modulus = ROCK.lambda + 2.0 * ROCK.mu;
    for prestress in [0.0, -5e6, -30e6] {
        let mut point = point::<2>(0.0, 0.0);
        point.prestress = Matrix::identity() * prestress;
        let at = |point: &PointState<2>, strain: f64| {
            law.response(
                point,
                &Matrix::from_diagonal(&Vector::<2>::new(0.0, strain)),
                0.0,
            )
        };
        let compressed = at(&point, -2e-4);
        assert!(compressed.driving <= 0.0 && compressed.damage <= 0.0);
        let strains = (0..40_000).map(|k| f64::from(k) * 5e-7 - prestress / modulus);
        let peak = strains
            .map(|e| at(&point, e).stress[(1, 1)])
            .fold(f64::MIN, f64::max);
        let strength = 0.573 * (modulus * TOUGHNESS).sqrt();
        assert!(
            (peak / strength - 1.0).abs() < 2e-3,
            "{prestress}: {peak} {strength}"
        );
    }
}
