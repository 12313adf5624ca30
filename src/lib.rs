//! Implicit peridynamics for porous rock: flow, poroelasticity, fracture.
//!
//! ```text
//! scene.toml → Scene → Plan → Cloud, Families → operators → Model → Scheme { blocks → solver }
//!                                                             └→ accept or reject → output, report
//! ```
//!
//! *Effects* act at points, *operators* act on bonds, *schemes* combine them over time, *backends*
//! (crate `perifrac-solvers`) solve.
//!
//! | to | see |
//! |---|---|
//! | run a scene from a program | [`prelude`], [`Setup`](plan::Setup), [`run`](prelude::run) |
//! | look at a run, or stop it | [`Observer`](prelude::Observer), [`Interrupt`](prelude::Interrupt) |
//! | step by oneself | [`Model`](prelude::Model), [`build_scheme`](prelude::build_scheme), [`Scheme`](prelude::Scheme) |
//! | use own points and permeabilities | [`PointTable`](plan::PointTable) |
//! | add a source or a load | [`Effect`](plan::Effect), [`OwnEffect`](plan::OwnEffect) |
//! | compare with exact solutions | [`reference`](mod@reference) |
//!
//! Each has an example in the folder `examples`.
//!
//! # Features
//!
//! All are on by default; a program that only computes needs none of them.
//!
//! - `cli`: the program `perifrac`
//! - `plots`: pictures and drawings of runs
//! - `study`: reports, and studies, which run the program many times
//!
//! # Stability
//!
//! What this documentation shows is the interface. Modules that it does not show are open to the tests
//! and benches of this package, and change without notice.

#![warn(unreachable_pub)]

// Modules use only those before them in this order, which tests/architecture.rs holds: parallel, load,
// geometry, material, reference, scene, plan, operators, assembly, report, effects, boundary, model,
// explain, schemes, output, run, prelude, cases, study, cli.

mod assembly;
mod boundary;
#[doc(hidden)]
pub mod cases;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod effects;
#[doc(hidden)]
pub mod explain;
#[doc(hidden)]
pub mod geometry;
mod load;
mod material;
#[doc(hidden)]
pub mod model;
mod operators;
#[doc(hidden)]
pub mod output;
mod parallel;
pub mod plan;
pub mod prelude;
pub mod reference;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod run;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod schemes;
#[cfg(feature = "study")]
mod study;

#[cfg(feature = "study")]
pub use study::{StudyError, draw_frames, report_run};
