//! Fluid that lags behind where cracks open: its pressure does not fall below the one at which it boils. A point of a
//! crack that would need less holds a void v beside its fluid,
//!
//!   p ≥ p_c,  v ≥ 0,  (p − p_c) v = 0,
//!
//! and its balance tells the void in place of the pressure. Between voids nothing flows; fluid that comes in fills
//! them first.

use std::collections::BTreeMap;

use super::crack_flow::CrackFlow;
use super::{FractureFlow, Model};
use crate::operators::Response;

/// Volume without fluid of the points of cracks that hold any, m^D.
pub type Voids = BTreeMap<u32, f64>;

impl<const D: usize> CrackFlow<D> {
    /// Volume that cracks hold without fluid, m^D.
    pub fn void_volume(&self) -> f64 {
        self.voids.values().fold(0.0, |sum, void| sum + void)
    }

    /// Raises pressures in cracks to `limit` (Pa) and keeps them there where there are voids, but not where they are
    /// prescribed; true if points have begun to boil.
    fn boil(&mut self, limit: f64, is_fixed: &[bool], pressure: &mut [f64]) -> bool {
        let below = |i: &usize| self.is_wet(*i) && !is_fixed[*i] && pressure[*i] < limit;
        let boiling: Vec<usize> = (0..pressure.len()).filter(below).collect();
        for &i in &boiling {
            self.voids.entry(i as u32).or_insert(0.0);
        }
        for i in self.voids.keys() {
            pressure[*i as usize] = limit;
        }
        !boiling.is_empty()
    }

    /// Lets voids take up what points lack, `left` being what they must still take up, m^D, shape `(n,)`: nothing
    /// where a void remains. Where none does fluid fills the crack from now on.
    fn settle(&mut self, left: &mut [f64]) {
        self.voids.retain(|i, void| {
            let own = &mut left[*i as usize];
            let lacks = *void - *own;
            let remains = lacks >= 0.0;
            (*own, *void) = match remains {
                true => (0.0, lacks),
                false => (-lacks, 0.0),
            };
            remains
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
    /// nothing where a void remains.
    pub fn settle_voids(&mut self, left: &mut [f64]) {
        if let Some(cracks) = self.cracks_mut() {
            cracks.settle(left);
        }
    }

    /// Fluid that points of cracks would owe, voids larger than all that is open there, m^D, and the point that owes most;
    /// `None` if none does.
    pub fn overdrawn(&self, response: &Response<D>) -> Option<(f64, usize)> {
        let cracks = self.cracks().filter(|cracks| !cracks.voids.is_empty())?;
        // What is open there, less the void.
        let fluid = self.crack_content(Some(response));
        let owed = cracks.voids.keys().map(|i| *i as usize);
        let owed: Vec<usize> = owed.filter(|i| fluid[*i] < 0.0).collect();
        let most = owed
            .iter()
            .min_by(|a, b| fluid[**a].total_cmp(&fluid[**b]))?;
        Some((-owed.iter().map(|i| fluid[*i]).sum::<f64>(), *most))
    }

    /// Points of cracks that hold voids: their pressure is that at which fluid boils.
    pub fn void_points(&self) -> impl Iterator<Item = usize> + '_ {
        let cracks = self.cracks().into_iter();
        cracks.flat_map(|cracks| cracks.voids.keys().map(|i| *i as usize))
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
