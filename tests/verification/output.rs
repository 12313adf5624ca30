//! What is reported beside the fields: values between points, velocities, openings, and figures of a slab.

use std::path::Path;

use perifrac::geometry::{Stencils, Vector};
use perifrac::output::{History, Table};
use perifrac::plan::{CrackPlace, Plan};
use perifrac::run::{Interrupt, Summary, Writer, openings, run};
use perifrac::schemes::State;

use crate::support::{flow_model, model, plan, plan_of, run_text, try_run};

/// A plane between two pressures, or in space with `SPACE`.
const BETWEEN: &str = r#"title = "Between two pressures"
[geometry]
type = "lattice"
size = [1, 0.5]
points = [20, 10]
[fluid]
viscosity = 1
[materials.rock]
permeability = 1
storage = 1
[flow.boundary]
left = { pressure = 3 }
right = { pressure = 1 }
[time]
mode = "steady"
"#;

const SPACE: [&str; 2] = ["geometry.size=[1, 0.5, 0.5]", "geometry.points=[10, 5, 5]"];

/// Runs a plan into a folder; gives its history too.
fn write(plan: &Plan, folder: &Path) -> (Summary, Table) {
    let mut writer = Writer::create(folder, "").unwrap();
    let ran = run(plan, Some(&mut writer), &mut (), &Interrupt::default());
    let (summary, _) = ran.unwrap_or_else(|error| panic!("{error}"));
    (summary, History::read(folder.join("history.csv")).unwrap())
}

fn last(table: &Table, column: &str) -> f64 {
    let values = table.column(column);
    *values
        .unwrap_or_else(|| panic!("no {column} in {:?}", table.columns))
        .last()
        .unwrap()
}

/// Largest error of the linear pressure between the walls at places all over the domain.
fn linear_error<const D: usize>(overrides: &[&str]) -> f64 {
    let flow = flow_model::<D>(&plan_of(BETWEEN, overrides));
    let around = flow.operator.neighbourhood();
    let (cloud, horizon) = (&around.cloud, &around.families.horizon);
    let pressure: Vec<f64> = cloud.position.iter().map(|x| 3.0 - 2.0 * x[0]).collect();
    let stencils = Stencils::new(cloud, horizon, |_| None).unwrap();
    let places: Vec<_> = (0..300)
        .map(|k| {
            let share =
                |axis: usize| (f64::from(k) * [0.7548777, 0.5698403, 0.3247180][axis]).fract();
            stencils.at(Vector::from_fn(|axis, _| {
                cloud.domain.size()[axis] * share(axis)
            }))
        })
        .chain([
            stencils.at(cloud.domain.lower),
            stencils.at(cloud.domain.upper),
        ])
        .collect();
    let found = flow.pressures_at(&pressure, 0.0, &places);
    let error = |(place, found): (&perifrac::geometry::Stencil<D>, &f64)| {
        (found - (3.0 - 2.0 * place.at[0])).abs()
    };
    places.iter().zip(&found).map(error).fold(0.0, f64::max)
}

#[test]
fn a_linear_pressure_is_exact_between_points_of_any_cloud() {
    let jitter = "geometry.jitter=0.35";
    for operator in ["path", "bond", "correspondence"] {
        let operator = &*format!("flow.operator={operator}");
        assert!(linear_error::<2>(&[operator]) < 1e-12, "{operator}");
        assert!(
            linear_error::<3>(&[&SPACE[..], &[operator]].concat()) < 1e-12,
            "{operator}"
        );
    }
    for overrides in [vec![jitter], [&SPACE[..], &[jitter]].concat()] {
        let error = match overrides.len() {
            1 => linear_error::<2>(&overrides),
            _ => linear_error::<3>(&overrides),
        };
        assert!(error < 1e-11, "{overrides:?}: {error}");
    }
}

/// A pressure that jumps from the walls' to another value is followed without jumps or overshoot.
#[test]
fn values_between_points_are_continuous_and_bounded_next_to_walls() {
    for overrides in [&["geometry.jitter=0.3"][..], &[]] {
        let flow = flow_model::<2>(&plan_of(BETWEEN, overrides));
        let around = flow.operator.neighbourhood();
        let pressure = vec![10.0; flow.points()];
        let stencils = Stencils::new(&around.cloud, &around.families.horizon, |_| None).unwrap();
        let place = |k: usize| stencils.at(Vector::<2>::new(k as f64 / 4000.0, 0.237));
        let places: Vec<_> = (0..=4000).map(place).collect();
        let found = flow.pressures_at(&pressure, 0.0, &places);
        assert!((found[0] - 3.0).abs() < 1e-9 && (found[4000] - 1.0).abs() < 1e-9);
        let steepest = found.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        // Rows are 200 places apart.
        let steepest = steepest.fold(0.0, f64::max);
        assert!(steepest < 0.02 * 9.0 * 2.5, "{steepest}");
        let beyond = found
            .iter()
            .map(|p| (p - 10.0).max(1.0 - p))
            .fold(0.0, f64::max);
        // Cells that touch see the jump within half a cell: 0.31 of it; families of 20 points 0.2.
        assert!(beyond < 0.33 * 9.0, "{beyond}");
    }
}

