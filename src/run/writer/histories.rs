//! Drawings of histories: what the columns of history.csv did over time.

use std::path::Path;

use super::super::columns::{self, AXES};
use super::super::finish::extremes;
use crate::output::{LinePlot, LineStyle, OutputError, Series, Table, lines_svg};
use crate::plan::Plan;

/// Change of the energy, relative to its size, from which on it is worth a drawing.
const NOTABLE: f64 = 1e-3;

/// Draws the columns of `history` that say something into `folder`.
///
/// # Errors
/// Those of [`lines_svg`].
pub(super) fn draw<const D: usize>(
    folder: &Path,
    plan: &Plan,
    history: &Table,
) -> Result<(), OutputError> {
    if history.rows.len() < 2 {
        return Ok(());
    }
    let time = history.column("time_s").unwrap_or_default();
    let over_time = |file: &str, title: &str, quantity: &str, curves: &[Curve]| {
        let curves = series(curves, &time);
        chart(folder, plan, (file, title), ("time [s]", quantity), &curves)
    };
    let pressure = pressures(plan, history);
    let title = "pressure over time";
    over_time("history-pressure.svg", title, "pressure [Pa]", &pressure)?;
    let (name, moved) = displacements::<D>(plan, history);
    let (title, label) = (format!("{name} over time"), format!("{name} [m]"));
    over_time("history-displacement.svg", &title, &label, &moved)?;
    charts(folder, plan, history, &time)?;
    let energy = energy(history);
    let title = "energy over time";
    over_time("history-energy.svg", title, &energy_label(D, plan), &energy)?;
    steps(folder, plan, history, &time)
}

/// Draws how the work went that a scene is about: what was pushed at, and what was pumped in.
fn charts(folder: &Path, plan: &Plan, history: &Table, time: &[f64]) -> Result<(), OutputError> {
    let pushed = pushed(history);
    let walls = pushed
        .iter()
        .map(|(label, motion, force)| line(label, motion, force));
    let labels = (
        "displacement of the side [m]",
        "force that holds it there [N]",
    );
    let walls: Vec<Series<'_>> = walls.collect();
    chart(
        folder,
        plan,
        ("force-displacement.svg", "force and displacement"),
        labels,
        &walls,
    )?;
    let (size, grown) = grown(history);
    for (file, title, label, curves) in [
        (
            "pressure",
            "pressure in cracks",
            "pressure [Pa]",
            crack_pressures(history),
        ),
        ("length", "size of the cracks", size, grown),
        (
            "opening",
            "largest openings of cracks",
            "opening [m]",
            crack_openings(history),
        ),
        (
            "volume",
            "what became of the fluid",
            "volume [m^3]",
            volumes(history),
        ),
    ] {
        let file = format!("history-crack-{file}.svg");
        let curves = series(&curves, time);
        chart(folder, plan, (&file, title), ("time [s]", label), &curves)?;
    }
    Ok(())
}

