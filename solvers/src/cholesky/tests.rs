//! Tests of the Cholesky factors.

use super::*;
use crate::test_support::{grid_laplacian, jittered_grid, positive_definite, wide_stencil};

fn fill(problem: &Problem<'_>, ordering: Ordering) -> u64 {
    prediction::<f64>(&symbolic(problem, ordering).unwrap()).nonzeros
}

#[test]
fn nested_dissection_fills_at_most_a_tenth_more_than_minimum_degree() {
    for jitter in [0.0, 0.2] {
        let cloud = jittered_grid(100, 100, jitter);
        let a = wide_stencil(&cloud, 1, 2.5, 1);
        let problem = positive_definite(&a, Some(&cloud), 1);
        let dissected = fill(&problem, Ordering::NestedDissection) as f64;
        let minimum_degree = fill(&problem, Ordering::MinimumDegree) as f64;
        assert!(
            dissected <= 1.1 * minimum_degree,
            "{dissected} against {minimum_degree}"
        );
    }
}

#[test]
fn unknowns_of_a_point_fill_like_blocks_of_the_point_factor() {
    let cloud = jittered_grid(30, 30, 0.2);
    let (one, three) = (
        wide_stencil(&cloud, 1, 2.5, 1),
        wide_stencil(&cloud, 3, 2.5, 1),
    );
    let points = fill(
        &positive_definite(&one, Some(&cloud), 1),
        Ordering::NestedDissection,
    );
    let blocks = fill(
        &positive_definite(&three, Some(&cloud), 3),
        Ordering::NestedDissection,
    );
    let ratio = blocks as f64 / points as f64;
    assert!((8.0..10.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_tridiagonal_matrix_without_reordering_gain_has_no_fill() {
    let a = grid_laplacian(300, 1, 0.0);
    let size = predict(&positive_definite(&a, None, 1)).unwrap();
    assert_eq!(size.nonzeros, 2 * 300 - 1);
    assert!((size.flops - (299.0 * 4.0 + 1.0)).abs() < 0.5);
    assert_eq!(size.bytes, 12 * 599);
}

#[test]
fn a_slender_cloud_is_swept_where_that_takes_fewer_operations() {
    let flops = |problem: &Problem<'_>, ordering| {
        prediction::<f64>(&symbolic(problem, ordering).unwrap()).flops
    };
    // A strip little wider than the reach, and one much wider.
    for (columns, rows, horizon, swept) in [(150, 10, 4.6, true), (200, 80, 1.5, false)] {
        let cloud = jittered_grid(columns, rows, 0.2);
        let a = wide_stencil(&cloud, 1, horizon, 1);
        let problem = positive_definite(&a, Some(&cloud), 1);
        let sweep = flops(&problem, Ordering::Sweep);
        let dissected = flops(&problem, Ordering::NestedDissection);
        assert_eq!(sweep < 0.8 * dissected, swept, "{sweep} {dissected}");
        let chosen = flops(&problem, Ordering::Automatic);
        assert!((chosen - sweep.min(dissected)).abs() < 0.5);
    }
}
