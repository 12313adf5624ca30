//! Files a run leaves behind: fields (VTU, PVD, VTKHDF), cracks (VTP), histories (CSV), summaries (JSON) and plots
//! (PNG, SVG).
//!
//! Every writer takes plain slices and knows nothing of the model. Whole files are written
//! atomically ([`write_atomically`]): a reader sees the old file or the new one, never half of one.
//! Histories grow line by line and are flushed after each line, so that a killed run leaves whole
//! lines. What a run wrote stands in a list ([`Manifest`]), and one run at a time writes into a folder
//! ([`FolderLock`]). But for that list nothing here depends on the clock or on threads: the same
//! input gives the same bytes.

mod atomic;
pub mod checkpoint;
mod error;
mod history;
mod lock;
mod manifest;
pub mod plots;
mod pvd;
mod pvtu;
mod summary;
mod vtk;
mod vtkhdf;
mod vtp;
mod vtu;

pub use atomic::write_atomically;
pub use checkpoint::CheckpointError;
pub use error::OutputError;
pub use history::{History, Table};
pub use lock::{FolderLock, LOCK};
pub use manifest::{LIST, Manifest, remove_results};
#[cfg(feature = "plots")]
pub use plots::lines_text;
pub use plots::{
    About, DRAWS, FieldPlot, IsometricPlot, LinePlot, LineStyle, Multiples, NARROW, PICTURE_KEY,
    PathPlot, PictureFacts, Scale, Series, SetupMark, SetupPlot, SideSign, Sign, Tile, WIDE,
    animation_png, field_png, isometric_png, lines_svg, multiples_png, paths_svg, setup_png,
};
pub use pvd::Pvd;
pub use pvtu::write_pvtu;
pub use summary::write_json;
pub use vtk::{Cells, Field};
pub use vtkhdf::{append_vtkhdf, create_vtkhdf, cut_vtkhdf};
pub use vtp::{VtpData, write_vtp};
pub use vtu::{VtuData, write_vtu};
