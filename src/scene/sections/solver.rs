//! `[solver]`: who solves the linear systems.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::scene::diagnostics::Diagnostic;
use crate::scene::span::{Span, Spanned};
use crate::scene::validate::{Context, Report, Section};

/// Who solves the linear systems.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Name and options as text: `"auto"`, `"faer-cg:preconditioner=jacobi"`. Flags of PETSc that
    /// read or write files or print are taken from the command line only.
    pub name: Spanned<String>,
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            name: Spanned::nowhere("auto".to_owned()),
        }
    }
}

impl Section for Solver {
    const NAME: &'static str = "solver";

    fn check(&self, _: Span, _: &Context<'_>, report: &mut Report) {
        if self.name.trim().is_empty() {
            let fault = Diagnostic::new("`name` of the solver is empty").at(self.name.span);
            report.add(fault.help("write name = \"auto\""));
        }
    }
}
