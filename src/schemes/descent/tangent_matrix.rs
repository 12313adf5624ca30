//! The stiffness of a damaged solid: refilled where its tangents moved.

use perifrac_solvers::CsrMatrix;

use crate::assembly::{Moduli, fill_rows};
use crate::geometry::{Matrix, Vector};
use crate::material::{Tangent, TangentKind};
use crate::model::SolidModel;
use crate::operators::{Damage, DamageFields, Elastic, Response};
use crate::parallel;
use crate::plan::DescentSettings;

/// Tangents of all points and the matrix made of them.
pub(crate) struct TangentMatrix<const D: usize> {
    /// K over unknowns, N/m.
    pub matrix: CsrMatrix,
    tangents: Vec<Tangent<D>>,
    /// Share of the hourglass stiffness that is left per point.
    integrity: Vec<f64>,
    /// Derivative of the driving energy of families that soften by their bond differences, N, shape
    /// `(bonds,)`.
    drives: Vec<Vector<D>>,
    /// Changes below which rows are kept; 0 refills all that changed at all.
    kept: f64,
    /// Change of the weakest modulus above which they are not.
    worn: f64,
    /// Families refilled so far.
    pub refilled: u64,
    /// Whether the matrix belongs to nothing yet.
    stale: bool,
}

struct Damaged<'a, const D: usize> {
    elastic: &'a Elastic<D>,
    tangents: &'a [Tangent<D>],
    integrity: &'a [f64],
    drives: &'a [Vector<D>],
}

impl<const D: usize> Moduli<D> for Damaged<'_, D> {
    fn stresses(&self, owner: usize, weight: &Vector<D>) -> [Matrix<D>; D] {
        let volume = self.elastic.around.cloud.volume[owner];
        self.tangents[owner].firm().stresses(weight, volume)
    }

    fn drive(&self, owner: usize) -> Option<(f64, &[Vector<D>])> {
        let softening = self.tangents[owner].softening;
        if softening >= 0.0 {
            return None;
        }
        let around = &self.elastic.around;
        let family = around.families.family(owner);
        Some((softening / around.cloud.volume[owner], &self.drives[family]))
    }

    fn hourglass(&self, owner: usize) -> f64 {
        self.integrity[owner]
    }
}

impl<const D: usize> TangentMatrix<D> {
    /// Matrix of intact rock, not filled yet.
    pub(crate) fn new(solid: &SolidModel<D>, settings: &DescentSettings) -> Self {
        let tangents = solid
            .elastic
            .lame
            .iter()
            .map(|lame| Tangent::elastic(*lame));
        TangentMatrix {
            matrix: solid.stiffness.clone(),
            tangents: tangents.collect(),
            integrity: vec![1.0; solid.elastic.points()],
            drives: vec![Vector::zeros(); solid.elastic.around.families.bonds()],
            kept: settings.refill_threshold,
            worn: settings.weak_refill_threshold,
            refilled: 0,
            stale: true,
        }
    }

    /// Makes the next update fill all rows, so that they do not depend on earlier ones.
    pub(crate) fn forget(&mut self) {
        self.stale = true;
    }

    /// Brings the matrix to a response; false if nothing moved.
    pub(crate) fn update(
        &mut self,
        solid: &SolidModel<D>,
        damage: &Damage<D>,
        fields: DamageFields<'_>,
        response: &Response<D>,
        softening: TangentKind,
    ) -> bool {
        let elastic = &solid.elastic;
        let tangents = || damage.tangents(elastic, fields, response, softening);
        let next = solid.timers.time("laws", tangents);
        let stale = std::mem::take(&mut self.stale);
        let moved = |i: usize| {
            if stale {
                return true;
            }
            let integrity = response.hourglass[i] / self.integrity[i] - 1.0;
            let distance = next[i].distance(&self.tangents[i], elastic.lame[i]);
            // What is nearly gone must not keep a stiffness many times its own.
            let weakest = next[i].shear.amin() / elastic.lame[i].mu;
            distance > self.kept.min(self.worn * weakest) || integrity.abs() > self.worn
        };
        let changed: Vec<bool> = parallel::map(next.len(), moved);
        let count = changed.iter().filter(|changed| **changed).count();
        if count == 0 {
            return false;
        }
        for i in (0..next.len()).filter(|i| changed[*i]) {
            self.tangents[i] = next[i];
            self.integrity[i] = response.hourglass[i];
            if next[i].softening < 0.0 {
                let family = elastic.around.families.family(i);
                damage.drive(elastic, fields, response, i, &mut self.drives[family]);
            }
        }
        let moduli = Damaged {
            elastic,
            tangents: &self.tangents,
            integrity: &self.integrity,
            drives: &self.drives,
        };
        let values = self.matrix.data_mut();
        let fill = || fill_rows(elastic, &moduli, Some(&changed), &solid.points, values);
        solid.timers.time("assembly", fill);
        self.refilled += count as u64;
        true
    }

    /// Softening −q of a point (1/Pa) and the derivative of its driving energy by the bond differences of its family,
    /// N; nothing where it does not soften.
    pub(crate) fn softening(&self, elastic: &Elastic<D>, owner: usize) -> (f64, &[Vector<D>]) {
        match self.tangents[owner].softening {
            softening if softening < 0.0 => {
                let family = elastic.around.families.family(owner);
                (-softening, &self.drives[family])
            }
            _ => (0.0, &[]),
        }
    }

    /// Forces on the points where the walls move by `moves` (m) and the points do not, N.
    pub(crate) fn wall_push(&self, solid: &SolidModel<D>, moves: &[f64]) -> Vec<f64> {
        let still = vec![0.0; solid.unknowns()];
        let moved = |owner, bond| solid.difference(&still, moves, owner, bond);
        let mut forces = solid.elastic.bond_forces_of(moved, |owner, strain| {
            (
                self.tangents[owner].firm().stress(strain),
                self.integrity[owner],
            )
        });
        let moduli = Damaged {
            elastic: &solid.elastic,
            tangents: &self.tangents,
            integrity: &self.integrity,
            drives: &self.drives,
        };
        let families = &solid.elastic.around.families;
        for owner in 0..families.len() {
            let Some((factor, drive)) = moduli.drive(owner) else {
                continue;
            };
            let pairs = families.family(owner).zip(drive);
            let driven: f64 = pairs.map(|(bond, f)| f.dot(&moved(owner, bond))).sum();
            for (bond, f) in families.family(owner).zip(drive) {
                forces[bond] += f * (factor * driven);
            }
        }
        solid.elastic.gather(&forces)
    }
}
