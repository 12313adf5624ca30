//! Files of a run: fields, history, profiles, pictures, summary.

mod crack_lines;
mod cracks;
mod fields;
mod folder;
mod fracture;
mod grid;
mod histories;
mod pace;
mod pictures;
mod profiles;
mod restart;
mod sections;
mod setup;
mod space;
mod staged;

use std::path::{Path, PathBuf};

use super::Summary;
use super::fracture::{CrackTracker, Fractures};
use super::rejections::Rejections;
use super::tables::{WrittenColumn, written};
use crate::model::Model;
use crate::output::{DRAWS, History, OutputError, Pvd, Table, write_json};
use crate::plan::{Plan, TimeMode};
use crate::report::Balance;
use crate::schemes::{State, StepReport};
use crack_lines::CrackLines;
use cracks::Cracks;
use fields::Snapshot;
pub(super) use fields::values as field_values;
use folder::Hold;
use grid::Grid;
use pace::Pace;
use pictures::Pictures;
use profiles::Profiles;
pub(super) use restart::WriterRecord;
use sections::Sections;
pub use staged::StagedFolder;

/// Writes the files of one run into its folder.
pub struct Writer {
    folder: PathBuf,
    hold: Hold,
    resolved: String,
    /// Points and cells of the files of fields, from the first one on.
    grid: Option<Grid>,
    pvd: Option<Pvd>,
    history: Option<History>,
    /// What history.csv holds.
    rows: Table,
    profiles: Option<Profiles>,
    cracks: Option<Cracks>,
    /// Lines of the cracks, from the first output on.
    crack_lines: Option<CrackLines>,
    /// What pictures show, from the first output on.
    sections: Option<Sections>,
    /// When outputs are drawn before the run ends.
    pace: Pace,
    outputs: usize,
    /// Accepted states so far, the first one included, and of how many one has a row.
    seen: u64,
    stride: u64,
    most_rows: usize,
    /// Whether this is the process that writes what there is once.
    leads: bool,
}

/// Most rows of history: some ten megabytes of text, which every spreadsheet opens.
pub(super) const MOST_ROWS: usize = 100_000;

impl Writer {
    /// Prepares `folder` for results and the resolved scene.
    ///
    /// A folder with other things in it, or into which another run writes, is refused. Results of an
    /// earlier run stay until this one has something to write; then those files are removed that runs
    /// wrote and nobody changed since.
    ///
    /// # Errors
    /// [`OutputError`] for a folder that cannot be used.
    pub fn create(folder: &Path, resolved: &str) -> Result<Self, OutputError> {
        Ok(Writer {
            leads: true,
            hold: Hold::take(folder, resolved)?,
            ..Self::follow(folder, resolved)
        })
    }

    /// The writer of a further process of a run, which adds its piece of the fields only.
    pub fn follow(folder: &Path, resolved: &str) -> Self {
        Writer {
            folder: folder.to_owned(),
            hold: Hold::follow(folder),
            resolved: resolved.to_owned(),
            grid: None,
            pvd: None,
            history: None,
            rows: Table::default(),
            profiles: None,
            cracks: None,
            crack_lines: None,
            sections: None,
            pace: Pace::default(),
            outputs: 0,
            seen: 0,
            stride: 1,
            most_rows: MOST_ROWS,
            leads: false,
        }
    }

    /// Files of the user that stood where the run wrote one of its own, by their new names.
    pub fn kept(&self) -> Vec<PathBuf> {
        self.hold.kept()
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
        if !self.leads {
            return Ok(());
        }
        self.hold.begin(&self.resolved)?;
        self.rows.columns = super::columns::names::<D>(plan);
        let path = self.folder.join("history.csv");
        self.history = Some(History::create(path, &self.rows.columns)?);
        self.profiles = Some(Profiles::new(&self.folder, plan));
        self.cracks = Some(Cracks::new(&self.folder, plan));
        Ok(())
    }

