//! A run as Python holds it.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use perifrac::prelude::{FieldValues, Interrupt};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::errors::{Fault, raised};
use crate::files::{Files, open};
use crate::loads::{Line, Load, effect};
use crate::recipe::Recipe;
use crate::relay::{Command, Ended, Event, Ground, Reached, Relay};
use crate::worker::{Task, pool, work};

/// Time after which a key that was pressed is heard.
const PATIENCE: Duration = Duration::from_millis(50);

/// Where a run stands.
enum Stand {
    /// It computes: at its start, or up to the next step.
    Runs,
    /// It waits at a state.
    Waits,
    /// It has ended.
    Ended(Box<Ended>),
}

struct Inner {
    commands: Option<Sender<Command>>,
    events: Receiver<Event>,
    thread: Option<JoinHandle<()>>,
    stand: Stand,
    ground: Option<Ground>,
    warnings: Vec<String>,
    /// Rows of the history of states that were reached while the end of a stopped run was awaited.
    late: Vec<Vec<f64>>,
}

/// A run on a thread of its own, which waits after every step.
#[pyclass(frozen)]
pub(crate) struct Session {
    inner: Mutex<Inner>,
    interrupt: Interrupt,
    line: Line,
}

/// Numbers of a step: time, end, step, accepted and rejected steps, iterations, length of cracks.
type Numbers = (f64, f64, f64, u64, u64, usize, Option<f64>);

#[pymethods]
impl Session {
    /// Begins a run, or goes on with one.
    #[new]
    #[pyo3(signature = (recipe, loads, threads=None, files=None))]
    fn new(
        py: Python<'_>,
        recipe: &Recipe,
        loads: Vec<Load>,
        threads: Option<usize>,
        files: Option<Files>,
    ) -> PyResult<Self> {
        let line = Line::default();
        let mut setup = recipe.setup();
        for load in &loads {
            setup = setup.effect(effect(py, load, &line));
        }
        let begin = || {
            let loaded = setup.load()?;
            let plan = setup.plan_of(&loaded)?;
            let pool = pool(threads)?;
            let (writer, from, settings) = open(files, &loaded.resolved_toml())?;
            Ok(Task {
                loaded,
                plan,
                writer,
                settings,
                from,
                pool,
            })
        };
        let task: Result<Task, Fault> = py.detach(begin);
        let (inner, interrupt) = start(raised(py, task)?, &line)?;
        Ok(Session {
            inner: Mutex::new(inner),
            interrupt,
            line,
        })
    }

    /// Lets the run go on to its next state; gives the numbers of the step that led there (none at the start) and the
    /// row of the history, or nothing if the run has ended.
    fn advance(&self, py: Python<'_>) -> PyResult<Option<(Option<Numbers>, Vec<f64>)>> {
        let mut inner = self.hold(py)?;
        inner.go(Command::Step);
        loop {
            match self.next(py, &mut inner)? {
                Event::State(reached) => return Ok(Some(inner.reach(*reached))),
                Event::Ended(ended) => {
                    inner.end(*ended);
                    return self.outcome(py, &inner).map(|()| None);
                }
                event => inner.keep(event),
            }
        }
    }

    /// Lets the run go on to its end without waiting; gives the rows of the history in between.
    fn finish(&self, py: Python<'_>, rows: &Bound<'_, pyo3::types::PyList>) -> PyResult<()> {
        let mut inner = self.hold(py)?;
        inner.go(Command::Run);
        while !matches!(inner.stand, Stand::Ended(_)) {
            match self.next(py, &mut inner)? {
                Event::State(reached) => rows.append(inner.pass(*reached).1)?,
                Event::Ended(ended) => inner.end(*ended),
                event => inner.keep(event),
            }
        }
        self.outcome(py, &inner)
    }

    /// Ends a run that waits as it would end at its end.
    fn enough(&self, py: Python<'_>, rows: &Bound<'_, pyo3::types::PyList>) -> PyResult<()> {
        self.hold(py)?.go(Command::Enough);
        self.finish(py, rows)
    }

    /// Fields of the state at which the run waits or has ended, and their units.
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let mut inner = self.hold(py)?;
        if let Stand::Ended(ended) = &inner.stand {
            return arrays::fields(py, ended.fields.clone());
        }
        let found = self.asked(py, &mut inner)?;
        arrays::fields(py, found)
    }

    /// Dimension, coordinates and edges of the cells, headings of the history; nothing before the first state.
    #[allow(clippy::type_complexity)]
    fn ground<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(usize, Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<String>)>> {
        let inner = self.hold(py)?;
        let Some(ground) = &inner.ground else {
            return Ok(None);
        };
        let array = |values: &Vec<f64>| arrays::array(py, values.clone(), ground.dimension);
        let (positions, cells) = (array(&ground.positions)?, array(&ground.cells)?);
        Ok(Some((
            ground.dimension,
            positions,
            cells,
            ground.columns.clone(),
        )))
    }

    /// The summary of a run that has ended, as JSON.
    fn summary(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let inner = self.hold(py)?;
        match &inner.stand {
            Stand::Ended(ended) => Ok(match &ended.result {
                Some(Ok(summary)) => Some(summary.clone()),
                _ => None,
            }),
            _ => Ok(None),
        }
    }

    /// Time of the last state of a run that has ended, s.
    fn end_time(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        match &self.hold(py)?.stand {
            Stand::Ended(ended) => Ok(Some(ended.time)),
            _ => Ok(None),
        }
    }

    /// Warnings since this was asked last.
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(std::mem::take(&mut self.hold(py)?.warnings))
    }

    /// Rows of the history since this was asked last that a stopped run reached before its end.
    fn late(&self, py: Python<'_>) -> PyResult<Vec<Vec<f64>>> {
        Ok(std::mem::take(&mut self.hold(py)?.late))
    }

    /// Asks the run to stop as soon as it can, from any thread.
    fn interrupt(&self) {
        self.interrupt.raise();
    }

    /// Stops the run, if it still goes on, and waits for its thread.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.interrupt.raise();
        let mut inner = self.hold(py)?;
        inner.commands = None;
        let thread = inner.thread.take();
        py.detach(|| thread.map(JoinHandle::join));
        Ok(())
    }
}

