//! Orders of the coupled problem in time and space, on Terzaghi's column.

use crate::support::{orders, run_case};

/// Relative differences of pressure and displacement at 60 s to a run with small steps.
fn time_errors(scheme: &str, integrator: &str, steps: &[f64]) -> Vec<[f64; 2]> {
    let (scheme, integrator) = (
        format!("scheme.name={scheme}"),
        format!("time.integrator={integrator}"),
    );
    let common = [
        "geometry.spacing=0.5",
        "output.times=[]",
        "scheme.coupling_tolerance=1e-10",
    ];
    let (_, exact) = run_case("terzaghi", &[&common[..], &["time.step=0.02"]].concat());
    let apart = |a: &[f64], b: &[f64]| {
        let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        perifrac_solvers::norm2(&change) / perifrac_solvers::norm2(b)
    };
    let error = |step: &f64| {
        let step = format!("time.step={step}");
        let own = [scheme.as_str(), &integrator, &step];
        let (_, state) = run_case("terzaghi", &[&common[..], &own].concat());
        [
            apart(&state.pressure, &exact.pressure),
            apart(&state.displacement, &exact.displacement),
        ]
    };
    steps.iter().map(error).collect()
}

#[track_caller]
fn assert_orders(name: &str, errors: &[[f64; 2]], least: f64, most: f64) {
    for (field, name_of) in ["pressure", "displacement"].iter().enumerate() {
        let own: Vec<f64> = errors.iter().map(|e| e[field]).collect();
        println!("{name}, {name_of}: {own:?}, orders {:?}", orders(&own));
        assert!(
            orders(&own).iter().all(|o| (least..most).contains(o)),
            "{name}, {name_of}"
        );
    }
}

#[test]
fn backward_euler_is_first_and_tr_bdf2_second_order_for_the_coupled_system() {
    for scheme in ["monolithic", "staggered"] {
        let first = time_errors(scheme, "backward-euler", &[4.0, 2.0, 1.0]);
        assert_orders(&format!("{scheme} backward Euler"), &first, 0.9, 1.2);
        let second = time_errors(scheme, "tr-bdf2", &[4.0, 2.0, 1.0]);
        assert_orders(&format!("{scheme} TR-BDF2"), &second, 1.85, 2.6);
        assert!(second[2][0] < 0.1 * first[2][0]);
    }
}

#[test]
fn terzaghi_is_second_order_in_space() {
    let errors: Vec<[f64; 2]> = ["0.25", "0.125", "0.0625"]
        .iter()
        .map(|spacing| {
            let spacing = format!("geometry.spacing={spacing}");
            let overrides = [
                spacing.as_str(),
                "geometry.size=[7.5, 0.5]",
                "time.end=15",
                "time.tolerance=1e-6",
                "output={times=[]}",
            ];
            let (summary, _) = run_case("terzaghi", &overrides);
            ["pressure", "displacement"].map(|field| summary.errors[field].l2_over_norm)
        })
        .collect();
    assert_orders("Terzaghi in space", &errors, 1.8, 2.4);
}
