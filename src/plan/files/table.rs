//! Points as slices, whether they were read or handed in.

use thiserror::Error;

/// Points in SI units: read from a file, or handed in by a program.
///
/// ```
/// use perifrac::prelude::PointTable;
///
/// let table = PointTable::new(2, &[0.25, 0.5, 0.75, 0.5], &[0.5, 0.5])
///     .and_then(|table| table.with_permeability(&[1e-12, 1e-14]));
/// assert_eq!(table.map(|table| table.volume.len()), Ok(2));
/// assert!(PointTable::new(2, &[0.25, 0.5], &[-1.0]).is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointTable {
    /// Space dimension, 2 or 3.
    pub dimension: usize,
    /// Coordinates point by point, m. Shape `(points · dimension,)`.
    pub position: Vec<f64>,
    /// Volume of each point, m³, or area in the plane, m². Positive. Shape `(points,)`.
    pub volume: Vec<f64>,
    /// Name of the material at each point, if it is given. Shape `(points,)`.
    pub material: Option<Vec<String>>,
    /// Permeability at each point, m², if it is given. Positive. Shape `(points,)`.
    pub permeability: Option<Vec<f64>>,
}

/// Why a table of points cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// Neither a plane nor space.
    #[error("points have 2 or 3 coordinates, not {0}")]
    Dimension(usize),
    /// No points, or lists that do not fit together.
    #[error("there are {found} values of {what}, and {expected} are needed")]
    Length {
        /// What the list holds.
        what: &'static str,
        /// Values in it.
        found: usize,
        /// Values that there should be, at least one.
        expected: usize,
    },
    /// A number that cannot be meant.
    #[error("the {what} of point {point} is {value}; {wanted}")]
    Value {
        /// What the list holds.
        what: &'static str,
        /// The point, from 0.
        point: usize,
        /// The number.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
}

impl PointTable {
    /// Points in `dimension` coordinates each, m, with their volumes, m^D.
    ///
    /// # Errors
    /// [`TableError`] for lists that do not fit together, positions that are not finite and volumes that
    /// are not positive.
    pub fn new(dimension: usize, position: &[f64], volume: &[f64]) -> Result<Self, TableError> {
        let table = PointTable {
            dimension,
            position: position.to_vec(),
            volume: volume.to_vec(),
            material: None,
            permeability: None,
        };
        table.check().map(|()| table)
    }

    /// Gives every point its permeability, m².
    ///
    /// # Errors
    /// [`TableError`] for another number of values, or one that is not positive.
    pub fn with_permeability(mut self, permeability: &[f64]) -> Result<Self, TableError> {
        self.permeability = Some(permeability.to_vec());
        self.check().map(|()| self)
    }

    /// Gives every point its material, by the name in the scene.
    ///
    /// # Errors
    /// [`TableError::Length`].
    pub fn with_materials<S: ToString>(mut self, names: &[S]) -> Result<Self, TableError> {
        self.material = Some(names.iter().map(S::to_string).collect());
        self.check().map(|()| self)
    }

    /// Whether the lists fit together and hold numbers that can be meant.
    ///
    /// # Errors
    /// [`TableError`] of the first fault.
    pub fn check(&self) -> Result<(), TableError> {
        let (points, dimension) = (self.volume.len(), self.dimension);
        if !matches!(dimension, 2 | 3) {
            return Err(TableError::Dimension(dimension));
        }
        length("volume", points, points.max(1))?;
        length("position", self.position.len(), points * dimension)?;
        let names = self.material.as_ref().map_or(points, Vec::len);
        length("material", names, points)?;
        let finite = self.position.iter().position(|x| !x.is_finite());
        if let Some(place) = finite {
            return Err(TableError::Value {
                what: "position",
                point: place / dimension,
                value: self.position[place],
                wanted: "coordinates must be finite",
            });
        }
        positive("volume", &self.volume)?;
        let Some(permeability) = &self.permeability else {
            return Ok(());
        };
        length("permeability", permeability.len(), points)?;
        positive("permeability", permeability)
    }
}

fn length(what: &'static str, found: usize, expected: usize) -> Result<(), TableError> {
    match found == expected {
        true => Ok(()),
        false => Err(TableError::Length {
            what,
            found,
            expected,
        }),
    }
}

fn positive(what: &'static str, values: &[f64]) -> Result<(), TableError> {
    let bad = |value: &f64| !(value.is_finite() && *value > 0.0);
    match values.iter().position(bad) {
        None => Ok(()),
        Some(point) => Err(TableError::Value {
            what,
            point,
            value: values[point],
            wanted: "it must be positive and finite",
        }),
    }
}
