//! Profiles: fields along lines at every output after the start, beside the exact solution.

use std::path::{Path, PathBuf};

use super::super::columns::AXES;
use crate::effects::vector;
use crate::geometry::{Stencil, Vector};
use crate::model::Model;
use crate::output::{
    History, LinePlot, LineStyle, OutputError, Series, Table, lines_svg, plots::readable_time,
};
use crate::plan::{Plan, TimeMode, exact_displacement, exact_pressure};
use crate::reference::{ExactDisplacement, ExactPressure};
use crate::schemes::State;

/// Most times in one drawing.
const MOST_CURVES: usize = 5;

/// All profiles of a run.
pub(super) struct Profiles {
    folder: PathBuf,
    exact: Exact,
    lines: Vec<Line>,
    /// Outputs after the start, and how many of them have been.
    outputs: usize,
    seen: usize,
    /// Time up to which tables that are there are continued, s.
    until: Option<f64>,
}

/// What the plan knows exactly.
struct Exact {
    pressure: Option<Box<dyn ExactPressure>>,
    displacement: Option<Box<dyn ExactDisplacement>>,
}

/// One line with its table, and what of it will be drawn.
#[derive(Default)]
struct Line {
    table: Option<History>,
    distance: Vec<f64>,
    drawn: Vec<(f64, Vec<Values>)>,
}

/// One scalar along a line at one time.
struct Values {
    /// Such as `pressure` or `displacement_x`.
    name: String,
    unit: &'static str,
    computed: Vec<f64>,
    exact: Option<Vec<f64>>,
}

impl Profiles {
    /// Profiles that `plan` asks for, to be written into `folder`.
    pub(super) fn new(folder: &Path, plan: &Plan) -> Self {
        let lines = plan.output.profiles.iter().map(|_| Line::default());
        Profiles {
            folder: folder.to_owned(),
            exact: Exact {
                pressure: exact_pressure(plan).ok().flatten(),
                displacement: exact_displacement(plan).ok().flatten(),
            },
            lines: lines.collect(),
            outputs: outputs(plan),
            seen: 0,
            until: None,
        }
    }

    /// Goes on with tables of `seen` outputs up to the time `until` (s), and with what of them is drawn.
    ///
    /// # Errors
    /// [`OutputError`] if a table cannot be read.
    pub(super) fn resume(
        &mut self,
        plan: &Plan,
        seen: usize,
        until: f64,
    ) -> Result<(), OutputError> {
        (self.seen, self.until) = (seen, Some(until));
        let drawn = |number: &usize| plan.output.plots && self.is_drawn(*number);
        let drawn: Vec<usize> = (1..=seen).filter(drawn).collect();
        for (line, profile) in self.lines.iter_mut().zip(&plan.output.profiles) {
            if seen > 0 {
                let path = self.folder.join(format!("profile-{}.csv", profile.name));
                line.recover(&History::read(path)?, &drawn);
            }
        }
        Ok(())
    }

    /// How many outputs after the start have been.
    pub(super) fn seen(&self) -> usize {
        self.seen
    }

    /// Whether the output of a number, from 1, is among those that are drawn.
    fn is_drawn(&self, number: usize) -> bool {
        let share = |seen: usize| seen * MOST_CURVES.min(self.outputs) / self.outputs;
        share(number) > share(number - 1)
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
        if plan.time.mode == TimeMode::Transient && state.time <= plan.time.start {
            return Ok(());
        }
        self.seen += 1;
        let drawn = plan.output.plots && self.is_drawn(self.seen);
        let until = self.until;
        let exact_time = self.exact_time(plan, state);
        let profiles = plan.output.profiles.iter().zip(&model.places.profiles);
        for (line, (profile, places)) in self.lines.iter_mut().zip(profiles) {
            let from = vector::<D>(&profile.from);
            line.distance = places.iter().map(|x| (x.at - from).norm()).collect();
            let values = along(model, state, &self.exact, exact_time, places);
            let path = self.folder.join(format!("profile-{}.csv", profile.name));
            line.write(&path, until, state.time, &values)?;
            if drawn {
                line.drawn.push((state.time, values));
            }
        }
        Ok(())
    }

    /// Time at which the exact solution is comparable, if it is: one that is steady only, at the end; none once a limit of a well was
    /// met.
    fn exact_time(&self, plan: &Plan, state: &State) -> Option<f64> {
        if plan.time.mode == TimeMode::Steady {
            return Some(f64::INFINITY);
        }
        let pressure = self.exact.pressure.as_ref();
        let steady_only = pressure.is_some_and(|exact| exact.steady_only());
        let comparable = !steady_only || self.seen == self.outputs;
        (comparable && state.is_unlimited()).then_some(state.time)
    }

