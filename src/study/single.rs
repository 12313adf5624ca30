//! `perifrac report`: what a run left, on one page.

use std::path::{Path, PathBuf};

use base64::Engine;
use serde_json::Value;

use super::findings::{Table, count, seconds, short};
use super::html::{escape, figure, page, paragraph, table};
use super::{Machine, StudyError};
use crate::output::{Manifest, OutputError, write_atomically};

/// Writes `report.html` into the folder of a run, from the files the run left there.
///
/// # Errors
/// [`StudyError::NoRun`] if the folder has no readable summary.json, [`StudyError::Output`] if the
/// page cannot be written.
pub fn report_run(folder: &Path) -> Result<PathBuf, StudyError> {
    let no_run = |reason: String| StudyError::NoRun {
        folder: folder.to_owned(),
        reason,
    };
    let text = std::fs::read_to_string(folder.join("summary.json"))
        .map_err(|error| no_run(format!("summary.json: {error}")))?;
    let summary: Value =
        serde_json::from_str(&text).map_err(|error| no_run(format!("summary.json: {error}")))?;
    let scene = std::fs::read_to_string(folder.join("resolved.toml")).unwrap_or_default();
    let mut body = head(&summary);
    body += &warnings(&summary);
    body += &errors(&summary);
    body += &pictures(folder)?;
    for (title, key) in [
        ("Balances", "balance"),
        ("Rates of outflow at the end", "outflow"),
        ("What broke", "results"),
        ("Coupling", "coupling"),
        ("Stability limit", "limit"),
        ("Counters", "counters"),
        ("Seconds per phase", "timers"),
    ] {
        body += &values(title, key, &summary);
    }
    if !scene.is_empty() {
        body += &format!(
            "<h2>Scene</h2>\n<details><summary>resolved.toml: running it again gives the same \
             bits</summary><pre class=\"wide\">{}</pre></details>\n",
            escape(&scene)
        );
    }
    let title = format!("Run of {}", summary["case"].as_str().unwrap_or("a scene"));
    let place = folder.join("report.html");
    let page = page(&title, &body);
    // The next run replaces the page too: it would show results that are gone.
    let _list = Manifest::resume(folder)?;
    write_atomically(&place, |out| out.write_all(page.as_bytes()))?;
    Ok(place)
}

fn text<'a>(summary: &'a Value, key: &str) -> &'a str {
    summary[key].as_str().unwrap_or("none")
}

fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or(f64::NAN)
}

fn head(summary: &Value) -> String {
    let mut plan = Table::new("What ran", &["", ""]);
    let mut row = |name: &str, value: String| plan.rows.push(vec![name.to_owned(), value]);
    row("scheme", text(summary, "scheme").to_owned());
    row("solver", text(summary, "solver").to_owned());
    if let Some(reason) = summary["solver_reason"].as_str() {
        row("why this solver", reason.to_owned());
    }
    row("flow operator", text(summary, "operator").to_owned());
    for name in [
        "dimension",
        "points",
        "unknowns",
        "bonds",
        "nonzeros",
        "steps",
        "rejected",
    ] {
        row(name, count(number(summary, name)));
    }
    row("time reached", format!("{} s", number(summary, "t_end")));
    row("wall time", seconds(number(summary, "wall_s")));
    let version = text(summary, "version");
    let machine = Machine::here();
    format!(
        "<p class=\"note\">Run by perifrac {}; reported on {}.</p>\n{}",
        escape(version),
        escape(&machine.to_string()),
        table(&plan)
    )
}

fn warnings(summary: &Value) -> String {
    let warnings = summary["warnings"].as_array().into_iter().flatten();
    let lines: String = warnings
        .filter_map(Value::as_str)
        .map(|line| format!("<li>{}</li>\n", escape(line)))
        .collect();
    match lines.is_empty() {
        true => paragraph("No warnings."),
        false => format!("<h2>Warnings</h2>\n<ul>\n{lines}</ul>\n"),
    }
}

fn errors(summary: &Value) -> String {
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
    for output in summary["errors_over_time"].as_array().into_iter().flatten() {
        let fields = output.as_object().into_iter().flatten();
        for (field, error) in fields.filter(|(_, error)| error.is_object()) {
            errors.rows.push(vec![
                format!("{}", number(output, "time")),
                field.clone(),
                short(number(error, "l2")),
                short(number(error, "max")),
                count(number(error, "compared")),
            ]);
        }
    }
    match errors.rows.is_empty() {
        true => String::new(),
        false => format!("<h2>Errors</h2>\n{}", table(&errors)),
    }
}

/// Profiles and histories first, then the fields; drawings as they are, pictures as data.
fn pictures(folder: &Path) -> Result<String, StudyError> {
    let entries =
        std::fs::read_dir(folder).map_err(|error| OutputError::from_io(folder, "list", error))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut text = String::new();
    for (title, start, end) in [
        ("Profiles", "profile-", "svg"),
        ("Cracks", "crack-", "svg"),
        ("Histories", "history-", "svg"),
        ("Fields", "", "png"),
    ] {
        let own: Vec<&PathBuf> = paths.iter().filter(|path| fits(path, start, end)).collect();
        if own.is_empty() {
            continue;
        }
        text += &format!("<h2>{title}</h2>\n");
        for path in own {
            let bytes =
                std::fs::read(path).map_err(|error| OutputError::from_io(path, "read", error))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            text += &match end {
                "svg" => figure(&String::from_utf8_lossy(&bytes), None, &name),
                _ => image(&bytes, &name),
            };
        }
    }
    Ok(text)
}

fn fits(path: &Path, start: &str, end: &str) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(start) && path.extension().is_some_and(|extension| extension == end)
}

fn image(bytes: &[u8], name: &str) -> String {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    let name = escape(name);
    format!(
        "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{data}\"><figcaption>{name}\
         </figcaption></figure>\n"
    )
}

/// All numbers below a key, as a table; nothing where there are none.
/// A table of the figures under a key of a summary, each with its unit where it has one.
fn values(title: &str, key: &str, summary: &Value) -> String {
    let mut flat = Table::new(title, &["", "", ""]);
    flatten("", &summary[key], &mut flat.rows);
    let units = &summary["units"];
    for row in &mut flat.rows {
        let own = units[format!("{key}.{}", row[0])].as_str();
        let unit = own.or(units[key].as_str()).unwrap_or_default();
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
