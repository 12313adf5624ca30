//! Forces on a lattice: one stencil for all points.
//!
//! With T_j = V σ_j K_j⁻¹ − h_j H_j the force of the family of j on the end of its bond ξ is
//! ω V (T_j ξ + h_j d), and with X_i = Σ ω V ξ and M_i = Σ ω V over the bonds that point i has
//!
//!   H_i = (Σ ω V u ξᵀ − u_i X_iᵀ) K_i⁻¹,
//!   (K u)_i = Σ ω V (T ξ) over all that see i − T_i X_i + Σ ω V [h_i (u_i − u_j) + h_j (u_i − u_j)],
//!
//! so that weights of bonds are those of the stencil everywhere, and what sides take away is in K⁻¹, X and M.

use super::Work;
use super::padding::{NONE, Padding, ROUNDING};
use super::stencil::Pair;
use crate::geometry::{Matrix, Vector};
use crate::operators::Elastic;
use crate::parallel;

/// A lattice whose families are those of one stencil, but for those that deviate.
#[derive(Debug, Clone)]
pub(super) struct LatticeForce<const D: usize> {
    pub padding: Padding<D>,
    pub(super) pairs: Vec<Pair<D>>,
    /// Whether the family of a point is that of the stencil, shape `(n,)`.
    pub regular: Vec<bool>,
    /// X per point.
    pub(super) lever: Vec<[f64; D]>,
    /// M per point.
    pub(super) measure: Vec<f64>,
    /// Σ ω V h of those that see a point; empty where h is the same everywhere.
    pub(super) springs: Vec<f64>,
}

/// Points that one task works on, at least.
const TASK: usize = 256;

/// Relative difference of weights that is rounding.
const SAME: f64 = 1e-10;

impl<const D: usize> LatticeForce<D> {
    /// `None` where points are no lattice, or have no stencil in common.
    pub(crate) fn new(elastic: &Elastic<D>) -> Option<Self> {
        let families = &elastic.around.families;
        if families.share.partition().is_some() || !elastic.has_plain_gradient() {
            return None;
        }
        let horizon = families.horizon.iter().copied().fold(0.0, f64::max);
        let padding = Padding::of(elastic, horizon)?;
        let pairs = pairs(elastic, &padding)?;
        let mut force = LatticeForce {
            regular: vec![false; elastic.points()],
            lever: vec![[0.0; D]; elastic.points()],
            measure: vec![0.0; elastic.points()],
            springs: Vec::new(),
            padding,
            pairs,
        };
        force.classify(elastic);
        let mut own = (0..elastic.points()).filter(|i| force.regular[*i]);
        let h = |point: usize| elastic.hourglass(point).1;
        let first = h(own.next()?);
        if own.any(|point| h(point).to_bits() != first.to_bits()) {
            let seen = |point: usize| -> f64 {
                let dual = families.dual(point);
                dual.map(|(owner, bond)| elastic.around.measure[bond] * h(owner))
                    .sum()
            };
            force.springs = parallel::map(elastic.points(), seen);
        }
        Some(force)
    }

    fn classify(&mut self, elastic: &Elastic<D>) {
        let around = &elastic.around;
        let sites = self.padding.length() * self.padding.lines();
        let mut origin = vec![(NONE, Vector::zeros()); sites];
        for point in 0..elastic.points() {
            origin[self.padding.site_of(point)] = (point as u32, Vector::repeat(1.0));
        }
        for ghost in &self.padding.ghosts {
            origin[ghost.site as usize] = (origin[ghost.source as usize].0, ghost.sign);
        }
        let own = |point: usize| {
            let sums = self.sums(elastic, &origin, point);
            sums.unwrap_or((false, [0.0; D], 0.0))
        };
        let all: Vec<_> = parallel::map(elastic.points(), own);
        for (point, (regular, lever, measure)) in all.into_iter().enumerate() {
            self.regular[point] = regular && around.families.family(point).len() > 1;
            (self.lever[point], self.measure[point]) = (lever, measure);
        }
    }

