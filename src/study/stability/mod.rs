//! Where each scheme holds: steps over the stable explicit step × coupling strength or contrast.

mod border;
mod class;
mod map;
mod setting;
mod theory;
mod tried;

use serde_json::json;

use self::border::{borders, headline};
use self::class::{Class, INACCURATE, OVERSHOOT};
use self::map::draw;
use self::setting::Setting;
use self::theory::Split;
use self::tried::tried;
use super::{
    Measured, Options, RecordedOutput, ReportContent, Section, Study, StudyCase, StudyError, Table,
    Variant,
};

/// The study of stability.
pub(super) struct Stability;

/// Ratio of neighbouring steps and strengths: a quarter of a decade.
const CELL: f64 = 1.778_279_410_038_922_8;
/// Where the lattice of steps and strengths is hung up, so that borders at 1 lie between two of them.
const HUNG: f64 = 0.749_894_209_332_455_8;
/// Steps of every run: modes that grow by a third per step become large.
const STEPS: u32 = 80;

/// Steps of a map, as powers of a cell: around the explicit limit, and from there to beyond the borders
/// where the smallest steps are the unstable ones.
fn steps(setting: &Setting, split: Split, strengths: &[i32], quick: bool) -> Vec<i32> {
    let usual = if quick { -1..=3 } else { -3..=5 };
    let borders = strengths
        .iter()
        .map(|s| setting.stable(split, HUNG * CELL.powi(*s)).0)
        .filter(|from| *from > 0.0)
        .map(|from| ((from / HUNG).ln() / CELL.ln()).floor() as i32);
    match (borders.clone().min(), borders.max()) {
        (Some(least), Some(most)) => [-1].into_iter().chain(least - 1..=most + 2).collect(),
        _ => usual.collect(),
    }
}

impl Study for Stability {
    fn name(&self) -> &'static str {
        "stability"
    }

    fn variants(&self, subject: &StudyCase, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let setting = Setting::new(subject, options)?;
        let coupled = subject.is_coupled();
        let strengths: &[i32] = match (options.quick, coupled) {
            (true, true) => &[-1, 1, 5],
            (true, false) => &[1, 9, 17],
            (false, true) => &[-4, -2, -1, 0, 1, 2, 3, 5],
            (false, false) => &[1, 5, 9, 17, 25, 33, 49],
        };
        let mut variants = Vec::new();
        for tried in tried(coupled) {
            if !options.wants_scheme(tried.method.scheme) {
                continue;
            }
            let solvers = subject.solvers(tried.method.scheme, options);
            let steps = steps(&setting, (tried.split)(subject), strengths, options.quick);
            for (&k, &s) in steps
                .iter()
                .flat_map(|k| strengths.iter().map(move |s| (k, s)))
            {
                let (ratio, strength) = (HUNG * CELL.powi(k), HUNG * CELL.powi(s));
                let step = ratio * setting.limit(strength);
                let mut variant = tried
                    .method
                    .variant(solvers.first().map(String::as_str))
                    .set(setting.grid.overrides.clone())
                    .set(tried.overrides.iter().map(|text| (*text).to_owned()))
                    .set([
                        format!("time.step={step:e}"),
                        format!("time.end={:e}", step * f64::from(STEPS)),
                        "output.times=[]".to_owned(),
                        "output.plots=false".to_owned(),
                        match coupled {
                            true => format!(
                                "materials.{}.storage={:e}",
                                setting.material,
                                setting.storage(strength)
                            ),
                            false => format!(
                                "materials.{}.permeability={:e}",
                                setting.material,
                                setting.permeability * strength
                            ),
                        },
                    ])
                    .with("step_ratio", ratio)
                    .with("spacing", setting.grid.spacing)
                    .with(if coupled { "strength" } else { "contrast" }, strength);
                variant.scheme = tried.label.to_owned();
                variant.kept = RecordedOutput::Extremes;
                variants.push(variant);
            }
        }
        Ok(variants)
    }

    fn findings(&self, subject: &StudyCase, runs: &[Measured]) -> ReportContent {
        let Ok(setting) = Setting::seen(subject, runs) else {
            return ReportContent::default();
        };
        let coupled = subject.is_coupled();
        let mut section = Section::new("Maps of stability");
        section.text.extend(words(runs));
        let axis = if coupled { "strength" } else { "contrast" };
        let mut table = table(axis);
        let mut facts = Vec::new();
        let mut headlines = Vec::new();
        for tried in tried(coupled) {
            let own: Vec<&Measured> = runs
                .iter()
                .filter(|run| run.variant.scheme == tried.label)
                .collect();
            if own.is_empty() {
                continue;
            }
            let split = (tried.split)(subject);
            draw(&mut section, tried.label, axis, &own, &setting, split);
            let borders = borders(&own, axis, &setting, split);
            headlines.push(headline(tried.label, axis, &borders));
            for border in borders {
                table.rows.push(border.cells(tried.label));
                facts.push(json!({ "method": tried.label, "border": border }));
            }
        }
        section.tables.push(table);
        let classes: Vec<_> = runs
            .iter()
            .map(|run| json!({ "method": run.variant.scheme, "varied": run.variant.values, "class": Class::of(run).name() }))
            .collect();
        ReportContent {
            facts: json!({ "borders": facts, "classes": classes }),
            headlines,
            sections: vec![section],
        }
    }
}

/// What the maps show; nothing if no run says anything of stability.
fn words(runs: &[Measured]) -> Vec<String> {
    let told: Vec<&Measured> = runs.iter().filter(|run| Class::of(run).is_told()).collect();
    if told.is_empty() {
        return vec!["No run ended or became unstable, so there is no map.".to_owned()];
    }
    let points = told.iter().map(|run| run.points()).find(|n| n.is_finite());
    let points = points.map_or(String::new(), |points| format!(" on {points} points"));
    let mut words = vec![format!(
        "Every mark is a run of {STEPS} constant steps{points}; runs that were not made, refused or cut off have \
         none. Steps are counted in the stable step of forward Euler with the storage s + α²/M; dashed is where theory \
         puts the border: Fourier factors of all waves of the lattice with the operators' own symbols. Diverged means \
         that the run stopped or that its pressure or its error grew, inaccurate an error above {INACCURATE} at the \
         end. Oscillating means that the pressure, which neither grew, turned again and again from one step to the \
         next or undershot zero, by more than {OVERSHOOT}. A border is found where of two neighbouring steps one is \
         stable and one is not."
    )];
    if told.iter().all(|run| Class::error_of(run).is_nan()) {
        words.push(
            "No run has an error against an exact solution: converged means only that the pressure neither grew nor \
             oscillated."
                .to_owned(),
        );
    }
    words
}

fn table(axis: &str) -> Table {
    Table::new(
        "Border of stability by theory and as found: the smallest and the largest step of either kind in \
         each row, in units of the explicit limit",
        &[
            "method",
            axis,
            "theory",
            "runs ended",
            "found stable",
            "found unstable",
            "border",
            "cells apart",
        ],
    )
}
