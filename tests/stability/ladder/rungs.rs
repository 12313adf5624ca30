//! The configurations of the ladder, family by family.

use super::{Judge, Rung};

/// Writes the same overrides in every combination.
fn set<T: std::fmt::Display>(key: &str, value: T) -> String {
    format!("{key}={value}")
}

/// All of them.
pub fn all() -> Vec<Rung> {
    let families = [layers(), wells(), columns(), bars(), fractures()];
    families.into_iter().flatten().collect()
}

const LAYERS: &str = include_str!("../../../cases/two-layer/scene.toml");

/// Two layers in series: contrast × operator × scheme × jitter × horizon, against the exact pressure.
fn layers() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for contrast in [1e-12, 1e-8, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e8, 1e12] {
        for operator in ["auto", "bond", "correspondence"] {
            for scheme in ["implicit", "explicit"] {
                for jitter in [0.0, 0.2] {
                    for horizon in ["neighbours=15", "ratio=3.1"] {
                        rungs.push(layer(contrast, operator, scheme, jitter, horizon));
                    }
                }
            }
        }
    }
    rungs
}

fn layer(contrast: f64, operator: &str, scheme: &str, jitter: f64, horizon: &str) -> Rung {
    // The slower layer needs a time of its own to feel the other.
    let end = 0.1 / f64::min(contrast, 1.0);
    // The arithmetic mean at the interface is off by 7 % of the flux; points off their places by less.
    let bar = match (operator, jitter > 0.0) {
        ("correspondence", _) => 0.1,
        (_, true) => 0.05,
        (_, false) => 0.01,
    };
    Rung {
        name: format!("layers {contrast:.0e} {operator} {scheme} jitter {jitter} {horizon}"),
        family: "two layers: contrast, operator, jitter, horizon",
        scene: LAYERS,
        overrides: vec![
            set("materials.left.permeability", contrast),
            set("flow.operator", operator),
            set("scheme.name", scheme),
            set("geometry.points", "[40, 6]"),
            set("geometry.jitter", jitter),
            format!("horizon.{horizon}"),
            set("time.end", end),
            set("time.max_steps", 20_000),
            set("output.times", "[]"),
        ],
        judge: Judge::Exact("pressure", bar, 0.0),
    }
}

const WELLS: &str = include_str!("../../../cases/five-spot/scene.toml");

/// Wells: storage × steps × operator × integrator, against the exact transient.
fn wells() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for storage in [1e-14, 1e-11, 1e-8] {
        for tolerance in [1e-3, 1e-5] {
            for operator in ["auto", "bond"] {
                for (scheme, integrator) in [
                    ("implicit", "tr-bdf2"),
                    ("implicit", "backward-euler"),
                    ("explicit", "tr-bdf2"),
                ] {
                    for jitter in [0.0, 0.2] {
                        rungs.push(Rung {
                            name: format!(
                                "wells {storage:.0e} {tolerance:.0e} {operator} {scheme} {integrator} {jitter}"
                            ),
                            family: "wells: storage, tolerance, operator, integrator, jitter",
                            scene: WELLS,
                            overrides: vec![
                                set("materials.rock.storage", storage),
                                set("time.tolerance", tolerance),
                                set("time.integrator", integrator),
                                set("flow.operator", operator),
                                set("scheme.name", scheme),
                                set("geometry.points", "[25, 25]"),
                                set("geometry.jitter", jitter),
                                // The same state of the transient whatever the storage is.
                                set("time.end", TRANSIENT * storage),
                                set("time.max_steps", 20_000),
                                set("output.times", "[]"),
                            ],
                            judge: Judge::Exact("pressure", 0.02, 0.0),
                        });
                    }
                }
            }
        }
    }
    rungs
}

/// Time over storage at which the five-spot is in the middle of its transient, s Pa: 0.1 L²/κ.
const TRANSIENT: f64 = 1e9;

const COLUMN: &str = include_str!("../../../cases/terzaghi/scene.toml");

/// Length of the column over which it drains, m, and mobility, m²/(Pa s).
const COLUMN_LENGTH: f64 = 15.0;
const COLUMN_MOBILITY: f64 = 1e-9;
/// What it bears, Pa.
const LOAD: f64 = 1e4;

/// Terzaghi's column: step × storage × Poisson's ratio × time × scheme, against the exact pressure.
fn columns() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for storage in [1e-13, 1.65e-10, 1e-8] {
        for ratio in [0.0, 0.25, 0.45, 0.499] {
            for (time, steps) in [(0.01, None), (0.2, None), (0.2, Some(50)), (3.0, None)] {
                for scheme in ["monolithic", "staggered", "semi-implicit", "explicit"] {
                    rungs.push(column(storage, ratio, time, steps, scheme));
                }
            }
        }
    }
    rungs
}

/// `time` is that of consolidation, c t / H²; without a number of steps their error controls them.
fn column(storage: f64, ratio: f64, time: f64, steps: Option<u32>, scheme: &str) -> Rung {
    let modulus = 1e8 * (1.0 - ratio) / ((1.0 + ratio) * (1.0 - 2.0 * ratio));
    let diffusivity = COLUMN_MOBILITY / (storage + 0.25 / modulus);
    let undrained = 0.5 * LOAD / modulus / (storage + 0.25 / modulus);
    let end = time * COLUMN_LENGTH.powi(2) / diffusivity;
    let mut overrides = vec![
        set("materials.rock.storage", storage),
        set("materials.rock.poissons_ratio", ratio),
        set("scheme.name", scheme),
        set("geometry.spacing", 0.5),
        set("time.end", end),
        set("time.max_steps", 20_000),
        set("output.times", "[]"),
    ];
    overrides.extend(steps.map(|count| set("time.step", end / f64::from(count))));
    Rung {
        name: format!("column {storage:.0e} ν {ratio} at {time} in {steps:?} {scheme}"),
        family: "column: storage, Poisson's ratio, time, step, scheme",
        scene: COLUMN,
        overrides,
        // Where most has drained, a part of what the load raised at first counts as the range. Steps of a given
        // length have the error that they have.
        judge: Judge::Exact(
            "pressure",
            if steps.is_some() { 0.05 } else { 0.03 },
            0.2 * undrained,
        ),
    }
}

