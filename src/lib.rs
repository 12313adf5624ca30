//! Implicit peridynamics for porous rock.
//!
//! ```text
//! scene.toml → Scene → Plan → Cloud, Families → operators → Model → Scheme { blocks → solver }
//!                                                             └→ accept or reject → output, report
//! ```
//!
//! *Effects* act at points, *operators* act on bonds, *schemes* combine them over time, *backends*
//! (crate `perifrac-solvers`) solve. Modules depend on each other in the order in which they stand
//! here, never backwards; a test checks it.

pub mod load;
pub mod geometry;
pub mod material;
pub mod reference;
pub mod scene;
pub mod plan;
pub mod operators;
pub mod assembly;
pub mod report;
pub mod effects;
pub mod boundary;
pub mod model;
pub mod explain;
pub mod schemes;
pub mod output;
pub mod run;
pub mod cases;
pub mod cli;
