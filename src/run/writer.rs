//! Files of a run: fields, history, profiles, pictures, summary.

use std::path::{Path, PathBuf};

use super::Summary;
use crate::effects::vector;
use crate::geometry::Vector;
use crate::model::Model;
use crate::output::{
    Field, FieldPlot, History, LinePlot, LineStyle, OutputError, Pvd, Scale, Series, VtuData,
    field_png, lines_svg, write_atomically, write_json, write_vtu,
};
use crate::plan::{Plan, TimeMode, exact_pressure};
use crate::report::Balance;
use crate::schemes::State;

/// Writes the files of one run into its folder.
pub struct Writer {
    folder: PathBuf,
    resolved: String,
    pvd: Option<Pvd>,
    history: Option<History>,
    rows: Vec<Vec<f64>>,
    outputs: usize,
    next_row: f64,
}

/// At most this many rows of history, whatever the number of steps.
const MOST_ROWS: f64 = 2000.0;
const PICTURE_WIDTH: u32 = 900;
const MARK: &str = "resolved.toml";

impl Writer {
    /// Prepares `folder` for results and the resolved scene.
    ///
    /// A folder with other things in it is refused. Results of an earlier run stay until this one
    /// has something to write.
    ///
    /// # Errors
    /// [`OutputError`] for a folder that cannot be used.
    pub fn create(folder: &Path, resolved: &str) -> Result<Self, OutputError> {
        if prepare(folder)?.is_empty() {
            write_mark(folder, resolved)?;
        }
        Ok(Writer {
            folder: folder.to_owned(),
            resolved: resolved.to_owned(),
            pvd: None,
            history: None,
            rows: Vec::new(),
            outputs: 0,
            next_row: f64::NEG_INFINITY,
        })
    }

