//! Bundled cases, by name.

/// A case that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// Text of its scene.toml.
    pub scene: &'static str,
    /// Text of its README.md.
    pub readme: &'static str,
}

macro_rules! case {
    ($name:literal, $summary:literal) => {
        Case {
            name: $name,
            summary: $summary,
            scene: include_str!(concat!("../../cases/", $name, "/scene.toml")),
            readme: include_str!(concat!("../../cases/", $name, "/README.md")),
        }
    };
}

/// All bundled cases.
pub const CASES: &[Case] = &[
    case!(
        "five-spot",
        "quarter of a confined five-spot (Sec. 5.3), transient to steady"
    ),
    case!(
        "two-layer",
        "two layers in series with any permeability contrast"
    ),
    case!("channel", "a one-cell-wide channel of high permeability"),
    case!("heterogeneous", "log-normal permeability over six decades"),
    case!(
        "reservoir-3d",
        "a small five-spot in three dimensions with gravity"
    ),
    case!(
        "theis",
        "a well in a wide aquifer, against the Theis solution"
    ),
    case!(
        "terzaghi",
        "consolidation of a loaded column (Sec. 5.2), against Terzaghi's solution"
    ),
    case!(
        "terzaghi-graded",
        "the same on 2:1 blocks, from 0.025 m to 0.1 m"
    ),
    case!(
        "terzaghi-tensor",
        "the same on a tensor grid, from 0.025 m to 0.1 m"
    ),
    case!("column-3d", "the same in three dimensions"),
    case!(
        "mandel",
        "a strip squeezed between rigid plates: the Mandel-Cryer effect"
    ),
    case!(
        "footing",
        "a strip footing on a nearly undrained layer: the pressure-oscillation trap"
    ),
    case!(
        "sneddon",
        "a crack opened by pressure, against Sneddon's solution"
    ),
    case!(
        "manufactured",
        "a smooth solution with its own source, for convergence studies"
    ),
];

/// The bundled case called `name`.
pub fn find(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|case| case.name == name)
}

/// Names of all bundled cases.
pub fn names() -> Vec<&'static str> {
    CASES.iter().map(|case| case.name).collect()
}
