//! Wells whose bottom-hole pressure is known: p_wf = p̄ + q/WI, with the mean p̄ = Σ s_i p_i / Σ s_i over the points that
//! the well feeds.
//!
//! One that is held at a pressure takes q = WI (p_wf − p̄) in, spread as every other rate is: the term (WI/Σs) s sᵀ of L, and
//! WI s p_wf beside it. The index WI follows from the operator itself, see [`radius`](self::radius).

mod control;
mod radius;

use std::sync::atomic::{AtomicU64, Ordering};

pub use control::Control;
use control::{Imposed, load};
use radius::Surroundings;

use super::FlowModel;
use crate::assembly::{Pattern, PatternError};
use crate::effects::{Context, EffectError, WellSpread};
use crate::operators::PlaneTensor;
use crate::plan::{Load, WellDrive, WellPlan, Wellbore};
use crate::report::Flows;

/// A well and its place in the operator.
#[derive(Debug)]
pub struct Well {
    /// Name in the scene.
    pub name: String,
    /// Index WI: full-plane rate per pascal between bottom and points, m^D/(Pa s).
    pub index: f64,
    /// Radius at which the exact pressure is p̄, m.
    pub equivalent_radius: f64,
    drive: WellDrive,
    /// Points and their shares; they add up to `inside`.
    share: Vec<(u32, f64)>,
    inside: f64,
    /// Places of the pairs of its points among the values of L, and the values of the rock there; empty where it never holds
    /// a pressure.
    block: Vec<(u32, f64)>,
}

/// A well at some time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WellNow {
    /// Full-plane rate into the rock, m^D/s.
    pub rate: f64,
    /// Bottom-hole pressure, Pa.
    pub pressure: f64,
}

impl Well {
    /// Mean pressure p̄ of its points, Pa.
    fn mean(&self, pressure: &[f64]) -> f64 {
        let sum = self.share.iter().map(|&(i, s)| s * pressure[i as usize]);
        sum.sum::<f64>() / self.inside
    }

    /// Whether it acts through the operator, and not as an effect.
    fn acts(&self) -> bool {
        !self.block.is_empty()
    }

    /// Rate and bottom-hole pressure at `time`.
    pub fn now(&self, control: Control, time: f64, pressure: &[f64]) -> WellNow {
        let mean = self.mean(pressure);
        match self.imposed(control, time) {
            Imposed::Rate(rate) => WellNow {
                rate,
                pressure: mean + rate / self.index,
            },
            Imposed::Pressure(pressure) => WellNow {
                rate: self.index * (pressure - mean),
                pressure,
            },
        }
    }

    fn bytes(&self) -> usize {
        (self.share.len() + self.block.len()) * size_of::<(u32, f64)>()
    }
}

/// All wells whose bottom-hole pressure is known, in the order of the plan.
#[derive(Debug, Default)]
pub struct Wells {
    wells: Vec<Well>,
    evaluations: AtomicU64,
}

