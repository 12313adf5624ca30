use super::support::*;
use crate::preconditioner::Preconditioner;
use crate::test_support::*;
use crate::{CsrMatrix, Problem, Symmetry, dot};

fn count(problem: &Problem<'_>) -> usize {
    iterations(problem.pattern, &mut built(problem))
}

#[test]
fn iterations_of_flow_hardly_grow_with_the_grid() {
    let on_grid = |n: usize| {
        let cloud = square(n);
        let mut matrix = wide_stencil(&cloud, 1, 2.3, 1);
        damage(
            &mut matrix,
            |_, _| 1.0,
            |row| if row % n == 0 { 1.0 } else { 0.0 },
        );
        count(&positive_definite(&matrix, Some(&cloud), 1))
    };
    let (coarse, fine) = (on_grid(16), on_grid(64));
    assert!(fine <= 20 && fine <= coarse + 6, "{coarse} {fine}");
}

#[test]
fn iterations_of_elasticity_hardly_grow_with_the_grid() {
    let on_grid = |n: usize| {
        let cloud = square(n);
        count(&elastic(&held_body(&cloud, 3.1, |_, _| 1.0), &cloud))
    };
    let (coarse, fine) = (on_grid(12), on_grid(48));
    assert!(fine <= 25 && fine <= coarse + 10, "{coarse} {fine}");
}

#[test]
fn bands_of_soft_bonds_cost_few_iterations() {
    let cloud = square(32);
    let count = |soft| {
        count(&elastic(
            &held_body(&cloud, 3.1, band(&cloud, 32, soft)),
            &cloud,
        ))
    };
    let intact = count(1.0);
    for soft in [1e-3, 1e-6, 1e-9] {
        let damaged = count(soft);
        assert!(damaged <= intact + 10, "{soft}: {intact} {damaged}");
    }
}

#[test]
fn slender_bodies_need_their_rotations() {
    let cloud = jittered_grid(60, 6, 0.2);
    let matrix = held_body(&cloud, 3.1, |_, _| 1.0);
    let rigid = count(&elastic(&matrix, &cloud));
    let constants = count(&positive_definite(&matrix, Some(&cloud), 2));
    assert!(3 * rigid < 2 * constants, "{rigid} {constants}");
}

#[test]
fn a_solid_in_space_converges_with_its_six_modes() {
    let cloud = jittered_cube(9, 0.2);
    let problem_matrix = held_body(&cloud, 2.1, |_, _| 1.0);
    let problem = elastic(&problem_matrix, &cloud);
    let mut amg = built(&problem);
    assert!(amg.complexity() > 1.0);
    let found = iterations(problem.pattern, &mut amg);
    assert!(found <= 25, "{found}");
}

#[test]
fn a_line_of_points_is_solved() {
    let cloud = Cloud {
        dimension: 2,
        coordinates: (0..400)
            .flat_map(|i| [f64::from(i) + 0.01 * noise(i as usize), 0.0])
            .collect(),
    };
    let mut matrix = free_body(&cloud, 3.1, |_, _| 1.0);
    add_to_diagonal(&mut matrix, |row| {
        if row % 2 == 1 || row == 0 { 1.0 } else { 1e-6 }
    });
    assert!(count(&elastic(&matrix, &cloud)) <= 40);
}

#[test]
fn the_inverse_is_symmetric_and_positive() {
    let cloud = square(24);
    for soft in [1.0, 1e-6] {
        let matrix = held_body(&cloud, 3.1, band(&cloud, 24, soft));
        let mut amg = built(&elastic(&matrix, &cloud));
        let n = matrix.rows();
        let (x, y) = (
            noisy_vector(n),
            (0..n).map(|i| noise(5 * i + 1)).collect::<Vec<_>>(),
        );
        let (mut mx, mut my) = (vec![0.0; n], vec![0.0; n]);
        amg.apply(&x, &mut mx);
        amg.apply(&y, &mut my);
        let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
        assert!((dot(&x, &my) - dot(&y, &mx)).abs() <= 1e-6 * size);
        for seed in 0..20 {
            let x: Vec<f64> = (0..n).map(|i| noise(i * 31 + seed * 7919)).collect();
            amg.apply(&x, &mut mx);
            assert!(dot(&x, &mx) > 0.0);
        }
    }
}

#[test]
fn separate_parts_isolated_points_and_fixed_ones_are_solved() {
    let mut cloud = square(20);
    // The upper half moves away, and two points leave both.
    for (point, at) in cloud.coordinates.chunks_exact_mut(2).enumerate() {
        at[1] += if at[1] > 10.0 { 100.0 } else { 0.0 };
        if point % 200 == 7 {
            at[1] += 1e3 * (point + 1) as f64;
        }
    }
    let mut matrix = free_body(&cloud, 3.1, |_, _| 1.0);
    add_to_diagonal(&mut matrix, |row| if row % 40 < 2 { 1.0 } else { 1e-4 });
    fix(&mut matrix, |unknown| unknown % 97 == 3);
    assert!(count(&elastic(&matrix, &cloud)) <= 30);
}

#[test]
fn diagonal_matrices_and_single_points_are_solved() {
    for points in [1, 2, 300] {
        let size = 2 * points;
        let starts = (0..=size as u32).collect();
        let columns = (0..size as u32).collect();
        let values = (0..size).map(|i| 1.0 + i as f64).collect();
        let matrix = CsrMatrix::new((size, size), starts, columns, values);
        let problem = Problem::new(matrix.view(), Symmetry::PositiveDefinite, 2);
        assert!(count(&problem) <= 3);
    }
}

#[test]
fn tiny_and_huge_matrices_are_solved_alike() {
    let cloud = square(24);
    let matrix = held_body(&cloud, 3.1, |_, _| 1.0);
    let usual = count(&elastic(&matrix, &cloud));
    for factor in [1e-60, 1e60] {
        let scaled = matrix.map(|value| value * factor);
        let found = count(&elastic(&scaled, &cloud));
        assert!(found.abs_diff(usual) <= 1, "{factor} {usual} {found}");
    }
}

#[test]
fn cycles_have_the_same_bits_for_any_number_of_threads() {
    let cloud = square(40);
    let matrix = held_body(&cloud, 3.1, band(&cloud, 40, 1e-6));
    let bits = |threads| {
        in_pool(threads, || {
            let mut amg = built(&elastic(&matrix, &cloud));
            let mut x = vec![0.0; matrix.rows()];
            amg.apply(&noisy_vector(matrix.rows()), &mut x);
            x.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        })
    };
    assert_eq!(bits(1), bits(2));
    assert_eq!(bits(1), bits(3));
}
