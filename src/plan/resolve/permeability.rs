//! Permeabilities: values, arrays from files, random fields and tensors.

use std::path::PathBuf;

use super::Resolver;
use crate::plan::files::{BUNDLED, check_cells, check_length, read_permeability};
use crate::plan::types::{
    GeometryPlan, GradientChoice, OperatorChoice, PermeabilityPlan, Plan, with_contrast,
};
use crate::scene::{self, PermeabilityField, Span, Spanned};

impl Resolver<'_> {
    pub(super) fn permeability(
        &mut self,
        field: &PermeabilityField,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        Some(match field {
            PermeabilityField::Value(value) => PermeabilityPlan::Uniform(value.value()),
            PermeabilityField::File(file) => self.permeability_file(file, geometry)?,
            PermeabilityField::Distribution(field) => PermeabilityPlan::LogNormal {
                median: field.median.value(),
                log10_std: field.log10_std.value(),
                decades: field
                    .decades
                    .map_or(f64::INFINITY, |decades| decades.value()),
                correlation_length: field.correlation_length.map(|length| length.value()),
                seed: field.seed,
            },
            PermeabilityField::K1(tensor) => {
                self.in_the_plane(tensor.k1.span(), geometry)?;
                principal(tensor)
            }
            PermeabilityField::Xx(tensor) => {
                self.in_the_plane(tensor.xx.span(), geometry)?;
                by_components(tensor)
            }
        })
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
        let cells = match &file.cells {
            Some(typed) => Some(self.laid_cells(typed, geometry)?),
            None => None,
        };
        let values = self.array(file, cells.as_deref(), geometry)?;
        let values = match file.contrast {
            None => values,
            Some(contrast) => match with_contrast(&values, contrast.value()) {
                Some(stretched) => stretched,
                None => {
                    let message =
                        "all values of the file are the same, and have no `contrast`; leave it out";
                    return self.fault(contrast.span(), message);
                }
            },
        };
        Some(PermeabilityPlan::Table {
            path: file.file.value.clone(),
            values,
            cells,
        })
    }

    /// Values of a file, x fastest: one for each of the `cells` laid over the domain, else for each point.
    fn array(
        &mut self,
        file: &scene::PermeabilityFile,
        cells: Option<&[usize]>,
        geometry: Option<&GeometryPlan>,
    ) -> Option<Vec<f64>> {
        let path = match file.file.starts_with(BUNDLED) {
            true => PathBuf::from(&file.file.value),
            false => self.loaded.path(&file.file),
        };
        let column = file.column.as_ref().map(|column| column.value.as_str());
        let own = geometry.and_then(GeometryPlan::cells);
        let read = read_permeability(&path, column).and_then(|table| {
            let values = match geometry {
                Some(_) => table.in_point_order(&path, cells.or(own.as_deref()))?,
                // The fault of the geometry is told; its points are not known.
                None => table.values,
            };
            match (cells, geometry.and_then(GeometryPlan::count)) {
                (Some(cells), _) => check_cells(&file.file, values.len(), cells)?,
                (None, Some(points)) => check_length(&file.file, values.len(), points)?,
                (None, None) => {}
            }
            Ok(values)
        });
        match read {
            Ok(values) => Some(values),
            Err(error) => self.fault(file.file.span, error),
        }
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

    /// Where permeabilities are tensors, what only numbers go together with is refused.
    pub(super) fn check_tensors(&mut self, plan: &Plan) {
        let scene = &self.loaded.scene;
        let Some(flow) = &scene.flow else {
            return;
        };
        let typed = scene.materials.iter();
        let mut typed = typed.filter_map(|entry| entry.value.permeability.as_ref());
        let Some(first) = typed.find(|own| own.is_tensor()) else {
            return;
        };
        if !matches!(plan.geometry, GeometryPlan::Lattice { jitter, .. } if jitter <= 0.0) {
            let message = "a permeability tensor needs a lattice without jitter: set geometry.type = \
                           \"lattice\", or give one value";
            self.fault::<()>(first.span, message);
        }
        let other = !matches!(
            flow.operator.value,
            OperatorChoice::Auto | OperatorChoice::Path
        );
        let gradient = flow.gradient.value != GradientChoice::Auto;
        let named = [(other, flow.operator.span), (gradient, flow.gradient.span)];
        if let Some((_, place)) = named.into_iter().find(|(named, _)| *named) {
            let message = "only the path operator knows permeability tensors: leave `operator` and `gradient` \
                           out, or give one value for the permeability";
            self.fault::<()>(place, message);
        }
        for (_, condition) in flow.boundary.iter() {
            if let scene::Condition::Flux(_) = condition.value {
                let message = "a prescribed flux and a permeability tensor do not go together: feed the side \
                               by a pressure, or by [wells] beside it";
                self.fault::<()>(condition.span, message);
            }
        }
    }
}

/// A tensor by its principal values and their axis.
fn principal(tensor: &scene::PrincipalPermeability) -> PermeabilityPlan {
    let [k1, k2] = [tensor.k1, tensor.k2].map(|own| own.value());
    let (sine, cosine) = tensor.angle.value().sin_cos();
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

fn by_components(tensor: &scene::PermeabilityTensor) -> PermeabilityPlan {
    let [xx, yy, xy] = [tensor.xx, tensor.yy, tensor.xy].map(|own| own.value());
    let largest = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    PermeabilityPlan::Tensor {
        largest,
        shape: [xx, yy, xy].map(|own| own / largest),
    }
}
