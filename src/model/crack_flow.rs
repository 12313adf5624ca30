//! Fluid in what is broken, in the split model: which points hold the fluid of the crack, and what they conduct.
//!
//! A point is wet from a small damage on. Where the crack goes on, points that are not wet yet feel the pressure of
//! a wet one whose crack points at them, and what opens there belongs to that one; without it fluid could never
//! break rock that is squeezed on a grid. Beside the crack there is no fluid but that of the pores, and rock breaks by
//! its effective stress.

use std::sync::Arc;

use rayon::prelude::*;

use super::coefficients::Coefficients;
use super::diffusion::CrackBonds;
use crate::effects::{Opening, openings};
use crate::geometry::Vector;
use crate::material::eigen;
use crate::operators::{BondConductance, BondForm, Elastic, MirrorContinuation, Response};

/// Where fluid is in what is broken.
#[derive(Clone)]
pub struct CrackFlow<const D: usize> {
    /// Point whose pressure acts in the crack here, shape `(n,)`; [`DRY`] for none.
    pub donor: Vec<u32>,
    /// Opening and width of the band, shape `(n,)`.
    pub opening: Vec<Opening>,
    /// What the pores of a point in a crack hold for good, m^D, shape `(n,)`; see [`CrackFlow::seal`].
    pub pores: Vec<f64>,
    /// Hydraulic aperture of a closed crack, m.
    residual: f64,
    conduction: Arc<BondConductance<D>>,
    /// What the rock conducts: values of L without cracks, m^D/(Pa s).
    pub rock: Arc<Vec<f64>>,
    /// How the pressure goes on across the sides.
    extension: Arc<MirrorContinuation<D>>,
}

/// How points may become wet.
#[derive(Debug, Clone, Copy)]
pub struct Wetting<'a> {
    /// Pressure at which the pores of a point close as it becomes wet, Pa: that of the start of a step.
    pub before: &'a [f64],
    /// Whether fluid only spreads: a point keeps the one whose pressure it feels until it is wet itself. Passes of a
    /// step would otherwise hand a point from one to another for ever.
    pub spreads: bool,
}

impl<'a> Wetting<'a> {
    /// Anew at a pressure, Pa.
    pub fn at(before: &'a [f64]) -> Self {
        let spreads = false;
        Wetting { before, spreads }
    }
}

/// No point at all.
pub const DRY: u32 = u32::MAX;
/// Damage from which a point conducts. Tip energy of a crack driven by fluid over G_c: 0.757, 0.794 and 0.784 for
/// 0.02, 0.1 and 0.4 *(prototype)*.
pub const WET: f64 = 0.1;
/// Damage below which a point that has become wet in a pass is no part of the crack where the passes end. A first pass that
/// leads far astray can wet all rock around, which then drinks all of the fluid while the crack stays closed
/// (`kgd-leak-off` at 10 cm with the share of pores at 1e-3). At [`WET`] itself tips would be let go that fluid holds open:
/// `kgd-toughness/smoke` then finds no end.
const SOUND: f64 = 0.01;
/// Cosine to the normal of a crack up to which a bond leads on along it.
const ALONG: f64 = 0.3;
/// Share of the storage of pores that a point in a crack keeps, so that a closed crack takes something up; without any
/// the system of a closed crack is singular. `kgd-leak-off` at 10 cm in rock that lets nothing in and stores ten times
/// as much keeps 0.705, 0.966, 0.9967 and 0.9997 of its fluid in the crack with 1e-2, 1e-3, 1e-4 and 1e-5; the passes of
/// `kgd-toughness/smoke` are 173, 235, 260 and 246.
const KEPT: f64 = 1e-4;

