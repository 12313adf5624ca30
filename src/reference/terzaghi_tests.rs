//! Checks of the Terzaghi solution against a table, limits and the equations themselves.

use super::*;

/// A = 1e-8 1/Pa, α = ½, S = 1.65e-10 1/Pa, κ = 1e-9 m²/(Pa·s), P₀ = 1e4 Pa, L = 15 m.
fn column(axis: usize, drained_end: f64, sealed_end: f64) -> Terzaghi {
    Terzaghi::new(TerzaghiParameters {
        axis,
        drained_end,
        sealed_end,
        load: 1e4,
        oedometer_modulus: 1e8,
        biot_coefficient: 0.5,
        storage: 1.65e-10,
        mobility: 1e-9,
    })
    .unwrap()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "{found} is not {expected}"
    );
}

/// Figures from the series in arbitrary precision, checked by a sum of images.
#[test]
fn the_table_is_met_to_every_printed_digit() {
    let column = column(0, 0.0, 15.0);
    let table = [
        (15.0, [4396.5178, 11796.568, 18285.307, 18761.434]),
        (30.0, [3131.7014, 8870.1987, 16623.613, 18702.787]),
        (60.0, [2222.4042, 6475.0809, 13799.231, 17808.888]),
    ];
    for (time, row) in table {
        for (x, expected) in [1.0, 3.0, 7.5, 15.0].into_iter().zip(row) {
            close(column.pressure(&[x, 0.3], time), expected, 5e-8);
        }
    }
    let table = [
        (15.0, [3.4399839e-4, 1.3819719e-4, 4.9215627e-5]),
        (30.0, [4.4801895e-4, 2.167308e-4, 6.8088584e-5]),
        (60.0, [5.9512423e-4, 3.4449259e-4, 1.2971634e-4]),
    ];
    for (time, row) in table {
        for (x, expected) in [0.0, 3.0, 7.5].into_iter().zip(row) {
            close(column.displacement(&[x, 0.3], time)[0], expected, 5e-8);
        }
    }
    close(column.loading_efficiency(), 1.8761726079, 1e-10);
    close(column.consolidation_coefficient(), 0.3752345216, 1e-10);
}

#[test]
fn the_undrained_state_holds_up_to_loading_and_the_drained_one_at_last() {
    let column = column(0, 0.0, 15.0);
    for time in [-1.0, 0.0, 1e-12] {
        close(column.pressure(&[4.0], time), 18761.726079, 1e-10);
        close(column.displacement(&[0.0], time)[0], 9.287054409e-5, 2e-6);
    }
    close(column.pressure(&[0.0], 0.0), 18761.726079, 1e-10);
    close(column.undrained_pressure(), 18761.726079, 1e-10);
    close(column.displacement(&[0.0], 0.0)[0], 9.287054409e-5, 1e-9);
    for time in [1e6, f64::INFINITY] {
        assert!(column.pressure(&[15.0], time).abs() < 1e-300);
        close(column.displacement(&[0.0], time)[0], 1.5e-3, 1e-14);
        close(column.displacement(&[6.0], time)[0], 9e-4, 1e-14);
    }
}

#[test]
fn images_and_modes_agree_where_they_meet() {
    for step in 0..=20 {
        let x = f64::from(step) / 20.0;
        let (early, late) = (
            Excess::from_images(x, SWITCH),
            Excess::from_modes(x, SWITCH),
        );
        // At the drained end the image left out last remains, 5e-41.
        let scale = late.pressure.abs().max(1e-28);
        assert!(
            (early.pressure - late.pressure).abs() <= 1e-12 * scale,
            "{x}"
        );
        // At the sealed end both integrals are zero up to the rounding of 1.
        let scale = late.beyond.abs().max(1e-4);
        assert!((early.beyond - late.beyond).abs() <= 1e-12 * scale, "{x}");
    }
}

#[test]
fn the_ends_are_drained_and_fixed_at_all_times() {
    let column = column(0, 0.0, 15.0);
    for time in [1e-9, 1e-3, 1.0, 50.0, 70.0, 1e3] {
        assert!(column.pressure(&[0.0], time).abs() < 1e-11);
        assert!(column.displacement(&[15.0], time)[0].abs() < 1e-18);
        let outflow_end = [15.0 - 1e-3, 15.0].map(|x| column.pressure(&[x], time));
        assert!((outflow_end[0] - outflow_end[1]).abs() < 1e-3, "sealed");
    }
}

