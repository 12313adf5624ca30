//! Checks of the Mandel solution against figures, limits and the equations themselves.

use super::*;

/// λ = ½, μ = ¾, α = 0.6, S = 0.2125 (1/S = 4.705882), κ = 1.5, F = 1, a = 1, height 0.1.
fn parameters() -> MandelParameters {
    MandelParameters {
        half_width: 1.0,
        height: 0.1,
        origin: [0.0; 2],
        drained_axis: 0,
        force: 1.0,
        lame_lambda: 0.5,
        shear_modulus: 0.75,
        biot_coefficient: 0.6,
        storage: 0.2125,
        mobility: 1.5,
    }
}

fn strip() -> Mandel {
    Mandel::new(parameters()).unwrap()
}

/// Another rock, another size, another place, drained along y.
fn turned() -> Mandel {
    Mandel::new(MandelParameters {
        half_width: 2.5,
        height: 4.0,
        origin: [-1.0, 3.0],
        drained_axis: 1,
        force: 3e6,
        lame_lambda: 4e9,
        shear_modulus: 6e9,
        biot_coefficient: 0.8,
        storage: 7e-11,
        mobility: 2e-10,
    })
    .unwrap()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance * expected.abs(),
        "{found} is not {expected}"
    );
}

/// Figures from the series in arbitrary precision, checked by Laplace inversion.
#[test]
fn the_figures_are_met_to_every_printed_digit() {
    let strip = strip();
    close(strip.consolidation_coefficient(), 3.821656051, 2e-10);
    close(strip.undrained_pressure(), 0.4795204795, 1e-10);
    for (time, expected) in [
        (0.01, 0.502936501),
        (0.05, 0.427684405),
        (0.1, 0.293181580),
        (0.3, 0.062790296),
    ] {
        let found = strip.pressure(&[0.0, 0.07], time);
        assert!((found - expected).abs() < 5.1e-10, "{found} {expected}");
    }
    for (time, expected) in [
        (0.002, -0.042730269),
        (0.03, -0.045509181),
        (0.35, -0.052674662),
    ] {
        let found = strip.plate_displacement(time);
        assert!((found - expected).abs() < 5.1e-10, "{found} {expected}");
        close(strip.displacement(&[0.4, 0.1], time)[1], found, 1e-15);
    }
}

/// Sums of 900 and of 60 terms in 40-digit arithmetic, at ct/a² = 1e-5 and 0.003, y = 1.
#[test]
fn early_times_agree_with_very_long_sums() {
    let strip = strip();
    let table = [
        (
            1e-5,
            0.3,
            0.4798899200866005,
            -0.4185706525199793,
            0.07458289174679249,
        ),
        (
            1e-5,
            0.99,
            0.4677312808488808,
            -0.4185706525199793,
            0.2461178692758422,
        ),
        (
            1e-5,
            0.997,
            0.2388710629973567,
            -0.4185706525199793,
            0.2476706187756015,
        ),
        (
            0.003,
            0.3,
            0.4859830922916079,
            -0.4238852527210135,
            0.07552987226032072,
        ),
        (
            0.003,
            0.99,
            0.05025120619804525,
            -0.4238852527210135,
            0.241646194327369,
        ),
        (
            0.003,
            0.997,
            0.01512411354836057,
            -0.4238852527210135,
            0.2424566925874313,
        ),
    ];
    for (time_factor, x, pressure, upwards, outwards) in table {
        let time = time_factor / strip.consolidation_coefficient();
        close(strip.pressure(&[x, 0.0], time), pressure, 1e-12);
        let moved = strip.displacement(&[x, 1.0], time);
        close(moved[0], outwards, 1e-13);
        close(moved[1], upwards, 1e-13);
    }
}

#[test]
fn the_early_and_the_late_form_agree_where_they_meet() {
    for strip in [strip(), turned()] {
        for step in 0..=20 {
            let x = f64::from(step) / 20.0;
            let early = Profile::early(x, SWITCH, strip.coupling);
            let late = Profile::late(x, SWITCH, strip.coupling, &strip.modes);
            assert!((early.pressure - late.pressure).abs() < 5e-15, "{x}");
            assert!((early.expelled - late.expelled).abs() < 5e-15, "{x}");
        }
    }
}

