//! Orders that errors over steps or spacings show, with their picture and their table.

use crate::output::LinePlot;
use crate::study::chart::{self, Marks, series};
use crate::study::findings::{count, short};
use crate::study::{Fit, Section, Table};

/// Orders in space or in time.
pub(super) struct Orders {
    pub section: Section,
    pub laws: Vec<Law>,
    /// Why there is no order, or how far those there are may be trusted.
    pub remark: Option<String>,
}

impl Orders {
    pub(super) fn without(mut section: Section, reason: String) -> Self {
        section.text.push(reason.clone());
        Orders {
            section,
            laws: Vec::new(),
            remark: Some(reason),
        }
    }

    pub(super) fn headlines(&self) -> Vec<String> {
        let laws = self.laws.iter().map(Law::line);
        laws.chain(self.remark.clone()).collect()
    }
}

/// Errors over steps or spacings, and the order seen in them.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Law {
    method: String,
    field: String,
    what: &'static str,
    /// `None` from fewer than three runs.
    fit: Option<Fit>,
    theory: f64,
    pairs: Vec<(f64, f64)>,
}

impl Law {
    /// From all pairs that tell the error, the coarsest first.
    pub(super) fn of(
        (method, field): (&str, &str),
        (what, theory): (&'static str, f64),
        pairs: Vec<(f64, f64)>,
    ) -> Self {
        Law {
            method: method.to_owned(),
            field: field.to_owned(),
            what,
            fit: Fit::confident(asymptotic(&pairs)),
            theory,
            pairs,
        }
    }

    fn line(&self) -> String {
        let Law {
            method,
            field,
            what,
            fit,
            theory,
            pairs,
        } = self;
        match fit {
            Some(fit) => {
                format!("{method}: {field} is of order {fit} in {what} (theory {theory:.0}).")
            }
            None => format!(
                "{method}: no order of {field} in {what}; {} runs tell its error, it takes three{}.",
                pairs.len(),
                match *what {
                    "space" => " (--points names more clouds)",
                    _ => "",
                }
            ),
        }
    }

    fn cells(&self) -> Vec<String> {
        let used = asymptotic(&self.pairs).len();
        vec![
            self.method.clone(),
            self.field.clone(),
            self.fit.map_or("–".to_owned(), |fit| fit.to_string()),
            format!("{:.0}", self.theory),
            count(used as f64),
            self.pairs
                .last()
                .map_or("–".to_owned(), |pair| short(pair.1)),
        ]
    }
}

const HEAD: [&str; 6] = [
    "method",
    "field",
    "order seen",
    "theory",
    "runs",
    "error of the finest",
];

/// The four finest: the coarsest runs are not yet where the leading term of the error rules.
fn asymptotic(pairs: &[(f64, f64)]) -> &[(f64, f64)] {
    &pairs[pairs.len().saturating_sub(4)..]
}

/// Draws the errors and puts the orders into a table.
pub(super) fn finish(orders: &mut Orders, (file, title, x_label): (&str, &str, &str)) {
    let Orders { section, laws, .. } = orders;
    let mut table = Table::new(
        "Orders with their 95 % confidence over the finest runs, from three to four",
        &HEAD,
    );
    table.rows.extend(laws.iter().map(Law::cells));
    let told = laws.iter().filter(|law| !law.pairs.is_empty());
    let marks: Vec<Marks> = told
        .map(|law| {
            let label = format!("{}, {}", law.method, law.field);
            Marks::joined(&label, law.pairs.iter().copied())
        })
        .collect();
    section.draw(
        file,
        "A mark per run; straight in logarithms, as steep as the order. Dashed: the slopes of theory over the same \
         range.",
        &LinePlot {
            title,
            x_label,
            y_label: "relative error",
            x_log: true,
            y_log: true,
            series: &series(&marks, &guides(laws)),
            note: None,
        },
    );
    section.tables.push(table);
}

/// Lines of the orders of theory, just below the lowest curve that should follow them.
fn guides(laws: &[Law]) -> Vec<chart::Law> {
    let mut guides = Vec::new();
    for theory in [1.0_f64, 2.0] {
        let own = laws.iter().filter(|law| (law.theory - theory).abs() < 0.5);
        let pairs: Vec<(f64, f64)> = own.flat_map(|law| law.pairs.iter().copied()).collect();
        let factor = pairs
            .iter()
            .map(|(x, y)| y / x.powf(theory))
            .fold(f64::INFINITY, f64::min);
        let least = pairs
            .iter()
            .map(|pair| pair.0)
            .fold(f64::INFINITY, f64::min);
        let most = pairs.iter().map(|pair| pair.0).fold(0.0, f64::max);
        if most > least {
            let line = [least, most].map(|x: f64| (x, 0.7 * factor * x.powf(theory)));
            guides.push(chart::Law::new(&format!("theory: order {theory:.0}"), line));
        }
    }
    guides
}
