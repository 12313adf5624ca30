//! Biot's coupling: Q u̇ + S ṗ + L p = q and K u − Qᵀ p = f.

use perifrac_solvers::{Lattice, dot};

use crate::geometry::Cloud;
use crate::operators::Divergence;
use crate::plan::Plan;
use crate::plan::capability::System;

use super::lattice::lattice;
use super::properties::Properties;
use super::{Fields, Model, MovingWall, SolidModel};

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
    /// The points as a lattice whose rows repeat where both fields are one system, or why they are none.
    pub lattice: Result<Lattice, String>,
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
            lattice: lattice(plan, cloud, points, System::Monolithic),
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
        self.divergence.add(&solid.elastic, displacement, content);
        for (wall, place) in solid.walls.iter().zip(walls) {
            for &(point, own) in &wall.content {
                content[point as usize] += own * place;
            }
        }
    }

    /// Adds Qᵀ p to `force`, shape `(n·D,)`, N.
    pub fn add_pressure_force<const D: usize>(
        &self,
        solid: &SolidModel<D>,
        pressure: &[f64],
        force: &mut [f64],
    ) {
        self.divergence.add_adjoint(&solid.elastic, pressure, force);
    }

    /// β V per point for a factor of the fixed-stress term, and S + β V for the given capacity, m^D/Pa.
    pub fn split(&self, relaxation: f64, capacity: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let split: Vec<f64> = self
            .fixed_stress
            .iter()
            .map(|own| relaxation * own)
            .collect();
        let storage = capacity.iter().zip(&split).map(|(c, b)| c + b).collect();
        (split, storage)
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
        // Pores in cracks are sealed.
        for point in self.filled_points() {
            content[point] = 0.0;
        }
        content
    }

    /// Forces out of balance at `time`, f − K u − r w + Qᵀ p, shape `(n·D,)`, N, and their scale: Σ|f| + Σ|Qᵀp|,
    /// and the force of the in-situ stress.
    pub fn unbalanced(&self, time: f64, state: &Fields<'_>) -> (Vec<f64>, f64) {
        let Some(solid) = &self.solid else {
            return (Vec::new(), 0.0);
        };
        let External { loads, push, scale } =
            self.external(solid, time, state.pressure, state.walls);
        let mut force: Vec<f64> = loads.iter().zip(&push).map(|(f, p)| f + p).collect();
        self.subtract_force(solid, state, &mut force);
        (force, scale)
    }

    /// Forces on the solid from loads at `time` and from the pressure, shape `(n·D,)`, N.
    pub fn external_force(&self, time: f64, pressure: &[f64]) -> Vec<f64> {
        let Some(solid) = &self.solid else {
            return Vec::new();
        };
        let mut force = vec![0.0; solid.unknowns()];
        solid.loads(time, &mut force);
        if let Some(coupling) = &self.coupling {
            coupling.add_pressure_force(solid, &self.pore_pressure(pressure), &mut force);
        }
        force
    }

    /// Loads at `time` and the push of the pressure.
    fn external(
        &self,
        solid: &SolidModel<D>,
        time: f64,
        pressure: &[f64],
        walls: &[f64],
    ) -> External {
        let mut loads = vec![0.0; solid.unknowns()];
        solid.loads(time, &mut loads);
        let mut push = vec![0.0; solid.unknowns()];
        if let Some(coupling) = &self.coupling {
            coupling.add_pressure_force(solid, &self.pore_pressure(pressure), &mut push);
        }
        let size = |force: &[f64]| force.iter().map(|f| f.abs()).sum::<f64>();
        let at_wall = |(wall, place): (&MovingWall, &f64)| -> f64 {
            wall.response.iter().map(|(_, r)| (r * place).abs()).sum()
        };
        let at_walls: f64 = solid.walls.iter().zip(walls).map(at_wall).sum();
        External {
            scale: size(&loads) + size(&push) + at_walls + solid.in_situ_force,
            loads,
            push,
        }
    }

    /// Balance of forces and energies of a state; nothing without mechanics.
    pub fn audit(&self, state: &Fields<'_>) -> Option<Audit> {
        let &Fields {
            time,
            pressure,
            displacement,
            walls,
            ..
        } = state;
        let solid = self.solid.as_ref()?;
        let External { loads, push, scale } = self.external(solid, time, pressure, walls);
        let size = |force: &[f64]| force.iter().map(|f| f.abs()).sum::<f64>();
        let mut force: Vec<f64> = loads.iter().zip(&push).map(|(f, p)| f + p).collect();
        if let Some(response) = self.response(state) {
            solid.subtract_internal_force(&response, &mut force);
            let held = solid.wall_forces(&response);
            let elastic = response.energy(&response.hourglass);
            let energy = elastic + self.stored_energy(pressure);
            return Some(Audit {
                unbalanced: size(&force),
                forces: size(&loads)
                    + size(&push)
                    + size(&held)
                    + self.crack_push(&response)
                    + solid.in_situ_force,
                energy,
                potential: energy - dot(&loads, displacement),
                elastic,
                loads,
                held,
                left: force,
            });
        }
        let outer = dot(&force, displacement);
        solid.subtract_internal(displacement, walls, &mut force);
        // u·(K u + r w) is what the external forces do less what is left of them.
        let inner = outer - dot(&force, displacement);
        let elastic = 0.5 * (inner + solid.wall_work(displacement, walls));
        let energy = elastic + self.stored_energy(pressure);
        let pore = self.coupling.as_ref().map_or(&[][..], |_| pressure);
        Some(Audit {
            unbalanced: size(&force),
            forces: scale,
            energy,
            potential: energy - dot(&loads, displacement) - solid.plate_work(time, walls),
            elastic,
            held: solid.internal_wall_force(displacement, walls, pore),
            loads,
            left: force,
        })
    }

    /// ½ pᵀSp, the stabilising storage included, J (per metre of thickness in 2-D).
    fn stored_energy(&self, pressure: &[f64]) -> f64 {
        let Some(flow) = &self.flow else { return 0.0 };
        let held = flow.capacity.iter().zip(pressure).map(|(c, p)| c * p * p);
        let mut rough = vec![0.0; pressure.len()];
        flow.subtract_stabilisation(pressure, &mut rough);
        0.5 * (held.sum::<f64>() - dot(&rough, pressure))
    }
}

/// Forces on the solid from outside, N, and Σ of their absolute values.
struct External {
    loads: Vec<f64>,
    push: Vec<f64>,
    scale: f64,
}

/// Balance of forces and energies of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Audit {
    /// Forces out of balance, Σ of their absolute values, N.
    pub unbalanced: f64,
    /// All forces, Σ|f| + Σ|Qᵀp| and what walls exert, N.
    pub forces: f64,
    /// Energy of Eq. 73, ½ uᵀKu + ½ pᵀSp, J (per metre of thickness in 2-D).
    pub energy: f64,
    /// The energy less the work of the loads that act now, J.
    pub potential: f64,
    /// Elastic energy, J, without that of the fluid.
    pub elastic: f64,
    /// Loads on the displacement, N, shape `(n·D,)`.
    pub loads: Vec<f64>,
    /// Forces that hold the walls, N.
    pub held: Vec<f64>,
    /// Forces out of balance, N, shape `(n·D,)`.
    pub left: Vec<f64>,
}
