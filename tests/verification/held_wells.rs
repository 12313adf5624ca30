//! Wells whose bottom-hole pressure is known: their index against exact solutions, limits, balances.

use std::f64::consts::PI;

use perifrac::model::Control;
use perifrac::reference::{ExactPressure, FiveSpot, InjectorCorner};
use perifrac::run::{Summary, examine};

use crate::support::{model, plan, plan_of, plan_of_variant, run_case, run_text, try_run};

/// A well at 1 Pa in a unit square whose sides are at 0.
const SQUARE: &str = r#"
title = "A well in a square"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [40, 40], seed = 5 }
fluid.viscosity = "1 Pa s"
materials.rock = { permeability = "1 m^2", storage = "1 1/Pa" }
time = { mode = "steady" }
[flow]
boundary.left.pressure = 0
boundary.right.pressure = 0
boundary.top.pressure = 0
boundary.bottom.pressure = 0
[wells.w]
at = [0.4637, 0.5311]
pressure = 1
wellbore_radius = "0.1 mm"
"#;

const PLACE: [f64; 2] = [0.4637, 0.5311];
const HOLE: f64 = 1e-4;

/// Potential at (x, y) of a unit source at (a, b) in a rectangle of the given width and height whose sides are at zero: that of
/// a strip in closed form (Morse and Feshbach, sec. 10.1), with images across the two other sides.
fn green([x, y]: [f64; 2], [a, b]: [f64; 2], [width, height]: [f64; 2]) -> f64 {
    let square = |t: f64| t * t;
    let strip = |dy: f64| {
        let sinh = square((0.5 * PI * dy / width).sinh());
        let sine = |dx: f64| square((0.5 * PI * dx / width).sin());
        ((sinh + sine(x + a)) / (sinh + sine(x - a))).ln() / (4.0 * PI)
    };
    let pair = |k: i32| {
        let shift = 2.0 * height * f64::from(k);
        strip(y - b - shift) - strip(y + b - shift)
    };
    (-10..=10).map(pair).sum()
}

/// Pressure per rate at the rim of a hole: the mean over four places, whose linear part cancels.
fn resistance(well: [f64; 2], size: [f64; 2], hole: f64) -> f64 {
    let rim = [[hole, 0.0], [0.0, hole], [-hole, 0.0], [0.0, -hole]];
    let at = |arm: &[f64; 2]| green([well[0] + arm[0], well[1] + arm[1]], well, size);
    0.25 * rim.iter().map(at).sum::<f64>()
}

fn rate(summary: &Summary, well: &str) -> f64 {
    summary.wells[well].rate
}

fn points(count: usize) -> String {
    format!("geometry.points=[{count}, {count}]")
}

/// Relative errors of the rate in the square at two spacings.
fn errors(sets: &[&str]) -> [f64; 2] {
    let exact = 1.0 / resistance(PLACE, [1.0, 1.0], HOLE);
    [20, 40].map(|count| {
        let count = points(count);
        let all: Vec<&str> = sets.iter().copied().chain([&*count]).collect();
        let (summary, _) = run_text(SQUARE, &all);
        assert!(summary.balance.mass < 1e-12, "{all:?}");
        (rate(&summary, "w") / exact - 1.0).abs()
    })
}

#[test]
fn green_function_of_a_square_is_zero_on_its_sides_and_symmetric() {
    let size = [1.0, 1.5];
    for side in [[0.0, 0.3], [1.0, 0.8], [0.2, 0.0], [0.7, 1.5]] {
        assert!(green(side, [0.4, 0.6], size).abs() < 1e-12);
    }
    let [one, other] = [[0.3, 0.2], [0.8, 1.1]];
    let turned = green([0.2, 0.3], [1.1, 0.8], [1.5, 1.0]);
    assert!((green(one, other, size) - green(other, one, size)).abs() < 1e-13);
    assert!((green(one, other, size) - turned).abs() < 1e-13);
}

#[test]
fn the_rate_between_points_of_a_lattice_is_exact() {
    for operator in ["path", "correspondence", "bond"] {
        let found = errors(&[&format!("flow.operator={operator}")]);
        assert!(found[0] < 1e-5 && found[1] < 3e-6, "{operator}: {found:?}");
    }
}

