//! Transforms against the assembled matrices: what they solve of a product with random numbers is these numbers.
//!
//! A symbol that differs from the matrix anywhere leaves an error of the size of the difference: no refinement
//! is allowed, which would hide it.

use perifrac::model::Model;
use perifrac::plan::capability::{Refusal, refusals};
use perifrac::report::Timers;
use perifrac::schemes::BlockMatrix;
use perifrac_solvers::{CsrView, Lattice, Problem, SolverSpec, Symmetry, multiply};

use crate::support::{plan, plan_of};

/// Deterministic numbers between −1 and 1.
fn numbers(length: usize) -> Vec<f64> {
    let place = |i: usize| (i as f64 * 0.754_877_666).fract();
    (0..length).map(|i| 2.0 * place(i + 1) - 1.0).collect()
}

/// Largest error of the solution of A x = A y against y, whose entries are up to 1.
fn error(
    matrix: CsrView<'_>,
    symmetry: Symmetry,
    unknowns: usize,
    lattice: &Result<Lattice, String>,
) -> f64 {
    let exact = numbers(matrix.rows());
    let (mut rhs, mut x) = (exact.clone(), exact.clone());
    multiply(matrix, &exact, &mut rhs);
    let mut solver = "fourier".parse::<SolverSpec>().unwrap().build().unwrap();
    let problem = Problem {
        lattice: lattice.as_ref().map_err(String::as_str),
        ..Problem::new(matrix, symmetry, unknowns)
    };
    solver.analyse(&problem).unwrap();
    solver.refresh(matrix).unwrap();
    x.fill(0.0);
    solver.solve(matrix, &rhs, &mut x).unwrap();
    assert_eq!(solver.counters().refinements, 0);
    crate::support::largest_difference(&x, &exact)
}

/// Rock of a lattice, whose cells are no squares.
const ROCK: &str = r#"title = "lattice"
[geometry]
type = "lattice"
size = SIZE
points = POINTS
[fluid]
viscosity = 1
[materials.rock]
permeability = 1
storage = 1
youngs_modulus = 2.5
poissons_ratio = 0.25
biot_coefficient = 0.7
[time]
end = 1
"#;

/// Points in the plane, or in space.
fn rock(dimension: usize) -> String {
    let (size, points) = match dimension {
        2 => ("[1, 0.9]", "[11, 8]"),
        _ => ("[0.6, 0.5, 0.7]", "[6, 5, 7]"),
    };
    ROCK.replace("SIZE", size).replace("POINTS", points)
}

/// Error for L with a storage of a hundredth of its largest diagonal entry.
fn flow_error<const D: usize>(text: &str, sets: &[String]) -> f64 {
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let model = Model::<D>::of(&plan_of(text, &sets)).unwrap();
    let flow = model.flow.unwrap();
    let mut values = flow.conductance.clone();
    let diagonals: Vec<usize> = flow.pattern.diagonals().map(|(_, place)| place).collect();
    let storage = 1e-2
        * diagonals
            .iter()
            .map(|&place| values[place])
            .fold(0.0, f64::max);
    diagonals.iter().for_each(|&place| values[place] += storage);
    error(
        flow.view(&values),
        Symmetry::PositiveDefinite,
        1,
        &flow.lattice,
    )
}

#[test]
fn the_symbols_of_all_flow_operators_are_those_of_the_matrices() {
    let operators: [&[&str]; 4] = [
        &["flow.operator=path"],
        &["flow.operator=bond"],
        &["flow.operator=correspondence"],
        // Two hops.
        &["flow.operator=correspondence", "flow.hourglass=0.4"],
    ];
    let sides = ["left", "right", "bottom", "top", "front", "back"];
    for dimension in [2, 3] {
        let text = rock(dimension);
        // Every choice of drained sides in the plane; a few in space.
        let step = if dimension == 2 { 1 } else { 7 };
        for drained in (0..1 << (2 * dimension)).step_by(step) {
            for operator in operators {
                let prescribed = (0..2 * dimension).filter(|side| drained >> side & 1 == 1);
                let mut sets: Vec<String> = prescribed
                    .map(|side| format!("flow.boundary.{}={{pressure=1}}", sides[side]))
                    .collect();
                sets.extend(operator.iter().map(|own| (*own).to_owned()));
                let error = match dimension {
                    2 => flow_error::<2>(&text, &sets),
                    _ => flow_error::<3>(&text, &sets),
                };
                assert!(error < 1e-11, "{sets:?}: {error:e}");
            }
        }
    }
}

/// Layers by faces and off them, and a prescribed flux at one end: the axis across is the one not transformed.
#[test]
fn layers_and_a_flux_across_them_are_exact() {
    for axis in [0, 1] {
        let (mut low, mut high) = (["-1", "-1"], ["2", "2"]);
        (low[axis], high[axis]) = ("0.3", "0.62");
        let sets = [
            format!(
                "materials.clay={{permeability=1e-3, storage=0.5, region={{type=\"box\", min=[{}], max=[{}]}}}}",
                low.join(","),
                high.join(",")
            ),
            format!("flow.boundary.{}={{flux=1}}", ["left", "bottom"][axis]),
        ];
        let error = flow_error::<2>(&rock(2), &sets);
        assert!(error < 1e-9, "{axis}: {error:e}");
    }
}

