//! Tests of the Cholesky factors.

use super::*;
use crate::test_support::{
    add_to_diagonal, biot, grid_laplacian, in_pool, jittered_grid, positive_definite, wide_stencil,
};

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

/// Values of the factor by faer's own factorisation, which looks to the left.
fn plain<T: RealField + Copy>(
    factor: &CholeskyFactor<T>,
    matrix: CsrView<'_>,
    entries: &[T],
) -> Vec<T> {
    let symbolic = &factor.symbolic;
    let (side, par) = (Side::Lower, Par::Seq);
    let view = SparseColMatRef::new(pattern_of(&matrix), entries);
    let mut values = vec![T::zero(); symbolic.len_val()];
    let (llt, ldlt) = (
        symbolic.factorize_numeric_llt_scratch::<T>(par, Default::default()),
        symbolic.factorize_numeric_ldlt_scratch::<T>(par, Default::default()),
    );
    let mut memory = MemBuffer::new(llt.or(ldlt));
    let (memory, regular) = (MemStack::new(&mut memory), Default::default());
    let done = match factor.kind {
        Kind::Llt => symbolic
            .factorize_numeric_llt(
                &mut values,
                view,
                side,
                regular,
                par,
                memory,
                Default::default(),
            )
            .is_ok(),
        Kind::Ldlt => symbolic
            .factorize_numeric_ldlt(
                &mut values,
                view,
                side,
                Default::default(),
                par,
                memory,
                Default::default(),
            )
            .is_ok(),
    };
    assert!(done);
    values
}

/// Largest difference of the values of a factor to others over the largest of its own.
fn difference<T: RealField + Copy + Into<f64>>(factor: &CholeskyFactor<T>, other: &[T]) -> f64 {
    let own = factor.values.col_as_slice(0);
    let pairs = own
        .iter()
        .zip(other)
        .map(|(a, b)| ((*a).into(), (*b).into()));
    let (mut off, mut most) = (0.0, 0.0);
    for (a, b) in pairs {
        off = f64::max(off, f64::abs(a - b));
        most = f64::max(most, f64::abs(a));
    }
    off / most
}

#[test]
fn fronts_give_the_factor_that_looking_to_the_left_gives() {
    let cloud = jittered_grid(25, 17, 0.2);
    let stiff = wide_stencil(&cloud, 2, 3.2, 1);
    let mixed = biot(&cloud, 1.0, 1e-2);
    for (matrix, unknowns, kind) in [
        (&stiff, 2, Kind::Llt),
        (&stiff, 2, Kind::Ldlt),
        (&mixed, mixed.rows() / cloud.points(), Kind::Ldlt),
    ] {
        let problem = positive_definite(matrix, Some(&cloud), unknowns);
        for ordering in [
            Ordering::NestedDissection,
            Ordering::Sweep,
            Ordering::MinimumDegree,
        ] {
            let mut fronts = CholeskyFactor::<f64>::analyse(&problem, kind, ordering).unwrap();
            assert!(!fronts.tree.roots.is_empty(), "{ordering:?}");
            fronts.factorise(matrix.view()).unwrap();
            let columns = plain(&fronts, matrix.view(), matrix.data());
            let found = difference(&fronts, &columns);
            assert!(found < 1e-12, "{kind:?} {ordering:?}: {found}");
            let mut single = CholeskyFactor::<f32>::analyse(&problem, kind, ordering).unwrap();
            let entries: Vec<f32> = matrix.data().iter().map(|value| *value as f32).collect();
            single.factorise_values(matrix.view(), &entries).unwrap();
            let columns = plain(&single, matrix.view(), &entries);
            let found = difference(&single, &columns);
            assert!(found < 1e-4, "{kind:?} {ordering:?}: {found}");
        }
    }
}

