//! What it costs to reach an error: the front of every method, and what errors between its runs cost.

use std::collections::BTreeMap;

use super::{Groups, Pair, pairs};
use crate::output::LinePlot;
use crate::study::chart::{Marks, legend, series};
use crate::study::findings::seconds;
use crate::study::{Measured, Section, Table, pareto, reach};

/// Runs below which a method is named beside the picture.
const FEW: usize = 4;

/// A cost that runs are compared by.
struct CostAxis {
    /// Name of its picture.
    name: &'static str,
    title: &'static str,
    axis: &'static str,
    /// What a reader gains further to the left.
    less: &'static str,
    of: fn(&Measured) -> f64,
    /// Whether repetitions are known to spread.
    ranged: bool,
}

const COSTS: [CostAxis; 3] = [
    CostAxis {
        name: "cost",
        title: "Error against wall time",
        axis: "wall time [s]",
        less: "fewer seconds",
        of: Measured::seconds,
        ranged: true,
    },
    CostAxis {
        name: "cost-cpu",
        title: "Error against processor time",
        axis: "processor time [s]",
        less: "fewer seconds of all processors",
        of: |run| run.typical(|row| row.cpu_s),
        ranged: false,
    },
    CostAxis {
        name: "cost-memory",
        title: "Error against memory",
        axis: "largest memory of the process [MB]",
        less: "less memory",
        of: |run| run.typical(|row| 1e-6 * row.memory_bytes as f64),
        ranged: false,
    },
];

/// Draws the runs of every method, with a line through its front, over each cost.
pub(super) fn draw(section: &mut Section, groups: &Groups<'_>) {
    COSTS
        .iter()
        .for_each(|cost| draw_over(cost, section, groups));
    let drawn = groups.values().any(|runs| !runs.is_empty());
    let few = groups.iter().filter(|(_, runs)| runs.len() < FEW);
    let few: Vec<String> = few
        .map(|(name, runs)| format!("{name} ({})", runs.len()))
        .collect();
    if !few.is_empty() && drawn {
        let few = few.join("; ");
        section.text.push(format!(
            "Methods with fewer than {FEW} runs that tell an error: {few}."
        ));
    }
}

fn draw_over(cost: &CostAxis, section: &mut Section, groups: &Groups<'_>) {
    let mark = |(name, runs): (&String, &Vec<&Measured>)| {
        let own: Vec<Pair> = (runs.iter())
            .map(|run| ((cost.of)(run), run.error()))
            .filter(|(cost, _)| *cost > 0.0)
            .collect();
        let front: Vec<Pair> = pareto(&own).into_iter().map(|i| own[i]).collect();
        let marks = Marks::new(name, own).through(front);
        match cost.ranged {
            true => marks.ranged(runs, |run, wall| (wall, run.error())),
            false => marks,
        }
    };
    let own = groups.iter().filter(|(_, runs)| !runs.is_empty());
    let marks: Vec<Marks> = own.map(mark).collect();
    let legend = match cost.ranged {
        true => legend(groups.values().flatten().copied()),
        false => legend([]),
    };
    section.draw(
        cost.name,
        &format!(
            "Down and left is better: less error, {}. {legend} The line of a method joins those of its runs that no other \
             of them beats in both.",
            cost.less
        ),
        &LinePlot {
            title: cost.title,
            x_label: cost.axis,
            y_label: "relative error",
            x_log: true,
            y_log: true,
            series: &series(&marks, &[]),
            note: None,
        },
    );
}

/// What it costs every method to reach an error.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct CostToReach {
    error: f64,
    cheapest: Option<String>,
    seconds: Option<f64>,
    methods: BTreeMap<String, MethodCost>,
}

/// What an error costs a method.
#[derive(Debug, Clone, serde::Serialize)]
struct MethodCost {
    /// s, by runs measured or between two of them; `None` where no run reaches the error.
    seconds: Option<f64>,
    /// Seconds and error of the most accurate run; `None` without one.
    best: Option<Pair>,
}

