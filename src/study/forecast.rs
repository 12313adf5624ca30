//! Which scheme, solver and step reach an error, and what that will cost, from a short calibration.

use std::collections::BTreeMap;

use serde::Serialize;

use super::findings::seconds;
use super::{Fit, Measured, Options, Study, StudyCase, StudyError, Variant, cost::Cost};

/// A recommendation with its grounds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Forecast {
    /// Error asked for: root mean square over the range, the largest of all fields and outputs.
    pub error: f64,
    /// Scheme and solver.
    pub method: String,
    /// Spacing, m.
    pub spacing: f64,
    /// Tolerance of the steps; `None` for a scheme at its stability limit.
    pub tolerance: Option<f64>,
    /// Command that does it.
    pub command: String,
    /// Expected wall time, s.
    pub seconds: f64,
    /// Between which it lies, s: the worst residual of the fits, or twice both ways where they have none.
    pub interval: (f64, f64),
    /// How sure that is, in words.
    pub confidence: &'static str,
    /// Runs of the calibration.
    pub runs: usize,
    /// The other methods with their expected seconds.
    pub others: BTreeMap<String, f64>,
}

/// Variants of the calibration: coarse clouds of the study of cost, at two tolerances.
///
/// # Errors
/// [`StudyError::Unsuited`] as the study of cost.
pub(crate) fn calibration(
    subject: &StudyCase,
    options: &Options,
) -> Result<Vec<Variant>, StudyError> {
    Cost.variants(
        subject,
        &Options {
            quick: true,
            ..options.clone()
        },
    )
}

/// Gives the runs of a calibration the errors that only their comparison can tell.
pub(crate) fn compare_costs(runs: &mut [Measured]) {
    Cost.compare(runs);
}

/// The cheapest method for an error, by power laws through the runs of the calibration.
///
/// Error grows with the spacing, cost with the number of points; both exponents are fitted over clouds
/// at the smallest tolerance. A method with one cloud takes the exponents of theory.
///
/// # Errors
/// [`StudyError::Unsuited`] if no run of the calibration reached its end.
pub(crate) fn forecast(
    subject: &StudyCase,
    runs: &[Measured],
    error: f64,
) -> Result<Forecast, StudyError> {
    let mut methods: BTreeMap<String, Vec<&Measured>> = BTreeMap::new();
    for run in runs.iter().filter(|run| run.resolved()) {
        methods.entry(run.variant.method()).or_default().push(run);
    }
    let guesses: Vec<(Guess, String)> = methods
        .iter()
        .flat_map(|(name, runs)| guesses(runs, error, subject).map(|guess| (guess, name.clone())))
        .collect();
    let best = guesses
        .iter()
        .min_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds));
    let Some((best, method)) = best else {
        return Err(StudyError::Unsuited {
            study: "the forecast",
            case: subject.plan.case.clone(),
            reason: format!(
                "no run of the calibration says how to reach {error:.1e}: their error does not fall \
                 with the spacing, or none reached its end in time; see `perifrac study cost`"
            ),
        });
    };
    let mut others: BTreeMap<String, f64> = BTreeMap::new();
    for (guess, name) in guesses.iter().filter(|(_, name)| name != method) {
        let least = others.entry(name.clone()).or_insert(f64::INFINITY);
        *least = least.min(guess.seconds);
    }
    Ok(Forecast {
        error,
        method: method.clone(),
        spacing: guess_spacing(subject, best.spacing),
        tolerance: best.tolerance,
        command: command(subject, best),
        seconds: best.seconds,
        interval: (
            best.seconds / best.uncertainty,
            best.seconds * best.uncertainty,
        ),
        confidence: best.confidence(),
        runs: runs.iter().filter(|run| run.done()).count(),
        others,
    })
}

/// A way to reach the error.
#[derive(Debug, Clone)]
struct Guess {
    spacing: f64,
    tolerance: Option<f64>,
    seconds: f64,
    /// Factor of the interval.
    uncertainty: f64,
    /// Points asked for over the most that were run.
    beyond: f64,
    overrides: Vec<String>,
}