#[test]
fn bits_of_a_factor_and_the_pivot_that_fails_are_the_same_on_any_number_of_threads() {
    // The largest fronts are shared by all threads.
    let cloud = jittered_grid(30, 30, 0.2);
    let sound = wide_stencil(&cloud, 3, 4.6, 1);
    // Several pivots fail, in branches that do not depend on each other.
    let mut broken = sound.clone();
    add_to_diagonal(&mut broken, |row| if row % 301 == 5 { -1e6 } else { 0.0 });
    let problem = positive_definite(&sound, Some(&cloud), 3);
    let outcome = |threads: usize| {
        in_pool(threads, || {
            let analysed = CholeskyFactor::<f64>::analyse(&problem, Kind::Llt, Ordering::Automatic);
            let mut factor = analysed.unwrap();
            factor.factorise(sound.view()).unwrap();
            let values = factor.values.col_as_slice(0).iter();
            let bits: Vec<u64> = values.map(|value| value.to_bits()).collect();
            (bits, format!("{:?}", factor.factorise(broken.view())))
        })
    };
    let (bits, failure) = outcome(1);
    assert!(failure.contains("NotPositiveDefinite"), "{failure}");
    for threads in [2, 3, 5] {
        let (own, failed) = outcome(threads);
        assert!(own == bits, "{threads} threads");
        assert_eq!(failed, failure);
    }
}

#[test]
fn subtrees_lie_in_one_piece_behind_their_branches() {
    let cloud = jittered_grid(30, 20, 0.2);
    let a = wide_stencil(&cloud, 2, 2.5, 1);
    let problem = positive_definite(&a, Some(&cloud), 2);
    let factor = CholeskyFactor::<f64>::analyse(&problem, Kind::Llt, Ordering::Automatic).unwrap();
    let tree = &factor.tree;
    let below = |node: u32| {
        let branches = tree.children(node).iter();
        branches
            .map(|child| tree.subtree(*child).len())
            .sum::<usize>()
    };
    let mut seen = 0;
    for root in &tree.roots {
        for node in tree.subtree(*root) {
            let own = tree.subtree(*node);
            assert_eq!((own.last(), own.len()), (Some(node), below(*node) + 1));
            seen += 1;
        }
    }
    let SymbolicCholeskyRaw::Supernodal(symbolic) = factor.symbolic.raw() else {
        unreachable!("it fills");
    };
    assert_eq!(seen, symbolic.n_supernodes());
    assert!(tree.roots.iter().any(|root| {
        let mut node = *root;
        while let [only] = tree.heavy(tree.children(node))[..] {
            node = only;
        }
        tree.heavy(tree.children(node)).len() > 1
    }));
}

/// Grids that do not touch: a root each, too light for a thread of their own.
#[test]
fn matrices_that_fall_apart_have_a_root_for_every_part() {
    let cloud = jittered_grid(8, 8, 0.2);
    let one = wide_stencil(&cloud, 3, 4.6, 1);
    let (size, copies) = (one.rows(), 260);
    let mut triplets = sprs::TriMatI::<f64, u32>::new((copies * size, copies * size));
    for copy in 0..copies {
        for (value, (row, column)) in one.iter() {
            let place = |index: u32| copy * size + index as usize;
            triplets.add_triplet(place(row), place(column), *value);
        }
    }
    let matrix: crate::CsrMatrix = triplets.to_csr();
    let problem = positive_definite(&matrix, None, 3);
    let analyse = || CholeskyFactor::<f64>::analyse(&problem, Kind::Llt, Ordering::Automatic);
    let mut factor = analyse().unwrap();
    assert_eq!(factor.tree.roots.len(), copies);
    let rhs = crate::test_support::noisy_vector(copies * size);
    factor.factorise(matrix.view()).unwrap();
    let mut x = rhs.clone();
    factor.solve_in_place(&mut x);
    let mut left = vec![0.0; x.len()];
    crate::multiply(matrix.view(), &x, &mut left);
    assert!(crate::test_support::relative_error(&left, &rhs) < 1e-12);
}

#[test]
fn a_sweep_from_both_ends_takes_as_many_operations_as_one_from_one_end() {
    let cloud = jittered_grid(96, 24, 0.2);
    let a = wide_stencil(&cloud, 1, 4.6, 1);
    let problem = positive_definite(&a, Some(&cloud), 1);
    let both = permutation(&problem, Ordering::Sweep).unwrap().unwrap();
    let (mut forward, middle) = (both.forward.clone(), both.forward.len() / 2);
    forward[middle..].reverse();
    let mut inverse = vec![0; forward.len()];
    for (new, old) in forward.iter().enumerate() {
        inverse[*old as usize] = new as u32;
    }
    let flops = |order: &Permutation| {
        let symbolic = symbolic_of(pattern_of(&problem.pattern), Some(order));
        prediction::<f64>(&symbolic.unwrap()).flops
    };
    let ratio = flops(&both) / flops(&Permutation { forward, inverse });
    eprintln!("{ratio}");
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
}