#[test]
fn roots_satisfy_their_equation_to_rounding_error() {
    for coupling in [1e-9, 0.01, 0.2158, 0.75] {
        for (index, mode) in (0..MODES).map(|n| (n, Mode::new(n, coupling))) {
            let least = index as f64 * PI;
            assert!(least < mode.root && mode.root < least + PI / 2.0);
            // sin A − (A/b) cos A, over its slope, is the error of the root.
            let (sine, cosine) = mode.root.sin_cos();
            let slope = cosine - cosine / coupling + mode.root / coupling * sine;
            let error = (sine - mode.root / coupling * cosine) / slope;
            assert!(error.abs() < 1e-15 * mode.root, "{index}: {error}");
            assert!((mode.cosine - cosine).abs() < 1e-14);
        }
    }
}

/// Mandel–Cryer: the centre pressure rises to 1.054659 p(0⁺) at ct/a² = 0.05796 before it falls.
#[test]
fn the_centre_pressure_rises_first() {
    let strip = strip();
    let relative = |step: u32| {
        let time = f64::from(step) * 1e-5 / strip.consolidation_coefficient();
        strip.pressure(&[0.0, 0.0], time) / strip.undrained_pressure()
    };
    let peak = (1..20_000).max_by(|&a, &b| relative(a).total_cmp(&relative(b)));
    assert_eq!(peak, Some(5796));
    assert!((relative(5796) - 1.054659).abs() < 5.1e-7);
}

#[test]
fn the_plate_stays_plane_and_the_sides_are_drained() {
    let strip = strip();
    for time in [1e-7, 1e-3, 0.006, 0.007, 0.2, 3.0] {
        let plate = strip.plate_displacement(time);
        for x in [-1.0, -0.3, 0.0, 0.8, 1.0] {
            for y in [-0.1, 0.03, 0.1] {
                let moved = strip.displacement(&[x, y], time);
                close(moved[1], plate * y / 0.1, 1e-14);
            }
        }
        for side in [-1.0, 1.0] {
            assert!(strip.pressure(&[side, 0.05], time).abs() < 1e-15);
        }
    }
}

/// ∫₀ᵃ σ dx = −F with σ = (λ+2μ) ε_y + λ ∂u_x/∂x − αp; the integral of ∂u_x/∂x is u_x(a), that of
/// p is taken by the midpoint rule in s, x = a(1−s³), which resolves the drained layer.
#[test]
fn the_plate_carries_the_force_at_all_times() {
    let (strip, steps) = (strip(), 20_000);
    for time in [0.0, 1e-5, 1e-3, 0.0065, 0.0066, 0.05, 0.5, f64::INFINITY] {
        let pressure: f64 = (0..steps)
            .map(|step| {
                let s = (f64::from(step) + 0.5) / f64::from(steps);
                let x = 1.0 - s.powi(3);
                strip.pressure(&[x, 0.0], time) * 3.0 * s * s / f64::from(steps)
            })
            .sum();
        let moved = strip.displacement(&[1.0, 1.0], time);
        let force = 2.0 * moved[1] + 0.5 * moved[0] - 0.6 * pressure;
        assert!((force + 1.0).abs() < 1e-8, "{time}: {force}");
    }
}

/// σ_xx = (λ+2μ) ∂u_x/∂x + λ ∂u_y/∂y − αp = 0 and S ∂p/∂t + α ∂(div u)/∂t = κ ∂²p/∂x², in the
/// turned strip (its x is the second axis), on both sides of the switch.
#[test]
fn it_satisfies_equilibrium_and_the_balance_of_fluid() {
    let strip = turned();
    let p = |x: f64, t: f64| strip.pressure(&[-0.7, 3.0 + x], t);
    let u = |x: f64, t: f64| strip.displacement(&[0.0, 3.0 + x], t);
    let h = 2e-3;
    let across = |x: f64, t: f64| (u(x + h, t)[1] - u(x - h, t)[1]) / (2.0 * h);
    let volume = |x: f64, t: f64| across(x, t) + u(x, t)[0];
    let scale = 2.5 * 2.5 / strip.consolidation_coefficient();
    for (x, factor) in [
        (0.0, 0.2),
        (1.0, 0.01),
        (2.2, 0.004),
        (1.7, 0.05),
        (-1.0, 0.6),
    ] {
        let (t, dt) = (factor * scale, 1e-3 * factor * scale);
        let stress = 16e9 * across(x, t) + 4e9 * u(x, t)[0];
        close(stress, 0.8 * p(x, t), 1e-5);
        let rate = |f: &dyn Fn(f64) -> f64| (f(t + dt) - f(t - dt)) / (2.0 * dt);
        let storing = 7e-11 * rate(&|t| p(x, t)) + 0.8 * rate(&|t| volume(x, t));
        let flowing = 2e-10 * (p(x + h, t) + p(x - h, t) - 2.0 * p(x, t)) / (h * h);
        close(storing, flowing, 1e-4);
    }
}