impl<const D: usize> CrackFlow<D> {
    /// Nothing broken yet.
    pub fn new(bonds: CrackBonds<D>, rock: Vec<f64>, residual: f64) -> Self {
        let CrackBonds { around, extension } = bonds;
        let points = around.len();
        CrackFlow {
            donor: vec![DRY; points],
            opening: vec![Opening::default(); points],
            pores: vec![0.0; points],
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

    /// Brings the openings to a response, and the map of wet points if it may change. What was wet stays so: a point
    /// that the fluid breaks only where it is not wet would have no state at all. Gives the points that became wet.
    pub fn follow(
        &mut self,
        elastic: &Elastic<D>,
        response: &Response<D>,
        wetting: Option<Wetting<'_>>,
    ) -> Vec<usize> {
        let wets = |(i, s): (usize, &f64)| self.is_wet(i) || wetting.is_some() && *s > WET;
        let wet: Vec<bool> = response.damage.iter().enumerate().map(wets).collect();
        self.opening = openings(elastic, response, &wet);
        let Some(Wetting { spreads, .. }) = wetting else {
            return Vec::new();
        };
        let wetted = (0..wet.len()).filter(|i| wet[*i] && !self.is_wet(*i));
        let wetted = wetted.collect();
        let axes = axes(elastic, response, &wet);
        let donor = |i: usize| match wet[i] {
            true => i as u32,
            false if spreads && self.donor[i] != DRY => self.donor[i],
            false => continues(elastic, &axes, &wet, i),
        };
        self.donor = (0..wet.len()).into_par_iter().map(donor).collect();
        wetted
    }

    /// Points that are wet here and not `before`, but broken too little for it by the `damage` of a state.
    pub fn strays(&self, before: &Self, damage: &[f64]) -> usize {
        let is_stray = |i: &usize| self.is_wet(*i) && !before.is_wet(*i) && damage[*i] < SOUND;
        (0..damage.len()).filter(is_stray).count()
    }

    /// Closes the pores of points that have become wet, at their pressure (Pa) before: they hold what they held, and
    /// their pressure is that in the crack from now on.
    ///
    /// A crack is a plane, but the fluid in it has the pressure of a band two horizons wide. Were the pores of the band
    /// to fill with it, rock would take up at once what it takes up in the time that fluid needs through the band:
    /// in `kgd-leak-off` at 10 cm nothing of what is pumped until 2 s would be in the crack instead of 0.53. So fluid
    /// leaves the crack at the edge of the band alone.
    pub fn seal(&mut self, wetted: &[usize], capacity: &mut [f64], pressure: &[f64]) {
        for &i in wetted {
            self.pores[i] += (1.0 - KEPT) * capacity[i] * pressure[i];
            capacity[i] *= KEPT;
        }
    }

    /// Takes over the fluid of another run: where it is, what it opens, and what closed pores hold.
    pub(super) fn take_over(&mut self, then: &Coefficients, capacity: &mut [f64]) {
        self.donor.clone_from(&then.donor);
        self.opening.clone_from(&then.opening);
        self.pores.clone_from(&then.pores);
        let wet = (0..capacity.len()).filter(|i| self.is_wet(*i));
        wet.for_each(|i| capacity[i] *= KEPT);
    }

    /// Permeability of the band of a crack, (w³ + w_r³)/12W, m², unless one is `given`.
    pub fn permeability(&self, own: Opening, given: Option<f64>) -> f64 {
        let cubes = own.opening.powi(3) + self.residual.powi(3);
        given.unwrap_or(cubes / (12.0 * own.width))
    }

    /// The pressures that enter the traction on the crack at a point with Biot's coefficient `biot`, with their factors
    /// β: 1 for that in the crack, −α for that in the pores; none where there is no fluid in the crack, and rock breaks by
    /// its effective stress.
    pub fn pressing(&self, point: usize, biot: f64) -> impl Iterator<Item = (usize, f64)> + use<D> {
        let pair = match self.donor[point] {
            DRY => [None; 2],
            donor if donor as usize == point => [Some((point, 1.0 - biot)), None],
            donor => [Some((point, -biot)), Some((donor as usize, 1.0))],
        };
        pair.into_iter().flatten()
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
        (4 + 8 + size_of::<Opening>()) * self.donor.len()
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
    (0..wet.len()).into_par_iter().map(axis).collect()
}

/// The nearest wet point whose crack leads on to a dry one, or [`DRY`].
fn continues<const D: usize>(
    elastic: &Elastic<D>,
    axes: &[Vector<D>],
    wet: &[bool],
    point: usize,
) -> u32 {
    let around = &elastic.around;
    let families = &around.families;
    let leads = |bond: usize| {
        let end = families.neighbour(bond);
        if !wet[end] || end == point {
            return None;
        }
        let image = families.images.get(families.image(bond));
        let normal = image.reflect(&axes[end]);
        let arm = around.bond_vector(point, bond);
        let (length, off) = (arm.norm(), arm.dot(&normal).abs());
        (off <= ALONG * length).then_some((length, off, end as u32))
    };
    let nearest = families.family(point).filter_map(leads);
    let nearest = nearest.min_by(|one, other| {
        let order = one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1));
        order.then(one.2.cmp(&other.2))
    });
    nearest.map_or(DRY, |(_, _, donor)| donor)
}
