//! The domain, its points, and how far they see.

use super::Resolver;
use crate::geometry::generate::{Refinement, Segment, divide};
use crate::geometry::{Horizon, Influence};
use crate::plan::files::{PointTable, read_mesh, read_points};
use crate::plan::types::{GeometryPlan, MeshPlan};
use crate::scene::quantity::{Length, values};
use crate::scene::{self, Spanned};

impl Resolver<'_> {
    pub(super) fn geometry(&mut self) -> Option<GeometryPlan> {
        let geometry = &self.loaded.scene.geometry;
        let origin = |given: &Option<Spanned<Vec<Length>>>, dimension: usize| {
            given
                .as_ref()
                .map_or_else(|| vec![0.0; dimension], |origin| values(origin))
        };
        match &geometry.value {
            scene::Geometry::Lattice(lattice) => {
                let size = values(&lattice.size);
                Some(GeometryPlan::Lattice {
                    origin: origin(&lattice.origin, size.len()),
                    cells: self.cells(lattice, &size)?,
                    size,
                    jitter: lattice.jitter.value(),
                    seed: lattice.seed,
                })
            }
            scene::Geometry::Graded(graded) => Some(GeometryPlan::Graded {
                origin: origin(&graded.origin, graded.axes.len()),
                axes: graded
                    .axes
                    .iter()
                    .map(|axis| axis.iter().map(segment).collect())
                    .collect(),
            }),
            scene::Geometry::Blocks(blocks) => {
                let size = values(&blocks.size);
                let refinement = |refine: &scene::Refinement| Refinement {
                    region: refine.region.resolved(),
                    levels: refine.levels.value as u32,
                };
                Some(GeometryPlan::Blocks {
                    origin: origin(&blocks.origin, size.len()),
                    size,
                    spacing: blocks.spacing.value(),
                    refinements: blocks.refine.iter().map(refinement).collect(),
                })
            }
            scene::Geometry::File(file) => self.points(file),
            scene::Geometry::Mesh(file) => self.mesh(file),
        }
    }

    /// Extent across the plane, m; 1 in space. Points from a file tell the dimension only now.
    pub(super) fn thickness(&mut self, dimension: usize) -> Option<f64> {
        let typed = self.loaded.scene.geometry.value.thickness();
        if let (Some(thickness), 3) = (typed, dimension) {
            self.faults
                .push(scene::thickness_in_space(thickness.span()));
            return None;
        }
        Some(typed.map_or(1.0, |thickness| thickness.value()))
    }

    fn cells(&mut self, lattice: &scene::Lattice, size: &[f64]) -> Option<Vec<usize>> {
        if let Some(points) = &lattice.points {
            return Some(points.iter().map(|n| n.value as usize).collect());
        }
        let spacing = lattice.spacing?;
        let cells: Result<Vec<usize>, _> = (0..size.len())
            .map(|axis| divide(size[axis], spacing.value(), axis))
            .collect();
        match cells {
            Ok(cells) => Some(cells),
            Err(error) => self.fault(spacing.span(), error),
        }
    }

    fn points(&mut self, file: &scene::PointFile) -> Option<GeometryPlan> {
        let path = self.loaded.path(&file.path);
        let table = match self.points {
            Some(table) => (table.check().map(|()| table.clone())).map_err(|e| e.to_string()),
            None => read_points(&path).map_err(|error| error.to_string()),
        };
        match table {
            Err(error) => self.fault(file.path.span, error),
            Ok(table) => {
                let bounds = file
                    .bounds
                    .as_ref()
                    .map(|bounds| (values(&bounds.min), values(&bounds.max)));
                if let (Some(given), Some((min, _))) = (&file.bounds, &bounds)
                    && min.len() != table.dimension
                {
                    let message = format!(
                        "the points in {} are {}-dimensional, the bounds {}-dimensional",
                        path.display(),
                        table.dimension,
                        min.len()
                    );
                    return self.fault(given.min.span, message);
                }
                Some(GeometryPlan::Points {
                    path: file.path.value.clone(),
                    table,
                    bounds,
                    any_volume: file.any_volume,
                    mesh: None,
                })
            }
        }
    }

    fn mesh(&mut self, file: &scene::MeshFile) -> Option<GeometryPlan> {
        let unit = file.unit.map_or(1.0, |unit| unit.value());
        let mesh = match read_mesh(&self.loaded.path(&file.path), unit) {
            Ok(mesh) => mesh,
            Err(error) => return self.fault(file.path.span, error),
        };
        let material = self.materials_of(file, &mesh)?;
        Some(GeometryPlan::Points {
            path: file.path.value.clone(),
            table: PointTable {
                material,
                ..mesh.table
            },
            bounds: Some(mesh.bounds),
            any_volume: false,
            mesh: Some(Box::new(MeshPlan {
                sets: mesh.sets,
                dual: mesh.dual,
                outlines: mesh.outlines,
                side_area: mesh.side_area,
                surface: mesh.surface,
            })),
        })
    }
}

fn segment(segment: &scene::Segment) -> Segment {
    let (first, last) = match &segment.spacing {
        scene::SegmentSpacing::Value(spacing) => (spacing.value(), spacing.value()),
        scene::SegmentSpacing::List([first, last]) => (first.value(), last.value()),
    };
    Segment {
        length: segment.length.value(),
        first,
        last,
    }
}

pub(super) fn horizon(scene: &scene::Scene) -> Horizon {
    match scene.horizon.size(scene.damage.as_deref()) {
        scene::HorizonSize::Neighbours(count) => Horizon::Neighbours(count),
        scene::HorizonSize::Radius(radius) => Horizon::Radius(radius),
        scene::HorizonSize::Ratio(ratio) => Horizon::Ratio(ratio),
    }
}

pub(super) fn influence(influence: scene::Influence) -> Influence {
    match influence {
        scene::Influence::InverseSquare => Influence::InverseSquare,
        scene::Influence::Inverse => Influence::Inverse,
        scene::Influence::Constant => Influence::Constant,
        scene::Influence::Gaussian => Influence::Gaussian,
    }
}
