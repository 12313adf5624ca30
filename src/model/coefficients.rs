//! Coefficients of flow that follow what breaks: part of a state, not of the model.

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Model, Voids};
use crate::boundary::BoundaryPlane;
use crate::effects::Opening;

/// Properties of rock and fluid at every point, as the damage and the openings of a state have them
/// (Eqs. 40 to 46). All shapes `(n,)`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Coefficients {
    /// Permeability, m².
    pub permeability: Vec<f64>,
    /// K/μ, m²/(Pa s).
    pub mobility: Vec<f64>,
    /// V s, m^D/Pa.
    pub capacity: Vec<f64>,
    /// V α, m^D.
    pub biot: Vec<f64>,
    /// Opening, m; 0 where the rock is intact.
    pub aperture: Vec<f64>,
    /// Point whose pressure acts in the crack here; empty in the model of the paper.
    pub donor: Vec<u32>,
    /// Openings of cracks and widths of their bands, m.
    pub opening: Vec<Opening>,
    /// What the pores of points in cracks hold for good, m^D; empty in the model of the paper.
    pub pores: Vec<f64>,
    /// Pressure in those pores, which stays, Pa; likewise.
    pub sealed: Vec<f64>,
    /// Volume without fluid of the points of cracks that hold any.
    pub voids: Voids,
    /// Values of L that belong to the mobility; filled anew where they are absent, as after a restart.
    #[serde(skip)]
    conductance: Vec<f64>,
    /// Sides of prescribed pressure at the mobility.
    #[serde(skip)]
    walls: Vec<BoundaryPlane>,
}

impl PartialEq for Coefficients {
    /// What follows from the mobility is not compared.
    fn eq(&self, other: &Self) -> bool {
        let fields = |own: &Self| {
            let Coefficients {
                permeability,
                mobility,
                capacity,
                biot,
                aperture,
                ..
            } = own.clone();
            [permeability, mobility, capacity, biot, aperture]
        };
        let cracks = |own: &Self, other: &Self| {
            let sealed = own.pores == other.pores && own.sealed == other.sealed;
            own.donor == other.donor
                && own.opening == other.opening
                && own.voids == other.voids
                && sealed
        };
        cracks(self, other) && fields(self) == fields(other)
    }
}

impl Coefficients {
    /// Bytes of the fields.
    pub fn bytes(&self) -> usize {
        8 * (5 * self.permeability.len() + 2 * self.opening.len() + 2 * self.pores.len())
            + 4 * self.donor.len()
    }
}

impl<const D: usize> Model<D> {
    /// Coefficients as this model has them; `None` where they follow nothing.
    pub fn coefficients(&self) -> Option<Arc<Coefficients>> {
        let (fracture, flow) = (self.fracture_flow.as_ref()?, self.flow.as_ref()?);
        let cracks = fracture.cracks.as_ref();
        Some(Arc::new(Coefficients {
            donor: cracks.map_or_else(Vec::new, |cracks| cracks.donor.clone()),
            opening: cracks.map_or_else(Vec::new, |cracks| cracks.opening.clone()),
            pores: cracks.map_or_else(Vec::new, |cracks| cracks.pores.clone()),
            sealed: cracks.map_or_else(Vec::new, |cracks| cracks.sealed.clone()),
            voids: cracks.map_or_else(Voids::new, |cracks| cracks.voids.clone()),
            permeability: self.permeability.clone(),
            mobility: flow.mobility.clone(),
            capacity: flow.capacity.clone(),
            biot: self.coupling.as_ref()?.divergence.weight.clone(),
            aperture: fracture.aperture.clone(),
            conductance: flow.conductance.clone(),
            walls: flow.walls.clone(),
        }))
    }

    /// This model at the coefficients of a state, if it has any.
    pub fn at(&self, coefficients: Option<&Arc<Coefficients>>) -> Cow<'_, Self> {
        match coefficients {
            None => Cow::Borrowed(self),
            Some(coefficients) => Cow::Owned(self.with(coefficients)),
        }
    }

    /// This model with the cracks of another run: their fluid, and what their pores hold, in rock as this model has
    /// it. As it is where cracks hold no fluid of their own.
    #[must_use]
    pub fn with_cracks(&self, coefficients: &Coefficients) -> Self {
        let mut model = self.clone();
        if let Model {
            fracture_flow: Some(fracture),
            flow: Some(flow),
            permeability,
            ..
        } = &mut model
            && let Some(cracks) = &mut fracture.cracks
            && coefficients.donor.len() == cracks.donor.len()
        {
            cracks.take_over(coefficients, &mut flow.capacity);
            fracture.conduct(flow, permeability);
        }
        model
    }

    /// This model with other coefficients.
    #[must_use]
    pub fn with(&self, coefficients: &Coefficients) -> Self {
        let mut model = self.clone();
        let Model {
            fracture_flow: Some(fracture),
            flow: Some(flow),
            coupling: Some(coupling),
            permeability,
            ..
        } = &mut model
        else {
            return model;
        };
        permeability.clone_from(&coefficients.permeability);
        flow.mobility.clone_from(&coefficients.mobility);
        flow.capacity.clone_from(&coefficients.capacity);
        coupling.divergence.weight.clone_from(&coefficients.biot);
        fracture.aperture.clone_from(&coefficients.aperture);
        if let Some(cracks) = &mut fracture.cracks {
            cracks.donor.clone_from(&coefficients.donor);
            cracks.opening.clone_from(&coefficients.opening);
            cracks.pores.clone_from(&coefficients.pores);
            cracks.voids.clone_from(&coefficients.voids);
            cracks.sealed.clone_from(&coefficients.sealed);
        }
        if coefficients.conductance.is_empty() {
            flow.refill();
            fracture.conduct(flow, permeability);
            flow.follow_walls();
        } else {
            flow.conductance.clone_from(&coefficients.conductance);
            flow.walls.clone_from(&coefficients.walls);
        }
        model
    }
}
