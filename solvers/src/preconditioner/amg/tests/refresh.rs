use super::support::*;
use crate::CsrMatrix;
use crate::preconditioner::Preconditioner;
use crate::test_support::*;

fn body(cloud: &Cloud, soft: f64) -> CsrMatrix {
    held_body(cloud, 3.1, band(cloud, 32, soft))
}

/// A body whose bonds at a few points in the middle are soft.
fn with_soft_points(cloud: &Cloud, count: usize, soft: f64) -> CsrMatrix {
    let first = 32 * 16 + 8;
    let inside = |point: usize| (first..first + count).contains(&point);
    held_body(
        cloud,
        3.1,
        |a, b| if inside(a) || inside(b) { soft } else { 1.0 },
    )
}

#[test]
fn new_values_keep_the_hierarchy_and_serve_as_well_as_a_new_one() {
    let cloud = square(32);
    let (before, after) = (body(&cloud, 1.0), body(&cloud, 0.2));
    let mut kept = built(&elastic(&before, &cloud));
    kept.refresh(after.view()).unwrap();
    assert_eq!(kept.work().factorisations, 1);
    let found = iterations(after.view(), &mut kept);
    let new = iterations(after.view(), &mut built(&elastic(&after, &cloud)));
    assert!(found <= new + 4, "{found} {new}");
}

#[test]
fn a_refresh_with_all_values_new_is_a_new_hierarchy() {
    let cloud = square(32);
    let (one, three) = (
        body(&cloud, 1.0),
        body(&cloud, 1.0).map(|value| 4.0 * value),
    );
    let mut kept = built(&elastic(&one, &cloud));
    kept.refresh(three.view()).unwrap();
    assert_eq!(kept.work().factorisations, 1);
    let mut new = built(&elastic(&three, &cloud));
    let n = one.rows();
    let (mut a, mut b) = (vec![0.0; n], vec![0.0; n]);
    kept.apply(&noisy_vector(n), &mut a);
    new.apply(&noisy_vector(n), &mut b);
    assert!(relative_error(&a, &b) < 1e-12);
}

#[test]
fn nothing_new_costs_nothing_and_asks_for_no_renewal() {
    let cloud = square(32);
    let matrix = body(&cloud, 1.0);
    let mut amg = built(&elastic(&matrix, &cloud));
    amg.refresh(matrix.view()).unwrap();
    assert_eq!((amg.work().factorisations, amg.patience()), (1, None));
}

#[test]
fn many_points_of_another_material_rebuild_at_once() {
    let cloud = square(32);
    let mut amg = built(&elastic(&body(&cloud, 1.0), &cloud));
    amg.refresh(body(&cloud, 1e-6).view()).unwrap();
    assert_eq!(amg.work().factorisations, 2);
    assert_eq!(amg.patience(), None);
}

#[test]
fn slow_solves_rebuild_at_the_next_refresh_only_if_the_hierarchy_is_old() {
    let cloud = square(32);
    let mut amg = built(&elastic(&body(&cloud, 1.0), &cloud));
    amg.observe(12);
    amg.observe(40);
    amg.refresh(body(&cloud, 0.5).view()).unwrap();
    assert_eq!((amg.work().factorisations, amg.patience()), (1, Some(36)));
    amg.observe(17);
    amg.refresh(body(&cloud, 0.4).view()).unwrap();
    assert_eq!(amg.work().factorisations, 1);
    amg.observe(19);
    amg.refresh(body(&cloud, 0.3).view()).unwrap();
    assert_eq!((amg.work().factorisations, amg.patience()), (2, None));
}

#[test]
fn renewing_is_a_rebuild() {
    let cloud = square(32);
    let mut amg = built(&elastic(&body(&cloud, 1.0), &cloud));
    let few = with_soft_points(&cloud, 4, 1e-9);
    amg.refresh(few.view()).unwrap();
    assert_eq!(amg.work().factorisations, 1);
    assert!(amg.patience().is_some());
    amg.renew(few.view()).unwrap();
    assert_eq!((amg.work().factorisations, amg.patience()), (2, None));
    assert!(iterations(few.view(), &mut amg) <= 25);
}

#[test]
fn work_counts_what_is_stored() {
    let cloud = square(32);
    let matrix = body(&cloud, 1.0);
    let amg = built(&elastic(&matrix, &cloud));
    let work = amg.work();
    assert!(work.nonzeros > matrix.nnz() as u64 && work.bytes > 5 * work.nonzeros);
    assert!(amg.complexity() < 1.3, "{}", amg.complexity());
}
