//! Walls: displacement components of plane sides, and which of them move.

use crate::geometry::Side;
use crate::load::Load;
use crate::operators::Parity;
use crate::plan::{MechanicsPlan, Support};

/// A displacement component of a plane side that moves.
#[derive(Debug, Clone)]
pub struct MovingWall {
    /// The side.
    pub side: Side,
    /// The component of the displacement.
    pub component: usize,
    /// What moves it.
    pub drive: Drive,
    /// Bonds that reach across the wall, and by how much its motion stretches them, sparse.
    pub bonds: Vec<(u32, f64)>,
    /// Force on every unknown per metre of the wall, sparse: column r of the stiffness, N/m.
    pub response: Vec<(u32, f64)>,
    /// Constant force on a plate that balances the in-situ state, N; zero for other walls and without one.
    pub implied: f64,
    /// Pore volume gained by every point per metre of the wall, sparse, m^(D−1).
    pub content: Vec<(u32, f64)>,
}

/// What moves a wall.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// A prescribed displacement over time, m.
    Displacement(Load),
    /// A rigid plate under a resultant force over time, N.
    Force(Load),
}

/// What a displacement component does at a side.
pub(super) fn parity(support: &Support, side: Side, component: usize) -> Parity {
    match support {
        Support::Free | Support::Traction(_) => Parity::OneSided,
        Support::Roller(_) | Support::Plate(_) if component != side.axis => Parity::Even,
        Support::Roller(_) | Support::Plate(_) | Support::Prescribed(_) => Parity::Odd,
    }
}

/// Sides and components whose displacement is prescribed and not always zero, in the order of
/// [`SolidModel::walls`](super::SolidModel::walls).
pub fn driven_walls<const D: usize>(mechanics: &MechanicsPlan) -> Vec<(Side, usize)> {
    Side::all(D)
        .flat_map(|side| moving(&mechanics.sides[side.index()], side))
        .map(|(side, component, _)| (side, component))
        .collect()
}

/// The walls of a side that move.
pub(super) fn moving(support: &Support, side: Side) -> Vec<(Side, usize, Drive)> {
    let wall = |(component, load): (usize, &Load)| {
        (!load.is_zero()).then(|| (side, component, Drive::Displacement(load.clone())))
    };
    match support {
        Support::Free | Support::Traction(_) => Vec::new(),
        Support::Roller(load) => wall((side.axis, load)).into_iter().collect(),
        Support::Prescribed(loads) => loads.iter().enumerate().filter_map(wall).collect(),
        Support::Plate(force) => vec![(side, side.axis, Drive::Force(force.clone()))],
    }
}
