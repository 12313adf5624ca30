//! Files beside the scene that are absent, damaged or do not fit.

use crate::support::{FAULT, Fault, check};

/// Turns the base scene into one whose points come from a file, pressed on at one of them.
const POINTS: [(&str, &str); 4] = [
    ("\"lattice\"", "\"file\""),
    ("size = [1, 1]\npoints = [8, 8]", "path = \"points.csv\""),
    (
        "[flow.boundary.left]\n",
        "[[flow.regions]]\nregion = { type = \"disc\", centre = [0, 0], radius = 0.1 }\n",
    ),
    ("[flow.boundary.right]\npressure = \"0 Pa\"\n", ""),
];

/// Neighbours enough for a cloud of three points.
const FEW: (&str, &str) = ("[fluid]", "[horizon]\nradius = 1.5\n[fluid]");

/// The same between sides.
const POINTS_IN_BOUNDS: [(&str, &str); 2] = [
    ("\"lattice\"", "\"file\""),
    (
        "size = [1, 1]\npoints = [8, 8]",
        "path = \"points.csv\"\nbounds = { min = [0, 0], max = [1, 1] }",
    ),
];

#[test]
fn points_files_that_cannot_be_used() {
    check(&[
        Fault {
            name: "a points file that is not there",
            change: &POINTS,
            stderr: r#"
error: points.csv: file not found; correct the path, which is relative to the scene file
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a gap in a coordinate",
            change: &POINTS,
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,NaN,1\n0,1,1\n")],
            stderr: r#"
error: points.csv, line 3: y is NaN, not a number; fill the gap in the data (1 of 3 values are bad)
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a line that is too short",
            change: &POINTS,
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,0\n0,1,1\n")],
            stderr: r#"
error: points.csv, line 3: 2 values, but the header has 3 columns; complete the line
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a file without volumes",
            change: &POINTS,
            files: &[("points.csv", b"x,y,volum\n0,0,1\n")],
            stderr: r#"
error: points.csv: no column `volume`; the file has `x`, `y`, `volum`; did you mean `volum` for `volume`?
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a volume of zero",
            change: &POINTS,
            files: &[("points.csv", b"x,y,volume\n0,0,0\n")],
            stderr: r#"
error: points.csv, line 2: volume is 0.0, not positive; correct the value (1 of 1 values are bad)
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "two points at one position",
            change: &POINTS,
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,0,1\n0,1,1\n1,0,1\n")],
            stderr: r#"
error: points.csv: points 1 and 3 are both at [1.0, 0.0]; remove one
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a material that the scene does not know",
            change: &[POINTS[0], POINTS[1], POINTS[2], POINTS[3], FEW],
            files: &[(
                "points.csv",
                b"x,y,volume,material\n0,0,1,rock\n1,0,1,clay\n0,1,1,rock\n",
            )],
            stderr: r#"
error: the points file names the material "clay", which the scene does not define
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "materials that the file does not tell apart",
            change: &[
                POINTS[0],
                POINTS[1],
                POINTS[2],
                POINTS[3],
                FEW,
                (
                    "[fluid]",
                    "[materials.clay]\npermeability = 1\nstorage = 1\n[fluid]",
                ),
            ],
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,0,1\n0,1,1\n")],
            stderr: r#"
error: neither "clay" nor "rock" has a region, and the file tells no materials; add a column `material` to points, name a group of a mesh like each material, or give one of them a region
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a point outside the bounds",
            change: &POINTS_IN_BOUNDS,
            files: &[("points.csv", b"x,y,volume\n0.25,0.5,0.5\n1.75,0.5,0.5\n")],
            stderr: r#"
error: points.csv: point 1 at [1.75, 0.5] lies on or outside geometry.bounds; points are cell centres, half a cell inside the boundary
 --> scene.toml:4:8
  |
4 | path = "points.csv"
  |        ^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "conditions on sides that a cloud without bounds does not have",
            change: &[POINTS[0], POINTS[1]],
            files: &[("points.csv", b"x,y,volume\n0,0,1\n1,0,1\n0,1,1\n")],
            stderr: r#"
error: a cloud from a file has sides only with geometry.bounds; give the bounds, or prescribe pressures on flow.regions
  --> scene.toml:10:1
   |
10 | [flow.boundary.left]
   | ^^^^^^^^^^^^^^^^^^^^

error: a cloud from a file has sides only with geometry.bounds; give the bounds, or prescribe pressures on flow.regions
  --> scene.toml:12:1
   |
12 | [flow.boundary.right]
   | ^^^^^^^^^^^^^^^^^^^^^

2 errors in scene.toml
"#,
            ..FAULT
        },
        Fault {
            name: "points in a format that is not read",
            change: &[
                POINTS[0],
                ("size = [1, 1]\npoints = [8, 8]", "path = \"points.xlsx\""),
            ],
            stderr: r#"
error: `path` must be a file ending in `csv` or `vtu`
 --> scene.toml:4:8
  |
4 | path = "points.xlsx"
  |        ^^^^^^^^^^^^^
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn permeability_files_that_cannot_be_used() {
    check(&[
        Fault {
            name: "an array of another length",
            change: &[("\"1 mD\"", "{ file = \"k.npy\" }")],
            files: &[(
                "k.npy",
                b"\x93NUMPY\x01\x00\x38\x00{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}\
                  \n\x00\x00\x00\x00\x00\x00\xf0\x3f\x00\x00\x00\x00\x00\x00\xf0\x3f",
            )],
            stderr: r#"
error: k.npy: 2 values for 64 points; the file needs one value per point, in the order of the cloud (x fastest on a lattice)
 --> scene.toml:9:25
  |
9 | permeability = { file = "k.npy" }
  |                         ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "an array of cells of another number",
            change: &[("\"1 mD\"", "{ file = \"k.csv\", cells = [2, 2] }")],
            files: &[("k.csv", b"permeability_m2\n1e-15\n1e-15\n1e-15\n")],
            stderr: r#"
error: k.csv: 3 values, but `cells` says 2 × 2 = 4; correct `cells`, or leave it out for one value per point
 --> scene.toml:9:25
  |
9 | permeability = { file = "k.csv", cells = [2, 2] }
  |                         ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "cells along one axis",
            change: &[(
                "\"1 mD\"",
                "{ file = \"bundled:spe10-1.csv\", cells = [2000] }",
            )],
            stderr: r#"
error: `cells` must be 2 positive numbers, one for each axis of the domain
 --> scene.toml:9:56
  |
9 | permeability = { file = "bundled:spe10-1.csv", cells = [2000] }
  |                                                        ^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a file that does not come with the program",
            change: &[("\"1 mD\"", "{ file = \"bundled:spe11.csv\" }")],
            stderr: r#"
error: no file "spe11.csv" comes with the program; there is spe10-1.csv
 --> scene.toml:9:25
  |
9 | permeability = { file = "bundled:spe11.csv" }
  |                         ^^^^^^^^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "an array that is cut off",
            change: &[("\"1 mD\"", "{ file = \"k.npy\" }")],
            files: &[(
                "k.npy",
                b"\x93NUMPY\x01\x00\x38\x00{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}\
                  \n\x00\x00\x00\x00\x00\x00\xf0\x3f",
            )],
            stderr: r#"
error: k.npy: the data end before the array is complete; the file is damaged or incomplete: write or copy it again
 --> scene.toml:9:25
  |
9 | permeability = { file = "k.npy" }
  |                         ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a gap in the permeability",
            change: &[("\"1 mD\"", "{ file = \"k.csv\" }")],
            files: &[("k.csv", b"permeability_m2\n1e-15\nnan\n1e-15\n")],
            stderr: r#"
error: k.csv, line 3: permeability is NaN, not a number; fill the gap in the data (1 of 3 values are bad)
 --> scene.toml:9:25
  |
9 | permeability = { file = "k.csv" }
  |                         ^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a column that is not there",
            change: &[("\"1 mD\"", "{ file = \"k.csv\", column = \"kz\" }")],
            files: &[("k.csv", b"kx,ky\n1e-15,1e-15\n")],
            stderr: r#"
error: k.csv: no column `kz`; the file has `kx`, `ky`; did you mean `kx` for `kz`?
 --> scene.toml:9:25
  |
9 | permeability = { file = "k.csv", column = "kz" }
  |                         ^^^^^^^
"#,
            ..FAULT
        },
    ]);
}