/// One guess per tolerance of a method.
fn guesses<'a>(
    runs: &'a [&'a Measured],
    error: f64,
    subject: &'a StudyCase,
) -> impl Iterator<Item = Guess> + 'a {
    let mut tolerances: Vec<u64> = runs
        .iter()
        .map(|run| run.variant.value("tolerance").to_bits())
        .collect();
    tolerances.sort_unstable();
    tolerances.dedup();
    let dimension = subject.plan.dimension as f64;
    tolerances.into_iter().filter_map(move |bits| {
        let of = |run: &&&Measured| run.variant.value("tolerance").to_bits() == bits;
        let mut own: Vec<&Measured> = runs.iter().filter(of).copied().collect();
        own.sort_by(|a, b| {
            b.variant
                .value("spacing")
                .total_cmp(&a.variant.value("spacing"))
        });
        let finest = *own.last()?;
        let place = finest.variant.value("spacing");
        let pairs = |measure: fn(&Measured) -> f64| -> Vec<(f64, f64)> {
            own.iter()
                .map(|run| (run.variant.value("spacing"), measure(run)))
                .collect()
        };
        let explicit = finest.variant.scheme == "explicit";
        let (errors, costs) = (pairs(Measured::error), pairs(Measured::seconds));
        // Theory: second order; cost as the points, times as many steps where a limit rules them.
        let order = Fit::of(&errors).map_or(2.0, |fit| fit.slope);
        let theory = -dimension - if explicit { 2.0 } else { 0.0 };
        let measured = Fit::of(&costs).map(|fit| fit.slope);
        // Short runs are mostly start-up, so beyond them cost grows at least as the points do.
        let growth = measured.map_or(theory, |slope| slope.min(-dimension));
        // Where the error does not fall with the spacing, the steps rule it: only what was run counts.
        let spacing = match (finest.error() <= error, order > 0.5) {
            (true, _) => own
                .iter()
                .find(|run| run.error() <= error)?
                .variant
                .value("spacing"),
            (false, true) => place * (error / finest.error()).powf(1.0 / order),
            (false, false) => return None,
        };
        let known = own
            .iter()
            .find(|run| (run.variant.value("spacing") - spacing).abs() < 1e-12);
        let expected = finest.seconds() * (spacing / place).powf(growth);
        let spread = measured.map_or(1.0, |slope| (slope - growth).abs().max(0.3));
        let ratio = (place / spacing).max(1.0);
        Some(Guess {
            spacing,
            tolerance: Some(finest.variant.value("tolerance")).filter(|t| t.is_finite()),
            seconds: known.map_or(expected, |run| run.seconds()),
            uncertainty: if known.is_some() {
                1.3
            } else {
                1.3 * ratio.powf(spread)
            },
            beyond: ratio.powf(dimension),
            overrides: finest.variant.overrides.clone(),
        })
    })
}

impl Guess {
    fn confidence(&self) -> &'static str {
        match self.beyond {
            beyond if beyond < 1.01 => "sure: such a run was part of the calibration",
            beyond if beyond < 10.0 => "fairly sure: less than ten times the points that were run",
            beyond if beyond < 100.0 => {
                "unsure: up to a hundred times the points that were run; `perifrac study cost` knows more"
            }
            _ => "a guess: more than a hundred times the points that were run",
        }
    }
}

/// A spacing that divides the domain, not above the one wanted.
fn guess_spacing(subject: &StudyCase, wanted: f64) -> f64 {
    subject
        .grid_within(wanted)
        .map_or(wanted, |grid| grid.spacing)
}

fn command(subject: &StudyCase, guess: &Guess) -> String {
    let mut words = vec![format!("perifrac run {}", subject.scene)];
    let grid = subject
        .grid_within(guess.spacing)
        .and_then(|grid| grid.overrides);
    let own = guess
        .overrides
        .iter()
        .filter(|text| !text.starts_with("geometry.") && !text.starts_with("output."));
    for text in subject.overrides.iter().chain(own).chain(grid.as_ref()) {
        words.push(format!("--set '{text}'"));
    }
    words.join(" ")
}

impl std::fmt::Display for Forecast {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "for an error of {:.1e}: {}", self.error, self.method)?;
        write!(f, "  spacing    {:.4e} m", self.spacing)?;
        match self.tolerance {
            Some(tolerance) => writeln!(f, ", tolerance of steps {tolerance:.0e}")?,
            None => writeln!(f, ", steps at 0.9 of the stability limit")?,
        }
        let (low, high) = self.interval;
        writeln!(
            f,
            "  cost       {} ({} to {})",
            seconds(self.seconds),
            seconds(low),
            seconds(high)
        )?;
        writeln!(f, "  confidence {}", self.confidence)?;
        for (name, cost) in &self.others {
            writeln!(f, "  instead    {name}: {}", seconds(*cost))?;
        }
        writeln!(
            f,
            "  grounds    {} runs of calibration on this machine",
            self.runs
        )?;
        write!(f, "  command    {}", self.command)
    }
}
