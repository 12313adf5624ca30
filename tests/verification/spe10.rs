//! The permeability of SPE 10, model 1 (Christie and Blunt 2001, SPE Reservoir Evaluation & Engineering 4, 308–317),
//! against the flux between two points on the same cells.

use perifrac::model::Model;
use perifrac::reference::two_point_flow;

use crate::support::{model, plan, plan_of_variant, try_run};

const MILLIDARCY: f64 = 9.869233e-16;
const ACROSS: &str = "flow.boundary={bottom={pressure=\"1 MPa\"}, top={pressure=0}}";

/// Effective permeability of a run and of the flux between two points, mD.
fn effective(variant: Option<&str>, finer: usize, axis: usize) -> [f64; 2] {
    let points = [100 * finer, 20 * finer];
    let mut sets = vec![format!("geometry.points={points:?}")];
    sets.extend((axis == 1).then(|| ACROSS.to_owned()));
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    let plan = match variant {
        None => plan("spe10-1", &sets),
        Some(variant) => plan_of_variant("spe10-1", variant, &sets),
    };
    let (summary, _) = try_run(&plan).unwrap();
    let built: Model<2> = model(&plan);
    let flow = built.flow.unwrap();
    let size = flow.operator.neighbourhood().cloud.domain.size();
    let edges = [size[0] / points[0] as f64, size[1] / points[1] as f64];
    let reference = two_point_flow(points, edges, &flow.mobility, axis);
    let per_mobility = size[axis] / size[1 - axis] * plan.fluid.viscosity / MILLIDARCY;
    let out = summary.outflow[["right", "top"][axis]] / 1e6;
    [out, reference].map(|rate| rate * per_mobility)
}

/// The reference is that of another program (square cells 78.9287 and 6.9681 mD, flat ones 119.6456 and
/// 2.8500 mD).
#[test]
fn effective_permeability_is_that_of_the_flux_between_two_points() {
    for (variant, known) in [(None, [78.9287, 6.9681]), (Some("flat"), [119.6456, 2.85])] {
        for (axis, known) in known.into_iter().enumerate() {
            let [own, reference] = effective(variant, 1, axis);
            println!("{variant:?} {axis}: {own} {reference}");
            assert!((reference / known - 1.0).abs() < 1e-4, "{reference}");
            assert!((own / reference - 1.0).abs() < 1e-2, "{own} {reference}");
        }
    }
}

#[test]
fn finer_points_take_the_values_of_the_cells_they_lie_in() {
    for axis in 0..2 {
        let [own, reference] = effective(None, 2, axis);
        println!("{axis}: {own} {reference}");
        assert!((own / reference - 1.0).abs() < 1e-2, "{own} {reference}");
    }
}
