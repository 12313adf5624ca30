//! What the examples print is right.
#![allow(clippy::unwrap_used)]

#[path = "../examples/crack_callback.rs"]
#[allow(dead_code)]
mod crack_callback;
#[path = "../examples/flow.rs"]
#[allow(dead_code)]
mod flow;
#[path = "../examples/own_cloud.rs"]
#[allow(dead_code)]
mod own_cloud;
#[path = "../examples/own_effect.rs"]
#[allow(dead_code)]
mod own_effect;
#[path = "../examples/terzaghi_by_hand.rs"]
#[allow(dead_code)]
mod terzaghi_by_hand;

use perifrac::prelude::*;

#[test]
fn flow_through_layers_in_a_row_follows_darcys_law() {
    let [found, exact] = flow::outflow().unwrap();
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} {exact}");
}

#[test]
fn a_column_stepped_by_hand_consolidates_as_terzaghi_says() {
    let coarse = terzaghi_by_hand::errors(20).unwrap();
    let fine = terzaghi_by_hand::errors(100).unwrap();
    assert!(fine.len() == 5 && fine.iter().all(|(_, error)| *error < 1e-3));
    let last = [coarse[4].1, fine[4].1];
    // Steps five times as long: what is left at the end is mostly theirs.
    assert!(last[1] < 5e-5 && last[1] < 0.5 * last[0], "{last:?}");
}

#[test]
fn a_callback_stops_the_run_when_the_crack_is_long_enough() {
    let (length, time) = crack_callback::grown_to(0.7e-3).unwrap();
    assert!((0.7e-3..0.85e-3).contains(&length), "{length}");
    assert!((4000.0..5000.0).contains(&time), "{time}");
    let (short, earlier) = crack_callback::grown_to(0.6e-3).unwrap();
    assert!(short < length && earlier < time, "{short} {earlier}");
}

#[test]
fn flow_through_handed_in_points_converges_to_darcys_law() {
    let error = |columns| {
        let (found, worst) = own_cloud::flow(columns).unwrap();
        ((found / own_cloud::exact_flow() - 1.0).abs(), worst)
    };
    let (coarse, fine) = (error(10), error(40));
    assert!(fine.0 < 5e-3 && fine.1 < 5e-3, "{fine:?}");
    assert!(
        fine.0 < coarse.0 && fine.1 < coarse.1,
        "{coarse:?} {fine:?}"
    );
}

#[test]
fn all_the_rain_is_in_the_pores() {
    let [found, exact, lost] = own_effect::rise().unwrap();
    assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    assert!(lost < 1e-8, "{lost}");
}

const DRY: &str = r#"
title = "No flow"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [8, 8] }
materials.rock = { youngs_modulus = "1 GPa", poissons_ratio = 0.2 }
mechanics.boundary.left.clamped = true
time.end = "1 s"
"#;

/// A force of one newton along x, shared by all points.
struct Pull(Vec<f64>);

impl Effect for Pull {
    fn name(&self) -> &'static str {
        "pull"
    }

    fn add_rate(&self, _time: f64, force: &mut [f64]) {
        let along_x = force.iter_mut().step_by(2);
        along_x.zip(&self.0).for_each(|(f, share)| *f += share);
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

fn pull() -> OwnEffect {
    OwnEffect::on_solid(|points| {
        let whole: f64 = points.volume.iter().sum();
        Pull(points.volume.iter().map(|v| v / whole).collect())
    })
}

#[test]
fn an_own_force_moves_the_rock_as_a_body_force_does() {
    let body = Setup::text(DRY).set("mechanics.body_force", "[1, 0]");
    let moved = |setup: &Setup| {
        let plan = setup.plan().unwrap();
        let (_, state) = run(&plan, None, &mut (), &Interrupt::default()).unwrap();
        state.displacement
    };
    let (own, usual) = (moved(&Setup::text(DRY).effect(pull())), moved(&body));
    let largest = usual.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    assert!(largest > 0.0);
    for (a, b) in own.iter().zip(&usual) {
        assert!((a - b).abs() < 1e-9 * largest, "{a} {b}");
    }
}

#[test]
fn an_effect_on_a_field_that_is_not_computed_is_refused() {
    struct Nothing;
    impl Effect for Nothing {
        fn name(&self) -> &'static str {
            "nothing"
        }
        fn add_rate(&self, _time: f64, _rate: &mut [f64]) {}
        fn bytes(&self) -> usize {
            0
        }
    }
    let nothing = OwnEffect::on_flow(|_| Nothing);
    let plan = Setup::text(DRY).effect(nothing).plan().unwrap();
    let error = Model::<2>::of(&plan).err().unwrap();
    assert!(matches!(error, ModelError::NothingToActOn { .. }));
    assert!(error.to_string().contains("[flow]"), "{error}");
}

#[test]
fn a_run_goes_on_with_its_own_effects_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let with = Setup::text(DRY).effect(pull()).plan().unwrap();
    let interrupt = Interrupt::default();
    let go_on = |plan: &Plan, from: Option<Checkpoint>| {
        let mut writer = Writer::create(folder.path(), "").unwrap();
        let mut listener = ();
        let job = Job {
            writer: Some(&mut writer),
            settings: Settings {
                checkpoints: Some(CheckpointRule::default()),
                ..Settings::default()
            },
            from,
            ..Job::new(&mut listener, &interrupt)
        };
        run_job(plan, job).map(|(_, state)| state)
    };
    let first = go_on(&with, None).unwrap();
    let kept = || Some(Checkpoint::newest(folder.path()).unwrap());
    assert_eq!(go_on(&with, kept()).unwrap(), first);
    let without = Setup::text(DRY).plan().unwrap();
    let error = go_on(&without, kept()).unwrap_err().to_string();
    assert!(error.contains("\"pull\""), "{error}");
}

#[test]
fn tables_that_do_not_fit_together_are_refused() {
    let table = || PointTable::new(2, &[0.0, 0.0, 1.0, 0.0], &[1.0, 1.0]);
    assert!(table().is_ok());
    let short = table().and_then(|t| t.with_permeability(&[1e-12]));
    let negative = table().and_then(|t| t.with_permeability(&[1e-12, -1e-12]));
    let names = table().and_then(|t| t.with_materials(&["rock"]));
    let endless = PointTable::new(2, &[0.0, f64::NAN], &[1.0]);
    for (table, words) in [
        (short, "1 values of permeability, and 2"),
        (negative, "permeability of point 1 is -0.000000000001"),
        (names, "1 values of material"),
        (endless, "position of point 0"),
        (PointTable::new(4, &[0.0; 4], &[1.0]), "not 4"),
        (PointTable::new(2, &[], &[]), "0 values of volume"),
    ] {
        let text = table.unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn a_scene_at_fault_is_shown_with_its_place() {
    let errors = Setup::text(DRY.replace("1 GPa", "1 GPaa")).plan();
    let text = format!("{:?}", errors.unwrap_err());
    assert!(
        text.contains("unknown unit") && text.contains("scene:4"),
        "{text}"
    );
}
