//! The fields of a run, and their changes in a step.

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Memory, StepError};
use crate::model::{Coefficients, Control, Fields, Model};

/// Fields of a run at one time. A field that the scene does not call for is empty.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Pore pressure per point, Pa, shape `(n,)`.
    pub pressure: Vec<f64>,
    /// Displacement, point by point, m, shape `(n·D,)`.
    pub displacement: Vec<f64>,
    /// Velocity of the solid, m/s, shape `(n·D,)`; only with inertia.
    pub velocity: Vec<f64>,
    /// Displacement of the walls that move, m, shape `(walls,)`.
    pub walls: Vec<f64>,
    /// Largest driving energy of damage at the end of the steps so far, J/m³, shape `(n,)`; only with
    /// damage.
    pub history: Vec<f64>,
    /// Normals of cracks that are settled, shape `(n·D,)`, zero elsewhere; only with damage in the split model.
    pub normal: Vec<f64>,
    /// Displacement from which outputs count, m, shape `(n·D,)`; empty where they count from none.
    pub datum: Vec<f64>,
    /// The same of the walls, m, shape `(walls,)`.
    pub datum_walls: Vec<f64>,
    /// Coefficients of flow as they followed what broke; only with flow in fractures.
    pub coefficients: Option<Arc<Coefficients>>,
    /// What wells are held at whose bottom-hole pressure is known, and how often that has changed; empty without such wells.
    pub wells: Vec<WellState>,
    /// What the scheme carries over to the next step.
    pub memory: Memory,
}

/// What a well is held at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WellState {
    /// What it is held at now.
    pub control: Control,
    /// How often that has changed in accepted steps.
    pub switches: u32,
}

/// Change of pressure, displacement and walls.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Increment {
    /// Pa, shape `(n,)`.
    pub pressure: Vec<f64>,
    /// m, shape `(n·D,)`.
    pub displacement: Vec<f64>,
    /// m, shape `(walls,)`.
    pub walls: Vec<f64>,
}

/// What leads from a datum to a value; all of it without a datum.
fn since<'a>(values: &'a [f64], datum: &[f64]) -> Cow<'a, [f64]> {
    match datum.is_empty() {
        true => Cow::Borrowed(values),
        false => Cow::Owned(values.iter().zip(datum).map(|(v, d)| v - d).collect()),
    }
}

impl WellState {
    /// That of a control that has not changed yet.
    fn of(control: &Control) -> Self {
        WellState {
            control: *control,
            switches: 0,
        }
    }
}

impl State {
    /// The fields a model calls for, at the start and before any load acts.
    pub fn initial<const D: usize>(model: &Model<D>) -> Self {
        let solid = model.solid.as_deref();
        let unknowns = solid.map_or(0, |solid| solid.unknowns());
        let moving = solid.filter(|solid| !solid.mass.is_empty());
        State {
            time: 0.0,
            pressure: model
                .flow
                .as_ref()
                .map_or_else(Vec::new, |flow| flow.initial.clone()),
            displacement: vec![0.0; unknowns],
            velocity: moving.map_or_else(Vec::new, |_| vec![0.0; unknowns]),
            walls: vec![0.0; solid.map_or(0, |solid| solid.walls.len())],
            history: solid
                .and_then(|solid| solid.damage.as_ref())
                .map_or_else(Vec::new, |damage| damage.initial.clone()),
            normal: solid
                .and_then(|solid| solid.damage.as_ref())
                .map_or_else(Vec::new, |damage| damage.initial_normal.clone()),
            datum: Vec::new(),
            datum_walls: Vec::new(),
            coefficients: model.coefficients(),
            wells: model
                .flow
                .iter()
                .flat_map(|flow| &flow.controls)
                .map(WellState::of)
                .collect(),
            memory: Memory::default(),
        }
    }

    /// What the wells are held at.
    pub fn controls(&self) -> Vec<Control> {
        self.wells.iter().map(|well| well.control).collect()
    }

    /// Whether no limit of a well was ever met: exact solutions know of none.
    pub fn is_unlimited(&self) -> bool {
        let given = |well: &WellState| well.control == Control::Given && well.switches == 0;
        self.wells.iter().all(given)
    }

    /// Holds the wells at what these controls say. What the scheme remembers of the rates at the end of the last step is then
    /// no longer so.
    pub fn set_controls(&mut self, controls: &[Control]) {
        for (well, control) in self.wells.iter_mut().zip(controls) {
            if well.control != *control {
                (well.control, well.switches) = (*control, well.switches + 1);
                self.memory.imbalance = None;
            }
        }
    }

    /// The fields as the model looks at them.
    pub fn view(&self) -> Fields<'_> {
        Fields {
            time: self.time,
            pressure: &self.pressure,
            displacement: &self.displacement,
            walls: &self.walls,
            history: &self.history,
            normal: &self.normal,
        }
    }

    /// Displacement as outputs tell it, m, shape `(n·D,)`.
    pub fn shown_displacement(&self) -> Cow<'_, [f64]> {
        since(&self.displacement, &self.datum)
    }

    /// Displacement of the walls as outputs tell it, m, shape `(walls,)`.
    pub fn shown_walls(&self) -> Cow<'_, [f64]> {
        since(&self.walls, &self.datum_walls)
    }

    /// Name and bytes of every field held.
    pub fn fields(&self) -> Vec<(&'static str, usize)> {
        let all = [
            ("pressure", &self.pressure),
            ("displacement", &self.displacement),
            ("velocity", &self.velocity),
            ("walls", &self.walls),
            ("history", &self.history),
            ("normal", &self.normal),
            ("datum", &self.datum),
        ];
        let held = all.into_iter().filter(|(_, field)| !field.is_empty());
        held.map(|(name, field)| (name, 8 * field.len())).collect()
    }

    /// Sets this state's fields to those of `base` plus `share` times `increment`.
    pub fn set_sum(&mut self, base: &State, share: f64, increment: &Increment) {
        let set = |target: &mut Vec<f64>, base: &[f64], change: &[f64]| {
            target.clear();
            target.extend(base.iter().zip(change).map(|(b, c)| b + share * c));
        };
        set(&mut self.pressure, &base.pressure, &increment.pressure);
        set(
            &mut self.displacement,
            &base.displacement,
            &increment.displacement,
        );
        set(&mut self.walls, &base.walls, &increment.walls);
    }

    /// What leads from `from` to this state.
    pub fn since(&self, from: &State) -> Increment {
        let difference =
            |new: &[f64], old: &[f64]| new.iter().zip(old).map(|(n, o)| n - o).collect();
        Increment {
            pressure: difference(&self.pressure, &from.pressure),
            displacement: difference(&self.displacement, &from.displacement),
            walls: difference(&self.walls, &from.walls),
        }
    }

    /// Whether all fields are finite numbers.
    ///
    /// # Errors
    /// [`StepError::NotFinite`] with the first point that is not.
    pub fn check(&self) -> Result<(), StepError> {
        let per_point = self.displacement.len() / self.pressure.len().max(1);
        let all = [
            ("pressure", &self.pressure, 1),
            ("displacement", &self.displacement, per_point),
        ];
        for (field, values, width) in all {
            if let Some(place) = values.iter().position(|value| !value.is_finite()) {
                let (point, time) = (place / width.max(1), self.time);
                return Err(StepError::NotFinite { field, point, time });
            }
        }
        Ok(())
    }
}
