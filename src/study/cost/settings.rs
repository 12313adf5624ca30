//! Settings of a method that cost time: what the program takes by itself, and what may be cheaper.

use crate::plan::{StepRule, TimeMode};
use crate::study::{Method, Options, StudyCase, Variant};

/// One way to set a method, run on every cloud until another one does it for less.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting {
    /// As in tables; `None` for what the program takes by itself.
    name: Option<&'static str>,
    overrides: &'static [&'static str],
    steps: Steps,
}

/// What the runs of a setting differ by on one cloud.
#[derive(Debug, Clone, Copy)]
enum Steps {
    /// Nothing.
    Own,
    /// `time.tolerance`.
    Adaptive,
    /// `time.step`.
    Constant,
}

const OWN: Setting = Setting {
    name: None,
    overrides: &[],
    steps: Steps::Own,
};
const ADAPTIVE: Setting = Setting {
    steps: Steps::Adaptive,
    ..OWN
};
const CONSTANT: Setting = Setting {
    name: Some("constant steps"),
    steps: Steps::Constant,
    ..OWN
};

/// Where explicit steps of coupled runs may be cheaper than by the defaults.
const EXPLICIT: [Setting; 4] = [
    OWN,
    Setting {
        name: Some("relaxed to 1e-5"),
        overrides: &["scheme.adr_tolerance=1e-5"],
        ..OWN
    },
    Setting {
        name: Some("local damping, smoothed by 0.1"),
        overrides: &["scheme.adr_damping=local", "scheme.adr_smoothing=0.1"],
        ..OWN
    },
    Setting {
        name: Some("Verlet"),
        overrides: &["scheme.solid=verlet"],
        ..OWN
    },
];
const SEMI_IMPLICIT: [Setting; 4] = [
    ADAPTIVE,
    CONSTANT,
    Setting {
        name: Some("relaxed to 1e-5"),
        overrides: &["scheme.adr_tolerance=1e-5"],
        ..ADAPTIVE
    },
    Setting {
        name: Some("constant steps, relaxed to 1e-5"),
        overrides: &["scheme.adr_tolerance=1e-5"],
        ..CONSTANT
    },
];
const STAGGERED: [Setting; 3] = [
    ADAPTIVE,
    CONSTANT,
    Setting {
        name: Some("constant steps, fields agree to 1e-6"),
        overrides: &["scheme.coupling_tolerance=1e-6"],
        ..CONSTANT
    },
];

const TOLERANCES: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// Constant steps over the run, for about the errors of these tolerances by a method of second order.
const COUNTS: [f64; 3] = [12.0, 36.0, 120.0];

impl Setting {
    /// Those of a method: the defaults first.
    pub(super) fn of(method: &Method, subject: &StudyCase, options: &Options) -> Vec<Self> {
        let all: &[Self] = match (method.integrator, method.scheme) {
            _ if subject.plan.time.mode != TimeMode::Transient => &[OWN],
            (None, _) if method.printed || !subject.is_coupled() => &[OWN],
            (None, _) => &EXPLICIT,
            (_, "semi-implicit") => &SEMI_IMPLICIT,
            (_, "staggered") => &STAGGERED,
            _ => &[ADAPTIVE, CONSTANT],
        };
        // Steps that the scene fixes are what the program takes by itself, and have no tolerance.
        let fixed = matches!(subject.plan.time.step, StepRule::Fixed(_));
        let wanted = all.iter().map(|own| match own.steps {
            Steps::Adaptive if fixed => Setting {
                steps: Steps::Own,
                ..*own
            },
            _ => *own,
        });
        let wanted = wanted.filter(|own| match own.steps {
            Steps::Adaptive => true,
            Steps::Constant => !options.quick || own.overrides.is_empty(),
            Steps::Own => !options.quick || own.name.is_none(),
        });
        let wanted = wanted.filter(|own| !options.defaults || own.name.is_none());
        wanted.collect()
    }

    /// Runs of a method on one cloud, each with a guess of how many times longer it takes than the first.
    pub(super) fn runs(
        &self,
        variant: &Variant,
        end: f64,
        options: &Options,
    ) -> Vec<(Variant, f64)> {
        let set = |text: &&str| (*text).to_owned();
        let variant = Variant {
            setting: self.name,
            ..variant.clone().set(self.overrides.iter().map(set))
        };
        let most = if options.quick { 2 } else { 3 };
        match self.steps {
            Steps::Own => vec![(variant, 1.0)],
            Steps::Adaptive => TOLERANCES[..most]
                .iter()
                .map(|&tolerance| {
                    let text = format!("time.tolerance={tolerance:?}");
                    let run = variant.clone().set([text]).with("tolerance", tolerance);
                    (run, (TOLERANCES[0] / tolerance).powf(0.3))
                })
                .collect(),
            Steps::Constant => COUNTS[..most]
                .iter()
                .map(|&count| {
                    let step = end / count;
                    let run = variant.clone().set([format!("time.step={step:?}")]);
                    (run.with("step", step), count / COUNTS[0])
                })
                .collect(),
        }
    }
}

/// The least tolerance of runs of a study.
pub(super) fn least_tolerance(options: &Options) -> f64 {
    TOLERANCES[if options.quick { 1 } else { 2 }]
}
