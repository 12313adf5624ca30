//! The scene as typed, where every section may be absent, and what must be there nevertheless.
//!
//! A new section is one file in `sections/`, a field in [`Draft`] and in [`Scene`](super::Scene),
//! and one line in [`Draft::check`] and [`Draft::finish`].

use schemars::JsonSchema;
use serde::Deserialize;

use super::Scene;
use super::diagnostics::Diagnostic;
use super::sections::{
    Audit, Coupling, Crack, Damage, Flow, Fluid, FractureFlow, Geometry, Gravity, Horizon, Initial,
    Material, Mechanics, Output, Reference, Scheme, Solver, Start, TimeControl, Well,
};
use super::span::{Named, Spanned};
use super::validate::{Context, Report, Section};

/// A perifrac scene. A bare number is in SI units; a text carries its unit, such as "10 mD". A unit is a product of
/// symbols, such as "kN/m^2" or "kg/(m s)", and most of them take the prefixes f, p, n, u, m, c, d, h, k, M, G and T.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Scene")]
pub(super) struct Draft {
    /// Title, shown in reports and pictures; the name of the case if absent.
    pub title: Option<Spanned<String>>,
    /// What the case shows, in a few sentences.
    pub description: Option<String>,
    /// The domain and its points.
    #[schemars(required)]
    pub geometry: Option<Spanned<Geometry>>,
    /// How far a point sees.
    pub horizon: Option<Spanned<Horizon>>,
    /// What fills the pores.
    pub fluid: Option<Spanned<Fluid>>,
    /// What the rock is like, and where.
    #[schemars(required)]
    pub materials: Option<Spanned<Named<Material>>>,
    /// A uniform field of gravity; acts if present.
    pub gravity: Option<Spanned<Gravity>>,
    /// The in-situ state, at rest before the run.
    pub initial: Option<Spanned<Initial>>,
    /// Single-phase flow; acts if present.
    pub flow: Option<Spanned<Flow>>,
    /// Deformation of the rock; acts if present.
    pub mechanics: Option<Spanned<Mechanics>>,
    /// The ways between pressure and strain; needed where there are both.
    pub coupling: Option<Spanned<Coupling>>,
    /// Breaking of the rock; acts if present.
    pub damage: Option<Spanned<Damage>>,
    /// Flow in what is broken; acts if present.
    pub fracture_flow: Option<Spanned<FractureFlow>>,
    /// Cracks that are there from the start.
    pub cracks: Option<Spanned<Named<Crack>>>,
    /// Sources and sinks at points; act if present.
    pub wells: Option<Spanned<Named<Well>>>,
    /// The run that this one goes on from.
    pub start: Option<Spanned<Start>>,
    /// How long, and in which steps.
    #[schemars(required)]
    pub time: Option<Spanned<TimeControl>>,
    /// How the step is taken.
    pub scheme: Option<Spanned<Scheme>>,
    /// Who solves the linear systems.
    pub solver: Option<Spanned<Solver>>,
    /// How well balances must close.
    pub audit: Option<Spanned<Audit>>,
    /// What is written, and when.
    pub output: Option<Spanned<Output>>,
    /// An exact solution to compare with.
    pub reference: Option<Spanned<Reference>>,
}

impl Draft {
    /// Every rule of every section in which there is no fault yet.
    pub(super) fn check(&self, scene: &Context<'_>) -> Vec<Diagnostic> {
        let mut report = Report::default();
        self.check_presence(scene, &mut report);
        check(&self.geometry, scene, &mut report);
        check(&self.horizon, scene, &mut report);
        check(&self.fluid, scene, &mut report);
        check(&self.materials, scene, &mut report);
        check(&self.gravity, scene, &mut report);
        check(&self.initial, scene, &mut report);
        check(&self.flow, scene, &mut report);
        check(&self.mechanics, scene, &mut report);
        check(&self.coupling, scene, &mut report);
        check(&self.damage, scene, &mut report);
        check(&self.fracture_flow, scene, &mut report);
        check(&self.cracks, scene, &mut report);
        check(&self.wells, scene, &mut report);
        check(&self.start, scene, &mut report);
        check(&self.time, scene, &mut report);
        check(&self.scheme, scene, &mut report);
        check(&self.solver, scene, &mut report);
        check(&self.audit, scene, &mut report);
        check(&self.output, scene, &mut report);
        check(&self.reference, scene, &mut report);
        report.faults
    }

    fn check_presence(&self, scene: &Context<'_>, report: &mut Report) {
        if let Some(title) = &self.title
            && title.trim().is_empty()
        {
            let fault = Diagnostic::new("`title` is empty").at(title.span);
            report.add(fault.help("leave it out, and the scene is called like its case"));
        }
        let needed = [
            (
                scene.has(&self.geometry),
                "[geometry]",
                "type = \"lattice\", `size` and `points`",
            ),
            (
                scene.has(&self.materials),
                "[materials.NAME]",
                "`permeability` and `storage`",
            ),
            (
                scene.has(&self.time),
                "[time]",
                "end = \"1 h\", or mode = \"steady\"",
            ),
        ];
        for (typed, section, content) in needed {
            if !typed {
                let fault = Diagnostic::new(format!("the scene has no {section}"));
                report.add(fault.help(format!("add {section} with {content}")));
            }
        }
    }

    /// The scene, if all that it needs is there.
    pub(super) fn finish(self) -> Option<Scene> {
        Some(Scene {
            title: self.title.map(|title| title.value),
            description: self.description,
            geometry: self.geometry?,
            horizon: self.horizon.unwrap_or_default(),
            fluid: self.fluid,
            materials: self.materials?.value,
            gravity: self.gravity,
            initial: self.initial,
            flow: self.flow,
            mechanics: self.mechanics,
            coupling: self.coupling,
            damage: self.damage,
            fracture_flow: self.fracture_flow,
            cracks: self.cracks.unwrap_or_default(),
            wells: self.wells.unwrap_or_default(),
            start: self.start,
            time: self.time?,
            scheme: self.scheme.unwrap_or_default(),
            solver: self.solver.unwrap_or_default(),
            audit: self.audit.unwrap_or_default(),
            output: self.output.unwrap_or_default(),
            reference: self.reference,
        })
    }
}

fn check<T: Section>(section: &Option<Spanned<T>>, scene: &Context<'_>, report: &mut Report) {
    if let Some(Spanned { value, span }) = section
        && !scene.faulty.contains(T::NAME)
    {
        value.check(*span, scene, report);
    }
}
