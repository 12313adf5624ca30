//! What stands in the tables of a run: every column with its unit and meaning, once.
//!
//! `perifrac schema --columns` prints the list, the book shows it, and a summary tells which of them a run has written.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Name;
use crate::geometry::Side;
use crate::output::{History, OutputError};

/// A column of a table, or several whose names differ by a name of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Column {
    /// Name of the file, in which NAME is that of a profile or crack.
    pub file: &'static str,
    /// Heading. PROBE, CRACK and WELL stand for names of the scene, SIDE for `left` … `back`, AXIS for `x`, `y` or `z`,
    /// NUMBER for a number from 1.
    pub name: &'static str,
    /// Unit; `1` for a plain number, empty for text.
    pub unit: &'static str,
    /// What a scene must have for it.
    pub with: &'static str,
    /// What it tells.
    pub meaning: &'static str,
}

impl Column {
    /// A column from its words, in the order of the fields.
    pub(crate) const fn new(
        file: &'static str,
        name: &'static str,
        unit: &'static str,
        with: &'static str,
        meaning: &'static str,
    ) -> Self {
        Column {
            file,
            name,
            unit,
            with,
            meaning,
        }
    }
}

/// A column as a run has written it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct WrittenColumn {
    /// Name of the file.
    pub file: String,
    /// Heading.
    pub name: String,
    /// Unit; `1` for a plain number.
    pub unit: Name,
    /// What it tells.
    pub meaning: Name,
}

const HISTORY: &str = "history.csv";
const PROFILE: &str = "profile-NAME.csv";
const CRACK: &str = "crack-NAME.csv";

