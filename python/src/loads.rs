//! Sources and forces that are functions in Python.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use perifrac::prelude::{Effect, Interrupt, OwnEffect, Points};
use pyo3::prelude::*;

use crate::arrays::array;
use crate::errors::Fault;

/// Function, whether it acts on the rock, name, breakpoints, and whether it is the same at all times.
pub(crate) type Load = (Py<PyAny>, bool, String, Vec<f64>, bool);

/// What the functions of a run share: the first exception that one of them raised, and what stops the run then.
#[derive(Clone, Default)]
pub(crate) struct Line {
    raised: Arc<Mutex<Option<PyErr>>>,
    pub(crate) interrupt: Interrupt,
}

impl Line {
    /// Takes the exception, if one was raised.
    pub(crate) fn take(&self) -> Option<PyErr> {
        lock(&self.raised).take()
    }

    fn fail(&self, error: PyErr) {
        lock(&self.raised).get_or_insert(error);
        self.interrupt.raise();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A load of Python as an effect of the program.
pub(crate) fn effect(py: Python<'_>, load: &Load, line: &Line) -> OwnEffect {
    let (function, on_solid, name, breakpoints, constant) = load;
    let (function, name, line) = (function.clone_ref(py), interned(name), line.clone());
    let (breakpoints, constant, on_solid) = (breakpoints.clone(), *constant, *on_solid);
    let build = move |points: &Points<'_>| {
        let per_point = if on_solid { points.dimension } else { 1 };
        let size = points.volume.len();
        let seen = Python::attach(|py| {
            seen_points(py, points).map(|seen| (function.clone_ref(py), seen.unbind()))
        });
        Callback {
            name,
            call: seen.map_err(|error| line.fail(error)).ok(),
            line: line.clone(),
            shape: [size, per_point],
            on_solid,
            breakpoints: breakpoints.clone(),
            constant,
            recent: Mutex::default(),
        }
    };
    match on_solid {
        true => OwnEffect::on_solid(build),
        false => OwnEffect::on_flow(build),
    }
}

/// The points as the function is handed them.
fn seen_points<'py>(py: Python<'py>, points: &Points<'_>) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("perifrac._loads")?.getattr("Points")?;
    let position = array(py, points.position.to_vec(), points.dimension)?;
    class.call1((position, array(py, points.volume.to_vec(), 1)?))
}

/// Effects are called by names that live as long as the program.
fn interned(name: &str) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = lock(&NAMES);
    if let Some(known) = names.get(name) {
        return known;
    }
    let known: &'static str = Box::leak(name.to_owned().into_boxed_str());
    names.insert(known);
    known
}

/// Values at one time.
struct Rates {
    values: Vec<f64>,
    total: f64,
    gross: f64,
}

/// Times of which the values are kept: stages and balances of a step ask for the same ones again.
const KEPT: usize = 6;

struct Callback {
    name: &'static str,
    /// The function and the points.
    call: Option<(Py<PyAny>, Py<PyAny>)>,
    line: Line,
    /// Points, and values per point.
    shape: [usize; 2],
    on_solid: bool,
    breakpoints: Vec<f64>,
    constant: bool,
    recent: Mutex<Vec<(u64, Arc<Rates>)>>,
}

impl Callback {
    fn at(&self, time: f64) -> Arc<Rates> {
        let key = if self.constant { 0 } else { time.to_bits() };
        if let Some((_, known)) = lock(&self.recent).iter().find(|(at, _)| *at == key) {
            return known.clone();
        }
        let values = self.ask(time).unwrap_or_else(|error| {
            self.line.fail(error);
            // A step with these is not accepted.
            vec![f64::NAN; self.shape[0] * self.shape[1]]
        });
        let rates = Arc::new(Rates {
            total: values.iter().sum(),
            gross: values.iter().map(|rate| rate.abs()).sum(),
            values,
        });
        let mut recent = lock(&self.recent);
        recent.push((key, rates.clone()));
        if recent.len() > KEPT {
            recent.remove(0);
        }
        rates
    }

    fn ask(&self, time: f64) -> PyResult<Vec<f64>> {
        Python::attach(|py| {
            let Some((function, points)) = &self.call else {
                return Ok(vec![0.0; self.shape[0] * self.shape[1]]);
            };
            let found = function.bind(py).call1((time, points))?;
            let check = py.import("perifrac._loads")?.getattr("as_rates")?;
            let found = check.call1((found, self.shape, self.on_solid, self.name, time))?;
            let found: PyReadonlyArrayDyn<'_, f64> = found.extract()?;
            match found.len() == self.shape[0] * self.shape[1] {
                true => Ok(found.as_slice()?.to_vec()),
                false => Err(Fault::new("LoadError", "another number of values").raise(py)),
            }
        })
    }
}

impl Effect for Callback {
    fn name(&self) -> &'static str {
        self.name
    }

    fn add_rate(&self, time: f64, rate: &mut [f64]) {
        let own = self.at(time);
        rate.iter_mut()
            .zip(&own.values)
            .for_each(|(rate, own)| *rate += own);
    }

    fn injection(&self, time: f64) -> f64 {
        match self.on_solid {
            true => 0.0,
            false => self.at(time).total,
        }
    }

    fn gross(&self, time: f64) -> f64 {
        match self.on_solid {
            true => 0.0,
            false => self.at(time).gross,
        }
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.breakpoints.clone()
    }

    fn is_constant(&self) -> bool {
        self.constant
    }

    fn bytes(&self) -> usize {
        KEPT * self.shape[0] * self.shape[1] * size_of::<f64>()
    }
}