/// Flow through two layers, from either side, with either operator: what a row of cells lets through is
/// what the side lets out, also beside the interface.
#[test]
fn the_velocity_across_an_interface_is_continuous() {
    for (left, operator) in [
        ("1e4", "path"),
        ("1e-4", "path"),
        ("1e4", "bond"),
        ("1e-4", "bond"),
        ("1e4", "correspondence"),
        ("1e-4", "correspondence"),
    ] {
        let overrides = [
            &format!("materials.left.permeability={left}"),
            &format!("flow.operator={operator}"),
            "time.mode=steady",
            "output.times=[]",
        ];
        let plan = plan("two-layer", &overrides);
        let (summary, state) = try_run(&plan).unwrap();
        let out = summary.outflow["right"] / 0.25;
        for velocity in flow_model::<2>(&plan).velocity(&state.pressure, 0.0) {
            let error = (velocity[0] / out - 1.0).abs();
            assert!(error < 1e-3, "{left} {operator}: {} for {out}", velocity[0]);
            assert!(velocity[1].abs() < 1e-6 * out);
        }
    }
}

/// Flow along two layers: each has its own velocity from some horizons off the interface on.
#[test]
fn the_velocity_along_an_interface_is_that_of_each_layer_away_from_it() {
    let overrides = [
        "geometry.size=[1, 1]",
        "geometry.points=[30, 30]",
        "materials.left.region={type=\"half-plane\", point=[0, 0.5], normal=[0, 1]}",
        "materials.left.permeability=1e4",
        "time.mode=steady",
        "output.times=[]",
    ];
    let text = perifrac::cases::find("two-layer").unwrap().scene;
    let text = text.replace("[reference]\ntype = \"two-layer\"", "");
    for operator in ["flow.operator=bond", "flow.operator=correspondence"] {
        let plan = plan_of(&text, &[&overrides[..], &[operator]].concat());
        let (_, state) = try_run(&plan).unwrap();
        let model = model::<2>(&plan);
        let velocity = model.flow.as_ref().unwrap().velocity(&state.pressure, 0.0);
        for (x, velocity) in model.cloud.position.iter().zip(velocity) {
            let exact = if x[1] < 0.5 { 1e4 } else { 1.0 };
            if (x[1] - 0.5).abs() > 0.25 {
                let error = (velocity[0] / exact - 1.0).abs();
                assert!(error < 1e-6, "{operator} {x}: {velocity}");
            }
        }
    }
}

#[test]
fn a_region_held_at_a_pressure_has_its_rate() {
    let text = BETWEEN.replace("mode = \"steady\"", "end = 1");
    let region = "flow.regions=[{region={type=\"box\", min=[0.4, 0], max=[0.6, 0.5]}, pressure=9}, \
                  {region={type=\"box\", min=[0.9, 0], max=[1, 0.5]}, pressure=2}]";
    let folder = tempfile::tempdir().unwrap();
    for scheme in ["implicit", "explicit"] {
        let scheme = format!("scheme.name={scheme}");
        let plan = plan_of(&text, &[region, &scheme, "output.plots=false"]);
        let (summary, table) = write(&plan, folder.path());
        let columns = ["outflow_region_1_m3_per_s", "outflow_region_2_m3_per_s"];
        let dt = table.column("step_s").unwrap();
        let out = columns.map(|column| {
            let rates = table.column(column).unwrap();
            rates
                .iter()
                .zip(&dt)
                .map(|(rate, dt)| rate * dt)
                .sum::<f64>()
        });
        let brought = -out[0] - out[1];
        assert!(
            (brought / summary.balance.fixed - 1.0).abs() < 1e-9,
            "{scheme}: {out:?}"
        );
        assert_eq!(last(&table, "fixed_m3"), summary.balance.fixed);
        // In the end the region feeds the wall and the other region; its outermost points are 0.425 and
        // 0.35 from theirs.
        let rates = columns.map(|column| last(&table, column));
        let exact = -0.5 * (6.0 / 0.425 + 7.0 / 0.35);
        assert!((rates[0] / exact - 1.0).abs() < 0.05, "{rates:?} {exact}");
    }
}