impl Session {
    fn hold(&self, py: Python<'_>) -> PyResult<std::sync::MutexGuard<'_, Inner>> {
        match self.inner.try_lock() {
            Ok(inner) => Ok(inner),
            Err(std::sync::TryLockError::Poisoned(poisoned)) => {
                Ok(PoisonError::into_inner(poisoned))
            }
            Err(std::sync::TryLockError::WouldBlock) => {
                let message = "another thread waits for this run; one thread at a time may step it";
                Err(Fault::new("StateError", message).raise(py))
            }
        }
    }

    /// The next thing that the run tells. Where the user presses Ctrl-C meanwhile, the run is stopped and its end
    /// awaited, so that its state is kept.
    fn next(&self, py: Python<'_>, inner: &mut Inner) -> PyResult<Event> {
        loop {
            // Also where the run tells so much that there is nothing to wait for.
            if let Err(pressed) = py.check_signals() {
                self.interrupt.raise();
                inner.drain(py);
                return Err(pressed);
            }
            let events = &mut inner.events;
            match py.detach(move || events.recv_timeout(PATIENCE)) {
                Ok(event) => return Ok(event),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Fault::new("StateError", "the run has ended").raise(py));
                }
            }
        }
    }

    fn asked(&self, py: Python<'_>, inner: &mut Inner) -> PyResult<Vec<FieldValues>> {
        if !matches!(inner.stand, Stand::Waits) {
            let message = "the run has no state yet; let it step first";
            return Err(Fault::new("StateError", message).raise(py));
        }
        inner.tell(Command::Fields);
        loop {
            match self.next(py, inner)? {
                Event::Fields(fields) => return Ok(fields),
                event => inner.keep(event),
            }
        }
    }

    /// Raises what the run ended with, unless it ended well. What a load in Python raised comes first.
    fn outcome(&self, py: Python<'_>, inner: &Inner) -> PyResult<()> {
        if let Some(error) = self.line.take() {
            return Err(error);
        }
        match &inner.stand {
            Stand::Ended(ended) => match &ended.result {
                Some(Err(fault)) => Err(fault.raise(py)),
                _ => Ok(()),
            },
            _ => Ok(()),
        }
    }
}

impl Inner {
    /// Gives a command where the run waits for one.
    fn go(&mut self, command: Command) {
        match self.stand {
            Stand::Waits => self.stand = Stand::Runs,
            // At its start it takes the command at its first state.
            Stand::Runs if command != Command::Step => {}
            _ => return,
        }
        self.tell(command);
    }

    /// A run that is gone is told of by its last event.
    fn tell(&self, command: Command) {
        if let Some(commands) = &self.commands {
            let _ = commands.send(command);
        }
    }

    /// Takes in a state at which the run does not wait.
    fn pass(&mut self, reached: Reached) -> (Option<Numbers>, Vec<f64>) {
        if reached.ground.is_some() {
            self.ground = reached.ground;
        }
        let numbers = reached.progress.map(|now| {
            let effort = (now.steps, now.rejected, now.iterations);
            let (steps, rejected, iterations) = effort;
            (
                now.time,
                now.end,
                now.dt,
                steps,
                rejected,
                iterations,
                now.crack_length,
            )
        });
        (numbers, reached.row)
    }

    /// Takes in a state at which it waits.
    fn reach(&mut self, reached: Reached) -> (Option<Numbers>, Vec<f64>) {
        self.stand = Stand::Waits;
        self.pass(reached)
    }

    /// Takes in the end.
    fn end(&mut self, ended: Ended) {
        if ended.ground.is_some() {
            self.ground.clone_from(&ended.ground);
        }
        self.stand = Stand::Ended(Box::new(ended));
        // A thread that has told its end needs no waiting for.
        self.thread = None;
        self.commands = None;
    }

    fn keep(&mut self, event: Event) {
        match event {
            Event::Warning(message) => self.warnings.push(message),
            Event::Ended(ended) => self.end(*ended),
            Event::State(_) | Event::Fields(_) => {}
        }
    }

    /// Waits for the end of a run that was stopped.
    fn drain(&mut self, py: Python<'_>) {
        self.commands = None;
        while !matches!(self.stand, Stand::Ended(_)) {
            let events = &mut self.events;
            match py.detach(move || events.recv()) {
                Ok(Event::State(reached)) => {
                    let (_, row) = self.pass(*reached);
                    self.late.push(row);
                }
                Ok(event) => self.keep(event),
                Err(_) => self.end(Ended::default()),
            }
        }
    }
}

/// Starts the thread of a run.
fn start(task: Task, line: &Line) -> PyResult<(Inner, Interrupt)> {
    let (commands, orders) = channel();
    let (told, events) = channel();
    let interrupt = line.interrupt.clone();
    let relay = Relay::new(told, orders, interrupt.clone());
    let own = interrupt.clone();
    let named = std::thread::Builder::new().name("perifrac".to_owned());
    let thread = named.spawn(move || work(task, relay, &own))?;
    let inner = Inner {
        commands: Some(commands),
        events,
        thread: Some(thread),
        stand: Stand::Runs,
        ground: None,
        warnings: Vec::new(),
        late: Vec::new(),
    };
    Ok((inner, interrupt))
}