/// All columns, in the order in which they are written. Of two that a heading fits, the first one is meant.
#[rustfmt::skip] // one a line, as the table that it is
pub const COLUMNS: &[Column] = &[
    Column::new(HISTORY, "time_s", "s", "always", "time"),
    Column::new(HISTORY, "stage", "1", "stages", "number of the stage, from 1; only in the file above the stages"),
    Column::new(HISTORY, "step_s", "s", "always", "length of the step that ended here; 0 at the start"),
    Column::new(HISTORY, "iterations", "1", "always", "iterations of linear solvers or of relaxation in the step; a direct solver counts none, or one"),
    Column::new(HISTORY, "pressure_min_Pa", "Pa", "flow", "smallest pressure of all points"),
    Column::new(HISTORY, "pressure_max_Pa", "Pa", "flow", "largest pressure of all points"),
    Column::new(HISTORY, "pressure_PROBE_Pa", "Pa", "flow", "pressure at a probe"),
    Column::new(HISTORY, "displacement_max_m", "m", "mechanics", "length of the largest displacement"),
    Column::new(HISTORY, "displacement_AXIS_PROBE_m", "m", "mechanics", "displacement of a probe along an axis"),
    Column::new(HISTORY, "plate_SIDE_m", "m", "a `plate`", "how far the plate has moved along the axis that it is normal to"),
    Column::new(HISTORY, "opening_CRACK_m", "m", "cracks", "largest opening along a crack"),
    Column::new(HISTORY, "motion_SIDE_AXIS_m", "m", "damage, a side that is moved", "displacement of the side"),
    Column::new(HISTORY, "force_SIDE_AXIS_N", "N", "damage, a side that is moved", "force that holds it there"),
    Column::new(HISTORY, "crack_pressure_CRACK_Pa", "Pa", "damage, a crack with `pressure` or `injection`", "that pressure, or the one where fluid is pumped in"),
    Column::new(HISTORY, "crack_length_m", "m", "damage, in a plane", "length of the cracks from the start and of what broke since"),
    Column::new(HISTORY, "crack_area_m2", "m^2", "damage, in space", "area of the cracks from the start and of what broke since"),
    Column::new(HISTORY, "dissipated_J", "J", "damage", "energy that damage took"),
    Column::new(HISTORY, "aperture_max_m", "m", "fracture flow", "largest opening that fluid flows through"),
    Column::new(HISTORY, "crack_volume_m3", "m^3", "fracture flow, split model", "fluid in cracks"),
    Column::new(HISTORY, "crack_void_m3", "m^3", "fracture flow, split model", "what cracks have opened and fluid has not filled yet"),
    Column::new(HISTORY, "energy_J", "J", "mechanics", "energy in the rock and, with coupling, in the fluid: ½ uᵀKu + ½ pᵀSp"),
    Column::new(HISTORY, "potential_J", "J", "mechanics", "the energy less the work of the loads that act now"),
    Column::new(HISTORY, "kinetic_J", "J", "dynamic", "kinetic energy"),
    Column::new(HISTORY, "work_J", "J", "dynamic", "work of loads, fluid and walls since the start"),
    Column::new(HISTORY, "energy_balance", "1", "dynamic", "energy from nowhere over the largest energy so far"),
    Column::new(HISTORY, "momentum_balance", "1", "mechanics", "forces out of balance over all forces"),
    Column::new(HISTORY, "outflow_SIDE_m3_per_s", "m^3/s", "flow", "rate out through a side at the time of the row"),
    Column::new(HISTORY, "outflow_region_NUMBER_m3_per_s", "m^3/s", "`flow.regions`", "rate out where a region holds a pressure, mean over the step"),
    Column::new(HISTORY, "outflow_crack_CRACK_m3_per_s", "m^3/s", "flow, a crack with `pressure`", "rate out at that crack, mean over the step"),
    Column::new(HISTORY, "well_rate_WELL_m3_per_s", "m^3/s", "a well with `wellbore_radius`", "its rate at the time of the row, for the whole plane as in the scene"),
    Column::new(HISTORY, "well_pressure_WELL_Pa", "Pa", "a well with `wellbore_radius`", "its bottom-hole pressure"),
    Column::new(HISTORY, "injected_m3", "m^3", "flow", "brought in by wells, sources and fluxes since the start, net"),
    Column::new(HISTORY, "fixed_m3", "m^3", "flow", "brought in where points have a prescribed pressure, net"),
    Column::new(HISTORY, "outflow_m3", "m^3", "flow", "gone out through sides of prescribed pressure, net"),
    Column::new(HISTORY, "stored_m3", "m^3", "flow", "gain of what the rock stores"),
    Column::new(HISTORY, "injected_m3_per_s", "m^3/s", "flow, steady", "rate brought in by wells, sources and fluxes, net"),
    Column::new(HISTORY, "fixed_m3_per_s", "m^3/s", "flow, steady", "rate brought in where points have a prescribed pressure, net"),
    Column::new(HISTORY, "outflow_m3_per_s", "m^3/s", "flow, steady", "rate out through sides of prescribed pressure, net"),
    Column::new(HISTORY, "stored_m3_per_s", "m^3/s", "flow, steady", "rate at which what the rock stores grows"),
    Column::new(HISTORY, "mass_balance", "1", "flow", "fluid lost or made over everything that moved"),
    Column::new(HISTORY, "rejected_error", "1", "always", "steps rejected so far because of their error"),
    Column::new(HISTORY, "rejected_growth", "1", "always", "steps rejected so far because damage grew too much"),
    Column::new(HISTORY, "rejected_solver", "1", "always", "steps rejected so far because a solver or relaxation failed"),
    Column::new(HISTORY, "rejected_coupling", "1", "always", "steps rejected so far because flow, mechanics and damage did not agree"),
    Column::new(HISTORY, "rejected_balance", "1", "always", "steps rejected so far because a balance did not close"),
    Column::new(PROFILE, "time_s", "s", "always", "time of the output"),
    Column::new(PROFILE, "distance_m", "m", "always", "distance from the start of the line"),
    Column::new(PROFILE, "pressure_Pa", "Pa", "flow", "pressure"),
    Column::new(PROFILE, "pressure_exact_Pa", "Pa", "flow, a reference", "exact pressure"),
    Column::new(PROFILE, "displacement_AXIS_m", "m", "mechanics", "displacement along an axis"),
    Column::new(PROFILE, "displacement_AXIS_exact_m", "m", "mechanics, a reference", "exact displacement"),
    Column::new(CRACK, "time_s", "s", "always", "time of the output"),
    Column::new(CRACK, "distance_m", "m", "always", "distance along the crack"),
    Column::new(CRACK, "opening_m", "m", "always", "distance of the faces across the crack; of a damaged crack by the displacements of the rock beyond the broken points, continued to the crack with their gradients"),
    Column::new(CRACK, "sliding_m", "m", "always", "distance of the faces along it"),
    Column::new(CRACK, "opening_exact_m", "m", "a reference", "exact opening"),
];