    /// Draws the profiles, one drawing per field.
    ///
    /// # Errors
    /// Those of [`lines_svg`].
    pub(super) fn draw(&self, plan: &Plan) -> Result<(), OutputError> {
        for (line, profile) in self.lines.iter().zip(&plan.output.profiles) {
            let name = &profile.name;
            line.draw(&self.folder, plan, name, "pressure", "")?;
            if let Some(component) = line.largest_displacement() {
                line.draw(&self.folder, plan, name, &component, "-displacement")?;
            }
        }
        Ok(())
    }
}

/// Number of outputs after the start.
fn outputs(plan: &Plan) -> usize {
    let (start, end) = (plan.time.start, plan.time.end);
    let before = |time: &&f64| **time > start + 1e-12 * end && **time < end * (1.0 - 1e-12);
    let mut times: Vec<f64> = plan.output.times.iter().filter(before).copied().collect();
    times.sort_unstable_by(f64::total_cmp);
    times.dedup_by(|b, a| *b - *a <= 1e-12 * end);
    times.len() + 1
}

/// All fields at the places; exact values are gaps where there is no time to compare at.
fn along<const D: usize>(
    model: &Model<D>,
    state: &State,
    exact: &Exact,
    time: Option<f64>,
    places: &[Stencil<D>],
) -> Vec<Values> {
    let mut all = Vec::new();
    if let Some(flow) = &model.flow {
        let known = |exact: &dyn ExactPressure, x: &Vector<D>| match time {
            Some(time) => finite(exact.pressure(x.as_slice(), time)),
            None => f64::NAN,
        };
        let exact = exact.pressure.as_deref();
        all.push(Values {
            name: "pressure".to_owned(),
            unit: "Pa",
            computed: flow.pressures_at(&state.pressure, state.time, places),
            exact: exact.map(|exact| places.iter().map(|x| known(exact, &x.at)).collect()),
        });
    }
    if let Some(solid) = &model.solid {
        let (displacement, walls) = (state.shown_displacement(), state.shown_walls());
        let computed = solid.displacements_at(&displacement, &walls, places);
        let known = |exact: &dyn ExactDisplacement, x: &Vector<D>| match time {
            Some(time) => vector::<D>(&exact.displacement(x.as_slice(), time)),
            None => Vector::repeat(f64::NAN),
        };
        let exact = exact.displacement.as_deref();
        let exact: Option<Vec<Vector<D>>> =
            exact.map(|exact| places.iter().map(|x| known(exact, &x.at)).collect());
        all.extend((0..D).map(|axis| {
            Values {
                name: format!("displacement_{}", AXES[axis]),
                unit: "m",
                computed: computed.iter().map(|u| u[axis]).collect(),
                exact: exact
                    .as_ref()
                    .map(|exact| exact.iter().map(|u| finite(u[axis])).collect()),
            }
        }));
    }
    all
}

/// Values beyond all numbers, as exact solutions have at wells, leave a gap in a drawing.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

impl Line {
    /// Takes the places and what is drawn of a table from it: the outputs of some numbers, from 1.
    fn recover(&mut self, table: &Table, drawn: &[usize]) {
        let mut outputs: Vec<Vec<&Vec<f64>>> = Vec::new();
        for row in &table.rows {
            match outputs.last_mut() {
                Some(rows) if rows[0][0].to_bits() == row[0].to_bits() => rows.push(row),
                _ => outputs.push(vec![row]),
            }
        }
        // A run that has all of its outputs writes no more, and draws over these.
        let places = outputs.first().into_iter().flatten();
        self.distance = places.filter_map(|row| row.get(1).copied()).collect();
        let known = drawn.iter().filter_map(|number| outputs.get(number - 1));
        self.drawn = known
            .map(|rows| (rows[0][0], values_of(&table.columns, rows)))
            .collect();
    }

    /// Adds one row per place.
    fn write(
        &mut self,
        path: &Path,
        until: Option<f64>,
        time: f64,
        values: &[Values],
    ) -> Result<(), OutputError> {
        let table = match &mut self.table {
            Some(table) => table,
            None => self
                .table
                .insert(History::open(path, &headings(values), until)?),
        };
        for (k, distance) in self.distance.iter().enumerate() {
            let mut row = vec![time, *distance];
            for values in values {
                row.push(values.computed[k]);
                row.extend(values.exact.as_ref().map(|exact| exact[k]));
            }
            table.append(&row)?;
        }
        Ok(())
    }

