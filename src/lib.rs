//! Implicit peridynamics for porous rock.
//!
//! ```text
//! scene.toml → Scene → Plan → Cloud, Families → operators → Model → Scheme { blocks → solver }
//!                                                             └→ accept or reject → output, report
//! ```
//!
//! *Effects* act at points, *operators* act on bonds, *schemes* combine them over time, *backends*
//! (crate `perifrac-solvers`) solve. Modules use only those before them in this order, which a test
//! holds: load, geometry, material, reference, scene, plan, operators, assembly, report, effects,
//! boundary, model, explain, schemes, output, run, cases, study, cli.

pub mod assembly;
pub mod boundary;
pub mod cases;
#[cfg(feature = "cli")]
pub mod cli;
pub mod effects;
pub mod explain;
pub mod geometry;
pub mod load;
pub mod material;
pub mod model;
pub mod operators;
pub mod output;
pub mod parallel;
pub mod plan;
pub mod reference;
pub mod report;
pub mod run;
pub mod scene;
pub mod schemes;
#[cfg(feature = "study")]
pub mod study;
