//! What a program may ask of a state while a run goes on: its row of history and its fields.

use super::time_loop::Run;
use super::{columns, writer};
use crate::model::Model;
use crate::plan::Plan;
use crate::report::Balance;
use crate::schemes::{State, StepReport};

use super::fracture::Fractures;
use super::rejections::Rejections;

/// A field as the files of an output have it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FieldValues {
    /// Name, such as `pressure`.
    pub name: &'static str,
    /// SI unit; empty for pure numbers.
    pub unit: &'static str,
    /// Values per point.
    pub components: usize,
    /// Values point by point. Shape `(n·components,)`.
    pub values: Vec<f64>,
}

/// A state of a run; what is asked of it is worked out then, and nothing else. Of several processes each knows
/// the fields at its own points.
///
/// ```
/// use perifrac::prelude::*;
///
/// /// Keeps one column of the history.
/// struct Largest(Vec<f64>);
///
/// impl Observer for Largest {
///     fn look(&mut self, view: &dyn View) {
///         let columns = view.columns();
///         let place = columns.iter().position(|name| name == "pressure_max_Pa");
///         self.0.extend(place.map(|place| view.row()[place]));
///     }
/// }
///
/// # let scene = r#"
/// #     title = "A square that drains to the left"
/// #     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
/// #     fluid.viscosity = "1 mPa s"
/// #     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
/// #     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
/// #     time.end = "1 s"
/// # "#;
/// let plan = Setup::text(scene).plan()?;
/// let mut largest = Largest(Vec::new());
/// let interrupt = Interrupt::default();
/// let (summary, _) = run_job(&plan, Job::new(&mut largest, &interrupt))?;
/// assert_eq!(largest.0.len() as u64, summary.steps + 1);
/// assert!(largest.0.is_sorted_by(|a, b| a >= b));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait View {
    /// Time, s.
    fn time(&self) -> f64;
    /// 2 or 3.
    fn dimension(&self) -> usize;
    /// Coordinates point by point, m. Shape `(n·D,)`.
    fn positions(&self) -> Vec<f64>;
    /// Edges of the cell of each point, m. Shape `(n·D,)`.
    fn cells(&self) -> Vec<f64>;
    /// Headings of history.csv.
    fn columns(&self) -> Vec<String>;
    /// Values under them.
    fn row(&self) -> Vec<f64>;
    /// The fields that the scene calls for, in the order of the files.
    fn fields(&self) -> Vec<FieldValues>;
}

/// The state of a run with what its row needs.
struct Seen<'a, const D: usize> {
    plan: &'a Plan,
    model: &'a Model<D>,
    state: &'a State,
    step: &'a (f64, StepReport),
    rejections: Rejections,
    balance: &'a Balance,
    fractures: Option<&'a Fractures>,
}

impl<const D: usize> View for Seen<'_, D> {
    fn time(&self) -> f64 {
        self.state.time
    }

    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<f64> {
        self.model.cloud.flat_positions()
    }

    fn cells(&self) -> Vec<f64> {
        let cells = self.model.cloud.cell.iter();
        cells.flat_map(|cell| cell.iter().copied()).collect()
    }

    fn columns(&self) -> Vec<String> {
        columns::names::<D>(self.plan)
    }

    fn row(&self) -> Vec<f64> {
        let (dt, report) = self.step;
        columns::row(
            self.plan,
            self.model,
            self.state,
            (*dt, report, self.rejections),
            self.balance,
            self.fractures,
        )
    }

    fn fields(&self) -> Vec<FieldValues> {
        writer::field_values(self.model, self.state)
    }
}

impl<const D: usize> Run<'_, D> {
    /// Lets the observer look at the state.
    pub(super) fn show(&mut self) {
        self.show_to(false);
    }

    /// The same at the end of the run.
    pub(super) fn show_end(&mut self) {
        self.show_to(true);
    }

    fn show_to(&mut self, end: bool) {
        let seen = Seen {
            plan: self.plan,
            model: &self.model,
            state: &self.state,
            step: &self.last_step,
            rejections: self.rejections,
            balance: &self.balance,
            fractures: self.tracker.last.as_ref(),
        };
        match end {
            true => self.observer.end(&seen),
            false => self.observer.look(&seen),
        }
    }
}
