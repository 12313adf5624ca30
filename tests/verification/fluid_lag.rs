//! Fluid that does not follow where a crack opens: voids at the pressure at which it boils (docs/theory.md, section 19).

use perifrac::run::{Interrupt, Observer, Summary, run};
use perifrac::schemes::State;

use crate::support::{plan, plan_of, run_text, try_run};

/// A crack of 1 m in the middle of a block (a quarter of it is computed) that is pulled within 0.1 s by 1 MPa,
/// while fluid without friction is pumped into it.
const PULLED: &str = r#"title = "A crack that tension opens is filled"
geometry = { type = "lattice", size = ["2 m", "2 m"], spacing = "10 cm" }
fluid.viscosity = "1e-6 Pa s"
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "1e6 J/m^2", permeability = "1e-30 m^2", storage = "1e-11 1/Pa", biot_coefficient = 0 }
flow = {}
damage = {}
fracture_flow = {}
coupling.undrained_start = false
scheme.name = "monolithic"
time = { end = "2 s", step = "0.1 s" }
output.vtu = false
[mechanics.boundary]
left.roller = true
bottom.roller = true
top.traction = [0, { time = [0, 0.1, 10], value = [0, "1 MPa", "1 MPa"] }]
[cracks.main]
kind = "damaged"
points = [["0 m", "0 m"], ["0.5 m", "0 m"]]
injection = { rate = "1e-4 m^2/s", at = ["0 m", "0 m"] }
"#;

/// Pull, Pa, and what the quarter of the crack gets a second, m².
const PULL: f64 = 1e6;
const RATE: f64 = 2.5e-5;

fn fluid_and_void(summary: &Summary) -> (f64, f64) {
    let results = summary.results.as_ref().unwrap();
    (results.crack_volume.unwrap(), results.void_volume.unwrap())
}

/// Pressure at the end where fluid is pumped in, Pa: it never falls there.
fn pressure(summary: &Summary) -> f64 {
    let results = summary.results.as_ref().unwrap();
    results.peak_injection_pressure.unwrap()
}

/// A crack opens in proportion to the pull and the pressure together. Pulled by σ it opens by V₀ at no pressure, so
/// that the pressure stays at that of boiling until V₀ is filled and is σ (V/V₀ − 1) from then on. Nothing is lost.
#[test]
fn a_crack_that_tension_opens_fills_before_its_pressure_rises() {
    for scheme in ["monolithic", "staggered"] {
        let name = format!("scheme.name={scheme}");
        let (half, _) = run_text(PULLED, &[&name, "time.end=0.5 s"]);
        let (fluid, void) = fluid_and_void(&half);
        assert!(
            (fluid / (0.5 * RATE) - 1.0).abs() < 1e-4,
            "{scheme}: {fluid}"
        );
        assert!(void > 0.5 * fluid, "{scheme}: {void}");
        // Friction on the way to the voids.
        assert!(
            pressure(&half) < 1e-3 * PULL,
            "{scheme}: {}",
            pressure(&half)
        );
        let opened = fluid + void;
        let (full, _) = run_text(PULLED, &[&name]);
        let (fluid, void) = fluid_and_void(&full);
        assert!(void == 0.0, "{scheme}: {void}");
        assert!(
            (fluid / (2.0 * RATE) - 1.0).abs() < 1e-3,
            "{scheme}: {fluid}"
        );
        let expected = PULL * (fluid / opened - 1.0);
        let found = pressure(&full);
        assert!(
            (found / expected - 1.0).abs() < 5e-3,
            "{scheme}: {found} for {expected}"
        );
    }
}

/// At −0.5 MPa half of the pull is left to open the crack.
#[test]
fn a_crack_closes_on_fluid_that_boils_at_a_lower_pressure() {
    let opened = |limit: &str| {
        let limit = format!("fluid.cavitation_pressure={limit}");
        let (summary, state) = run_text(PULLED, &[&limit, "flow.suction=true", "time.end=0.1 s"]);
        let lowest = state.pressure.iter().copied().fold(0.0, f64::min);
        (fluid_and_void(&summary), lowest)
    };
    let ((fluid, void), lowest) = opened("0 Pa");
    let ((half_fluid, half_void), half_lowest) = opened("-0.5 MPa");
    assert!(
        lowest.abs() < 1e-9 && half_lowest == -0.5e6,
        "{lowest} {half_lowest}"
    );
    let ratio = (half_fluid + half_void) / (fluid + void);
    assert!((ratio - 0.5).abs() < 5e-3, "{ratio}");
}

/// Nothing but `flow.suction` switches boiling off.
#[test]
fn pressures_that_count_from_another_zero_do_not_boil() {
    let set = [
        "flow.suction=true",
        "time.end=0.1 s",
        "materials.rock.storage=1e-10 1/Pa",
    ];
    let (summary, state) = run_text(PULLED, &set);
    assert_eq!(fluid_and_void(&summary).1, 0.0);
    assert!(state.pressure.iter().any(|p| *p < -0.5e6));
}