/// Draws curves over linear axes with their labels; nothing without any.
fn chart(
    folder: &Path,
    plan: &Plan,
    (file, title): (&str, &str),
    (x_label, y_label): (&str, &str),
    series: &[Series<'_>],
) -> Result<(), OutputError> {
    if series.is_empty() {
        return Ok(());
    }
    let plot = LinePlot {
        title: &format!("{}: {title}", plan.title),
        x_label,
        y_label,
        x_log: false,
        y_log: false,
        series,
        note: None,
    };
    lines_svg(folder.join(file), &plot)
}

/// Side and axis, displacement and force of every side that is moved.
fn pushed(history: &Table) -> Vec<(String, Vec<f64>, Vec<f64>)> {
    let wall = |column: &String| {
        let name = column.strip_prefix("motion_")?.strip_suffix("_m")?;
        let force = history.column(&format!("force_{name}_N"))?;
        let label = name.replace('_', ", along ");
        Some((label, history.column(column)?, force))
    };
    history.columns.iter().filter_map(wall).collect()
}

/// Curves of the columns between a start and an end, by what stands between these.
fn between(history: &Table, start: &str, end: &str) -> Vec<Curve> {
    let own = |column: &String| {
        let name = column.strip_prefix(start)?.strip_suffix(end)?;
        Some((name.to_owned(), history.column(column)?))
    };
    history.columns.iter().filter_map(own).collect()
}

fn crack_pressures(history: &Table) -> Vec<Curve> {
    between(history, "crack_pressure_", "_Pa")
}

fn crack_openings(history: &Table) -> Vec<Curve> {
    let mut curves = between(history, "opening_", "_m");
    let flowed = history.column("aperture_max_m");
    curves.extend(flowed.map(|values| ("that fluid flows through".to_owned(), values)));
    curves
}

/// Label of the axis and curve of how far cracks have grown, if they have.
fn grown(history: &Table) -> (&'static str, Vec<Curve>) {
    let columns = [
        ("length [m]", "crack_length_m"),
        ("area [m^2]", "crack_area_m2"),
    ];
    let own = |(label, column): (&'static str, &str)| {
        let values = history
            .column(column)
            .filter(|values| range(values) > 0.0)?;
        Some((label, vec![(String::new(), values)]))
    };
    columns.into_iter().find_map(own).unwrap_or_default()
}

/// What was pumped in, what of it is in cracks, and the rest, which leaked into the pores.
fn volumes(history: &Table) -> Vec<Curve> {
    let column = |name: &str| history.column(name);
    let (Some(injected), Some(held)) = (column("injected_m3"), column("crack_volume_m3")) else {
        return Vec::new();
    };
    if range(&injected) <= 0.0 {
        return Vec::new();
    }
    let leaked = injected.iter().zip(&held).map(|(all, held)| all - held);
    let leaked = (
        "leaked off into pores, or compressed".to_owned(),
        leaked.collect(),
    );
    let mut curves = vec![
        ("pumped in".to_owned(), injected.clone()),
        ("in cracks".to_owned(), held),
        leaked,
    ];
    let void = column("crack_void_m3").filter(|values| range(values) > 0.0);
    curves.extend(void.map(|values| ("cracks not filled yet".to_owned(), values)));
    curves
}

/// The energy of a plane is that of a slab.
fn energy_label(dimension: usize, plan: &Plan) -> String {
    match dimension {
        2 => format!("energy [J], {} m thick", plan.thickness),
        _ => "energy [J]".to_owned(),
    }
}

/// Label and values of a curve.
type Curve = (String, Vec<f64>);

fn series<'a>(curves: &'a [Curve], x: &'a [f64]) -> Vec<Series<'a>> {
    curves.iter().map(|(label, y)| line(label, x, y)).collect()
}

fn line<'a>(label: &'a str, x: &'a [f64], y: &'a [f64]) -> Series<'a> {
    Series {
        label,
        x,
        y,
        style: LineStyle::Line,
    }
}

/// Pressures at the probes, without probes the extremes, and those at the bottoms of wells.
fn pressures(plan: &Plan, history: &Table) -> Vec<Curve> {
    let named = |(label, column): (&str, &str)| Some((label.to_owned(), history.column(column)?));
    let wells = plan.wells.iter().filter_map(|well| {
        let [_, pressure] = columns::of_well(&well.name);
        named((&format!("bottom of {}", well.name), &pressure))
    });
    if plan.output.probes.is_empty() {
        let extremes = [
            ("smallest", "pressure_min_Pa"),
            ("largest", "pressure_max_Pa"),
        ];
        return extremes
            .into_iter()
            .filter_map(named)
            .chain(wells)
            .collect();
    }
    let names = plan.output.probes.iter().map(|probe| &probe.name);
    names
        .filter_map(|name| named((name, &columns::pressure_at(name))))
        .chain(wells)
        .collect()
}

/// Displacements at the probes along the axis on which they move most; without probes the largest.
fn displacements<const D: usize>(plan: &Plan, history: &Table) -> (String, Vec<Curve>) {
    let largest = || {
        let column = history.column("displacement_max_m");
        column.map(|values| ("largest".to_owned(), values))
    };
    let along = |axis: &str| -> Vec<Curve> {
        let column = |name: &String| {
            let values = history.column(&columns::displacement_at(axis, name))?;
            Some((name.clone(), values))
        };
        let names = plan.output.probes.iter().map(|probe| &probe.name);
        names.filter_map(column).collect()
    };
    let span = |curves: &[Curve]| curves.iter().map(|(_, y)| range(y)).fold(0.0, f64::max);
    let mut most: (&str, Vec<Curve>) = ("", Vec::new());
    for axis in &AXES[..D] {
        let curves = along(axis);
        if most.1.is_empty() || span(&curves) > span(&most.1) {
            most = (axis, curves);
        }
    }
    match most {
        (_, curves) if curves.is_empty() => ("displacement".to_owned(), Vec::from_iter(largest())),
        (axis, curves) => (format!("{axis}-displacement"), curves),
    }
}

