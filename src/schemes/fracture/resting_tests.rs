//! Who rests, and by how much those who do may err.

use std::path::Path;

use crate::model::Model;
use crate::operators::Resting;
use crate::plan::resolve;
use crate::report::Timers;
use crate::scene::load_str;
use crate::schemes::State;

fn model(set: &[&str]) -> Model<2> {
    let text = include_str!("../../../cases/notched-tension/scene.toml");
    let small = ["geometry.points=[12, 12]", "damage.length_scale=0.3 mm"];
    let set: Vec<String> = small.iter().chain(set).map(|s| (*s).to_owned()).collect();
    let loaded = load_str("notch", text, Path::new(""), &set).unwrap();
    let plan = resolve(&loaded, "notch").unwrap();
    Model::build(&plan, &mut Timers::default()).unwrap()
}

/// A rough displacement (m) that breaks some points well and others hardly.
fn displaced(size: f64) -> Vec<f64> {
    let wave = |k: usize| (0.7 * k as f64).sin() + 0.02 * (k / 24) as f64 * (k % 2) as f64;
    (0..288).map(|k| size * wave(k)).collect()
}

#[test]
fn points_that_rest_err_by_less_than_what_stirs_them() {
    let growth = 1e-2;
    for split in ["spectral", "volumetric-deviatoric", "none"] {
        let model = model(&[&format!("damage.split={split}")]);
        let solid = model.solid.as_ref().unwrap();
        let (damage, elastic) = (solid.damage.as_ref().unwrap(), &solid.elastic);
        let walls = State::initial(&model).walls;
        let mut history = vec![0.0; elastic.points()];
        let began = solid.answer(&displaced(2e-7), &walls, &history).unwrap();
        damage.advance(&began.driving, &mut history);
        let mut resting = Resting::new(growth);
        resting.settle(damage, elastic, &history, &began);
        let mut counts = [0, 0];
        for change in [0.99, 0.999, 1.0, 1.001, 1.01, 1.5] {
            let there = displaced(2e-7 * change);
            let exact = solid.answer(&there, &walls, &history).unwrap();
            let own = solid.answer_of(&there, &walls, &history, &resting).unwrap();
            for i in 0..elastic.points() {
                let woken = own.stirred.contains(&(i as u32));
                counts[usize::from(woken)] += 1;
                let off = (own.damage[i] - exact.damage[i]).abs();
                assert!(off <= if woken { 0.0 } else { growth }, "{i} {split} {off}");
                let family = elastic.around.families.family(i);
                let size = |bond: usize| exact.forces[bond].norm();
                let off = |bond: usize| (own.forces[bond] - exact.forces[bond]).norm();
                let largest = family.clone().map(size).fold(0.0, f64::max);
                let off = family.map(off).fold(0.0, f64::max);
                assert!(off <= 4.0 * growth * largest, "{i} {split} {off} {largest}");
            }
            let bound = 1e-12 * exact.bulk;
            assert!(own.bulk >= exact.bulk - bound, "{split} {change}");
        }
        assert!(
            counts.iter().all(|count| *count > 100),
            "{split} {counts:?}"
        );
    }
}

#[test]
fn a_step_that_is_tried_again_keeps_who_was_stirred() {
    let model = model(&[]);
    let solid = model.solid.as_ref().unwrap();
    let (damage, elastic) = (solid.damage.as_ref().unwrap(), &solid.elastic);
    let walls = State::initial(&model).walls;
    let history = vec![0.0; elastic.points()];
    let at = solid.answer(&displaced(2e-7), &walls, &history).unwrap();
    let mut resting = Resting::new(1e-3);
    assert!(!resting.holds(7));
    resting.settle(damage, elastic, &history, &at);
    resting.wake(&[7]);
    resting.settle(damage, elastic, &history, &at);
    assert!(resting.holds(6) && !resting.holds(7));
    let mut nobody = Resting::new(0.0);
    nobody.settle(damage, elastic, &history, &at);
    assert!(!nobody.holds(6));
}
