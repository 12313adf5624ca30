//! Named columns: which column is which quantity, with its unit checked.

use std::path::{Path, PathBuf};

use super::FileError;

/// Endings of names that are units of length, area, volume, permeability or other properties of rock. Other endings belong
/// to other quantities: `x_velocity` is no `x`.
const UNITS: [&str; 49] = [
    "m", "mm", "cm", "dm", "km", "um", "nm", "ft", "in", "m2", "mm2", "cm2", "dm2", "km2", "um2",
    "ft2", "in2", "m3", "mm3", "cm3", "dm3", "km3", "ft3", "in3", "l", "D", "mD", "md", "uD",
    "darcy", "Pa", "kPa", "MPa", "GPa", "bar", "psi", "ksi", "Mpsi", "1/Pa", "1/kPa", "1/MPa",
    "1/GPa", "1/bar", "1/psi", "J/m2", "kJ/m2", "kg/m3", "g/cm3", "t/m3",
];

/// The names of the columns (or arrays) of a file.
#[derive(Debug)]
pub(super) struct Columns<'a> {
    path: &'a Path,
    kind: &'static str,
    names: Vec<String>,
}

impl<'a> Columns<'a> {
    /// Takes the names as they stand in the file; `kind` is what messages call a column.
    ///
    /// # Errors
    /// [`FileError::DuplicateColumn`] if a name stands there twice.
    pub(super) fn new(
        path: &'a Path,
        kind: &'static str,
        names: Vec<String>,
    ) -> Result<Self, FileError> {
        for (index, name) in names.iter().enumerate() {
            if !name.is_empty() && names[..index].contains(name) {
                return Err(duplicate(path, name, name));
            }
        }
        Ok(Self { path, kind, names })
    }

    /// The names in the order of the file.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Finds a quantity: a column with its name, or its name and unit as in `x_m`.
    ///
    /// # Errors
    /// [`FileError::WrongUnit`] for another unit, [`FileError::DuplicateColumn`] if both `x` and
    /// `x_m` are there.
    pub(super) fn find(
        &self,
        quantity: &str,
        unit: Option<&'static str>,
    ) -> Result<Option<usize>, FileError> {
        let mut found: Option<usize> = None;
        for (index, name) in self.names.iter().enumerate() {
            let Some(rest) = name.strip_prefix(quantity) else {
                continue;
            };
            let suffix = rest.strip_prefix('_');
            match (suffix, unit) {
                (Some(suffix), Some(unit)) if suffix == unit => {}
                (Some(suffix), Some(unit)) if UNITS.contains(&suffix) => {
                    return Err(self.wrong_unit(name, suffix, unit));
                }
                _ if rest.is_empty() => {}
                _ => continue,
            }
            if let Some(first) = found {
                return Err(duplicate(self.path, &self.names[first], name));
            }
            found = Some(index);
        }
        Ok(found)
    }

    /// Like [`Columns::find`], for a quantity that must be there.
    ///
    /// # Errors
    /// Those of [`Columns::find`], and [`FileError::MissingColumn`].
    pub(super) fn need(
        &self,
        quantity: &str,
        unit: Option<&'static str>,
    ) -> Result<usize, FileError> {
        self.find(quantity, unit)?
            .ok_or_else(|| self.missing(&[quantity]))
    }

    /// Fails if the column's name ends in a unit other than `unit`.
    pub(super) fn check_unit(&self, index: usize, unit: &'static str) -> Result<(), FileError> {
        let name = &self.names[index];
        match name.rsplit_once('_') {
            Some((_, suffix)) if suffix != unit && UNITS.contains(&suffix) => {
                Err(self.wrong_unit(name, suffix, unit))
            }
            _ => Ok(()),
        }
    }

    /// The error for columns that are not there, with the closest names.
    pub(super) fn missing(&self, wanted: &[&str]) -> FileError {
        let guesses: Vec<String> = wanted
            .iter()
            .filter_map(|name| Some(format!("`{}` for `{name}`", self.closest(name)?)))
            .collect();
        let separator = self
            .names
            .iter()
            .find_map(|name| name.find([';', '\t']).map(|_| name));
        let remedy = match (separator, guesses.is_empty()) {
            (Some(_), _) => "separate the columns by commas".to_owned(),
            (None, true) => format!("add the {}", self.kind),
            (None, false) => format!("did you mean {}?", guesses.join(", ")),
        };
        FileError::MissingColumn {
            path: self.path.to_path_buf(),
            kind: self.kind,
            missing: list(wanted.iter().copied()),
            found: self.listed(),
            remedy,
        }
    }