fn energy(history: &Table) -> Vec<Curve> {
    let notable = |values: &Vec<f64>| {
        let size = values.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
        range(values) > NOTABLE * size
    };
    let column = history.column("energy_J").filter(notable);
    Vec::from_iter(column.map(|values| (String::new(), values)))
}

fn range(values: &[f64]) -> f64 {
    let [low, high] = extremes(values);
    high - low
}

fn steps(folder: &Path, plan: &Plan, history: &Table, time: &[f64]) -> Result<(), OutputError> {
    let steps = history.column("step_s").unwrap_or_default();
    let curve = [("Δt".to_owned(), steps.get(1..).unwrap_or_default().to_vec())];
    let plot = LinePlot {
        title: &format!("{}: time step", plan.title),
        x_label: "time [s]",
        y_label: "Δt [s]",
        x_log: true,
        y_log: true,
        series: &series(&curve, &time[1..]),
        note: None,
    };
    lines_svg(folder.join("history-step.svg"), &plot)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    fn table(columns: &[(&str, [f64; 2])]) -> Table {
        let row = |k: usize| columns.iter().map(|(_, values)| values[k]).collect();
        Table {
            columns: columns.iter().map(|(name, _)| (*name).to_owned()).collect(),
            rows: vec![row(0), row(1)],
        }
    }

    #[test]
    fn an_energy_that_stays_is_not_drawn() {
        assert!(energy(&table(&[("time_s", [0.0, 1.0])])).is_empty());
        assert!(energy(&table(&[("energy_J", [2.0, 2.0001])])).is_empty());
        assert_eq!(energy(&table(&[("energy_J", [2.0, 2.1])])).len(), 1);
    }

    #[test]
    fn probes_are_drawn_along_the_axis_on_which_they_move_most() {
        let plan = super::super::tests::plan(&["output.probes.a.at=[0.5, 0.5]"]);
        let history = table(&[
            ("displacement_max_m", [9.0, 9.0]),
            ("displacement_x_a_m", [5.0, 5.5]),
            ("displacement_y_a_m", [0.0, -1.0]),
        ]);
        let (name, curves) = displacements::<2>(&plan, &history);
        assert_eq!(name, "y-displacement");
        assert_eq!(curves, [("a".to_owned(), vec![0.0, -1.0])]);
    }

    #[test]
    fn what_was_pushed_has_the_force_of_its_own_side() {
        let history = table(&[
            ("motion_top_y_m", [0.0, 1.0]),
            ("force_left_x_N", [7.0, 8.0]),
            ("force_top_y_N", [0.0, 5.0]),
        ]);
        let expected = ("top, along y".to_owned(), vec![0.0, 1.0], vec![0.0, 5.0]);
        assert_eq!(pushed(&history), [expected]);
    }

    /// By hand: of 5 pumped in 2 are in cracks.
    #[test]
    fn what_leaked_off_is_what_is_not_in_cracks() {
        let columns = [("injected_m3", [0.0, 5.0]), ("crack_volume_m3", [0.0, 2.0])];
        let curves = volumes(&table(&columns));
        assert_eq!(
            curves[2],
            (
                "leaked off into pores, or compressed".to_owned(),
                vec![0.0, 3.0]
            )
        );
        assert_eq!(curves.len(), 3);
        let idle = [("injected_m3", [0.0, 0.0]), ("crack_volume_m3", [0.0, 2.0])];
        assert!(volumes(&table(&idle)).is_empty());
    }

    #[test]
    fn cracks_that_do_not_grow_are_not_drawn() {
        assert!(
            grown(&table(&[("crack_length_m", [1.0, 1.0])]))
                .1
                .is_empty()
        );
        let (label, curves) = grown(&table(&[("crack_area_m2", [1.0, 2.0])]));
        assert_eq!((label, curves.len()), ("area [m^2]", 1));
    }

    #[test]
    fn without_probes_the_largest_displacement_is_drawn() {
        let plan = super::super::tests::plan(&[]);
        let history = table(&[("displacement_max_m", [0.0, 9.0])]);
        let (name, curves) = displacements::<2>(&plan, &history);
        assert_eq!((name.as_str(), curves.len()), ("displacement", 1));
        assert!(
            displacements::<2>(&plan, &table(&[("time_s", [0.0, 1.0])]))
                .1
                .is_empty()
        );
    }
}
