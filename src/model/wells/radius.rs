//! Which pressure of the exact solution the mean pressure of a well's points is.
//!
//! Near a source of unit rate in rock of unit mobility the exact potential is G(ρ) = −ln ρ/2π in the plane and 1/(4πρ) in
//! space. The operator's own answer to s, the spread source, is G again a few cells away, and near the well something that
//! depends on operator, kernel and points. So that answer is computed: the operator at unit mobility on the points around, with
//! G given beyond them. Its mean Σ s_i p_i/Σ s_i is G(r_e), and
//!
//!   1/WI = (G(r_w) − G(r_e) + skin G_s)/κ,   G_s = 1/2π, in space 1/(4π r_w).
//!
//! Beside a side there are image wells in G, with the side's sign; they are no part of G(r_e). With a tensor of the mobility
//! ρ² = r·κ̂⁻¹r with κ̂ of unit determinant, κ is √det, and the hole is an ellipse, whose radius for what is far away is the
//! mean of its semi-axes (Peaceman 1983).

use std::f64::consts::PI;

use perifrac_solvers::dot;

use crate::effects::{EffectError, WellSpread, vector};
use crate::geometry::{Matrix, Side, Vector};
use crate::model::FlowModel;
use crate::operators::{Parity, PlaneTensor};
use crate::plan::{WellPlan, Wellbore};

/// Reach of the points around a well that take part, in kernel radii.
///
/// The rate of a well at a pressure in a square of 40 points across, whose sides are at another, is off by 3.0e-6, 1.4e-6, 1.3e-6 and 1.2e-6 with
/// 2, 3, 4 and 6 (correspondence operator, well between points), and on a cloud jittered by a fifth of a cell by 1.2e-4, 2.2e-5, 5.6e-5 and
/// 2.5e-5.
const SURROUNDINGS: f64 = 4.0;
/// Residual of the answer, relative to its source.
const SOLVED: f64 = 1e-13;
/// Share of the volume around a well that may be missing, beside half a cell at the rim.
const MISSING: f64 = 0.15;
/// A well stands on a side that is nearer than this, over the size of the domain.
const ON: f64 = 1e-9;

/// What a hole comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// WI, m^D/(Pa s).
    pub index: f64,
    /// r_e, m.
    pub equivalent_radius: f64,
}

/// The operator at unit mobility.
pub(super) struct Surroundings<'a, const D: usize> {
    flow: &'a FlowModel<D>,
    tensor: &'a [PlaneTensor],
    /// Values of L at unit mobility, shape `(nonzeros,)`, m^(D−2).
    values: Vec<f64>,
}

/// Where a well, or an image of it, is seen, and with which sign.
struct Image<const D: usize> {
    place: Vector<D>,
    sign: f64,
    /// Whether it is the well itself, seen in a plane on which it stands.
    own: bool,
    /// Reflections that lead there, as signs of the axes and places of their planes.
    planes: Vec<(usize, f64)>,
}

impl<const D: usize> Image<D> {
    /// This image in a plane, with `turn` for its sign; the well itself again where that `stands` on the plane.
    fn mirrored(&self, (axis, plane): (usize, f64), turn: f64, stands: bool) -> Self {
        let mut planes = self.planes.clone();
        planes.push((axis, plane));
        let mut place = self.place;
        place[axis] = 2.0 * plane - place[axis];
        Image {
            place,
            sign: turn * self.sign,
            own: self.own && stands,
            planes,
        }
    }

    /// The place that the reflections turn `x` to.
    fn reflected(&self, x: &Vector<D>) -> Vector<D> {
        let mut place = *x;
        for &(axis, plane) in &self.planes {
            place[axis] = 2.0 * plane - place[axis];
        }
        place
    }
}

/// How often a well on planes is seen that is one source: it is its own image in each of them.
fn standing<const D: usize>(images: &[Image<D>]) -> f64 {
    images.iter().filter(|image| image.own).count() as f64
}

