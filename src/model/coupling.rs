//! Biot's coupling: Q u̇ + S ṗ + L p = q and K u − Qᵀ p = f.

use perifrac_solvers::dot;

use crate::geometry::Cloud;
use crate::operators::Divergence;
use crate::plan::Plan;

use super::properties::Properties;
use super::{Drive, Model, SolidModel};

/// What couples flow and mechanics.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Q.
    pub divergence: Divergence,
    /// V α²/K_dr per point with the drained bulk modulus of the dimension, K_dr = λ + 2μ/D: the
    /// storage that the fixed-stress split adds to both sides, m^D/Pa, shape `(n,)`.
    pub fixed_stress: Vec<f64>,
    /// V α²/(λ + 2μ) per point: storage by strain under oedometric conditions, m^D/Pa.
    pub oedometric: Vec<f64>,
    /// Whether loads at the start meet an undrained body.
    pub undrained_start: bool,
}

impl Coupling {
    pub(super) fn new<const D: usize>(plan: &Plan, cloud: &Cloud<D>, points: &Properties) -> Self {
        let biot = &points.biot_coefficient;
        let storage = |i: usize, modulus: f64| cloud.volume[i] * biot[i].powi(2) / modulus;
        let per_point = |share: f64| -> Vec<f64> {
            let modulus = |i: usize| points.lame[i].lambda + share * points.lame[i].mu;
            (0..cloud.len()).map(|i| storage(i, modulus(i))).collect()
        };
        Coupling {
            divergence: Divergence {
                weight: biot.iter().zip(&cloud.volume).map(|(a, v)| a * v).collect(),
            },
            fixed_stress: per_point(2.0 / D as f64),
            oedometric: per_point(2.0),
            undrained_start: plan
                .coupling
                .is_some_and(|coupling| coupling.undrained_start),
        }
    }

    /// Adds Q u + q w to `content`, shape `(n,)`, m^D: the pore volume that strain gains.
    pub fn add_content<const D: usize>(
        &self,
        solid: &SolidModel<D>,
        displacement: &[f64],
        walls: &[f64],
        content: &mut [f64],
    ) {
        self.divergence
            .add(&solid.elastic, displacement, 1.0, content);
        for (wall, place) in solid.walls.iter().zip(walls) {
            for &(point, own) in &wall.content {
                content[point as usize] += own * place;
            }
        }
    }

    /// Adds Qᵀ p to `force`, shape `(n·D,)`, N.
    pub fn add_push<const D: usize>(
        &self,
        solid: &SolidModel<D>,
        pressure: &[f64],
        force: &mut [f64],
    ) {
        self.divergence
            .add_adjoint(&solid.elastic, pressure, 1.0, force);
    }

    /// Largest α²/(s(λ + 2μ)) of all points: beyond 1 a split with lagged strain diverges.
    pub fn strength(&self, capacity: &[f64]) -> f64 {
        let ratios = self
            .oedometric
            .iter()
            .zip(capacity)
            .map(|(strain, own)| strain / own);
        ratios.fold(0.0, f64::max)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        8 * (self.divergence.weight.len() + self.fixed_stress.len() + self.oedometric.len())
    }
}

impl<const D: usize> Model<D> {
    /// Pore volume gained per point by strain, Q u + q w; zero without coupling.
    pub fn content(&self, displacement: &[f64], walls: &[f64]) -> Vec<f64> {
        let mut content = vec![0.0; self.cloud.len()];
        if let (Some(coupling), Some(solid)) = (&self.coupling, &self.solid) {
            coupling.add_content(solid, displacement, walls, &mut content);
        }
        content
    }

    /// Forces out of balance, f − K u − r w + Qᵀ p, shape `(n·D,)`, N, and their scale Σ|f| + Σ|Qᵀp|.
    pub fn unbalanced(
        &self,
        time: f64,
        pressure: &[f64],
        displacement: &[f64],
        walls: &[f64],
    ) -> (Vec<f64>, f64) {
        let Some(solid) = &self.solid else {
            return (Vec::new(), 0.0);
        };
        let mut force = vec![0.0; displacement.len()];
        solid.loads(time, &mut force);
        let size = |force: &[f64]| force.iter().map(|f| f.abs()).sum::<f64>();
        let mut scale = size(&force);
        if let Some(coupling) = &self.coupling {
            let mut push = vec![0.0; displacement.len()];
            coupling.add_push(solid, pressure, &mut push);
            scale += size(&push);
            force.iter_mut().zip(&push).for_each(|(f, p)| *f += p);
        }
        for (wall, place) in solid.walls.iter().zip(walls) {
            scale += wall
                .response
                .iter()
                .map(|(_, r)| (r * place).abs())
                .sum::<f64>();
        }
        solid.subtract_internal(displacement, walls, &mut force);
        (force, scale)
    }

    /// Work fᵀu + Fᵀw of the loads at `time` on a displacement from rest, J.
    pub fn load_work(&self, time: f64, displacement: &[f64], walls: &[f64]) -> f64 {
        let Some(solid) = &self.solid else { return 0.0 };
        let mut force = vec![0.0; displacement.len()];
        solid.loads(time, &mut force);
        let driven = solid
            .walls
            .iter()
            .zip(walls)
            .map(|(wall, w)| match &wall.drive {
                Drive::Force(load) => load.at(time) * w,
                Drive::Displacement(_) => 0.0,
            });
        dot(&force, displacement) + driven.sum::<f64>()
    }

    /// Energy of Eq. 73, ½ uᵀKu + ½ pᵀSp, J (per metre of thickness in 2-D).
    pub fn energy(&self, pressure: &[f64], displacement: &[f64], walls: &[f64]) -> f64 {
        let solid = self
            .solid
            .as_ref()
            .map_or(0.0, |s| s.strain_energy(displacement, walls));
        let fluid = self.flow.as_ref().map_or(0.0, |flow| {
            let terms = flow
                .capacity
                .iter()
                .zip(pressure)
                .map(|(c, p)| 0.5 * c * p * p);
            terms.sum::<f64>()
        });
        solid + fluid
    }
}
