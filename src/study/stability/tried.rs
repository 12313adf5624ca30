//! The schemes that are tried, with their ways through the coupling.

use super::theory::Split;
use crate::plan::MaterialPlan;
use crate::study::{Method, StudyCase};

/// A scheme with its way through the coupling.
pub(super) struct Candidate {
    /// As in legends.
    pub label: &'static str,
    /// Scheme and integrator.
    pub method: Method,
    /// Beyond those of the method.
    pub overrides: &'static [&'static str],
    /// For the theory.
    pub split: fn(&StudyCase) -> Split,
}

/// Those that suit flow coupled with deformation, or flow alone.
pub(super) fn tried(coupled: bool) -> Vec<Candidate> {
    let method = Method::new;
    let euler = Some("backward-euler");
    let explicit = |subject: &StudyCase| Split::Explicit {
        relaxation: fixed_stress(subject),
    };
    match coupled {
        true => vec![
            Candidate {
                label: "explicit, fixed-stress term",
                method: method("explicit", None),
                overrides: &[],
                split: explicit,
            },
            Candidate {
                label: "explicit, lagged strain",
                method: method("explicit", None),
                overrides: &["scheme.relaxation=0"],
                split: |_| Split::Explicit { relaxation: 0.0 },
            },
            // One pass a step whatever it disagrees by, and whatever fluid lags: the program would pass again
            // or end the run where that is much.
            Candidate {
                label: "semi-implicit, lagged strain",
                method: method("semi-implicit", euler),
                overrides: &[
                    "scheme.relaxation=0",
                    "scheme.single_pass=true",
                    "audit.mass=1",
                    "audit.momentum=1",
                    "audit.energy=1",
                ],
                split: |_| Split::SemiImplicit { relaxation: 0.0 },
            },
            Candidate {
                label: "staggered",
                method: method("staggered", euler),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
            Candidate {
                label: "monolithic",
                method: method("monolithic", Some("tr-bdf2")),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
        ],
        false => vec![
            Candidate {
                label: "explicit",
                method: method("explicit", None),
                overrides: &[],
                split: |_| Split::Explicit { relaxation: 0.0 },
            },
            Candidate {
                label: "implicit backward Euler",
                method: method("implicit", euler),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
            Candidate {
                label: "implicit TR-BDF2",
                method: method("implicit", Some("tr-bdf2")),
                overrides: &[],
                split: |_| Split::Unconditional,
            },
        ],
    }
}

/// The fixed-stress term that the program adds, over α²/M: (λ + 2μ)/(λ + 2μ/d).
fn fixed_stress(subject: &StudyCase) -> f64 {
    let elasticity = subject
        .plan
        .materials
        .first()
        .and_then(MaterialPlan::uniform_elasticity);
    elasticity.map_or(0.0, |elasticity| {
        let (lambda, mu) = (elasticity.lambda(), elasticity.shear_modulus());
        (lambda + 2.0 * mu) / (lambda + 2.0 * mu / subject.plan.dimension as f64)
    })
}