impl Wells {
    /// The wells.
    pub fn iter(&self) -> std::slice::Iter<'_, Well> {
        self.wells.iter()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.wells.is_empty()
    }

    /// How often rates of wells in the operator were evaluated; `None` without such a well.
    pub fn evaluations(&self) -> Option<u64> {
        let acts = self.wells.iter().any(Well::acts);
        acts.then(|| self.evaluations.load(Ordering::Relaxed))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.wells.iter().map(Well::bytes).sum()
    }

    /// Wells in the operator with what they are held at.
    fn imposed<'a>(
        &'a self,
        controls: &'a [Control],
        time: f64,
    ) -> impl Iterator<Item = (&'a Well, Imposed)> {
        let pairs = self.wells.iter().zip(controls);
        let acting = pairs.filter(|(well, _)| well.acts());
        acting.map(move |(well, control)| (well, well.imposed(*control, time)))
    }

    /// Adds the rates of wells that are held at one, m^D/s.
    pub fn add_rate(&self, controls: &[Control], time: f64, rate: &mut [f64]) {
        if !self.wells.is_empty() {
            self.evaluations.fetch_add(1, Ordering::Relaxed);
        }
        for (well, imposed) in self.imposed(controls, time) {
            if let Imposed::Rate(total) = imposed {
                for &(point, share) in &well.share {
                    rate[point as usize] += total * share;
                }
            }
        }
    }

    /// Calls `visit(point, rate)` for every point of the wells that are held at a pressure: WI s_i (p_wf − p_i), m^D/s. What is
    /// missing to WI s_i (p_wf − p̄) is exchanged between the points, by L.
    pub fn each_inflow(
        &self,
        (controls, time): (&[Control], f64),
        pressure: &[f64],
        mut visit: impl FnMut(usize, f64),
    ) {
        for (well, imposed) in self.imposed(controls, time) {
            if let Imposed::Pressure(bottom) = imposed {
                for &(point, share) in &well.share {
                    let point = point as usize;
                    visit(point, well.index * share * (bottom - pressure[point]));
                }
            }
        }
    }

    /// Adds what the wells in the operator bring into the domain.
    pub fn add_flows(&self, controls: &[Control], time: f64, pressure: &[f64], flows: &mut Flows) {
        for (well, imposed) in self.imposed(controls, time) {
            let rate = match imposed {
                Imposed::Rate(rate) => rate * well.inside,
                Imposed::Pressure(bottom) => {
                    let own = |&(i, s): &(u32, f64)| s * (bottom - pressure[i as usize]);
                    well.index * well.share.iter().map(own).sum::<f64>()
                }
            };
            flows.injected += rate;
            flows.gross += rate.abs();
        }
    }

    /// Power of the fluid from wells that are held at a pressure, J/s (per metre in the plane).
    pub fn power(&self, controls: &[Control], time: f64, pressure: &[f64]) -> f64 {
        let held = self.imposed(controls, time);
        let power = held.map(|(well, imposed)| match imposed {
            Imposed::Rate(_) => 0.0,
            Imposed::Pressure(bottom) => {
                let rate = well.index * (bottom - well.mean(pressure));
                bottom * rate * well.inside
            }
        });
        power.sum()
    }

    /// Adds each point's conductance to the wells that are held at a pressure, m^D/(Pa s): row sums of L.
    pub fn add_leak(&self, controls: &[Control], leak: &mut [f64]) {
        for (well, imposed) in self.imposed(controls, 0.0) {
            if let Imposed::Pressure(_) = imposed {
                for &(point, share) in &well.share {
                    leak[point as usize] += well.index * share;
                }
            }
        }
    }

    /// Points of the wells that are held at a pressure.
    pub fn held_points<'a>(&'a self, controls: &'a [Control]) -> impl Iterator<Item = usize> + 'a {
        let held = self.imposed(controls, 0.0);
        let held = held.filter(|(_, imposed)| matches!(imposed, Imposed::Pressure(_)));
        held.flat_map(|(well, _)| well.share.iter().map(|&(point, _)| point as usize))
    }

    /// What is prescribed over time.
    pub fn loads(&self) -> impl Iterator<Item = &Load> {
        let acting = self.wells.iter().filter(|well| well.acts());
        acting.map(|well| load(&well.drive))
    }

    /// All pressures that are prescribed, at any time, Pa.
    pub fn pressures(&self) -> impl Iterator<Item = f64> + '_ {
        self.wells.iter().flat_map(|well| match &well.drive {
            WellDrive::Rate {
                pressure_min,
                pressure_max,
                ..
            } => pressure_min.iter().chain(pressure_max).copied().collect(),
            WellDrive::Pressure { pressure, .. } => pressure.values().to_vec(),
        })
    }

    /// The controls that suit a pressure at `time`, which `controls` have led to; `None` where they suit already.
    pub fn suited(
        &self,
        controls: &[Control],
        time: f64,
        pressure: &[f64],
    ) -> Option<Vec<Control>> {
        let pairs = self.wells.iter().zip(controls);
        let suited = pairs.map(|(well, &control)| match well.acts() {
            true => well.suited(control, well.mean(pressure), time),
            false => control,
        });
        let suited: Vec<Control> = suited.collect();
        (suited != controls).then_some(suited)
    }

    /// Sets the values of L (shape `(nonzeros,)`) to those of the rock, and adds the wells that are held at a pressure. A function of
    /// the controls alone, whatever the values were before.
    fn enter(&self, controls: &[Control], values: &mut [f64]) {
        for (well, imposed) in self.imposed(controls, 0.0) {
            let held = matches!(imposed, Imposed::Pressure(_));
            let strength = if held { well.index / well.inside } else { 0.0 };
            let pairs = (well.share.iter())
                .flat_map(|(_, one)| well.share.iter().map(move |(_, other)| one * other));
            for (&(place, rock), shares) in well.block.iter().zip(pairs) {
                values[place as usize] = rock + strength * shares;
            }
        }
    }
}