/// Water pumped into a crack at 45° to the stresses in tight rock with pores that feel it: where the tip opens undrained
/// pores draw by a megapascal and rock breaks before fluid is there.
const TIGHT: &str = r#"title = "Water in tight rock"
geometry = { type = "lattice", size = ["1.6 m", "1.6 m"], spacing = "4 cm" }
fluid.viscosity = "1 mPa s"
initial.stress = { xx = "-10 MPa", yy = "-5 MPa" }
time = { end = "0.4 s", first_step = "10 ms", tolerance = 0.1 }
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2", permeability = "1e-20 m^2", storage = "1e-11 1/Pa", biot_coefficient = 0.6 }
flow = {}
coupling.undrained_start = false
damage.largest_increment = 0.9
fracture_flow = {}
output.vtu = false
[mechanics.boundary]
left.clamped = true
right.clamped = true
bottom.clamped = true
top.clamped = true
[cracks.main]
kind = "damaged"
points = [["0.66 m", "0.66 m"], ["0.94 m", "0.94 m"]]
injection = { rate = "1e-4 m^2/s", at = ["0.8 m", "0.8 m"] }
"#;

/// The crack runs, holds what was pumped in, and does not care how short steps are.
#[test]
fn water_is_pumped_into_tight_rock_whose_pores_draw() {
    let (summary, _) = run_text(TIGHT, &[]);
    let (fluid, void) = fluid_and_void(&summary);
    assert!(
        (fluid / 4e-5 - 1.0).abs() < 1e-4 && void == 0.0,
        "{fluid} {void}"
    );
    assert!(
        summary.steps <= 20 && summary.rejected <= 2,
        "{}",
        summary.steps
    );
    let length = |set: &[&str]| run_text(TIGHT, set).0.results.unwrap().crack_length;
    let start = length(&["time.end=10 ms"]);
    let grown = summary.results.unwrap().crack_length - start;
    assert!(grown > 0.15, "{grown}");
    let short = [
        "time.end=0.2 s",
        "time.first_step=5 ms",
        "time.max_step=5 ms",
    ];
    let (long, short) = (length(&["time.end=0.2 s"]), length(&short));
    let apart = (long - short).abs() / (short - start);
    assert!(apart < 0.15, "{long} {short} {start}");
}

/// Soft rock that takes in fluid as it widens draws at the tip of `natural-fractures`: points there are empty at the
/// end of the first step, their faces bear no suction, and nothing flows out of them that was not in them. Others hold a
/// void and fluid, which boils.
#[test]
fn rock_draws_a_tip_empty_and_gets_no_more_than_was_in_it() {
    let plan = plan("natural-fractures", &["time.end=10 ms"]);
    let (summary, state) = try_run(&plan).unwrap();
    let (fluid, void) = fluid_and_void(&summary);
    assert!(void > 0.1 * fluid, "{void} beside {fluid}");
    let leaked = summary.results.as_ref().unwrap().leaked_volume.unwrap();
    let injected = 5e-4 * 10e-3;
    let apart = (fluid + leaked) / injected - 1.0;
    assert!(apart.abs() < 1e-6, "{fluid} and {leaked}");
    let coefficients = state.coefficients.unwrap();
    let voids = &coefficients.voids;
    let (whole, part): (Vec<_>, Vec<_>) = voids.iter().partition(|(_, void)| void.whole);
    assert!(!whole.is_empty() && !part.is_empty(), "{voids:?}");
    let pressure = |i: &u32| state.pressure[*i as usize];
    assert!(whole.iter().all(|(i, _)| pressure(i) < 0.0));
    assert!(part.iter().all(|(i, _)| pressure(i) == 0.0));
    assert!(voids.values().all(|void| void.volume >= 0.0));
}

/// Rock of α = 0 that breaks beside a crack, where no fluid leads, opens empty: filled at once, the crack held 2.9e-4 more than
/// was pumped into it, and the pores owed it.
#[test]
fn rock_that_breaks_where_no_fluid_leads_is_empty() {
    let small = "geometry.size=[\"1.5 m\", \"3 m\"]";
    let plan = plan("two-cracks", &[small, "time.end=1.3 s"]);
    let mut empty = Empty::default();
    let (summary, _) = run(&plan, None, &mut empty, &Interrupt::default()).unwrap();
    let efficiency = summary.results.unwrap().fluid_efficiency.unwrap();
    assert!((efficiency - 1.0).abs() < 1e-6, "{efficiency}");
    assert!(empty.steps > 0 && empty.steps < summary.steps as usize);
}

/// Counts steps after which there is broken rock with no fluid and with no donor of any: fluid may come there later.
#[derive(Default)]
struct Empty {
    steps: usize,
}

impl Observer for Empty {
    fn state(&mut self, state: &State) {
        let Some(coefficients) = &state.coefficients else {
            return;
        };
        let alone = |i: usize| coefficients.donor[i] == i as u32 && state.pressure[i] <= 0.0;
        let broken = |i: usize| state.history[i] > 0.0 && alone(i);
        self.steps += usize::from((0..state.pressure.len()).any(broken));
    }
}

/// A crack gives no more than it has.
#[test]
fn an_empty_crack_gives_no_fluid() {
    let out = "cracks.main.injection.rate=-1e-5 m^2/s";
    let plan = plan_of(TIGHT, &[out, "time.end=20 ms"]);
    let refused = try_run(&plan).map(|_| ()).unwrap_err().to_string();
    assert!(
        refused.contains("more fluid leaves the crack at"),
        "{refused}"
    );
}
