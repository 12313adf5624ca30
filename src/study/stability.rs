//! Where each scheme holds: steps over the stable explicit step × coupling strength or contrast.

use std::collections::BTreeMap;

use serde_json::json;

use super::theory::{Lattice, Mode, Split};
use super::variant::Method;
use super::{
    Findings, Grid, Measured, Options, Section, Status, Study, StudyError, Subject, Table, Variant,
};
use crate::geometry::Horizon;
use crate::output::{LinePlot, LineStyle, Series};
use crate::plan::{GeometryPlan, PermeabilityPlan};

/// The study of stability.
pub struct Stability;

/// Ratio of neighbouring steps and strengths: a quarter of a decade.
const CELL: f64 = 1.778_279_410_038_922_8;
/// Where the lattice of steps and strengths is hung up, so that borders at 1 lie between two of them.
const HUNG: f64 = 0.749_894_209_332_455_8;
/// Steps of every run: modes that grow by a third per step become large.
const STEPS: u32 = 80;
/// Error above which a run that reached its end is inaccurate.
const INACCURATE: f64 = 0.05;
/// Error above which a run that reached its end has diverged all the same.
const DIVERGED: f64 = 1.0;
/// Overshoot of the pressure, relative to its range at the start, that counts as oscillation.
const OVERSHOOT: f64 = 0.05;

/// A scheme with its way through the coupling.
struct Tried {
    label: &'static str,
    method: Method,
    overrides: &'static [&'static str],
    split: fn(&Subject) -> Split,
}

