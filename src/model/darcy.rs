//! Darcy velocity from the flux that bonds carry, and the pressure between points from its slope.
//!
//! With the path operator it is the mean of what the faces of a cell carry, (1/V) Σ F (x_face − x).
//!
//! With the others −κ∇̃p is not the flux where the mobility varies: the gradient sees both sides of a jump. What bonds
//! carry is: with the force F_b of every bond the operator conserves Σ F_b through any plane. The velocity
//! v of a cell is the weighted least-squares fit to the bonds that run through it, with weights as a
//! uniform rock would have them,
//!
//!   v = −M⁻¹ Σ_b s_b F_b ξ_b,  M = Σ_b s_b ξ_b ⊗ f_b,
//!
//! where s_b is the share of the bond in the cell and f_b the force for unit mobility and slope. It is exact
//! for uniform flow on any cloud; on a lattice M is the volume of the cell, so that the sum over a row of
//! cells is what the operator drives through it, whatever the jumps of the mobility. On irregular clouds
//! single cells scatter, and both sums go over the cells that a point sees in its own rock.

use super::FlowModel;
use crate::geometry::{Matrix, Stencil, Vector, sources};
use crate::operators::Crossings;
use crate::parallel;

/// Both sums of a cell.
type Sums<const D: usize> = (Vector<D>, Matrix<D>);
/// Differences of the pressure along bonds by owner and bond, Pa.
type Drive<'a> = &'a (dyn Fn(usize, usize) -> f64 + Sync);

/// Relative difference of mobilities that counts as none.
const UNIFORM: f64 = 1e-9;
/// Ratio of mobilities up to which points tell the slope of each other's pressure.
const ALIKE: f64 = 3.0;
/// Times that the set of points beside a jump grows by their families: the pressure next to a jump is
/// disturbed by 7 % of the flux three rows off it, by less than 0.1 % seven rows off.
const GROWN: usize = 2;
/// Smallest determinant of a scaled M or shape tensor that is inverted.
const SINGULAR: f64 = 1e-6;
/// Cells worked on at a time, which bounds the memory for their bonds to some 50 MB.
const CHUNK: usize = 16_384;

impl<const D: usize> FlowModel<D> {
    /// Darcy velocity −κ(∇p − ρ_f g) (Eq. 37), shape `(n,)`, m/s; zero at points of other processes.
    pub fn velocity(&self, pressure: &[f64], time: f64) -> Vec<Vector<D>> {
        let walls = self.wall_values(time);
        let drive = self.drive(pressure, &walls);
        let at = |point| self.operator.flux(&self.mobility, point, &drive);
        let mut velocity: Vec<Vector<D>> = parallel::map(self.points(), at);
        match self.operator.flux_is_carried() {
            true => self.add_open_faces(time, &mut velocity),
            false => self.fit_beside_jumps(&drive, &mut velocity),
        }
        velocity
    }

    /// Adds what prescribed fluxes bring through the faces of cells on their sides.
    fn add_open_faces(&self, time: f64, velocity: &mut [Vector<D>]) {
        let volume = &self.operator.neighbourhood().cloud.volume;
        for face in self.operator.open_faces() {
            let point = face.point as usize;
            if let Some(flux) = &self.fluxes[face.side.index()] {
                velocity[point] -= face.arm * (flux.at(time) * face.area / volume[point]);
            }
        }
    }

    /// Fits the velocity anew to the bonds through the cells near jumps of the mobility.
    fn fit_beside_jumps(&self, drive: Drive<'_>, velocity: &mut [Vector<D>]) {
        let points = self.beside_jumps();
        let parts = points.chunks(CHUNK);
        let sums: Vec<Sums<D>> = parts.flat_map(|points| self.sums(points, drive)).collect();
        let fit = |cell: usize| {
            let (flux, moment) = self.own_sums(&points, &sums, cell);
            let volume = moment.trace().abs() / D as f64;
            let inverse = invert(&(moment / volume))? / volume;
            Some(-inverse * flux)
        };
        let found: Vec<Option<Vector<D>>> = parallel::map(points.len(), fit);
        for (point, own) in points.iter().zip(found) {
            let point = *point as usize;
            velocity[point] = own.unwrap_or(velocity[point]);
        }
    }

    /// Points of this process near those that see another mobility, or are seen by one, ascending.
    fn beside_jumps(&self) -> Vec<u32> {
        let families = &self.operator.neighbourhood().families;
        let near = |point: usize, wanted: &(dyn Fn(usize) -> bool + Sync)| {
            let mut seen = families.family(point).map(|bond| families.neighbour(bond));
            seen.any(wanted) || families.dual(point).any(|(owner, _)| wanted(owner))
        };
        let jumps = |point: usize| {
            let own = self.mobility[point];
            let differs = |other: usize| {
                let other = self.mobility[other];
                (own - other).abs() > UNIFORM * own.max(other)
            };
            near(point, &differs)
        };
        let mut beside: Vec<bool> = parallel::map(self.points(), jumps);
        for _ in 0..GROWN {
            let grown = |point: usize| beside[point] || near(point, &|other| beside[other]);
            beside = parallel::map(self.points(), grown);
        }
        let own =
            (0..self.points()).filter(|point| beside[*point] && self.subdomain().owns(*point));
        own.map(|point| point as u32).collect()
    }

