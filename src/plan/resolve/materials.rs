//! What the rock and its fluid are like.

use super::Resolver;
use crate::material::{Elasticity, storage_coefficient};
use std::path::PathBuf;

use crate::plan::files::{BUNDLED, check_cells, check_length, read_permeability};
use crate::plan::types::{
    FluidPlan, GeometryPlan, GradientChoice, MaterialPlan, OperatorChoice, PermeabilityPlan, Plan,
    with_contrast,
};
use crate::scene::{self, Span, Spanned};

impl Resolver<'_> {
    pub(super) fn material(
        &mut self,
        name: &str,
        material: &scene::Material,
        geometry: Option<&GeometryPlan>,
    ) -> Option<MaterialPlan> {
        let permeability = match &material.permeability {
            Some(field) => Some(self.permeability(field, geometry)?),
            None => None,
        };
        Some(MaterialPlan {
            name: name.to_owned(),
            region: material.region.as_ref().map(|region| region.resolved()),
            permeability,
            storage: storage(&self.loaded.scene, material),
            elasticity: elasticity(material),
            biot_coefficient: material.biot_coefficient.map(|value| value.value()),
            density: material.density.map(|value| value.value()),
            fracture_energy: material.fracture_energy.map(|value| value.value()),
        })
    }

    fn permeability(
        &mut self,
        field: &scene::PermeabilityField,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        Some(match field {
            scene::PermeabilityField::Value(value) => PermeabilityPlan::Uniform(value.value()),
            scene::PermeabilityField::File(file) => self.permeability_file(file, geometry)?,
            scene::PermeabilityField::Distribution(field) => PermeabilityPlan::LogNormal {
                median: field.median.value(),
                log10_std: field.log10_std.value(),
                decades: field
                    .decades
                    .map_or(f64::INFINITY, |decades| decades.value()),
                correlation_length: field.correlation_length.map(|length| length.value()),
                seed: field.seed,
            },
            scene::PermeabilityField::K1(principal) => {
                self.in_the_plane(principal.k1.span(), geometry)?;
                let [k1, k2] = [principal.k1, principal.k2].map(|own| own.value());
                let (sine, cosine) = principal.angle.value().sin_cos();
                let largest = k1.max(k2);
                let [a, b] = [k1, k2].map(|own| own / largest);
                PermeabilityPlan::Tensor {
                    largest,
                    shape: [
                        a * cosine * cosine + b * sine * sine,
                        a * sine * sine + b * cosine * cosine,
                        (a - b) * cosine * sine,
                    ],
                }
            }
            scene::PermeabilityField::Xx(tensor) => {
                self.in_the_plane(tensor.xx.span(), geometry)?;
                let [xx, yy, xy] = [tensor.xx, tensor.yy, tensor.xy].map(|own| own.value());
                let largest = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
                PermeabilityPlan::Tensor {
                    largest,
                    shape: [xx, yy, xy].map(|own| own / largest),
                }
            }
        })
    }

    /// Where permeabilities are tensors, what only numbers go together with is refused.
    pub(super) fn check_tensors(&mut self, plan: &Plan) {
        let scene = &self.loaded.scene;
        let is_tensor = |own: &&scene::Entry<scene::Material>| {
            matches!(
                own.value.permeability.as_deref(),
                Some(scene::PermeabilityField::K1(_) | scene::PermeabilityField::Xx(_))
            )
        };
        let first = scene.materials.iter().find(is_tensor);
        let (Some(first), Some(flow)) = (first, &scene.flow) else {
            return;
        };
        let place = (first.value.permeability.as_ref()).map_or(first.span, |own| own.span);
        let lattice =
            matches!(plan.geometry, GeometryPlan::Lattice { jitter, .. } if jitter <= 0.0);
        if !lattice {
            let message = "a permeability tensor needs a lattice without jitter: set geometry.type = \
                           \"lattice\", or give one value";
            self.fault::<()>(place, message);
        }
        let path = matches!(
            flow.operator.value,
            OperatorChoice::Auto | OperatorChoice::Path
        );
        if !path || flow.gradient.value != GradientChoice::Auto {
            let named = if path {
                flow.gradient.span
            } else {
                flow.operator.span
            };
            let message = "only the path operator knows permeability tensors: leave `operator` and `gradient` \
                           out, or give one value for the permeability";
            self.fault::<()>(named, message);
        }
        for (_, condition) in flow.boundary.iter() {
            if let scene::Condition::Flux(_) = condition.value {
                let message = "a prescribed flux and a permeability tensor do not go together: feed the side \
                               by a pressure, or by [wells] beside it";
                self.fault::<()>(condition.span, message);
            }
        }
    }

    /// Tensors exist in two dimensions only.
    fn in_the_plane(&mut self, place: Span, geometry: Option<&GeometryPlan>) -> Option<()> {
        match geometry.map(GeometryPlan::dimension) {
            Some(3) => self.fault(
                place,
                "a permeability tensor works in two dimensions only; give one value, or run a plane",
            ),
            _ => Some(()),
        }
    }

    fn permeability_file(
        &mut self,
        file: &scene::PermeabilityFile,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        let path = match file.file.starts_with(BUNDLED) {
            true => PathBuf::from(&file.file.value),
            false => self.loaded.path(&file.file),
        };
        let column = file.column.as_ref().map(|column| column.value.as_str());
        let laid = match &file.cells {
            Some(typed) => Some(self.laid_cells(typed, geometry)?),
            None => None,
        };
        let own = || geometry.and_then(GeometryPlan::cells);
        let cells = laid.clone().or_else(own);
        let points = geometry.and_then(GeometryPlan::count);
        let read = read_permeability(&path, column)
            .and_then(|table| match geometry {
                Some(_) => table.in_point_order(&path, cells.as_deref()),
                // The fault of the geometry is told; its points are not known.
                None => Ok(table.values),
            })
            .and_then(|values| {
                let wanted = points.unwrap_or(values.len());
                match &laid {
                    Some(cells) => check_cells(&file.file, values.len(), cells)?,
                    None => check_length(&file.file, values.len(), wanted)?,
                }
                Ok(values)
            });
        let mut values = match read {
            Ok(values) => values,
            Err(error) => return self.fault(file.file.span, error),
        };
        if let Some(contrast) = file.contrast {
            let Some(stretched) = with_contrast(&values, contrast.value()) else {
                let message =
                    "all values of the file are the same, and have no `contrast`; leave it out";
                return self.fault(contrast.span(), message);
            };
            values = stretched;
        }
        Some(PermeabilityPlan::Table {
            path: file.file.value.clone(),
            values,
            cells: laid,
        })
    }

    /// Cells along each axis of an array that is laid over the domain.
    fn laid_cells(
        &mut self,
        typed: &Spanned<Vec<u32>>,
        geometry: Option<&GeometryPlan>,
    ) -> Option<Vec<usize>> {
        let dimension = geometry.map_or(typed.len(), GeometryPlan::dimension);
        if typed.len() != dimension || typed.contains(&0) {
            let message = format!(
                "`cells` must be {dimension} positive numbers, one for each axis of the domain"
            );
            return self.fault(typed.span, message);
        }
        if let Some(GeometryPlan::Points { bounds: None, .. }) = geometry {
            let message = "an array is laid over the domain, and points from a file have one only with \
                           `geometry.bounds`; give the bounds, or one value for each point without `cells`";
            return self.fault(typed.span, message);
        }
        Some(typed.iter().map(|&cells| cells as usize).collect())
    }
}

pub(super) fn fluid(scene: &scene::Scene) -> FluidPlan {
    let fluid = scene.fluid.as_ref();
    FluidPlan {
        viscosity: fluid.map_or(1.0, |fluid| fluid.viscosity.value()),
        density: fluid.map_or(1000.0, |fluid| fluid.density.value()),
    }
}

fn elasticity(material: &scene::Material) -> Option<Elasticity> {
    Some(Elasticity {
        youngs_modulus: material.youngs_modulus?.value(),
        poissons_ratio: material.poissons_ratio?.value(),
    })
}

/// Storage of a material. A steady run needs none; there it only weighs how a sealed part shares a
/// constant, evenly by volume.
fn storage(scene: &scene::Scene, material: &scene::Material) -> f64 {
    match material.storage() {
        None => 1.0,
        Some(scene::Storage::Given(storage)) => storage,
        Some(scene::Storage::Derived {
            porosity,
            biot_coefficient,
            bulk_modulus,
        }) => {
            let fluid = scene.fluid.as_ref().and_then(|fluid| fluid.bulk_modulus);
            let fluid = fluid.map_or(f64::INFINITY, |modulus| modulus.value());
            storage_coefficient(porosity, biot_coefficient, bulk_modulus, fluid)
        }
    }
}