/// Beside one side, two sides, on one that is sealed, and in the middle between points.
#[test]
fn the_rate_beside_sides_is_exact() {
    for (place, size, sealed) in [
        ([0.0731, 0.4], 1.0, false),
        ([0.11, 0.09], 1.0, false),
        ([0.5, 0.5], 1.0, false),
        ([0.0, 0.55], 2.0, true),
    ] {
        let at = format!("wells.w.at=[{}, {}]", place[0], place[1]);
        let text = match sealed {
            true => SQUARE.replace("boundary.left.pressure = 0", "boundary.left.sealed = true"),
            false => SQUARE.to_owned(),
        };
        // A sealed side is the middle of a rectangle twice as wide.
        let well = [place[0] + size - 1.0, place[1]];
        let exact = 1.0 / resistance(well, [size, 1.0], HOLE);
        for operator in ["path", "correspondence"] {
            let (summary, _) = run_text(&text, &[&at, &format!("flow.operator={operator}")]);
            let off = (rate(&summary, "w") / exact - 1.0).abs();
            assert!(off < 2e-6, "{place:?} {operator}: {off:.2e}");
        }
    }
}

#[test]
fn the_rate_on_a_jittered_cloud_is_good() {
    for operator in ["path", "correspondence", "bond"] {
        let found = errors(&[&format!("flow.operator={operator}"), "geometry.jitter=0.2"]);
        // The bond operator conducts otherwise on jittered clouds, in the whole square.
        let most = if operator == "bond" { 5e-3 } else { 2e-4 };
        assert!(found.iter().all(|e| *e < most), "{operator}: {found:?}");
    }
}

#[test]
fn the_rate_of_a_five_spot_between_pressures() {
    for operator in ["path", "correspondence"] {
        let found = [20, 40].map(|count| {
            let sets = [
                points(count),
                format!("flow.operator={operator}"),
                "time.mode=steady".to_owned(),
                "wells={injector = {at = [0, 0], pressure = 3e6, wellbore_radius = 1e-3}, \
                 producer = {at = [1, 1], pressure = 1e6, wellbore_radius = 1e-3}}"
                    .to_owned(),
            ];
            let text = perifrac::cases::find("five-spot").unwrap().scene;
            let text: String =
                text.split("# Rates are").next().unwrap().to_owned() + "[time]\nend = 1\n";
            let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
            let (summary, _) = run_text(&text, &sets);
            // Pressure at the rim per unit of Qμ/2πk.
            let spot = FiveSpot::new(1.0, [0.0, 0.0], 1.0, InjectorCorner::LowerLeft).unwrap();
            let rim = spot.pressure(&[1e-3, 0.0], 0.0) - spot.pressure(&[1.0 - 1e-3, 1.0], 0.0);
            let exact = 2e6 / rim * 2.0 * PI * 1e-10;
            assert!((rate(&summary, "injector") / rate(&summary, "producer") + 1.0).abs() < 1e-9);
            assert!(summary.balance.mass < 1e-10, "{}", summary.balance.mass);
            (rate(&summary, "injector") / exact - 1.0).abs()
        });
        assert!(found[0] < 1e-5 && found[1] < 3e-6, "{operator}: {found:?}");
    }
}

/// Rock that conducts four times as well along x as along y is isotropic where x is shrunk and y stretched by √2.
#[test]
fn the_rate_with_a_tensor_is_exact() {
    let found = [20, 40].map(|count| {
        let tensor = "materials.rock.permeability={xx = 4, yy = 1, xy = 0}";
        let (summary, _) = run_text(SQUARE, &[tensor, &points(count)]);
        let stretch = 2.0_f64.sqrt();
        let hole = 0.5 * HOLE * (stretch + 1.0 / stretch);
        let place = [PLACE[0] / stretch, PLACE[1] * stretch];
        let exact = 2.0 / resistance(place, [1.0 / stretch, stretch], hole);
        (rate(&summary, "w") / exact - 1.0).abs()
    });
    // The source is round where it should be an ellipse.
    assert!(found[0] < 7e-4 && found[1] < 0.5 * found[0], "{found:?}");
}

/// The regular part of the potential at the centre of a cube with sides at zero is Madelung's constant over 4π.
#[test]
fn the_rate_of_a_cavity_in_a_cube() {
    const MADELUNG: f64 = 1.747_564_594_633_182;
    for operator in ["path", "correspondence"] {
        let found = [12, 20].map(|count| {
            let all = format!("geometry.points=[{count}, {count}, {count}]");
            let sides = "boundary.bottom.pressure = 0";
            let text = SQUARE.replace(
                sides,
                &format!("{sides}\nboundary.front.pressure = 0\nboundary.back.pressure = 0"),
            );
            let text = text.replace("[0.4637, 0.5311]", "[0.5, 0.5, 0.5]");
            let text = text.replace("[\"1 m\", \"1 m\"]", "[1, 1, 1]");
            let hole = 0.01;
            let (summary, _) = run_text(
                &text,
                &[
                    &all,
                    "wells.w.wellbore_radius=0.01",
                    "wells.w.skin=0.5",
                    &format!("flow.operator={operator}"),
                ],
            );
            let exact = 4.0 * PI / (1.5 / hole - MADELUNG);
            (rate(&summary, "w") / exact - 1.0).abs()
        });
        assert!(found[0] < 2e-5 && found[1] < 1e-6, "{operator}: {found:?}");
    }
}