    /// Folder of the run.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Removes the results of an earlier run and opens history.csv.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn start_history<const D: usize>(&mut self, plan: &Plan) -> Result<(), OutputError> {
        clear(&self.folder)?;
        write_mark(&self.folder, &self.resolved)?;
        let columns = super::columns::names::<D>(plan);
        self.history = Some(History::create(self.folder.join("history.csv"), &columns)?);
        Ok(())
    }

    /// Adds a row of history; of very many steps some are left out.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn history<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
        dt: f64,
        iterations: usize,
        balance: &Balance,
    ) -> Result<(), OutputError> {
        if state.time < self.next_row && state.time < plan.time.end {
            return Ok(());
        }
        self.next_row = state.time + plan.time.end / MOST_ROWS;
        let row = super::columns::row(plan, model, state, (dt, iterations), balance);
        if let Some(history) = &mut self.history {
            history.append(&row)?;
        }
        self.rows.push(row);
        Ok(())
    }

    /// Writes the fields as VTU and PNG.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn fields<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        let number = self.outputs;
        self.outputs += 1;
        if plan.output.vtu {
            let name = format!("fields-{number:04}.vtu");
            self.vtu(&name, model, state)?;
            let pvd = match &mut self.pvd {
                Some(pvd) => pvd,
                None => self
                    .pvd
                    .insert(Pvd::create(self.folder.join("fields.pvd"))?),
            };
            pvd.add(state.time, self.folder.join(name))?;
        }
        if plan.output.plots {
            let time = (plan.time.mode == TimeMode::Transient).then_some(state.time);
            let name = format!("pressure-{number:04}.png");
            self.picture(
                &name,
                "pressure",
                "Pa",
                model,
                &state.pressure,
                time,
                Scale::Linear,
            )?;
        }
        Ok(())
    }

    fn vtu<const D: usize>(
        &self,
        name: &str,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        let velocity: Vec<f64> = model
            .flow
            .iter()
            .flat_map(|flow| flow.velocity(&state.pressure, state.time))
            .collect::<Vec<_>>()
            .iter()
            .flat_map(|v| v.iter().copied())
            .collect();
        let material: Vec<f64> = model.material.iter().map(|&m| f64::from(m)).collect();
        let field = |name, unit, components, values| Field {
            name,
            unit,
            components,
            values,
        };
        write_vtu(
            self.folder.join(name),
            &VtuData {
                positions: &model.cloud.flat_positions(),
                dimension: D,
                time: state.time,
                fields: &[
                    field("pressure", "Pa", 1, &state.pressure),
                    field("velocity", "m/s", D, &velocity),
                    field("permeability", "m^2", 1, &model.permeability),
                    field("volume", "m^D", 1, &model.cloud.volume),
                    field("material_id", "", 1, &material),
                ],
            },
        )
    }

    /// Picture of a field: the whole plane in 2-D, the middle layer of points in 3-D.
    #[expect(
        clippy::too_many_arguments,
        reason = "a picture is described by this many things"
    )]
    fn picture<const D: usize>(
        &self,
        name: &str,
        title: &str,
        unit: &str,
        model: &Model<D>,
        values: &[f64],
        time: Option<f64>,
        scale: Scale,
    ) -> Result<(), OutputError> {
        let cloud = &model.cloud;
        let shown = shown_points(model);
        let positions: Vec<f64> = shown
            .iter()
            .flat_map(|&i| [cloud.position[i][0], cloud.position[i][1]])
            .collect();
        // Squares as large as the longer edge: narrow cells of tensor grids leave no gaps.
        let sizes: Vec<f64> = shown
            .iter()
            .map(|&i| cloud.cell[i].fixed_rows::<2>(0).max())
            .collect();
        let values: Vec<f64> = shown.iter().map(|&i| values[i]).collect();
        let title = if D == 3 {
            format!("{title}, middle layer")
        } else {
            title.to_owned()
        };
        field_png(
            self.folder.join(name),
            &FieldPlot {
                title: &title,
                unit,
                positions: &positions,
                dimension: 2,
                sizes: &sizes,
                values: &values,
                time,
                scale,
                range: None,
                width_px: PICTURE_WIDTH,
            },
        )
    }

    /// Draws what needs the whole run: permeability, error map, histories and profiles.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn finish<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        self.profiles(plan, model, state)?;
        if !plan.output.plots {
            return Ok(());
        }
        self.permeability(model)?;
        self.history_plots(plan)
    }

    fn permeability<const D: usize>(&self, model: &Model<D>) -> Result<(), OutputError> {
        let (low, high) = model
            .permeability
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), &k| {
                (low.min(k), high.max(k))
            });
        if high <= low * (1.0 + 1e-12) {
            return Ok(());
        }
        let scale = if high > 30.0 * low {
            Scale::Log10
        } else {
            Scale::Linear
        };
        let values = &model.permeability;
        self.picture(
            "permeability.png",
            "permeability",
            "m²",
            model,
            values,
            None,
            scale,
        )
    }

    fn history_plots(&self, plan: &Plan) -> Result<(), OutputError> {
        if plan.time.mode == TimeMode::Steady || self.rows.len() < 2 {
            return Ok(());
        }
        let column =
            |index: usize| -> Vec<f64> { self.rows.iter().map(|row| row[index]).collect() };
        let time = column(0);
        let first = 5;
        let data: Vec<Vec<f64>> = match plan.output.probes.len() {
            0 => vec![column(3), column(4)],
            probes => (first..first + probes).map(column).collect(),
        };
        let labels: Vec<String> = match plan.output.probes.len() {
            0 => vec!["smallest".to_owned(), "largest".to_owned()],
            _ => plan
                .output
                .probes
                .iter()
                .map(|probe| probe.name.clone())
                .collect(),
        };
        lines_svg(
            self.folder.join("history-pressure.svg"),
            &LinePlot {
                title: &format!("{}: pressure over time", plan.title),
                x_label: "time [s]",
                y_label: "pressure [Pa]",
                x_log: false,
                y_log: false,
                series: &series(&labels, &time, &data),
                note: None,
            },
        )?;
        let steps = [column(1)[1..].to_vec()];
        lines_svg(
            self.folder.join("history-step.svg"),
            &LinePlot {
                title: &format!("{}: time step", plan.title),
                x_label: "time [s]",
                y_label: "Δt [s]",
                x_log: true,
                y_log: true,
                series: &series(&["Δt".to_owned()], &time[1..], &steps),
                note: None,
            },
        )
    }

    fn profiles<const D: usize>(
        &self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        let exact = exact_pressure(plan).ok().flatten();
        let steady = plan.time.mode == TimeMode::Steady;
        let time = if steady { f64::INFINITY } else { state.time };
        for profile in &plan.output.profiles {
            let (from, to) = (vector::<D>(&profile.from), vector::<D>(&profile.to));
            let places: Vec<Vector<D>> = (0..profile.points)
                .map(|k| from + (to - from) * (k as f64 / (profile.points.max(2) - 1) as f64))
                .collect();
            let distance: Vec<f64> = places.iter().map(|x| (x - from).norm()).collect();
            let computed: Vec<f64> = places
                .iter()
                .map(|x| {
                    model
                        .flow
                        .as_ref()
                        .map_or(0.0, |flow| flow.pressure_at(&state.pressure, state.time, x))
                })
                .collect();
            let reference: Option<Vec<f64>> = exact.as_ref().map(|exact| {
                places
                    .iter()
                    .map(|x| finite(exact.pressure(x.as_slice(), time)))
                    .collect()
            });
            self.profile_table(&profile.name, &distance, &computed, reference.as_deref())?;
            if plan.output.plots {
                let title = format!("{}: pressure along {}", plan.title, profile.name);
                self.profile_plot(
                    &profile.name,
                    &title,
                    &distance,
                    &computed,
                    reference.as_deref(),
                )?;
            }
        }
        Ok(())
    }

    fn profile_table(
        &self,
        name: &str,
        distance: &[f64],
        computed: &[f64],
        exact: Option<&[f64]>,
    ) -> Result<(), OutputError> {
        let mut columns = vec!["distance_m".to_owned(), "pressure_Pa".to_owned()];
        columns.extend(exact.map(|_| "pressure_exact_Pa".to_owned()));
        let path = self.folder.join(format!("profile-{name}.csv"));
        let mut table = History::create(path, &columns)?;
        for k in 0..distance.len() {
            let mut row = vec![distance[k], computed[k]];
            row.extend(exact.map(|exact| exact[k]));
            table.append(&row)?;
        }
        Ok(())
    }

    fn profile_plot(
        &self,
        name: &str,
        title: &str,
        distance: &[f64],
        computed: &[f64],
        exact: Option<&[f64]>,
    ) -> Result<(), OutputError> {
        let line = |label, y, style| Series {
            label,
            x: distance,
            y,
            style,
        };
        let mut series = vec![line("computed", computed, LineStyle::Line)];
        series.extend(exact.map(|y| line("exact", y, LineStyle::Dashed)));
        lines_svg(
            self.folder.join(format!("profile-{name}.svg")),
            &LinePlot {
                title,
                x_label: "distance [m]",
                y_label: "pressure [Pa]",
                x_log: false,
                y_log: false,
                series: &series,
                note: None,
            },
        )
    }

    /// Writes summary.json.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn summary(&self, summary: &Summary) -> Result<(), OutputError> {
        write_json(self.folder.join("summary.json"), summary)
    }
}

