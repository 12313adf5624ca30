//! `[damage]`: the rock breaks; its presence makes the effect exist.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::mechanics::Support;
use crate::scene::diagnostics::Diagnostic;
use crate::scene::quantity::{Length, Number, Time};
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Variational damage (Eqs. 20 to 35). Needs `[mechanics]`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damage {
    /// Length scale ℓ over which damage is spread, m.
    pub length_scale: Length,
    /// Which part of the elastic energy breaks the rock.
    #[serde(default)]
    pub split: EnergySplit,
    /// Share k of the stiffness that broken rock keeps, 1e-14 to 0.1.
    #[serde(default = "nearly_nothing")]
    pub residual_stiffness: Number,
    /// How damage weakens the hourglass term.
    #[serde(default)]
    pub hourglass: Hourglass,
    /// Scales the fracture energy by ℓ/2δ, so that a crack takes G_c whatever the horizon is.
    #[serde(default)]
    pub normalise: bool,
    /// How equilibrium with damage is found.
    #[serde(default)]
    pub method: DamageMethod,
    /// Forces out of balance, relative to all forces, that count as equilibrium; below 0.1.
    #[serde(default = "balance")]
    pub tolerance: Number,
    /// The step fails beyond this many iterations.
    #[serde(default = "thousand")]
    pub iterations: Spanned<u64>,
    /// Growth of damage at a point, in one step, below which it is evaluated at the end of the step only;
    /// 0 (all points all the time) to 0.01, and at most 30 times `tolerance`.
    #[serde(default = "hardly")]
    pub resting_growth: Number,
    /// Growth of damage at a point, in one step, above which an adaptive step is cut; above 0, up
    /// to 1.
    #[serde(default = "third")]
    pub largest_increment: Number,
    /// Shortest adaptive step, s: growth that goes on in it is accepted however fast it is. A
    /// hundredth of the run if absent.
    pub shortest_step: Option<Time>,
}

/// Splits of the elastic energy into what breaks the rock and what does not (Eq. 24).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnergySplit {
    /// Positive principal strains and expansion break the rock.
    #[default]
    Spectral,
    /// Expansion and all change of shape break the rock.
    VolumetricDeviatoric,
    /// All of the energy breaks the rock.
    None,
}

/// How damage weakens the hourglass term.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Hourglass {
    /// Like the stress, and its energy drives damage too.
    #[default]
    Variational,
    /// By 1 − s, as printed (Eq. 53): a crack then takes more energy than damage tells.
    Linear,
}

/// Ways to equilibrium with damage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DamageMethod {
    /// Newton's method where it works, alternate minimisation elsewhere.
    #[default]
    Auto,
    /// Newton's method with damage eliminated.
    Newton,
    /// Displacement at fixed damage, then damage, in turns.
    Alternate,
}

fn nearly_nothing() -> Number {
    Number::si(1e-9)
}

fn balance() -> Number {
    Number::si(1e-5)
}

fn thousand() -> Spanned<u64> {
    Spanned::nowhere(1000)
}

fn hardly() -> Number {
    Number::si(3e-4)
}

fn third() -> Number {
    Number::si(0.3)
}

impl Section for Damage {
    const NAME: &'static str = "damage";

    fn check(&self, place: Span, scene: &Context<'_>, report: &mut Report) {
        report.positive("length_scale", self.length_scale);
        report.within("residual_stiffness", self.residual_stiffness, 1e-14, 0.1);
        report.positive("tolerance", self.tolerance);
        if self.tolerance.value() >= 0.1 {
            let fault = Diagnostic::new("`tolerance` must be below 0.1");
            report.add(fault.at(self.tolerance.span()));
        }
        report.at_least("iterations", self.iterations, 1);
        report.within("resting_growth", self.resting_growth, 0.0, 0.01);
        report.share("largest_increment", self.largest_increment);
        let shortest = self.shortest_step;
        shortest
            .into_iter()
            .for_each(|step| report.positive("shortest_step", step));
        let mechanics = scene.has(&scene.draft.mechanics);
        report.needs("[damage]", place, &[("[mechanics]", mechanics)]);
        check_mechanics(place, scene, report);
        check_time(place, scene, report);
    }
}

fn check_mechanics(place: Span, scene: &Context<'_>, report: &mut Report) {
    let Some(mechanics) = scene.sound(&scene.draft.mechanics) else {
        return;
    };
    if mechanics.is_dynamic() {
        let fault = Diagnostic::new("damage needs quasi-static mechanics").at(mechanics.mode.span);
        let fault = fault.also(place, "the damage");
        report.add(fault.help("set mechanics.mode = \"quasi-static\", or leave [damage] out"));
    }
    for (_, support) in mechanics.boundary.iter() {
        if matches!(support.value, Support::Plate { .. }) {
            let fault = Diagnostic::new("a rigid `plate` and [damage] do not go together");
            let fault = fault.at(support.span).also(place, "the damage");
            report.add(fault.help("give the side a `traction` or a `normal_displacement`"));
        }
    }
}

/// Without flow a steady run is one equilibrium at the loads.
fn check_time(place: Span, scene: &Context<'_>, report: &mut Report) {
    let draft = scene.draft;
    let flows = scene.has(&draft.flow) && !scene.has(&draft.fracture_flow);
    let steady = scene.sound(&draft.time).filter(|time| time.is_steady());
    if let Some(time) = steady.filter(|_| flows) {
        let fault = Diagnostic::new("a steady run with [flow] has no [damage]").at(place);
        let fault = fault.also(time.mode.span, "steady here");
        report.add(fault.help("give the run an `end`, or leave [flow] or [damage] out"));
    }
}