#[test]
fn the_rate_of_a_held_region_stands_in_a_steady_state_too() {
    let region = "flow.regions=[{region={type=\"box\", min=[0.4, 0], max=[0.6, 0.5]}, pressure=9}]";
    let plan = plan_of(BETWEEN, &[region, "output.plots=false"]);
    let folder = tempfile::tempdir().unwrap();
    let (summary, table) = write(&plan, folder.path());
    let rate = last(&table, "outflow_region_1_m3_per_s");
    assert!(
        (rate + summary.balance.outflow).abs() < 1e-9 * rate.abs(),
        "{rate}"
    );
    assert_eq!(last(&table, "fixed_m3_per_s"), -rate);
}

/// A slab 0.2 m thick: what is typed for all of it is shared out, what is reported is for all of it, and
/// pressure and velocity are the same.
#[test]
fn figures_of_a_plane_are_those_of_a_slab_of_its_thickness() {
    let text = BETWEEN.replace("mode = \"steady\"", "end = 0.1\nstep = 0.01");
    let folder = tempfile::tempdir().unwrap();
    let run = |overrides: &[&str]| {
        let plan = plan_of(&text, &[overrides, &["output.plots=false"]].concat());
        write(&plan, folder.path())
    };
    let (one, first) = run(&["wells.in={at=[0.5, 0.25], rate=\"4 m^2/s\"}"]);
    for well in [
        "wells.in={at=[0.5, 0.25], rate=\"4 m^2/s\"}",
        "wells.in={at=[0.5, 0.25], rate=\"0.8 m^3/s\"}",
        "wells.in={at=[0.5, 0.25], rate=0.8}",
    ] {
        let (slab, table) = run(&[well, "geometry.thickness=\"20 cm\""]);
        assert_eq!(slab.thickness, Some(0.2));
        assert!(
            (slab.pressure_range.unwrap()[1] / one.pressure_range.unwrap()[1] - 1.0).abs() < 1e-12
        );
        let pairs = [
            (slab.balance.injected, one.balance.injected),
            (slab.outflow["right"], one.outflow["right"]),
            (slab.balance.stored, one.balance.stored),
            (last(&table, "injected_m3"), last(&first, "injected_m3")),
            (
                last(&table, "outflow_left_m3_per_s"),
                last(&first, "outflow_left_m3_per_s"),
            ),
        ];
        for (slab, one) in pairs {
            assert!(
                (slab / (0.2 * one) - 1.0).abs() < 1e-9,
                "{well}: {slab} {one}"
            );
        }
    }
}

#[test]
fn a_pressure_below_zero_is_told_once_with_its_place_and_time_unless_it_is_meant() {
    let text = BETWEEN.replace("left = { pressure = 3 }\nright = { pressure = 1 }", "");
    let text = text.replace("mode = \"steady\"", "end = 1");
    let sink = "wells.out={at=[0.5, 0.25], rate=-1}";
    let told = |overrides: &[&str]| {
        let (summary, _) = run_text(
            &text,
            &[&["flow.initial_pressure=1", sink], overrides].concat(),
        );
        let below = |text: &&String| text.contains("below zero");
        summary
            .warnings
            .iter()
            .filter(below)
            .cloned()
            .collect::<Vec<String>>()
    };
    let warnings = told(&[]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].contains("t = ") && warnings[0].contains("flow.suction"),
        "{warnings:?}"
    );
    assert!(told(&["flow.suction=true"]).is_empty());
    assert!(
        told(&["wells.out.rate=-0.1"]).is_empty(),
        "the block holds half a cubic metre"
    );
}

/// Sneddon's penny: w = 8 (1 − ν²) p √(a² − r²) / (π E). A band opens beyond its last broken points, the less the finer
/// they are: 1.26, 1.13 and 1.08 times as far at radii of 3, 4.2 and 6 spacings.
#[test]
fn a_disc_has_its_opening_and_its_area() {
    let mut off = f64::INFINITY;
    for (spacing, most) in [
        ("geometry.points=[10, 10, 10]", 1.28),
        ("geometry.points=[14, 14, 14]", 1.15),
    ] {
        let plan = plan("penny-3d", &[spacing]);
        let (summary, state) = try_run(&plan).unwrap();
        let results = summary.results.unwrap();
        let area = std::f64::consts::PI * 0.09 / 4.0;
        assert!(
            (results.crack_length / area - 1.0).abs() < 0.01,
            "{}",
            results.crack_length
        );
        let (found, exact) = penny(&plan, &state);
        println!("{spacing}: {found:.3e} m of {exact:.3e} m");
        assert!((1.0..most).contains(&(found / exact)), "{found} {exact}");
        assert!(found / exact - 1.0 < 0.6 * off, "{found} {exact} {off}");
        off = found / exact - 1.0;
    }
}

