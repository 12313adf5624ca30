//! Domains, points and horizons that do not fit together.

use crate::support::{FAULT, Fault, check};

#[test]
fn lattices_that_cannot_be() {
    check(&[
        Fault {
            name: "a spacing that does not divide the domain",
            change: &[("points = [8, 8]", "spacing = 0.3")],
            stderr: r#"
error: `spacing` must divide `size`, found 3.333 cells
 --> scene.toml:5:11
  |
4 | size = [1, 1]
  |         - this edge
5 | spacing = 0.3
  |           ^^^
"#,
            ..FAULT
        },
        Fault {
            name: "points that are shifted into each other",
            change: &[("points = [8, 8]", "points = [8, 8]\njitter = 0.6")],
            stderr: r#"
error: `jitter` must lie between 0 and 0.4, found 0.6
 --> scene.toml:6:10
  |
6 | jitter = 0.6
  |          ^^^
  |
  = help: beyond half a cell points leave their own cells and may meet
"#,
            ..FAULT
        },
        Fault {
            name: "points and spacing",
            change: &[("points = [8, 8]", "points = [8, 8]\nspacing = 0.125")],
            stderr: r#"
error: `points` excludes `spacing`
 --> scene.toml:6:11
  |
5 | points = [8, 8]
  |          ------ given here
6 | spacing = 0.125
  |           ^^^^^
  |
  = help: keep one of them
"#,
            ..FAULT
        },
        Fault {
            name: "three counts for a plane",
            change: &[("points = [8, 8]", "points = [8, 8, 8]")],
            stderr: r#"
error: `points` needs 2 components, found 3
 --> scene.toml:5:10
  |
5 | points = [8, 8, 8]
  |          ^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "more points than can be numbered",
            change: &[("points = [8, 8]", "points = [100000, 100000]")],
            stderr: r#"
error: 1.000e10 points are more than 32-bit indices can number; use a coarser cloud
 --> scene.toml:2:1
  |
2 | [geometry]
  | ^^^^^^^^^^
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn horizons_that_cannot_be() {
    check(&[
        Fault {
            name: "a horizon shorter than the spacing",
            arguments: &["check", "scene.toml"],
            change: &[("[fluid]", "[horizon]\nradius = \"0.1 m\"\n[fluid]")],
            stderr: r#"
error: point 0 at [0.0625, 0.0625]: its 0 neighbours within 1.000e-1 m do not span the space (singular shape tensor); enlarge the horizon
 --> scene.toml:7:10
  |
7 | radius = "0.1 m"
  |          ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a horizon that spans a thin domain many times",
            change: &[
                (
                    "size = [1, 1]\npoints = [8, 8]",
                    "size = [1, 0.001]\npoints = [8, 1]",
                ),
                ("[fluid]", "[horizon]\nradius = \"0.3 m\"\n[fluid]"),
            ],
            stderr: r#"
error: the horizon (3.000e-1 m) is more than 7 times the thickness of the domain (1.000e-3 m along axis 1); make the domain thicker or the horizon smaller
 --> scene.toml:7:10
  |
7 | radius = "0.3 m"
  |          ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "two horizons",
            change: &[(
                "[fluid]",
                "[horizon]\nradius = \"0.3 m\"\nratio = 2.5\n[fluid]",
            )],
            stderr: r#"
error: `radius` excludes `ratio`
 --> scene.toml:8:9
  |
7 | radius = "0.3 m"
  |          ------- given here
8 | ratio = 2.5
  |         ^^^
  |
  = help: keep one of them
"#,
            ..FAULT
        },
        Fault {
            name: "fewer points than neighbours",
            change: &[
                ("\"lattice\"", "\"file\""),
                ("size = [1, 1]\npoints = [8, 8]", "path = \"points.csv\""),
                (
                    "[flow.boundary.left]",
                    "[[flow.regions]]\nregion = { type = \"disc\", centre = [0, 0], radius = 0.1 }",
                ),
                ("[flow.boundary.right]\npressure = \"0 Pa\"\n", ""),
            ],
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,0,1\n0,1,1\n1,1,1\n")],
            stderr: r#"
error: the cloud has 4 points, too few for 15 neighbours each
 --> scene.toml:2:1
  |
2 | [geometry]
  | ^^^^^^^^^^
  |
  = help: add points, or set horizon.neighbours to fewer, or horizon.radius to a length
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn a_crack_through_points() {
    check(&[Fault {
        name: "a crack along a row of points",
        files: &[(
            "scene.toml",
            br#"title = "cracked"
[geometry]
type = "lattice"
size = [1, 1]
points = [9, 9]
[materials.rock]
youngs_modulus = 1
poissons_ratio = 0.2
[mechanics.boundary.left]
clamped = true
[cracks.main]
points = [[0.2, 0.5], [0.6, 0.5]]
[time]
mode = "steady"
"#,
        )],
        stderr: r#"
error: crack "main" goes through point 38 at [0.2777777777777778, 0.5]; move it off the points, such as by half the spacing, or change the number of points
  --> scene.toml:12:10
   |
12 | points = [[0.2, 0.5], [0.6, 0.5]]
   |          ^^^^^^^^^^^^^^^^^^^^^^^^
"#,
        ..FAULT
    }]);
}
