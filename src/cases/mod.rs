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
    /// Names and texts of files that change the scene: `smoke` runs in seconds, `paper` has the size of
    /// the paper.
    pub variants: &'static [(&'static str, &'static str)],
}

macro_rules! case {
    ($name:literal, $summary:literal $(, $variant:literal)*) => {
        Case {
            name: $name,
            summary: $summary,
            scene: include_str!(concat!("../../cases/", $name, "/scene.toml")),
            readme: include_str!(concat!("../../cases/", $name, "/README.md")),
            variants: &[$((
                $variant,
                include_str!(concat!("../../cases/", $name, "/", $variant, ".toml")),
            )),*],
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
    case!("barrier", "a one-cell-thick barrier of low permeability"),
    case!(
        "inclusion",
        "a cylinder of another permeability, one of a square array"
    ),
    case!("heterogeneous", "log-normal permeability over six decades"),
    case!(
        "spe10-1",
        "the permeability of SPE 10, model 1, against the flux between two points",
        "flat"
    ),
    case!(
        "reservoir-3d",
        "a small five-spot in three dimensions with gravity"
    ),
    case!(
        "theis",
        "a well in a wide aquifer, against the Theis solution"
    ),
    case!(
        "anisotropic",
        "a well where rock conducts better along one axis, against the exact solution"
    ),
    case!(
        "well-test",
        "drawdown and build-up of a well, against Theis and his superposition",
        "limited"
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
        "layers-stiffness",
        "two stiffnesses in series: the stress does not know of the interface"
    ),
    case!(
        "sneddon",
        "a crack opened by pressure, against Sneddon's solution"
    ),
    case!(
        "notched-tension",
        "a notched square pulled apart (Sec. 5.1): a straight crack",
        "smoke",
        "paper",
        "fine",
        "uniform"
    ),
    case!(
        "notched-shear",
        "a notched square sheared (Sec. 5.1): a crack that turns down",
        "smoke",
        "paper",
        "uniform"
    ),
    case!(
        "pressurised-notch",
        "a crack driven by pressure (Sec. 5.4), against Sneddon and Griffith",
        "smoke",
        "paper"
    ),
    case!(
        "natural-fractures",
        "injection into a crack with natural fractures in its way (Sec. 5.5)",
        "smoke",
        "paper",
        "vertical",
        "wide"
    ),
    case!(
        "injection-rate",
        "injection into a single crack at 2, 4 and 6 l/s (Sec. 5.5)",
        "smoke",
        "four",
        "six"
    ),
    case!(
        "kgd-toughness",
        "a crack in plane strain that fluid without friction drives, against its exact solution",
        "smoke"
    ),
    case!(
        "kgd-viscosity",
        "a crack in plane strain that a viscous fluid drives, against its exact solution",
        "smoke"
    ),
    case!(
        "kgd-leak-off",
        "a crack in plane strain that loses half of its fluid to the rock, against Carter's leak-off",
        "smoke"
    ),
    case!(
        "breakdown",
        "the pressure at which a pumped crack begins to run, and the in-situ stress across it",
        "smoke"
    ),
    case!(
        "inclined-injection",
        "a pumped crack at 45° to the in-situ stresses, which turns to the larger one",
        "smoke",
        "turned"
    ),
    case!(
        "two-cracks",
        "cracks side by side that fluid drives away from each other, against LEFM",
        "smoke"
    ),
    case!(
        "wing-cracks",
        "a closed crack under compression whose tips turn, against LEFM",
        "smoke"
    ),
    case!(
        "staged-injection",
        "in-situ stress, drainage, injection and shut-in, one after the other"
    ),
    case!(
        "penny-3d",
        "a penny-shaped crack under pressure, an eighth of it in space",
        "smoke"
    ),
    case!(
        "penny-viscosity",
        "a penny-shaped crack that a viscous fluid drives, an eighth of it, against its exact solution",
        "smoke"
    ),
    case!(
        "manufactured",
        "a smooth solution with its own source, for convergence studies"
    ),
];

impl Case {
    /// Texts of the scene, or of one of its variants, with their names for messages.
    pub fn layers(&self, variant: Option<&str>) -> Option<Vec<(String, &'static str)>> {
        let mut layers = vec![(format!("{} (bundled case)", self.name), self.scene)];
        if let Some(wanted) = variant {
            let (name, text) = self.variants.iter().find(|(name, _)| *name == wanted)?;
            layers.push((format!("{}/{name} (bundled case)", self.name), text));
        }
        Some(layers)
    }
}

/// The bundled case called `name`.
pub fn find(name: &str) -> Option<&'static Case> {
    CASES.iter().find(|case| case.name == name)
}

/// Names of all bundled cases.
pub fn names() -> Vec<&'static str> {
    CASES.iter().map(|case| case.name).collect()
}
