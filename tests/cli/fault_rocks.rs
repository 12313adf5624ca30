//! Scenes that can be read but make no sense: fluid, materials, sides, loads and wells.

use crate::support::{FAULT, Fault, check};

#[test]
fn fluids_and_materials_that_cannot_be() {
    check(&[
        Fault {
            name: "a negative permeability",
            change: &[("\"1 mD\"", "\"-1 mD\"")],
            stderr: r#"
error: `permeability` must be positive
 --> scene.toml:9:16
  |
9 | permeability = "-1 mD"
  |                ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a viscosity of zero",
            change: &[("\"1 cP\"", "0")],
            stderr: r#"
error: `viscosity` must be positive
 --> scene.toml:7:13
  |
7 | viscosity = 0
  |             ^
"#,
            ..FAULT
        },
        Fault {
            name: "storage given in two ways",
            change: &[("storage =", "porosity = 0.2\nstorage =")],
            stderr: r#"
error: `storage` excludes `porosity`
  --> scene.toml:10:12
   |
10 | porosity = 0.2
   |            ^^^
11 | storage = "1e-10 1/Pa"
   |           ------------ given here
   |
   = help: keep one of them
"#,
            ..FAULT
        },
        Fault {
            name: "a porosity in percent without its unit",
            change: &[(
                "storage = \"1e-10 1/Pa\"",
                "porosity = 20\nbiot_coefficient = 0.8\nbulk_modulus = \"10 GPa\"",
            )],
            stderr: r#"
error: storage by Eq. 38 needs `fluid.bulk_modulus`
 --> scene.toml:8:12
  |
8 | [materials.rock]
  |            ^^^^
  |
  = help: for water: bulk_modulus = "2.2 GPa"

error: `porosity` must lie between 0 and 1, found 20
  --> scene.toml:10:12
   |
10 | porosity = 20
   |            ^^
   |
   = help: it is a share of the volume

error: `biot_coefficient` must not be below `porosity` (Eq. 38)
  --> scene.toml:11:20
   |
10 | porosity = 20
   |            -- the porosity
11 | biot_coefficient = 0.8
   |                    ^^^

3 errors in scene.toml
"#,
            ..FAULT
        },
        Fault {
            name: "no storage in a transient run",
            change: &[("storage = \"1e-10 1/Pa\"\n", "")],
            stderr: r#"
error: material `rock` has no storage
 --> scene.toml:8:12
  |
8 | [materials.rock]
  |            ^^^^
  |
  = help: add `storage`, or `porosity`, `biot_coefficient` and `bulk_modulus` (Eq. 38)
"#,
            ..FAULT
        },
        Fault {
            name: "no material",
            change: &[
                ("[materials.rock]\n", ""),
                ("permeability = \"1 mD\"\n", ""),
                ("storage = \"1e-10 1/Pa\"\n", ""),
            ],
            stderr: r#"
error: the scene has no [materials.NAME]
--> scene.toml
 = help: add [materials.NAME] with `permeability` and `storage`
"#,
            ..FAULT
        },
        Fault {
            name: "two backgrounds",
            change: &[(
                "[flow.boundary.left]",
                "[materials.sand]\npermeability = \"1 D\"\nstorage = 1e-10\n[flow.boundary.left]",
            )],
            stderr: r#"
error: only one material can go without a `region`
  --> scene.toml:11:12
   |
 8 | [materials.rock]
   |            ---- has none either
...
11 | [materials.sand]
   |            ^^^^
   |
   = help: give one of them a region
"#,
            ..FAULT
        },
        Fault {
            name: "a region between the points",
            change: &[(
                "[flow.boundary.left]",
                "[materials.seam]\npermeability = \"1 D\"\nstorage = 1e-10\n\
                 region = { type = \"box\", min = [0, 0.49], max = [1, 0.51] }\n\
                 [flow.boundary.left]",
            )],
            stderr: r#"
error: the region of material "seam" holds no point; enlarge it or refine the cloud
  --> scene.toml:14:10
   |
14 | region = { type = "box", min = [0, 0.49], max = [1, 0.51] }
   |          ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "points without a material",
            change: &[(
                "[materials.rock]",
                "[materials.rock]\nregion = { type = \"disc\", centre = [0.5, 0.5], radius = 0.4 }",
            )],
            stderr: r#"
error: 32 points have no material, the first at [0.0625, 0.0625]; add a material without a region as the background
 --> scene.toml:8:12
  |
8 | [materials.rock]
  |            ^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a box turned inside out",
            change: &[(
                "[materials.rock]",
                "[materials.rock]\nregion = { type = \"box\", min = [1, 0], max = [0, 1] }",
            )],
            stderr: r#"
error: `max` must be greater than `min` along every axis
 --> scene.toml:9:46
  |
9 | region = { type = "box", min = [1, 0], max = [0, 1] }
  |                                ------ `min`  ^^^^^^
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn sides_and_loads_that_cannot_be() {
    check(&[
        Fault {
            name: "a side with two conditions",
            change: &[("\"1 MPa\"", "\"1 MPa\"\nflux = 0")],
            stderr: r#"
error: `pressure` excludes `flux`
  --> scene.toml:13:1
   |
12 | pressure = "1 MPa"
   | -------- given here
13 | flux = 0
   | ^^^^
   |
   = help: keep one of them
"#,
            ..FAULT
        },
        Fault {
            name: "a side that does not exist",
            change: &[("[flow.boundary.left]", "[flow.boundary.lift]")],
            stderr: r#"
error: unknown key `lift`
  --> scene.toml:11:16
   |
11 | [flow.boundary.lift]
   |                ^^^^
   |
   = help: did you mean `left`?
"#,
            ..FAULT
        },
        Fault {
            name: "a side of a space in a plane",
            change: &[("[flow.boundary.left]", "[flow.boundary.front]")],
            stderr: r#"
error: a plane domain has no side `front`
  --> scene.toml:11:1
   |
11 | [flow.boundary.front]
   | ^^^^^^^^^^^^^^^^^^^^^
   |
   = help: its sides are `left`, `right`, `bottom` and `top`
"#,
            ..FAULT
        },
        Fault {
            name: "a load whose times go back",
            change: &[("\"1 MPa\"", "{ time = [0, 50, 20], value = [0, 1e6, 0] }")],
            stderr: r#"
error: `time` must increase from entry to entry
  --> scene.toml:12:29
   |
12 | pressure = { time = [0, 50, 20], value = [0, 1e6, 0] }
   |                             ^^
"#,
            ..FAULT
        },
        Fault {
            name: "a load with more times than values",
            change: &[("\"1 MPa\"", "{ time = [0, 20, 50], value = [0, 1e6] }")],
            stderr: r#"
error: `value` needs one entry for each of the 3 times, found 2
  --> scene.toml:12:42
   |
12 | pressure = { time = [0, 20, 50], value = [0, 1e6] }
   |                     -----------          ^^^^^^^^
   |                     |
   |                     the times
"#,
            ..FAULT
        },
        Fault {
            name: "a load that changes in a steady run",
            change: &[
                ("\"1 MPa\"", "{ time = [0, 50], value = [0, 1e6] }"),
                ("end = \"100 s\"", "mode = \"steady\""),
            ],
            stderr: r#"
error: a steady run needs loads that are constant in time
  --> scene.toml:12:38
   |
12 | pressure = { time = [0, 50], value = [0, 1e6] }
   |                                      ^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "gravity without a fluid that it could act on",
            change: &[
                (
                    "[flow.boundary.left]\npressure = \"1 MPa\"\n",
                    "[gravity]\n",
                ),
                (
                    "[flow.boundary.right]\npressure = \"0 Pa\"",
                    "acceleration = [0, -9.81]",
                ),
            ],
            stderr: r#"
error: [gravity] has nothing to act on
  --> scene.toml:11:1
   |
11 | [gravity]
   | ^^^^^^^^^
   |
   = help: add [flow] or [mechanics], or leave [gravity] out

error: the scene names no effect, so nothing would happen
--> scene.toml
 = help: add one of [flow], [mechanics]

2 errors in scene.toml
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn wells_that_cannot_be() {
    check(&[
        Fault {
            name: "a well outside the domain",
            change: &[(
                "[time]",
                "[wells.a]\nat = [1.5, 0.5]\nrate = \"1e-6 m^2/s\"\n[time]",
            )],
            stderr: r#"
error: `at` lies outside the domain
  --> scene.toml:16:6
   |
16 | at = [1.5, 0.5]
   |      ^^^^^^^^^^
   |
   = help: the domain is [0, 1] × [0, 1] m
"#,
            ..FAULT
        },
        Fault {
            name: "a well without a rate",
            change: &[("[time]", "[wells.a]\nat = [0.5, 0.5]\n[time]")],
            stderr: r#"
error: a well needs `rate` or `pressure`
  --> scene.toml:15:8
   |
15 | [wells.a]
   |        ^
   |
   = help: rate = "1e-4 m^3/s" injects, and below zero produces
"#,
            ..FAULT
        },
        Fault {
            name: "a hole as wide as a cell",
            arguments: &["check", "scene.toml"],
            change: &[(
                "[time]",
                "[wells.a]\nat = [0.5, 0.5]\npressure = 1\nwellbore_radius = \"10 m\"\n[time]",
            )],
            stderr: r#"
error: well "a": with a hole of 1.000e1 m and a skin of 0 nothing is left between the bottom and the points, which tell the pressure at 1.319e-1 m from the well; set a smaller wellbore_radius, a greater skin, or coarsen the cloud
  --> scene.toml:18:19
   |
18 | wellbore_radius = "10 m"
   |                   ^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "wells that overlap",
            arguments: &["check", "scene.toml"],
            change: &[(
                "[time]",
                "[wells.a]\nat = [0.5, 0.5]\nrate = 1e-6\n[wells.b]\nat = [0.6, 0.5]\nrate = -1e-6\n[time]",
            )],
            stderr: r#"
error: wells "a" and "b" overlap: they are 1.000e-1 m apart, and their radii add up to 5.383e-1 m; move them apart, refine the cloud or set smaller radii
  --> scene.toml:19:6
   |
19 | at = [0.6, 0.5]
   |      ^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a well narrower than the gaps between the points",
            change: &[(
                "[time]",
                "[wells.a]\nat = [0.5, 0.5]\nrate = 1e-6\nradius = \"1 cm\"\n[time]",
            )],
            arguments: &["check", "scene.toml"],
            stderr: r#"
error: well "a" at [0.5, 0.5]: no point within its radius of 1.000e-2 m
  --> scene.toml:16:6
   |
16 | at = [0.5, 0.5]
   |      ^^^^^^^^^^
   |
   = help: enlarge its radius, leave the radius out, or refine the cloud there
"#,
            ..FAULT
        },
    ]);
}
