//! The compiled part of the Python package `perifrac`: scenes, runs and arrays. What users see of it is in
//! `perifrac/*.py`.

mod arrays;
mod errors;
mod files;
mod loads;
mod pictures;
mod recipe;
mod relay;
mod session;
mod worker;

use pyo3::prelude::*;

/// The compiled part of perifrac.
#[pymodule]
mod _perifrac {
    #[pymodule_export]
    use super::pictures::picture;
    #[pymodule_export]
    use super::recipe::{Recipe, case_layers, cases, checkpoint, file_layers, report};
    #[pymodule_export]
    use super::session::Session;

    /// Version of the library.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
