//! Checks of the two-layer solution against tables, limits and the equation itself.

use super::*;

fn contrast(mobility: f64) -> TwoLayer {
    TwoLayer::new(TwoLayerParameters::halves(
        1.0,
        [mobility, 1.0],
        [1.0, 1.0],
        [1.0, 0.0],
    ))
    .unwrap()
}

fn uneven() -> TwoLayer {
    TwoLayer::new(TwoLayerParameters {
        layers: [
            Layer {
                thickness: 0.3,
                mobility: 25.0,
                storage: 2.0,
            },
            Layer {
                thickness: 0.9,
                mobility: 0.4,
                storage: 0.6,
            },
        ],
        end_pressures: [3.0, -1.0],
        initial_pressure: 0.5,
        origin: 10.0,
        axis: 1,
    })
    .unwrap()
}

#[test]
fn transients_match_the_table_to_every_printed_digit() {
    let table = [
        (1e0, 0.02, [0.211_299_55, 0.012_419_33, 0.000_176_83]),
        (1e0, 0.1, [0.576_059_50, 0.262_756_27, 0.088_343_91]),
        (1e2, 0.02, [0.989_348_06, 0.978_886_28, 0.187_910_92]),
        (1e2, 0.1, [0.994_822_47, 0.989_650_42, 0.481_085_60]),
        (1e4, 0.02, [0.999_900_20, 0.999_800_42, 0.210_889_69]),
        (1e4, 0.1, [0.999_948_07, 0.999_896_14, 0.487_649_83]),
        (1e8, 0.02, [0.999_999_99, 0.999_999_98, 0.211_122_69]),
        (1e8, 0.1, [0.999_999_99, 0.999_999_99, 0.487_715_59]),
    ];
    for (mobility, time, expected) in table {
        for (x, value) in [0.25, 0.5, 0.75].into_iter().zip(expected) {
            let found = contrast(mobility).pressure(&[x], time);
            // Half a unit of the last digit.
            assert!(
                (found - value).abs() < 5.000_001e-9,
                "K1 = {mobility}, t = {time}, x = {x}: {found}"
            );
        }
    }
}

#[test]
fn eigenfunctions_and_laplace_inversion_agree() {
    let mut solutions: Vec<TwoLayer> = [1e-6, 1e-3, 0.2, 1.0, 1e2, 1e4, 1e8, 1e12]
        .map(contrast)
        .to_vec();
    solutions.push(uneven());
    for solution in solutions {
        let parameters = solution.parameters();
        let rises = parameters
            .end_pressures
            .map(|end| end - parameters.initial_pressure);
        let earliest = FORGOTTEN / solution.modes.last().unwrap().decay_rate();
        for time in [1.0, 2.0, 30.0, 1e3, 1e6].map(|factor| factor * earliest) {
            for (layer, depth) in [(0, 0.2), (0, 0.9), (0, 1.0), (1, 1.0), (1, 0.6), (1, 0.01)] {
                let place = Place { layer, depth };
                let modal = solution.steady_at(place) + modes::sum(&solution.modes, place, time);
                let inverted = parameters.initial_pressure
                    + laplace::rise(&parameters.layers, rises, place, time);
                let difference = (modal - inverted).abs();
                assert!(
                    difference < 1e-12,
                    "{:?} {time} {place:?}: {difference:e}",
                    parameters.layers
                );
            }
        }
    }
}

#[test]
fn extreme_contrasts_stay_finite_and_bounded() {
    for mobility in [1e-12, 1e-9, 1e9, 1e12] {
        let solution = contrast(mobility);
        for time in [
            1e-300,
            1e-12,
            1e-3,
            0.02,
            0.1,
            10.0,
            1e9,
            1e15,
            f64::INFINITY,
        ] {
            for step in 0..=40 {
                let pressure = solution.pressure(&[f64::from(step) / 40.0], time);
                assert!(
                    (-1e-11..=1.0 + 1e-11).contains(&pressure),
                    "{mobility} {time}: {pressure}"
                );
            }
        }
    }
}

/// A layer without resistance holds the interface at 1; one that seals keeps the other at 0.
#[test]
fn extreme_contrasts_have_their_one_layer_limits() {
    let conducting = contrast(1e12);
    // One layer of length ½ with D = 1, sine series at its middle.
    let series = |time: f64| -> f64 {
        0.5 - (1..60)
            .map(|n| {
                let wave = f64::from(n) * std::f64::consts::PI;
                let decay = (-4.0 * wave * wave * time).exp();
                2.0 / wave * (0.5 * wave).sin() * decay
            })
            .sum::<f64>()
    };
    for time in [0.02, 0.1, 0.5] {
        assert!((conducting.pressure(&[0.75], time) - series(time)).abs() < 1e-10);
        assert!((conducting.pressure(&[0.5], time) - 1.0).abs() < 1e-10);
        assert!(contrast(1e-12).pressure(&[0.75], time).abs() < 1e-11);
    }
}

