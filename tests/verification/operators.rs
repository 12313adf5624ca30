//! Assembled operators against the matrix-free oracle, and their invariants.

use perifrac::plan::Plan;

use crate::support::{flow_model, model, plan, plan_of};

fn cases() -> Vec<(&'static str, Plan)> {
    let graded = super::patch::COLUMN;
    let one_sided = graded.replace("[reference]\ntype = \"two-layer\"\n", "");
    vec![
        ("lattice", plan("five-spot", &["geometry.points=[12, 12]"])),
        (
            "low hourglass",
            plan(
                "five-spot",
                &["geometry.points=[12, 12]", "flow.hourglass=0.3"],
            ),
        ),
        ("walls", plan("two-layer", &["geometry.points=[16, 4]"])),
        (
            "walls, two hops",
            plan(
                "two-layer",
                &[
                    "geometry.points=[16, 4]",
                    "flow.operator=correspondence",
                    "flow.hourglass=0.5",
                ],
            ),
        ),
        ("graded", plan_of(graded, &[])),
        ("graded, plain", plan_of(graded, &["flow.gradient=plain"])),
        (
            "one-sided",
            plan_of(&one_sided, &["flow.boundary.left={flux=1}"]),
        ),
        (
            "heterogeneous",
            plan("heterogeneous", &["geometry.points=[14, 14]"]),
        ),
    ]
}

/// Reproducible values between −1 and 1.
fn noise(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| ((i * 7919 + 13) % 1009) as f64 / 504.5 - 1.0)
        .collect()
}

#[test]
fn the_matrix_is_the_matrix_free_operator() {
    for (name, plan) in cases() {
        let flow = flow_model::<2>(&plan);
        let pressure = noise(flow.points());
        let families = &flow.operator.neighbourhood().families;
        let difference = |owner: usize, bond: usize| {
            let end =
                flow.extension.sign(families.image(bond)) * pressure[families.neighbour(bond)];
            end - pressure[owner]
        };
        let oracle = flow
            .operator
            .force(&flow.extension, &flow.mobility, &difference);
        let mut product = vec![0.0; pressure.len()];
        perifrac_solvers::multiply(flow.matrix(), &pressure, &mut product);
        let scale = product.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        for (a, b) in oracle.iter().zip(&product) {
            assert!((a - b).abs() < 1e-12 * scale, "{name}: {a} {b}");
        }
    }
}

#[test]
fn matrices_are_symmetric_and_their_rows_add_up_to_what_the_walls_take() {
    for (name, plan) in cases() {
        let flow = flow_model::<2>(&plan);
        assert!(
            perifrac_solvers::is_symmetric(flow.matrix(), 1e-12),
            "{name}"
        );
        let mut leak = vec![0.0; flow.points()];
        flow.walls.iter().for_each(|wall| wall.add_leak(&mut leak));
        for (row, &leak) in leak.iter().enumerate() {
            let entries = &flow.conductance[flow.pattern.row(row)];
            let sum: f64 = entries.iter().sum();
            let scale: f64 = entries.iter().map(|v| v.abs()).sum();
            assert!(
                (sum - leak).abs() < 1e-14 * scale,
                "{name} row {row}: {sum:.1e}"
            );
        }
    }
}

#[test]
fn a_constant_pressure_equal_to_the_walls_drives_nothing() {
    let plan = plan(
        "two-layer",
        &[
            "geometry.points=[16, 4]",
            "flow.boundary.right={pressure=1}",
        ],
    );
    let flow = flow_model::<2>(&plan);
    let mut imbalance = vec![7.0; flow.points()];
    flow.imbalance(0.0, &vec![1.0; flow.points()], &mut imbalance);
    assert!(imbalance.iter().all(|&r| r == 0.0), "to the last bit");
}

#[test]
fn a_linear_pressure_has_the_exact_darcy_velocity_everywhere() {
    let plan = plan_of(super::patch::COLUMN, &[]);
    let model = model::<2>(&plan);
    let pressure: Vec<f64> = model.cloud.position.iter().map(|x| 1.0 - x[0]).collect();
    for velocity in model.flow.as_ref().unwrap().velocity(&pressure, 0.0) {
        assert!(
            (velocity[0] - 1.0).abs() < 1e-11 && velocity[1].abs() < 1e-11,
            "{velocity}"
        );
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let flow = flow_model::<2>(&plan_of(super::patch::COLUMN, &[]));
            let pressure = noise(flow.points());
            let mut imbalance = vec![0.0; pressure.len()];
            flow.imbalance(0.0, &pressure, &mut imbalance);
            (flow.conductance, imbalance)
        })
    };
    let one = build(1);
    for threads in [2, 3, 7] {
        assert!(build(threads) == one, "{threads} threads");
    }
}
