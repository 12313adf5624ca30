//! The scene: what the user types, with units, checked, and ready to be planned.
//!
//! The text goes through these steps, each in its own file:
//!
//! ```text
//! text ─ tree (TOML + places) ─ overrides (--set) ─ recover/reader (serde) ─ draft ─ rules ─ Scene
//! ```
//!
//! Every fault becomes a [`Diagnostic`] with its place; they are shown together as
//! [`SceneErrors`]. Lengths, pressures and so on are [`Quantity`] values in SI that remember where
//! they were typed, so that later steps can underline them too.

mod base;
mod diagnostics;
mod draft;
mod load;
mod loading;
mod overrides;
pub mod quantity;
mod range;
mod reader;
mod recover;
mod schema;
mod sections;
mod shape;
mod sources;
mod span;
mod stages;
mod suggest;
mod tree;
pub mod units;
mod validate;

#[cfg(test)]
pub(crate) mod rules_tests;

pub use diagnostics::{Diagnostic, SceneErrors};
pub use load::{Load, TimeSeries};
pub use loading::{LoadedScene, load_file, load_layers, load_str, with_layers};
pub use overrides::Override;
pub use quantity::{Dimension, Quantity};
pub use schema::json_schema;
pub use sections::*;
pub use shape::{BoxShape, DiscShape, HalfPlaneShape, PolygonShape, SetShape, Shape};
pub use sources::Sources;
pub use span::{Entry, Named, Span, Spanned};
pub use stages::{Stage, load_stages};
pub use suggest::{closest, one_of};

/// What the user typed, complete and free of contradictions.
///
/// An optional section that is absent means that its effect does not exist.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Title, shown in reports and pictures, if it has one.
    pub title: Option<String>,
    /// What the case shows.
    pub description: Option<String>,
    /// The domain and its points.
    pub geometry: Spanned<Geometry>,
    /// How far a point sees.
    pub horizon: Spanned<Horizon>,
    /// What fills the pores; always there if there is flow.
    pub fluid: Option<Spanned<Fluid>>,
    /// What the rock is like, and where; at least one, in the order of the file.
    pub materials: Named<Material>,
    /// Gravity, if it acts.
    pub gravity: Option<Spanned<Gravity>>,
    /// The in-situ state, if it is told.
    pub initial: Option<Spanned<Initial>>,
    /// Flow, if it is computed.
    pub flow: Option<Spanned<Flow>>,
    /// Deformation, if it is computed.
    pub mechanics: Option<Spanned<Mechanics>>,
    /// How flow and deformation feel each other; always there if there are both.
    pub coupling: Option<Spanned<Coupling>>,
    /// Breaking of the rock, if it is computed.
    pub damage: Option<Spanned<Damage>>,
    /// Flow in what is broken, if it is computed.
    pub fracture_flow: Option<Spanned<FractureFlow>>,
    /// Cracks that are there from the start, in the order of the file.
    pub cracks: Spanned<Named<Crack>>,
    /// Sources and sinks at points, in the order of the file.
    pub wells: Spanned<Named<Well>>,
    /// The run that this one goes on from, if it does.
    pub start: Option<Spanned<Start>>,
    /// How long, and in which steps.
    pub time: Spanned<TimeControl>,
    /// How the step is taken.
    pub scheme: Spanned<Scheme>,
    /// Who solves the linear systems.
    pub solver: Spanned<Solver>,
    /// How well balances must close.
    pub audit: Spanned<Audit>,
    /// What is written, and when.
    pub output: Spanned<Output>,
    /// An exact solution to compare with.
    pub reference: Option<Spanned<Reference>>,
}