fn tried(coupled: bool) -> Vec<Tried> {
    let method = |scheme, integrator| Method { scheme, integrator };
    let euler = Some("backward-euler");
    let explicit = |subject: &Subject| Split::Explicit {
        relaxation: fixed_stress(subject),
    };
    match coupled {
        true => vec![
            Tried {
                label: "explicit, fixed-stress term",
                method: method("explicit", None),
                overrides: &[],
                split: explicit,
            },
            Tried {
                label: "explicit, lagged strain",
                method: method("explicit", None),
                overrides: &["scheme.relaxation=0"],
                split: |_| Split::Explicit { relaxation: 0.0 },
            },
            Tried {
                label: "staggered",
                method: method("staggered", euler),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
            Tried {
                label: "monolithic",
                method: method("monolithic", Some("tr-bdf2")),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
        ],
        false => vec![
            Tried {
                label: "explicit",
                method: method("explicit", None),
                overrides: &[],
                split: |_| Split::Explicit { relaxation: 0.0 },
            },
            Tried {
                label: "implicit backward Euler",
                method: method("implicit", euler),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
            Tried {
                label: "implicit TR-BDF2",
                method: method("implicit", Some("tr-bdf2")),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
        ],
    }
}

/// The fixed-stress term that the program adds, over α²/M: (λ + 2μ)/(λ + 2μ/d).
fn fixed_stress(subject: &Subject) -> f64 {
    let elasticity = subject
        .plan
        .materials
        .first()
        .and_then(|material| material.elasticity);
    elasticity.map_or(0.0, |elasticity| {
        let (lambda, mu) = (elasticity.lambda(), elasticity.shear_modulus());
        (lambda + 2.0 * mu) / (lambda + 2.0 * mu / subject.plan.dimension as f64)
    })
}

/// What the case gives the theory.
struct Setting {
    grid: Grid,
    modes: Vec<Mode>,
    /// Material whose storage (coupled) or permeability (flow alone) is varied.
    material: String,
    /// α²/M, 1/Pa; 0 without coupling.
    softening: f64,
    /// Largest mobility at strength or contrast 1, m²/(Pa s).
    mobility: f64,
    /// Permeability that a contrast of 1 has, m².
    permeability: f64,
    /// Storage at contrast 1, 1/Pa.
    storage: f64,
}

impl Setting {
    fn of(subject: &Subject, options: &Options) -> Result<Self, StudyError> {
        let unsuited = |reason: &str| StudyError::Unsuited {
            study: "the stability study",
            case: subject.plan.case.clone(),
            reason: reason.to_owned(),
        };
        let plan = &subject.plan;
        // The coarsest cloud: borders are in units of its own limit.
        let grids = subject.grids(options, (30, 1000));
        let grid = grids.first().filter(|grid| grid.overrides.is_some());
        let grid = grid
            .ok_or_else(|| unsuited("theory knows lattices only"))?
            .clone();
        let uniform: Vec<(&crate::plan::MaterialPlan, f64)> = plan
            .materials
            .iter()
            .filter_map(|material| match material.permeability {
                Some(PermeabilityPlan::Uniform(value)) => Some((material, value)),
                _ => None,
            })
            .collect();
        let most = uniform.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let least = uniform.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let (Some((material, _)), Some((_, lowest))) = (most, least) else {
            return Err(unsuited("it needs a material with one permeability"));
        };
        let coupled = subject.is_coupled();
        if coupled && plan.materials.len() != 1 {
            return Err(unsuited("the theory of coupling needs one material"));
        }
        let elasticity = material.elasticity.filter(|_| coupled);
        let softening = elasticity.map_or(0.0, |elasticity| {
            material.biot_coefficient.unwrap_or(1.0).powi(2) / elasticity.oedometer_modulus()
        });
        let ratio = match plan.horizon {
            // The shells of the square and the cubic lattice that the default gives.
            Horizon::Neighbours(15) if plan.dimension == 2 => 5_f64.sqrt(),
            Horizon::Ratio(ratio) => ratio,
            _ => {
                return Err(unsuited(
                    "theory knows the default horizon and horizon.ratio",
                ));
            }
        };
        let lattice = Lattice {
            dimension: plan.dimension,
            ratio,
            influence: plan.influence,
            stiffness: elasticity.map_or(0.0, |e| e.lambda() / e.shear_modulus()),
        };
        let mut modes = lattice.modes();
        modes.push(longest(plan.geometry.clone(), grid.spacing));
        Ok(Setting {
            grid,
            modes,
            material: material.name.clone(),
            softening,
            mobility: lowest / plan.fluid.viscosity,
            permeability: *lowest,
            storage: material.storage,
        })
    }

    /// Storage of a strength, or that of the case, 1/Pa.
    fn storage(&self, strength: f64) -> f64 {
        match self.softening > 0.0 {
            true => self.softening / strength,
            false => self.storage,
        }
    }

    /// Strength τ for the theory: none without coupling.
    fn tau(&self, strength: f64) -> f64 {
        if self.softening > 0.0 { strength } else { 0.0 }
    }

    /// Δx² S/κ of the fastest material, s: the unit of the theory's steps.
    fn unit(&self, strength: f64) -> f64 {
        let contrast = if self.softening > 0.0 { 1.0 } else { strength };
        self.grid.spacing.powi(2) * self.storage(strength) / (self.mobility * contrast)
    }

    /// The step that the axis counts in, s: the stable one of forward Euler with storage S + α²/M.
    fn limit(&self, strength: f64) -> f64 {
        let largest = self
            .modes
            .iter()
            .map(|mode| mode.diffusion)
            .fold(0.0, f64::max);
        2.0 * (1.0 + self.tau(strength)) / largest * self.unit(strength)
    }

    /// Largest stable step of a split, in units of the limit.
    fn stable(&self, split: Split, strength: f64) -> f64 {
        let stable = split.stable(&self.modes, self.tau(strength));
        stable * self.unit(strength) / self.limit(strength)
    }
}

/// The longest wave: half a wave along the longest side with one open end is a quarter of a wave.
fn longest(geometry: GeometryPlan, spacing: f64) -> Mode {
    let side = match geometry {
        GeometryPlan::Lattice { size, .. } => size.into_iter().fold(0.0, f64::max),
        _ => spacing,
    };
    let wave = std::f64::consts::PI / (2.0 * side);
    Mode {
        diffusion: (wave * spacing).powi(2),
        softness: 1.0,
    }
}

impl Study for Stability {
    fn name(&self) -> &'static str {
        "stability"
    }

    fn variants(&self, subject: &Subject, options: &Options) -> Result<Vec<Variant>, StudyError> {
        let setting = Setting::of(subject, options)?;
        let coupled = subject.is_coupled();
        let (steps, strengths): (Vec<i32>, Vec<i32>) = match (options.quick, coupled) {
            (true, true) => ((-1..=3).collect(), vec![-2, 0, 1, 5]),
            (true, false) => ((-1..=3).collect(), vec![1, 9, 17]),
            (false, true) => ((-3..=5).collect(), vec![-4, -2, -1, 0, 1, 2, 3, 5]),
            (false, false) => ((-3..=5).collect(), vec![1, 5, 9, 17, 25, 33, 49]),
        };
        let mut variants = Vec::new();
        for tried in tried(coupled) {
            if !options.wants_scheme(tried.method.scheme) {
                continue;
            }
            let solvers = subject.solvers(tried.method.scheme, options);
            for (&k, &s) in steps
                .iter()
                .flat_map(|k| strengths.iter().map(move |s| (k, s)))
            {
                let (ratio, strength) = (HUNG * CELL.powi(k), HUNG * CELL.powi(s));
                let step = ratio * setting.limit(strength);
                let mut variant = tried
                    .method
                    .variant(solvers.first().map(String::as_str))
                    .set(setting.grid.overrides.clone())
                    .set(tried.overrides.iter().map(|text| (*text).to_owned()))
                    .set([
                        format!("time.step={step:e}"),
                        format!("time.end={:e}", step * f64::from(STEPS)),
                        "output.times=[]".to_owned(),
                        "output.plots=false".to_owned(),
                        match coupled {
                            true => format!(
                                "materials.{}.storage={:e}",
                                setting.material,
                                setting.storage(strength)
                            ),
                            false => format!(
                                "materials.{}.permeability={:e}",
                                setting.material,
                                setting.permeability * strength
                            ),
                        },
                    ])
                    .with("step_ratio", ratio)
                    .with(if coupled { "strength" } else { "contrast" }, strength);
                variant.scheme = tried.label.to_owned();
                variants.push(variant);
            }
        }
        Ok(variants)
    }

    fn findings(&self, subject: &Subject, runs: &[Measured]) -> Findings {
        let Ok(setting) = Setting::of(subject, &Options::default()) else {
            return Findings::default();
        };
        let coupled = subject.is_coupled();
        let mut section = Section::new("Maps of stability");
        section.text.push(format!(
            "Every mark is a run of {STEPS} constant steps on {} points. Steps are counted in the stable \
             step of forward Euler with the storage s + α²/M; dashed is where theory puts the border: \
             Fourier factors of all waves of the lattice with the operators' own symbols. Inaccurate means \
             an error above {INACCURATE}, oscillating an overshoot of the pressure above {OVERSHOOT} of its \
             range.",
            setting.grid.points
        ));
        let axis = if coupled { "strength" } else { "contrast" };
        let mut table = Table::new(
            "Border of stability by theory and as found: the last stable and the first unstable step at each \
             row, in units of the explicit limit",
            &[
                "method",
                axis,
                "theory",
                "stable up to",
                "unstable from",
                "cells apart",
            ],
        );
        let mut facts = Vec::new();
        let mut headlines = Vec::new();
        for tried in tried(coupled) {
            let own: Vec<&Measured> = runs
                .iter()
                .filter(|run| run.variant.scheme == tried.label)
                .collect();
            if own.is_empty() {
                continue;
            }
            let split = (tried.split)(subject);
            draw(&mut section, tried.label, axis, &own, &setting, split);
            let borders = borders(&own, axis, &setting, split);
            let worst = borders
                .iter()
                .map(|border| border.cells_apart)
                .fold(0.0, f64::max);
            headlines.push(match split {
                Split::Unconditional => {
                    let fell = own.iter().filter(|run| !Class::of(run).is_stable()).count();
                    format!(
                        "{}: {} of {} runs stable at every step and {axis}.",
                        tried.label,
                        own.len() - fell,
                        own.len()
                    )
                }
                _ => format!(
                    "{}: the border found is {} of theory's.",
                    tried.label,
                    match worst < 0.5 {
                        true => "in the very grid cell".to_owned(),
                        false if worst < 1.5 => "within one grid cell".to_owned(),
                        false => format!("within {worst:.0} grid cells"),
                    }
                ),
            });
            for border in borders {
                table.rows.push(border.cells(tried.label));
                facts.push(json!({ "method": tried.label, "border": border }));
            }
        }
        section.tables.push(table);
        let classes: Vec<_> = runs
            .iter()
            .map(|run| json!({ "method": run.variant.scheme, "varied": run.variant.values, "class": Class::of(run).name() }))
            .collect();
        Findings {
            facts: json!({ "borders": facts, "classes": classes }),
            headlines,
            sections: vec![section],
        }
    }
}

/// How a run went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    Converged,
    Inaccurate,
    Oscillating,
    Diverged,
    Refused,
    Unfinished,
}

impl Class {
    const ALL: [Class; 6] = [
        Class::Converged,
        Class::Inaccurate,
        Class::Oscillating,
        Class::Diverged,
        Class::Refused,
        Class::Unfinished,
    ];

    fn of(run: &Measured) -> Class {
        match run.first().status {
            Status::Done => {}
            Status::Refused => return Class::Refused,
            Status::TimedOut | Status::Skipped => return Class::Unfinished,
            _ => return Class::Diverged,
        }
        let error = run.error();
        if error > DIVERGED {
            return Class::Diverged;
        }
        let number = |path: &str| run.number(path);
        let (low, high) = (number("/pressure_range/0"), number("/pressure_range/1"));
        let range = high - low;
        // Drained and sealed pressures stay on one side of zero.
        if low < -OVERSHOOT * range && high > 0.0 && error > INACCURATE {
            return Class::Oscillating;
        }
        match error > INACCURATE {
            true => Class::Inaccurate,
            false => Class::Converged,
        }
    }

    fn is_stable(self) -> bool {
        matches!(self, Class::Converged | Class::Inaccurate)
    }

    fn name(self) -> &'static str {
        match self {
            Class::Converged => "converged",
            Class::Inaccurate => "inaccurate",
            Class::Oscillating => "oscillating",
            Class::Diverged => "diverged",
            Class::Refused => "refused",
            Class::Unfinished => "unfinished",
        }
    }
}

/// The border at one strength.
#[derive(Debug, Clone, serde::Serialize)]
struct Border {
    strength: f64,
    /// Infinite (null) if every step is stable.
    theory: f64,
    stable_to: Option<f64>,
    unstable_from: Option<f64>,
    cells_apart: f64,
}

impl Border {
    fn cells(&self, label: &str) -> Vec<String> {
        let number = |value: Option<f64>| value.map_or("none".to_owned(), |v| format!("{v:.2}"));
        let theory = match self.theory {
            to if to.is_infinite() => "every step is stable".to_owned(),
            to if to <= 0.0 => "no step is stable".to_owned(),
            to => format!("stable to {to:.3}"),
        };
        vec![
            label.to_owned(),
            format!("{:.3}", self.strength),
            theory,
            number(self.stable_to),
            number(self.unstable_from),
            format!("{:.1}", self.cells_apart),
        ]
    }
}

fn borders(runs: &[&Measured], axis: &str, setting: &Setting, split: Split) -> Vec<Border> {
    let mut rows: BTreeMap<u64, Vec<(f64, f64, bool)>> = BTreeMap::new();
    let ended = |run: &&&Measured| Class::of(run) != Class::Unfinished;
    for run in runs.iter().filter(ended) {
        let (ratio, strength) = (run.variant.value("step_ratio"), run.variant.value(axis));
        let stable = Class::of(run).is_stable();
        rows.entry(strength.to_bits())
            .or_default()
            .push((ratio, strength, stable));
    }
    rows.into_values()
        .map(|mut row| {
            row.sort_by(|a, b| a.0.total_cmp(&b.0));
            let strength = row[0].1;
            let theory = setting.stable(split, strength);
            // Runs that theory puts on the other side; how far from the border, in cells.
            let wrong = row
                .iter()
                .filter(|(ratio, _, stable)| (*ratio <= theory) != *stable);
            let apart = wrong.map(|(ratio, ..)| match theory > 0.0 && theory.is_finite() {
                true => ((ratio / theory).ln().abs() / CELL.ln()).ceil(),
                // The border runs along this row: it is a strength of one away.
                false => (strength.ln().abs() / CELL.ln()).ceil(),
            });
            Border {
                strength,
                theory,
                cells_apart: apart.fold(0.0, f64::max),
                stable_to: row
                    .iter()
                    .filter(|cell| cell.2)
                    .map(|cell| cell.0)
                    .reduce(f64::max),
                unstable_from: row.iter().find(|cell| !cell.2).map(|cell| cell.0),
            }
        })
        .collect()
}

fn draw(
    section: &mut Section,
    label: &str,
    axis: &str,
    runs: &[&Measured],
    setting: &Setting,
    split: Split,
) {
    let columns: Vec<(&str, Vec<f64>, Vec<f64>)> = Class::ALL
        .iter()
        .map(|class| {
            let own = runs.iter().filter(|run| Class::of(run) == *class);
            let places = own.map(|run| (run.variant.value("step_ratio"), run.variant.value(axis)));
            let (x, y) = places.unzip();
            (class.name(), x, y)
        })
        .collect();
    let all = || {
        runs.iter()
            .map(|run| (run.variant.value("step_ratio"), run.variant.value(axis)))
    };
    let span = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    };
    let (x_low, x_high) = span(&mut all().map(|place| place.0));
    let (y_low, y_high) = span(&mut all().map(|place| place.1));
    // Nothing is drawn where the border lies beyond the runs.
    let (x, y): (Vec<f64>, Vec<f64>) = (0..=400)
        .map(|k| y_low * (y_high / y_low).powf(f64::from(k) / 400.0))
        .map(|y| (setting.stable(split, y), y))
        .filter(|(x, _)| (0.5 * x_low..=2.0 * x_high).contains(x))
        .unzip();
    let mut series: Vec<Series<'_>> = columns
        .iter()
        // Classes that do not occur keep their look, so that pictures can be compared.
        .map(|(label, x, y)| Series {
            label,
            x,
            y,
            style: LineStyle::Markers,
        })
        .collect();
    if !x.is_empty() {
        series.push(Series {
            label: "theory",
            x: &x,
            y: &y,
            style: LineStyle::Dashed,
        });
    }
    let file = format!("stability-{}", label.replace(", ", "-").replace(' ', "-"));
    section.draw(
        &file,
        &format!("How runs of the {label} scheme end."),
        &LinePlot {
            title: label,
            x_label: "step over explicit limit",
            y_label: if axis == "strength" {
                "coupling strength α²/(s M)"
            } else {
                "contrast"
            },
            x_log: true,
            y_log: true,
            series: &series,
            note: None,
        },
    );
}