#[test]
fn it_starts_undrained_and_ends_drained() {
    for strip in [strip(), turned()] {
        let MandelParameters {
            half_width,
            height,
            origin,
            drained_axis,
            force,
            shear_modulus,
            ..
        } = strip.parameters().clone();
        let mut corner = origin;
        corner[drained_axis] += half_width;
        corner[1 - drained_axis] += height;
        let unit = force / (2.0 * shear_modulus);
        let states = [
            (
                -1.0,
                strip.undrained_poisson_ratio(),
                strip.undrained_pressure(),
            ),
            (
                0.0,
                strip.undrained_poisson_ratio(),
                strip.undrained_pressure(),
            ),
            (f64::INFINITY, strip.poisson_ratio(), 0.0),
        ];
        for (time, ratio, pressure) in states {
            close(strip.pressure(&corner, time), pressure, 1e-14);
            let moved = strip.displacement(&corner, time);
            close(moved[drained_axis], unit * ratio, 1e-13);
            let loaded = -unit * (1.0 - ratio) * height / half_width;
            close(moved[1 - drained_axis], loaded, 1e-13);
            close(strip.plate_displacement(time), loaded, 1e-13);
        }
    }
}

/// ν_u from K_u and μ, B = α/(S K_u), and the diffusivity in terms of ν and ν_u.
#[test]
fn the_undrained_constants_follow_from_the_moduli() {
    let strip = turned();
    let (drained, undrained) = (strip.poisson_ratio(), strip.undrained_poisson_ratio());
    let bulk = 4e9 + 2.0 / 3.0 * 6e9 + 0.64 / 7e-11;
    close(
        undrained,
        (3.0 * bulk - 12e9) / (2.0 * (3.0 * bulk + 6e9)),
        1e-14,
    );
    close(strip.skempton_coefficient(), 0.8 / (7e-11 * bulk), 1e-14);
    close(
        strip.coupling,
        (undrained - drained) / (1.0 - drained),
        1e-13,
    );
    // c = 2κB²μ(1−ν)(1+ν_u)²/(9(1−ν_u)(ν_u−ν)), E. Detournay and A. H.-D. Cheng, 1993.
    let c = 2.0
        * 2e-10
        * strip.skempton_coefficient().powi(2)
        * 6e9
        * (1.0 - drained)
        * (1.0 + undrained).powi(2)
        / (9.0 * (1.0 - undrained) * (undrained - drained));
    close(strip.consolidation_coefficient(), c, 1e-13);
}

#[test]
fn positions_decide_the_shape() {
    let strip = strip();
    for time in [0.0, 1e-3, 1.0] {
        let plane = strip.displacement(&[0.4, 0.05], time);
        let space = strip.displacement(&[0.4, 0.05, 8.0], time);
        assert_eq!(space[..2], plane[..]);
        assert!(space.len() == 3 && space[2].abs() < f64::MIN_POSITIVE);
        assert!(strip.displacement(&[0.4], time)[0].is_nan());
        assert!(strip.pressure(&[], time).is_nan());
    }
}

#[test]
fn impossible_parameters_are_named() {
    let refusal = |change: &dyn Fn(&mut MandelParameters)| {
        let mut parameters = parameters();
        change(&mut parameters);
        Mandel::new(parameters).unwrap_err().to_string()
    };
    assert!(refusal(&|p| p.drained_axis = 2).contains("drained axis"));
    assert!(refusal(&|p| p.lame_lambda = -0.5).contains("bulk modulus"));
    assert!(refusal(&|p| p.biot_coefficient = 0.0).contains("Biot"));
    assert!(refusal(&|p| p.height = 0.0).contains("height"));
    assert!(refusal(&|p| p.force = f64::INFINITY).contains("force"));
    assert!(refusal(&|p| p.origin[1] = f64::NAN).contains("second"));
}