    /// X and M of a point with all bonds of the stencil that its sides allow, and no others.
    fn sums(
        &self,
        elastic: &Elastic<D>,
        origin: &[(u32, Vector<D>)],
        point: usize,
    ) -> Option<(bool, [f64; D], f64)> {
        let around = &elastic.around;
        if elastic.layers(point).is_some() {
            return None;
        }
        let site = self.padding.site_of(point);
        let (mut lever, mut measure, mut bonds) = ([0.0; D], 0.0, 0);
        let mut expected = Vec::with_capacity(2 * self.pairs.len());
        for pair in &self.pairs {
            for (end, sign) in [(site + pair.shift / D, 1.0), (site - pair.shift / D, -1.0)] {
                if origin[end].0 != NONE {
                    (0..D).for_each(|axis| lever[axis] += pair.arm[axis] * sign);
                    measure += pair.measure;
                    bonds += 1;
                    expected.push((end, pair.measure));
                }
            }
        }
        expected.sort_unstable_by_key(|(end, _)| *end);
        if bonds != around.families.family(point).len() {
            return None;
        }
        for bond in around.families.family(point) {
            let step = step_of(elastic, point, bond)?;
            let (lines, along) = self.padding.shift(step);
            let end = site as i64 + lines * self.padding.length() as i64 + along;
            let place = expected.binary_search_by_key(&(end as usize), |(end, _)| *end);
            let (end, measure) = expected[place.ok()?];
            let (source, sign) = &origin[end];
            let is_end = *source as usize == around.families.neighbour(bond);
            let same = (around.measure[bond] - measure).abs() <= SAME * measure;
            if !is_end || !same || *sign != elastic.signs(bond) {
                return None;
            }
        }
        Some((true, lever, measure))
    }

    /// Values of a line of stresses, and of one of displacements.
    fn widths(&self) -> (usize, usize) {
        let length = D * self.padding.length();
        (D * length, length)
    }

    /// Room for a field of displacements and one of stresses.
    pub(crate) fn prepare(&self, work: &mut Work<D>) {
        let (stress, displacement) = self.widths();
        let lines = self.padding.lines();
        work.displacement = vec![0.0; lines * displacement + MOST_LANES];
        work.rest = vec![0.0; lines * displacement];
        work.stress = vec![0.0; lines * stress + MOST_LANES];
        if !self.springs.is_empty() {
            work.stiff = vec![0.0; lines * displacement + MOST_LANES];
        }
    }

    /// First pass: T of all regular families, and what the own family of a point does to it.
    pub(crate) fn first_pass(
        &self,
        elastic: &Elastic<D>,
        displacement: &[f64],
        work: &mut Work<D>,
    ) {
        self.lay_out(elastic, displacement, work);
        let (stress, width) = self.widths();
        let field = &work.displacement;
        let arch = pulp::Arch::new();
        let least = TASK.div_ceil(self.padding.counts[0]);
        let lists = (&mut work.stress[..], &mut work.rest[..]);
        let respond =
            |line: usize, stress: &mut [f64], rest: &mut [f64]| match self.padding.first[line] {
                NONE => {}
                first => {
                    let line = (line, first as usize);
                    match D {
                        2 => arch.dispatch(
                            #[inline(always)]
                            || self.respond::<16>(elastic, field, line, stress, rest),
                        ),
                        _ => arch.dispatch(
                            #[inline(always)]
                            || self.respond::<12>(elastic, field, line, stress, rest),
                        ),
                    }
                }
            };
        parallel::chunk_pairs(lists, (stress, width), least, respond);
        self.continue_stress(&mut work.stress);
    }

    /// Displacements of the points and of their images, site by site.
    fn lay_out(&self, elastic: &Elastic<D>, displacement: &[f64], work: &mut Work<D>) {
        let length = self.padding.length();
        let count = D * self.padding.counts[0];
        let lines = self.padding.first.iter().enumerate();
        for (line, first) in lines.filter(|(_, first)| **first != NONE) {
            let (start, from) = (
                D * (line * length + self.padding.reach[0]),
                D * *first as usize,
            );
            let values = &displacement[from..from + count];
            work.displacement[start..start + count].copy_from_slice(values);
            if !self.springs.is_empty() {
                let points = work.stiff[start..start + count].chunks_exact_mut(D);
                for ((point, stiff), own) in
                    (*first as usize..).zip(points).zip(values.chunks_exact(D))
                {
                    let h = elastic.hourglass(point).1;
                    stiff.iter_mut().zip(own).for_each(|(s, u)| *s = h * u);
                }
            }
        }
        for ghost in &self.padding.ghosts {
            let (to, from) = (D * ghost.site as usize, D * ghost.source as usize);
            for axis in 0..D {
                work.displacement[to + axis] = ghost.sign[axis] * work.displacement[from + axis];
                if !self.springs.is_empty() {
                    work.stiff[to + axis] = ghost.sign[axis] * work.stiff[from + axis];
                }
            }
        }
    }

