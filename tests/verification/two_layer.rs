//! Two layers in series against the exact flux and the transient table (Sturm–Liouville series).

use perifrac::run::Summary;

use crate::support::{extremes, plan, run_case};

fn steady(contrast: &str, operator: &str) -> Summary {
    let contrast = format!("materials.left.permeability={contrast}");
    let operator = format!("flow.operator={operator}");
    run_case("two-layer", &["time.mode=steady", &contrast, &operator]).0
}

#[test]
fn the_bond_operator_carries_the_flux_at_every_contrast() {
    for contrast in ["1", "1e2", "1e4", "1e6", "1e8", "1e10", "1e12"] {
        let bond = steady(contrast, "bond");
        assert!(
            bond.errors["flux"].max <= 0.007,
            "{contrast}: {:?}",
            bond.errors["flux"]
        );
        let [low, high] = bond.pressure_range.unwrap();
        assert!(
            low >= 0.0 && high <= 1.0,
            "no over- or undershoot at {contrast}"
        );
    }
    // The correspondence operator acts like an arithmetic mean at the interface: 7 % at 40 across.
    let correspondence = steady("1e4", "correspondence").errors["flux"].max;
    assert!((0.05..0.09).contains(&correspondence), "{correspondence}");
}

#[test]
fn a_uniform_column_is_exact() {
    for operator in ["bond", "correspondence"] {
        let summary = steady("1", operator);
        assert!(summary.errors["flux"].max < 1e-12 && summary.errors["pressure"].max < 1e-12);
    }
}

/// p(¼), p(½), p(¾) at t = 0.02 and 0.1 for K₁ = 1e0 … 1e8.
const TABLE: [(&str, [[f64; 3]; 2]); 4] = [
    (
        "1",
        [
            [0.21129955, 0.01241933, 0.00017683],
            [0.57605950, 0.26275627, 0.08834391],
        ],
    ),
    (
        "1e2",
        [
            [0.98934806, 0.97888628, 0.18791092],
            [0.99482247, 0.98965042, 0.48108560],
        ],
    ),
    (
        "1e4",
        [
            [0.99990020, 0.99980042, 0.21088969],
            [0.99994807, 0.99989614, 0.48764983],
        ],
    ),
    (
        "1e8",
        [
            [0.99999999, 0.99999998, 0.21112269],
            [0.99999999, 0.99999998, 0.48771559],
        ],
    ),
];

#[test]
fn transient_pressures_at_the_quarter_points_and_the_interface() {
    for (contrast, rows) in TABLE {
        let contrast = format!("materials.left.permeability={contrast}");
        for (time, row) in ["0.02", "0.1"].into_iter().zip(rows) {
            let end = format!("time.end={time}");
            let plan = plan("two-layer", &[&contrast, &end, "output.times=[]"]);
            let probes = crate::support::probe_values(&plan);
            for (computed, exact) in probes.into_iter().zip(row) {
                let gap = (computed - exact).abs();
                assert!(
                    gap <= 0.01,
                    "{contrast} t = {time}: {computed} against {exact}"
                );
            }
        }
    }
}

#[test]
fn mass_is_balanced_and_the_maximum_principle_holds_over_the_transient() {
    for contrast in ["1", "1e2", "1e4"] {
        let contrast = format!("materials.left.permeability={contrast}");
        let (summary, state) = run_case("two-layer", &[&contrast]);
        assert!(
            summary.balance.mass <= 1e-10,
            "{contrast}: {}",
            summary.balance.mass
        );
        let (low, high) = extremes(&state.pressure);
        assert!(low >= -1e-10 && high <= 1.0 + 1e-10);
    }
}
