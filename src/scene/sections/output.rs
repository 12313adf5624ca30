//! `[output]`: what is written, and when.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, Time, values};
use crate::scene::range::{Range, within};
use crate::scene::span::{Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// What is written, and when. The state at the end is always written.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Times at which fields are written, s; those after `time.end` are left out. Excludes `every`.
    pub times: Option<Spanned<Vec<Time>>>,
    /// Interval at which fields are written, s. Excludes `times`.
    pub every: Option<Time>,
    /// Growth of the cracks after which fields are written too, m; in space their area grows by its
    /// square. Needs `[damage]`.
    pub crack_increment: Option<Length>,
    /// Whether files of fields are written.
    pub vtu: bool,
    /// Format of the files of fields.
    pub format: Spanned<Format>,
    /// Whether pictures are drawn.
    pub plots: bool,
    /// Points at which fields are recorded in every step.
    pub probes: Named<Probe>,
    /// Lines along which fields are recorded at every output.
    pub profiles: Named<Profile>,
}

impl Default for Output {
    fn default() -> Self {
        let (probes, profiles) = (Named::default(), Named::default());
        Self {
            times: None,
            every: None,
            crack_increment: None,
            vtu: true,
            format: Spanned::default(),
            plots: true,
            probes,
            profiles,
        }
    }
}

/// Formats of files of fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// A `.vtu` for every output, and `fields.pvd` with their times.
    #[default]
    Vtu,
    /// One `fields.vtkhdf` with all outputs, of one process; needs a program built with the feature `vtkhdf`.
    Vtkhdf,
}

/// A point at which fields are recorded.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Position, m.
    pub at: Spanned<Vec<Length>>,
}

/// A line along which fields are recorded.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Start, m.
    pub from: Spanned<Vec<Length>>,
    /// End, m.
    pub to: Spanned<Vec<Length>>,
    /// Number of positions, both ends among them.
    #[schemars(transform = within(&POSITIONS))]
    #[serde(default = "two_hundred")]
    pub points: Spanned<u64>,
}

fn two_hundred() -> Spanned<u64> {
    Spanned::nowhere(200)
}

impl Section for Output {
    const NAME: &'static str = "output";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.at_most_one(&[
            ("times", self.times.as_ref().map(|times| times.span)),
            ("every", self.every.map(|every| every.span())),
        ]);
        self.check_format(report);
        let end = scene.sound(&scene.draft.time).and_then(|time| time.end);
        if let Some(every) = self.every {
            report.positive("every", every);
            check_count(every, end, report);
        }
        for time in self.times.iter().flat_map(|times| times.iter()) {
            report.not_negative("times", *time);
        }
        if let Some(increment) = self.crack_increment {
            report.positive("crack_increment", increment);
            if !scene.has(&scene.draft.damage) {
                let fault = Diagnostic::new("`crack_increment` needs [damage]");
                report.add(
                    fault
                        .at(increment.span())
                        .help("add [damage], or leave it out"),
                );
            }
        }
        report.names(&self.probes);
        report.names(&self.profiles);
        for probe in &self.probes {
            report.position("at", &probe.value.at, scene);
        }
        for profile in &self.profiles {
            check_profile(&profile.value, scene, report);
        }
    }
}

impl Output {
    fn check_format(&self, report: &mut Report) {
        if self.format.value != Format::Vtkhdf {
            return;
        }
        if !cfg!(feature = "vtkhdf") {
            let fault = Diagnostic::new("this program was built without the feature `vtkhdf`");
            let fault = fault.at(self.format.span);
            report.add(fault.help(
                "leave `format` out, or build with --features vtkhdf, which needs libhdf5 (Debian: libhdf5-dev)",
            ));
        }
        if !self.vtu {
            let fault =
                Diagnostic::new("`format` is that of fields, and `vtu = false` leaves them out");
            report.add(fault.at(self.format.span).help("keep one of them"));
        }
    }
}

/// Outputs are files: so many of them are a slip of the pen.
const MOST_OUTPUTS: f64 = 1e5;
const POSITIONS: Range = Range {
    key: "points",
    low: 2.0,
    high: 1e5,
    why: "a line has two ends, and no cloud resolves more places along it",
};

fn check_count(every: Time, end: Option<Time>, report: &mut Report) {
    let Some(end) = end.filter(|_| every.value() > 0.0) else {
        return;
    };
    let count = end.value() / every.value();
    if count > MOST_OUTPUTS {
        let fault = Diagnostic::new(format!("`every` gives {count:.1e} outputs")).at(every.span());
        let fault = fault.also(end.span(), "the run ends here");
        report.add(fault.help(format!("at most {MOST_OUTPUTS:.0} are written")));
    }
}

fn check_profile(profile: &Profile, scene: &Context<'_>, report: &mut Report) {
    report.position("from", &profile.from, scene);
    report.position("to", &profile.to, scene);
    POSITIONS.check_count(profile.points, report);
    let (from, to) = (values(&profile.from), values(&profile.to));
    if from.len() != to.len() {
        report.vector("to", &profile.to, Some(from.len()));
    } else if from
        .iter()
        .zip(&to)
        .all(|(start, end)| start.total_cmp(end).is_eq())
    {
        let fault = Diagnostic::new("`from` and `to` are the same position").at(profile.to.span);
        report.add(fault.also(profile.from.span, "`from`"));
    }
}
