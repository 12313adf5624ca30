//! Pages that need nothing but themselves: no network, and no script to be read.

use super::findings::{ReportContent, Section, Table, count, plain, seconds, short};
use super::{Coverage, Machine, Measured, Request, StudyCase};

/// Screen, phone, print.
const STYLE: &str = include_str!("page/page.css");

/// What makes charts and fields answer; pages read without it.
const SCRIPT: &str = include_str!("page/page.js");

/// Chart.js 4.6.1, which draws charts that answer.
const CHARTS: &str = include_str!("page/chart.js/chart.umd.min.js");

/// Mark of a drawing that carries its numbers.
const NUMBERS: &str = "<metadata>";

/// Start of a picture of a field over time.
pub(super) const FIELDS: &str = "<section class=\"fields\">";

/// Text with what HTML would take as its own replaced.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A whole page, with scripts where something in it answers to them.
pub(super) fn page(title: &str, body: &str) -> String {
    let charts = body.contains(NUMBERS);
    // Its last line names a file that pages do not have.
    let library = CHARTS.rsplit_once("\n//#").map_or(CHARTS, |(code, _)| code);
    let mut scripts = String::new();
    for (script, _) in [(library, charts), (SCRIPT, charts || body.contains(FIELDS))]
        .into_iter()
        .filter(|(_, wanted)| *wanted)
    {
        scripts += &format!("<script>{script}</script>\n");
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{body}{scripts}\
         </body>\n</html>\n",
        escape(title)
    )
}

/// A paragraph.
pub(super) fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// Longest text of a cell that is kept on one line.
const WHOLE: usize = 12;

/// A table; on a narrow screen every row becomes a list of its columns. Nothing without rows.
pub(super) fn table(table: &Table) -> String {
    if table.rows.is_empty() {
        return String::new();
    }
    let whole = |text: &str| match text.chars().count() <= WHOLE {
        true => " class=\"whole\"",
        false => "",
    };
    let head = table.head.iter();
    let head: String = head
        .map(|name| format!("<th{}>{}</th>", whole(name), escape(name)))
        .collect();
    let cell = |(text, name): (&String, &String)| {
        let whole = whole(text);
        let (name, text) = (escape(name), escape(text));
        format!("<td{whole} data-name=\"{name}\"><span>{text}</span></td>")
    };
    let row = |cells: &Vec<String>| {
        let cells: String = cells.iter().zip(&table.head).map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    };
    format!(
        "<p class=\"caption\">{}</p>\n<div class=\"wide\"><table>\n<thead><tr>{head}</tr></thead>\n\
         <tbody>\n{}</tbody>\n</table></div>\n",
        escape(&table.caption),
        table.rows.iter().map(row).collect::<String>()
    )
}

/// A picture with its caption, and what takes its place on a narrow screen.
pub(super) fn figure(svg: &str, narrow: Option<&str>, caption: &str) -> String {
    let caption = escape(caption);
    let drawings = match narrow {
        Some(narrow) => {
            format!("<div class=\"broad\">{svg}</div><div class=\"narrow\">{narrow}</div>")
        }
        None => format!("<div>{svg}</div>"),
    };
    format!("<figure>{drawings}<figcaption>{caption}</figcaption></figure>\n")
}

fn section(section: &Section) -> String {
    let mut text = format!("<h2>{}</h2>\n", escape(&section.title));
    text.extend(section.text.iter().map(|words| paragraph(words)));
    text.extend(
        section
            .figures
            .iter()
            .map(|it| figure(&it.svg, Some(&it.narrow), &it.caption)),
    );
    text.extend(section.tables.iter().map(table));
    text
}

/// The report of a study.
pub(super) fn study_page(
    (kind, request): (&str, &Request),
    subject: &StudyCase,
    machine: &Machine,
    findings: &ReportContent,
    runs: &[Measured],
) -> String {
    let mut body = format!(
        "<p class=\"note\">perifrac {} on {}. Command: <code>{}</code></p>\n",
        env!("CARGO_PKG_VERSION"),
        escape(&machine.to_string()),
        escape(&request.command),
    );
    body += &paragraph(&format!("{}.", request.state(&Coverage::of(runs))));
    let lines: String = findings
        .headlines
        .iter()
        .map(|line| format!("<li>{}</li>\n", escape(line)))
        .collect();
    if !lines.is_empty() {
        body += &format!("<ul class=\"lead\">\n{lines}</ul>\n");
    }
    body.extend(findings.sections.iter().map(section));
    body += &format!(
        "<h2>All runs</h2>\n<details open><summary>{} variants</summary>\n{}</details>\n",
        runs.len(),
        table(&all_runs(runs))
    );
    page(
        &format!("{} study: {}", capital(kind), subject.plan.title),
        &body,
    )
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

fn all_runs(runs: &[Measured]) -> Table {
    let mut table = Table::new(
        "One row per variant: median of its repetitions, with the range of their wall times",
        &[
            "method", "varied", "points", "error", "wall", "range", "CPU", "memory", "steps",
            "factors", "Krylov", "outcome",
        ],
    );
    for run in runs {
        let (variant, first) = (&run.variant, run.first());
        let values = variant.values.iter();
        let values =
            values.map(|(name, value)| format!("{} {}", name.replace('_', " "), plain(*value)));
        let setting = variant.setting.map(str::to_owned);
        let varied = setting.into_iter().chain(values);
        table.rows.push(vec![
            variant.method(),
            varied.collect::<Vec<_>>().join(", "),
            count(run.points()),
            short(run.error()),
            seconds(run.seconds()),
            run.range().map_or("–".to_owned(), |(least, most)| {
                format!("{} … {}", seconds(least), seconds(most))
            }),
            seconds(run.typical(|row| row.cpu_s)),
            match run.typical(|row| row.memory_bytes as f64) {
                bytes if bytes.is_finite() => format!("{:.0} MB", bytes / 1e6),
                _ => "–".to_owned(),
            },
            count(run.steps()),
            count(run.solver(|done| done.factorisations)),
            count(run.solver(|done| done.iterations)),
            match &first.reason {
                None if run.error() > 0.0 && !run.resolved() => {
                    "done; error not resolved".to_owned()
                }
                None => first.status.name().to_owned(),
                Some(reason) => format!("{}: {reason}", first.status.name()),
            },
        ]);
    }
    table
}
