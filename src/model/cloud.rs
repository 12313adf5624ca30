//! Cloud and families of a plan.

use crate::effects::vector;
use crate::geometry::generate::{blocks, graded, jitter, lattice};
use crate::geometry::{
    Cloud, Crack, Cutter, Domain, Families, ImageTable, Outline, Subdomain, Vector, horizons,
    horizons_in_parts,
};
use crate::plan::{CrackKind, CrackPlan, GeometryPlan, Plan, PointTable};
use perifrac_solvers::{Communicator, Coordinates, Partition};
use std::sync::Arc;

use super::ModelError;
use super::operator_choice::grid_alone;
use crate::operators::{grid_families, runs_along_axes};

/// Makes the cloud; the table holds what a points file says about materials.
///
/// # Errors
/// [`ModelError`] for a geometry that cannot be generated.
pub fn build_cloud<const D: usize>(
    plan: &Plan,
) -> Result<(Cloud<D>, Option<&PointTable>), ModelError> {
    let (cloud, table) = generate(plan)?;
    check_resolved(&cloud)?;
    Ok((cloud, table))
}

/// Cell edges over the largest coordinate below which neighbours cannot be told apart well enough:
/// differences of coordinates keep three digits fewer than 16.
const FINEST: f64 = 1e-10;

/// Points so far from the origin that rounding moves them are no lattice any more.
fn check_resolved<const D: usize>(cloud: &Cloud<D>) -> Result<(), ModelError> {
    let reach = cloud.domain.lower.amax().max(cloud.domain.upper.amax());
    let edge = |point: &usize| cloud.cell[*point].min();
    let fine = |point: &usize| !(edge(point) > FINEST * reach && cloud.volume[*point] > 0.0);
    match (0..cloud.len()).find(fine) {
        None => Ok(()),
        Some(point) => Err(ModelError::Unresolved {
            point,
            edge: edge(&point),
            reach,
        }),
    }
}

fn generate<const D: usize>(plan: &Plan) -> Result<(Cloud<D>, Option<&PointTable>), ModelError> {
    match &plan.geometry {
        GeometryPlan::Lattice {
            origin,
            size,
            cells,
            jitter: amount,
            seed,
        } => {
            let cells = std::array::from_fn(|axis| cells[axis]);
            let mut cloud = lattice(vector(origin), vector(size), cells)?;
            jitter(&mut cloud, *amount, *seed);
            Ok((cloud, None))
        }
        GeometryPlan::Graded { origin, axes } => {
            let axes = std::array::from_fn(|axis| axes[axis].clone());
            Ok((graded(vector(origin), &axes)?, None))
        }
        GeometryPlan::Blocks {
            origin,
            size,
            spacing,
            refinements,
        } => Ok((
            blocks(vector(origin), vector(size), *spacing, refinements)?,
            None,
        )),
        GeometryPlan::Points {
            path,
            table,
            bounds,
            mesh,
            ..
        } => {
            let mut cloud = from_table(path, table, bounds.as_ref())?;
            if let Some(mesh) = mesh {
                let ball = |own: &(Vec<f64>, f64)| (vector(&own.0), own.1);
                cloud.filled = mesh.surface.is_empty();
                cloud.outline = Some(Outline {
                    side_area: mesh.side_area.clone(),
                    surface: mesh.surface.iter().map(ball).collect(),
                });
            }
            Ok((cloud, Some(table)))
        }
    }
}

/// Finds the families of the plan's horizon; with a team only those that this process needs, and those of
/// points in `watched`.
///
/// # Errors
/// [`ModelError::Geometry`].
pub fn build_families<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    team: Option<&Arc<dyn Communicator>>,
    watched: &[usize],
) -> Result<Families<D>, ModelError> {
    let Some(team) = team else {
        if grid_alone(plan, cloud.irregular) && runs_along_axes(cloud) {
            let horizon = horizons(cloud, plan.horizon)?;
            let reach = horizon.iter().copied().fold(0.0, f64::max);
            let images = ImageTable::new(&cloud.domain, reach)?;
            return Ok(grid_families(cloud, images, Subdomain::WHOLE, horizon)?);
        }
        let families = Families::search(cloud, horizons(cloud, plan.horizon)?)?;
        return cut(plan, cloud, families);
    };
    let values = cloud.flat_positions();
    let coordinates = Coordinates {
        dimension: D,
        values: &values,
    };
    let partition = Partition::bisection(team.clone(), &coordinates);
    let horizon = horizons_in_parts(cloud, plan.horizon, Some(&partition))?;
    let families = Families::search_share(cloud, horizon, Some(partition), watched)?;
    cut(plan, cloud, families)
}

