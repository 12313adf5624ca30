//! Numbers on their way to numpy and from there.

use numpy::{PyArray1, PyArrayMethods};
use perifrac::prelude::FieldValues;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Numbers as an array that owns them and that nobody writes into: one row of `components` each, if there are more
/// than one.
pub(crate) fn array<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    components: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = values.len() / components.max(1);
    let flat = PyArray1::from_vec(py, values);
    let flat = flat.try_readwrite()?.make_nonwriteable();
    match components {
        1 => Ok((*flat).clone().into_any()),
        _ => Ok(flat.reshape([rows, components])?.into_any()),
    }
}

/// Fields by their names, and their units.
pub(crate) fn fields<'py>(
    py: Python<'py>,
    fields: Vec<FieldValues>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let (values, units) = (PyDict::new(py), PyDict::new(py));
    for field in fields {
        units.set_item(field.name, field.unit)?;
        values.set_item(field.name, array(py, field.values, field.components)?)?;
    }
    Ok((values, units))
}