/// The exact potential of unit rate in a medium of unit mobility.
struct Medium<const D: usize> {
    /// κ̂⁻¹.
    inverse: Matrix<D>,
    /// √det of the tensor; 1 without one.
    conductance: f64,
    /// Largest eigenvalue of κ̂; the other one is its inverse.
    stretch: f64,
}

impl<const D: usize> Medium<D> {
    fn new(tensor: Option<&PlaneTensor>) -> Self {
        let mut medium = Medium {
            inverse: Matrix::identity(),
            conductance: 1.0,
            stretch: 1.0,
        };
        if let Some([xx, yy, xy]) = tensor {
            let det = (xx * yy - xy * xy).sqrt();
            let entries = [[yy / det, -xy / det], [-xy / det, xx / det]];
            medium.inverse = Matrix::from_fn(|row, column| {
                let entry = entries.get(row).and_then(|row| row.get(column));
                entry.copied().unwrap_or(0.0)
            });
            let (half, apart) = (0.5 * (xx + yy) / det, (0.5 * (xx - yy)).hypot(*xy) / det);
            (medium.conductance, medium.stretch) = (det, half + apart);
        }
        medium
    }

    /// G(ρ).
    fn potential(&self, rho: f64) -> f64 {
        match D {
            2 => -rho.ln() / (2.0 * PI * self.conductance),
            _ => 1.0 / (4.0 * PI * rho),
        }
    }

    /// Its inverse, m.
    fn radius(&self, potential: f64) -> f64 {
        match D {
            2 => (-2.0 * PI * self.conductance * potential).exp(),
            _ => 1.0 / (4.0 * PI * potential),
        }
    }

    /// G_s for a hole.
    fn skin(&self, hole: f64) -> f64 {
        match D {
            2 => 1.0 / (2.0 * PI * self.conductance),
            _ => 1.0 / (4.0 * PI * hole),
        }
    }

    /// ρ of an arm.
    fn distance(&self, arm: &Vector<D>) -> f64 {
        (arm.transpose() * self.inverse * arm)[0].max(0.0).sqrt()
    }

    /// Radius of a round hole as what is far away feels it, m.
    fn hole(&self, radius: f64) -> f64 {
        0.5 * radius * (self.stretch.sqrt() + 1.0 / self.stretch.sqrt())
    }
}

impl<'a, const D: usize> Surroundings<'a, D> {
    /// Fills the operator at unit mobility.
    pub(crate) fn new(flow: &'a FlowModel<D>, tensor: &'a [PlaneTensor]) -> Self {
        let mut values = vec![0.0; flow.pattern.nonzeros()];
        flow.fill_with(&vec![1.0; flow.points()], &mut values);
        Surroundings {
            flow,
            tensor,
            values,
        }
    }

    /// Index and equivalent radius of a well.
    ///
    /// # Errors
    /// [`EffectError::CrampedWell`], [`EffectError::WideHole`].
    pub(crate) fn index(
        &self,
        plan: &WellPlan,
        bore: Wellbore,
        spread: &WellSpread,
    ) -> Result<Found, EffectError> {
        let at = vector::<D>(&plan.at);
        let tensor = (spread.share.first()).and_then(|(point, _)| self.tensor.get(*point as usize));
        let medium = Medium::new(tensor);
        let cramped = |reason| EffectError::CrampedWell {
            name: plan.name.clone(),
            at: plan.at.clone(),
            reason,
            reach: SURROUNDINGS * spread.radius,
        };
        let mirrors = tensor.is_none_or(|[_, _, xy]| xy.abs() <= 0.0);
        let found = self.images(&at, (spread, medium.stretch.sqrt()), mirrors);
        let (reach, images) = found.map_err(cramped)?;
        let mean = self.mean(spread, &medium, &images, reach);
        let mean = mean.map_err(cramped)?;
        let others = images.iter().filter(|image| !image.own);
        let seen =
            others.map(|image| image.sign * medium.potential(medium.distance(&(at - image.place))));
        let own = mean - seen.sum::<f64>() / standing(&images);
        let hole = medium.hole(bore.radius);
        let between = medium.potential(hole) - own + bore.skin * medium.skin(hole);
        let found = Found {
            index: self.mobility(spread) / between,
            equivalent_radius: medium.radius(own),
        };
        match between > 0.0 && found.index.is_finite() {
            true => Ok(found),
            false => Err(EffectError::WideHole {
                name: plan.name.clone(),
                radius: bore.radius,
                skin: bore.skin,
                equivalent: found.equivalent_radius,
            }),
        }
    }