/// The plan's cracks as chains; those in space have no segments.
pub(crate) fn cracks<const D: usize>(plan: &Plan) -> Vec<Crack<D>> {
    let chain = |crack: &CrackPlan| Crack {
        points: crack.points().iter().map(|x| vector(x)).collect(),
    };
    plan.cracks.iter().map(chain).collect()
}

/// Those of the plan's cracks that cut bonds, as chains.
pub fn cut_cracks<const D: usize>(plan: &Plan) -> Vec<Crack<D>> {
    let own = plan.cracks.iter().zip(cracks(plan));
    let cut = own.filter(|(own, _)| own.kind == CrackKind::Cut);
    cut.map(|(_, crack)| crack).collect()
}

/// Cuts the bonds across the plan's cracks.
fn cut<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    families: Families<D>,
) -> Result<Families<D>, ModelError> {
    let is_cut = |crack: &CrackPlan| crack.kind == CrackKind::Cut;
    if !plan.cracks.iter().any(is_cut) {
        return Ok(families);
    }
    let mut cracks = cracks(plan);
    for (crack, own) in cracks.iter_mut().zip(&plan.cracks) {
        if !is_cut(own) {
            crack.points.clear();
        }
    }
    let cutter = Cutter::new(&cracks, &families.images);
    for (point, x) in cloud.position.iter().enumerate() {
        if let Some(crack) = cutter.first(x, x) {
            return Err(ModelError::CrackThroughPoint {
                name: plan.cracks[usize::from(crack)].name.clone(),
                point,
                position: x.iter().copied().collect(),
            });
        }
    }
    Ok(families.cut(cloud, &cutter)?)
}

fn from_table<const D: usize>(
    path: &str,
    table: &PointTable,
    bounds: Option<&(Vec<f64>, Vec<f64>)>,
) -> Result<Cloud<D>, ModelError> {
    let position: Vec<Vector<D>> = table.position.chunks_exact(D).map(vector).collect();
    let domain = match bounds {
        Some((lower, upper)) => Domain {
            lower: vector(lower),
            upper: vector(upper),
            planes: true,
        },
        None => bounding_box(&position),
    };
    let cell: Vec<Vector<D>> = table
        .volume
        .iter()
        .map(|&v| Vector::repeat(crate::geometry::edge(v, D)))
        .collect();
    let cloud = Cloud {
        domain,
        position,
        volume: table.volume.clone(),
        cell,
        irregular: true,
        filled: false,
        outline: None,
    };
    check_inside(path, &cloud)?;
    check_distinct(path, &cloud)?;
    Ok(cloud)
}

fn bounding_box<const D: usize>(position: &[Vector<D>]) -> Domain<D> {
    let start: (Vector<D>, Vector<D>) = (
        Vector::repeat(f64::INFINITY),
        Vector::repeat(f64::NEG_INFINITY),
    );
    let (lower, upper) = position.iter().fold(start, |(low, high), x: &Vector<D>| {
        (low.inf(x), high.sup(x))
    });
    Domain {
        lower,
        upper,
        planes: false,
    }
}

/// Points on or beyond a mirror plane would coincide with their images.
fn check_inside<const D: usize>(path: &str, cloud: &Cloud<D>) -> Result<(), ModelError> {
    if !cloud.domain.planes {
        return Ok(());
    }
    let outside = |i: &usize| {
        let margin = 1e-6 * cloud.spacing(*i);
        let x = &cloud.position[*i];
        (0..D)
            .any(|a| x[a] < cloud.domain.lower[a] + margin || x[a] > cloud.domain.upper[a] - margin)
    };
    match (0..cloud.len()).find(outside) {
        None => Ok(()),
        Some(i) => Err(ModelError::Points {
            path: path.to_owned(),
            message: format!(
                "point {i} at {:?} lies on or outside geometry.bounds; points are cell centres, \
                 half a cell inside the boundary",
                cloud.position[i].as_slice()
            ),
        }),
    }
}

fn check_distinct<const D: usize>(path: &str, cloud: &Cloud<D>) -> Result<(), ModelError> {
    let mut order: Vec<usize> = (0..cloud.len()).collect();
    let key = |i: usize| {
        cloud.position[i]
            .iter()
            .map(|x| x.to_bits())
            .collect::<Vec<u64>>()
    };
    order.sort_by_cached_key(|&i| key(i));
    match order
        .windows(2)
        .find(|pair| cloud.position[pair[0]] == cloud.position[pair[1]])
    {
        None => Ok(()),
        Some(pair) => Err(ModelError::Points {
            path: path.to_owned(),
            message: format!(
                "points {} and {} are both at {:?}; remove one",
                pair[0].min(pair[1]),
                pair[0].max(pair[1]),
                cloud.position[pair[0]].as_slice()
            ),
        }),
    }
}
