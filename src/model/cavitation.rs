//! Fluid that lags behind where cracks open: its pressure does not fall below the one at which it boils. A point of a
//! crack that would need less holds a void v beside its fluid, up to all that is open there, w,
//!
//!   0 ≤ v ≤ w,  p = p_c for 0 < v < w,  p ≥ p_c for v = 0,  p ≤ p_c for v = w,
//!
//! and its balance tells the void in place of the pressure. Between voids nothing flows; fluid that comes in fills
//! them first. A point without any fluid is rock like that around it: its pressure is what is drawn there, and the one at
//! which fluid boils acts on its faces.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::crack_flow::{CrackFlow, DRY};
use super::{FractureFlow, Model};
use crate::operators::Response;

/// Volume without fluid at a point of a crack.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Void {
    /// m^D.
    pub volume: f64,
    /// Whether it is all that is open.
    pub whole: bool,
}

/// Those of the points of cracks that hold any.
pub type Voids = BTreeMap<u32, Void>;

impl<const D: usize> CrackFlow<D> {
    /// Volume that cracks hold without fluid, m^D.
    pub fn void_volume(&self) -> f64 {
        self.voids.values().fold(0.0, |sum, void| sum + void.volume)
    }

    /// Whether a point of a crack holds no fluid at all; false for [`DRY`].
    pub fn is_empty(&self, point: u32) -> bool {
        point != DRY && self.voids.get(&point).is_some_and(|void| void.whole)
    }

    /// Makes a point that breaks one without fluid, open by so much, m^D: what another counted as its own void is handed over.
    pub fn leave_empty(&mut self, point: usize, opened: f64) {
        let donor = self.donor[point];
        if let Some(void) = self.voids.get_mut(&donor).filter(|void| void.whole) {
            void.volume -= opened;
        }
        let whole = Void {
            volume: opened,
            whole: true,
        };
        self.voids.insert(point as u32, whole);
    }

    /// Points whose pressure is that at which fluid boils.
    fn boiling(&self) -> impl Iterator<Item = usize> + '_ {
        let some = self.voids.iter().filter(|(_, void)| !void.whole);
        some.map(|(i, _)| *i as usize)
    }

    /// Raises pressures in cracks to `limit` (Pa) and keeps them there where there are voids and fluid, but not where
    /// they are prescribed; true if points have begun to boil.
    fn boil(&mut self, limit: f64, is_fixed: &[bool], pressure: &mut [f64]) -> bool {
        // Where there was no fluid there is some from now on.
        for (i, void) in &mut self.voids {
            void.whole &= pressure[*i as usize] <= limit;
        }
        let below = |i: &usize| self.is_wet(*i) && !is_fixed[*i] && pressure[*i] < limit;
        let new = |i: &usize| !self.voids.contains_key(&(*i as u32));
        let begin: Vec<usize> = (0..pressure.len()).filter(below).filter(new).collect();
        for &i in &begin {
            let none = Void {
                volume: 0.0,
                whole: false,
            };
            self.voids.insert(i as u32, none);
        }
        for i in self.boiling() {
            pressure[i] = limit;
        }
        !begin.is_empty()
    }

    /// Lets voids take up what points lack, `left` being what they must still take up and `open` what is open there,
    /// m^D, shape `(n,)`: nothing where a void remains. Where none does fluid fills the crack from now on, where there
    /// is nothing else pores give.
    fn settle(&mut self, left: &mut [f64], open: &[f64]) {
        self.voids.retain(|i, void| {
            let (own, most) = (&mut left[*i as usize], open[*i as usize]);
            if void.whole {
                void.volume = most;
                return true;
            }
            let lacks = void.volume - *own;
            void.volume = lacks.clamp(0.0, most);
            void.whole = lacks > most;
            *own = void.volume - lacks;
            lacks >= 0.0
        });
    }
}

impl<const D: usize> Model<D> {
    /// Raises pressures (Pa, shape `(n,)`) in cracks to the one at which fluid boils, but where they are prescribed;
    /// true if points have begun to boil.
    pub fn boil(&mut self, is_fixed: &[bool], pressure: &mut [f64]) -> bool {
        let Some(FractureFlow { plan, cracks, .. }) = &mut self.fracture_flow else {
            return false;
        };
        let limit = plan.cavitation_pressure;
        cracks
            .as_mut()
            .is_some_and(|cracks| cracks.boil(limit, is_fixed, pressure))
    }

    /// Lets voids in cracks take up what points lack: `left` is what points must still take up, m^D, shape `(n,)`, and
    /// nothing where a void remains, at a response.
    pub fn settle_voids(&mut self, left: &mut [f64], response: &Response<D>) {
        if self.cracks().is_none_or(|cracks| cracks.voids.is_empty()) {
            return;
        }
        let open = self.open_in_cracks(response);
        if let Some(cracks) = self.cracks_mut() {
            cracks.settle(left, &open);
        }
    }

    /// What is drawn out of points of cracks that hold no fluid, m^D/s, and the one of which most is; `None` if nothing is.
    pub fn overdrawn(&self, pressure: &[f64], time: f64) -> Option<(f64, usize)> {
        let (cracks, flow) = (self.cracks()?, self.flow.as_ref()?);
        let empty = cracks.voids.keys().filter(|i| cracks.is_empty(**i));
        let empty: Vec<usize> = empty.map(|i| *i as usize).collect();
        if empty.is_empty() {
            return None;
        }
        let mut rate = vec![0.0; pressure.len()];
        flow.sources(time, pressure, &mut rate);
        let drawn = empty.iter().filter(|i| rate[**i] < 0.0);
        let most = drawn
            .clone()
            .min_by(|a, b| rate[**a].total_cmp(&rate[**b]))?;
        Some((-drawn.map(|i| rate[*i]).sum::<f64>(), *most))
    }

    /// What is open at the points whose pressure acts in cracks, m^D, shape `(n,)`.
    fn open_in_cracks(&self, response: &Response<D>) -> Vec<f64> {
        let mut open = vec![0.0; self.cloud.len()];
        let donors = self.cracks().map_or(&[][..], |cracks| &cracks.donor);
        for (i, donor) in donors
            .iter()
            .enumerate()
            .filter(|(_, donor)| **donor != DRY)
        {
            open[*donor as usize] += self.cloud.volume[i] * response.planes[i].opening;
        }
        open
    }

    /// Points of cracks that hold voids beside fluid: their pressure is that at which it boils.
    pub fn void_points(&self) -> impl Iterator<Item = usize> + '_ {
        self.cracks().into_iter().flat_map(CrackFlow::boiling)
    }

    /// Lowest pressure in cracks (Pa) and that at which fluid boils there; `None` without fluid in cracks.
    pub fn lowest_in_cracks(&self, pressure: &[f64]) -> Option<(f64, f64)> {
        let limit = self.fracture_flow.as_ref()?.plan.cavitation_pressure;
        let cracks = self.cracks()?;
        let wet = (0..pressure.len()).filter(|i| cracks.is_wet(*i));
        let lowest = wet.map(|i| pressure[i]).min_by(f64::total_cmp)?;
        Some((lowest, limit))
    }

    /// Voids in cracks, m^D.
    pub fn voids(&self) -> Voids {
        self.cracks()
            .map_or_else(Voids::new, |cracks| cracks.voids.clone())
    }

    /// Sets the voids in cracks.
    pub fn set_voids(&mut self, voids: &Voids) {
        if let Some(cracks) = self.cracks_mut() {
            cracks.voids.clone_from(voids);
        }
    }
}
