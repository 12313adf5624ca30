//! Starting from the state that another run left.

use super::RunError;
use super::checkpoint::{Checkpoint, Record};
use crate::geometry::Side;
use crate::model::{Model, driven_walls};
use crate::output::CheckpointError;
use crate::plan::{Plan, StartPlan, resolve_any};
use crate::scene::load_str;
use crate::schemes::State;

/// State that a run begins with: that of the scene, or the one that it takes over. What goes on from a
/// checkpoint of its own takes over the same state as it did at its beginning.
///
/// # Errors
/// [`RunError::Start`] if there is no such state or it does not fit.
pub(super) fn initial_state<const D: usize>(
    plan: &Plan,
    from: Option<&Checkpoint>,
    model: &mut Model<D>,
    processes: usize,
) -> Result<State, RunError> {
    let initial = State::initial(model);
    let Some(start) = &plan.start else {
        return Ok(initial);
    };
    if let Some(checkpoint) = from {
        // The pressure at the start is what changes are measured against.
        if let Some(flow) = &mut model.flow {
            flow.initial.clone_from(&checkpoint.record.course.reference);
        }
        return Ok(initial);
    }
    let state = take_over(start, initial, model, processes).map_err(RunError::Start)?;
    if let Some(flow) = &mut model.flow {
        flow.initial.clone_from(&state.pressure);
    }
    Ok(state)
}

/// Refuses a start that a run of the plan would refuse. Without a model, only what the checkpoint says of
/// itself is compared.
///
/// # Errors
/// [`RunError::Start`].
pub(super) fn check_start<const D: usize>(
    plan: &Plan,
    model: Option<&mut Model<D>>,
    processes: usize,
) -> Result<(), RunError> {
    let Some(start) = &plan.start else {
        return Ok(());
    };
    let then = match model {
        Some(model) => initial_state(plan, None, model, processes)?.time,
        None => {
            let checkpoint = Checkpoint::open(&start.from).map_err(RunError::Start)?;
            let fits = checkpoint.check_processes(processes);
            let fits = fits.and_then(|()| checkpoint.check_dimension(D));
            fits.map_err(RunError::Start)?;
            match start.keeps_clock {
                true => checkpoint.header.time,
                false => 0.0,
            }
        }
    };
    check_time(plan, then)
}

/// The plan with the time that the run begins with.
///
/// # Errors
/// [`RunError::Start`] if that is beyond its end.
pub(super) fn at_its_time(
    plan: &Plan,
    from: Option<&Checkpoint>,
    state: &State,
) -> Result<Plan, RunError> {
    let mut plan = plan.clone();
    plan.time.start = from.map_or(state.time, |checkpoint| checkpoint.record.course.start);
    check_time(&plan, plan.time.start)?;
    Ok(plan)
}

/// Refuses a start at or beyond the end.
fn check_time(plan: &Plan, begin: f64) -> Result<(), RunError> {
    let end = plan.time.end;
    match &plan.start {
        Some(start) if begin >= end => Err(RunError::Start(CheckpointError::Misfit {
            path: start.from.clone(),
            reason: format!(
                "it ends at t = {begin:e} s, and time.end = {end:e} s is not later; raise time.end, or set \
                 start.clock = \"reset\""
            ),
        })),
        _ => Ok(()),
    }
}

/// The state that the plan names, with the fields that the model calls for.
fn take_over<const D: usize>(
    start: &StartPlan,
    initial: State,
    model: &mut Model<D>,
    processes: usize,
) -> Result<State, CheckpointError> {
    let checkpoint = Checkpoint::open(&start.from)?;
    checkpoint.check_processes(processes)?;
    checkpoint.check_cloud(&model.cloud)?;
    let taken = Taken {
        checkpoint: &checkpoint,
        start,
        model,
    };
    let inertia = taken.inertia(&initial)?;
    let state = taken.state(initial)?;
    model.warnings.extend(inertia);
    Ok(state)
}

/// A component of a side that moves, and its place, m.
type Placed = ((Side, usize), f64);

struct Taken<'a, const D: usize> {
    checkpoint: &'a Checkpoint,
    start: &'a StartPlan,
    model: &'a Model<D>,
}

