//! Flow where rock is broken: in the split model along the crack beside the flow in the rock, in that of the paper
//! with properties between those of rock and of a crack (Eqs. 40 to 46).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::crack_flow::{CrackFlow, Spreading, WET};
use super::{Coupling, FlowModel, Model, SolidModel};
use crate::effects::aperture;
use crate::operators::Response;
use crate::parallel;
use crate::plan::{FractureFlowPlan, Plan, TransmissivityRule};

/// Properties of the intact rock, and how they change with damage.
#[derive(Clone)]
pub struct FractureFlow<const D: usize> {
    /// What the plan says.
    pub plan: FractureFlowPlan,
    /// Permeability of the rock per point, m².
    permeability: Vec<f64>,
    /// Storage s V of the rock per point, m^D/Pa; empty in the split model, like the next.
    capacity: Vec<f64>,
    /// α V of the rock per point, m^D.
    weight: Vec<f64>,
    /// Viscosity of the fluid in the rock, Pa s.
    viscosity: f64,
    /// Opening per point, m, shape `(n,)`; 0 where the rock is intact.
    pub aperture: Vec<f64>,
    /// Fluid in cracks, in the split model.
    pub cracks: Option<CrackFlow<D>>,
    /// Openings evaluated so far, by all clones.
    evaluations: Arc<AtomicU64>,
}

/// Damage below the upper threshold that counts as it: damage never reaches 1.
const NEARLY: f64 = 1e-3;

impl<const D: usize> FractureFlow<D> {
    /// Keeps the properties of the rock; `None` if the plan does not name flow in fractures.
    pub(super) fn of(
        plan: &Plan,
        flow: Option<&FlowModel<D>>,
        coupling: Option<&Coupling>,
        permeability: &[f64],
    ) -> Option<Self> {
        let (own, flow, coupling) = (plan.fracture_flow?, flow?, coupling?);
        let bonds = flow.crack_bonds.clone();
        // Only the paper mixes storage and Biot's coefficient with those of a crack.
        let mixed = |rock: &[f64]| match bonds {
            Some(_) => Vec::new(),
            None => rock.to_vec(),
        };
        Some(FractureFlow {
            plan: own,
            permeability: permeability.to_vec(),
            capacity: mixed(&flow.capacity),
            weight: mixed(&coupling.divergence.weight),
            viscosity: plan.fluid.viscosity,
            aperture: vec![0.0; flow.points()],
            cracks: bonds.map(|bonds| {
                CrackFlow::new(bonds, flow.conductance.clone(), own.residual_aperture)
            }),
            evaluations: Arc::default(),
        })
    }

    /// Openings evaluated so far.
    pub fn evaluations(&self) -> u64 {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let own = [
            &self.permeability,
            &self.capacity,
            &self.weight,
            &self.aperture,
        ];
        let own: usize = own.iter().map(|values| values.len()).sum();
        8 * own + self.cracks.as_ref().map_or(0, CrackFlow::bytes)
    }

