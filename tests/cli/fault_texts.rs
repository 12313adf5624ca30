//! Scene files that cannot be read as a scene: syntax, keys, units, encodings.

use crate::support::{FAULT, Fault, check};

#[test]
fn texts_that_are_no_toml() {
    check(&[
        Fault {
            name: "a text without its closing quote",
            change: &[("\"Base\"", "\"Base")],
            stderr: r#"
error: a text is not closed
 --> scene.toml:1:14
  |
1 | title = "Base
  |              ^
  |
  = help: end it with `"`
"#,
            ..FAULT
        },
        Fault {
            name: "a quantity without quotes, and a key without a value",
            change: &[("\"1 cP\"", "1 cP"), ("end = \"100 s\"", "end =")],
            stderr: r#"
error: a text must stand in quotes
 --> scene.toml:7:13
  |
7 | viscosity = 1 cP
  |             ^^^^
  |
  = help: write "1 cP"

error: a value is missing
  --> scene.toml:16:6
   |
16 | end =
   |      ^

2 errors in scene.toml
"#,
            ..FAULT
        },
        Fault {
            name: "a key given twice",
            change: &[(
                "viscosity = \"1 cP\"",
                "viscosity = \"1 cP\"\nviscosity = \"2 cP\"",
            )],
            stderr: r#"
error: duplicate key `viscosity`
 --> scene.toml:8:1
  |
8 | viscosity = "2 cP"
  | ^^^^^^^^^
  |
  = help: keep one of them
"#,
            ..FAULT
        },
        Fault {
            name: "an empty file",
            files: &[("scene.toml", b"\n# nothing yet\n")],
            stderr: r#"
error: the scene file is empty
--> scene.toml
 = help: start from a bundled case: perifrac cases --write NAME
"#,
            ..FAULT
        },
        Fault {
            name: "a file in another encoding",
            files: &[("scene.toml", b"# first line\ntitle = 'B\xe4se'\n")],
            stderr: r#"
error: the scene file `scene.toml` is not UTF-8 text (line 2)
--> scene.toml
 = help: save the file with the encoding UTF-8
"#,
            ..FAULT
        },
        Fault {
            name: "a folder",
            files: &[("folder.toml/scene.toml", b"")],
            arguments: &["run", "folder.toml"],
            stderr: r#"
error: the scene file `folder.toml` is a folder, not a scene file
--> folder.toml
 = help: name the scene file in it, such as scene.toml
"#,
            ..FAULT
        },
        Fault {
            name: "a file that is not there",
            arguments: &["run", "sceen.toml"],
            stderr: r#"
error: cannot read the scene file `sceen.toml`: No such file or directory (os error 2)
--> sceen.toml
 = help: check the path and the permissions
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn keys_and_sections_that_do_not_exist() {
    check(&[
        Fault {
            name: "a list where a table belongs",
            change: &[("title = \"Base\"", "title = \"Base\"\naudit = [0.1, 0.2]")],
            stderr: r#"
error: expected a table, found a list
 --> scene.toml:2:9
  |
2 | audit = [0.1, 0.2]
  |         ^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt key",
            change: &[("permeability =", "permeabilty =")],
            stderr: r#"
error: unknown key `permeabilty`
 --> scene.toml:9:1
  |
9 | permeabilty = "1 mD"
  | ^^^^^^^^^^^
  |
  = help: did you mean `permeability`?
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt section",
            change: &[("[fluid]", "[fluids]")],
            stderr: r#"
error: unknown key `fluids`
 --> scene.toml:6:2
  |
6 | [fluids]
  |  ^^^^^^
  |
  = help: did you mean `fluid`?

error: [flow] needs a fluid
  --> scene.toml:11:2
   |
11 | [flow.boundary.left]
   |  ^^^^
   |
   = help: add [fluid] with viscosity = "1 cP"

2 errors in scene.toml
"#,
            ..FAULT
        },
        Fault {
            name: "a section of another program",
            change: &[("[time]", "[mesh]\nsize = 3\n[time]")],
            stderr: r#"
error: unknown key `mesh`
  --> scene.toml:15:2
   |
15 | [mesh]
   |  ^^^^
   |
   = help: expected `title`, `description`, `geometry`, `horizon`, `fluid`, `materials`, `gravity`, `initial`, `flow`, `mechanics`, `coupling`, `damage`, `fracture_flow`, `cracks`, `wells`, `start`, `time`, `scheme`, `solver`, `audit`, `output` or `reference`
"#,
            ..FAULT
        },
        Fault {
            name: "a scheme that does not exist",
            change: &[("[time]", "[scheme]\nname = \"implict\"\n[time]")],
            stderr: r#"
error: `implict` is not known here
  --> scene.toml:16:8
   |
16 | name = "implict"
   |        ^^^^^^^^^
   |
   = help: did you mean `implicit`?
"#,
            ..FAULT
        },
        Fault {
            name: "a geometry that does not exist",
            change: &[("\"lattice\"", "\"hexagons\"")],
            stderr: r#"
error: `hexagons` is not known here
 --> scene.toml:3:8
  |
3 | type = "hexagons"
  |        ^^^^^^^^^^
  |
  = help: expected `lattice`, `graded`, `blocks`, `file` or `mesh`
"#,
            ..FAULT
        },
        Fault {
            name: "a section that must be there",
            change: &[("[time]\nend = \"100 s\"\n", "")],
            stderr: r#"
error: the scene has no [time]
--> scene.toml
 = help: add [time] with end = "1 h", or mode = "steady"
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn quantities_that_are_none() {
    check(&[
        Fault {
            name: "a unit of another dimension",
            change: &[("\"1 cP\"", "\"1 mD\"")],
            stderr: r#"
error: expected a viscosity (Pa s), found an area: "1 mD"
 --> scene.toml:7:13
  |
7 | viscosity = "1 mD"
  |             ^^^^^^
  |
  = help: write it like "1 cP"
"#,
            ..FAULT
        },
        Fault {
            name: "a misspelt unit",
            change: &[("\"1 cP\"", "\"1 cp\"")],
            stderr: r#"
error: unknown unit `cp` in "1 cp"
 --> scene.toml:7:13
  |
7 | viscosity = "1 cp"
  |             ^^^^^^
  |
  = help: did you mean `cP`?
"#,
            ..FAULT
        },
        Fault {
            name: "a number that is not finite",
            change: &[("\"100 s\"", "inf")],
            stderr: r#"
error: expected a time (s), found inf, which is not finite
  --> scene.toml:16:7
   |
16 | end = inf
   |       ^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a text where a list is needed",
            change: &[("[1, 1]", "\"1 m\"")],
            stderr: r#"
error: expected a list, found the text "1 m"
 --> scene.toml:4:8
  |
4 | size = "1 m"
  |        ^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "two faults far apart",
            change: &[("\"1 mD\"", "\"-1 mD\""), ("\"100 s\"", "\"100 m\"")],
            stderr: r#"
error: `permeability` must be positive
 --> scene.toml:9:16
  |
9 | permeability = "-1 mD"
  |                ^^^^^^^

error: expected a time (s), found a length: "100 m"
  --> scene.toml:16:7
   |
16 | end = "100 m"
   |       ^^^^^^^
   |
   = help: write it like "2 h"

2 errors in scene.toml
"#,
            ..FAULT
        },
    ]);
}
