//! Properties of the rock as fields: values, arrays from files and random fields.

use std::path::PathBuf;

use super::Resolver;
use crate::plan::files::{BUNDLED, Property, check_cells, check_length, fault, read_field};
use crate::plan::types::{FieldPlan, GeometryPlan, with_contrast};
use crate::scene::quantity::Number;
use crate::scene::{Dimension, FieldFile, Spanned, Typed};

impl Resolver<'_> {
    pub(super) fn field<D: Dimension>(
        &mut self,
        typed: Typed<'_, D>,
        property: Property,
        geometry: Option<&GeometryPlan>,
    ) -> Option<FieldPlan> {
        Some(match typed {
            Typed::Value(value) => FieldPlan::Uniform(value.value()),
            Typed::File(file) => self.field_file(file, property, geometry)?,
            Typed::Distribution(random) => FieldPlan::LogNormal {
                median: random.median.value(),
                log10_std: random.log10_std.value(),
                decades: random
                    .decades
                    .map_or(f64::INFINITY, |decades| decades.value()),
                correlation_length: random.correlation_length.map(|length| length.value()),
                seed: random.seed,
            },
        })
    }

    fn field_file(
        &mut self,
        file: &FieldFile,
        property: Property,
        geometry: Option<&GeometryPlan>,
    ) -> Option<FieldPlan> {
        let cells = match &file.cells {
            Some(typed) => Some(self.laid_cells(typed, geometry)?),
            None => None,
        };
        let values = self.array(file, property, cells.as_deref(), geometry)?;
        let values = match &file.contrast {
            None => values,
            Some(contrast) => self.stretched(&values, *contrast, property)?,
        };
        Some(FieldPlan::Table {
            path: file.file.value.clone(),
            values,
            cells,
        })
    }

    /// The values with their contrast, as far as they still make sense.
    fn stretched(
        &mut self,
        values: &[f64],
        contrast: Number,
        property: Property,
    ) -> Option<Vec<f64>> {
        let Some(stretched) = with_contrast(values, contrast.value()) else {
            let message =
                "all values of the file are the same, and have no `contrast`; leave it out";
            return self.fault(contrast.span(), message);
        };
        let mut faults =
            (stretched.iter()).filter_map(|own| Some((*own, fault(*own, property.allowed)?)));
        match faults.next() {
            None => Some(stretched),
            Some((value, fault)) => {
                let message = format!(
                    "with this `contrast` {} is {value:e}, {fault}",
                    property.key
                );
                self.fault(contrast.span(), message)
            }
        }
    }

    /// Values of a file, x fastest: one for each of the `cells` laid over the domain, else for each point.
    fn array(
        &mut self,
        file: &FieldFile,
        property: Property,
        cells: Option<&[usize]>,
        geometry: Option<&GeometryPlan>,
    ) -> Option<Vec<f64>> {
        let path = match file.file.starts_with(BUNDLED) {
            true => PathBuf::from(&file.file.value),
            false => self.loaded.path(&file.file),
        };
        let column = file.column.as_ref().map(|column| column.value.as_str());
        let own = geometry.and_then(GeometryPlan::cells);
        let read = read_field(&path, column, property).and_then(|table| {
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
}
