//! Loads: a constant, or values in time.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::quantity::{Dimension, Quantity, Time};
use super::span::{Span, Spanned};

/// A quantity that may change in time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    rename = "Load by key",
    rename_all = "kebab-case",
    bound = "D: Dimension"
)]
pub enum Load<D: Dimension> {
    /// The same value at all times.
    Value(Quantity<D>),
    /// Straight lines between points in time; constant before the first and after the last.
    Time(TimeSeries<D>),
}

/// Points in time with their values.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, bound = "D: Dimension")]
pub struct TimeSeries<D: Dimension> {
    /// The times, s, strictly increasing.
    pub time: Spanned<Vec<Time>>,
    /// The value at each time.
    pub value: Spanned<Vec<Quantity<D>>>,
}

impl<D: Dimension> Load<D> {
    /// The load in SI numbers.
    pub fn resolved(&self) -> crate::load::Load {
        match self {
            Self::Value(value) => crate::load::Load::constant(value.value()),
            Self::Time(series) => {
                let numbers = |list: &[Quantity<D>]| list.iter().map(Quantity::value).collect();
                let times = series.time.iter().map(Time::value).collect();
                crate::load::Load::table(times, numbers(&series.value))
            }
        }
    }

    /// The load per metre of thickness of a slab of `thickness` metres: what was typed for all of it, or
    /// as a bare number, is divided by it; what was typed per metre is not.
    pub fn per_thickness(&self, thickness: f64) -> crate::load::Load {
        let share = |value: &Quantity<D>| value.per_thickness(thickness);
        match self {
            Self::Value(value) => crate::load::Load::constant(share(value)),
            Self::Time(series) => {
                let times = series.time.iter().map(Time::value).collect();
                crate::load::Load::table(times, series.value.iter().map(share).collect())
            }
        }
    }

    /// All values it is made of, each with its place.
    pub fn values(&self) -> &[Quantity<D>] {
        match self {
            Self::Value(value) => std::slice::from_ref(value),
            Self::Time(series) => &series.value,
        }
    }

    /// Where it was typed (the values of a series).
    pub fn span(&self) -> Span {
        match self {
            Self::Value(value) => value.span(),
            Self::Time(series) => series.value.span,
        }
    }
}

impl<D: Dimension> JsonSchema for Load<D> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}Load", D::ID).into()
    }
    fn schema_id() -> Cow<'static, str> {
        format!("{}::{}", module_path!(), D::ID).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<Quantity<D>>();
        let time = generator.subschema_for::<Time>();
        json_schema!({
            "description": "a constant, or values in time with straight lines between",
            "anyOf": [value, {
                "type": "object",
                "properties": {
                    "time": { "type": "array", "items": time },
                    "value": { "type": "array", "items": value },
                },
                "required": ["time", "value"],
                "additionalProperties": false,
            }],
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;
    use crate::scene::quantity::dimension;

    fn ramp() -> Load<dimension::Pressure> {
        let list = |values: &[f64]| values.iter().map(|&v| Quantity::si(v)).collect();
        Load::Time(TimeSeries {
            time: Spanned::nowhere(values_of(&[1.0, 3.0, 4.0])),
            value: Spanned::nowhere(list(&[10.0, 20.0, 0.0])),
        })
    }

    fn values_of(values: &[f64]) -> Vec<Time> {
        values.iter().map(|&value| Time::si(value)).collect()
    }

    #[test]
    fn a_series_is_linear_between_its_points_and_constant_outside() {
        for (time, value) in [
            (-1.0, 10.0),
            (1.0, 10.0),
            (2.0, 15.0),
            (3.0, 20.0),
            (3.5, 10.0),
            (4.0, 0.0),
            (9.0, 0.0),
        ] {
            assert_eq!(ramp().resolved().at(time), value, "t = {time}");
        }
        assert_eq!(ramp().resolved().breakpoints(), [1.0, 3.0, 4.0]);
        assert!(!ramp().resolved().is_constant());
    }

    #[test]
    fn a_constant_has_no_breakpoints() {
        let load = Load::<dimension::Pressure>::Value(Quantity::si(7.0)).resolved();
        assert_eq!((load.at(-1.0), load.at(1e9)), (7.0, 7.0));
        assert!(load.is_constant() && load.breakpoints().is_empty());
    }

    #[test]
    fn a_series_of_one_point_is_constant() {
        let load = Load::<dimension::Pressure>::Time(TimeSeries {
            time: Spanned::nowhere(values_of(&[2.0])),
            value: Spanned::nowhere(vec![Quantity::si(5.0)]),
        })
        .resolved();
        assert!(load.is_constant());
        assert_eq!((load.at(0.0), load.at(2.0), load.at(3.0)), (5.0, 5.0, 5.0));
    }
}