    /// Adds a row of history; of more than `MOST_ROWS` steps rows are left out evenly.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn history<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
        step: (f64, &StepReport, Rejections),
        balance: &Balance,
        fractures: Option<&Fractures>,
    ) -> Result<(), OutputError> {
        if !self.leads {
            return Ok(());
        }
        let last = plan.time.mode == TimeMode::Transient && state.time >= plan.time.end;
        let kept = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
        if !kept && !last {
            return Ok(());
        }
        let row = super::columns::row(plan, model, state, step, balance, fractures);
        if let Some(history) = &mut self.history {
            history.append(&row)?;
        }
        self.rows.rows.push(row);
        match self.rows.rows.len() > self.most_rows {
            true => self.thin(),
            false => Ok(()),
        }
    }

    /// Leaves out every second row from the first on, and writes half as many from now on.
    fn thin(&mut self) -> Result<(), OutputError> {
        let rows = std::mem::take(&mut self.rows.rows).into_iter();
        self.rows.rows = rows.step_by(2).collect();
        self.stride *= 2;
        if let Some(history) = &mut self.history {
            history.rewrite(&self.rows)?;
        }
        Ok(())
    }

    /// The columns of all tables that there are.
    ///
    /// # Errors
    /// [`OutputError`] if a table cannot be read.
    pub fn columns(&self, plan: &Plan) -> Result<Vec<WrittenColumn>, OutputError> {
        if !self.leads {
            return Ok(Vec::new());
        }
        let profiles = plan.output.profiles.iter();
        let cracks = plan.cracks.iter();
        let paths = std::iter::once("history.csv".to_owned())
            .chain(profiles.map(|profile| format!("profile-{}.csv", profile.name)))
            .chain(cracks.map(|crack| format!("crack-{}.csv", crack.name)))
            .map(|file| self.folder.join(file))
            .filter(|path| path.is_file());
        let tables: Vec<Vec<WrittenColumn>> =
            paths.map(|path| written(&path)).collect::<Result<_, _>>()?;
        Ok(tables.concat())
    }

    /// Says so where history.csv does not have all steps.
    pub fn thinned(&self) -> Option<String> {
        (self.stride > 1).then(|| {
            format!(
                "history.csv has one in {} of the {} steps, evenly, and the last: it holds at most {} rows",
                self.stride,
                self.seen - 1,
                self.most_rows
            )
        })
    }

    /// Writes the points of this process as VTU, or adds them to the file of all outputs. All processes must call this together.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn piece<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        let number = self.outputs;
        self.outputs += 1;
        let draws = plan.output.plots && DRAWS;
        if !has_fields(plan) && !draws {
            return Ok(());
        }
        // Values are exchanged before anything can fail in one process alone.
        let snapshot = Snapshot::take(model, state);
        self.hold.list()?;
        if plan.output.vtu {
            let grid = self.grid.get_or_insert_with(|| Grid::of(plan, model));
            let rank = model.subdomain().partition().map(|own| own.team().rank());
            let path = self.folder.join(piece_name(number, rank));
            snapshot.write(&path, grid)?;
        }
        if plan.output.vtkhdf {
            let grid = self.grid.get_or_insert_with(|| Grid::of(plan, model));
            snapshot.append(&self.folder.join(WHOLE), grid, number)?;
        }
        if draws && self.leads {
            let sections = &mut self.sections;
            let sections = sections.get_or_insert_with(|| Sections::of(plan, model));
            sections.write((&self.folder, number), &snapshot)?;
            sections.keep(number, &snapshot, D);
        }
        Ok(())
    }

    /// Completes an output of which all pieces are there: indices, pictures and profiles.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn fields<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        if !self.leads {
            return Ok(());
        }
        let number = self.outputs - 1;
        if plan.output.vtu {
            self.collect(number, model, state)?;
        }
        if has_fields(plan) {
            let lines = &mut self.crack_lines;
            let lines = lines.get_or_insert_with(|| CrackLines::new(plan, model));
            lines.record((&self.folder, number), plan, model, state)?;
        }
        if plan.output.plots {
            self.pace.add(number);
            if self.pace.is_due() {
                self.draw_pending(plan, model)?;
            }
        }
        if let Some(cracks) = &mut self.cracks {
            cracks.record(plan, model, state)?;
        }
        match &mut self.profiles {
            Some(profiles) => profiles.record(plan, model, state),
            None => Ok(()),
        }
    }

    /// Enters the fields of an output into their collection.
    fn collect<const D: usize>(
        &mut self,
        number: usize,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        let path = match model.subdomain().partition() {
            None => self.folder.join(piece_name(number, None)),
            Some(partition) => {
                let ranks = 0..partition.team().size();
                let pieces: Vec<String> =
                    ranks.map(|rank| piece_name(number, Some(rank))).collect();
                let path = self.folder.join(format!("fields-{number:04}.pvtu"));
                fields::write_index(&path, model, state, &pieces)?;
                path
            }
        };
        let pvd = match &mut self.pvd {
            Some(pvd) => pvd,
            none => none.insert(Pvd::create(self.folder.join("fields.pvd"))?),
        };
        pvd.add(state.time, path)
    }

    /// Draws what needs the whole run: permeability, histories and profiles.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn finish<const D: usize>(
        &mut self,
        plan: &Plan,
        model: &Model<D>,
        tracker: &CrackTracker,
    ) -> Result<(), OutputError> {
        if !plan.output.plots || !self.leads {
            return Ok(());
        }
        if let Some(profiles) = &self.profiles {
            profiles.draw(plan)?;
        }
        if let Some(cracks) = &self.cracks {
            cracks.draw(plan)?;
        }
        // Where there are several they are drawn in the colours of all.
        if self.outputs == 1 {
            self.draw_pending(plan, model)?;
        }
        self.pictures(plan, model, |pictures| {
            pictures.of_run(self.outputs)?;
            pictures.of_permeability()?;
            setup::draw(pictures)?;
            fracture::draw(pictures, self.outputs, tracker)?;
            space::draw(pictures, self.outputs, tracker)
        })?;
        histories::draw::<D>(&self.folder, plan, &self.rows)
    }

    /// Draws pictures of fields, in a build that draws.
    fn pictures<const D: usize>(
        &self,
        plan: &Plan,
        model: &Model<D>,
        draw: impl FnOnce(&Pictures<'_, D>) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        if !DRAWS {
            return Ok(());
        }
        let made;
        let sections = match &self.sections {
            Some(sections) => sections,
            // A run that goes on may have nothing left to write.
            None => {
                made = Sections::of(plan, model);
                &made
            }
        };
        draw(&Pictures {
            folder: &self.folder,
            plan,
            model,
            sections,
        })
    }

    /// Writes summary.json.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn summary(&self, summary: &Summary) -> Result<(), OutputError> {
        if !self.leads {
            return Ok(());
        }
        write_json(self.folder.join("summary.json"), summary)
    }
}

/// A warning where pictures are wanted of a build that draws none.
pub(super) fn undrawn(plan: &Plan, writer: Option<&Writer>) -> Option<String> {
    let wanted = plan.output.plots && writer.is_some_and(|writer| writer.leads);
    (wanted && !DRAWS)
        .then(|| "no pictures are drawn: perifrac was built without the feature `plots`".to_owned())
}

/// Whether files of fields are written.
fn has_fields(plan: &Plan) -> bool {
    plan.output.vtu || plan.output.vtkhdf
}

/// Name of the file with the fields of all outputs.
const WHOLE: &str = "fields.vtkhdf";

/// Name of the fields of one output, or of the piece of one process.
fn piece_name(number: usize, rank: Option<usize>) -> String {
    match rank {
        None => format!("fields-{number:04}.vtu"),
        Some(rank) => format!("fields-{number:04}-{rank}.vtu"),
    }
}

#[cfg(test)]
mod tests;
