//! The command-line program `perifrac`.

use std::process::ExitCode;

fn main() -> ExitCode {
    perifrac::cli::main()
}
