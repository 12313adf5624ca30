//! Runs that cannot be done, or fail on their way: times, outputs, solvers, references.

use crate::support::{FAULT, Fault, Outcome, Place, check};

#[test]
fn times_and_outputs_that_cannot_be() {
    check(&[
        Fault {
            name: "a steady state by explicit steps",
            change: &[(
                "end = \"100 s\"",
                "mode = \"steady\"\n[scheme]\nname = \"explicit\"",
            )],
            stderr: r#"
error: a steady run has no explicit scheme
  --> scene.toml:18:8
   |
16 | mode = "steady"
   |        -------- steady here
17 | [scheme]
18 | name = "explicit"
   |        ^^^^^^^^^^
   |
   = help: use name = "implicit", or a transient run to a late `end`
"#,
            ..FAULT
        },
        Fault {
            name: "a transient run without an end",
            change: &[("end = \"100 s\"", "step = \"1 s\"")],
            stderr: r#"
error: a transient run needs `end`
  --> scene.toml:15:1
   |
15 | [time]
   | ^^^^^^
   |
   = help: write end = "1 h", or mode = "steady"
"#,
            ..FAULT
        },
        Fault {
            name: "more outputs than a disk could hold",
            change: &[("plots = false", "plots = false\nevery = \"1 ns\"")],
            stderr: r#"
error: `every` gives 1.0e11 outputs
  --> scene.toml:19:9
   |
16 | end = "100 s"
   |       ------- the run ends here
...
19 | every = "1 ns"
   |         ^^^^^^
   |
   = help: at most 100000 are written
"#,
            ..FAULT
        },
        Fault {
            name: "a profile of a billion positions",
            change: &[(
                "plots = false",
                "plots = false\nprofiles.p = { from = [0, 0], to = [1, 1], points = 1000000000 }",
            )],
            stderr: r#"
error: `points` must lie between 2 and 1e5, found 1e9
  --> scene.toml:19:53
   |
19 | profiles.p = { from = [0, 0], to = [1, 1], points = 1000000000 }
   |                                                     ^^^^^^^^^^
   |
   = help: a line has two ends, and no cloud resolves more places along it
"#,
            ..FAULT
        },
        Fault {
            name: "a probe outside the domain",
            change: &[(
                "plots = false",
                "plots = false\nprobes.p = { at = [0.5, -1] }",
            )],
            stderr: r#"
error: `at` lies outside the domain
  --> scene.toml:19:19
   |
19 | probes.p = { at = [0.5, -1] }
   |                   ^^^^^^^^^
   |
   = help: the domain is [0, 1] × [0, 1] m
"#,
            ..FAULT
        },
        Fault {
            name: "a probe whose name cannot be in a file name",
            change: &[(
                "plots = false",
                "plots = false\nprobes.\"a/b\" = { at = [0.5, 0.5] }",
            )],
            stderr: r#"
error: the name `a/b` cannot be used in a file name
  --> scene.toml:19:8
   |
19 | probes."a/b" = { at = [0.5, 0.5] }
   |        ^^^^^
   |
   = help: use letters, digits, `-` and `_`
"#,
            ..FAULT
        },
        Fault {
            name: "more steps than allowed",
            change: &[("\"100 s\"", "\"100 s\"\nstep = \"1 s\"\nmax_steps = 7")],
            code: 1,
            stderr: r#"
error: stopped after 7 steps at t = 7.000000e0 s of 1.000000e2 s; raise time.max_steps or choose larger steps
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn solvers_that_cannot_be() {
    check(&[
        Fault {
            name: "a solver that does not exist",
            change: &[("[time]", "[solver]\nname = \"fear-cg\"\n[time]")],
            stderr: r#"
error: unknown solver `fear-cg`, did you mean `faer-cg`?; valid names: auto, faer-llt, faer-ldlt, faer-cg, faer-lu, fourier, minres, gmres, fgmres, bicgstab, petsc
  --> scene.toml:16:8
   |
16 | name = "fear-cg"
   |        ^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "an option that the solver does not have",
            change: &[(
                "[time]",
                "[solver]\nname = \"faer-cg:precondtioner=jacobi\"\n[time]",
            )],
            stderr: r#"
error: solver `faer-cg` has no option `precondtioner`, did you mean `preconditioner`?; valid options: preconditioner, tolerance, max_iterations, refactor_above, threshold, smoother_degree, inner
  --> scene.toml:16:8
   |
16 | name = "faer-cg:precondtioner=jacobi"
   |        ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "an option without a value",
            change: &[(
                "[time]",
                "[solver]\nname = \"faer-cg:preconditioner\"\n[time]",
            )],
            stderr: r#"
error: `preconditioner` in the solver specification: there is no `=`; write NAME:key=value,key=value
  --> scene.toml:16:8
   |
16 | name = "faer-cg:preconditioner"
   |        ^^^^^^^^^^^^^^^^^^^^^^^^
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn an_iteration_that_is_not_given_enough_steps() {
    let place = Place::with_scene(&[("end = \"100 s\"", "mode = \"steady\"")]);
    let solver = "faer-cg:preconditioner=jacobi,max_iterations=2";
    let Outcome {
        code,
        stdout,
        stderr,
    } = place.run(&["run", "scene.toml", "--solver", solver]);
    assert_eq!((code, stdout.as_str()), (Some(4), ""));
    let start = "error: steady: linear solver: no convergence in 2 iterations: relative residual ";
    let end = ", wanted 1e-12; raise max_iterations, use preconditioner=stale, or use `faer-llt`\n";
    assert!(
        stderr.starts_with(start) && stderr.ends_with(end),
        "{stderr}"
    );
}

#[test]
fn runs_that_have_no_end() {
    check(&[
        Fault {
            name: "a sealed domain into which a well pumps for ever",
            change: &[
                ("[flow.boundary.left]\npressure = \"1 MPa\"\n", "[flow]\n"),
                (
                    "[flow.boundary.right]\npressure = \"0 Pa\"\n",
                    "[wells.a]\nat = [0.5, 0.5]\nrate = \"1e-6 m^2/s\"\n",
                ),
                ("end = \"100 s\"", "mode = \"steady\""),
            ],
            stderr: r#"
error: steady: no steady state: the part of the domain around point 0 is sealed, and 1.000e-6 m³/s net (per metre in 2-D) are brought into it; prescribe a pressure somewhere or balance the wells
"#,
            ..FAULT
        },
        Fault {
            name: "explicit steps above their limit",
            change: &[(
                "\"100 s\"",
                "\"100 s\"\nstep = \"1.05 s\"\n[scheme]\nname = \"explicit\"",
            )],
            code: 4,
            stderr: r#"
warning: Δt = 1.050000e0 s is above the stability limit of 5.993963e-1 s: the run will be unstable
error: explicit (forward-euler): explicit step unstable at t = 3.150000e0 s: the imbalance grew 1.7e0 times; Δt = 1.050000e0 s is above the stability limit of 5.993963e-1 s; use a smaller time.step, leave it out, or use --scheme implicit; the output at t = 0.000000e0 s is kept
"#,
            ..FAULT
        },
    ]);
}

#[test]
fn references_that_do_not_fit() {
    check(&[
        Fault {
            name: "a five-spot without wells",
            change: &[("[output]", "[reference]\ntype = \"five-spot\"\n[output]")],
            stderr: r#"
error: this reference needs [wells] with 2 of them, found 0
  --> scene.toml:18:8
   |
18 | type = "five-spot"
   |        ^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "two layers of one material",
            change: &[("[output]", "[reference]\ntype = \"two-layer\"\n[output]")],
            stderr: r#"
error: this reference needs [materials] with 2 of them, found 1
  --> scene.toml:18:8
   |
18 | type = "two-layer"
   |        ^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a manufactured solution between two pressures",
            change: &[("[output]", "[reference]\ntype = \"manufactured\"\n[output]")],
            stderr: r#"
error: the manufactured solution needs both sides of axis 0 sealed or both at pressure 0
  --> scene.toml:18:8
   |
18 | type = "manufactured"
   |        ^^^^^^^^^^^^^^
"#,
            ..FAULT
        },
        Fault {
            name: "a reference that does not exist",
            change: &[("[output]", "[reference]\ntype = \"five-sport\"\n[output]")],
            stderr: r#"
error: `five-sport` is not known here
  --> scene.toml:18:8
   |
18 | type = "five-sport"
   |        ^^^^^^^^^^^^
   |
   = help: did you mean `five-spot`?
"#,
            ..FAULT
        },
    ]);
}

#[cfg(not(feature = "vtkhdf"))]
#[test]
fn a_format_that_this_program_was_built_without() {
    check(&[Fault {
        name: "fields in one file",
        change: &[("plots = false", "plots = false\nformat = \"vtkhdf\"")],
        stderr: r#"
error: this program was built without the feature `vtkhdf`
  --> scene.toml:19:10
   |
19 | format = "vtkhdf"
   |          ^^^^^^^^
   |
   = help: leave `format` out, or build with --features vtkhdf, which needs libhdf5 (Debian: libhdf5-dev)
"#,
        ..FAULT
    }]);
}
