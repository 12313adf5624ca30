//! Fields along the lines that a run writes and extremes of its history, to compare runs with each other.

use std::collections::BTreeMap;
use std::path::Path;

/// Start of the names of lines at whose places all clouds of a study are compared.
pub(super) const SAMPLE: &str = "sample-";

/// Name of the smallest pressure after every step.
pub(super) const LOWEST: &str = "lowest pressure";
/// Name of the largest.
pub(super) const HIGHEST: &str = "highest pressure";

/// Which fields of a run are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum RecordedOutput {
    /// None.
    #[default]
    Nothing,
    /// At the end, along the lines of the case.
    End,
    /// At every output, along the lines across the domain that the study adds.
    Outputs,
    /// The smallest and the largest pressure after every step.
    Extremes,
}

/// Between the field and the time in the name of what is kept at an output.
const AT: &str = " at ";

/// The field of what is kept: `pressure` or `displacement`.
pub(super) fn field(name: &str) -> &str {
    name.split_once(AT).map_or(name, |(field, _)| field)
}

/// Values of the fields by time (as its bits, which are ordered as times are) and name.
type Fields = BTreeMap<(u64, String), Vec<f64>>;

/// The fields of a run that are to be kept, exact solutions left out; at outputs with their times.
///
/// What cannot be read is left out: the study then has fewer fields.
pub(super) fn fields(folder: &Path, kept: RecordedOutput) -> Vec<(String, Vec<f64>)> {
    let start = match kept {
        RecordedOutput::Nothing => return Vec::new(),
        RecordedOutput::Extremes => return extremes(&folder.join("history.csv")),
        RecordedOutput::End => "profile-".to_owned(),
        RecordedOutput::Outputs => format!("profile-{SAMPLE}"),
    };
    let mut fields = Fields::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort_unstable();
    for path in paths {
        let name = path.file_name().map(|name| name.to_string_lossy());
        let name = name.unwrap_or_default();
        if name.starts_with(&start) && name.ends_with(".csv") {
            add(&path, &mut fields);
        }
    }
    let last = fields.keys().map(|(time, _)| *time).max();
    let named = fields.into_iter().filter_map(|((time, field), values)| {
        let name = match kept {
            RecordedOutput::Outputs => format!("{field}{AT}{:.6e}", f64::from_bits(time)),
            _ => (Some(time) == last).then_some(field)?,
        };
        Some((name, values))
    });
    named.collect()
}

/// Extremes of the pressure from the history of a run.
fn extremes(path: &Path) -> Vec<(String, Vec<f64>)> {
    let Some((head, rows)) = read(path) else {
        return Vec::new();
    };
    let columns = [("pressure_min", LOWEST), ("pressure_max", HIGHEST)].into_iter();
    let series = columns.filter_map(|(start, name)| {
        let column = head.iter().position(|own| own.starts_with(start))?;
        let values = rows.iter().map(|row| row[column]).collect();
        Some((name.to_owned(), values))
    });
    series.collect()
}

fn add(path: &Path, fields: &mut Fields) {
    let Some((head, rows)) = read(path) else {
        return;
    };
    let Some(time) = head.iter().position(|name| name.starts_with("time")) else {
        return;
    };
    for (column, name) in head.iter().enumerate() {
        let mut known = ["pressure", "displacement"].into_iter();
        let field = known.find(|field| name.starts_with(field));
        let (Some(field), false) = (field, name.contains("exact")) else {
            continue;
        };
        for row in &rows {
            let key = (row[time].max(0.0).to_bits(), field.to_owned());
            fields.entry(key).or_default().push(row[column]);
        }
    }
}

/// Head and rows of a table; a last line that was cut off is left out.
fn read(path: &Path) -> Option<(csv::StringRecord, Vec<Vec<f64>>)> {
    let mut reader = csv::Reader::from_path(path).ok()?;
    let head = reader.headers().ok()?.clone();
    let rows = reader.records().flatten().map(|record| {
        let cells = record.iter();
        cells.map(|cell| cell.parse().unwrap_or(f64::NAN)).collect()
    });
    Some((head, rows.collect()))
}

/// Norm of the difference over the norm of the second; NaN if they do not fit.
pub(super) fn apart(values: &[f64], from: &[f64]) -> f64 {
    difference(values, from) / root_of_squares(from.iter().copied())
}

/// Root mean square of the difference over the range of the second; NaN if they do not fit or the
/// second is constant.
pub(super) fn over_range(values: &[f64], from: &[f64]) -> f64 {
    let low = from.iter().copied().fold(f64::INFINITY, f64::min);
    let high = from.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let error = difference(values, from) / (from.len() as f64).sqrt() / (high - low);
    if error.is_finite() { error } else { f64::NAN }
}

fn difference(values: &[f64], from: &[f64]) -> f64 {
    match values.len() == from.len() && !values.is_empty() {
        true => root_of_squares(values.iter().zip(from).map(|(a, b)| a - b)),
        false => f64::NAN,
    }
}

fn root_of_squares(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn fields_are_kept_at_the_end_or_at_every_output() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).unwrap();
        };
        let table =
            "time_s,distance_m,pressure_Pa,pressure_exact_Pa\n1,0,5,0\n1,1,6,0\n2,0,7,0\n2,1,8,0\n";
        write("profile-own.csv", table);
        write("profile-sample-0.csv", table);
        let end = fields(folder.path(), RecordedOutput::End);
        assert_eq!(end, [("pressure".to_owned(), vec![7.0, 8.0, 7.0, 8.0])]);
        let all = fields(folder.path(), RecordedOutput::Outputs);
        assert_eq!(
            all[0],
            ("pressure at 1.000000e0".to_owned(), vec![5.0, 6.0])
        );
        assert_eq!(all.len(), 2);
        assert_eq!(field(&all[1].0), "pressure");
        assert!(fields(folder.path(), RecordedOutput::Nothing).is_empty());
    }

    #[test]
    fn distances_are_relative_to_the_norm_or_to_the_range() {
        assert_eq!(apart(&[3.0, 5.0], &[3.0, 4.0]), 0.2);
        assert_eq!(over_range(&[1.0, 4.0], &[1.0, 3.0]), 0.5 / 2_f64.sqrt());
        assert!(over_range(&[1.0], &[1.0, 3.0]).is_nan());
        assert!(over_range(&[1.0, 2.0], &[3.0, 3.0]).is_nan());
    }
}
