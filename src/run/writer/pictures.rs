//! Pictures of fields: the whole plane in 2-D, three sections in 3-D.
//!
//! A picture is drawn when its output is there, and again at the end of the run in the colours of all outputs.

use std::path::Path;

use super::sections::{Section, Sections};
use crate::model::Model;
use crate::output::{FieldPlot, OutputError, Scale, field_png};
use crate::plan::{Plan, PointFields, TimeMode};
use crate::run::quantities::{Quantity, drawn};

const PICTURE_WIDTH: u32 = 900;

/// Share of the longest edge of the domain that the largest displacement has in pictures of the deformed shape.
const DEFORMATION: f64 = 0.08;

/// What all pictures of a run have in common.
pub(super) struct Pictures<'a, const D: usize> {
    pub(super) folder: &'a Path,
    pub(super) plan: &'a Plan,
    pub(super) model: &'a Model<D>,
    pub(super) sections: &'a Sections,
}

/// Time, s, and values of a quantity at an output.
pub(super) type Frame = (f64, Vec<f64>);

/// What one picture shows.
struct Picture<'a> {
    file: &'a str,
    title: &'a str,
    unit: &'a str,
    section: &'a Section,
    positions: &'a [f64],
    values: &'a [f64],
    lines: &'a [Vec<[f64; 2]>],
    outlines: &'a [Vec<[f64; 2]>],
    time: Option<f64>,
    scale: Scale,
    range: Option<[f64; 2]>,
    source: Option<&'a str>,
}