/// M ∂u/∂x = αp − P₀ and S ∂p/∂t + α ∂²u/∂x∂t = κ ∂²p/∂x², on both sides of the switch.
#[test]
fn it_satisfies_equilibrium_and_the_balance_of_fluid() {
    let (column, h, dt) = (column(0, 0.0, 15.0), 1e-2, 1e-2);
    let p = |x: f64, t: f64| column.pressure(&[x], t);
    let u = |x: f64, t: f64| column.displacement(&[x], t)[0];
    let strain = |x: f64, t: f64| (u(x + h, t) - u(x - h, t)) / (2.0 * h);
    for (x, t) in [(2.0, 15.0), (6.0, 40.0), (6.0, 80.0), (11.0, 300.0)] {
        close(1e8 * strain(x, t), 0.5 * p(x, t) - 1e4, 1e-5);
        let storing = 1.65e-10 * (p(x, t + dt) - p(x, t - dt)) / (2.0 * dt);
        let squeezing = 0.5 * (strain(x, t + dt) - strain(x, t - dt)) / (2.0 * dt);
        let flowing = 1e-9 * (p(x + h, t) + p(x - h, t) - 2.0 * p(x, t)) / (h * h);
        close(storing + squeezing, flowing, 1e-4);
    }
}

#[test]
fn a_mirrored_or_turned_column_is_the_same() {
    let standard = column(0, 0.0, 15.0);
    let mirrored = column(2, 12.0, -3.0);
    for time in [0.0, 2.0, 30.0, 90.0] {
        for s in [0.0, 0.7, 6.0, 14.0] {
            let position = [0.4, 9.0, 12.0 - s];
            close(
                mirrored.pressure(&position, time),
                standard.pressure(&[s], time),
                1e-12,
            );
            let moved = mirrored.displacement(&position, time);
            let along = standard.displacement(&[s], time)[0];
            assert!(along > 0.0, "a compressed column shortens");
            assert_eq!(moved.len(), 3);
            assert!(moved[0].abs() + moved[1].abs() < f64::MIN_POSITIVE);
            close(moved[2], -along, 1e-12);
        }
    }
}

#[test]
fn a_position_without_the_axis_has_no_value() {
    let column = column(2, 0.0, 15.0);
    for time in [0.0, 1.0, 1e3] {
        assert!(column.pressure(&[1.0, 2.0], time).is_nan());
        let moved = column.displacement(&[1.0, 2.0], time);
        assert!(moved.len() == 2 && moved.iter().all(|u| u.is_nan()));
    }
}

/// Values from arbitrary-precision arithmetic.
#[test]
fn erfc_agrees_with_exact_values() {
    let table = [
        (-1.5, 1.966_105_146_475_310_7),
        (1e-3, 0.998_871_621_209_030_8),
        (0.5, 0.479_500_122_186_953_5),
        (1.499, 3.401_396_234_814_333e-2),
        (1.5, 3.389_485_352_468_927_4e-2),
        (1.999, 4.698_443_348_629_49e-3),
        (2.0, 4.677_734_981_047_266e-3),
        (3.0, 2.209_049_699_858_544e-5),
        (6.0, 2.151_973_671_249_891_3e-17),
        (15.0, 7.212_994_172_451_207e-100),
    ];
    for (x, expected) in table {
        close(erfc(x), expected, 3e-14);
        assert!((erf(x) + expected - 1.0).abs() < 1e-15);
    }
    assert!(erfc(1e200).abs() < f64::MIN_POSITIVE && erfc(f64::NAN).is_nan());
}

#[test]
fn impossible_parameters_are_named() {
    let example = column(0, 0.0, 15.0);
    let refusal = |change: &dyn Fn(&mut TerzaghiParameters)| {
        let mut parameters = example.parameters().clone();
        change(&mut parameters);
        Terzaghi::new(parameters).unwrap_err().to_string()
    };
    assert!(refusal(&|p| p.sealed_end = 0.0).contains("length"));
    assert!(refusal(&|p| p.storage = -1.0).contains("storage"));
    assert!(refusal(&|p| p.load = f64::NAN).contains("load"));
    assert!(refusal(&|p| p.axis = 3).contains("axis of the Terzaghi column"));
}
