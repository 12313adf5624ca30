//! Which diffusion operator a plan gets on its cloud.

use crate::operators::Cells;
use crate::plan::{FlowPlan, GeometryPlan, GradientChoice, OperatorChoice, Plan};

/// Largest over smallest permeability up to which `auto` takes the correspondence operator where there is
/// no path operator, on lattices and on irregular clouds.
///
/// Measured on two layers in series, 40 cells across. On a lattice the flux of the correspondence operator
/// is off by 0.5, 1.1, 2.2, 6.6 % at 2, 3, 5, 100, that of the bond operator by 0.5 % at most. With points
/// jittered by 0.3 the first has 0.5, 1.1, 2.0, 6.8 %, the second 3.4 % at any contrast.
const MILD: [f64; 2] = [3.0, 10.0];

/// Forms of the diffusion operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Between cells that touch, with what lies on the way.
    Path(Cells),
    /// One conductance per bond of the family.
    Bond,
    /// Nonlocal gradient, its transpose and an hourglass term.
    Correspondence,
}

impl Form {
    /// Name in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Form::Path(_) => "path",
            Form::Bond => "bond",
            Form::Correspondence => "correspondence",
        }
    }
}

/// The operator of the pressure, and what decided it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenOperator {
    /// Its form.
    pub form: Form,
    /// Why.
    pub why: String,
    /// What the user should know about it.
    pub doubt: Option<String>,
}

impl ChosenOperator {
    /// Chooses for `flow` on points of the given permeabilities (m²), on a lattice or an irregular cloud.
    pub fn of(plan: &Plan, flow: &FlowPlan, permeability: &[f64], irregular: bool) -> Self {
        let contrast = contrast(permeability);
        let path = Form::Path(cells(plan, irregular));
        let asked = |form| ChosenOperator {
            form,
            why: "asked for".to_owned(),
            doubt: doubt(form, contrast, plan),
        };
        match flow.operator {
            OperatorChoice::Path => asked(path),
            OperatorChoice::Bond => asked(Form::Bond),
            OperatorChoice::Correspondence => asked(Form::Correspondence),
            OperatorChoice::Auto => {
                let (form, why) = automatic(plan, flow, contrast, irregular);
                ChosenOperator {
                    form: form.unwrap_or(path),
                    why,
                    doubt: form.and_then(|form| doubt(form, contrast, plan)),
                }
            }
        }
    }
}

/// Whether a plan has no bonds but those between cells of a grid: flow alone, with the path operator.
pub(super) fn grid_alone(plan: &Plan, irregular: bool) -> bool {
    let Some(flow) = plan.flow.as_ref().filter(|_| plan.mechanics.is_none()) else {
        return false;
    };
    let takes = match flow.operator {
        OperatorChoice::Path => true,
        OperatorChoice::Auto => automatic(plan, flow, 1.0, irregular).0.is_none(),
        OperatorChoice::Bond | OperatorChoice::Correspondence => false,
    };
    takes && cells(plan, irregular) != Cells::Scattered && plan.cracks.is_empty()
}

/// How the cells of the plan's cloud are known.
fn cells(plan: &Plan, irregular: bool) -> Cells {
    match (irregular, &plan.geometry) {
        (false, _) if plan.has_tensors() => Cells::Oblique,
        (false, _) => Cells::Lattice,
        (true, GeometryPlan::Graded { .. }) => Cells::Tensor,
        (true, _) => Cells::Scattered,
    }
}

/// The form where it is not the path operator, and why.
fn automatic(
    plan: &Plan,
    flow: &FlowPlan,
    contrast: f64,
    irregular: bool,
) -> (Option<Form>, String) {
    if flow.gradient != GradientChoice::Auto {
        let why = "flow.gradient is named, which is its own";
        return (Some(Form::Correspondence), why.to_owned());
    }
    if !mixes(plan) && plan.geometry.tells_cells() {
        return (None, "right at every contrast".to_owned());
    }
    let (limit, cloud) = match irregular {
        true => (MILD[1], "an irregular cloud"),
        false => (MILD[0], "a lattice"),
    };
    match contrast > limit {
        true => {
            let why = format!("permeability contrast {contrast:.3e}, above {limit} on {cloud}");
            (Some(Form::Bond), why)
        }
        false if mixes(plan) => {
            let why = "fractures conduct better than rock";
            (Some(Form::Bond), why.to_owned())
        }
        false => {
            let why = format!("permeability contrast {contrast:.3}, not above {limit} on {cloud}");
            (Some(Form::Correspondence), why)
        }
    }
}

/// Whether rock takes on the properties of cracks where it breaks, as in the model of the paper: then fluid
/// moves in cracks by the operator of the rock, and must get past points that are not broken.
fn mixes(plan: &Plan) -> bool {
    plan.fracture_flow.is_some() && !plan.has_crack_fluid()
}

/// What a form is in for where permeabilities differ by `contrast`.
///
/// Measured on lattices of 20 to 40 cells across: with the bond operator a channel one cell wide carries
/// 40 % of its flow, one of four cells 83 %, and a barrier of one cell that is 1e8 times tighter leaks 4e6
/// times too much.
fn doubt(form: Form, contrast: f64, plan: &Plan) -> Option<String> {
    let wrong = match form {
        Form::Path(_) => return None,
        Form::Bond => {
            "the bond operator jumps over what lies between the ends of a bond: channels of a few cells \
             carry too little, by 60 % where one cell wide, and barriers thinner than a horizon leak"
        }
        Form::Correspondence => {
            "the correspondence operator takes about the arithmetic mean where permeabilities meet: flow \
             across layers is too large, by a few hundredths for layers of many horizons, by far more for \
             thin ones"
        }
    };
    let remedy = match (form, mixes(plan)) {
        (_, false) => "; use flow.operator = \"path\"",
        (Form::Correspondence, true) => "; use flow.operator = \"bond\"",
        (_, true) => "",
    };
    let doubt =
        || format!("{wrong}, and here permeabilities differ by a factor of {contrast:.1e}{remedy}");
    (contrast > MILD[0]).then(doubt)
}

/// Largest over smallest; infinite if the smallest is zero, 1 without points.
fn contrast(permeability: &[f64]) -> f64 {
    let start = (f64::INFINITY, 0.0_f64);
    let (low, high) = (permeability.iter()).fold(start, |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if high > low { high / low } else { 1.0 }
}
