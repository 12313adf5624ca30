//! What pictures show: one number per point, from the fields of an output.

use nalgebra::Matrix3;

use crate::plan::PointFields;

/// A field, or what is drawn of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Quantity {
    /// Start of the names of its pictures.
    pub(crate) file: String,
    /// What it is, with component or magnitude.
    pub(crate) title: String,
    /// SI unit; empty for pure numbers.
    pub(crate) unit: &'static str,
    array: &'static str,
    part: Part,
    /// Ends of the colours where they are the same in all runs.
    pub(crate) range: Option<[f64; 2]>,
}

/// Which number of those at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Component(usize),
    Magnitude,
    /// Largest principal value of the components xx, yy, xy.
    LargestInPlane,
    /// The same of all six components.
    Largest,
}

/// Fields with their units and the names of their components.
const FIELDS: [(&str, &str, &[&str]); 8] = [
    ("pressure", "Pa", &[]),
    ("displacement", "m", &["x", "y", "z"]),
    (
        "effective_stress",
        "Pa",
        &["xx", "yy", "zz", "xy", "yz", "xz"],
    ),
    ("damage", "1", &[]),
    ("velocity", "m/s", &["x", "y", "z"]),
    ("solid_velocity", "m/s", &["x", "y", "z"]),
    ("volumetric_strain", "1", &[]),
    ("aperture", "m", &[]),
];

/// Share of the values at either end of a stress that colours leave out: beside tips and edges of loads it grows with
/// the fineness of the points, and would leave the rest in one colour.
const TAIL: f64 = 0.002;

/// What a run draws at its outputs, in a plane or in space.
pub(crate) fn drawn(dimension: usize) -> [Quantity; 4] {
    let (stress, largest) = match dimension {
        2 => ("largest principal value in the plane", Part::LargestInPlane),
        _ => ("largest principal value", Part::Largest),
    };
    [
        Quantity::new("pressure", "pressure".to_owned(), 0, Part::Component(0)),
        Quantity::new(
            "displacement",
            "displacement, magnitude".to_owned(),
            1,
            Part::Magnitude,
        ),
        Quantity {
            file: "stress".to_owned(),
            ..Quantity::new(
                "",
                format!("effective stress, {stress}, tension positive"),
                2,
                largest,
            )
        },
        Quantity {
            range: Some([0.0, 1.0]),
            ..Quantity::new("damage", "damage".to_owned(), 3, Part::Component(0))
        },
    ]
}

/// The quantity of a name: that of a picture, of a field, or of a field and a component such as `velocity_x`.
///
/// # Errors
/// All names that there are in a dimension.
#[cfg(feature = "study")]
pub(crate) fn named(name: &str, dimension: usize) -> Result<Quantity, Vec<String>> {
    let all = all(dimension);
    let names = || all.iter().map(|own| own.file.clone()).collect();
    all.iter()
        .find(|own| own.file == name)
        .cloned()
        .ok_or_else(names)
}

/// Every quantity that can be drawn.
#[cfg(feature = "study")]
fn all(dimension: usize) -> Vec<Quantity> {
    let mut all: Vec<Quantity> = drawn(dimension).into();
    for (number, (name, _, components)) in FIELDS.iter().enumerate() {
        let words = name.replace('_', " ");
        match components.len() {
            0 => all.push(Quantity::new(
                name,
                words.clone(),
                number,
                Part::Component(0),
            )),
            3 => all.push(Quantity::new(
                name,
                format!("{words}, magnitude"),
                number,
                Part::Magnitude,
            )),
            _ => {}
        }
        for (k, component) in components.iter().enumerate() {
            if components.len() == 3 && k >= dimension {
                continue;
            }
            let file = format!("{name}_{component}");
            let title = format!("{words}, component {component}");
            all.push(Quantity::new(&file, title, number, Part::Component(k)));
        }
    }
    // Those that a run draws come first; a field of the same name adds nothing.
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|own| seen.insert(own.file.clone()));
    all
}