impl<const D: usize> Pictures<'_, D> {
    /// Draws the fields of output `number`, in colours of its own.
    ///
    /// # Errors
    /// Those of [`field_png`], [`OutputError::Malformed`] if the fields cannot be read.
    pub(super) fn of_output(&self, number: usize) -> Result<(), OutputError> {
        for section in &self.sections.all {
            if let Some(fields) = self.sections.read(self.folder, section, number)? {
                self.of_section(section, number, &fields, &[None; 4])?;
            }
        }
        Ok(())
    }

    /// Draws all outputs again, each quantity in the same colours, and the deformed shape.
    ///
    /// # Errors
    /// Those of [`Pictures::of_output`].
    pub(super) fn of_run(&self, outputs: usize) -> Result<(), OutputError> {
        let mut ranges = [None; 4];
        let mut farthest = 0.0_f64;
        let all = || {
            let sections = self.sections.all.iter();
            sections.flat_map(|section| (0..outputs).map(move |number| (section, number)))
        };
        for (section, number) in all() {
            if let Some(fields) = self.sections.read(self.folder, section, number)? {
                for (range, quantity) in ranges.iter_mut().zip(drawn(D)) {
                    let values = quantity.of(&fields).unwrap_or_default();
                    if quantity.file == "displacement" {
                        farthest = values.iter().copied().fold(farthest, f64::max);
                    }
                    *range = joined(*range, quantity.spread(values.into_iter()));
                }
            }
        }
        let factor = self.factor(farthest);
        for (section, number) in all() {
            if let Some(fields) = self.sections.read(self.folder, section, number)? {
                if outputs > 1 {
                    self.of_section(section, number, &fields, &ranges)?;
                }
                if let Some(factor) = factor {
                    self.deformed(section, number, &fields, (factor, &ranges))?;
                }
            }
        }
        Ok(())
    }

    /// Values of a quantity at all outputs in the first section; empty where the scene does not name it.
    ///
    /// # Errors
    /// [`OutputError::Malformed`] if the fields cannot be read.
    pub(super) fn frames(
        &self,
        quantity: &Quantity,
        outputs: usize,
    ) -> Result<Vec<Frame>, OutputError> {
        let mut frames = Vec::new();
        for number in 0..outputs {
            let Some(section) = self.sections.all.first() else {
                continue;
            };
            if let Some(fields) = self.sections.read(self.folder, section, number)? {
                let values = quantity.of(&fields);
                frames.extend(values.map(|values| (fields.time.unwrap_or(0.0), values)));
            }
        }
        Ok(frames)
    }

    fn of_section(
        &self,
        section: &Section,
        number: usize,
        fields: &PointFields,
        ranges: &[Option<[f64; 2]>; 4],
    ) -> Result<(), OutputError> {
        let source = self.sections.file(section, number);
        for (quantity, range) in drawn(D).iter().zip(ranges) {
            let Some(values) = quantity.of(fields) else {
                continue;
            };
            let name = format!(
                "{}{}-{number:04}.png",
                quantity.file,
                section.picture_suffix()
            );
            self.draw(&Picture {
                file: &name,
                title: &format!("{}{}", quantity.title, section.name()),
                unit: quantity.unit,
                section,
                positions: &section.positions(self.model),
                values: &values,
                lines: &section.cracks(self.plan),
                outlines: section.outlines(self.plan),
                time: self.time(fields),
                scale: Scale::Linear,
                range: range.or_else(|| quantity.spread(values.iter().copied())),
                source: Some(&source),
            })?;
        }
        Ok(())
    }

    /// Draws the points where they have moved to, enlarged, in the colours of damage or of how far they moved.
    fn deformed(
        &self,
        section: &Section,
        number: usize,
        fields: &PointFields,
        (factor, ranges): (f64, &[Option<[f64; 2]>; 4]),
    ) -> Result<(), OutputError> {
        let Some((components, moved)) = fields.arrays.get("displacement") else {
            return Ok(());
        };
        let shown = drawn(D).into_iter().zip(ranges).rev();
        let shown = shown.filter(|(own, _)| ["damage", "displacement"].contains(&&*own.file));
        let shown = shown.map(|(own, range)| (own.of(fields), own, range));
        let Some((Some(values), quantity, range)) = { shown }.find(|own| own.0.is_some()) else {
            return Ok(());
        };
        let mut positions = section.positions(self.model);
        for (place, moved) in positions.chunks_mut(2).zip(moved.chunks(*components)) {
            for (own, axis) in place.iter_mut().zip(section.across()) {
                *own += factor * moved[axis];
            }
        }
        let by = format!("displacement enlarged {factor} times");
        self.draw(&Picture {
            file: &format!("deformed{}-{number:04}.png", section.picture_suffix()),
            title: &format!(
                "deformed shape, {by}, colours: {}{}",
                quantity.title,
                section.name()
            ),
            unit: quantity.unit,
            section,
            positions: &positions,
            values: &values,
            lines: &[],
            outlines: &[],
            time: self.time(fields),
            scale: Scale::Linear,
            range: *range,
            source: None,
        })
    }

    /// One, two or five times a power of ten by which displacements are enlarged; none where nothing moves.
    fn factor(&self, farthest: f64) -> Option<f64> {
        let domain = &self.model.cloud.domain;
        let longest = (domain.upper - domain.lower).max();
        let most = DEFORMATION * longest / farthest;
        if !(most.is_finite() && farthest > 0.0) {
            return None;
        }
        let power = 10_f64.powf(most.log10().floor());
        let step = [5.0, 2.0].into_iter().find(|step| step * power <= most);
        Some((step.unwrap_or(1.0) * power).max(1.0))
    }

    fn time(&self, fields: &PointFields) -> Option<f64> {
        fields
            .time
            .filter(|_| self.plan.time.mode == TimeMode::Transient)
    }

    /// Draws the permeability where it varies.
    ///
    /// # Errors
    /// Those of [`field_png`].
    pub(super) fn of_permeability(&self) -> Result<(), OutputError> {
        let values = &self.model.permeability;
        let extremes = |(low, high): (f64, f64), &k: &f64| (low.min(k), high.max(k));
        let (low, high) = values.iter().fold((f64::INFINITY, 0.0), extremes);
        if self.model.flow.is_none() || high <= low * (1.0 + 1e-12) {
            return Ok(());
        }
        let scale = match high > 30.0 * low {
            true => Scale::Log10,
            false => Scale::Linear,
        };
        for section in &self.sections.all {
            let own = |point: &u32| values[*point as usize];
            self.draw(&Picture {
                file: &format!("permeability{}.png", section.picture_suffix()),
                title: &format!("permeability{}", section.name()),
                unit: "m²",
                section,
                positions: &section.positions(self.model),
                values: &section.points.iter().map(own).collect::<Vec<_>>(),
                lines: &section.cracks(self.plan),
                outlines: section.outlines(self.plan),
                time: None,
                scale,
                range: Some([low, high]),
                source: None,
            })?;
        }
        Ok(())
    }

    fn draw(&self, picture: &Picture<'_>) -> Result<(), OutputError> {
        let plot = FieldPlot {
            title: &format!("{}: {}", self.plan.title, picture.title),
            unit: picture.unit,
            positions: picture.positions,
            dimension: 2,
            sizes: &picture.section.sizes(self.model),
            values: picture.values,
            time: picture.time,
            scale: picture.scale,
            range: picture.range.map(|[low, high]| (low, high)),
            width_px: PICTURE_WIDTH,
            axes: picture.section.axes(),
            lines: picture.lines,
            outlines: picture.outlines,
            source: picture.source,
        };
        field_png(self.folder.join(picture.file), &plot)
    }
}

/// The range that holds both.
fn joined(a: Option<[f64; 2]>, b: Option<[f64; 2]>) -> Option<[f64; 2]> {
    match (a, b) {
        (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
        (one, None) | (None, one) => one,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn colours_hold_what_every_output_has() {
        assert_eq!(joined(None, Some([1.0, 2.0])), Some([1.0, 2.0]));
        assert_eq!(joined(Some([1.0, 2.0]), None), Some([1.0, 2.0]));
        assert_eq!(
            joined(Some([1.0, 2.0]), Some([-1.0, 1.5])),
            Some([-1.0, 2.0])
        );
    }
}
