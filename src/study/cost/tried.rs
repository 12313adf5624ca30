//! Which settings of a method were tried, and which of them its line goes through.

use super::{Groups, pairs};
use crate::study::{Measured, Section, Status, Table, pareto};

/// What stands for no setting.
const OWN: &str = "as it comes";

/// Tells the settings of every method that has several, by all its runs.
pub(super) fn tell(section: &mut Section, runs: &[Measured], groups: &Groups<'_>) {
    let mut table = Table::new(
        "Settings that were tried. One whose runs on a cloud all took longer, by more than a tenth, than a run of another \
         setting with at most 1.1 times the error was not run on finer clouds",
        &[
            "method",
            "setting",
            "runs",
            "not run, as beaten",
            "on the line",
        ],
    );
    for (method, own) in groups {
        let front = pareto(&pairs(own));
        let named = || runs.iter().filter(|run| run.variant.method() == *method);
        let mut settings: Vec<Option<&str>> = Vec::new();
        named().for_each(|run| {
            if !settings.contains(&run.variant.setting) {
                settings.push(run.variant.setting);
            }
        });
        for setting in settings.iter().filter(|_| settings.len() > 1) {
            let same = |run: &&Measured| run.variant.setting == *setting;
            let count = |wanted: Status| {
                let own = named().filter(same);
                own.filter(|run| run.first().status == wanted).count()
            };
            let chosen = front.iter().filter(|&&index| same(&own[index])).count();
            table.rows.push(vec![
                method.clone(),
                setting.unwrap_or(OWN).to_owned(),
                count(Status::Done).to_string(),
                count(Status::Beaten).to_string(),
                chosen.to_string(),
            ]);
        }
    }
    section.tables.push(table);
}