    /// T of images: diag(signs) T diag(turns).
    fn continue_stress(&self, stress: &mut [f64]) {
        for ghost in &self.padding.ghosts {
            let [to, from] =
                [ghost.site, ghost.source].map(|site| self.stress_at(site as usize, 0));
            let column = D * self.padding.length();
            for axis in 0..D {
                for component in 0..D {
                    let sign = ghost.sign[component] * ghost.turn[axis];
                    let place = axis * column + component;
                    stress[to + place] = sign * stress[from + place];
                }
            }
        }
    }

    /// Place of T of a site, from column `axis` on.
    pub(super) fn stress_at(&self, site: usize, axis: usize) -> usize {
        let length = self.padding.length();
        let (line, along) = (site / length, site % length);
        (line * D + axis) * D * length + along * D
    }

    /// T of a point.
    pub(crate) fn stress_of(&self, stress: &[f64], point: usize) -> Matrix<D> {
        let site = self.padding.site_of(point);
        Matrix::from_fn(|component, axis| stress[self.stress_at(site, axis) + component])
    }

    /// Second pass: K u of all points that only regular families see.
    pub(crate) fn second_pass(&self, work: &Work<D>, result: &mut [f64]) {
        let count = self.padding.counts[0];
        let arch = pulp::Arch::new();
        let least = TASK.div_ceil(count);
        parallel::chunks(result, D * count, least, |line, result| {
            let first = line * count;
            match D {
                2 => arch.dispatch(
                    #[inline(always)]
                    || self.collect::<16>(work, first, result),
                ),
                _ => arch.dispatch(
                    #[inline(always)]
                    || self.collect::<12>(work, first, result),
                ),
            }
        });
    }

    /// Force of the family of a regular point on the end of one of its bonds, N, without the signs of an image.
    pub(crate) fn bond_force(
        &self,
        elastic: &Elastic<D>,
        (stress, displacement): (&[f64], &[f64]),
        owner: usize,
        bond: usize,
    ) -> Vector<D> {
        let difference = elastic.difference(displacement, owner, bond);
        let xi = elastic.around.bond_vector(owner, bond);
        let traction = self.stress_of(stress, owner) * xi;
        (traction + difference * elastic.hourglass(owner).1) * elastic.around.measure[bond]
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let points = self.regular.len();
        let ghosts = size_of_val(self.padding.ghosts.as_slice());
        points * (1 + 8 * (D + 1)) + 8 * self.springs.len() + ghosts
    }
}

/// Most values that are summed side by side.
const MOST_LANES: usize = 16;

/// The step on the lattice that a bond takes.
fn step_of<const D: usize>(elastic: &Elastic<D>, owner: usize, bond: usize) -> Option<[i64; D]> {
    let xi = elastic.around.bond_vector(owner, bond);
    let cell = &elastic.around.cloud.cell[0];
    let steps: [f64; D] = std::array::from_fn(|axis| xi[axis] / cell[axis]);
    steps
        .iter()
        .all(|step| (step - step.round()).abs() <= ROUNDING)
        .then(|| steps.map(|step| step.round() as i64))
}

/// The largest family as pairs of opposite bonds; `None` where a bond has no opposite like it.
fn pairs<const D: usize>(elastic: &Elastic<D>, padding: &Padding<D>) -> Option<Vec<Pair<D>>> {
    let around = &elastic.around;
    let size = |point: &usize| around.families.family(*point).len();
    let largest = (0..elastic.points()).rev().max_by_key(size)?;
    let bond = |bond: usize| Some((step_of(elastic, largest, bond)?, around.measure[bond]));
    let bonds: Option<Vec<_>> = around.families.family(largest).map(bond).collect();
    let bonds = bonds?;
    let cell = &around.cloud.cell[0];
    let mut pairs = Vec::with_capacity(bonds.len() / 2);
    for &(step, measure) in &bonds {
        let back = step.map(|own| -own);
        let (_, other) = bonds.iter().find(|(own, _)| *own == back)?;
        if (other - measure).abs() > SAME * measure {
            return None;
        }
        let (lines, along) = padding.shift(step);
        let length = padding.length() as i64;
        let sites = lines * length + along;
        if sites > 0 {
            pairs.push(Pair {
                shift: D * sites as usize,
                stress: (D as i64 * (lines * D as i64 * length + along)) as usize,
                measure,
                arm: std::array::from_fn(|axis| measure * step[axis] as f64 * cell[axis]),
            });
        }
    }
    Some(pairs)
}
