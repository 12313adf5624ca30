//! Cracks of the scene as lines with their opening and pressure, as VTK poly data beside the fields.

use std::path::Path;

use super::super::columns::openings;
use crate::geometry::{Locator, Vector};
use crate::model::{Model, crack_parts};
use crate::output::{Cells, Field, OutputError, Pvd, VtpData, write_vtp};
use crate::plan::Plan;
use crate::schemes::State;

const COLLECTION: &str = "cracks.pvd";

/// The lines of all cracks, which stay, and the collection of their files.
pub(super) struct CrackLines {
    collection: Option<Pvd>,
    positions: Vec<f64>,
    corners: Vec<u32>,
    ends: Vec<u64>,
    /// The points nearest to the middle of each line.
    nearest: Vec<Vec<usize>>,
}

impl CrackLines {
    /// Lines of the plan's cracks; none where it has no cracks.
    pub(super) fn new<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let mut lines = CrackLines {
            collection: None,
            positions: Vec::new(),
            corners: Vec::new(),
            ends: Vec::new(),
            nearest: Vec::new(),
        };
        let locator = Locator::new(&model.cloud);
        for (number, places) in model.places.cracks.iter().enumerate() {
            for part in crack_parts(plan, model, number) {
                lines.add(&part);
            }
            let nearest = places
                .iter()
                .map(|faces| locator.place(faces.on.at).nearest);
            lines.nearest.extend(nearest);
        }
        lines
    }

    fn add<const D: usize>(&mut self, part: &[Vector<D>]) {
        for x in part {
            self.corners.push((self.positions.len() / D) as u32);
            self.positions.extend(x.iter());
        }
        self.ends.push(self.corners.len() as u64);
    }

    /// Goes on with the collection of a run whose last output that counts was at a time, s.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be read.
    pub(super) fn resume(&mut self, folder: &Path, until: f64) -> Result<(), OutputError> {
        if until.is_finite() && !self.ends.is_empty() {
            self.collection = Some(Pvd::resume(folder.join(COLLECTION), until)?);
        }
        Ok(())
    }

    /// Writes the lines at output `number`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub(super) fn record<const D: usize>(
        &mut self,
        (folder, number): (&Path, usize),
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Result<(), OutputError> {
        if self.ends.is_empty() {
            return Ok(());
        }
        let columns = self.columns(plan, model, state);
        let fields = columns.iter().map(|(name, unit, values)| Field {
            name,
            unit,
            components: 1,
            values,
        });
        let fields: Vec<Field<'_>> = fields.collect();
        let data = VtpData {
            positions: &self.positions,
            dimension: D,
            time: state.time,
            lines: Cells {
                corners: &self.corners,
                ends: &self.ends,
                ..Cells::default()
            },
            fields: &fields,
        };
        let path = folder.join(format!("cracks-{number:04}.vtp"));
        write_vtp(&path, &data)?;
        let collection = match &mut self.collection {
            Some(collection) => collection,
            none => none.insert(Pvd::create(folder.join(COLLECTION))?),
        };
        collection.add(state.time, path)
    }

    /// Names, units and values of what is known of every line.
    fn columns<const D: usize>(
        &self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Vec<(&'static str, &'static str, Vec<f64>)> {
        let all = || model.places.cracks.iter().enumerate();
        let numbers = all().flat_map(|(number, places)| vec![number as f64; places.len()]);
        let distance = all().flat_map(|(_, places)| places.iter().map(|faces| faces.on.distance));
        let mut columns = vec![
            ("crack", "", numbers.collect()),
            ("distance", "m", distance.collect()),
        ];
        if model.solid.is_some() {
            let jumps: Vec<[f64; 2]> = all()
                .flat_map(|(number, _)| openings(model, state, number))
                .collect();
            columns.push(("opening", "m", jumps.iter().map(|jump| jump[0]).collect()));
            columns.push(("sliding", "m", jumps.iter().map(|jump| jump[1]).collect()));
        }
        if let Some(fractures) = &model.fracture_flow {
            columns.push(("aperture", "m", self.at_lines(&fractures.aperture)));
        }
        if let Some(pressure) = self.pressure(plan, model, state) {
            columns.push(("pressure", "Pa", pressure));
        }
        columns
    }

    /// Pressure of the fluid at every line, Pa: that of the nearest points, without flow the one that the scene gives.
    fn pressure<const D: usize>(
        &self,
        plan: &Plan,
        model: &Model<D>,
        state: &State,
    ) -> Option<Vec<f64>> {
        if model.flow.is_some() {
            return Some(self.at_lines(&state.pressure));
        }
        let given = |(number, places): (usize, &Vec<_>)| {
            let load = plan.cracks[number].pressure.as_ref();
            vec![load.map_or(0.0, |load| load.at(state.time)); places.len()]
        };
        let any = plan.cracks.iter().any(|crack| crack.pressure.is_some());
        any.then(|| {
            (model.places.cracks.iter().enumerate())
                .flat_map(given)
                .collect()
        })
    }

    /// Means of the values at the points nearest to each line.
    fn at_lines(&self, values: &[f64]) -> Vec<f64> {
        let mean = |near: &Vec<usize>| {
            let sum: f64 = near.iter().map(|point| values[*point]).sum();
            sum / near.len().max(1) as f64
        };
        self.nearest.iter().map(mean).collect()
    }
}
