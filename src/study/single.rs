//! `perifrac report`: what a run left, on one page.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use base64::Engine;
use serde::Serialize;
use serde_json::Value;

use super::findings::{Table, count, seconds, short};
use super::html::{escape, figure, page, paragraph, table};
use super::{Machine, StudyError, fields, scene};
use crate::output::{Manifest, OutputError, write_atomically};
use crate::run::{Name, Summary};

/// Writes `report.html` into the folder of a run, from the files the run left there.
///
/// # Errors
/// [`StudyError::NoRun`] if the folder has no readable summary.json, [`StudyError::Output`] if the
/// page cannot be written.
pub fn report_run(folder: &Path) -> Result<PathBuf, StudyError> {
    let run = summary(folder)?;
    let text = std::fs::read_to_string(folder.join("resolved.toml")).unwrap_or_default();
    let paths = listed(folder)?;
    let mut body = head(&run);
    body += &warnings(&run);
    body += &errors(&run);
    body += &format!("<h2>Scene</h2>\n{}", pictures(&paths, &SETUP)?);
    body += &scene::tables(&text);
    body += &scene::text(&text);
    body += &pictures(&paths, &WORK)?;
    body += &fields::fields(&paths, run.dimension)?;
    body += &pictures(&paths, &REST)?;
    let units = &run.units;
    body += &values("Balances", "balance", &run.balance, units);
    body += &values(
        "Rates of outflow at the end",
        "outflow",
        &run.outflow,
        units,
    );
    body += &values("What broke", "results", &run.results, units);
    body += &values("Coupling", "coupling", &run.coupling, units);
    body += &values("Stability limit", "limit", &run.limit, units);
    body += &values("Counters", "counters", &run.counters, units);
    body += &values("Seconds per phase", "timers", &run.timers, units);
    let name = scene::title(&text).map_or_else(String::new, |title| format!(": {title}"));
    let title = format!("Run of {}{name}", run.case);
    let place = folder.join("report.html");
    let page = page(&title, &body);
    // The next run replaces the page too: it would show results that are gone.
    let _list = Manifest::resume(folder)?;
    write_atomically(&place, |out| out.write_all(page.as_bytes()))?;
    Ok(place)
}

/// What a run found.
///
/// # Errors
/// [`StudyError::NoRun`] if the folder has no readable summary.json.
pub(super) fn summary(folder: &Path) -> Result<Summary, StudyError> {
    let no_run = |reason: String| StudyError::NoRun {
        folder: folder.to_owned(),
        reason: format!("summary.json: {reason}"),
    };
    let text = std::fs::read_to_string(folder.join("summary.json"))
        .map_err(|error| no_run(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| no_run(error.to_string()))
}

fn head(run: &Summary) -> String {
    let mut plan = Table::new("What ran", &["", ""]);
    let mut row = |name: &str, value: String| plan.rows.push(vec![name.to_owned(), value]);
    row("scheme", run.scheme.clone());
    row("solver", run.solver.clone().unwrap_or("none".to_owned()));
    if let Some(reason) = &run.solver_reason {
        row("why this solver", reason.clone());
    }
    row("flow operator", run.operator.to_string());
    for (name, number) in [
        ("dimension", run.dimension as f64),
        ("points", run.points as f64),
        ("unknowns", run.unknowns as f64),
        ("bonds", run.bonds as f64),
        ("nonzeros", run.nonzeros as f64),
        ("steps", run.steps as f64),
        ("rejected", run.rejected as f64),
    ] {
        row(name, count(number));
    }
    row("time reached", format!("{} s", run.t_end));
    row("wall time", seconds(run.wall_s));
    let machine = Machine::here();
    format!(
        "<p class=\"note\">Run by perifrac {}; reported on {}.</p>\n{}",
        escape(&run.version),
        escape(&machine.to_string()),
        table(&plan)
    )
}

fn warnings(run: &Summary) -> String {
    let lines = run.warnings.iter();
    let lines: String = lines
        .map(|line| format!("<li>{}</li>\n", escape(line)))
        .collect();
    match lines.is_empty() {
        true => paragraph("No warnings."),
        false => format!("<h2>Warnings</h2>\n<ul>\n{lines}</ul>\n"),
    }
}

fn errors(run: &Summary) -> String {
    let mut errors = Table::new(
        "Errors against the exact solution at every output, relative to its range",
        &[
            "time [s]",
            "field",
            "root mean square",
            "largest",
            "points compared",
        ],
    );
    for output in &run.errors_over_time {
        for (field, error) in &output.errors {
            errors.rows.push(vec![
                format!("{}", output.time),
                field.to_string(),
                short(error.l2),
                short(error.max),
                count(error.compared as f64),
            ]);
        }
    }
    match errors.rows.is_empty() {
        true => String::new(),
        false => format!("<h2>Errors</h2>\n{}", table(&errors)),
    }
}

/// A part of the page: its heading, and start and end of the names of its pictures.
type Part = (&'static str, &'static str, &'static str);

/// Points and conditions, and what the rock was like.
const SETUP: [Part; 2] = [("", "setup", "png"), ("", "permeability", "png")];

/// What the work was.
const WORK: [Part; 2] = [
    ("Force and displacement", "force-", "svg"),
    ("Cracks over time", "history-crack-", "svg"),
];

/// What else was drawn.
const REST: [Part; 5] = [
    ("Profiles", "profile-", "svg"),
    ("Cracks", "crack-", "svg"),
    ("Crack surface", "crack-surface", "png"),
    ("Damage over time", "damage-over-time", "png"),
    ("Histories", "history-", "svg"),
];

/// Files in the folder of a run, in the order of their names.
pub(super) fn listed(folder: &Path) -> Result<Vec<PathBuf>, StudyError> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| OutputError::from_io(folder, "list", error))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort_unstable();
    Ok(paths)
}