/// A producer that reaches its lowest pressure, and one beside it that does not.
const LIMITED: &str = r#"
title = "Producers"
geometry = { type = "lattice", size = ["100 m", "100 m"], points = [25, 25] }
fluid.viscosity = "1 mPa s"
materials.rock = { permeability = "1e-13 m^2", storage = "1e-9 1/Pa" }
flow = { initial_pressure = "20 MPa" }
[wells.weak]
at = ["30 m", "31 m"]
rate = { time = [0, "20 h", "21 h"], value = ["-2e-4 m^2/s", "-2e-4 m^2/s", 0] }
wellbore_radius = "10 cm"
pressure_min = "18.2 MPa"
[wells.strong]
at = ["70 m", "60 m"]
rate = "-1e-5 m^2/s"
wellbore_radius = "10 cm"
pressure_min = "1 MPa"
[time]
end = "30 h"
"#;

#[test]
fn a_limit_is_kept_mass_is_conserved_and_the_rate_comes_back() {
    for sets in [
        &["time.integrator=backward-euler"][..],
        &["time.integrator=tr-bdf2"],
        &["time.integrator=backward-euler", "time.step=600"],
        &["scheme.name=explicit"],
    ] {
        let (summary, state) = run_text(LIMITED, sets);
        assert!(summary.balance.mass < 1e-12, "{}", summary.balance.mass);
        let weak = &summary.wells["weak"];
        assert_eq!(weak.switches, 2, "to the limit and back: {sets:?}");
        assert_eq!(state.wells[1].switches, 0);
        assert_eq!(state.wells[0].control, Control::Given);
        // Shut in: the bottom is at the mean of the rock beside it, above the limit.
        assert!(weak.rate.abs() <= 0.0 && weak.pressure > 18.2e6);
    }
}

#[test]
fn at_the_limit_the_rate_is_less_than_asked_for() {
    let (summary, _) = run_text(LIMITED, &["time.end=10 h"]);
    let weak = &summary.wells["weak"];
    assert_eq!((&*weak.control, weak.switches), ("pressure-min", 1));
    assert!((weak.pressure / 18.2e6 - 1.0).abs() < 1e-15);
    assert!(weak.rate < 0.0 && weak.rate > -2e-4, "{weak:?}");
    assert_eq!(&*summary.wells["strong"].control, "given");
}

/// A well whose rate is limited follows the same course as one whose pressure is, the other way round.
#[test]
fn a_pressure_well_starts_at_its_largest_rate() {
    let pressure = [
        "wells={weak = {at = [30, 31], pressure = 18.2e6, rate_max = 2e-4, wellbore_radius = 0.1}, \
         strong = {at = [70, 60], rate = -1e-5, wellbore_radius = 0.1, pressure_min = 1e6}}",
        "time.end=10 h",
    ];
    let [(one, first), (other, second)] =
        [&["time.end=10 h"][..], &pressure].map(|sets| run_text(LIMITED, sets));
    assert_eq!(&*other.wells["weak"].control, "given");
    assert_eq!(other.wells["weak"].switches, 1);
    let pairs = first.pressure.iter().zip(&second.pressure);
    assert!(pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max) < 1e-12);
    assert!((rate(&one, "weak") / rate(&other, "weak") - 1.0).abs() < 1e-9);
}

/// The rock around falls below the limit of a producer: it is shut, and takes nothing back.
#[test]
fn a_producer_never_takes_in() {
    let sets = [
        "wells.strong.rate=-3e-4 m^2/s",
        "wells.strong.pressure_min=2 MPa",
        "wells.weak.rate=-2e-4 m^2/s",
        "time.end=400 h",
    ];
    let (summary, _) = run_text(LIMITED, &sets);
    let weak = &summary.wells["weak"];
    assert_eq!(&*weak.control, "shut");
    assert!(weak.rate.abs() <= 0.0 && weak.pressure < 18.2e6);
    assert!(summary.balance.mass < 1e-12);
}

