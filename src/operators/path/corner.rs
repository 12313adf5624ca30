//! Bonds across the edges of lattice cells: how much of them stays where the four cells differ.
//!
//! In every plane of axes four cells meet at an edge, owner, one neighbour along each axis and the one
//! across. The bond across has conductance θ c, θ = (κ_min/κ_max)² over the four; the rest (1 − θ) c goes to
//! the faces, of which each gets it from every such group that it is in. First moments stay what they are
//! for every θ, so that uniform flow and layers in series remain exact; where all four are alike nothing
//! changes; and a channel or a barrier one cell wide is neither starved nor jumped over. θ falls smoothly:
//! with a threshold velocities converge irregularly.
//!
//! Where one of the bonds is missing, at sides without images and at cuts, θ is 0.

use super::super::Neighbourhood;
use super::cells::edge_weights;

/// Groups of three bonds of a family: across an edge, and through the two faces beside it.
#[derive(Debug, Clone, Default)]
pub(super) struct Corners {
    /// Places in the family, the one across first.
    bonds: Vec<[u8; 3]>,
    /// Start of every family's groups, shape `(n + 1,)`; empty without groups.
    offset: Vec<u32>,
}

/// θ for the smallest and largest mobility of four cells.
fn alike(low: f64, high: f64) -> f64 {
    (low / high).powi(2)
}

impl Corners {
    /// Finds the groups of all families of a lattice, whose bonds lead `steps` cells along the axes. What
    /// belongs to groups that are not complete goes to the faces in `geometric`.
    pub(super) fn find<const D: usize>(
        around: &Neighbourhood<D>,
        steps: &[[i8; D]],
        geometric: &mut [f64],
    ) -> Self {
        let edges = around.cloud.cell.first().map(edge_weights);
        let mut corners = Corners::default();
        corners.offset.push(0);
        for owner in 0..around.len() {
            let family = around.families.family(owner);
            let place =
                |wanted: [i8; D]| steps[family.clone()].iter().position(|own| *own == wanted);
            for axis in 0..D {
                for other in axis + 1..D {
                    for signs in [[-1, -1], [1, -1], [-1, 1], [1, 1]] {
                        let along = |own: [i8; 2]| {
                            let mut step = [0; D];
                            (step[axis], step[other]) = (own[0], own[1]);
                            place(step)
                        };
                        let faces = [along([signs[0], 0]), along([0, signs[1]])];
                        match (along(signs), faces) {
                            (Some(across), [Some(first), Some(second)]) => (corners.bonds)
                                .push([across, first, second].map(|place| place as u8)),
                            (across, faces) => {
                                let whole = edges.map_or(0.0, |edges| 0.5 * edges[axis][other]);
                                across
                                    .iter()
                                    .for_each(|k| geometric[family.start + k] = 0.0);
                                let faces = faces.iter().flatten();
                                faces.for_each(|k| geometric[family.start + k] += whole);
                            }
                        }
                    }
                }
            }
            corners.offset.push(corners.bonds.len() as u32);
        }
        corners
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bonds.is_empty()
    }

    /// Moves what cells that differ do not let pass across edges to the faces beside; `conductances` holds
    /// the geometric factors of the family of `owner` of mobility `own`, `end` the mobility at its bonds.
    pub(super) fn collapse(
        &self,
        owner: usize,
        own: f64,
        end: impl Fn(usize) -> f64,
        conductances: &mut [f64],
    ) {
        let Some(offsets) = self.offset.get(owner..owner + 2) else {
            return;
        };
        for &group in &self.bonds[offsets[0] as usize..offsets[1] as usize] {
            let group = group.map(usize::from);
            let (low, high) = group
                .iter()
                .map(|place| end(*place))
                .fold((own, own), |(low, high), mobility| {
                    (low.min(mobility), high.max(mobility))
                });
            let whole = conductances[group[0]];
            conductances[group[0]] = whole * alike(low, high);
            let moved = whole - conductances[group[0]];
            conductances[group[1]] += moved;
            conductances[group[2]] += moved;
        }
    }

    pub(super) fn bytes(&self) -> usize {
        3 * self.bonds.len() + 4 * self.offset.len()
    }
}
