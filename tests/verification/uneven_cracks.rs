//! Fluid in cracks on points that are no lattice (docs/theory.md, section 19).

use perifrac::output::History;
use perifrac::run::{Interrupt, Writer, run};

use crate::support::{plan_of, try_run};

/// A crack of a metre in the middle of a block of 3 m, into which fluid with next to no friction is pumped.
const KGD: &str = r#"
title = "A crack on uneven points"
geometry = { type = "lattice", size = ["3 m", "3 m"], spacing = "10 cm" }
fluid.viscosity = "1e-6 Pa s"
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2", permeability = "1e-30 m^2", storage = "1e-12 1/Pa", biot_coefficient = 0 }
mechanics.boundary = { left = { clamped = true }, right = { clamped = true }, bottom = { clamped = true }, top = { clamped = true } }
flow = {}
damage = {}
fracture_flow = {}
coupling.undrained_start = false
scheme.name = "monolithic"
time = { end = "0.2 s", first_step = "0.1 s", max_step = "0.1 s", tolerance = 0.1 }
output.vtu = false
[cracks.main]
kind = "damaged"
points = [["1 m", "1.5 m"], ["2 m", "1.5 m"]]
injection = { rate = "1e-4 m^2/s", at = ["1.5 m", "1.5 m"] }
"#;

const JITTER: &str = "geometry.jitter=0.25";

/// Crack at an angle to the rows of the lattice, degrees.
fn turned(angle: f64) -> String {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let end = |side: f64| {
        format!(
            "[{}, {}]",
            1.5 + side * 0.5 * cosine,
            1.5 + side * 0.5 * sine
        )
    };
    format!("cracks.main.points=[{}, {}]", end(-1.0), end(1.0))
}

/// Pressure in the crack, Pa, its opening at the inlet, m, and the passes that a run took.
fn ended(overrides: &[&str]) -> (f64, f64, u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(folder.path(), "").unwrap();
    let plan = plan_of(KGD, overrides);
    let ran = run(&plan, Some(&mut writer), &mut (), &Interrupt::default());
    let (summary, _) = ran.unwrap_or_else(|error| panic!("{error}"));
    let table = History::read(folder.path().join("history.csv")).unwrap();
    let last = |name: &str| *table.column(name).unwrap().last().unwrap();
    let passes = summary.counters.coupling_iterations;
    (
        last("crack_pressure_main_Pa"),
        last("opening_main_m"),
        passes,
    )
}

/// Where a uniform pressure moves broken points about, as with the plain gradient, pressures and openings fall to half of those of the lattice.
#[test]
fn a_crack_opens_under_fluid_on_jittered_points_as_on_a_lattice() {
    for angle in [0.0, 22.5, 45.0] {
        let crack = turned(angle);
        let (pressure, opening, _) = ended(&[&crack]);
        for seed in [1, 2] {
            let seed = format!("geometry.seed={seed}");
            let (jittered, width, _) = ended(&[&crack, JITTER, &seed]);
            let off = [jittered / pressure - 1.0, width / opening - 1.0];
            assert!(
                off.iter().all(|off| off.abs() < 0.12),
                "{angle} {seed} {off:?}"
            );
        }
    }
}

/// Along rows, diagonals and in between, and on jittered points, the crack of 10 spacings grows at the same pressure and opening.
#[test]
fn a_crack_grows_under_fluid_at_the_same_pressure_in_any_direction() {
    let run = |angle: f64, more: &[&str]| {
        let crack = turned(angle);
        let set: Vec<&str> = [crack.as_str(), "time.end=1"]
            .iter()
            .chain(more)
            .copied()
            .collect();
        ended(&set)
    };
    let (pressure, opening, _) = run(0.0, &[]);
    let jittered = [JITTER, "geometry.seed=2"];
    for (angle, more) in [(45.0, &[][..]), (22.5, &jittered), (0.0, &jittered)] {
        let (turned, width, passes) = run(angle, more);
        let off = [turned / pressure - 1.0, width / opening - 1.0];
        assert!(
            off.iter().all(|off| off.abs() < 0.08),
            "{angle} {more:?} {off:?}"
        );
        assert!(passes < 400, "{angle} {more:?}: {passes} passes");
    }
}

/// A damaged crack that is held at a pressure, beside one that is cut, which keeps the plain gradient.
const BESIDE: &str = r#"
title = "A damaged crack beside a cut one"
geometry = { type = "lattice", size = ["3 m", "3 m"], spacing = "10 cm" }
materials.rock = { youngs_modulus = "20 GPa", poissons_ratio = 0.2, fracture_energy = "100 J/m^2" }
mechanics.boundary.bottom.clamped = true
damage = {}
time = { end = "1 s", step = "1 s" }
output.vtu = false
[cracks.main]
kind = "damaged"
points = [["1 m", "1.51 m"], ["2 m", "1.51 m"]]
pressure = "0.1 MPa"
[cracks.other]
kind = "cut"
points = [["1 m", "2.5 m"], ["2 m", "2.5 m"]]
"#;

/// With the plain gradient the run is refused and says what to do; on a lattice it runs, and so does one without fluid in what is broken.
#[test]
fn fluid_in_broken_rock_is_refused_where_its_pressure_is_not_in_equilibrium() {
    let ran = |text: &str, overrides: &[&str]| {
        let ran = try_run(&plan_of(text, overrides));
        ran.map(|_| ()).map_err(|error| error.to_string())
    };
    let plain = ran(KGD, &[JITTER, "mechanics.gradient=plain"]).unwrap_err();
    assert!(
        plain.contains("set mechanics.gradient = \"divergence-consistent\""),
        "{plain}"
    );
    let beside = ran(BESIDE, &[JITTER]).unwrap_err();
    assert!(
        beside.contains("make all cracks kind = \"damaged\""),
        "{beside}"
    );
    assert_eq!(ran(KGD, &["mechanics.gradient=plain"]), Ok(()));
    assert_eq!(ran(BESIDE, &[]), Ok(()));
    let dry = BESIDE.replace("pressure = \"0.1 MPa\"\n", "");
    assert_eq!(ran(&dry, &[JITTER]), Ok(()));
}
