//! Pictures of any field of a run at all of its outputs, and an animation of them.

use std::path::{Path, PathBuf};

use super::fields::{facts, parts};
use super::{StudyError, scene};
use crate::output::{
    FieldPlot, Manifest, Multiples, OutputError, PictureFacts, Scale, animation_png, field_png,
};
use crate::plan::{PointFields, read_fields};
use crate::run::{Quantity, Summary, named};

const WIDTH: u32 = 900;
const SECONDS_PER_FRAME: f64 = 0.6;

/// An output in a plane or section.
struct Output {
    number: String,
    source: String,
    fields: PointFields,
    values: Vec<f64>,
}

/// Draws a field at all outputs into the folder of a run, in the same colours, and an animation of it; gives the
/// pictures. `field` is a name such as `pressure`, `velocity` for its magnitude, or `effective_stress_xy`.
///
/// # Errors
/// [`StudyError::NoRun`] if the folder has no run whose fields can be read, [`StudyError::NoField`] for a field that
/// there is not, with those that there are, [`StudyError::Output`] if a picture cannot be written.
pub fn draw_frames(folder: &Path, field: &str) -> Result<Vec<PathBuf>, StudyError> {
    let run = super::single::summary(folder)?;
    let no_field = |known| StudyError::NoField {
        folder: folder.to_owned(),
        field: field.to_owned(),
        known,
    };
    let quantity = match named(field, run.dimension) {
        Ok(quantity) => quantity,
        Err(_) => return Err(no_field(present(folder, run.dimension)?)),
    };
    let text = std::fs::read_to_string(folder.join("resolved.toml")).unwrap_or_default();
    let title = scene::title(&text).unwrap_or_else(|| run.case.clone());
    let _list = Manifest::resume(folder)?;
    let mut pictures = Vec::new();
    for (suffix, section) in sections(folder)? {
        let outputs = outputs(folder, &section, &quantity)?;
        if !outputs.is_empty() {
            let own = Drawn {
                folder,
                run: &run,
                title: &title,
                quantity: &quantity,
                suffix: &suffix,
            };
            pictures.extend(own.draw(&outputs, &section[0].1)?);
        }
    }
    match pictures.is_empty() {
        true => Err(no_field(present(folder, run.dimension)?)),
        false => Ok(pictures),
    }
}

/// Pictures of one field by the end of their names: those tell files and places of all sections.
type Section = Vec<(String, PictureFacts)>;

/// Every section with the facts of its pictures at the outputs.
fn sections(folder: &Path) -> Result<Vec<(String, Section)>, StudyError> {
    let mut sections: Vec<(String, Section)> = Vec::new();
    for path in super::single::listed(folder)? {
        let Some(((name, number), facts)) = parts(&path).zip(facts(&path)) else {
            continue;
        };
        let suffix = ["-x", "-y"]
            .into_iter()
            .find(|end| name.ends_with(end))
            .unwrap_or("");
        let place = sections
            .iter()
            .position(|own| own.0 == suffix)
            .unwrap_or_else(|| {
                sections.push((suffix.to_owned(), Section::new()));
                sections.len() - 1
            });
        let known = &mut sections[place].1;
        if known.iter().all(|own| own.0 != number) {
            known.push((number, facts));
        }
    }
    Ok(sections)
}

/// Fields of a section at the outputs that have the quantity.
fn outputs(
    folder: &Path,
    section: &Section,
    quantity: &Quantity,
) -> Result<Vec<Output>, StudyError> {
    let mut outputs = Vec::new();
    for (number, facts) in section {
        let Some(name) = Path::new(&facts.source).file_name() else {
            continue;
        };
        let fields = read(&folder.join(name))?;
        if let Some(values) = quantity.of(&fields) {
            outputs.push(Output {
                number: number.clone(),
                source: facts.source.clone(),
                fields,
                values,
            });
        }
    }
    Ok(outputs)
}

fn read(path: &Path) -> Result<PointFields, StudyError> {
    let malformed = |error: crate::plan::FileError| OutputError::Malformed {
        path: path.to_owned(),
        line: 1,
        reason: error.to_string(),
    };
    Ok(read_fields(path).map_err(malformed)?)
}

