//! What breaks in a step belongs to the crack from its end on.
//!
//! In the step itself the pressure of the wet point that leads there opens what breaks, and what opens is filled by that
//! point. At the end of the step every broken point gets fluid of its own: what it opened by, at the pressure that
//! opened it, while its pores are sealed with all that they hold at the pressure that they have. Neither a force nor an
//! amount of fluid changes by it, so that a step may be as short as it likes. Where no fluid led and pores do not press
//! it is empty.
//!
//! A crack is a plane, but its fluid has the pressure of a band two horizons wide. Were the pores of the band to fill
//! with it, rock would take up at once what it takes up in the time that fluid needs through the band: in
//! `kgd-leak-off` at 10 cm nothing of what is pumped until 2 s would be in the crack instead of 0.56. So fluid leaves the
//! crack at the edge of the band alone.

use std::borrow::Cow;

use super::crack_flow::{DRY, KEPT};
use super::{CrackFlow, Fields, FractureFlow, Model};
use crate::operators::Response;

/// A state whose broken points get fluid of their own.
pub struct Filling<'a> {
    /// Displacement, m, shape `(n·D,)`.
    pub displacement: &'a [f64],
    /// Displacement of the walls that move, m.
    pub walls: &'a [f64],
    /// Pressure, Pa, shape `(n,)`.
    pub pressure: &'a mut [f64],
    /// Whether forces balance in it, so that the pressure that opened what broke is known; else that of the pores
    /// stays.
    pub in_balance: bool,
}

impl<const D: usize> Model<D> {
    /// Points of cracks with fluid of their own: their pores are sealed.
    pub fn filled_points(&self) -> impl Iterator<Item = usize> + '_ {
        let cracks = self.cracks().into_iter();
        cracks.flat_map(|cracks| (0..cracks.donor.len()).filter(|i| cracks.is_wet(*i)))
    }

    /// Whether rock has broken that has no fluid of its own yet.
    pub fn has_unfilled(&self, response: &Response<D>) -> bool {
        self.cracks()
            .is_some_and(|cracks| !cracks.broken(&response.damage).is_empty())
    }

    /// Pressure in the pores, Pa: `pressure` but where they are sealed.
    pub fn pore_pressure<'a>(&self, pressure: &'a [f64]) -> Cow<'a, [f64]> {
        let Some(cracks) = self.cracks() else {
            return Cow::Borrowed(pressure);
        };
        let mut pores = pressure.to_vec();
        for i in self.filled_points() {
            pores[i] = cracks.sealed[i];
        }
        Cow::Owned(pores)
    }

    /// Gives what is broken by a response to a state fluid of its own.
    pub fn fill_broken(&mut self, response: &Response<D>, state: Filling<'_>) {
        let (Some(fracture), Some(flow), Some(coupling)) =
            (&self.fracture_flow, &self.flow, &self.coupling)
        else {
            return;
        };
        let Some(cracks) = &fracture.cracks else {
            return;
        };
        let broken = cracks.broken(&response.damage);
        if broken.is_empty() {
            return;
        }
        let is_fixed = flow.fixed_mask();
        // What opened at the expense of another point is handed over.
        let opened = |i: usize| self.cloud.volume[i] * response.planes[i].opening;
        let handed = |i: &usize| match cracks.donor[*i] {
            donor if donor == DRY || cracks.is_empty(donor) => 0.0,
            _ => opened(*i),
        };
        let handed: Vec<f64> = broken.iter().map(handed).collect();
        let at = |model: &Self, pressure: &[f64]| {
            let fields = Fields {
                pressure,
                displacement: state.displacement,
                walls: state.walls,
                ..Fields::default()
            };
            model.held(&fields, Some(response))
        };
        let before = at(self, state.pressure);
        let dry = |i: &usize| {
            let biot = coupling.divergence.weight[*i] / self.cloud.volume[*i];
            let pores = biot * state.pressure[*i] <= fracture.plan.cavitation_pressure;
            state.in_balance && !is_fixed[*i] && cracks.donor[*i] == DRY && pores
        };
        let empty = |i: &usize| dry(i) || cracks.is_empty(cracks.donor[*i]);
        let empty: Vec<(usize, f64)> = (broken.iter().filter(|i| empty(i)))
            .map(|i| (*i, opened(*i)))
            .collect();
        if let Some(cracks) = self.cracks_mut() {
            empty
                .iter()
                .for_each(|(i, open)| cracks.leave_empty(*i, *open));
        }
        self.seal(&broken, &is_fixed, (state.pressure, state.in_balance));
        let after = at(self, state.pressure);
        if let Some(cracks) = self.cracks_mut() {
            for (i, handed) in broken.into_iter().zip(handed) {
                cracks.pores[i] = before[i] + handed - after[i];
            }
        }
        self.follow_openings(response);
    }

    /// Seals the pores of points at their pressure, and sets that of the fluid in the crack there.
    fn seal(
        &mut self,
        points: &[usize],
        is_fixed: &[bool],
        (pressure, in_balance): (&mut [f64], bool),
    ) {
        let Model {
            fracture_flow:
                Some(FractureFlow {
                    plan,
                    cracks: Some(cracks),
                    ..
                }),
            flow: Some(flow),
            coupling: Some(coupling),
            cloud,
            ..
        } = self
        else {
            return;
        };
        for &i in points {
            let biot = coupling.divergence.weight[i] / cloud.volume[i];
            let pores = pressure[i];
            cracks.sealed[i] = pores;
            flow.capacity[i] *= KEPT;
            if in_balance && !is_fixed[i] {
                // Rock breaks by its effective stress where no crack leads.
                pressure[i] = match cracks.donor[i] {
                    DRY => (biot * pores).max(plan.cavitation_pressure),
                    donor => pressure[donor as usize],
                };
            }
        }
        points.iter().for_each(|i| cracks.donor[*i] = *i as u32);
    }

    /// Fluid in cracks, in the split model.
    pub(super) fn cracks_mut(&mut self) -> Option<&mut CrackFlow<D>> {
        self.fracture_flow.as_mut()?.cracks.as_mut()
    }
}