const BAR: &str = r#"
title = "Bar that is pulled"
[geometry]
type = "lattice"
size = [4, 1]
points = [24, 6]
[materials.rock]
youngs_modulus = 1e9
poissons_ratio = 0.2
[mechanics]
[mechanics.boundary.left]
roller = true
[mechanics.boundary.bottom]
roller = true
[mechanics.boundary.right]
traction = [1e6, 0]
[time]
mode = "transient"
end = 1
[scheme]
adr_iterations = 200000
"#;

/// Uniform stress: jitter × Poisson's ratio × gradient × horizon × scheme, against Hooke's law.
fn bars() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for jitter in [0.0, 0.1, 0.3] {
        for ratio in [0.0_f64, 0.3, 0.49, 0.4999] {
            for gradient in ["auto", "plain"] {
                for horizon in ["neighbours=15", "ratio=3.1"] {
                    for scheme in ["implicit", "explicit"] {
                        if gradient == "plain" && jitter > 0.2 {
                            // Ghost forces of the plain gradient leave 7 % there, as documented.
                            continue;
                        }
                        // Plane strain; points end half a cell before the side.
                        let strain = 1e6 * (1.0 - ratio * ratio) / 1e9;
                        rungs.push(Rung {
                            name: format!("bar {jitter} ν {ratio} {gradient} {horizon} {scheme}"),
                            family: "bar: jitter, Poisson's ratio, gradient, horizon, scheme",
                            scene: BAR,
                            overrides: vec![
                                set("geometry.jitter", jitter),
                                set("materials.rock.poissons_ratio", ratio),
                                set("mechanics.gradient", gradient),
                                format!("horizon.{horizon}"),
                                set("scheme.name", scheme),
                            ],
                            judge: Judge::Tip {
                                axis: 0,
                                value: strain * (4.0 - 0.5 * 4.0 / 24.0),
                                // Ghost forces of the plain gradient are warned of, and take up to 3.7 %.
                                bar: if gradient == "plain" { 0.04 } else { 0.03 },
                            },
                        });
                    }
                }
            }
        }
    }
    rungs
}

const FRACTURE: &str = r#"
title = "Injection into a crack"
[geometry]
type = "lattice"
size = [0.48, 0.96]
spacing = 0.06
[fluid]
viscosity = 1e-3
[materials.rock]
youngs_modulus = 1e8
poissons_ratio = 0.25
fracture_energy = 100
permeability = 1e-12
storage = 1e-10
biot_coefficient = 1
[mechanics]
[mechanics.boundary.left]
roller = true
[mechanics.boundary.right]
clamped = true
[mechanics.boundary.top]
clamped = true
[mechanics.boundary.bottom]
clamped = true
[flow]
[flow.boundary.right]
pressure = 0
[flow.boundary.top]
pressure = 0
[flow.boundary.bottom]
pressure = 0
[coupling]
undrained_start = false
[damage]
model = "paper"
length_scale = 0.18
normalise = true
[fracture_flow]
storage = 1e-10
[cracks.main]
kind = "damaged"
points = [[0, 0.48], [0.15, 0.48]]
injection = { rate = 1e-3, at = [0, 0.48] }
[scheme]
name = "monolithic"
[time]
end = 0.05
max_steps = 20_000
"#;

/// Injection: rate × permeability × storage of the fracture × scheme, against both fields at once.
fn fractures() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for rate in [1e-6, 1e-4, 1e-3] {
        for permeability in [1e-18, 1e-15, 1e-12] {
            for storage in [1e-12, 1e-9] {
                for scheme in ["staggered", "semi-implicit", "explicit"] {
                    rungs.push(fracture(rate, permeability, storage, scheme));
                }
            }
        }
    }
    rungs
}

fn fracture(rate: f64, permeability: f64, storage: f64, scheme: &str) -> Rung {
    let of = |scheme: &str| {
        vec![
            set("cracks.main.injection.rate", rate),
            set("materials.rock.permeability", permeability),
            set("fracture_flow.storage", storage),
            set("scheme.name", scheme),
        ]
    };
    // Steps in turns solve the same equations as both fields at once, in the same steps. Those of the other
    // schemes are held against short ones.
    let (mut own, mut peer) = (of(scheme), of("monolithic"));
    let bar = match scheme {
        "staggered" => {
            own.push("time.step=0.0025".to_owned());
            peer.push("time.step=0.0025".to_owned());
            1e-3
        }
        _ => {
            own.push("time.tolerance=3e-4".to_owned());
            peer.push("time.step=0.001".to_owned());
            0.05
        }
    };
    Rung {
        name: format!("fracture {rate:.0e}, {permeability:.0e} m², storage {storage:.0e} {scheme}"),
        family: "fracture: rate, permeability, storage, scheme",
        scene: FRACTURE,
        overrides: own,
        // Steps are as long as their error allows; those in turns solve the same equations.
        judge: Judge::Like(peer, bar),
    }
}