#[test]
fn the_order_of_wells_and_their_keys_changes_nothing() {
    let (one, _) = run_text(LIMITED, &["time.end=10 h"]);
    let (head, wells) = LIMITED.split_at(LIMITED.find("[wells.weak]").unwrap());
    let (weak, rest) = wells.split_at(wells.find("[wells.strong]").unwrap());
    let (strong, time) = rest.split_at(rest.find("[time]").unwrap());
    let mut weak: Vec<&str> = weak.lines().collect();
    weak[1..].reverse();
    let text = format!("{head}{strong}{}\n{time}", weak.join("\n"));
    let (other, _) = run_text(&text, &["time.end=10 h"]);
    for name in ["weak", "strong"] {
        let (a, b) = (&one.wells[name], &other.wells[name]);
        assert_eq!(a.control, b.control);
        assert!((a.rate / b.rate - 1.0).abs() < 1e-11);
        assert!((a.pressure / b.pressure - 1.0).abs() < 1e-13);
    }
}

#[test]
fn a_well_shut_in_is_at_the_pressure_of_the_rock_and_one_with_a_huge_skin_moves_nothing() {
    let shut = [
        "wells.weak.rate=0",
        "wells.strong.rate=-1e-40",
        "time.end=1 h",
    ];
    let text = LIMITED.replace("pressure_min = \"18.2 MPa\"\n", "");
    let (summary, state) = run_text(&text, &shut);
    assert!(
        state
            .pressure
            .iter()
            .all(|p| (p / 20e6 - 1.0).abs() < 1e-14)
    );
    assert!((summary.wells["weak"].pressure / 20e6 - 1.0).abs() < 1e-14);
    let (plain, _) = run_text(SQUARE, &[]);
    let (tight, _) = run_text(SQUARE, &["wells.w.skin=1e12"]);
    let exact = 2.0 * PI / (2.0 * PI * resistance(PLACE, [1.0, 1.0], HOLE) + 1e12);
    assert!((rate(&tight, "w") / exact - 1.0).abs() < 1e-9);
    assert!(rate(&plain, "w") > 0.5);
}

#[test]
fn skin_adds_to_the_resistance_and_a_hole_that_is_too_wide_is_refused() {
    let [plain, skin] = [&[][..], &["wells.w.skin=4"]].map(|sets| {
        let (summary, _) = run_text(SQUARE, sets);
        1.0 / rate(&summary, "w")
    });
    assert!((2.0 * PI * (skin - plain) / 4.0 - 1.0).abs() < 1e-10);
    let wide = plan_of(SQUARE, &["wells.w.wellbore_radius=0.1"]);
    let told = try_run(&wide).unwrap_err().to_string();
    assert!(told.contains("set a smaller wellbore_radius"), "{told}");
    assert_eq!(examine(&wide, 1).unwrap_err().to_string(), told);
    let near = plan_of(SQUARE, &["geometry.points=[6, 6]", "wells.w.at=[0.5, 0.5]"]);
    let told = try_run(&near).unwrap_err().to_string();
    assert!(told.contains("sides are too near to each other"), "{told}");
    let on = plan_of(SQUARE, &["wells.w.at=[0, 0.5]"]);
    let told = try_run(&on).unwrap_err().to_string();
    assert!(
        told.contains("stands on a side that is not sealed"),
        "{told}"
    );
}

/// The term of a well is of no M-matrix, and large where the hole is nearly as wide as the points tell.
#[test]
fn every_kind_of_solver_finds_the_same_rate() {
    for hole in [
        "wells.w.wellbore_radius=1e-4",
        "wells.w.wellbore_radius=0.0258",
    ] {
        let solvers = ["faer-llt", "faer-cg:preconditioner=amg", "faer-cg", "gmres"];
        let rates = solvers.map(|name| {
            let (summary, _) = run_text(SQUARE, &[hole, &format!("solver.name={name}")]);
            assert!(
                summary.balance.mass < 1e-11,
                "{name}: {}",
                summary.balance.mass
            );
            rate(&summary, "w")
        });
        assert!(
            rates.iter().all(|own| (own / rates[0] - 1.0).abs() < 1e-9),
            "{rates:?}"
        );
    }
    let told = try_run(&plan_of(SQUARE, &["solver.name=fourier"])).unwrap_err();
    assert!(
        told.to_string().contains("here a well holds a pressure"),
        "{told}"
    );
}

