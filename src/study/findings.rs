//! What a study found: numbers for programs, sections with pictures and tables for readers.

use serde_json::Value;

use crate::output::{LinePlot, NARROW, WIDE, lines_text};

/// What a study found.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReportContent {
    /// Numbers, for report.json.
    pub facts: Value,
    /// One sentence per finding, the most important one first.
    pub headlines: Vec<String>,
    /// Parts of the report.
    pub sections: Vec<Section>,
}

/// A part of a report.
#[derive(Debug, Clone, Default)]
pub(crate) struct Section {
    /// Heading.
    pub title: String,
    /// Paragraphs.
    pub text: Vec<String>,
    /// Pictures.
    pub figures: Vec<Figure>,
    /// Tables.
    pub tables: Vec<Table>,
}

/// A picture of a report.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    /// Name of its own file.
    pub file: String,
    /// What it shows.
    pub caption: String,
    /// The drawing.
    pub svg: String,
    /// The same for narrow screens.
    pub narrow: String,
}

/// A table of a report.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    /// What it holds.
    pub caption: String,
    /// Names of columns.
    pub head: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl ReportContent {
    /// Files of the pictures with their drawings.
    pub(crate) fn pictures(&self) -> impl Iterator<Item = (&str, &str)> {
        let figures = self.sections.iter().flat_map(|section| &section.figures);
        figures.map(|figure| (figure.file.as_str(), figure.svg.as_str()))
    }
}

impl Section {
    /// A part with a heading.
    pub(crate) fn new(title: &str) -> Self {
        Section {
            title: title.to_owned(),
            ..Section::default()
        }
    }

    /// Adds a picture, unless it would show nothing; a drawing that fails leaves its reason as a paragraph.
    pub(crate) fn draw(&mut self, file: &str, caption: &str, plot: &LinePlot<'_>) {
        if plot.series.iter().all(|series| series.x.is_empty()) {
            return;
        }
        let drawings = lines_text(plot, WIDE).and_then(|svg| Ok((svg, lines_text(plot, NARROW)?)));
        match drawings {
            Ok((svg, narrow)) => self.figures.push(Figure {
                file: format!("{file}.svg"),
                caption: caption.to_owned(),
                svg,
                narrow,
            }),
            Err(reason) => self
                .text
                .push(format!("The picture {file} failed: {reason}.")),
        }
    }
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(caption: &str, head: &[&str]) -> Self {
        Table {
            caption: caption.to_owned(),
            head: head.iter().map(|name| (*name).to_owned()).collect(),
            rows: Vec::new(),
        }
    }
}

/// A number of seconds as people say it.
pub(super) fn seconds(value: f64) -> String {
    match value {
        v if !v.is_finite() => "–".to_owned(),
        v if v < 0.1 => format!("{:.0} ms", 1e3 * v),
        v if v < 10.0 => format!("{v:.2} s"),
        v if v < 600.0 => format!("{v:.0} s"),
        v if v < 7200.0 => format!("{:.0} min", v / 60.0),
        v if v < 2e5 => format!("{:.1} h", v / 3600.0),
        v => format!("{:.1e} s", v),
    }
}

/// A number as people write it, to three digits: powers of ten where it is large or small.
pub(super) fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    match rounded.abs() {
        size if size.is_nan() => "–".to_owned(),
        size if (1e-2..1e4).contains(&size) || size <= 0.0 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

/// A small number, or a dash.
pub(super) fn short(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value:.2e}"),
        false => "–".to_owned(),
    }
}

/// A count, or a dash.
pub(super) fn count(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value:.0}"),
        false => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_numbers_are_short() {
        let numbers = [
            0.0,
            2.0,
            0.6666666666666666,
            1e-3,
            3.125e-5,
            1e12,
            13335.2,
            -0.5,
        ];
        let texts: Vec<String> = numbers.map(plain).into();
        let wanted = [
            "0", "2", "0.667", "1e-3", "3.13e-5", "1e12", "1.33e4", "-0.5",
        ];
        assert_eq!(texts, wanted);
        assert_eq!(plain(f64::NAN), "–");
    }
}
