//! Fluid in what is broken, in the split model: which points hold the fluid of the crack, and what they conduct.
//!
//! A point is wet from a small damage on. Where the crack goes on, points that are not wet yet feel the pressure of
//! a wet one whose crack points at them, and what opens there belongs to that one; without it fluid could never
//! break rock that is squeezed on a grid. Beside the crack there is no fluid but that of the pores, and rock breaks by
//! its effective stress.

use std::sync::Arc;

use super::cavitation::Voids;
use super::coefficients::Coefficients;
use super::diffusion::CrackBonds;
use crate::effects::{Opening, openings};
use crate::geometry::Vector;
use crate::material::eigen;
use crate::operators::{BondConductance, BondForm, Elastic, MirrorContinuation, Response};
use crate::parallel;

/// Where fluid is in what is broken.
#[derive(Clone)]
pub struct CrackFlow<const D: usize> {
    /// Point whose pressure acts in the crack here, shape `(n,)`; [`DRY`] for none.
    pub donor: Vec<u32>,
    /// Opening and width of the band, shape `(n,)`.
    pub opening: Vec<Opening>,
    /// What the pores of a point in a crack hold for good, m^D, shape `(n,)`; see [`super::Model::fill_broken`].
    pub pores: Vec<f64>,
    /// Pressure in the pores of a point in a crack, which stays, Pa, shape `(n,)`; 0 elsewhere.
    pub sealed: Vec<f64>,
    /// Volume without fluid of the points of cracks that hold any.
    pub voids: Voids,
    /// Hydraulic aperture of a closed crack, m.
    residual: f64,
    conduction: Arc<BondConductance<D>>,
    /// What the rock conducts: values of L without cracks, m^D/(Pa s).
    pub rock: Arc<Vec<f64>>,
    /// How the pressure goes on across the sides.
    extension: Arc<MirrorContinuation<D>>,
}

/// How far the pressure of a crack may reach in a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spreading {
    /// As far as the wet points lead.
    Anew,
    /// Beyond what has broken since the step began, too.
    Further,
}

/// No point at all.
pub const DRY: u32 = u32::MAX;
/// Damage from which a point conducts. Tip energy of a crack driven by fluid over G_c: 0.757, 0.794 and 0.784 for
/// 0.02, 0.1 and 0.4 *(prototype)*.
pub(crate) const WET: f64 = 0.1;
/// Cosine to the normal of a crack up to which a bond leads on along it.
const ALONG: f64 = 0.3;
/// Share of the storage of pores that a point in a crack keeps, so that a closed crack takes something up; without any
/// the system of a closed crack is singular. `kgd-leak-off` at 10 cm in rock that lets nothing in and stores ten times
/// as much keeps 0.705, 0.966, 0.9967 and 0.9997 of its fluid in the crack with 1e-2, 1e-3, 1e-4 and 1e-5; the passes of
/// `kgd-toughness/smoke` are 173, 235, 260 and 246.
pub(super) const KEPT: f64 = 1e-4;

impl<const D: usize> CrackFlow<D> {
    /// Nothing broken yet.
    pub fn new(bonds: CrackBonds<D>, rock: Vec<f64>, residual: f64) -> Self {
        let CrackBonds { around, extension } = bonds;
        let points = around.len();
        CrackFlow {
            donor: vec![DRY; points],
            opening: vec![Opening::default(); points],
            pores: vec![0.0; points],
            sealed: vec![0.0; points],
            voids: Voids::new(),
            residual,
            conduction: Arc::new(BondConductance::new(around)),
            rock: Arc::new(rock),
            extension,
        }
    }

    /// Whether a point conducts.
    pub fn is_wet(&self, point: usize) -> bool {
        self.donor[point] == point as u32
    }