    /// Σ s_b F_b ξ_b and M of the cells of `points` (ascending).
    fn sums(&self, points: &[u32], drive: Drive<'_>) -> Vec<Sums<D>> {
        let around = self.operator.neighbourhood();
        let crossings = Crossings::of(around, points);
        let ones = vec![1.0; around.len()];
        let forces = |number: usize| {
            let owner = crossings.owners[number] as usize;
            let difference = |bond: usize| drive(owner, bond);
            let carried = self
                .operator
                .family_forces(&self.mobility, owner, &difference);
            let unit: [Vec<f64>; D] = std::array::from_fn(|axis| {
                let difference = |bond: usize| around.bond_vector(owner, bond)[axis];
                self.operator.family_forces(&ones, owner, &difference)
            });
            (carried, unit)
        };
        let forces: Vec<(Vec<f64>, [Vec<f64>; D])> = parallel::map(crossings.owners.len(), forces);
        let mut sums = vec![(Vector::zeros(), Matrix::zeros()); points.len()];
        for part in &crossings.parts {
            let owner = crossings.owners[part.owner as usize] as usize;
            let bond = part.bond as usize;
            let place = bond - around.families.family(owner).start;
            let image = around.families.images.get(part.image);
            let (carried, unit) = &forces[part.owner as usize];
            let xi = image.reflect(&around.bond_vector(owner, bond)) * part.share;
            let unit = image.reflect(&Vector::from_fn(|axis, _| unit[axis][place]));
            let (flux, moment) = &mut sums[part.cell as usize];
            *flux += xi * (self.extension.sign(part.image) * carried[place]);
            *moment += xi * unit.transpose();
        }
        sums
    }

    /// The sums of a cell; on irregular clouds with those of the cells around it in the same rock.
    fn own_sums(&self, points: &[u32], sums: &[Sums<D>], cell: usize) -> Sums<D> {
        let around = self.operator.neighbourhood();
        let (mut flux, mut moment) = sums[cell];
        if !around.cloud.irregular {
            return (flux, moment);
        }
        let (families, point) = (&around.families, points[cell] as usize);
        for bond in families.family(point) {
            let other = families.neighbour(bond);
            if (self.mobility[point] - self.mobility[other]).abs() > UNIFORM * self.mobility[point]
            {
                continue;
            }
            let Ok(other) = points.binary_search(&(other as u32)) else {
                continue;
            };
            let number = families.image(bond);
            let image = families.images.get(number);
            let (own_flux, own_moment) = &sums[other];
            flux += image.reflect(own_flux) * self.extension.sign(number);
            let axes = |a: usize, b: usize| image.parity(a) * own_moment[(a, b)] * image.parity(b);
            moment += Matrix::from_fn(axes);
        }
        (flux, moment)
    }

    /// Slope of the pressure at a point, Pa/m, by least squares over those it sees in alike rock: next to
    /// a jump of the mobility it is the slope on the point's own side. Exact for linear pressures.
    fn slope(&self, point: usize, drive: Drive<'_>) -> Vector<D> {
        let around = self.operator.neighbourhood();
        let own = self.mobility[point];
        let over = |wanted: &dyn Fn(usize) -> bool| {
            let (mut shape, mut sum) = (Matrix::<D>::zeros(), Vector::<D>::zeros());
            for bond in around.families.family(point) {
                if wanted(around.families.neighbour(bond)) {
                    let xi = around.bond_vector(point, bond) * around.measure[bond];
                    shape += xi * around.bond_vector(point, bond).transpose();
                    sum += xi * drive(point, bond);
                }
            }
            let scale = shape.trace() / D as f64;
            Some(invert(&(shape / scale))? / scale * sum)
        };
        let alike = |other: usize| {
            let ratio = self.mobility[other] / own;
            (1.0 / ALIKE..=ALIKE).contains(&ratio)
        };
        let slope = over(&alike).or_else(|| over(&|_| true));
        slope.unwrap_or_else(Vector::zeros) + self.weight()
    }

    /// Pressure at places, Pa: the points around each, continued along their slopes and blended; images
    /// as the sides have it. Linear pressures are exact.
    pub fn pressures_at(&self, pressure: &[f64], time: f64, places: &[Stencil<D>]) -> Vec<f64> {
        let walls = self.wall_values(time);
        let drive = self.drive(pressure, &walls);
        let points = sources(places);
        let slopes: Vec<Vector<D>> = points
            .iter()
            .map(|point| self.slope(*point, &drive))
            .collect();
        let blend = |place: &Stencil<D>| {
            let kept = place
                .terms
                .iter()
                .filter(|term| self.extension.keeps(term.image));
            let (mut sum, mut all) = (0.0, 0.0);
            for term in kept {
                let slope = points
                    .binary_search(&term.point)
                    .map_or(Vector::zeros(), |k| slopes[k]);
                let own = pressure[term.point] + slope.dot(&term.arm);
                sum += term.weight * self.image_value(term, own, &place.at, &walls);
                all += term.weight;
            }
            sum / all
        };
        places.iter().map(blend).collect()
    }
}

/// Inverse of a matrix of mean diagonal 1, unless it is nearly singular.
fn invert<const D: usize>(matrix: &Matrix<D>) -> Option<Matrix<D>> {
    let inverse = matrix.try_inverse()?;
    (inverse.amax() < 1.0 / SINGULAR).then_some(inverse)
}