/// Errors for K, and with flow beside it for the coupled matrix.
fn solid_errors<const D: usize>(sets: &[String]) -> Vec<f64> {
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let model = Model::<D>::build(&plan_of(&rock(D), &sets), &mut Timers::default()).unwrap();
    let solid = model.solid.as_ref().unwrap();
    let alone = error(
        solid.matrix(),
        Symmetry::PositiveDefinite,
        D,
        &solid.lattice,
    );
    let coupled = model.coupling.as_ref().map(|coupling| {
        let mut block = BlockMatrix::new(&model).unwrap();
        block.fill(model.flow.as_ref().unwrap(), 0.05);
        error(
            block.matrix.view(),
            Symmetry::QuasiDefinite,
            D + 1,
            &coupling.lattice,
        )
    });
    [Some(alone), coupled].into_iter().flatten().collect()
}

#[test]
fn the_blocks_of_elasticity_and_of_biot_are_those_of_the_matrices() {
    let roller = |sides: &[&str]| -> Vec<String> {
        let held = |side: &&str| format!("mechanics.boundary.{side}={{roller=true}}");
        sides.iter().map(held).collect()
    };
    let ends = |lower: &str, upper: &str| -> Vec<Vec<String>> {
        let side = |side: &str, support: &str| format!("mechanics.boundary.{side}={{{support}}}");
        let coupled = [
            "flow={}".to_owned(),
            "coupling={stabilisation=0.5}".to_owned(),
        ];
        [
            ("clamped=true", "traction=[0,-1]"),
            ("clamped=true", "clamped=true"),
            ("traction=[1,0]", "roller=true"),
        ]
        .into_iter()
        .flat_map(|(one, other)| {
            let alone = vec![side(lower, one), side(upper, other)];
            let drained = format!("flow.boundary.{upper}={{pressure=0}}");
            let both = [&alone[..], &coupled[..], &[drained]].concat();
            [alone, both]
        })
        .collect()
    };
    for (sides, [lower, upper]) in [
        (["left", "right"], ["bottom", "top"]),
        (["bottom", "top"], ["left", "right"]),
    ] {
        for own in ends(lower, upper) {
            let sets = [roller(&sides), own].concat();
            for error in solid_errors::<2>(&sets) {
                assert!(error < 1e-10, "{sets:?}: {error:e}");
            }
        }
    }
    let held = roller(&["left", "right", "bottom", "top"]);
    let column = [
        "mechanics.boundary.front={clamped=true}",
        "mechanics.boundary.back={traction=[0,0,-1]}",
        "flow={boundary={back={pressure=0}}}",
        "coupling={}",
    ];
    let sets = [held, column.map(str::to_owned).to_vec()].concat();
    for error in solid_errors::<3>(&sets) {
        assert!(error < 1e-10, "{error:e}");
    }
}

/// Rows of elasticity that are copied, against those that are filled one by one, in 2-D and 3-D.
fn copied_rows<const D: usize>([points, size]: [&str; 2], sides: &[&str]) {
    let sets = [&[points, size, "horizon.ratio=2.1"][..], sides].concat();
    let mut solid = Model::<D>::of(&plan_of(&rock(D), &sets))
        .unwrap()
        .solid
        .unwrap();
    let solid = std::sync::Arc::get_mut(&mut solid).unwrap();
    let copied = solid.stiffness.clone();
    solid.refill();
    let largest = copied
        .data()
        .iter()
        .fold(0.0, |most: f64, own| most.max(own.abs()));
    let off = crate::support::largest_difference(copied.data(), solid.stiffness.data());
    assert!(off < 1e-12 * largest, "{off:e} of {largest:e}");
}

#[test]
fn rows_of_a_uniform_lattice_are_copies_of_each_other() {
    let sides = [
        "mechanics.boundary.left={clamped=true}",
        "mechanics.boundary.right={traction=[1,0]}",
        "mechanics.boundary.top={roller=true}",
    ];
    copied_rows::<2>(["geometry.points=[19,16]", "geometry.size=[2,1.6]"], &sides);
    let sides = [
        "mechanics.boundary.front={clamped=true}",
        "mechanics.boundary.back={traction=[0,0,1]}",
        "mechanics.boundary.top={roller=true}",
    ];
    copied_rows::<3>(
        ["geometry.points=[16,16,3]", "geometry.size=[1.6,1.7,0.3]"],
        &sides,
    );
}

/// What a plan that asks for transforms is refused with; empty if it is not.
fn refusal(case: &str, overrides: &[&str]) -> String {
    let all = [overrides, &["solver.name=fourier"]].concat();
    let refused: Vec<Refusal> = refusals(&plan(case, &all), 1);
    refused.iter().map(Refusal::to_string).collect()
}

#[test]
fn rows_that_do_not_repeat_are_refused_with_their_reason() {
    for (case, overrides, reason) in [
        ("five-spot", &[][..], ""),
        ("terzaghi", &[], ""),
        ("five-spot", &["geometry.jitter=0.1"], "points are jittered"),
        ("terzaghi-graded", &[], "cells differ in size or place"),
        ("sneddon", &[], "cracks cut bonds"),
        ("natural-fractures", &[], "rock breaks"),
        (
            "footing",
            &["mechanics.boundary.right={clamped=true}"],
            "along x, `right` is clamped",
        ),
        (
            "footing",
            &["flow.boundary.left={pressure=0}"],
            "along x, `left` slides and is drained",
        ),
    ] {
        let told = refusal(case, overrides);
        assert_eq!(told.is_empty(), reason.is_empty(), "{case}: {told}");
        assert!(told.contains(reason), "{case}: {told}");
    }
}
