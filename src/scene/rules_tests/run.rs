//! Rules of time, scheme, solver and output.

use super::{SOUND, check, faults};

#[test]
fn time_rules() {
    check(&[
        (
            "end = \"100 s\"\n",
            "",
            "a transient run needs `end`",
            "[time]",
        ),
        (
            "tolerance = 1e-6",
            "tolerance = 1",
            "`tolerance` must lie between 1e-12 and 0.1, found 1",
            "1",
        ),
        (
            "tolerance = 1e-6",
            "safety = 0",
            "`safety` must lie between 0.001 and 1, found 0",
            "0",
        ),
        (
            "tolerance = 1e-6",
            "safety = 1.1",
            "`safety` must lie between 0.001 and 1, found 1.1",
            "1.1",
        ),
        (
            "tolerance = 1e-6",
            "max_steps = 0",
            "`max_steps` must lie between 1 and 1e12, found 0",
            "0",
        ),
        (
            "first_step = 0.1\nmax_step = 10",
            "step = 0",
            "`step` must be positive",
            "0",
        ),
        (
            "max_step = 10",
            "step = 10",
            "`step` excludes `first_step`",
            "0.1",
        ),
        (
            "first_step = 0.1",
            "step = 1",
            "`step` excludes `max_step`",
            "10",
        ),
    ]);
}

#[test]
fn steady_rules() {
    let found = faults(SOUND, &["time.mode=steady"]);
    let expected = "a steady run needs loads that are constant in time";
    assert_eq!(
        found,
        [(expected.to_owned(), "[0, \"1 MPa\", 0]".to_owned())]
    );
    let constant = SOUND.replace(
        "{ time = [0, \"10 s\", 20], value = [0, \"1 MPa\", 0] }",
        "1",
    );
    let free = constant.replace("end = \"100 s\"", "mode = \"steady\"");
    let free = free.replace("storage = \"1e-10 1/Pa\"", "");
    assert_eq!(faults(&free, &[]), [], "neither end nor storage is needed");
}

#[test]
fn solver_and_output_rules() {
    check(&[
        (
            "name = \"auto\"",
            "name = \" \"",
            "`name` of the solver is empty",
            "\" \"",
        ),
        (
            "times = [0, \"50 s\", 100]",
            "times = [-1]",
            "`times` must not be negative",
            "-1",
        ),
        (
            "times = [0, \"50 s\", 100]",
            "every = 0",
            "`every` must be positive",
            "0",
        ),
        (
            "probes.centre",
            "every = 1\nprobes.centre",
            "`times` excludes `every`",
            "1",
        ),
        (
            "{ at = [1, 0.5] }",
            "{ at = [3, 0.5] }",
            "`at` lies outside the domain",
            "[3, 0.5]",
        ),
        (
            "to = [2, 0.5]",
            "to = [0, 0.5]",
            "`from` and `to` are the same position",
            "[0, 0.5]",
        ),
        (
            "to = [2, 0.5]",
            "to = [2, 9]",
            "`to` lies outside the domain",
            "[2, 9]",
        ),
        (
            "to = [2, 0.5]",
            "to = [2, 1], points = 1",
            "`points` must lie between 2 and 1e5, found 1",
            "1",
        ),
        (
            "probes.centre",
            "probes.\"../x\"",
            "the name `../x` cannot be used in a file name",
            "\"../x\"",
        ),
    ]);
}
