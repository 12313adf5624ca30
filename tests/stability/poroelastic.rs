//! Coupled hard cases: tiny and huge steps, undrained and nearly incompressible rock, contrasts.

use perifrac::plan::Plan;
use perifrac::run::{Interrupt, Observer, Progress, RunError, Summary, run};
use perifrac::schemes::State;

use crate::support::{extremes, plan, plan_of};

/// Keeps the potential energy of every step.
#[derive(Default)]
struct Energies(Vec<f64>);

impl Observer for Energies {
    fn step(&mut self, progress: &Progress) {
        self.0.extend(progress.potential);
    }
}

fn watched(plan: &Plan) -> Result<(Summary, State, Vec<f64>), RunError> {
    let mut energies = Energies::default();
    let interrupt = Interrupt::default();
    let (summary, state) = run(plan, None, &mut energies, &interrupt)?;
    Ok((summary, state, energies.0))
}

/// Finite, energy not increasing, and pressures between the boundary's and `high`, both overshot by
/// 5 % at most; or refused by name. Gives whether it ran.
#[track_caller]
fn assert_stable(name: &str, plan: &Plan, high: f64) -> bool {
    let (summary, state, energies) = match watched(plan) {
        Ok(outcome) => outcome,
        Err(error) => {
            println!("{name}: refused: {error}");
            assert!(matches!(error, RunError::Step { .. }), "{name}: {error}");
            return false;
        }
    };
    let (low, top) = extremes(&state.pressure);
    println!(
        "{name}: pressure {:.4} to {:.4} of the response, mass {:.0e}",
        low / high,
        top / high,
        summary.balance.mass
    );
    assert!(
        state
            .displacement
            .iter()
            .chain(&state.pressure)
            .all(|value| value.is_finite())
    );
    assert!(
        low > -0.05 * high && top < 1.05 * high,
        "{name}: {low} to {top} of {high}"
    );
    let scale = energies.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    for pair in energies.windows(2) {
        assert!(
            pair[1] <= pair[0] + 1e-9 * scale,
            "{name}: energy {} to {}",
            pair[0],
            pair[1]
        );
    }
    true
}

const SCHEMES: [&str; 2] = ["monolithic", "staggered"];
const INTEGRATORS: [&str; 2] = ["backward-euler", "tr-bdf2"];
const COLUMN: [&str; 3] = [
    "geometry.spacing=0.25",
    "geometry.size=[\"5 m\", \"1 m\"]",
    "output={times=[]}",
];

/// Terzaghi's column; `step` in units of Δx²/(6 c_v) for a storage and a permeability.
fn column(factor: f64, storage: f64, ratio: f64, own: &[&str]) -> (Plan, f64) {
    // A = (1+ν)(1−2ν)/(E(1−ν)) with E = 1e8, α = ½, κ = 1e-9.
    let compliance = (1.0 + ratio) * (1.0 - 2.0 * ratio) / (1e8 * (1.0 - ratio));
    let total = storage + 0.25 * compliance;
    let step = factor * 0.0625 * total / (6.0 * 1e-9);
    let (step, end) = (
        format!("time.step={step}"),
        format!("time.end={}", 12.0 * step),
    );
    let (storage, ratio) = (
        format!("materials.rock.storage={storage}"),
        format!("materials.rock.poissons_ratio={ratio}"),
    );
    let all = [&COLUMN[..], &[&step, &end, &storage, &ratio], own].concat();
    (plan("terzaghi", &all), 0.5 * compliance / total * 1e4)
}

#[test]
fn terzaghi_over_ten_decades_of_the_step() {
    for scheme in SCHEMES {
        for integrator in INTEGRATORS {
            let own = [
                format!("scheme.name={scheme}"),
                format!("time.integrator={integrator}"),
            ];
            let own: Vec<&str> = own.iter().map(String::as_str).collect();
            for factor in [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6] {
                let (plan, response) = column(factor, 1.65e-10, 0.0, &own);
                let name = format!("{scheme} {integrator}, step {factor:.0e}");
                assert!(assert_stable(&name, &plan, response), "{name} must run");
            }
        }
    }
}