    /// Brings the openings to a response, and where the pressure of the crack acts beside the wet points if that may
    /// change: in what has broken since the step began and where it leads on. Fluid only spreads in a step: passes
    /// would otherwise hand a point from one to another for ever.
    pub fn follow(
        &mut self,
        elastic: &Elastic<D>,
        response: &Response<D>,
        spreading: Option<Spreading>,
    ) {
        let wet: Vec<bool> = (0..self.donor.len()).map(|i| self.is_wet(i)).collect();
        self.opening = openings(elastic, response, &wet);
        let Some(spreading) = spreading else { return };
        let keeps = spreading == Spreading::Further;
        let fed = |i: usize| keeps && self.donor[i] != DRY && response.damage[i] > WET;
        let filled: Vec<bool> = (0..wet.len()).map(|i| wet[i] || fed(i)).collect();
        let axes = axes(elastic, response, &filled);
        let donor = |i: usize| match wet[i] || keeps && self.donor[i] != DRY {
            true => self.donor[i],
            false => continues(elastic, &axes, (&self.donor, &filled), i),
        };
        self.donor = parallel::map(wet.len(), donor);
    }

    /// Takes the pressure of the crack off points that nothing leads to as a response has left them: what led there in
    /// a pass is not broken any more. True if there are any.
    ///
    /// Otherwise they would feel the pressure where the step ends, and keep the damage that it does.
    pub fn withdraw(&mut self, elastic: &Elastic<D>, response: &Response<D>) -> bool {
        let points = self.donor.len();
        let mut filled: Vec<bool> = (0..points).map(|i| self.is_wet(i)).collect();
        let mut led = filled.clone();
        loop {
            let axes = axes(elastic, response, &filled);
            let leads = |i: usize| {
                let pressed = self.donor[i] != DRY;
                led[i] || pressed && continues(elastic, &axes, (&self.donor, &filled), i) != DRY
            };
            led = parallel::map(points, leads);
            let breaks = |i: usize| filled[i] || led[i] && response.damage[i] > WET;
            let next: Vec<bool> = (0..points).map(breaks).collect();
            if next == filled {
                break;
            }
            filled = next;
        }
        let left = |i: &usize| self.donor[*i] != DRY && !led[*i];
        let left: Vec<usize> = (0..points).filter(left).collect();
        left.iter().for_each(|i| self.donor[*i] = DRY);
        !left.is_empty()
    }

    /// Points that are broken and hold no fluid of a crack yet.
    pub fn broken(&self, damage: &[f64]) -> Vec<usize> {
        let broken = |i: &usize| damage[*i] > WET && !self.is_wet(*i);
        (0..damage.len()).filter(broken).collect()
    }

    /// Takes over the fluid of another run: where it is, what it opens, and what closed pores hold.
    pub(super) fn take_over(&mut self, then: &Coefficients, capacity: &mut [f64]) {
        self.donor.clone_from(&then.donor);
        self.opening.clone_from(&then.opening);
        self.pores.clone_from(&then.pores);
        self.voids.clone_from(&then.voids);
        self.sealed.clone_from(&then.sealed);
        let wet = (0..capacity.len()).filter(|i| self.is_wet(*i));
        wet.for_each(|i| capacity[i] *= KEPT);
    }

    /// Permeability of the band of a crack, (w³ + w_r³)/12W, m², unless one is `given`.
    pub fn permeability(&self, own: Opening, given: Option<f64>) -> f64 {
        let cubes = own.opening.powi(3) + self.residual.powi(3);
        given.unwrap_or(cubes / (12.0 * own.width))
    }

    /// The pressures that enter the traction on the crack at a point with Biot's coefficient `biot`, with their factors
    /// β: 1 for that in the crack, −α for that in the pores unless they are sealed; none where there is no fluid in the
    /// crack, and rock breaks by its effective stress. Where a crack is empty its pressure is known.
    pub fn pressing(&self, point: usize, biot: f64) -> impl Iterator<Item = (usize, f64)> + use<D> {
        let donor = self.donor[point];
        let fluid = (donor != DRY && !self.is_empty(donor)).then_some((donor as usize, 1.0));
        let pores = (donor != DRY && donor as usize != point).then_some((point, -biot));
        [pores, fluid].into_iter().flatten()
    }