/// Drawings as they are, pictures as data.
fn pictures(paths: &[PathBuf], parts: &[Part]) -> Result<String, StudyError> {
    let mut text = String::new();
    for (title, start, end) in parts {
        let own: Vec<&PathBuf> = paths.iter().filter(|path| fits(path, start, end)).collect();
        if !own.is_empty() && !title.is_empty() {
            text += &format!("<h2>{title}</h2>\n");
        }
        for path in own {
            let bytes =
                std::fs::read(path).map_err(|error| OutputError::from_io(path, "read", error))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            text += &match *end {
                "svg" => figure(&String::from_utf8_lossy(&bytes), None, &name),
                _ => image(&bytes, &name),
            };
        }
    }
    Ok(text)
}

fn fits(path: &Path, start: &str, end: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // What has a part of its own is not shown again.
    let own = |part: &&Part| part.1.len() > start.len() && name.starts_with(part.1);
    let elsewhere = start.starts_with("history-") && WORK.iter().any(|part| own(&part));
    name.starts_with(start)
        && !elsewhere
        && path.extension().is_some_and(|extension| extension == end)
}

fn image(bytes: &[u8], name: &str) -> String {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    let name = escape(name);
    format!(
        "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{data}\"><figcaption>{name}\
         </figcaption></figure>\n"
    )
}

/// A table of the figures of a part of a summary, each with its unit where it has one; nothing where there
/// are none.
fn values<T: Serialize>(title: &str, key: &str, part: &T, units: &BTreeMap<Name, Name>) -> String {
    let mut flat = Table::new(title, &["", "", ""]);
    let part = serde_json::to_value(part).unwrap_or_default();
    flatten("", &part, &mut flat.rows);
    for row in &mut flat.rows {
        let own = units.get(&*format!("{key}.{}", row[0]));
        let unit = own.or(units.get(key)).map_or("", |unit| unit);
        row.push(unit.to_owned());
    }
    match flat.rows.is_empty() {
        true => String::new(),
        false => format!("<h2>{}</h2>\n{}", escape(title), table(&flat)),
    }
}

fn flatten(name: &str, value: &Value, rows: &mut Vec<Vec<String>>) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let name = if name.is_empty() {
                    key.clone()
                } else {
                    format!("{name} · {key}")
                };
                flatten(&name, value, rows);
            }
        }
        Value::Null => {}
        Value::String(words) => rows.push(vec![name.to_owned(), words.clone()]),
        other => rows.push(vec![name.to_owned(), other.to_string()]),
    }
}