impl Quantity {
    fn new(file: &str, title: String, field: usize, part: Part) -> Self {
        let (array, unit, _) = FIELDS[field];
        Quantity {
            file: file.to_owned(),
            title,
            unit,
            array,
            part,
            range: None,
        }
    }

    /// Name of the field it is of.
    pub(crate) fn field(&self) -> &'static str {
        self.array
    }

    /// Its values point by point; `None` where the scene does not name the field.
    pub(crate) fn of(&self, fields: &PointFields) -> Option<Vec<f64>> {
        let (components, values) = fields.arrays.get(self.array)?;
        let own = |at: &[f64]| self.part.of(at);
        Some(values.chunks_exact((*components).max(1)).map(own).collect())
    }

    /// Values between which colours are spread, over all outputs: the extremes, of a stress without its
    /// outermost values; `None` without finite values or where all are the same.
    pub(crate) fn spread(&self, values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
        if self.range.is_some() {
            return self.range;
        }
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let last = values.len().checked_sub(1)?;
        let cut = match self.array {
            "effective_stress" => (TAIL * last as f64) as usize,
            _ => 0,
        };
        let ends = [cut, last - cut].map(|place| {
            let (_, found, _) = values.select_nth_unstable_by(place, f64::total_cmp);
            *found
        });
        let apart = ends[1] - ends[0];
        (apart > 1e-9 * ends[0].abs().max(ends[1].abs())).then_some(ends)
    }
}

impl Part {
    fn of(self, at: &[f64]) -> f64 {
        match (self, at) {
            (Part::Component(k), _) => at.get(k).copied().unwrap_or(f64::NAN),
            (Part::Magnitude, _) => at.iter().map(|c| c * c).sum::<f64>().sqrt(),
            (Part::LargestInPlane, &[xx, yy, _, xy, ..]) => {
                0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy)
            }
            (Part::Largest, &[xx, yy, zz, xy, yz, xz]) => {
                let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
                match tensor.iter().all(|own| own.is_finite()) {
                    true => tensor.symmetric_eigenvalues().max(),
                    false => f64::NAN,
                }
            }
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    fn stress(components: [f64; 6]) -> PointFields {
        let mut fields = PointFields::default();
        let values = (6, components.to_vec());
        fields.arrays.insert("effective_stress".to_owned(), values);
        fields
    }

    /// By hand: a pure shear of 3 in the plane on top of 1 has the principal values 4 and −2; 5 across the plane counts
    /// in space only.
    #[test]
    fn principal_values_are_those_of_the_plane_or_of_space() {
        let fields = stress([1.0, 1.0, 5.0, 3.0, 0.0, 0.0]);
        let [_, _, plane, _] = drawn(2);
        let [_, _, space, _] = drawn(3);
        assert_eq!(plane.of(&fields), Some(vec![4.0]));
        assert!((space.of(&fields).unwrap()[0] - 5.0).abs() < 1e-12);
        assert!(space.of(&stress([f64::NAN; 6])).unwrap()[0].is_nan());
    }

    #[test]
    fn names_are_those_of_pictures_fields_and_components() {
        assert_eq!(
            named("velocity_x", 2).unwrap().title,
            "velocity, component x"
        );
        assert_eq!(named("stress", 2).unwrap().unit, "Pa");
        let known = named("velocity_z", 2).unwrap_err();
        assert!(
            known.contains(&"effective_stress_xy".to_owned()),
            "{known:?}"
        );
        let count = known.iter().filter(|name| *name == "pressure").count();
        assert_eq!(count, 1);
    }

    #[test]
    fn colours_leave_out_the_outermost_values_of_a_stress_only() {
        let values = || (0..=1000).map(f64::from);
        let [pressure, _, stress, damage] = drawn(2);
        assert_eq!(pressure.spread(values()), Some([0.0, 1000.0]));
        assert_eq!(stress.spread(values()), Some([2.0, 998.0]));
        assert_eq!(damage.spread(values()), Some([0.0, 1.0]));
        assert_eq!(pressure.spread([3.0, f64::NAN, 3.0].into_iter()), None);
        assert_eq!(pressure.spread(std::iter::empty()), None);
    }
}
