//! One run: build the model, step to the end, write what was asked for.

mod error;
mod time_loop;
mod summary;
mod writer;

pub use error::RunError;
pub use time_loop::{Observer, Progress, run};
pub use summary::{FieldError, Summary};
pub use writer::Writer;
