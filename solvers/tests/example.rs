//! What the example prints is right.
#![allow(clippy::unwrap_used)]

#[path = "../examples/poisson.rs"]
#[allow(dead_code)]
mod poisson;

#[test]
fn every_solver_of_the_example_finds_the_solution_to_second_order() {
    for spec in poisson::SPECS {
        let errors = [19, 39].map(|n| poisson::solve(spec, n).unwrap());
        let order = (errors[0] / errors[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{spec}: {errors:?}");
    }
}
