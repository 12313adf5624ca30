//! Tests of the orderings.

use proptest::prelude::*;

use super::*;
use crate::test_support::{Cloud, jittered_grid, positive_definite, wide_stencil};

fn is_permutation(order: &Permutation, unknowns: usize) -> bool {
    order.forward.len() == unknowns
        && order.inverse.len() == unknowns
        && (0..unknowns).all(|old| order.forward[order.inverse[old] as usize] == old as u32)
}

fn dissect(cloud: &Cloud, per_point: usize, horizon: f64) -> Permutation {
    let a = wide_stencil(cloud, per_point, horizon, 5);
    nested_dissection(&positive_definite(&a, Some(cloud), per_point)).unwrap()
}

/// Clouds on a coarse lattice, so that many points coincide or lie on a line.
fn clouds() -> impl Strategy<Value = Cloud> {
    (1_usize..=3).prop_flat_map(|dimension| {
        let points = proptest::collection::vec(-3_i8..=3, dimension * 150..dimension * 300);
        points.prop_map(move |mut values| {
            values.truncate(values.len() / dimension * dimension);
            let coordinates = values.into_iter().map(f64::from).collect();
            Cloud {
                dimension,
                coordinates,
            }
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn random_clouds_with_coincident_points_give_permutations(
        cloud in clouds(), horizon in 0.0_f64..3.0, per_point in 1_usize..=3,
    ) {
        let order = dissect(&cloud, per_point, horizon);
        prop_assert!(is_permutation(&order, cloud.points() * per_point));
    }
}

#[test]
fn lines_and_single_places_are_ordered() {
    let line = Cloud {
        dimension: 2,
        coordinates: (0..400).map(|i| (i % 2) as f64).collect(),
    };
    assert!(is_permutation(&dissect(&line, 1, 0.5), 200));
    let heap = Cloud {
        dimension: 3,
        coordinates: vec![0.0; 600],
    };
    assert!(is_permutation(&dissect(&heap, 2, 0.5), 400));
    let empty = Cloud {
        dimension: 2,
        coordinates: Vec::new(),
    };
    assert!(is_permutation(&dissect(&empty, 1, 0.5), 0));
}

#[test]
fn unknowns_of_a_point_stay_together_in_the_order_of_points() {
    let cloud = jittered_grid(20, 15, 0.3);
    let (points, unknowns) = (dissect(&cloud, 1, 2.3), dissect(&cloud, 3, 2.3));
    for (new, block) in unknowns.forward.chunks_exact(3).enumerate() {
        let first = 3 * points.forward[new];
        assert_eq!(block, [first, first + 1, first + 2]);
    }
}

#[test]
fn the_last_points_separate_the_two_halves() {
    let cloud = jittered_grid(40, 10, 0.0);
    let a = wide_stencil(&cloud, 1, 1.5, 5);
    let order = dissect(&cloud, 1, 1.5);
    let (rest, separator) = order.forward.split_at(390);
    let column = |point: &u32| point % 40;
    assert!(
        separator
            .iter()
            .all(|point| column(point) == column(&separator[0]))
    );
    let cut = column(&separator[0]);
    for (i, j) in rest.iter().flat_map(|i| rest.iter().map(move |j| (i, j))) {
        let apart = (column(i) < cut) != (column(j) < cut);
        assert!(!apart || a.get(*i as usize, *j as usize).is_none());
    }
}

#[test]
fn there_is_no_dissection_without_coordinates() {
    let a = wide_stencil(&jittered_grid(5, 5, 0.0), 1, 1.5, 5);
    assert!(nested_dissection(&positive_definite(&a, None, 1)).is_none());
}

#[test]
fn a_sweep_follows_the_longest_axis_from_both_ends_with_ties_by_the_others() {
    let (length, height) = (30, 4);
    let coordinates: Vec<f64> = (0..length * height)
        .flat_map(|point| [(point / length) as f64, (point % length) as f64])
        .collect();
    let coordinates = Coordinates {
        dimension: 2,
        values: &coordinates,
    };
    assert!(is_slender(&coordinates));
    let order = sweep(&coordinates, length * height).of_points();
    let middle = length * height / 2;
    for (new, point) in order.forward.iter().enumerate() {
        let along = if new < middle {
            new
        } else {
            3 * middle - 1 - new
        };
        assert_eq!(*point as usize, along % height * length + along / height);
    }
}

#[test]
fn quasi_definite_groups_list_the_last_unknowns_after_their_neighbours() {
    let cloud = jittered_grid(40, 6, 0.2);
    let a = wide_stencil(&cloud, 3, 2.3, 5);
    let problem = Problem {
        symmetry: Symmetry::QuasiDefinite,
        ..positive_definite(&a, Some(&cloud), 3)
    };
    let order = nested_dissection(&problem).unwrap();
    assert!(is_permutation(&order, 3 * cloud.points()));
    // The first set not cut has at most LEAF_POINTS points and lists its unknowns by kind.
    let kinds: Vec<u32> = order.forward.iter().map(|unknown| unknown % 3).collect();
    let size = kinds.iter().take_while(|kind| **kind == 0).count();
    assert!(size > 1 && size <= LEAF_POINTS);
    let blocks = kinds.chunks_exact(size).take(3).enumerate();
    for (kind, block) in blocks {
        assert!(block.iter().all(|found| *found == kind as u32));
    }
}
