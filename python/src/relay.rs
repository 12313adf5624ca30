//! What the thread of a run and the interpreter tell each other.

use std::sync::mpsc::{Receiver, Sender};

use perifrac::prelude::{FieldValues, Interrupt, Observer, Progress, View};

use crate::errors::Fault;

/// What the run is told while it waits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Command {
    /// One step more.
    Step,
    /// On to the end, without waiting any more.
    Run,
    /// This is the end.
    Enough,
    /// The fields of this state.
    Fields,
}

/// What the run tells.
pub(crate) enum Event {
    /// A state was reached.
    State(Box<Reached>),
    /// The fields of that state.
    Fields(Vec<FieldValues>),
    /// A doubt arose.
    Warning(String),
    /// The run has ended.
    Ended(Box<Ended>),
}

/// A state that was reached.
#[derive(Debug)]
pub(crate) struct Reached {
    /// The step that led there; none at the start.
    pub progress: Option<Progress>,
    /// Row of the history.
    pub row: Vec<f64>,
    /// The points, the first time.
    pub ground: Option<Ground>,
}

/// Points and headings, which stay the same.
#[derive(Debug, Clone)]
pub(crate) struct Ground {
    pub dimension: usize,
    pub positions: Vec<f64>,
    pub cells: Vec<f64>,
    pub columns: Vec<String>,
}

/// The end of a run.
#[derive(Default)]
pub(crate) struct Ended {
    /// The summary as JSON, or what went wrong.
    pub result: Option<Result<String, Fault>>,
    /// The last fields, if there were any.
    pub fields: Vec<FieldValues>,
    /// Time of the last state, s.
    pub time: f64,
    /// The points, if they were not told before.
    pub ground: Option<Ground>,
}

/// Observes a run from its own thread and waits after each step for what is to be done.
pub(crate) struct Relay {
    events: Sender<Event>,
    commands: Receiver<Command>,
    interrupt: Interrupt,
    progress: Option<Progress>,
    told_ground: bool,
    free: bool,
    enough: bool,
    ended: Ended,
}

impl Relay {
    pub(crate) fn new(
        events: Sender<Event>,
        commands: Receiver<Command>,
        interrupt: Interrupt,
    ) -> Self {
        Relay {
            events,
            commands,
            interrupt,
            progress: None,
            told_ground: false,
            free: false,
            enough: false,
            ended: Ended::default(),
        }
    }

    /// Tells of the end of the run.
    pub(crate) fn conclude(mut self, result: Result<String, Fault>) {
        self.ended.result = Some(result);
        // Nobody listens any more where this fails.
        let _ = self.events.send(Event::Ended(Box::new(self.ended)));
    }

    fn ground(&mut self, view: &dyn View) -> Option<Ground> {
        let told = std::mem::replace(&mut self.told_ground, true);
        (!told).then(|| Ground {
            dimension: view.dimension(),
            positions: view.positions(),
            cells: view.cells(),
            columns: view.columns(),
        })
    }

    /// Sends, or ends the run if nobody listens any more.
    fn send(&mut self, event: Event) {
        if self.events.send(event).is_err() {
            self.interrupt.raise();
            self.free = true;
        }
    }
}

impl Observer for Relay {
    fn warn(&mut self, message: &str) {
        self.send(Event::Warning(message.to_owned()));
    }

    fn step(&mut self, progress: &Progress) {
        self.progress = Some(*progress);
    }

    fn look(&mut self, view: &dyn View) {
        let reached = Reached {
            progress: self.progress.take(),
            row: view.row(),
            ground: self.ground(view),
        };
        self.send(Event::State(Box::new(reached)));
        while !self.free {
            match self.commands.recv() {
                Ok(Command::Step) => return,
                Ok(Command::Run) => self.free = true,
                Ok(Command::Enough) => {
                    self.enough = true;
                    return;
                }
                Ok(Command::Fields) => self.send(Event::Fields(view.fields())),
                Err(_) => {
                    self.interrupt.raise();
                    return;
                }
            }
        }
    }

    fn is_enough(&mut self) -> bool {
        self.enough
    }

    fn end(&mut self, view: &dyn View) {
        self.ended.fields = view.fields();
        self.ended.time = view.time();
        self.ended.ground = self.ground(view);
    }
}