    /// Conductances between wet points for a viscosity (Pa s): both points and the value, m^D/(Pa s); none through
    /// sides of prescribed pressure. With a given permeability (m²) that of the crack is not asked.
    ///
    /// The mean of both openings: the harmonic mean of their cubes would starve the tip.
    pub fn conductances(
        &self,
        viscosity: f64,
        permeability: Option<f64>,
    ) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        let families = &self.conduction.neighbourhood().families;
        let mobility = move |i: usize, j: usize| {
            let (one, other) = (self.opening[i], self.opening[j]);
            let between = Opening {
                opening: 0.5 * (one.opening + other.opening),
                width: 0.5 * (one.width + other.width),
            };
            self.permeability(between, permeability) / viscosity
        };
        let wet = (0..self.donor.len()).filter(|i| self.is_wet(*i));
        wet.flat_map(move |owner| {
            families.family(owner).filter_map(move |bond| {
                let end = families.neighbour(bond);
                let stays = self.extension.sign(families.image(bond)) > 0.0;
                let conducts = end != owner && stays && self.is_wet(end);
                let value = || self.conduction.geometric(owner, bond) * mobility(owner, end);
                conducts.then(|| (owner, end, value()))
            })
        })
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        (4 + 2 * 8 + size_of::<Opening>()) * self.donor.len()
            + 8 * self.rock.len()
            + BondForm::bytes(&*self.conduction)
    }
}

/// Normal of the crack at wet points: the axis of n ⊗ n on average over what is broken in the family; zero elsewhere.
///
/// The planes of single points fan out from the tip, those at the edge of the band by some 45°: with them the fluid
/// finds its way out of the band sidewards. In `kgd-viscosity` at 10 cm under equal in-situ stresses the pressure is 29 %
/// too large after 1 s then, with the axes 2.9 %.
fn axes<const D: usize>(
    elastic: &Elastic<D>,
    response: &Response<D>,
    wet: &[bool],
) -> Vec<Vector<D>> {
    let around = &elastic.around;
    let families = &around.families;
    let broken = |j: usize| around.cloud.volume[j] * response.damage[j];
    let axis = |i: usize| {
        if !wet[i] {
            return Vector::zeros();
        }
        let own = response.planes[i].normal;
        let mut sum = own * own.transpose() * broken(i);
        for bond in families.family(i) {
            let j = families.neighbour(bond);
            if wet[j] {
                let image = families.images.get(families.image(bond));
                let normal = image.reflect(&response.planes[j].normal);
                sum += normal * normal.transpose() * broken(j);
            }
        }
        let (values, vectors) = eigen(&sum);
        vectors.column(values.imax()).into_owned()
    };
    parallel::map(wet.len(), axis)
}

/// The wet point that fills the nearest one whose crack leads on to a dry one, or [`DRY`].
fn continues<const D: usize>(
    elastic: &Elastic<D>,
    axes: &[Vector<D>],
    (donor, filled): (&[u32], &[bool]),
    point: usize,
) -> u32 {
    let around = &elastic.around;
    let families = &around.families;
    let leads = |bond: usize| {
        let end = families.neighbour(bond);
        if !filled[end] || end == point {
            return None;
        }
        let image = families.images.get(families.image(bond));
        let normal = image.reflect(&axes[end]);
        let arm = around.bond_vector(point, bond);
        let (length, off) = (arm.norm(), arm.dot(&normal).abs());
        (off <= ALONG * length).then_some((length, off, donor[end]))
    };
    let nearest = families.family(point).filter_map(leads);
    let nearest = nearest.min_by(|one, other| {
        let order = one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1));
        order.then(one.2.cmp(&other.2))
    });
    nearest.map_or(DRY, |(_, _, donor)| donor)
}
