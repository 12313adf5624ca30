//! Permeability tensors: a manufactured field with its own source, the well of Papadopulos (1965), a strip between
//! sealed sides, rock at rest, and bonds that stay positive.

use std::f64::consts::PI;

use perifrac::model::FlowModel;
use perifrac::prelude::*;

use crate::support::{flow_model, orders, plan, plan_of, run_text, square, try_run};

/// Components of a tensor of principal values 1 and `k2`, the first at 30° to x.
fn turned(k2: f64) -> [f64; 3] {
    let (sine, cosine) = (PI / 6.0).sin_cos();
    let (s, c) = (sine * sine, cosine * cosine);
    [c + k2 * s, s + k2 * c, (1.0 - k2) * sine * cosine]
}

fn rock(k2: f64) -> String {
    format!("materials.rock.permeability={{k1=1, k2={k2:e}, angle=\"30 deg\"}}")
}

/// The source of p = sin πx sin 2πy in rock of a tensor and unit viscosity.
struct Source(Vec<f64>);

impl Source {
    fn of([xx, yy, xy]: [f64; 3], points: &Points<'_>) -> Self {
        let places = points.position.chunks(2).zip(points.volume);
        let rate = |(x, volume): (&[f64], &f64)| {
            let (a, b) = (PI * x[0], 2.0 * PI * x[1]);
            let own = PI * PI * (xx + 4.0 * yy) * a.sin() * b.sin();
            volume * (own - 4.0 * PI * PI * xy * a.cos() * b.cos())
        };
        Source(places.map(rate).collect())
    }
}

impl Effect for Source {
    fn name(&self) -> &'static str {
        "source"
    }

    fn add_rate(&self, _time: f64, rate: &mut [f64]) {
        rate.iter_mut()
            .zip(&self.0)
            .for_each(|(rate, own)| *rate += own);
    }

    fn injection(&self, _time: f64) -> f64 {
        self.0.iter().sum()
    }

    fn bytes(&self) -> usize {
        8 * self.0.len()
    }
}

/// Largest error of that pressure on points × points.
fn error(k2: f64, points: usize) -> f64 {
    let zero = "{left={pressure=0}, right={pressure=0}, bottom={pressure=0}, top={pressure=0}}";
    let source = OwnEffect::on_flow(move |points| Source::of(turned(k2), points));
    let key = rock(k2);
    let (key, value) = key.split_once('=').unwrap();
    let setup = Setup::text(square(points)).set("flow.boundary", zero);
    let plan = setup.set(key, value).effect(source).plan().unwrap();
    let (_, state) = try_run(&plan).unwrap();
    let flow: FlowModel<2> = flow_model(&plan);
    let position = &flow.operator.neighbourhood().cloud.position;
    let exact = |x: &Vector<2>| (PI * x[0]).sin() * (2.0 * PI * x[1]).sin();
    let pairs = position.iter().zip(&state.pressure);
    pairs.map(|(x, p)| (p - exact(x)).abs()).fold(0.0, f64::max)
}

/// Up to where all bonds are positive and far beyond.
#[test]
fn a_smooth_pressure_is_second_order_at_every_anisotropy() {
    for k2 in [0.2, 1e-2, 1e-3] {
        let errors = [20, 40, 80].map(|points| error(k2, points));
        println!("{k2}: {errors:?}");
        assert!(orders(&errors)[1] > 1.9, "{k2}: {errors:?}");
        assert!(errors[2] < 3e-3, "{k2}: {errors:?}");
    }
}

#[test]
fn a_well_in_anisotropic_rock_follows_papadopulos() {
    let errors = [40, 80].map(|points| {
        let points = format!("geometry.points=[{points}, {points}]");
        let (summary, _) =
            try_run(&plan("anisotropic", &[&points, "time.tolerance=1e-4"])).unwrap();
        assert!(summary.warnings.is_empty(), "{:?}", summary.warnings);
        summary.errors["pressure"].l2
    });
    println!("{errors:?}");
    assert!(orders(&errors)[0] > 1.8 && errors[1] < 3.5e-3, "{errors:?}");
}

/// Far from its ends a strip between sealed sides conducts K_xx − K_xy²/K_yy: across it the pressure adjusts.
#[test]
fn a_sealed_strip_conducts_along_itself_what_is_left_of_the_tensor() {
    for k2 in [0.2, 1e-2] {
        let [xx, yy, xy] = turned(k2);
        let strip = [
            "geometry.size=[100, 1]",
            "geometry.points=[400, 4]",
            &rock(k2),
        ];
        let (summary, _) = run_text(&square(4), &strip);
        let left = xx - xy * xy / yy;
        let ratio = summary.outflow["right"] * 100.0 / left;
        println!("{k2}: {ratio}");
        // Both ends hold the pressure across the strip, which shortens it by about its width.
        assert!((0.999..1.03).contains(&ratio), "{ratio}");
    }
}

#[test]
fn a_column_of_fluid_stays_at_rest_in_oblique_rock() {
    let rest = [
        "fluid.density=1000",
        "gravity.acceleration=[0, -9.81]",
        "flow={hydrostatic_start=true, initial_pressure=1e5, boundary={top={pressure=1e5}}}",
        "time={mode=\"transient\", end=1}",
        &rock(0.2),
    ];
    let plan = plan_of(&square(10), &rest);
    let (_, state) = try_run(&plan).unwrap();
    let flow: FlowModel<2> = flow_model(&plan);
    for velocity in flow.velocity(&state.pressure, state.time) {
        // Pressures of 1e5 have 1e-11, over the spacing.
        assert!(velocity.amax() < 1e-9, "{velocity}");
    }
}

/// A box of oblique rock in rock a million times better and worse.
#[test]
fn oblique_boxes_in_other_rock_leave_the_matrix_an_m_matrix() {
    for k in [1e-6, 1.0, 1e6] {
        let inner = format!(
            "materials.inner={{permeability={{k1={k:e}, k2={:e}, angle=\"30 deg\"}}, storage=1, \
             region={{type=\"box\", min=[0.25, 0.25], max=[0.6, 0.75]}}}}",
            0.2 * k
        );
        let plan = plan_of(&square(20), &[&inner]);
        let flow: FlowModel<2> = flow_model(&plan);
        for (row, diagonal) in flow.pattern.diagonals() {
            for place in flow.pattern.row(row) {
                let value = flow.conductance[place];
                assert!(place == diagonal || value <= 0.0, "{k:e} {row}: {value:e}");
            }
        }
        assert!(perifrac_solvers::is_symmetric(flow.matrix(), 1e-12));
        let (_, state) = try_run(&plan).unwrap();
        assert!(state.pressure.iter().all(|p| (0.0..=1.0).contains(p)));
    }
}