/// What the wells of a plan need of the pattern of L: every point of one that may hold a pressure exchanges with all others of it.
pub(super) fn pattern(
    points: usize,
    spreads: &[(usize, WellSpread)],
    plan: &[WellPlan],
) -> Option<Pattern> {
    let mut rows: Vec<Vec<u32>> = Vec::new();
    for (place, spread) in spreads {
        if plan[*place].holds() {
            rows.resize(points, Vec::new());
            for (point, _) in &spread.share {
                rows[*point as usize].extend(spread.share.iter().map(|(other, _)| *other));
            }
        }
    }
    if rows.is_empty() {
        return None;
    }
    let mut pattern = Pattern {
        offsets: vec![0],
        columns: Vec::new(),
    };
    for mut row in rows {
        row.sort_unstable();
        pattern.columns.append(&mut row);
        pattern.offsets.push(pattern.columns.len() as u32);
    }
    Some(pattern)
}

impl<const D: usize> FlowModel<D> {
    /// The pattern with all that wells exchange.
    pub(super) fn with_wells(
        pattern: Pattern,
        spreads: &[(usize, WellSpread)],
        plan: &[WellPlan],
    ) -> Result<Pattern, PatternError> {
        match self::pattern(pattern.rows(), spreads, plan) {
            Some(own) => pattern.union(&own),
            None => Ok(pattern),
        }
    }

    /// The wells of these spreads, in an operator whose values are those of the rock. `tensor` is the shape of the mobility per point;
    /// empty where it has no preferred direction.
    pub(super) fn wells(
        &self,
        context: &Context<'_, D>,
        spreads: Vec<(usize, WellSpread)>,
        tensor: &[PlaneTensor],
    ) -> Result<Wells, EffectError> {
        if spreads.is_empty() {
            return Ok(Wells::default());
        }
        let surroundings = Surroundings::new(self, tensor);
        let wells = spreads.into_iter().map(|(place, spread)| {
            let plan = &context.plan.wells[place];
            let bore = plan.bore.unwrap_or(Wellbore {
                radius: 0.0,
                skin: 0.0,
            });
            let found = surroundings.index(plan, bore, &spread)?;
            let points = spread.share.iter().map(|(point, _)| *point as usize);
            let pairs = points
                .clone()
                .flat_map(|row| points.clone().map(move |column| (row, column)));
            let value = |(row, column)| {
                let place = self.pattern.find(row, column)?;
                Some((place as u32, self.conductance[place]))
            };
            Ok(Well {
                name: plan.name.clone(),
                index: found.index,
                equivalent_radius: found.equivalent_radius,
                drive: plan.drive.clone(),
                block: match plan.holds() {
                    true => pairs.filter_map(value).collect(),
                    false => Vec::new(),
                },
                share: spread.share,
                inside: spread.inside,
            })
        });
        Ok(Wells {
            wells: wells.collect::<Result<_, EffectError>>()?,
            evaluations: AtomicU64::new(0),
        })
    }

    /// Holds the wells at what these controls say; L changes with them.
    pub fn set_controls(&mut self, controls: &[Control]) {
        if self.controls != controls {
            self.controls.clear();
            self.controls.extend_from_slice(controls);
            self.enter_wells();
        }
    }

    /// Adds the rate that enters the points from wells that are held at a pressure, m^D/s.
    pub fn add_well_inflow(&self, time: f64, pressure: &[f64], rate: &mut [f64]) {
        let held = (&self.controls[..], time);
        self.wells
            .each_inflow(held, pressure, |point, own| rate[point] += own);
    }

    /// Brings L to the controls of the wells.
    pub(super) fn enter_wells(&mut self) {
        self.wells.enter(&self.controls, &mut self.conductance);
    }

    /// This flow with every well held at a pressure that ever may be: L is never stiffer.
    pub fn stiffest(&self) -> std::borrow::Cow<'_, Self> {
        let stiff = |well: &Well| match &well.drive {
            WellDrive::Rate {
                pressure_min: Some(_),
                ..
            } => Control::PressureMin,
            WellDrive::Rate {
                pressure_max: Some(_),
                ..
            } => Control::PressureMax,
            _ => Control::Given,
        };
        let controls: Vec<Control> = self.wells.iter().map(stiff).collect();
        if controls == self.controls {
            return std::borrow::Cow::Borrowed(self);
        }
        let mut stiffest = self.clone();
        stiffest.set_controls(&controls);
        std::borrow::Cow::Owned(stiffest)
    }

    /// The controls of the wells that suit a pressure at `time`, which those of now have led to; `None` where they do already.
    pub fn suited_controls(&self, time: f64, pressure: &[f64]) -> Option<Vec<Control>> {
        self.wells.suited(&self.controls, time, pressure)
    }

    /// Rate and bottom-hole pressure of every well at `time`, where it is known.
    pub fn wells_now(&self, pressure: &[f64], time: f64) -> Vec<WellNow> {
        let pairs = self.wells.iter().zip(&self.controls);
        let now = pairs.map(|(well, control)| well.now(*control, time, pressure));
        now.collect()
    }
}
