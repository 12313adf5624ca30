//! The configurations of the ladder, family by family.

use super::{Judge, Rung};

/// Writes the same overrides in every combination.
fn set<T: std::fmt::Display>(key: &str, value: T) -> String {
    format!("{key}={value}")
}

/// All of them.
pub fn all() -> Vec<Rung> {
    let families = [layers(), wells(), bars(), fractures()];
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
        judge: Judge::Exact("pressure", bar),
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
                            judge: Judge::Exact("pressure", 0.02),
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
                                bar: 0.04,
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
step = 0.01
max_steps = 2000
"#;

/// Injection: rate × permeability × storage of the fracture × scheme, against monolithic steps.
fn fractures() -> Vec<Rung> {
    let mut rungs = Vec::new();
    for rate in [1e-6, 1e-4, 1e-3] {
        for permeability in [1e-18, 1e-15, 1e-12] {
            for storage in [1e-12, 1e-9] {
                for scheme in ["staggered", "monolithic"] {
                    let of = |scheme: &str| {
                        vec![
                            set("cracks.main.injection.rate", rate),
                            set("materials.rock.permeability", permeability),
                            set("fracture_flow.storage", storage),
                            set("scheme.name", scheme),
                        ]
                    };
                    rungs.push(Rung {
                        name: format!(
                            "fracture {rate:.0e}, {permeability:.0e} m², storage {storage:.0e}, {scheme}"
                        ),
                        family: "fracture: rate, permeability, storage, scheme",
                        scene: FRACTURE,
                        overrides: of(scheme),
                        judge: match scheme {
                            "staggered" => Judge::Like(of("monolithic"), 1e-3),
                            _ => Judge::Like(of("staggered"), 1e-3),
                        },
                    });
                }
            }
        }
    }
    rungs
}
