//! Which diffusion operator a plan gets on its cloud.

use crate::plan::{FlowPlan, GradientChoice, OperatorChoice, Plan};

/// Largest over smallest permeability up to which `auto` takes the correspondence operator.
///
/// Measured on two layers in series, 40 cells across: its flux is off by 0.7 % at 2, 1.7 % at 3, 2.8 %
/// at 5 and 6.6 % at 100, that of the bond operator by 0.5 % at most.
const MILD: f64 = 3.0;

/// The operator of the pressure, and what decided it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenOperator {
    /// Whether it is the bond operator.
    pub bond: bool,
    /// Why.
    pub why: String,
    /// What the user should know about it.
    pub doubt: Option<String>,
}

impl ChosenOperator {
    /// Chooses for `flow` on points of the given permeabilities (m²).
    pub fn of(plan: &Plan, flow: &FlowPlan, permeability: &[f64]) -> Self {
        let contrast = contrast(permeability);
        match flow.operator {
            OperatorChoice::Auto => automatic(plan, flow, contrast),
            OperatorChoice::Bond => ChosenOperator {
                bond: true,
                why: "asked for".to_owned(),
                doubt: None,
            },
            OperatorChoice::Correspondence => correspondence("asked for".to_owned(), contrast),
        }
    }
}

fn automatic(plan: &Plan, flow: &FlowPlan, contrast: f64) -> ChosenOperator {
    if flow.gradient != GradientChoice::Auto {
        return correspondence(
            "flow.gradient is named, which is its own".to_owned(),
            contrast,
        );
    }
    let why = match contrast > MILD {
        true => format!("permeability contrast {contrast:.3e}, above {MILD}"),
        false if plan.fracture_flow.is_some() => "fractures conduct better than rock".to_owned(),
        false => {
            let why = format!("permeability contrast {contrast:.3}, not above {MILD}");
            return correspondence(why, contrast);
        }
    };
    ChosenOperator {
        bond: true,
        why,
        doubt: None,
    }
}

fn correspondence(why: String, contrast: f64) -> ChosenOperator {
    let doubt = format!(
        "the correspondence operator takes about the arithmetic mean where permeabilities meet, and \
         here they differ by {contrast:.1e}: flow across layers is too large; use flow.operator = \
         \"bond\", or \"auto\" without flow.gradient"
    );
    ChosenOperator {
        bond: false,
        why,
        doubt: (contrast > MILD).then_some(doubt),
    }
}

/// Largest over smallest; infinite if the smallest is zero, 1 without points.
fn contrast(permeability: &[f64]) -> f64 {
    let start = (f64::INFINITY, 0.0_f64);
    let (low, high) = (permeability.iter()).fold(start, |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if high > low { high / low } else { 1.0 }
}