impl<const D: usize> Taken<'_, D> {
    /// The initial state with the fields that are taken over.
    fn state(&self, initial: State) -> Result<State, CheckpointError> {
        let then = &self.checkpoint.record.state;
        self.check_parts(&initial)?;
        let or = |own: &[f64], initial: Vec<f64>| match own.is_empty() {
            true => initial,
            false => own.to_vec(),
        };
        let walls = self.walls(&initial)?;
        let displacement = or(&then.displacement, initial.displacement);
        Ok(State {
            time: if self.start.keeps_clock {
                then.time
            } else {
                0.0
            },
            pressure: or(&then.pressure, initial.pressure),
            velocity: match then.velocity.len() == initial.velocity.len() {
                true => then.velocity.clone(),
                false => initial.velocity,
            },
            datum_walls: match self.start.resets_displacement {
                true => walls.clone(),
                false => self.datum_walls()?,
            },
            walls,
            // Bands of cracks that are new are broken from here on.
            history: match then.history.is_empty() {
                true => initial.history,
                false => {
                    let pairs = then.history.iter().zip(&initial.history);
                    pairs.map(|(then, own)| then.max(*own)).collect()
                }
            },
            normal: match then.normal.is_empty() {
                true => initial.normal,
                false => {
                    let pairs = then.normal.chunks(D).zip(initial.normal.chunks(D));
                    let settled = |own: &[f64]| own.iter().any(|n| *n != 0.0);
                    let either = pairs.map(|(then, own)| if settled(then) { then } else { own });
                    either.flatten().copied().collect()
                }
            },
            datum: match self.start.resets_displacement {
                true => displacement.clone(),
                false => then.datum.clone(),
            },
            displacement,
            coefficients: match &then.coefficients {
                Some(then) => self.model.with_cracks(then).coefficients(),
                None => initial.coefficients,
            },
            // Whether a limit is met the new scene decides.
            wells: initial.wells,
            memory: initial.memory,
        })
    }

    /// Refuses to lose a field that the state has and the scene does not compute.
    fn check_parts(&self, initial: &State) -> Result<(), CheckpointError> {
        let then = &self.checkpoint.record.state;
        let parts = [
            (&then.pressure, &initial.pressure, "a pressure", "[flow]"),
            (
                &then.displacement,
                &initial.displacement,
                "a displacement",
                "[mechanics]",
            ),
            (&then.history, &initial.history, "damage", "[damage]"),
        ];
        for (then, own, what, section) in parts {
            if !then.is_empty() && own.is_empty() {
                return Err(self.misfit(format!(
                    "it has {what}, which this scene would forget; add {section}, or start without it"
                )));
            }
        }
        Ok(())
    }

    /// Refuses to stop rock that moves, and tells where one of both runs has no inertia.
    fn inertia(&self, initial: &State) -> Result<Option<String>, CheckpointError> {
        let then = &self.checkpoint.record.state;
        let path = self.checkpoint.path.display();
        let fastest = then.velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        match (then.velocity.is_empty(), initial.velocity.is_empty()) {
            (false, true) if fastest > 0.0 => Err(self.misfit(format!(
                "its rock moves, at up to {fastest:.1e} m/s, which a scene without inertia would forget; set \
                 mechanics.mode = \"dynamic\", or start from a state at rest"
            ))),
            (false, true) => Ok(Some(format!(
                "{path} is of a run with inertia and this one is without; its rock was at rest, so nothing is lost"
            ))),
            (true, false) if !then.displacement.is_empty() => Ok(Some(format!(
                "{path} is of a run without inertia: the rock, which moves from now on, starts at rest"
            ))),
            _ => Ok(None),
        }
    }

    fn misfit(&self, reason: String) -> CheckpointError {
        self.checkpoint.misfit(reason)
    }

    /// Places of the sides that move, m; those that did not move before are at 0.
    fn walls(&self, initial: &State) -> Result<Vec<f64>, CheckpointError> {
        let before = self.walls_before(&self.checkpoint.record.state.walls)?;
        let own = self.own_walls();
        let lost = before
            .iter()
            .find(|(wall, place)| *place != 0.0 && !own.contains(wall));
        if let Some(((side, axis), place)) = lost {
            return Err(self.misfit(format!(
                "side {side} was moved by {place:.3e} m along axis {axis} there and does not move in this \
                 scene; give it the same kind of motion, which may stand still"
            )));
        }
        let walls = placed(&own, &before);
        debug_assert_eq!(walls.len(), initial.walls.len());
        Ok(walls)
    }

    /// Places of the sides that move from which outputs count, m; empty where they count from none.
    fn datum_walls(&self) -> Result<Vec<f64>, CheckpointError> {
        let then = &self.checkpoint.record.state;
        match then.datum.is_empty() {
            true => Ok(Vec::new()),
            false => Ok(placed(
                &self.own_walls(),
                &self.walls_before(&then.datum_walls)?,
            )),
        }
    }

    /// Components of the sides that move in this scene.
    fn own_walls(&self) -> Vec<(Side, usize)> {
        let own = self.model.solid.iter().flat_map(|solid| &solid.walls);
        own.map(|wall| (wall.side, wall.component)).collect()
    }

    /// Sides that moved in the run that is taken over, with `places` of theirs, m.
    fn walls_before(&self, places: &[f64]) -> Result<Vec<Placed>, CheckpointError> {
        let Record { scene, base, .. } = &self.checkpoint.record;
        if places.is_empty() {
            return Ok(Vec::new());
        }
        let name = self.checkpoint.path.display().to_string();
        let loaded = load_str(&name, scene, base, &[]);
        let plan = loaded.and_then(|loaded| resolve_any(&loaded, &self.checkpoint.header.case));
        let plan = plan.map_err(|_| self.misfit("its scene cannot be read any more".to_owned()))?;
        let walls = plan.mechanics.iter().flat_map(driven_walls::<D>);
        Ok(walls.zip(places.iter().copied()).collect())
    }
}

/// Places of sides, m; those that did not move before are at 0.
fn placed(own: &[(Side, usize)], before: &[Placed]) -> Vec<f64> {
    let place = |wall: &(Side, usize)| {
        let found = before.iter().find(|(then, _)| then == wall);
        found.map_or(0.0, |(_, place)| *place)
    };
    own.iter().map(place).collect()
}
