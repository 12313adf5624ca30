//! One of the runs of a study.

use std::collections::BTreeMap;

use super::profile::RecordedOutput;

/// One of the runs of a study: what it is called and which keys of the scene it sets.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Variant {
    /// Scheme with its integrator, as in legends.
    pub scheme: String,
    /// Linear solver; `-` without one.
    pub solver: String,
    /// How the method is set, where the study tries several ways; `None` for what the program takes by itself.
    pub setting: Option<&'static str>,
    /// Flow operator, where the study varies it.
    pub operator: Option<String>,
    /// What it varies beyond that, such as `tolerance` or `contrast`, for tables and axes.
    pub values: BTreeMap<&'static str, f64>,
    /// Keys and values for `--set`.
    pub overrides: Vec<String>,
    /// Guess of its cost, in any unit: of a method cheap runs come first, and where one takes too long its dearer
    /// sisters are skipped.
    pub weight: f64,
    /// Which of its fields are kept, to compare runs with each other.
    pub kept: RecordedOutput,
    /// Whether one run is enough, because its seconds do not matter.
    pub once: bool,
}

impl Variant {
    /// Scheme, solver and operator: what a curve in a picture stands for.
    pub(crate) fn method(&self) -> String {
        let parts = [
            Some(&self.scheme),
            Some(&self.solver),
            self.operator.as_ref(),
        ];
        let parts: Vec<&str> = parts.into_iter().flatten().map(String::as_str).collect();
        parts
            .into_iter()
            .filter(|part| *part != "-")
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// A value that it varies.
    pub(crate) fn value(&self, name: &str) -> f64 {
        self.values.get(name).copied().unwrap_or(f64::NAN)
    }

    /// Adds overrides.
    pub(crate) fn set(mut self, overrides: impl IntoIterator<Item = String>) -> Self {
        self.overrides.extend(overrides);
        self
    }

    /// Names a value that it varies.
    pub(crate) fn with(mut self, name: &'static str, value: f64) -> Self {
        self.values.insert(name, value);
        self
    }
}

/// What is added to the name of a scheme whose dynamic relaxation is that of the paper.
pub(crate) const PRINTED: &str = " as printed";

/// Dynamic relaxation by the stiffness that the last step showed at every point (Eqs. 65 to 68), to one tolerance.
const LOCAL_DAMPING: [&str; 2] = ["scheme.adr_damping=local", "scheme.adr_tolerance=1e-6"];

/// A way to step through time, as the studies call and set it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Method {
    /// Name on the command line.
    pub scheme: &'static str,
    /// Integrator, if the scheme has one.
    pub integrator: Option<&'static str>,
    /// Whether dynamic relaxation is that of the paper.
    pub printed: bool,
}

impl Method {
    /// A scheme with its integrator, as the program takes it by itself.
    pub(crate) const fn new(scheme: &'static str, integrator: Option<&'static str>) -> Self {
        Method {
            scheme,
            integrator,
            printed: false,
        }
    }

    /// As in legends.
    pub(crate) fn label(&self) -> String {
        match self.integrator {
            Some("tr-bdf2") => format!("{} TR-BDF2", self.scheme),
            Some("backward-euler") => format!("{} backward Euler", self.scheme),
            _ if self.printed => format!("{}{PRINTED}", self.scheme),
            _ => self.scheme.to_owned(),
        }
    }

    /// Its overrides.
    pub(crate) fn overrides(&self) -> Vec<String> {
        let scheme = [format!("scheme.name=\"{}\"", self.scheme)];
        let integrator = self
            .integrator
            .map(|name| format!("time.integrator=\"{name}\""));
        let printed = LOCAL_DAMPING.iter().filter(|_| self.printed);
        let printed = printed.map(|text| (*text).to_owned());
        scheme
            .into_iter()
            .chain(integrator)
            .chain(printed)
            .collect()
    }

    /// Order in time.
    pub(crate) fn order(&self) -> f64 {
        match self.integrator {
            Some("tr-bdf2") => 2.0,
            _ => 1.0,
        }
    }

    /// A variant that runs by this method, with the solver unless it needs none.
    pub(crate) fn variant(&self, solver: Option<&str>) -> Variant {
        let solver = solver.filter(|_| self.scheme != "explicit");
        Variant {
            scheme: self.label(),
            solver: solver.unwrap_or("-").to_owned(),
            overrides: self.overrides(),
            ..Variant::default()
        }
        .set(solver.map(|name| format!("solver.name=\"{name}\"")))
    }
}
