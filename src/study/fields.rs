//! Pictures of fields on a page: one after another where there is no script, else one at a time with the values under
//! the pointer.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::html::{FIELDS, escape};
use crate::output::{OutputError, PICTURE_KEY, PictureFacts};
use crate::plan::{PointFields, read_fields};
use crate::run::named;

/// Most outputs of a field on a page; of more some are left out evenly.
const MOST_OUTPUTS: usize = 24;

/// Most points of a picture whose values a page has.
const MOST_POINTS: usize = 20_000;

/// Most values that a page has in all: three megabytes before they are packed.
const MOST_VALUES: usize = 750_000;

/// A picture of a field at an output.
struct Shown {
    number: String,
    path: PathBuf,
    facts: Option<PictureFacts>,
}

/// Pictures of fields by the start of their names.
type Groups = BTreeMap<String, Vec<Shown>>;

/// The part of a page with the pictures `NAME-NNNN.png`; nothing without any.
///
/// # Errors
/// [`OutputError`] if a picture cannot be read.
pub(super) fn fields(paths: &[PathBuf], dimension: usize) -> Result<String, OutputError> {
    let groups = groups(paths);
    if groups.is_empty() {
        return Ok(String::new());
    }
    let pictures: usize = groups.values().map(Vec::len).sum();
    let most = (MOST_VALUES / pictures).clamp(100, MOST_POINTS);
    let mut sources = Sources::new(most);
    let mut text = format!("<h2>Fields</h2>\n{FIELDS}\n");
    for (name, shown) in &groups {
        text += &format!(
            "<div class=\"field\" data-name=\"{0}\">\n<div class=\"outputs\">\n",
            escape(name)
        );
        for picture in shown {
            text += &figure(name, picture, &mut sources, dimension)?;
        }
        text += "</div>\n</div>\n";
    }
    text += &sources.places();
    text += "</section>\n";
    text += &remarks(paths, &groups, &sources);
    Ok(text)
}

/// Name and number of a picture of a field.
pub(super) fn parts(path: &Path) -> Option<(String, String)> {
    let name = path.file_name()?.to_str()?.strip_suffix(".png")?;
    let (name, number) = name.rsplit_once('-')?;
    let counts = number.len() >= 4 && number.bytes().all(|own| own.is_ascii_digit());
    counts.then(|| (name.to_owned(), number.to_owned()))
}

fn groups(paths: &[PathBuf]) -> Groups {
    let mut groups = Groups::new();
    for path in paths {
        if let Some((name, number)) = parts(path) {
            groups.entry(name).or_default().push(Shown {
                number,
                path: path.clone(),
                facts: facts(path),
            });
        }
    }
    for shown in groups.values_mut() {
        let (all, most) = (shown.len(), shown.len().min(MOST_OUTPUTS));
        let kept: BTreeSet<usize> = (0..most)
            .map(|k| k * (all - 1) / (most - 1).max(1))
            .collect();
        let mut place = 0..all;
        shown.retain(|_| place.next().is_some_and(|place| kept.contains(&place)));
    }
    groups
}

/// What a picture tells of itself.
pub(super) fn facts(path: &Path) -> Option<PictureFacts> {
    let file = std::io::BufReader::new(std::fs::File::open(path).ok()?);
    let reader = png::Decoder::new(file).read_info().ok()?;
    let texts = &reader.info().utf8_text;
    let own = texts.iter().find(|text| text.keyword == PICTURE_KEY)?;
    serde_json::from_str(&own.get_text().ok()?).ok()
}

fn figure(
    name: &str,
    picture: &Shown,
    sources: &mut Sources,
    dimension: usize,
) -> Result<String, OutputError> {
    let bytes = std::fs::read(&picture.path)
        .map_err(|error| OutputError::from_io(&picture.path, "read", error))?;
    let mut own = format!(" data-output=\"{}\"", picture.number);
    let mut caption = format!("{name}-{}.png", picture.number);
    if let Some(facts) = &picture.facts {
        let json = serde_json::to_string(facts).unwrap_or_default();
        own += &format!(" data-facts=\"{}\"", escape(&json));
        let values = sources.values(name, picture, facts, dimension);
        own += &values.map_or_else(String::new, |packed| format!(" data-values=\"{packed}\""));
        caption = format!("{}: {caption}", facts.title);
    }
    let caption = escape(&caption);
    Ok(format!(
        "<figure{own}><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption>\
         </figure>\n",
        BASE64.encode(bytes)
    ))
}

/// What a reader must know of what is left out.
fn remarks(paths: &[PathBuf], groups: &Groups, sources: &Sources) -> String {
    let mut remarks = Vec::new();
    let all = paths.iter().filter_map(|path| parts(path));
    let numbers: BTreeSet<String> = all.map(|(_, number)| number).collect();
    let shown: BTreeSet<&String> = groups.values().flatten().map(|own| &own.number).collect();
    if shown.len() < numbers.len() {
        let (shown, all) = (shown.len(), numbers.len());
        remarks.push(format!(
            "Pictures of {shown} of {all} outputs; all are in the folder of the run."
        ));
    }
    for (source, (kept, all)) in sources.thinned() {
        remarks.push(format!(
            "Values under the pointer are those of {kept} of the {all} points of {source}, the nearest to it."
        ));
    }
    let line = |text: &String| format!("<p class=\"note\">{}</p>\n", escape(text));
    remarks.iter().map(line).collect()
}