    /// Share χ_f of a fracture at a damage (Eqs. 43 and 44).
    ///
    /// In the split model a point is wet or not.
    pub fn share(&self, damage: f64) -> f64 {
        if self.cracks.is_some() {
            return f64::from(damage > WET);
        }
        let (low, high) = (
            self.plan.lower_threshold,
            self.plan.upper_threshold - NEARLY,
        );
        ((damage - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// Permeability of a crack of an opening (m) in a band of half width `horizon` (m) in rock of
    /// permeability `rock`, m². A closed crack conducts like the rock.
    fn crack(&self, opening: f64, horizon: f64, rock: f64) -> f64 {
        if let Some(given) = self.plan.permeability {
            return given;
        }
        let cubic = opening * opening / 12.0;
        rock + match self.plan.transmissivity {
            TransmissivityRule::Paper => cubic,
            TransmissivityRule::Cubic => cubic * opening / (2.0 * horizon),
        }
    }

    /// Openings of all broken points.
    fn open(
        &mut self,
        solid: &SolidModel<D>,
        response: &Response<D>,
        displacement: &[f64],
        walls: &[f64],
    ) {
        let this = &*self;
        let share = |i: usize| this.share(response.damage[i]);
        let broken = |i: usize| share(i) > 0.0;
        let at = |i: usize| match broken(i) {
            false => 0.0,
            true => {
                let difference = |bond| solid.difference(displacement, walls, i, bond);
                aperture(
                    this.plan.aperture,
                    &solid.elastic,
                    response,
                    i,
                    difference,
                    share,
                )
            }
        };
        let openings: Vec<f64> = parallel::map(response.damage.len(), at);
        let evaluated = (0..openings.len()).filter(|i| broken(*i)).count();
        self.evaluations
            .fetch_add(evaluated as u64, Ordering::Relaxed);
        self.aperture = openings;
    }
}

impl<const D: usize> FractureFlow<D> {
    /// Brings the fluid in cracks to a response, and what it conducts into L.
    fn fill_cracks(
        &mut self,
        solid: &SolidModel<D>,
        (response, spreading): (&Response<D>, Option<Spreading>),
        flow: &mut FlowModel<D>,
        permeability: &mut [f64],
    ) {
        let Some(cracks) = &mut self.cracks else {
            return;
        };
        cracks.follow(&solid.elastic, response, spreading);
        let evaluated = (0..flow.points()).filter(|i| cracks.is_wet(*i)).count();
        self.evaluations
            .fetch_add(evaluated as u64, Ordering::Relaxed);
        self.conduct(flow, permeability);
    }

    /// Puts what cracks conduct into L beside the rock, and into the permeability of points, m².
    pub(super) fn conduct(&mut self, flow: &mut FlowModel<D>, permeability: &mut [f64]) {
        let Some(cracks) = &self.cracks else { return };
        let viscosity = self.plan.viscosity.unwrap_or(self.viscosity);
        flow.conductance.clone_from(&cracks.rock);
        flow.add_conductances(cracks.conductances(viscosity, self.plan.permeability));
        for (i, own) in cracks.opening.iter().enumerate() {
            self.aperture[i] = own.opening;
            permeability[i] = self.permeability[i];
            if cracks.is_wet(i) {
                permeability[i] += cracks.permeability(*own, self.plan.permeability);
            }
        }
    }
}

impl<const D: usize> Model<D> {
    /// Brings permeability, storage and Biot's coefficient to the damage and the openings of a state,
    /// and fills L anew; nothing without flow in fractures.
    pub fn follow_fractures(
        &mut self,
        response: &Response<D>,
        (displacement, walls): (&[f64], &[f64]),
        spreading: Spreading,
    ) {
        let timers = self.timers.clone();
        let mix = || match self.has_crack_content() {
            true => self.fill_cracks(response, Some(spreading)),
            false => self.mix_fractures(response, displacement, walls),
        };
        timers.time("flow", mix);
    }

    /// Brings what cracks conduct to the openings of a state, in the split model; their pressure acts where it did.
    pub fn follow_openings(&mut self, response: &Response<D>) {
        let timers = self.timers.clone();
        timers.time("flow", || self.fill_cracks(response, None));
    }

    /// Takes the pressure of cracks off points that nothing leads to as passes have left them; true if there are any.
    pub fn withdraw_fluid(&mut self, response: &Response<D>) -> bool {
        let (Some(fracture), Some(solid)) = (&mut self.fracture_flow, &self.solid) else {
            return false;
        };
        let cracks = fracture.cracks.as_mut();
        cracks.is_some_and(|cracks| cracks.withdraw(&solid.elastic, response))
    }

    fn fill_cracks(&mut self, response: &Response<D>, spreading: Option<Spreading>) {
        let Model {
            fracture_flow: Some(fracture),
            flow: Some(flow),
            solid: Some(solid),
            permeability,
            ..
        } = self
        else {
            return;
        };
        fracture.fill_cracks(solid, (response, spreading), flow, permeability);
    }

    fn mix_fractures(&mut self, response: &Response<D>, displacement: &[f64], walls: &[f64]) {
        let Model {
            fracture_flow: Some(fracture),
            flow: Some(flow),
            solid: Some(solid),
            coupling: Some(coupling),
            permeability,
            cloud,
            ..
        } = self
        else {
            return;
        };
        fracture.open(solid, response, displacement, walls);
        let horizon = &solid.elastic.around.families.horizon;
        let viscosity = fracture.plan.viscosity.unwrap_or(fracture.viscosity);
        for i in 0..flow.points() {
            let open = fracture.share(response.damage[i]);
            let mix = |rock: f64, crack: f64| rock + open * (crack - rock);
            let (rock, volume) = (fracture.permeability[i], cloud.volume[i]);
            let crack = fracture.crack(fracture.aperture[i], horizon[i], rock);
            permeability[i] = mix(rock, crack);
            flow.mobility[i] = permeability[i] / mix(fracture.viscosity, viscosity);
            let stored = fracture
                .plan
                .storage
                .map_or(fracture.capacity[i], |s| s * volume);
            flow.capacity[i] = mix(fracture.capacity[i], stored);
            let weight = fracture.plan.biot_coefficient * volume;
            coupling.divergence.weight[i] = mix(fracture.weight[i], weight);
        }
        flow.refill();
        flow.follow_walls();
    }
}