/// Values beyond all numbers, as exact solutions have at wells, leave a gap in a drawing.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

fn series<'a>(labels: &'a [String], x: &'a [f64], data: &'a [Vec<f64>]) -> Vec<Series<'a>> {
    let line = |(label, y): (&'a String, &'a Vec<f64>)| Series {
        label,
        x,
        y,
        style: LineStyle::Line,
    };
    labels.iter().zip(data).map(line).collect()
}

/// All points in 2-D; in 3-D those of the layer nearest to the middle of the domain.
fn shown_points<const D: usize>(model: &Model<D>) -> Vec<usize> {
    let cloud = &model.cloud;
    if D == 2 {
        return (0..cloud.len()).collect();
    }
    let middle = 0.5 * (cloud.domain.lower[2] + cloud.domain.upper[2]);
    let within = |&i: &usize| (cloud.position[i][2] - middle).abs() <= 0.5001 * cloud.cell[i][2];
    let near: Vec<usize> = (0..cloud.len()).filter(within).collect();
    // An even number of layers has two beside the middle; one is enough.
    let lowest = near
        .iter()
        .map(|&i| cloud.position[i][2])
        .fold(f64::INFINITY, f64::min);
    near.into_iter()
        .filter(|&i| cloud.position[i][2] < lowest + 0.25 * cloud.cell[i][2])
        .collect()
}

/// Makes the folder if need be; gives what is in it, which must be results.
fn prepare(folder: &Path) -> Result<Vec<PathBuf>, OutputError> {
    let io = |source: std::io::Error| OutputError::from_io(folder, "prepare the folder", source);
    if !folder.exists() {
        std::fs::create_dir_all(folder).map_err(io)?;
    }
    let entries: Vec<PathBuf> = std::fs::read_dir(folder)
        .and_then(|entries| entries.map(|entry| entry.map(|e| e.path())).collect())
        .map_err(io)?;
    if !entries.is_empty() && !folder.join(MARK).exists() {
        return Err(OutputError::Foreign {
            path: folder.to_owned(),
        });
    }
    Ok(entries)
}

/// Removes the results of an earlier run; the mark is replaced afterwards.
fn clear(folder: &Path) -> Result<(), OutputError> {
    let io = |source: std::io::Error| OutputError::from_io(folder, "prepare the folder", source);
    for path in prepare(folder)?.iter().filter(|path| is_result(path)) {
        std::fs::remove_file(path).map_err(io)?;
    }
    Ok(())
}

/// Writes the resolved scene, which also marks the folder as one of results.
fn write_mark(folder: &Path, resolved: &str) -> Result<(), OutputError> {
    write_atomically(folder.join(MARK), |file| {
        file.write_all(resolved.as_bytes())
    })
}

fn is_result(path: &Path) -> bool {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    let own = [
        "fields",
        "pressure-",
        "permeability",
        "history",
        "profile-",
        "summary.json",
    ];
    path.is_file() && own.iter().any(|start| name.starts_with(start))
}
