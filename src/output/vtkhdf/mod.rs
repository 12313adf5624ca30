//! Fields of all outputs in one file (`.vtkhdf`), in a program with the feature of that name.

#[cfg(not(feature = "vtkhdf"))]
mod blank;
#[cfg(feature = "vtkhdf")]
mod file;

#[cfg(not(feature = "vtkhdf"))]
pub use blank::{append_vtkhdf, create_vtkhdf, cut_vtkhdf};
#[cfg(feature = "vtkhdf")]
pub use file::{append_vtkhdf, create_vtkhdf, cut_vtkhdf};
