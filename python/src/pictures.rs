//! Pictures of fields for notebooks.

use numpy::PyReadonlyArray1;
use perifrac::output::{FieldPlot, Scale, field_png};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{Fault, raised};

/// Draws a field over the plane as PNG: `positions` x and y point by point, m, `sizes` the edge of each cell, m,
/// `labels` title and unit.
#[pyfunction]
#[pyo3(signature = (positions, sizes, values, labels, time=None, width=560))]
pub(crate) fn picture<'py>(
    py: Python<'py>,
    positions: PyReadonlyArray1<'py, f64>,
    sizes: PyReadonlyArray1<'py, f64>,
    values: PyReadonlyArray1<'py, f64>,
    labels: (String, String),
    time: Option<f64>,
    width: u32,
) -> PyResult<Bound<'py, PyBytes>> {
    let plot = FieldPlot {
        title: &labels.0,
        unit: &labels.1,
        positions: positions.as_slice()?,
        dimension: 2,
        sizes: sizes.as_slice()?,
        values: values.as_slice()?,
        time,
        scale: Scale::Linear,
        range: None,
        width_px: width,
        axes: ["x", "y"],
        lines: &[],
        outlines: &[],
        source: None,
    };
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("field.png");
    let drawn = field_png(&path, &plot);
    raised(py, drawn.map_err(|error| Fault::new("OutputError", error)))?;
    Ok(PyBytes::new(py, &std::fs::read(path)?))
}