#[test]
fn terzaghi_down_to_no_storage_and_up_to_incompressible_rock() {
    for scheme in SCHEMES {
        let own = format!("scheme.name={scheme}");
        for storage in [1e-12, 1e-14, 1e-16] {
            for factor in [1e-4, 1.0, 1e4] {
                let (plan, response) = column(factor, storage, 0.0, &[&own]);
                let name = format!("{scheme}, storage {storage:.0e}, step {factor:.0e}");
                // Without storage rough pressures contract by next to nothing per pass: the split may
                // refuse, by name.
                assert!(
                    assert_stable(&name, &plan, response) || scheme == "staggered",
                    "{name}"
                );
            }
        }
        for ratio in [0.45, 0.499, 0.4999] {
            for factor in [1e-4, 1.0, 1e4] {
                let (plan, response) = column(factor, 1.65e-10, ratio, &[&own]);
                let name = format!("{scheme}, Poisson {ratio}, step {factor:.0e}");
                assert!(assert_stable(&name, &plan, response), "{name} must run");
            }
        }
    }
}

/// A column whose far half has another permeability.
fn layered(contrast: f64, scheme: &str, operator: &str, stabilisation: &str) -> Plan {
    let text = perifrac::cases::find("terzaghi").unwrap().scene;
    let text = text.split("[reference]").next().unwrap();
    let text = text.split("[output]").next().unwrap();
    let far = r#"materials.far={youngs_modulus=1e8, poissons_ratio=0, biot_coefficient=0.5, storage=1.65e-10, permeability=K, region={type="half-plane", point=[2.5, 0], normal=[-1, 0]}}"#;
    let far = far.replace('K', &format!("{}", 1e-12 * contrast));
    let scheme = format!("scheme.name={scheme}");
    let operator = format!("flow.operator={operator}");
    let time = "time={end=60, step=5}";
    let stabilisation = format!("coupling.stabilisation={stabilisation}");
    plan_of(
        text,
        &[
            COLUMN[0],
            COLUMN[1],
            &far,
            &scheme,
            &operator,
            &stabilisation,
            time,
        ],
    )
}

#[test]
fn terzaghi_with_a_permeability_contrast() {
    for scheme in SCHEMES {
        for operator in ["correspondence", "bond"] {
            for contrast in [1e-12, 1e-6, 1e6, 1e12] {
                let name = format!("{scheme} {operator}, contrast {contrast:.0e}");
                let plan = layered(contrast, scheme, operator, "0.5");
                let ran = assert_stable(&name, &plan, 18761.726);
                assert!(ran || !(1e-7..1e7).contains(&contrast), "{name} must run");
            }
        }
    }
}

/// What the stabilising storage is for: the strain jumps where the drained half meets the undrained.
#[test]
fn an_undrained_layer_beside_a_drained_one_needs_the_stabilising_storage() {
    let highest = |strength: &str| {
        let plan = layered(1e-6, "monolithic", "bond", strength);
        watched(&plan).unwrap().0.pressure_range.unwrap()[1] / 18761.726
    };
    let (without, with) = (highest("0"), highest("0.5"));
    println!("highest pressure over the response: {without:.3} without, {with:.3} with");
    assert!(without > 1.5 && with < 1.05);
}

/// Half a strip footing; `factor` is the step in units of Δx²/(6 c_v).
fn footing(factor: f64, own: &[&str]) -> Plan {
    let compliance = 1.3 * 0.4 / (1e7 * 0.7);
    let step = factor * 0.16 * (1e-11 + compliance) / (6.0 * 1e-12);
    let (step, end) = (
        format!("time.step={step}"),
        format!("time.end={}", 8.0 * step),
    );
    let common = [
        "geometry.spacing=0.4",
        "output={times=[]}",
        step.as_str(),
        &end,
    ];
    plan("footing", &[&common[..], own].concat())
}

#[test]
fn a_footing_on_a_nearly_undrained_layer_does_not_oscillate() {
    for scheme in SCHEMES {
        let name = format!("scheme.name={scheme}");
        for factor in [1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6] {
            for storage in ["1e-11", "1e-16"] {
                let storage = format!("materials.clay.storage={storage}");
                let plan = footing(factor, &[&name, &storage]);
                let label = format!("footing {scheme}, {storage}, step {factor:.0e}");
                // The response cannot exceed the load itself.
                let ran = assert_stable(&label, &plan, 1e5);
                assert!(ran || scheme == "staggered", "{label} must run");
            }
        }
    }
}
