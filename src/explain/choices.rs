//! What to choose for which problem: one table, which `perifrac plan --choices` prints and the book holds.

use std::fmt::{self, Write};

use serde::Serialize;

use crate::plan::{DamageModel, Plan, TimeMode};

/// What to choose for a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// The problem.
    pub problem: &'static str,
    /// `flow.operator`.
    pub operator: &'static str,
    /// `[horizon]`.
    pub horizon: &'static str,
    /// `damage.length_scale`.
    pub length_scale: &'static str,
    /// `scheme.name`.
    pub scheme: &'static str,
    /// `solver.name`.
    pub solver: &'static str,
    /// `[time]`.
    pub time: &'static str,
}

/// Where there is nothing to choose.
const NONE: &str = "–";
/// Where the default is right.
const LEAVE: &str = "leave";
/// The horizon of the split model, which no key needs to ask for.
const ROUND: &str = "leave (2.3 spacings)";
/// The horizon of the model of the paper.
const HALF: &str = "`length_scale_ratio = 0.5`";
/// Its length scale.
const RESOLVED: &str = "4 spacings or more";
/// Steps where rock breaks.
const BREAKING: &str = "`first_step`, `max_step`; cut where damage grows";
/// Steps where fluid is pumped into cracks.
const PUMPING: &str = "`first_step`, `max_step`, tolerance 1e-2 … 0.1";

/// Flow alone, in time.
const FLOW: Choice = Choice {
    problem: "flow alone",
    operator: "leave (`path`)",
    horizon: LEAVE,
    length_scale: NONE,
    scheme: "leave (`implicit`)",
    solver: "`auto`",
    time: "`time.tolerance` 1e-4 … 1e-5",
};
const STEADY_FLOW: Choice = Choice {
    problem: "flow, only the end state",
    operator: LEAVE,
    scheme: LEAVE,
    time: "`time.mode = \"steady\"`",
    ..FLOW
};
const DEFORMATION: Choice = Choice {
    problem: "deformation alone",
    operator: NONE,
    scheme: LEAVE,
    time: "steady, or a fixed `step` per load",
    ..FLOW
};
const CONSOLIDATION: Choice = Choice {
    problem: "consolidation",
    operator: LEAVE,
    scheme: "`monolithic`, or `staggered` if the matrix is too large",
    time: "tolerance 1e-3",
    ..FLOW
};
const WAVES: Choice = Choice {
    problem: "waves, impact",
    operator: NONE,
    scheme: "`explicit`, `mechanics.mode = \"dynamic\"`",
    solver: "none",
    time: "the stability limit",
    ..FLOW
};
const BREAKS: Choice = Choice {
    problem: "rock that breaks",
    horizon: ROUND,
    length_scale: "leave",
    time: BREAKING,
    ..DEFORMATION
};
const BREAKS_AS_IN_THE_PAPER: Choice = Choice {
    problem: "rock that breaks, model of the paper",
    horizon: HALF,
    length_scale: RESOLVED,
    ..BREAKS
};
const INJECTION: Choice = Choice {
    problem: "injection",
    operator: LEAVE,
    scheme: "`monolithic`",
    time: PUMPING,
    ..BREAKS
};
const INJECTION_AS_IN_THE_PAPER: Choice = Choice {
    problem: "injection, model of the paper",
    operator: "leave (`bond`)",
    horizon: HALF,
    length_scale: RESOLVED,
    ..INJECTION
};

/// All problems, the simple ones first.
pub const CHOICES: [Choice; 9] = [
    FLOW,
    STEADY_FLOW,
    DEFORMATION,
    CONSOLIDATION,
    WAVES,
    BREAKS,
    BREAKS_AS_IN_THE_PAPER,
    INJECTION,
    INJECTION_AS_IN_THE_PAPER,
];

/// The row for a plan: that of the hardest thing it does.
pub fn choice(plan: &Plan) -> Choice {
    let inertia = plan.mechanics.as_ref().is_some_and(|own| own.inertia);
    let in_paper = |damage: DamageModel| damage == DamageModel::Paper;
    let model = plan.damage.as_ref().map(|own| in_paper(own.model));
    match (plan.fracture_flow.is_some(), model) {
        (true, Some(true)) => INJECTION_AS_IN_THE_PAPER,
        (true, _) => INJECTION,
        (false, Some(true)) => BREAKS_AS_IN_THE_PAPER,
        (false, Some(false)) => BREAKS,
        _ if inertia => WAVES,
        _ if plan.flow.is_none() => DEFORMATION,
        _ if plan.mechanics.is_some() => CONSOLIDATION,
        _ if plan.time.mode == TimeMode::Steady => STEADY_FLOW,
        _ => FLOW,
    }
}

/// The whole table with the row of a plan; printed as text or JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Choices {
    /// Name of the case.
    pub case: String,
    /// The problem whose row applies.
    pub applies: &'static str,
    /// All rows.
    pub choices: [Choice; CHOICES.len()],
}

impl Choices {
    /// The table for a plan.
    pub fn of(plan: &Plan) -> Self {
        Choices {
            case: plan.case.clone(),
            applies: choice(plan).problem,
            choices: CHOICES,
        }
    }
}

/// The cells of a row.
fn cells(row: &Choice) -> [&'static str; 7] {
    [
        row.problem,
        row.operator,
        row.horizon,
        row.length_scale,
        row.scheme,
        row.solver,
        row.time,
    ]
}

const HEAD: [&str; 7] = [
    "problem",
    "operator",
    "horizon",
    "length scale",
    "scheme",
    "solver",
    "time",
];

impl fmt::Display for Choices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let widths: Vec<usize> = (0..HEAD.len())
            .map(|k| {
                let cells = self.choices.iter().map(|row| cells(row)[k]);
                let all = cells.chain([HEAD[k]]).map(|cell| cell.chars().count());
                all.max().unwrap_or(0)
            })
            .collect();
        let line = |mark: &str, cells: [&str; 7]| {
            let mut text = mark.to_owned();
            for (cell, width) in cells.iter().zip(&widths) {
                // Writing into a text cannot fail.
                let _ = write!(text, " | {cell:width$}");
            }
            text.trim_end().to_owned()
        };
        writeln!(f, "{}: {} (marked >)", self.case, self.applies)?;
        writeln!(f, "{}", line(" ", HEAD))?;
        for row in &self.choices {
            let mark = if row.problem == self.applies {
                ">"
            } else {
                " "
            };
            writeln!(f, "{}", line(mark, cells(row)))?;
        }
        Ok(())
    }
}
