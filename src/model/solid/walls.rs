//! Walls that a solid moves with: their place, the force on them, and the work that is done there.

use nalgebra::DMatrix;
use perifrac_solvers::dot;

use super::{SolidModel, sparse};
use crate::geometry::{Side, Vector};
use crate::model::walls::{Drive, MovingWall, moving};
use crate::operators::Divergence;
use crate::plan::MechanicsPlan;

impl<const D: usize> SolidModel<D> {
    pub(super) fn build_walls(&mut self, mechanics: &MechanicsPlan, coupling: Option<&Divergence>) {
        let elastic = &self.elastic;
        let drives: Vec<(Side, usize, Drive)> = Side::all(D)
            .flat_map(|side| moving(&mechanics.sides[side.index()], side))
            .collect();
        let offset = |(side, component, _): &(Side, usize, Drive), bond: usize| {
            let mut unit = vec![0.0; 2 * D];
            unit[side.index()] = 1.0;
            let image = elastic.around.families.image(bond);
            let mut value = Vector::<D>::zeros();
            value[*component] = elastic.extension[*component].wall_offset(image, &unit);
            value
        };
        let forces: Vec<Vec<Vector<D>>> = drives
            .iter()
            .map(|drive| elastic.bond_forces(|_, bond| offset(drive, bond)))
            .collect();
        let families = &elastic.around.families;
        let own = |point: &usize| families.share.owns(*point);
        self.wall_stiffness = DMatrix::from_fn(drives.len(), drives.len(), |k, l| {
            (0..families.len())
                .filter(own)
                .flat_map(|point| families.family(point))
                .map(|bond| forces[k][bond].dot(&offset(&drives[l], bond)))
                .sum()
        });
        families.share.sum(self.wall_stiffness.as_mut_slice());
        self.walls = drives
            .iter()
            .zip(&forces)
            .map(|(wall, forces)| MovingWall {
                side: wall.0,
                component: wall.1,
                drive: wall.2.clone(),
                bonds: (0..families.len())
                    .flat_map(|point| families.family(point))
                    .map(|bond| (bond as u32, offset(wall, bond)[wall.1]))
                    .filter(|(_, offset)| *offset != 0.0)
                    .collect(),
                response: sparse(elastic.gather(forces)),
                implied: 0.0,
                content: coupling.map_or_else(Vec::new, |coupling| {
                    let of = |i| coupling.of_differences(elastic, i, |bond| offset(wall, bond));
                    let mut content: Vec<f64> = (0..elastic.points()).map(of).collect();
                    families.share.complete(&mut content, 1);
                    sparse(content)
                }),
            })
            .collect();
    }

    /// Sets the walls of prescribed displacement to their place at `time`, m.
    pub fn place_walls(&self, time: f64, walls: &mut [f64]) {
        for (wall, place) in self.walls.iter().zip(walls) {
            if let Drive::Displacement(load) = &wall.drive {
                *place = load.at(time);
            }
        }
    }

    /// Force that is left over at each wall at `time`, N: the drive of a plate less what the body and
    /// the pressure ask for; for prescribed walls minus the reaction.
    pub fn wall_residual(
        &self,
        time: f64,
        displacement: &[f64],
        walls: &[f64],
        pressure: &[f64],
    ) -> Vec<f64> {
        let internal = self.internal_wall_force(displacement, walls, pressure);
        let drive = |wall: &MovingWall| match &wall.drive {
            Drive::Force(load) => load.at(time) + wall.implied,
            Drive::Displacement(_) => 0.0,
        };
        self.walls
            .iter()
            .zip(internal)
            .map(|(wall, own)| drive(wall) - own)
            .collect()
    }

    /// Forces that drive the plates at `time`, in absolute amounts, N.
    pub fn drive(&self, time: f64) -> f64 {
        let force = |wall: &MovingWall| match &wall.drive {
            Drive::Force(load) => load.at(time).abs(),
            Drive::Displacement(_) => 0.0,
        };
        self.walls.iter().map(force).sum()
    }

    /// rᵀ u + k w − qᵀ p per wall, N: the force that holds it there. `pressure` may be empty.
    pub fn internal_wall_force(
        &self,
        displacement: &[f64],
        walls: &[f64],
        pressure: &[f64],
    ) -> Vec<f64> {
        let row = |(k, wall): (usize, &MovingWall)| {
            let solid: f64 = wall
                .response
                .iter()
                .map(|&(i, r)| r * displacement[i as usize])
                .sum();
            let others: f64 = walls
                .iter()
                .enumerate()
                .map(|(l, w)| self.wall_stiffness[(k, l)] * w)
                .sum();
            let push = |&(i, q): &(u32, f64)| q * pressure.get(i as usize).unwrap_or(&0.0);
            solid + others - wall.content.iter().map(push).sum::<f64>()
        };
        self.walls.iter().enumerate().map(row).collect()
    }

    /// Indices of the walls that find their own place.
    pub fn plates(&self) -> Vec<usize> {
        let free = |k: &usize| matches!(self.walls[*k].drive, Drive::Force(_));
        (0..self.walls.len()).filter(free).collect()
    }

    /// w·(rᵀu + k w): the work of what holds the walls, J (per metre of thickness in 2-D).
    pub fn wall_work(&self, displacement: &[f64], walls: &[f64]) -> f64 {
        dot(&self.internal_wall_force(displacement, walls, &[]), walls)
    }

    /// Work Fᵀw of the forces on the plates at `time`, J.
    pub fn plate_work(&self, time: f64, walls: &[f64]) -> f64 {
        let work = |(wall, place): (&MovingWall, &f64)| match &wall.drive {
            Drive::Force(load) => (load.at(time) + wall.implied) * place,
            Drive::Displacement(_) => 0.0,
        };
        self.walls.iter().zip(walls).map(work).sum()
    }
}