    /// Mobility at the well: the geometric mean over its points, which is that of rock in the plane that varies from place to place.
    fn mobility(&self, spread: &WellSpread) -> f64 {
        let of = |&(point, share): &(u32, f64)| share * self.flow.mobility[point as usize].ln();
        (spread.share.iter().map(of).sum::<f64>() / spread.inside).exp()
    }

    /// How far the points reach that take part, as ρ, m, and where they see the well: in all planes within reach. Along one direction
    /// ρ is `longer` times as far.
    fn images(
        &self,
        at: &Vector<D>,
        (spread, longer): (&WellSpread, f64),
        mirrors: bool,
    ) -> Result<(f64, Vec<Image<D>>), &'static str> {
        let domain = &self.flow.operator.neighbourhood().cloud.domain;
        let coupled = self.coupled(spread);
        let gaps = |axis: usize| {
            let sides = Side::all(D).filter(move |side| domain.planes && side.axis == axis);
            sides.map(|side| (at[side.axis] - domain.plane(side)).abs())
        };
        // Of two planes one is seen; images in both would go on for ever.
        let far = |axis: usize| match mirrors {
            _ if !domain.planes => f64::INFINITY,
            true => gaps(axis).fold(0.0, f64::max),
            false => gaps(axis).fold(f64::INFINITY, f64::min),
        };
        let reach = (0..D)
            .map(|axis| far(axis) - coupled)
            .fold(SURROUNDINGS * spread.radius * longer, f64::min);
        match reach < spread.radius * longer * longer {
            true => Err(
                "sides are too near to each other, or to a well in rock that conducts best along neither of them",
            ),
            false => Ok((reach / longer, self.seen(at, reach + coupled)?)),
        }
    }

    /// The well and its images in the planes within `reach`, m.
    fn seen(&self, at: &Vector<D>, reach: f64) -> Result<Vec<Image<D>>, &'static str> {
        let domain = &self.flow.operator.neighbourhood().cloud.domain;
        let mut images = vec![Image {
            place: *at,
            sign: 1.0,
            own: true,
            planes: Vec::new(),
        }];
        for side in Side::all(D).filter(|_| domain.planes) {
            let (axis, plane) = (side.axis, domain.plane(side));
            let gap = (at[axis] - plane).abs();
            if gap >= reach {
                continue;
            }
            let stands = gap < ON * domain.size()[axis];
            let parity = self.flow.extension.parity(side);
            if stands && parity != Parity::Even {
                return Err("the well stands on a side that is not sealed");
            }
            let turn = if parity == Parity::Odd { -1.0 } else { 1.0 };
            let mirror = |image: &Image<D>| image.mirrored((axis, plane), turn, stands);
            let mirrored: Vec<Image<D>> = images.iter().map(mirror).collect();
            images.extend(mirrored);
        }
        Ok(images)
    }

    /// How far a row of L reaches at the points of a well, m.
    fn coupled(&self, spread: &WellSpread) -> f64 {
        let position = &self.flow.operator.neighbourhood().cloud.position;
        let pattern = &self.flow.pattern;
        let rows = spread.share.iter().map(|(point, _)| *point as usize);
        let arms = rows.flat_map(|row| {
            let entries = pattern.row(row).filter(|k| self.values[*k] != 0.0);
            entries.map(move |k| (position[pattern.columns[k] as usize] - position[row]).norm())
        });
        arms.fold(0.0, f64::max)
    }

    /// Σ s_i p_i / Σ s_i of the operator's answer to the well, with the exact potential beyond ρ = `reach`.
    fn mean(
        &self,
        spread: &WellSpread,
        medium: &Medium<D>,
        images: &[Image<D>],
        reach: f64,
    ) -> Result<f64, &'static str> {
        let cloud = &self.flow.operator.neighbourhood().cloud;
        let at = images[0].place;
        // Round as the exact potential is: what the spread source is more than a point vanishes in the mean along this rim.
        let near = |x: &Vector<D>| medium.distance(&(x - at)) < reach;
        let inside: Vec<u32> = (0_u32..)
            .zip(&cloud.position)
            .filter(|(_, x)| near(x))
            .map(|(point, _)| point)
            .collect();
        self.check_filled(&inside, images, (reach, &near))?;
        let exact = |x: &Vector<D>| -> f64 {
            let potential = |image: &Image<D>| {
                image.sign * medium.potential(medium.distance(&(x - image.place)))
            };
            images.iter().map(potential).sum::<f64>() / standing(images)
        };
        let answer = self.answer(spread, &inside, exact)?;
        let sum = spread.share.iter().map(|&(point, share)| {
            let place = inside.binary_search(&point).ok();
            place.map_or(0.0, |place| share * answer[place])
        });
        Ok(sum.sum::<f64>() / spread.inside)
    }

    /// Refuses points `inside` that leave out a part of the ball of `reach`, m.
    fn check_filled(
        &self,
        inside: &[u32],
        images: &[Image<D>],
        (reach, near): (f64, &dyn Fn(&Vector<D>) -> bool),
    ) -> Result<(), &'static str> {
        let cloud = &self.flow.operator.neighbourhood().cloud;
        // What planes cut off the ball is there once more, mirrored.
        let seen = |&point: &u32| {
            let own = &cloud.position[point as usize];
            let often = images.iter().filter(|image| near(&image.reflected(own)));
            cloud.volume[point as usize] * often.count() as f64
        };
        let ball = match D {
            2 => PI * reach * reach,
            _ => 4.0 / 3.0 * PI * reach.powi(3),
        };
        let filled = inside.iter().map(seen).sum::<f64>() / ball;
        // Cells end in steps.
        let first = inside.first().map(|own| cloud.spacing(*own as usize));
        let steps = 0.5 * first.unwrap_or(0.0) / reach;
        match (filled - 1.0).abs() > MISSING + steps {
            true => Err("they end or leave a void"),
            false => Ok(()),
        }
    }

    /// Solves L p = s on the points `inside` (increasing) with `exact` at all others, by conjugate gradients.
    fn answer(
        &self,
        spread: &WellSpread,
        inside: &[u32],
        exact: impl Fn(&Vector<D>) -> f64,
    ) -> Result<Vec<f64>, &'static str> {
        let cloud = &self.flow.operator.neighbourhood().cloud;
        let pattern = &self.flow.pattern;
        let mut rhs = vec![0.0; inside.len()];
        for &(point, share) in &spread.share {
            let place = inside.binary_search(&point);
            rhs[place.map_err(|_| "sides are so near that points of the well are beyond")?] +=
                share;
        }
        // Rows and columns within, and what those beyond bring.
        let (mut offsets, mut entries) = (vec![0], Vec::new());
        for (row, &point) in inside.iter().enumerate() {
            for k in pattern.row(point as usize) {
                let (column, value) = (pattern.columns[k], self.values[k]);
                match inside.binary_search(&column) {
                    Ok(place) => entries.push((place, value)),
                    Err(_) if value == 0.0 => {}
                    Err(_) => rhs[row] -= value * exact(&cloud.position[column as usize]),
                }
            }
            offsets.push(entries.len());
        }
        let product = |x: &[f64]| -> Vec<f64> {
            let rows = offsets.windows(2).map(|ends| &entries[ends[0]..ends[1]]);
            rows.map(|row| row.iter().map(|&(j, value)| value * x[j]).sum())
                .collect()
        };
        conjugate_gradients(product, &rhs).ok_or("their equations have no solution")
    }
}