    /// Component of the displacement that is largest over all drawn times.
    fn largest_displacement(&self) -> Option<String> {
        let components = self.drawn.iter().flat_map(|(_, values)| values);
        let size = |values: &Values| values.computed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        components
            .filter(|values| values.name.starts_with("displacement"))
            .map(|values| (&values.name, size(values)))
            .reduce(|most, next| if next.1 > most.1 { next } else { most })
            .map(|(name, _)| name.clone())
    }

    /// Draws one of the values over the distance, one curve per time and dashed ones for the exact
    /// solution.
    fn draw(
        &self,
        folder: &Path,
        plan: &Plan,
        profile: &str,
        name: &str,
        ending: &str,
    ) -> Result<(), OutputError> {
        let shown: Vec<(String, &Values)> = self
            .drawn
            .iter()
            .flat_map(|(time, values)| {
                let label = format!("t = {}", readable_time(*time));
                let values = values.iter().find(|values| values.name == name)?;
                Some((label, values))
            })
            .collect();
        let Some((_, Values { unit, .. })) = shown.first() else {
            return Ok(());
        };
        let line = |label, y, style| Series {
            label,
            x: &self.distance,
            y,
            style,
        };
        let computed = shown.iter().map(|(time, values)| {
            let label = if shown.len() > 1 { time } else { "computed" };
            line(label, &values.computed, LineStyle::Line)
        });
        let exact = shown.iter().filter_map(|(_, values)| values.exact.as_ref());
        let exact = exact.filter(|values| values.iter().any(|v| v.is_finite()));
        // Without labels all but the first look like it.
        let labels = std::iter::once("exact").chain(std::iter::repeat(""));
        let exact = exact
            .zip(labels)
            .map(|(y, label)| line(label, y, LineStyle::Dashed));
        let quantity = match name.strip_prefix("displacement_") {
            Some(axis) => format!("{axis}-displacement"),
            None => name.to_owned(),
        };
        let plot = LinePlot {
            title: &format!("{}: {quantity} along {profile}", plan.title),
            x_label: "distance [m]",
            y_label: &format!("{quantity} [{unit}]"),
            x_log: false,
            y_log: false,
            series: &computed.chain(exact).collect::<Vec<_>>(),
            note: None,
        };
        lines_svg(folder.join(format!("profile-{profile}{ending}.svg")), &plot)
    }
}

/// Values under the headings of a table.
fn values_of(columns: &[String], rows: &[&Vec<f64>]) -> Vec<Values> {
    let mut all: Vec<Values> = Vec::new();
    for (k, column) in columns.iter().enumerate().skip(2) {
        let numbers = rows.iter().map(|row| row[k]).collect();
        let (name, unit) = column.rsplit_once('_').unwrap_or((column, ""));
        match (name.strip_suffix("_exact"), all.last_mut()) {
            (Some(_), Some(computed)) => computed.exact = Some(numbers),
            _ => all.push(Values {
                name: name.to_owned(),
                unit: if unit == "Pa" { "Pa" } else { "m" },
                computed: numbers,
                exact: None,
            }),
        }
    }
    all
}

/// Headings of the table: `time_s`, `distance_m`, then every value with the exact one after it.
fn headings(values: &[Values]) -> Vec<String> {
    let mut columns = vec!["time_s".to_owned(), "distance_m".to_owned()];
    for Values {
        name, unit, exact, ..
    } in values
    {
        columns.push(format!("{name}_{unit}"));
        columns.extend(exact.as_ref().map(|_| format!("{name}_exact_{unit}")));
    }
    columns
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn a_line_that_goes_on_knows_its_places_before_it_writes_again() {
        let columns = ["time_s", "distance_m", "pressure_Pa"].map(str::to_owned);
        let table = Table {
            columns: columns.to_vec(),
            rows: vec![
                vec![1.0, 0.0, 5.0],
                vec![1.0, 0.5, 6.0],
                vec![2.0, 0.0, 7.0],
                vec![2.0, 0.5, 8.0],
            ],
        };
        let mut line = Line::default();
        line.recover(&table, &[2]);
        assert_eq!(line.distance, [0.0, 0.5]);
        assert_eq!(line.drawn.len(), 1);
        assert_eq!(line.drawn[0].1[0].computed, [7.0, 8.0]);
    }
}
