//! Fields along the lines that a run writes, to compare runs of one cloud with each other.

use std::collections::BTreeMap;
use std::path::Path;

/// Columns of all `profile-*.csv` of a run at the last time, exact solutions left out.
///
/// What cannot be read is left out: the study then has fewer fields.
pub fn last_fields(folder: &Path) -> Vec<(String, Vec<f64>)> {
    let mut fields: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        if name.starts_with("profile-") && name.ends_with(".csv") {
            add(&path, &mut fields);
        }
    }
    fields.into_iter().collect()
}

fn add(path: &Path, fields: &mut BTreeMap<String, Vec<f64>>) {
    let Ok(mut reader) = csv::Reader::from_path(path) else {
        return;
    };
    let Ok(head) = reader.headers().cloned() else {
        return;
    };
    let rows: Vec<Vec<f64>> = reader
        .records()
        .flatten()
        .map(|record| {
            record
                .iter()
                .map(|cell| cell.parse().unwrap_or(f64::NAN))
                .collect()
        })
        .collect();
    let Some(time) = head.iter().position(|name| name.starts_with("time")) else {
        return;
    };
    let last = rows
        .iter()
        .map(|row| row[time])
        .fold(f64::NEG_INFINITY, f64::max);
    let at_end: Vec<&Vec<f64>> = rows.iter().filter(|row| row[time] >= last).collect();
    for (column, name) in head.iter().enumerate() {
        let field = ["pressure", "displacement"]
            .into_iter()
            .find(|f| name.starts_with(f));
        let (Some(field), false) = (field, name.contains("exact")) else {
            continue;
        };
        let values = at_end.iter().map(|row| row[column]);
        fields.entry(field.to_owned()).or_default().extend(values);
    }
}

/// Norm of the difference over the norm of the second; NaN if they do not fit.
pub fn apart(values: &[f64], from: &[f64]) -> f64 {
    if values.len() != from.len() || values.is_empty() {
        return f64::NAN;
    }
    let square = |list: &mut dyn Iterator<Item = f64>| list.map(|v| v * v).sum::<f64>().sqrt();
    let change = square(&mut values.iter().zip(from).map(|(a, b)| a - b));
    change / square(&mut from.iter().copied())
}