/// Solution of a symmetric positive definite system, to rounding.
fn conjugate_gradients(product: impl Fn(&[f64]) -> Vec<f64>, rhs: &[f64]) -> Option<Vec<f64>> {
    let mut x = vec![0.0; rhs.len()];
    let (mut residual, mut direction) = (rhs.to_vec(), rhs.to_vec());
    let mut square = dot(&residual, &residual);
    let enough = SOLVED * SOLVED * square;
    for _ in 0..10 * rhs.len() {
        if square <= enough {
            return Some(x);
        }
        let image = product(&direction);
        let step = square / dot(&direction, &image);
        x.iter_mut()
            .zip(&direction)
            .for_each(|(x, d)| *x += step * d);
        residual
            .iter_mut()
            .zip(&image)
            .for_each(|(r, i)| *r -= step * i);
        let next = dot(&residual, &residual);
        let share = next / square;
        direction
            .iter_mut()
            .zip(&residual)
            .for_each(|(d, r)| *d = r + share * *d);
        square = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn potentials_have_their_inverse_and_the_flux_of_a_unit_source() {
        let plane = Medium::<2>::new(None);
        let space = Medium::<3>::new(None);
        for r in [1e-3, 0.7, 40.0] {
            assert!((plane.radius(plane.potential(r)) / r - 1.0).abs() < 1e-13);
            assert!((space.radius(space.potential(r)) / r - 1.0).abs() < 1e-13);
            let h = 1e-4 * r;
            let slope = |of: &dyn Fn(f64) -> f64| (of(r - h) - of(r + h)) / (2.0 * h);
            let [circle, sphere] = [2.0 * PI * r, 4.0 * PI * r * r];
            assert!((circle * slope(&|r| plane.potential(r)) - 1.0).abs() < 1e-7);
            assert!((sphere * slope(&|r| space.potential(r)) - 1.0).abs() < 1e-7);
        }
    }

    /// ∇·K∇G = 0 away from the source.
    #[test]
    fn the_potential_with_a_tensor_solves_its_equation() {
        let tensor = [0.8, 0.5, 0.3];
        let medium = Medium::<2>::new(Some(&tensor));
        let at = |x: f64, y: f64| medium.potential(medium.distance(&Vector::<2>::new(x, y)));
        let (x, y, h) = (0.6, -0.9, 1e-3);
        let xx = (at(x + h, y) + at(x - h, y) - 2.0 * at(x, y)) / (h * h);
        let yy = (at(x, y + h) + at(x, y - h) - 2.0 * at(x, y)) / (h * h);
        let xy = (at(x + h, y + h) + at(x - h, y - h) - at(x + h, y - h) - at(x - h, y + h))
            / (4.0 * h * h);
        let sum = tensor[0] * xx + tensor[1] * yy + 2.0 * tensor[2] * xy;
        assert!(sum.abs() < 1e-5 * (xx.abs() + yy.abs()), "{sum}");
        assert!((Medium::<2>::new(Some(&[1.0, 1.0, 0.0])).hole(0.1) - 0.1).abs() < 1e-15);
        assert!(
            (Medium::<2>::new(Some(&[4.0, 1.0, 0.0])).hole(1.0) - 0.75 * 2.0_f64.sqrt()).abs()
                < 1e-14
        );
    }

    #[test]
    fn conjugate_gradients_solve_a_chain() {
        let product = |x: &[f64]| -> Vec<f64> {
            let at = |i: usize, step: isize| x.get(i.wrapping_add_signed(step)).copied();
            (0..x.len())
                .map(|i| 2.0 * x[i] - at(i, -1).unwrap_or(0.0) - at(i, 1).unwrap_or(0.0))
                .collect()
        };
        let exact: Vec<f64> = (0..30).map(|i| f64::from(i * i % 7)).collect();
        let found = conjugate_gradients(product, &product(&exact)).unwrap();
        for (one, other) in found.iter().zip(&exact) {
            assert!((one - other).abs() < 1e-10);
        }
        assert_eq!(conjugate_gradients(product, &[0.0; 4]), Some(vec![0.0; 4]));
    }
}
