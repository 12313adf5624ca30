//! Opening and sliding along cracks at every output, beside the exact opening.

use std::path::{Path, PathBuf};

use super::super::columns::{exact_openings, openings};
use crate::model::Model;
use crate::output::{History, LinePlot, LineStyle, OutputError, Series, lines_svg};
use crate::plan::Plan;
use crate::schemes::State;

/// Tables of all cracks of a run.
pub(super) struct Cracks {
    folder: PathBuf,
    tables: Vec<Option<History>>,
    /// Time up to which tables that are there are continued, s.
    until: Option<f64>,
    /// Distance, opening and exact opening along every crack at the last output.
    last: Vec<[Vec<f64>; 3]>,
}

impl Cracks {
    /// Tables of the cracks of `plan`, to be written into `folder`.
    pub(super) fn new(folder: &Path, plan: &Plan) -> Self {
        Cracks {
            folder: folder.to_owned(),
            tables: plan.cracks.iter().map(|_| None).collect(),
            until: None,
            last: vec![Default::default(); plan.cracks.len()],
        }
    }

    /// Goes on with tables that have rows up to a time, s, of which the last output is what will be drawn.
    ///
    /// # Errors
    /// [`OutputError`] if a table cannot be read.
    pub(super) fn resume(&mut self, plan: &Plan, until: f64) -> Result<(), OutputError> {
        self.until = Some(until);
        if !until.is_finite() {
            return Ok(());
        }
        for (crack, last) in plan.cracks.iter().zip(&mut self.last) {
            let path = self.folder.join(format!("crack-{}.csv", crack.name));
            let table = History::read(path)?;
            let rows = table.rows.iter().filter(|row| row[0] <= until);
            let time = rows.clone().next_back().map_or(f64::NAN, |row| row[0]);
            let rows: Vec<&Vec<f64>> = rows.filter(|row| row[0] >= time).collect();
            let column = |place: usize| {
                rows.iter()
                    .filter_map(|row| row.get(place).copied())
                    .collect()
            };
            *last = [column(1), column(2), column(4)];
        }
        Ok(())
    }

    /// Adds the state at an output to the tables.
    ///
    /// # Errors
    /// [`OutputError`] if a table cannot be written.
    pub(super) fn record<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        for (number, crack) in plan.cracks.iter().enumerate() {
            let mut columns = ["time_s", "distance_m", "opening_m", "sliding_m"]
                .map(str::to_owned)
                .to_vec();
            let exact = exact_openings(plan, model, state, number);
            columns.extend(exact.as_ref().map(|_| "opening_exact_m".to_owned()));
            let path = self.folder.join(format!("crack-{}.csv", crack.name));
            let table = match &mut self.tables[number] {
                Some(table) => table,
                None => {
                    let table = History::open(&path, &columns, self.until)?;
                    self.tables[number].insert(table)
                }
            };
            let jumps = openings(model, state, number);
            let distance = model.places.cracks[number]
                .iter()
                .map(|faces| faces.on.distance);
            let distance: Vec<f64> = distance.collect();
            for (k, jump) in jumps.iter().enumerate() {
                let mut row = vec![state.time, distance[k], jump[0], jump[1]];
                row.extend(exact.as_ref().map(|exact| exact[k]));
                table.append(&row)?;
            }
            let opening = jumps.iter().map(|jump| jump[0]).collect();
            self.last[number] = [distance, opening, exact.unwrap_or_default()];
        }
        Ok(())
    }

    /// Draws the openings at the last output.
    ///
    /// # Errors
    /// Those of [`lines_svg`].
    pub(super) fn draw(&self, plan: &Plan) -> Result<(), OutputError> {
        for (crack, [distance, opening, exact]) in plan.cracks.iter().zip(&self.last) {
            let line = |label, y, style| Series {
                label,
                x: distance,
                y,
                style,
            };
            let mut series = vec![line("computed", opening.as_slice(), LineStyle::Line)];
            if !exact.is_empty() {
                series.push(line("unbounded plane", exact.as_slice(), LineStyle::Dashed));
            }
            let name = &crack.name;
            let plot = LinePlot {
                title: &format!("{}: opening of {name}", plan.title),
                x_label: "distance along the crack [m]",
                y_label: "opening [m]",
                x_log: false,
                y_log: false,
                series: &series,
                note: None,
            };
            lines_svg(self.folder.join(format!("crack-{name}.svg")), &plot)?;
        }
        Ok(())
    }
}