/// The columns of a table of a run.
///
/// # Errors
/// [`OutputError`] if its heading cannot be read.
pub(crate) fn written(path: &Path) -> Result<Vec<WrittenColumn>, OutputError> {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let kind = [PROFILE, CRACK].into_iter().find(|kind| {
        let start = kind.split("NAME").next().unwrap_or(kind);
        file.starts_with(start)
    });
    let columns = History::columns(path)?.into_iter();
    let told = columns.map(|name| {
        let known = described(kind.unwrap_or(HISTORY), &name);
        debug_assert!(known.is_some(), "{file}: {name} is not among COLUMNS");
        WrittenColumn {
            file: file.to_string(),
            unit: known.map_or("", |own| own.unit).into(),
            meaning: known.map_or("", |own| own.meaning).into(),
            name,
        }
    });
    Ok(told.collect())
}

/// The column of a kind of file that a heading belongs to.
fn described(file: &str, heading: &str) -> Option<&'static Column> {
    let words: Vec<&str> = heading.split('_').collect();
    let own = COLUMNS.iter().filter(|column| column.file == file);
    own.into_iter().find(|column| {
        let pattern: Vec<&str> = column.name.split('_').collect();
        fits(&pattern, &words)
    })
}

/// Whether words of a heading are those of a pattern; a name of the scene may be several of them.
fn fits(pattern: &[&str], words: &[&str]) -> bool {
    let Some((first, rest)) = pattern.split_first() else {
        return words.is_empty();
    };
    let one = |word: &str| match *first {
        "SIDE" => Side::all(3).any(|side| side.name() == word),
        "AXIS" => super::columns::AXES.contains(&word),
        "NUMBER" => word.parse::<u64>().is_ok(),
        plain => plain == word,
    };
    match *first {
        "PROBE" | "CRACK" | "WELL" => (1..=words.len()).any(|count| fits(rest, &words[count..])),
        _ => words
            .split_first()
            .is_some_and(|(word, others)| one(word) && fits(rest, others)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A heading that belongs to a pattern.
    fn example(column: &Column) -> String {
        let stand = |word: &str| {
            match word {
                "SIDE" => "back",
                "AXIS" => "y",
                "NUMBER" => "12",
                "PROBE" | "CRACK" | "WELL" => "north_2-a",
                plain => plain,
            }
            .to_owned()
        };
        let words: Vec<String> = column.name.split('_').map(stand).collect();
        words.join("_")
    }

    #[test]
    fn no_column_hides_another() {
        for column in COLUMNS {
            assert_eq!(described(column.file, &example(column)), Some(column));
        }
    }

    #[test]
    fn a_heading_ends_in_its_unit() {
        for column in COLUMNS {
            let unit = column.unit.replace('^', "").replace('/', "_per_");
            let told = column.name.ends_with(&format!("_{unit}"));
            assert_eq!(told, column.unit != "1", "{column:?}");
        }
    }

    #[test]
    fn headings_of_other_files_and_other_words_are_not_known() {
        for (file, heading) in [
            (HISTORY, "opening_m"),
            (CRACK, "opening_main_m"),
            (HISTORY, "outflow_above_m3_per_s"),
            (HISTORY, "outflow_region_one_m3_per_s"),
            (HISTORY, "opening__Pa"),
            (HISTORY, "plate__m"),
            (PROFILE, "displacement_w_m"),
            (HISTORY, ""),
        ] {
            assert_eq!(described(file, heading), None, "{file} {heading}");
        }
    }
}
