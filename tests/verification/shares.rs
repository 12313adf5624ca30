//! Several processes, each with its own share of bonds and matrix rows, make the operators of one.
//!
//! Threads stand in for processes: what is exchanged is the same.

use std::sync::Arc;

use perifrac::model::{Fields, Model};
use perifrac::report::Timers;
use perifrac::schemes::BlockMatrix;
use perifrac_solvers::{Communicator, CsrMatrix, CsrView, thread_team};

use crate::support::plan;

/// Numbers without structure, the same on every process.
fn rough(length: usize) -> Vec<f64> {
    (0..length)
        .map(|i| (0.7 * i as f64).sin() + 0.1 * (2.3 * i as f64).cos())
        .collect()
}

/// All that a model says of rough fields, each to be the same on all processes.
fn answers<const D: usize>(model: &Model<D>) -> Vec<(&'static str, Vec<f64>)> {
    let points = model.cloud.len();
    let pressure = rough(points);
    let mut all = Vec::new();
    if let Some(flow) = &model.flow {
        let mut imbalance = vec![0.0; points];
        flow.imbalance(0.3, &pressure, &mut imbalance);
        all.push(("imbalance", imbalance));
        all.push(("leak", flow.leak()));
        all.push(("outflow", flow.outflow(&pressure, 0.3)));
        let mut held = vec![0.0; points];
        flow.subtract_stabilisation(&pressure, &mut held);
        all.push(("stabilisation", held));
    }
    if let Some(solid) = &model.solid {
        let displacement = rough(points * D);
        let walls = rough(solid.walls.len());
        let at = Fields {
            pressure: &pressure,
            displacement: &displacement,
            walls: &walls,
            ..Fields::default()
        };
        all.push(("forces", model.unbalanced(0.3, &at).0));
        all.push(("content", model.content(&displacement, &walls)));
        all.push((
            "walls",
            solid.wall_residual(0.3, &displacement, &walls, &pressure),
        ));
        all.push(("wall stiffness", solid.wall_stiffness.as_slice().to_vec()));
    }
    all
}

fn assert_same_answers<const D: usize>(case: &str, overrides: &[&str]) {
    let plan = plan(case, overrides);
    let whole = Model::<D>::build(&plan, &mut Timers::default()).unwrap();
    let expected = answers(&whole);
    let (expected, whole, plan) = (&expected, &whole, &plan);
    for size in [2, 3, 5] {
        std::thread::scope(|scope| {
            for member in thread_team(size) {
                scope.spawn(move || {
                    let model = share::<D>(plan, &member);
                    for ((what, found), (_, expected)) in answers(&model).iter().zip(expected) {
                        let scale = expected.iter().fold(1e-300, |m: f64, v| m.max(v.abs()));
                        for (i, (f, e)) in found.iter().zip(expected).enumerate() {
                            let off = (f - e).abs() / scale;
                            assert!(off < 1e-12, "{case}, {size}: {what}[{i}] is {f}, not {e}");
                        }
                    }
                    assert_same_rows(whole, &model);
                });
            }
        });
    }
}

fn share<const D: usize>(plan: &perifrac::plan::Plan, member: &Arc<dyn Communicator>) -> Model<D> {
    Model::build_with(plan, Some(member), &mut Timers::default()).unwrap()
}

/// Stored rows are those of the whole matrices, and they are the process's own.
fn assert_same_rows<const D: usize>(whole: &Model<D>, share: &Model<D>) {
    if let (Some(whole), Some(flow)) = (&whole.flow, &share.flow) {
        compare_rows(whole.matrix(), flow.matrix(), 1, share);
    }
    if let (Some(whole), Some(solid)) = (&whole.solid, &share.solid) {
        compare_rows(whole.matrix(), solid.matrix(), D, share);
    }
    if share.coupling.is_some() {
        let filled = |model: &Model<D>| -> CsrMatrix {
            let mut block = BlockMatrix::new(model).unwrap();
            block.fill(model.flow.as_ref().unwrap(), 2.0);
            block.matrix
        };
        compare_rows(filled(whole).view(), filled(share).view(), D + 1, share);
    }
}

fn compare_rows<const D: usize>(
    whole: CsrView<'_>,
    found: CsrView<'_>,
    per_point: usize,
    share: &Model<D>,
) {
    let largest = whole.data().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for row in 0..whole.rows() {
        let own = found.outer_view(row).unwrap();
        if !share.subdomain().owns(row / per_point) {
            assert_eq!(own.nnz(), 0, "row {row} is another process's");
            continue;
        }
        let expected = whole.outer_view(row).unwrap();
        assert_eq!(own.indices(), expected.indices(), "row {row}");
        for (found, expected) in own.data().iter().zip(expected.data()) {
            assert!((found - expected).abs() <= 1e-13 * largest, "row {row}");
        }
    }
}

#[test]
fn flow_with_wells_mirrored_at_sealed_sides() {
    assert_same_answers::<2>("five-spot", &["geometry.points=[24, 17]"]);
    assert_same_answers::<2>(
        "five-spot",
        &["geometry.points=[24, 17]", "flow.hourglass=0.5"],
    );
}

#[test]
fn flow_in_bond_form_between_prescribed_sides_with_a_contrast() {
    assert_same_answers::<2>("two-layer", &["materials.left.permeability=1e8"]);
}

#[test]
fn flow_in_space_with_gravity() {
    assert_same_answers::<3>("reservoir-3d", &["geometry.points=[12, 10, 5]"]);
}

#[test]
fn a_column_with_traction_and_clamped_end() {
    assert_same_answers::<2>("terzaghi", &["geometry.spacing=0.2"]);
}

#[test]
fn a_graded_column_whose_families_are_seen_from_afar() {
    let plain = ["mechanics.gradient=plain", "flow.gradient=plain"];
    assert_same_answers::<2>("terzaghi-tensor", &plain);
    assert_same_answers::<2>("terzaghi-graded", &plain);
}

#[test]
fn a_plate_that_finds_its_own_place() {
    assert_same_answers::<2>("mandel", &[]);
}

#[test]
fn a_footing_with_stabilising_storage() {
    assert_same_answers::<2>("footing", &["geometry.spacing=0.4"]);
}

#[test]
fn a_crack_that_is_cut_by_the_border_of_shares() {
    assert_same_answers::<2>("sneddon", &["geometry.spacing=0.025"]);
}

/// The families of a process are those of its points and of the points that see them: a fraction
/// of all that shrinks with the number of processes.
#[test]
fn each_process_holds_its_part_of_bonds_and_entries() {
    let plan = plan(
        "five-spot",
        &["geometry.points=[100, 100]", "flow.hourglass=0.5"],
    );
    let whole = Model::<2>::build(&plan, &mut Timers::default()).unwrap();
    let bonds = |model: &Model<2>| {
        let flow = model.flow.as_ref().unwrap();
        flow.operator.neighbourhood().families.bonds() as f64
    };
    let entries = |model: &Model<2>| model.flow.as_ref().unwrap().pattern.nonzeros() as f64;
    let (plan, whole) = (&plan, &whole);
    std::thread::scope(|scope| {
        for member in thread_team(4) {
            scope.spawn(move || {
                let share = share::<2>(plan, &member);
                assert!((entries(&share) / entries(whole) - 0.25).abs() < 0.01);
                // The leading one has the families along the diagonal profile too.
                let most = if member.rank() == 0 { 0.36 } else { 0.30 };
                assert!(bonds(&share) / bonds(whole) < most);
            });
        }
    });
}
