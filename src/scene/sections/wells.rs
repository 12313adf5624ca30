//! `[wells.NAME]`: sources and sinks at a point.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::load::Load;
use crate::scene::quantity::{FlowRate, Length, Number, Pressure, dimension};
use crate::scene::span::{Entry, Named, Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// A source or sink at a point, with exactly one of `rate` and `pressure`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Well {
    /// Position, m.
    pub at: Spanned<Vec<Length>>,
    /// Volume rate into the rock, m³/s, or m²/s per metre of `geometry.thickness` in a plane, for the whole
    /// plane: a well on a corner of the domain puts a quarter into it.
    pub rate: Option<Load<dimension::FlowRate>>,
    /// Bottom-hole pressure, Pa, at which the well is held instead of a `rate`. Needs `wellbore_radius`.
    pub pressure: Option<Load<dimension::Pressure>>,
    /// Radius of the hole, m, in three dimensions that of a spherical cavity: with it the bottom-hole pressure is
    /// known.
    pub wellbore_radius: Option<Length>,
    /// Resistance of the damaged rock around the hole, in units of that of a factor e of the radius; below zero where the rock
    /// conducts better. 0 if absent.
    pub skin: Option<Number>,
    /// Lowest bottom-hole pressure of a producer, Pa: where its `rate` needs less the well is held at this pressure.
    pub pressure_min: Option<Pressure>,
    /// Highest bottom-hole pressure of an injector, Pa: where its `rate` needs more the well is held at this pressure.
    pub pressure_max: Option<Pressure>,
    /// Largest rate in or out, in the units of `rate`: where a well held at a `pressure` moves more it goes over to this rate.
    pub rate_max: Option<FlowRate>,
    /// Radius over which the source is spread, m; chosen from the horizon if absent.
    pub radius: Option<Length>,
}

impl Section for Named<Well> {
    const NAME: &'static str = "wells";

    fn check(&self, _: Span, scene: &Context<'_>, report: &mut Report) {
        report.names(self);
        for Entry { span, value, .. } in self {
            report.position("at", &value.at, scene);
            value.check_drive(*span, scene, report);
            value.check_hole(report);
            value.check_limits(report);
            value.check_rate_limit(scene, report);
            let lengths = [
                ("radius", value.radius),
                ("wellbore_radius", value.wellbore_radius),
            ];
            for (name, length) in lengths {
                length
                    .into_iter()
                    .for_each(|length| report.positive(name, length));
            }
        }
    }
}

impl Well {
    /// Either a rate or a pressure.
    fn check_drive(&self, name: Span, scene: &Context<'_>, report: &mut Report) {
        let rate = self.rate.as_ref().map(Load::span);
        let pressure = self.pressure.as_ref().map(Load::span);
        if rate.is_none() && pressure.is_none() {
            let fault = Diagnostic::new("a well needs `rate` or `pressure`").at(name);
            report.add(fault.help("rate = \"1e-4 m^3/s\" injects, and below zero produces"));
        }
        report.at_most_one(&[("rate", rate), ("pressure", pressure)]);
        if let Some(rate) = &self.rate {
            report.load(rate, scene);
            check_rate_unit(rate, scene, report);
        }
        if let Some(pressure) = &self.pressure {
            report.load(pressure, scene);
        }
    }

    /// What has no meaning without the radius of the hole.
    fn check_hole(&self, report: &mut Report) {
        let needing = [
            ("pressure", self.pressure.as_ref().map(Load::span)),
            ("pressure_min", self.pressure_min.map(|own| own.span())),
            ("pressure_max", self.pressure_max.map(|own| own.span())),
            ("rate_max", self.rate_max.map(|own| own.span())),
            ("skin", self.skin.map(|own| own.span())),
        ];
        let first = needing
            .into_iter()
            .find_map(|(name, place)| Some((name, place?)));
        if let (Some((name, place)), None) = (first, self.wellbore_radius) {
            let fault = Diagnostic::new(format!("`{name}` needs `wellbore_radius`")).at(place);
            report
                .add(fault.help("add the radius of the hole, such as wellbore_radius = \"10 cm\""));
        }
    }

    /// Limits of the pressure that can ever be met; a well that is shut in may keep its own.
    fn check_limits(&self, report: &mut Report) {
        let values = |sign: f64| {
            let rate = self.rate.iter().flat_map(|rate| rate.values());
            rate.map(|rate| sign * rate.value()).fold(0.0, f64::max)
        };
        let limits = [
            (
                "pressure_min",
                self.pressure_min,
                -1.0,
                "never below zero",
                "a producer",
            ),
            (
                "pressure_max",
                self.pressure_max,
                1.0,
                "never above zero",
                "an injector",
            ),
        ];
        for (name, limit, sign, never, kind) in limits {
            let Some(limit) = limit else { continue };
            if let (Some(pressure), None) = (&self.pressure, &self.rate) {
                let fault = Diagnostic::new(format!("`{name}` limits a `rate`, not a `pressure`"));
                let fault = fault.at(limit.span()).also(pressure.span(), "held here");
                report.add(fault.help("leave it out, or hold the well at a `rate`"));
            } else if values(sign) <= 0.0 && values(-sign) > 0.0 {
                let message =
                    format!("`{name}` limits the pressure of {kind}, and `rate` is {never}");
                let other = if sign < 0.0 {
                    "pressure_max"
                } else {
                    "pressure_min"
                };
                let fault = Diagnostic::new(message).at(limit.span());
                report.add(fault.help(format!("did you mean `{other}`? rates above zero inject")));
            }
        }
        if let (Some(low), Some(high)) = (self.pressure_min, self.pressure_max)
            && low.value() >= high.value()
        {
            let fault = Diagnostic::new("`pressure_max` must be greater than `pressure_min`");
            report.add(fault.at(high.span()).also(low.span(), "`pressure_min`"));
        }
    }

    /// A largest rate of a well that is held at a pressure.
    fn check_rate_limit(&self, scene: &Context<'_>, report: &mut Report) {
        let Some(most) = self.rate_max else { return };
        report.positive("rate_max", most);
        if most.accepted() == 1 && scene.dimension() == Some(3) {
            report.add(per_metre_in_space(most.span()));
        }
        if let (Some(rate), None) = (&self.rate, &self.pressure) {
            let fault = Diagnostic::new("`rate_max` limits a `pressure`, not a `rate`");
            let fault = fault.at(most.span()).also(rate.span(), "given here");
            report.add(fault.help("leave it out, or hold the well at a `pressure`"));
        }
    }
}

/// A rate per metre of thickness belongs to a plane.
pub(super) fn check_rate_unit(
    rate: &Load<dimension::FlowRate>,
    scene: &Context<'_>,
    report: &mut Report,
) {
    let per_metre = rate.values().iter().find(|value| value.accepted() == 1);
    if let (Some(value), Some(3)) = (per_metre, scene.dimension()) {
        report.add(per_metre_in_space(value.span()));
    }
}

fn per_metre_in_space(place: Span) -> Diagnostic {
    let fault = Diagnostic::new("a rate per metre of thickness has no meaning in three dimensions");
    fault.at(place).help("give the whole rate, in m^3/s")
}
