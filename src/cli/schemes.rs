//! `perifrac schemes`.

use crate::plan::capability;

use super::exit::{Failure, print};

/// Prints what can be combined.
pub(super) fn run() -> Result<(), Failure> {
    print(&capability::page())
}