/// Files with the values of pictures, each read once, and which of their points a page has.
struct Sources {
    most: usize,
    last: Option<(PathBuf, Option<PointFields>)>,
    /// Numbers of the points kept, the number of all and their places, by what tells one set of points from another.
    kept: BTreeMap<String, Kept>,
}

/// Points whose values a page has.
struct Kept {
    points: Vec<usize>,
    all: usize,
    places: Vec<f32>,
}

impl Sources {
    fn new(most: usize) -> Self {
        Sources {
            most,
            last: None,
            kept: BTreeMap::new(),
        }
    }

    /// Packed values of a picture at the points kept; `None` where there are none.
    fn values(
        &mut self,
        name: &str,
        picture: &Shown,
        facts: &PictureFacts,
        dimension: usize,
    ) -> Option<String> {
        let path = picture
            .path
            .parent()?
            .join(Path::new(&facts.source).file_name()?);
        if self.last.as_ref().is_none_or(|(last, _)| *last != path) {
            self.last = Some((path.clone(), read_fields(&path).ok()));
        }
        let fields = self.last.as_ref()?.1.as_ref()?;
        let [x, y] = [0, 1].map(|k| ["x", "y", "z"].iter().position(|own| *own == facts.axes[k]));
        let plane = name
            .strip_suffix("-x")
            .or(name.strip_suffix("-y"))
            .unwrap_or(name);
        let values = named(plane, dimension).ok()?.of(fields)?;
        let most = self.most;
        let kept = self.kept.entry(facts.axes.concat());
        let kept = kept
            .or_insert_with(|| Kept::of(&fields.positions, [x.unwrap_or(0), y.unwrap_or(1)], most));
        if kept.all != values.len() {
            return None;
        }
        let own = kept.points.iter().map(|point| values[*point] as f32);
        Some(packed(own))
    }

    /// Places of the points kept, which all pictures of the same axes share.
    fn places(&self) -> String {
        let one = |(axes, kept): (&String, &Kept)| {
            let places = packed(kept.places.iter().copied());
            format!(
                "<div hidden data-axes=\"{}\" data-places=\"{places}\"></div>\n",
                escape(axes)
            )
        };
        self.kept.iter().map(one).collect()
    }

    fn thinned(&self) -> impl Iterator<Item = (String, (usize, usize))> {
        let fewer = self
            .kept
            .iter()
            .filter(|(_, kept)| kept.points.len() < kept.all);
        fewer.map(|(axes, kept)| {
            let axes: Vec<String> = axes.chars().map(String::from).collect();
            (
                format!("pictures over {}", axes.join(" and ")),
                (kept.points.len(), kept.all),
            )
        })
    }
}

impl Kept {
    /// At most `most` points, evenly over the plane: one in every box of a grid.
    fn of(positions: &[f64], axes: [usize; 2], most: usize) -> Self {
        let all = positions.len() / 3;
        let place = |point: usize| axes.map(|axis| positions[3 * point + axis]);
        let mut points: Vec<usize> = (0..all).collect();
        if all > most {
            let span = |k: usize| {
                let values = (0..all).map(|point| place(point)[k]);
                let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
                values.fold((f64::INFINITY, f64::NEG_INFINITY), ends)
            };
            let spans = [span(0), span(1)];
            let width = |(low, high): (f64, f64)| (high - low).max(f64::MIN_POSITIVE);
            let edge = (width(spans[0]) * width(spans[1]) / most as f64).sqrt();
            let of = |point: usize| [0, 1].map(|k| ((place(point)[k] - spans[k].0) / edge) as i64);
            let mut taken = BTreeSet::new();
            points.retain(|point| taken.insert(of(*point)));
        }
        let places = points.iter().flat_map(|point| place(*point));
        Kept {
            places: places.map(|own| own as f32).collect(),
            points,
            all,
        }
    }
}

/// Numbers in single precision, little endian, compressed with zlib, as base64; nothing if that fails.
fn packed(values: impl Iterator<Item = f32>) -> String {
    let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let done = encoder.write_all(&bytes).and_then(|()| encoder.finish());
    done.map_or_else(|_| String::new(), |bytes| BASE64.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_fields_end_in_a_number() {
        let of = |name: &str| parts(Path::new(name));
        assert_eq!(
            of("a/pressure-0003.png"),
            Some(("pressure".to_owned(), "0003".to_owned()))
        );
        assert_eq!(of("stress-x-12345.png").unwrap().0, "stress-x");
        for other in [
            "permeability.png",
            "damage-over-time.png",
            "a-03.png",
            "a-0003.svg",
        ] {
            assert_eq!(of(other), None, "{other}");
        }
    }

    #[test]
    fn of_many_points_some_are_kept_all_over_the_plane() {
        let positions: Vec<f64> = (0..10_000)
            .flat_map(|k| [f64::from(k % 200), f64::from(k / 200), 7.0])
            .collect();
        let kept = Kept::of(&positions, [0, 1], 400);
        assert!(
            (200..=500).contains(&kept.points.len()),
            "{}",
            kept.points.len()
        );
        let last = kept
            .places
            .chunks(2)
            .map(|own| own[0] + own[1])
            .fold(0.0, f32::max);
        assert!(last > 220.0, "the farthest corner is at 199 + 49: {last}");
        assert_eq!(Kept::of(&positions, [0, 1], 10_000).points.len(), 10_000);
    }
}
