//! How the model responds to the fields of a state: forces of the solid, and what pores and cracks hold.

use super::{CrackFlow, DRY, Model, SolidModel};
use crate::operators::{DamageFields, Response};

/// The fields of a state; those that the scene does not call for are empty.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fields<'a> {
    /// Time, s.
    pub time: f64,
    /// Pore pressure, Pa, shape `(n,)`.
    pub pressure: &'a [f64],
    /// Displacement, m, shape `(n·D,)`.
    pub displacement: &'a [f64],
    /// Displacement of the walls that move, m, shape `(walls,)`.
    pub walls: &'a [f64],
    /// Largest driving energy of damage, J/m³, shape `(n,)`.
    pub history: &'a [f64],
    /// Settled normals of cracks, shape `(n·D,)`, zero elsewhere.
    pub normal: &'a [f64],
}

impl<'a> Fields<'a> {
    /// What they tell about the damage of points, with what fluid adds to the traction on cracks, Pa.
    pub fn damage(&self, fluid: &'a [f64]) -> DamageFields<'a> {
        DamageFields {
            history: self.history,
            normal: self.normal,
            fluid,
        }
    }
}

impl<const D: usize> Model<D> {
    /// Takes the internal force of a state off `force`, shape `(n·D,)`, N.
    pub fn subtract_force(&self, solid: &SolidModel<D>, state: &Fields<'_>, force: &mut [f64]) {
        match self.response(state) {
            Some(response) => solid.subtract_internal_force(&response, force),
            None => solid.subtract_internal(state.displacement, state.walls, force),
        }
    }

    /// Response of a solid with damage to a state; `None` without damage.
    pub fn response(&self, state: &Fields<'_>) -> Option<Response<D>> {
        let solid = self.solid.as_ref()?;
        solid.damage.as_ref()?;
        let fluid = self.fluid_traction(state.pressure);
        solid.response(state.displacement, state.walls, state.damage(&fluid))
    }

    /// Fluid in cracks, in the split model.
    pub fn cracks(&self) -> Option<&CrackFlow<D>> {
        self.fracture_flow.as_ref()?.cracks.as_ref()
    }

    /// What fluid adds to the effective traction on a crack, p^c − α p per point, Pa, zero where there is none in the
    /// crack; empty where it adds nothing at all.
    pub fn fluid_traction(&self, pressure: &[f64]) -> Vec<f64> {
        let (Some(fracture), Some(coupling)) = (&self.fracture_flow, &self.coupling) else {
            return Vec::new();
        };
        let Some(cracks) = &fracture.cracks else {
            return Vec::new();
        };
        let biot = |i: usize| coupling.divergence.weight[i] / self.cloud.volume[i];
        let added = |i: usize| -> f64 {
            let pressing = cracks.pressing(i, biot(i));
            let pressed: f64 = pressing
                .map(|(point, factor)| factor * pressure[point])
                .sum();
            let empty = match cracks.is_empty(cracks.donor[i]) {
                true => fracture.plan.cavitation_pressure,
                false => 0.0,
            };
            pressed + empty - biot(i) * cracks.sealed[i]
        };
        (0..pressure.len()).map(added).collect()
    }

    /// Pore volume per point that cracks add to what strain and pressure do, m^D: what they hold belongs to the
    /// point whose fluid fills them, and the pores beside them take no part in it. Zero without a response.
    pub fn crack_content(&self, response: Option<&Response<D>>) -> Vec<f64> {
        let mut content = vec![0.0; self.cloud.len()];
        let parts = (self.cracks(), &self.coupling, response);
        let (Some(cracks), Some(coupling), Some(response)) = parts else {
            return content;
        };
        for (i, plane) in response.planes.iter().enumerate() {
            let volume = self.cloud.volume[i];
            let biot = coupling.divergence.weight[i] / volume;
            for (point, factor) in cracks.pressing(i, biot) {
                content[point] += factor * volume * plane.opening;
            }
        }
        for (point, void) in cracks.voids.iter().filter(|(_, void)| !void.whole) {
            content[*point as usize] -= void.volume;
        }
        content
    }

    /// Which point's pressure acts in the crack at every point; empty in the model of the paper.
    pub fn wet_points(&self) -> Vec<u32> {
        self.cracks()
            .map_or_else(Vec::new, |cracks| cracks.donor.clone())
    }

    /// Whether there is fluid in any crack.
    pub fn has_fluid_in_cracks(&self) -> bool {
        let wet = |cracks: &CrackFlow<D>| cracks.donor.iter().any(|donor| *donor != DRY);
        self.cracks().is_some_and(wet)
    }

    /// Adds to a storage per point (m^D/Pa) what open cracks yield to their fluid at a fixed displacement.
    pub fn add_crack_storage(&self, response: &Response<D>, storage: &mut [f64]) {
        let (Some(cracks), Some(coupling)) = (self.cracks(), &self.coupling) else {
            return;
        };
        for (i, plane) in response.planes.iter().enumerate() {
            let volume = self.cloud.volume[i];
            let biot = coupling.divergence.weight[i] / volume;
            for (point, factor) in cracks.pressing(i, biot) {
                storage[point] += factor * factor * volume * plane.yielding;
            }
        }
    }

    /// Fluid in cracks, m^D: the opening of all points in which the pressure of a crack acts, less the voids in it.
    pub fn crack_volume(&self, response: &Response<D>) -> f64 {
        let Some(cracks) = self.cracks() else {
            return 0.0;
        };
        let planes = response.planes.iter().zip(&self.cloud.volume);
        let wet = planes
            .zip(&cracks.donor)
            .filter(|(_, donor)| **donor != DRY);
        let open: f64 = wet.map(|((plane, volume), _)| plane.opening * volume).sum();
        open - cracks.void_volume()
    }

    /// Whether cracks hold fluid of their own, so that what a state holds does not follow from increments.
    pub fn has_crack_content(&self) -> bool {
        self.cracks().is_some()
    }

    /// Response to a state where what a state holds depends on it; `None` elsewhere.
    pub fn crack_response(&self, state: &Fields<'_>) -> Option<Response<D>> {
        match self.has_crack_content() {
            true => self.response(state),
            false => None,
        }
    }

    /// All that a state holds per point above rest, V s p + Q u + q w and what cracks hold, m^D.
    pub fn held(&self, state: &Fields<'_>, response: Option<&Response<D>>) -> Vec<f64> {
        let mut held = self.content(state.displacement, state.walls);
        let cracks = self.crack_content(response);
        let capacity = self.flow.iter().flat_map(|flow| &flow.capacity);
        for (i, capacity) in capacity.enumerate() {
            held[i] += capacity * state.pressure[i] + cracks[i];
        }
        let pores = self.cracks().map_or(&[][..], |cracks| &cracks.pores);
        let pairs = held.iter_mut().zip(pores);
        pairs.for_each(|(held, pores)| *held += pores);
        held
    }

    /// Σ of the absolute forces that what is released in cracks would exert, N: the push of the fluid in them, and
    /// the prestress that they lost.
    pub fn crack_push(&self, response: &Response<D>) -> f64 {
        let Some(solid) = &self.solid else { return 0.0 };
        solid.crack_force(response).iter().map(|f| f.abs()).sum()
    }
}
