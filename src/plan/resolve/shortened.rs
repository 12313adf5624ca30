//! What reaches past the end of the run is brought back to it: a scene stays valid when its run is
//! shortened.

use crate::plan::types::{DamagePlan, OutputPlan, StepRule, TimeMode, TimePlan};
use crate::scene::Scene;

/// Cuts steps and outputs of a transient run to its end; tells what was cut.
pub(super) fn cut_to_end(
    scene: &Scene,
    time: &mut TimePlan,
    output: &mut OutputPlan,
    damage: Option<&mut DamagePlan>,
) -> Vec<String> {
    let end = time.end;
    if time.mode == TimeMode::Steady || end <= 0.0 {
        return Vec::new();
    }
    let mut told = Vec::new();
    if let StepRule::Fixed(step) = &mut time.step {
        told.extend(cut("time.step", step, end));
    }
    if let Some(longest) = &mut time.max_step {
        told.extend(cut("time.max_step", longest, end));
    }
    if let Some(first) = &mut time.first_step {
        told.extend(cut("time.first_step", first, end));
        if let Some(longest) = time.max_step.filter(|longest| *first > *longest) {
            told.push(format!(
                "time.first_step = {first} s is longer than time.max_step and is cut to it, {longest} s"
            ));
            *first = longest;
        }
    }
    if let Some(damage) = damage {
        told.extend(cut("damage.shortest_step", &mut damage.shortest_step, end));
    }
    told.extend(outputs(scene, output, end));
    told
}

fn cut(key: &str, length: &mut f64, end: f64) -> Option<String> {
    if *length <= end {
        return None;
    }
    let told = format!("{key} = {length} s is longer than the run and is cut to its end, {end} s");
    *length = end;
    Some(told)
}

/// Leaves out the outputs after the end, where the last state is written anyway.
fn outputs(scene: &Scene, output: &mut OutputPlan, end: f64) -> Option<String> {
    output.times.sort_unstable_by(f64::total_cmp);
    let kept = output.times.partition_point(|time| *time <= end);
    let late = output.times.split_off(kept);
    if let Some(every) = scene.output.every.filter(|every| every.value() > end) {
        return Some(format!(
            "output.every = {every} is longer than the run: only the state at its end, {end} s, is \
             written"
        ));
    }
    let (first, after) = (late.first()?, "lie after the end of the run");
    Some(match late.len() {
        1 => format!(
            "the output at {first} s lies after the end of the run, {end} s, and is left out"
        ),
        count => {
            format!(
                "{count} of output.times, from {first} s on, {after}, {end} s, and are left out"
            )
        }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use crate::plan::{Plan, StepRule, resolve};
    use crate::scene::load_file;

    fn planned(case: &str, variant: Option<&str>, sets: &[&str]) -> Plan {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let file = format!("cases/{case}/{}.toml", variant.unwrap_or("scene"));
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
        let loaded = load_file(&path, &sets).unwrap();
        resolve(&loaded, case).unwrap()
    }

    /// The keys come in both orders: those of `--set` before and after the end.
    #[test]
    fn steps_longer_than_the_run_are_cut_to_it_and_told() {
        for sets in [
            ["time.end=2", "time.max_step=3", "time.first_step=4"],
            ["time.first_step=4", "time.max_step=3", "time.end=2"],
        ] {
            let plan = planned("five-spot", None, &sets);
            assert_eq!(
                (plan.time.first_step, plan.time.max_step),
                (Some(2.0), Some(2.0))
            );
            let told = |key: &str| plan.warnings.iter().any(|told| told.contains(key));
            assert!(
                told("time.max_step = 3 s is longer than the run"),
                "{:?}",
                plan.warnings
            );
            assert!(
                told("time.first_step = 4 s is longer than the run"),
                "{:?}",
                plan.warnings
            );
        }
        let plan = planned(
            "five-spot",
            None,
            &["time.max_step=1e-3", "time.first_step=0.5"],
        );
        assert_eq!(plan.time.first_step, Some(1e-3));
        assert!(
            plan.warnings
                .iter()
                .any(|told| told.contains("time.max_step and is cut to it"))
        );
    }

    #[test]
    fn a_fixed_step_longer_than_the_run_is_one_step() {
        let plan = planned("terzaghi", None, &["time.step=1 h", "time.end=1 min"]);
        assert_eq!(plan.time.step, StepRule::Fixed(60.0));
        assert!(
            plan.warnings[0].contains("time.step = 3600 s"),
            "{:?}",
            plan.warnings
        );
    }

    #[test]
    fn outputs_after_the_end_are_left_out_whatever_their_order() {
        let sets = ["time.end=2", "output.times=[5, 1, 9, 2]"];
        let plan = planned("five-spot", None, &sets);
        assert_eq!(plan.output.times, [1.0, 2.0]);
        let told = plan
            .warnings
            .iter()
            .find(|told| told.contains("2 of output.times, from 5 s on"));
        assert!(told.is_some(), "{:?}", plan.warnings);
    }

    #[test]
    fn a_variant_may_be_shortened() {
        let plan = planned("natural-fractures", Some("smoke"), &["time.end=1e-3"]);
        assert!(plan.time.max_step.is_none_or(|step| step <= 1e-3));
        assert!(
            plan.damage
                .is_some_and(|damage| damage.shortest_step <= 1e-3)
        );
        assert!(plan.output.times.iter().all(|time| *time <= 1e-3));
    }

    #[test]
    fn what_fits_is_left_as_it_is_in_silence() {
        let plan = planned(
            "five-spot",
            None,
            &["time.first_step=1e-3", "time.max_step=1e-2"],
        );
        assert_eq!(
            (plan.time.first_step, plan.time.max_step),
            (Some(1e-3), Some(1e-2))
        );
        assert!(
            !plan.warnings.iter().any(|told| told.contains("cut")),
            "{:?}",
            plan.warnings
        );
    }
}
