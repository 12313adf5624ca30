mod convergence;
mod levels;
mod refresh;
pub(crate) mod support;
