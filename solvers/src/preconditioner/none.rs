//! Preconditioner `none`: M = 1.

use super::Preconditioner;
use crate::registry::Options;
use crate::{CsrView, Problem, SolveError, SpecError};

pub(super) fn build(_options: &Options<'_>) -> Result<Box<dyn Preconditioner>, SpecError> {
    Ok(Box::new(Identity))
}

struct Identity;

impl Preconditioner for Identity {
    fn analyse(&mut self, _problem: &Problem<'_>) -> Result<(), SolveError> {
        Ok(())
    }

    fn refresh(&mut self, _matrix: CsrView<'_>) -> Result<(), SolveError> {
        Ok(())
    }

    fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        correction.copy_from_slice(residual);
    }
}
