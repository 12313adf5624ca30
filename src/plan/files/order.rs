//! Which value of a file belongs to which point.

use std::path::Path;

use super::FileError;

/// Values of a property from a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FieldTable {
    /// The values, SI; those of an array in C order (last index fastest).
    pub values: Vec<f64>,
    /// Shape of the array; `None` for a column of a table.
    pub shape: Option<Vec<usize>>,
}

impl FieldTable {
    /// The values in the order of the points, x fastest. `cells` are the points along each axis,
    /// where they form a grid.
    ///
    /// A column and an array of shape `(n,)` are in the order of the points. An array of the shape
    /// of the grid has the indices `[ix, iy]` or `[ix, iy, iz]`, from the lowest corner.
    ///
    /// # Errors
    /// [`FileError::Shape`] for an array of another shape.
    pub(crate) fn in_point_order(
        self,
        path: &Path,
        cells: Option<&[usize]>,
    ) -> Result<Vec<f64>, FileError> {
        match (&self.shape, cells) {
            (None, _) => Ok(self.values),
            (Some(shape), _) if shape.len() == 1 => Ok(self.values),
            (Some(shape), Some(cells)) if shape[..] == *cells => {
                Ok(first_index_fastest(&self.values, shape))
            }
            (Some(shape), _) => Err(misfit(path, shape, cells)),
        }
    }
}

/// As many values as points, if `found` is right.
///
/// # Errors
/// [`FileError::Length`].
pub fn check_length(path: &str, found: usize, points: usize) -> Result<(), FileError> {
    match found == points {
        true => Ok(()),
        false => Err(FileError::Length {
            path: path.into(),
            found,
            points,
        }),
    }
}

/// As many values as cells of an array, if `found` is right.
///
/// # Errors
/// [`FileError::Cells`].
pub(crate) fn check_cells(path: &str, found: usize, cells: &[usize]) -> Result<(), FileError> {
    let all = cells
        .iter()
        .try_fold(1_usize, |all, &own| all.checked_mul(own));
    let counts: Vec<String> = cells.iter().map(usize::to_string).collect();
    match all == Some(found) {
        true => Ok(()),
        false => Err(FileError::Cells {
            path: path.into(),
            found,
            cells: match all {
                Some(all) => format!("{} = {all}", counts.join(" × ")),
                None => counts.join(" × "),
            },
        }),
    }
}

/// Values in C order, sorted so that the first index is the fastest.
fn first_index_fastest(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let place = |mut index: usize| {
        let digits = shape.iter().map(|&size| {
            let digit = index % size;
            index /= size;
            digit
        });
        let digits: Vec<usize> = digits.collect();
        let along = digits.iter().zip(shape);
        along.fold(0, |place, (digit, size)| place * size + digit)
    };
    (0..values.len())
        .map(|index| values[place(index)])
        .collect()
}

fn misfit(path: &Path, shape: &[usize], cells: Option<&[usize]>) -> FileError {
    let flat = "in the order of the points";
    let (points, remedy) = match cells {
        None => (
            "points that form no lattice".to_owned(),
            format!("save it flat, with one value for each point {flat}"),
        ),
        Some(cells) => {
            let counts: Vec<String> = cells.iter().map(usize::to_string).collect();
            let names = &["ix", "iy", "iz"][..cells.len().min(3)];
            let turned = shape.iter().rev().eq(cells);
            let turn = if turned {
                "transpose it (`array.T`): "
            } else {
                ""
            };
            let remedy = format!(
                "{turn}its shape must be {}, with the indices [{}] from the lowest corner, or ({},) \
                 {flat} (x fastest)",
                tuple(cells),
                names.join(", "),
                cells
                    .iter()
                    .fold(1_usize, |all, cells| all.saturating_mul(*cells)),
            );
            (format!("a grid of {} points", counts.join(" × ")), remedy)
        }
    };
    FileError::Shape {
        path: path.to_owned(),
        shape: tuple(shape),
        points,
        remedy,
    }
}

/// A shape as NumPy writes it: `(8, 4)`, `(32,)`, `()`.
fn tuple(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &sizes[..] {
        [only] => format!("({only},)"),
        several => format!("({})", several.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    fn ordered(shape: &[usize], cells: Option<&[usize]>) -> Result<Vec<f64>, String> {
        let count: usize = shape.iter().product();
        let table = FieldTable {
            values: (0..count).map(|k| k as f64).collect(),
            shape: Some(shape.to_vec()),
        };
        let ordered = table.in_point_order(Path::new("k.npy"), cells);
        ordered.map_err(|error| error.to_string())
    }

    /// In C order the entry [ix, iy] of shape (3, 2) is number 2 ix + iy.
    #[test]
    fn an_array_of_the_shape_of_the_grid_is_indexed_by_x_first() {
        let expected = [0.0, 2.0, 4.0, 1.0, 3.0, 5.0];
        assert_eq!(ordered(&[3, 2], Some(&[3, 2])).unwrap(), expected);
        // [ix, iy, iz] of shape (2, 1, 3) is number 3 ix + iz.
        let expected = [0.0, 3.0, 1.0, 4.0, 2.0, 5.0];
        assert_eq!(ordered(&[2, 1, 3], Some(&[2, 1, 3])).unwrap(), expected);
    }

    #[test]
    fn a_flat_array_is_in_the_order_of_the_points() {
        for cells in [Some(&[2, 2][..]), None] {
            assert_eq!(ordered(&[4], cells).unwrap(), [0.0, 1.0, 2.0, 3.0]);
        }
    }

    #[test]
    fn every_other_shape_is_refused_with_the_right_one() {
        for (shape, cells, words) in [
            (&[2, 3][..], Some(&[3, 2][..]), "(2, 3) for a grid of 3 × 2"),
            (&[2, 3], Some(&[3, 2]), "transpose it (`array.T`)"),
            (
                &[6, 1],
                Some(&[3, 2]),
                "must be (3, 2), with the indices [ix, iy]",
            ),
            (&[], Some(&[1, 1]), "shape () for a grid of 1 × 1"),
            (
                &[3, 2, 1],
                Some(&[3, 2]),
                "or (6,) in the order of the points",
            ),
            (&[2, 3], None, "points that form no lattice; save it flat"),
        ] {
            let error = ordered(shape, cells).unwrap_err();
            assert!(error.contains(words), "{shape:?}: {error}");
        }
        let error = ordered(&[6, 1], Some(&[3, 2])).unwrap_err();
        assert!(!error.contains("transpose"), "{error}");
    }
}