#[test]
fn the_equation_holds_in_each_layer_and_the_flux_across() {
    let solution = uneven();
    let (h, dt) = (1e-3, 1e-4);
    for time in [1e-2, 0.05, 0.4] {
        for (x, layer) in [(10.1, 0), (10.25, 0), (10.4, 1), (10.9, 1)] {
            let Layer {
                mobility, storage, ..
            } = solution.parameters().layers[layer];
            let at = |x: f64, time: f64| solution.pressure(&[0.0, x], time);
            let curvature = (at(x + h, time) + at(x - h, time) - 2.0 * at(x, time)) / (h * h);
            let rate = (at(x, time + dt) - at(x, time - dt)) / (2.0 * dt);
            let (storing, flowing) = (storage * rate, mobility * curvature);
            let scale = storing.abs().max(1e-2);
            assert!(
                (storing - flowing).abs() < 2e-3 * scale,
                "{time} {x}: {storing} {flowing}"
            );
        }
        let [near, far] = solution.parameters().layers;
        let pressure = |by: f64| solution.pressure(&[0.0, solution.interface() + by], time);
        let centre = pressure(0.0);
        let h = 1e-4;
        let left = near.mobility * (3.0 * centre - 4.0 * pressure(-h) + pressure(-2.0 * h));
        let right = far.mobility * (4.0 * pressure(h) - 3.0 * centre - pressure(2.0 * h));
        assert!((left / right - 1.0).abs() < 1e-3, "{time}: {left} {right}");
    }
}

#[test]
fn the_ends_of_time_are_the_initial_and_the_steady_state() {
    let solution = uneven();
    for x in [10.05, 10.2, 10.3, 10.31, 10.8, 11.15] {
        let early = solution.pressure(&[0.0, x, 0.0], 1e-9);
        assert!((early - 0.5).abs() < 1e-11, "{x}: {early}");
        let late = solution.pressure(&[0.0, x, 0.0], f64::INFINITY);
        assert!((late - solution.steady_pressure(x)).abs() < 1e-15);
        assert!((solution.pressure(&[0.0, x], 1e4) - late).abs() < 1e-15);
    }
    for time in [1e-9, 1e-2, 1.0] {
        assert!((solution.pressure(&[0.0, 10.0], time) - 3.0).abs() < 1e-11);
        // 11.2 − 10 is not 1.2 to the last bit, and the early profile is steep.
        assert!((solution.pressure(&[0.0, 11.2], time) + 1.0).abs() < 1e-9);
    }
    assert!((solution.pressure(&[0.0, 10.5], 0.0) - 0.5).abs() < f64::EPSILON);
    assert!(
        solution.pressure(&[10.5], 1.0).is_nan(),
        "no coordinate along the axis"
    );
}

#[test]
fn the_steady_state_is_that_of_resistances_in_series() {
    for mobility in [1e-12, 1.0, 1e2, 1e12] {
        let solution = contrast(mobility);
        let expected = mobility / (mobility + 1.0);
        assert!((solution.interface_pressure() / expected - 1.0).abs() < 1e-14);
        assert!((solution.steady_flux() / (2.0 * expected) - 1.0).abs() < 1e-14);
    }
    let solution = uneven();
    let flux = solution.steady_flux();
    let fall = solution.steady_pressure(10.1) - solution.steady_pressure(10.2);
    assert!((fall * 25.0 / 0.1 / flux - 1.0).abs() < 1e-10);
    let fall = solution.steady_pressure(10.5) - solution.steady_pressure(10.6);
    assert!((fall * 0.4 / 0.1 / flux - 1.0).abs() < 1e-10);
}

#[test]
fn units_of_rock_give_the_scaled_solution() {
    let (mobility, storage, load) = (1e-13, 1e-10, 1e7);
    let rock = TwoLayer::new(TwoLayerParameters::halves(
        20.0,
        [1e2 * mobility, mobility],
        [storage; 2],
        [load, 0.0],
    ))
    .unwrap();
    let time = 0.1 * 400.0 * storage / mobility;
    let (found, expected) = (rock.pressure(&[15.0], time), 1e7 * 0.481_085_60);
    assert!((found - expected).abs() < 0.06, "{found} {expected}");
}

#[test]
fn impossible_layers_are_refused() {
    let mut parameters = *uneven().parameters();
    parameters.layers[1].mobility = f64::INFINITY;
    assert!(matches!(
        TwoLayer::new(parameters),
        Err(ReferenceError::NotPositive { .. })
    ));
    let mut parameters = *uneven().parameters();
    parameters.axis = 3;
    assert!(matches!(
        TwoLayer::new(parameters),
        Err(ReferenceError::WrongDimension { .. })
    ));
}