/// Largest opening of the first disc, and Sneddon's, m.
fn penny(plan: &Plan, state: &State) -> (f64, f64) {
    let model = model::<3>(plan);
    let found = openings(&model, state, 0);
    let found = found.iter().map(|jump| jump[0]).fold(0.0, f64::max);
    let CrackPlace::Disc { radius, .. } = plan.cracks[0].place else {
        panic!("a disc");
    };
    let pressure = plan.cracks[0].pressure.as_ref().unwrap().at(0.0);
    (
        found,
        8.0 * (1.0 - 0.04) * pressure * radius / (std::f64::consts::PI * 20e9),
    )
}

/// The same disc in the middle of a whole block, and tilted: area and opening have both faces.
#[test]
fn a_tilted_disc_in_the_middle_of_a_block_has_both() {
    let clamped = ["left", "right", "front", "back", "bottom", "top"]
        .map(|side| format!("mechanics.boundary.{side}={{clamped=true}}"));
    for normal in ["[0, 0, 1]", "[1, 0, 1]"] {
        let disc =
            format!("cracks.penny.disc={{centre=[0.5, 0.5, 0.5], normal={normal}, radius=0.25}}");
        let mut overrides: Vec<&str> = clamped.iter().map(String::as_str).collect();
        overrides.extend([disc.as_str(), "geometry.points=[12, 12, 12]"]);
        let plan = plan("penny-3d", &overrides);
        let (summary, state) = try_run(&plan).unwrap();
        let area = std::f64::consts::PI * 0.0625;
        let found = summary.results.unwrap().crack_length;
        assert!(
            (found / area - 1.0).abs() < 0.01,
            "{normal}: {found} {area}"
        );
        let (found, exact) = penny(&plan, &state);
        println!("{normal}: {found:.3e} m of {exact:.3e} m");
        assert!(
            (0.5..1.15).contains(&(found / exact)),
            "{normal}: {found} {exact}"
        );
    }
}

/// Two cracks, of which the second is pumped; in either order of the file.
#[test]
fn the_figures_of_an_injection_are_those_of_the_pumped_crack() {
    let smoke = |first: &str| {
        let text = TWO_CRACKS.replace("FIRST", first);
        let (summary, _) = run_text(&text, &[]);
        summary.results.unwrap()
    };
    let [before, after] = ["a_side", "z_side"].map(smoke);
    for results in [&before, &after] {
        assert_eq!(results.peak_injection_crack.as_deref(), Some("main"));
        assert!(
            results.peak_injection_pressure.unwrap() > 2e4,
            "{results:?}"
        );
    }
    let [before, after] = [before, after].map(|results| results.peak_injection_pressure.unwrap());
    assert!((before / after - 1.0).abs() < 1e-6, "{before} {after}");
}

const TWO_CRACKS: &str = r#"title = "Two cracks"
[geometry]
type = "lattice"
size = ["0.48 m", "0.96 m"]
spacing = "4 cm"
[fluid]
viscosity = "1 mPa s"
[materials.rock]
youngs_modulus = "0.1 GPa"
poissons_ratio = 0.25
fracture_energy = "100 J/m^2"
permeability = "1e-12 m^2"
storage = "1e-10 1/Pa"
biot_coefficient = 1
[mechanics.boundary]
left = { roller = true }
right = { clamped = true }
top = { clamped = true }
bottom = { clamped = true }
[flow]
operator = "bond"
boundary = { right = { pressure = 0 } }
[coupling]
undrained_start = false
[damage]
model = "paper"
length_scale = "12 cm"
normalise = true
[fracture_flow]
storage = "1e-10 1/Pa"
[cracks.FIRST]
kind = "damaged"
points = [["0.2 m", "0.8 m"], ["0.3 m", "0.8 m"]]
pressure = 1000
[cracks.main]
kind = "damaged"
points = [["0 m", "0.32 m"], ["0.15 m", "0.32 m"]]
injection = { rate = "1e-3 m^2/s", at = ["0 m", "0.32 m"] }
[scheme]
name = "monolithic"
[time]
end = "0.05 s"
first_step = "10 ms"
max_step = "50 ms"
"#;

#[test]
fn timers_add_up_to_the_wall_time_and_counters_hold_the_step_that_finds_the_range() {
    let text = BETWEEN.replace("mode = \"steady\"", "end = 1");
    let (summary, _) = run_text(&text, &[]);
    let names: Vec<_> = summary.timers.iter().map(|(name, _)| name).collect();
    for name in [
        "cloud",
        "families",
        "assembly",
        "scheme",
        "range",
        "output",
        "factor",
        "substitution",
        "flow",
    ] {
        assert!(names.iter().any(|own| own == name), "{name} in {names:?}");
    }
    let sum: f64 = summary.timers.iter().map(|(_, seconds)| seconds).sum();
    assert!(
        sum <= 1.02 * summary.wall_s + 1e-3,
        "{sum} {}",
        summary.wall_s
    );
    // One analysis for the scheme, one for the step across the whole run.
    assert_eq!(summary.counters.solver.analyses, 2);
}