/// Rock that deforms, between rollers, with a producer at a pressure and an injector with a limit.
const COUPLED: &str = r#"
title = "Wells in rock that deforms"
geometry = { type = "lattice", size = ["20 m", "20 m"], points = [20, 20] }
fluid.viscosity = "1 mPa s"
flow = { suction = true }
coupling = {}
[materials.rock]
permeability = "1e-14 m^2"
storage = "1e-10 1/Pa"
youngs_modulus = "10 GPa"
poissons_ratio = 0.2
biot_coefficient = 0.8
[mechanics]
boundary = { left.normal_displacement = 0, right.normal_displacement = 0, bottom.normal_displacement = 0, top.normal_displacement = 0 }
[wells.out]
at = ["6 m", "6 m"]
pressure = "-1 MPa"
wellbore_radius = "5 cm"
[wells.in]
at = ["14 m", "14 m"]
rate = "1e-5 m^2/s"
pressure_max = "0.8 MPa"
wellbore_radius = "5 cm"
[time]
end = "2 h"
"#;

#[test]
fn every_scheme_holds_wells_at_their_pressures() {
    let schemes = [
        "scheme.name=monolithic",
        "scheme.name=staggered",
        "scheme.name=semi-implicit",
        "scheme.name=explicit",
    ];
    let found = schemes.map(|scheme| {
        let (summary, _) = run_text(COUPLED, &[scheme]);
        // Where strain lags fluid is owed.
        let most = if scheme.ends_with("plicit") {
            1e-2
        } else {
            1e-9
        };
        assert!(
            summary.balance.mass < most,
            "{scheme}: {}",
            summary.balance.mass
        );
        summary.wells
    });
    for own in &found[1..] {
        for name in ["in", "out"] {
            let (a, b) = (&found[0][name], &own[name]);
            assert_eq!(a.control, b.control);
            assert!((a.rate / b.rate - 1.0).abs() < 1e-2, "{name}: {a:?} {b:?}");
        }
    }
}

#[test]
fn what_a_scene_without_such_wells_does_not_name_is_not_there() {
    let (without, state) = run_case("theis", &["geometry.points=[20, 20]", "output.times=[]"]);
    assert!(state.wells.is_empty() && without.wells.is_empty());
    assert_eq!(without.counters.evaluations("held-wells"), 0);
    assert!(!without.counters.bytes.contains_key("wells"));
    let known = [
        "geometry.points=[20, 20]",
        "output.times=[]",
        "wells.well.wellbore_radius=1e-3",
    ];
    let (known, other) = run_case("theis", &known);
    // To know the pressure at the bottom changes nothing of the run.
    assert_eq!(state.pressure, other.pressure);
    assert_eq!(known.nonzeros, without.nonzeros);
    assert_eq!(known.counters.evaluations("held-wells"), 0);
    assert!(known.counters.bytes["wells"] > 0);
    let plan = plan(
        "theis",
        &[
            "wells.well.wellbore_radius=1e-3",
            "wells.well.pressure_max=1e9",
        ],
    );
    let held = model::<2>(&plan).flow.unwrap();
    assert!(held.wells.evaluations().is_some());
}

/// Ten hours of production at a constant rate and ten of rest, against superposed solutions of Theis: what is left is of second order.
#[test]
fn a_well_test_follows_theis_and_its_superposition() {
    let [coarse, fine] = ["geometry.points=[50, 50]", "geometry.points=[100, 100]"].map(|set| {
        let (summary, _) = run_case("well-test", &[set]);
        assert!(summary.balance.mass < 1e-12);
        let errors = summary.errors_over_time.iter();
        errors
            .map(|at| (at.time, at.errors["well_pressure"].max))
            .collect::<Vec<_>>()
    });
    assert_eq!(coarse.len(), 8);
    for ((time, coarse), (_, fine)) in coarse.iter().zip(&fine) {
        assert!(coarse / fine > 3.5, "{time}: {coarse:.2e} {fine:.2e}");
    }
    let at = |wanted: f64| fine.iter().find(|(time, _)| *time >= wanted).unwrap().1;
    assert!(
        at(1800.0) < 2e-3 && at(36_000.0) < 1e-4 && at(72_000.0) < 5e-5,
        "{fine:?}"
    );
}

/// Errors are told up to the time at which a limit is met, which no exact solution knows of.
#[test]
fn a_limited_well_is_compared_up_to_its_limit() {
    let plan = plan_of_variant("well-test", "limited", &["geometry.points=[30, 30]"]);
    let (summary, _) = try_run(&plan).unwrap();
    let times: Vec<f64> = summary.errors_over_time.iter().map(|at| at.time).collect();
    assert_eq!(times, [1800.0, 3600.0]);
    assert_eq!(summary.wells["well"].switches, 2);
    assert!(summary.errors.is_empty());
}
