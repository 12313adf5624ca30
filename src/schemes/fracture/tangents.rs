//! The stiffness of a damaged solid: refilled where its tangents moved.

use perifrac_solvers::CsrMatrix;

use crate::assembly::{Moduli, fill_rows};
use crate::geometry::{Matrix, Vector};
use crate::material::{Softening, Tangent};
use crate::model::SolidModel;
use crate::operators::{Answer, Damage, Elastic};

/// Change of a tangent, relative to the intact moduli, below which its rows are kept.
pub const KEPT: f64 = 1e-3;

/// Change of the weakest modulus, relative to itself, above which they are not.
const STALE: f64 = 0.1;

/// Tangents of all points and the matrix made of them.
pub struct TangentMatrix<const D: usize> {
    /// K over unknowns, N/m.
    pub matrix: CsrMatrix,
    tangents: Vec<Tangent<D>>,
    /// Share of the hourglass stiffness that is left per point.
    integrity: Vec<f64>,
    /// Change below which rows are kept; 0 refills all that changed at all.
    pub kept: f64,
    /// Families refilled so far.
    pub refilled: u64,
}

struct Damaged<'a, const D: usize> {
    elastic: &'a Elastic<D>,
    tangents: &'a [Tangent<D>],
    integrity: &'a [f64],
}

impl<const D: usize> Moduli<D> for Damaged<'_, D> {
    fn stresses(&self, owner: usize, weight: &Vector<D>) -> [Matrix<D>; D] {
        self.tangents[owner].stresses(weight, self.elastic.around.cloud.volume[owner])
    }

    fn hourglass(&self, owner: usize) -> f64 {
        self.integrity[owner]
    }
}

impl<const D: usize> TangentMatrix<D> {
    /// Matrix of intact rock, not filled yet.
    pub fn new(solid: &SolidModel<D>) -> Self {
        let tangents = solid
            .elastic
            .lame
            .iter()
            .map(|lame| Tangent::elastic(*lame));
        TangentMatrix {
            matrix: solid.stiffness.clone(),
            tangents: tangents.collect(),
            integrity: vec![1.0; solid.elastic.points()],
            kept: KEPT,
            refilled: 0,
        }
    }

    /// Brings the matrix to an answer; false if nothing moved.
    pub fn update(
        &mut self,
        solid: &SolidModel<D>,
        damage: &Damage<D>,
        history: &[f64],
        answer: &Answer<D>,
        softening: Softening,
    ) -> bool {
        let elastic = &solid.elastic;
        let next = damage.tangents(elastic, history, answer, softening);
        let moved = |i: usize| {
            let integrity = answer.hourglass[i] / self.integrity[i] - 1.0;
            let distance = next[i].distance(&self.tangents[i], elastic.lame[i]);
            // What is nearly gone must not keep a stiffness many times its own.
            let weakest = next[i].shear.amin() / elastic.lame[i].mu;
            distance > self.kept.min(STALE * weakest) || integrity.abs() > STALE
        };
        let changed: Vec<bool> = (0..next.len()).map(moved).collect();
        let count = changed.iter().filter(|changed| **changed).count();
        if count == 0 {
            return false;
        }
        for i in (0..next.len()).filter(|i| changed[*i]) {
            self.tangents[i] = next[i];
            self.integrity[i] = answer.hourglass[i];
        }
        let moduli = Damaged {
            elastic,
            tangents: &self.tangents,
            integrity: &self.integrity,
        };
        fill_rows(
            elastic,
            &moduli,
            Some(&changed),
            &solid.points,
            self.matrix.data_mut(),
        );
        self.refilled += count as u64;
        true
    }

    /// Forces on the points where the walls move by `moves` (m) and the points do not, N.
    pub fn wall_push(&self, solid: &SolidModel<D>, moves: &[f64]) -> Vec<f64> {
        let still = vec![0.0; solid.unknowns()];
        let forces = solid.elastic.bond_forces_of(
            |owner, bond| solid.difference(&still, moves, owner, bond),
            |owner, strain| (self.tangents[owner].stress(strain), self.integrity[owner]),
        );
        solid.elastic.gather(&forces)
    }
}