    /// All names, quoted, for messages.
    pub(super) fn listed(&self) -> String {
        list(self.names.iter().map(String::as_str))
    }

    /// A unit that was forgotten is no misspelling, so that names count without their unit too.
    fn closest(&self, wanted: &str) -> Option<&str> {
        let lower = wanted.to_lowercase();
        let allowed = match lower.chars().count() {
            0..=1 => 0,
            2..=4 => 1,
            5..=8 => 3,
            _ => 4,
        };
        let distance = |name: &str| strsim::damerau_levenshtein(&lower, &name.to_lowercase());
        self.names
            .iter()
            .filter(|name| !name.is_empty())
            .map(|name| {
                let bare = name
                    .rsplit_once('_')
                    .map_or(name.as_str(), |(bare, _)| bare);
                (distance(name).min(distance(bare)), name.as_str())
            })
            .filter(|&(letters, _)| letters <= allowed)
            .min_by_key(|&(letters, _)| letters)
            .map(|(_, name)| name)
    }

    fn wrong_unit(&self, column: &str, unit: &str, expected: &'static str) -> FileError {
        let name = column
            .strip_suffix(unit)
            .and_then(|bare| bare.strip_suffix('_'));
        FileError::WrongUnit {
            path: self.path.to_path_buf(),
            column: column.to_owned(),
            name: name.unwrap_or(column).to_owned(),
            unit: unit.to_owned(),
            expected,
        }
    }
}

fn duplicate(path: &Path, first: &str, second: &str) -> FileError {
    let path: PathBuf = path.to_path_buf();
    FileError::DuplicateColumn {
        path,
        first: first.to_owned(),
        second: second.to_owned(),
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if quoted.is_empty() {
        "none".to_owned()
    } else {
        quoted.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(names: &[&str]) -> Result<Columns<'static>, FileError> {
        let names = names.iter().map(|&name| name.to_owned()).collect();
        Columns::new(Path::new("points.csv"), "column", names)
    }

    #[test]
    fn the_si_unit_is_part_of_the_name_and_other_quantities_are_not() {
        let columns = columns(&["x_velocity", "y", "x_m", "xy"]).unwrap();
        assert_eq!(columns.find("x", Some("m")).unwrap(), Some(2));
        assert_eq!(columns.find("y", Some("m")).unwrap(), Some(1));
        assert_eq!(columns.find("z", Some("m")).unwrap(), None);
    }

    #[test]
    fn millimetres_and_millidarcys_are_refused() {
        let columns = columns(&["x_mm", "permeability_mD", "volume_m3"]).unwrap();
        for (quantity, unit) in [("x", "m"), ("permeability", "m2"), ("volume", "m2")] {
            let error = columns.find(quantity, Some(unit)).unwrap_err();
            assert!(matches!(error, FileError::WrongUnit { .. }), "{error}");
            assert!(
                error.to_string().contains(&format!("`{quantity}_{unit}`")),
                "{error}"
            );
        }
    }

    #[test]
    fn a_quantity_given_twice_is_refused() {
        assert!(columns(&["x", "y", "x"]).is_err());
        let twice = columns(&["x", "x_m"]).unwrap();
        let error = twice.find("x", Some("m")).unwrap_err();
        assert!(
            matches!(error, FileError::DuplicateColumn { .. }),
            "{error}"
        );
        assert!(columns(&["x", "", ""]).is_ok());
    }

    #[test]
    fn a_misspelt_column_is_suggested() {
        let error = columns(&["x", "Volumn_m2"])
            .unwrap()
            .missing(&["volume"])
            .to_string();
        assert!(
            error.contains("did you mean `Volumn_m2` for `volume`?"),
            "{error}"
        );
        let error = columns(&["x;y;volume"])
            .unwrap()
            .missing(&["x"])
            .to_string();
        assert!(error.contains("separate the columns by commas"), "{error}");
    }
}
