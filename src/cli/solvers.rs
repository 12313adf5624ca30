//! `perifrac solvers`.

use perifrac_solvers::BACKENDS;

use super::exit::{Failure, print};

/// Arguments of `solvers`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Lists solvers and options.
pub fn run(_args: &Args) -> Result<(), Failure> {
    let mut text =
        String::from("Choose with --solver NAME or --solver NAME:key=value,key=value\n\n");
    for backend in BACKENDS {
        text += &format!("{:10} {}\n", backend.name, backend.summary);
        let kinds: Vec<String> = backend.symmetries.iter().map(ToString::to_string).collect();
        text += &format!("{:10}   for {} systems\n", "", kinds.join(", "));
        for option in backend.options {
            text += &format!(
                "{:10}   {}={} (default {}): {}\n",
                "",
                option.key,
                option.value.describe(),
                option.default,
                option.meaning
            );
        }
    }
    print(&text)
}