/// Names of the fields that the run has.
fn present(folder: &Path, dimension: usize) -> Result<Vec<String>, StudyError> {
    let sections = sections(folder)?;
    let source = sections
        .first()
        .and_then(|own| own.1.first())
        .map(|own| folder.join(&own.1.source));
    let fields = source
        .map(|path| read(&path))
        .transpose()?
        .unwrap_or_default();
    // A name that there is not asks for all names.
    let all = named("", dimension).err().unwrap_or_default();
    let has = |name: &String| named(name, dimension).is_ok_and(|own| own.of(&fields).is_some());
    Ok(all.into_iter().filter(has).collect())
}

/// What the pictures of one section have in common.
struct Drawn<'a> {
    folder: &'a Path,
    run: &'a Summary,
    title: &'a str,
    quantity: &'a Quantity,
    suffix: &'a str,
}

impl Drawn<'_> {
    fn draw(&self, outputs: &[Output], facts: &PictureFacts) -> Result<Vec<PathBuf>, StudyError> {
        let values = outputs.iter().flat_map(|own| own.values.iter().copied());
        let axes = [&*facts.axes[0], &*facts.axes[1]];
        let (positions, sizes) = self.cells(&outputs[0].fields, axes);
        let (quantity, place) = (&self.quantity.title, self.place(outputs));
        let frame = |own: &Output| (own.fields.time.unwrap_or(0.0), own.values.clone());
        let film = Multiples {
            title: &format!("{}: {quantity}{place}", self.title),
            unit: self.quantity.unit,
            positions: &positions,
            sizes: &sizes,
            outlines: &[],
            frames: &outputs.iter().map(frame).collect::<Vec<_>>(),
            scale: Scale::Linear,
            range: self.quantity.spread(values),
            width_px: WIDTH,
            axes,
            lines: &facts.lines,
        };
        let name = format!("{}{}", self.quantity.file, self.suffix);
        let mut pictures = Vec::new();
        for output in outputs {
            let path = self.folder.join(format!("{name}-{}.png", output.number));
            let time = output.fields.time.filter(|_| facts.time.is_some());
            field_png(&path, &picture(&film, output, time))?;
            pictures.push(path);
        }
        if outputs.len() > 1 {
            let path = self.folder.join(format!("{name}-animation.png"));
            animation_png(&path, &film, SECONDS_PER_FRAME)?;
            pictures.push(path);
        }
        Ok(pictures)
    }

    /// Where a section is, for titles.
    fn place(&self, outputs: &[Output]) -> String {
        let axis = match (self.run.dimension, self.suffix) {
            (2, _) => return String::new(),
            (_, "-x") => 0,
            (_, "-y") => 1,
            _ => 2,
        };
        let at = outputs[0]
            .fields
            .positions
            .get(axis)
            .copied()
            .unwrap_or(0.0);
        let rounded: f64 = format!("{at:.3e}").parse().unwrap_or(at);
        format!(", points at {} = {rounded} m", ["x", "y", "z"][axis])
    }

    /// Places in the picture and edges of squares as large as the points, m.
    fn cells(&self, fields: &PointFields, axes: [&str; 2]) -> (Vec<f64>, Vec<f64>) {
        let axis = |name: &str| {
            ["x", "y", "z"]
                .iter()
                .position(|own| *own == name)
                .unwrap_or(0)
        };
        let [x, y] = axes.map(axis);
        let places = fields
            .positions
            .chunks_exact(3)
            .flat_map(|place| [place[x], place[y]]);
        let volumes = fields
            .arrays
            .get("volume")
            .map(|own| &own.1[..])
            .unwrap_or_default();
        let power = 1.0 / self.run.dimension as f64;
        (
            places.collect(),
            volumes.iter().map(|volume| volume.powf(power)).collect(),
        )
    }
}

/// One output as a picture like the frames of an animation.
fn picture<'a>(film: &Multiples<'a>, output: &'a Output, time: Option<f64>) -> FieldPlot<'a> {
    FieldPlot {
        title: film.title,
        unit: film.unit,
        positions: film.positions,
        dimension: 2,
        sizes: film.sizes,
        outlines: film.outlines,
        values: &output.values,
        time,
        scale: film.scale,
        range: film.range.map(|[low, high]| (low, high)),
        width_px: film.width_px,
        axes: film.axes,
        lines: film.lines,
        source: Some(&output.source),
    }
}
