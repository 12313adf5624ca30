//! Pages that need nothing but themselves: no network, no script.

use super::findings::{ReportContent, Section, Table, count, plain, seconds, short};
use super::{Coverage, Machine, Measured, Request, StudyCase};

/// Screen, phone, print; colours of text and lines only, the drawings bring their own.
const STYLE: &str = "\
:root{color-scheme:light}*{box-sizing:border-box}\
body{margin:0 auto;max-width:66rem;padding:1rem;background:#fff;color:#1a1a1a;\
font:16px/1.5 'DejaVu Sans',Verdana,system-ui,sans-serif;overflow-wrap:break-word}\
h1{font-size:1.6rem;line-height:1.2;margin:.5rem 0}h2{font-size:1.25rem;margin:2rem 0 .5rem}\
p,ul{margin:.5rem 0}li{margin:.2rem 0}.note{color:#555;font-size:.9rem}\
.lead{border-left:4px solid #0072b2;padding:.2rem 0 .2rem 1rem;list-style:none;margin-left:0}\
figure{margin:1rem 0}.wide{overflow-x:auto}\
figure svg{display:block;width:100%;height:auto}figure .narrow{display:none}\
figure img{display:block;max-width:100%;height:auto}\
figcaption,.caption{color:#555;font-size:.9rem;text-align:left;padding:.3rem 0}\
.caption{margin:1rem 0 0}table{border-collapse:collapse;font-size:.8rem;width:100%}\
th,td{padding:.3rem .5rem .3rem 0;border-bottom:1px solid #ddd;text-align:left;vertical-align:top}\
th{border-bottom:2px solid #999}td{font-variant-numeric:tabular-nums}th,td{min-width:5rem}th{overflow-wrap:anywhere}\
th.whole,td.whole{white-space:nowrap;min-width:0}\
code{font-size:.85em;overflow-wrap:anywhere}details{margin:1rem 0}summary{cursor:pointer}\
@media screen and (max-width:48rem){figure .broad{display:none}figure .narrow{display:block}\
thead{display:none}tr{display:block;border-bottom:2px solid #999;padding:.4rem 0}\
td{display:flex;gap:1rem;border:0;padding:.1rem 0;min-width:0}td.whole{white-space:normal}\
td::before{content:attr(data-name);flex:0 0 8.5rem;color:#555}}\
@media print{body{max-width:none;padding:0;font-size:11px}figure,tr{break-inside:avoid}\
h1{font-size:18px}h2{font-size:14px;margin:1rem 0 .3rem}.note,figcaption,.caption{font-size:10px}\
h2,.caption{break-after:avoid}thead{display:table-header-group}table{font-size:8px}\
figure svg{max-width:16cm}th,td{min-width:4rem;padding-right:.3rem}\
.wide{overflow:visible}details>*{display:block}}";

/// Text with what HTML would take as its own replaced.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A whole page.
pub(super) fn page(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{body}</body>\n\
         </html>\n",
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
        let varied = variant
            .values
            .iter()
            .map(|(name, value)| format!("{} {}", name.replace('_', " "), plain(*value)));
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