impl MethodCost {
    fn of(runs: &[&Measured], error: f64) -> Self {
        let own = pairs(runs);
        MethodCost {
            seconds: reach(&own, error),
            best: own.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)),
        }
    }

    /// What comes first among methods: less time, else less error.
    fn rank(&self) -> (f64, f64) {
        let seconds = self.seconds.unwrap_or(f64::INFINITY);
        (seconds, self.best.map_or(f64::INFINITY, |best| best.1))
    }

    /// In words, with how many times the cheapest that is.
    fn words(&self, cheapest: Option<f64>) -> String {
        match (self.seconds, cheapest) {
            (Some(own), Some(least)) if own > least => {
                format!("{} ({:.1}×)", seconds(own), own / least)
            }
            (Some(own), _) => seconds(own),
            _ => self
                .best
                .map_or("no error measured".to_owned(), |(wall, error)| {
                    format!("not reached (best {error:.1e} at {})", seconds(wall))
                }),
        }
    }
}

/// Errors from loose to tight with what they cost every method, as a table and as numbers.
pub(super) fn reaching(groups: &Groups<'_>, done: &[&Measured]) -> (Table, Vec<CostToReach>) {
    let least = done
        .iter()
        .map(|run| run.error())
        .fold(f64::INFINITY, f64::min);
    let most = done.iter().map(|run| run.error()).fold(0.0, f64::max);
    let decades = (-9..=0)
        .rev()
        .flat_map(|k| [3.0, 1.0].map(|m| m * 10_f64.powi(k)));
    let targets = decades.filter(|error| (0.99 * least..=most).contains(error));
    let costs: Vec<CostToReach> = targets.map(|error| cost_to_reach(groups, error)).collect();
    let mut table = Table::new(
        "Seconds to reach an error, and how many times the cheapest that is: of runs, or interpolated between two of \
         the same method",
        &["error ≤", "cheapest"],
    );
    table.head.extend(groups.keys().cloned());
    for cost in &costs {
        let mut cells = vec![format!("{:.0e}", cost.error)];
        cells.push(cost.cheapest.clone().unwrap_or_else(|| "–".to_owned()));
        let methods = cost.methods.values();
        cells.extend(methods.map(|method| method.words(cost.seconds)));
        table.rows.push(cells);
    }
    (table, costs)
}

fn cost_to_reach(groups: &Groups<'_>, error: f64) -> CostToReach {
    let methods: BTreeMap<String, MethodCost> = groups
        .iter()
        .map(|(name, runs)| (name.clone(), MethodCost::of(runs, error)))
        .collect();
    let reached = methods
        .iter()
        .filter_map(|(name, own)| Some((name, own.seconds?)));
    let best = reached.min_by(|a, b| a.1.total_cmp(&b.1));
    CostToReach {
        error,
        cheapest: best.map(|(name, _)| name.clone()),
        seconds: best.map(|(_, seconds)| seconds),
        methods,
    }
}

/// What powers of ten cost, the loosest first; other errors where no run reaches one of these.
pub(super) fn headlines(costs: &[CostToReach]) -> Vec<String> {
    let whole = |cost: &&CostToReach| {
        let decade = cost.error.log10();
        (decade - decade.round()).abs() < 1e-9
    };
    let decades: Vec<String> = costs.iter().filter(whole).filter_map(headline).collect();
    match decades.is_empty() {
        true => costs.iter().filter_map(headline).collect(),
        false => decades,
    }
}

/// What an error costs every scheme by the solver that does it best; `None` if no run reaches it.
fn headline(cost: &CostToReach) -> Option<String> {
    let cheapest = cost.seconds?;
    let mut schemes: BTreeMap<&str, &MethodCost> = BTreeMap::new();
    for (name, own) in &cost.methods {
        let scheme = name.split_once(", ").map_or(&**name, |(scheme, _)| scheme);
        let best = schemes.entry(scheme).or_insert(own);
        if own.rank() < best.rank() {
            *best = own;
        }
    }
    let mut schemes: Vec<(&str, &MethodCost)> = schemes.into_iter().collect();
    schemes.sort_by(|a, b| a.1.rank().0.total_cmp(&b.1.rank().0));
    let words = schemes.iter();
    let words: Vec<String> = words
        .map(|(scheme, own)| format!("{scheme} {}", own.words(Some(cheapest))))
        .collect();
    Some(format!("For {:.0e}: {}.", cost.error, words.join(", ")))
}
