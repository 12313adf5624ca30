//! Effective widths of families over directions: what a crack takes of the strength c of a point.
//!
//! A crack of normal n breaks the points whose families reach across it, a band about as wide as the
//! convex hull of a family along n. On a lattice that is 2 floor(δ/Δx) Δx along the rows and not 2δ. The
//! strength c = G_c/W(n) with the *effective* width W(n), that of the energy the band holds, makes a crack
//! take G_c in any direction; c = G_c/W̄ with the mean over directions makes it so on average.
//!
//! Families are whole: with mirror images beyond all sides, free ones too, and with the bonds that cracks
//! cut, so that neither a side nor a crack changes the strength beside it. Families at voids, and all near
//! sides that are no planes, have no such images. What reaches less than [`WHOLE`] δ to some side takes the
//! mean of the widths of all whole families, times its own δ.

mod family;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::f64::consts::PI;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use self::family::Widths;
pub(crate) use self::family::{BandLaw, WholeFamily};
use crate::geometry::{Cloud, Families, Influence, Severed, Subdomain, Vector};
use crate::material::Lame;
use crate::parallel;

/// Directions over half a circle, 2.5° apart. A family takes 31 µs at δ = 2.3 Δx and 68 µs at 3.05 Δx, a point that
/// shares its row 1 to 2 µs.
const IN_PLANE: usize = 72;

/// Directions over half a sphere, about 14° apart: means of cubic lattices are those over 3000 directions within
/// 0.1 %, extremes within 1.3 %. A family takes 0.16 ms at δ = 2.3 Δx and 0.37 ms at 3.05 Δx.
const IN_SPACE: usize = 100;

/// Reach over δ in the direction of the least, below which a family is not whole. That of a lattice in a
/// plane is 0.5 at least; the first two rows at a free side reach 0 and 0.43 at δ = 2.3 Δx. Of 3600 points of
/// a lattice jittered by a quarter the least is 0.42 at δ = 2.3 Δx and 0.57 at 3.05 Δx.
const WHOLE: f64 = 0.45;

/// Relative difference of bond vectors and weights that counts as rounding error. On lattices it is below
/// 1e-12 and reaches 1e-9 where coordinates are 1e7 times the horizon.
const ROUNDING: f64 = 1e-7;

/// Table of effective widths W_i(n) over points and directions. Points with the same family share a row.
#[derive(Debug, Clone)]
pub struct FamilyWidths<const D: usize> {
    /// Unit normals over half a circle or half a sphere, shape `(directions,)`.
    direction: Vec<Vector<D>>,
    /// δ per point, m, shape `(n,)`.
    horizon: Vec<f64>,
    /// Row per point, shape `(n,)`.
    row: Vec<u32>,
    /// W/δ, shape `(rows, directions)`.
    width: Vec<f64>,
    /// Mean of W/δ over directions, shape `(rows,)`.
    mean: Vec<f64>,
}

/// Widths over 2δ, averaged over points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WidthRange {
    /// In the direction of the narrowest.
    pub least: f64,
    /// Mean over directions.
    pub mean: f64,
    /// In the direction of the widest.
    pub most: f64,
}

impl<const D: usize> FamilyWidths<D> {
    /// Widths of all families that are held here; `families` have all their images, and their bonds may be
    /// severed. `lame` has the elastic constants per point, shape `(n,)`.
    ///
    /// All processes must call this together.
    pub fn new(
        cloud: &Cloud<D>,
        families: &Families<D>,
        influence: Influence,
        lame: &[Lame],
        law: &BandLaw,
    ) -> Self {
        let severed = families.severed.as_deref().unwrap_or_default();
        let whole = |point: usize| {
            families.share.holds(point).then(|| {
                let bonds = whole_family(cloud, families, severed, influence, point);
                WholeFamily {
                    horizon: families.horizon[point],
                    lame: lame[point],
                    bonds,
                }
            })
        };
        Self::build(families.horizon.clone(), whole, &families.share, law)
    }

    /// Widths of the given families, point by point.
    pub fn of_families(families: &[WholeFamily<D>], law: &BandLaw) -> Self {
        let horizon = families.iter().map(|family| family.horizon).collect();
        let whole = |point: usize| Some(families[point].clone());
        Self::build(horizon, whole, &Subdomain::WHOLE, law)
    }

    fn build(
        horizon: Vec<f64>,
        family: impl Fn(usize) -> Option<WholeFamily<D>> + Sync,
        share: &Subdomain,
        law: &BandLaw,
    ) -> Self {
        let points = 0..horizon.len();
        let keys: Vec<Option<u128>> = parallel::map(horizon.len(), |point| {
            family(point).map(|family| fingerprint(&family))
        });
        let mut known = HashMap::new();
        let mut shown = Vec::new();
        let rows: Vec<Option<u32>> = (keys.into_iter().enumerate())
            .map(|(point, key)| {
                Some(*known.entry(key?).or_insert_with(|| {
                    shown.push(point);
                    shown.len() as u32 - 1
                }))
            })
            .collect();
        let direction = directions::<D>();
        let widths: Vec<Option<Widths>> = parallel::map(shown.len(), |number| {
            family(shown[number])?.widths(&direction, law)
        });
        let owned = points.filter(|point| share.owns(*point));
        let mean = mean_row(&widths, owned.map(|point| rows[point]), share, &direction);
        let last = widths.len() as u32;
        let row = rows.into_iter().map(|row| row.unwrap_or(last)).collect();
        Self::of_rows(direction, horizon, row, widths, mean)
    }

    /// The table, in which `stand_in` replaces the rows of families that are not whole.
    fn of_rows(
        direction: Vec<Vector<D>>,
        horizon: Vec<f64>,
        row: Vec<u32>,
        widths: Vec<Option<Widths>>,
        stand_in: StandIn,
    ) -> Self {
        let rows = widths.into_iter().map(|widths| match widths {
            Some(own) if !stand_in.replaces || own.reach >= WHOLE => own.width,
            _ => stand_in.width.clone(),
        });
        let width: Vec<f64> = (rows.chain(std::iter::once(stand_in.width.clone())))
            .flatten()
            .collect();
        let count = direction.len();
        let mean = |row: &[f64]| row.iter().sum::<f64>() / count as f64;
        FamilyWidths {
            mean: width.chunks_exact(count).map(mean).collect(),
            direction,
            horizon,
            row,
            width,
        }
    }

    /// W_i(n) of a point in the direction of the table nearest to the unit vector `normal`, m.
    pub fn width(&self, point: usize, normal: &Vector<D>) -> f64 {
        self.horizon[point] * self.of_row(self.row[point])[self.nearest(normal)]
    }

    /// W̄_i, the mean of the width of a point over all directions, m.
    pub fn mean(&self, point: usize) -> f64 {
        self.horizon[point] * self.mean[self.row[point] as usize]
    }

    /// Smallest and largest width over 2δ of all directions, averaged over points: what cracks take of G_c
    /// where c = G_c/2δ.
    pub fn extremes(&self) -> (f64, f64) {
        let range = self.range();
        (range.least, range.most)
    }

    /// The extremes with the mean over directions: with c = G_c/W̄ cracks take `least/mean` to `most/mean`
    /// of G_c.
    ///
    /// A crack passes many points, whose energies add up: where families differ their mean tells.
    pub fn range(&self) -> WidthRange {
        let count = self.direction.len();
        let mut sum = vec![0.0; count];
        for row in &self.row {
            let widths = sum.iter_mut().zip(self.of_row(*row));
            widths.for_each(|(sum, width)| *sum += width);
        }
        let scale = 0.5 / self.row.len().max(1) as f64;
        let widths = sum.iter().map(|sum| sum * scale);
        WidthRange {
            least: widths.clone().fold(f64::INFINITY, f64::min),
            mean: widths.clone().sum::<f64>() / count as f64,
            most: widths.fold(0.0, f64::max),
        }
    }

    /// Number of different families, and one more that stands in for those that are not whole.
    pub fn rows(&self) -> usize {
        self.mean.len()
    }

    /// Unit normals of the table.
    pub fn directions(&self) -> &[Vector<D>] {
        &self.direction
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let numbers = D * self.direction.len() + self.horizon.len() + self.width.len();
        8 * (numbers + self.mean.len()) + 4 * self.row.len()
    }

    fn of_row(&self, row: u32) -> &[f64] {
        let count = self.direction.len();
        &self.width[row as usize * count..][..count]
    }

    /// Direction nearest to ±`normal`; the first of several.
    fn nearest(&self, normal: &Vector<D>) -> usize {
        let mut best = (0, -1.0);
        for (k, direction) in self.direction.iter().enumerate() {
            let cosine = direction.dot(normal).abs();
            if cosine > best.1 {
                best = (k, cosine);
            }
        }
        best.0
    }
}

/// Row of families that are not whole.
struct StandIn {
    width: Vec<f64>,
    /// Whether there is a whole family.
    replaces: bool,
}

/// Mean of the widths of whole families over the points `rows` belong to; of all families where none is
/// whole, 2δ where there is none.
fn mean_row<const D: usize>(
    widths: &[Option<Widths>],
    rows: impl Iterator<Item = Option<u32>>,
    share: &Subdomain,
    direction: &[Vector<D>],
) -> StandIn {
    let mut points = vec![0_u32; widths.len()];
    rows.flatten().for_each(|row| points[row as usize] += 1);
    let count = direction.len();
    // Sums over the whole families, then over all, each followed by their number.
    let mut sums = vec![0.0; 2 * (count + 1)];
    for (points, widths) in points.iter().zip(widths) {
        let Some(widths) = widths else { continue };
        let first = if widths.reach >= WHOLE { 0 } else { count + 1 };
        for sums in sums[first..].chunks_exact_mut(count + 1) {
            let values = widths.width.iter().chain(std::iter::once(&1.0));
            let terms = values.map(|value| f64::from(*points) * value);
            sums.iter_mut()
                .zip(terms)
                .for_each(|(sum, term)| *sum += term);
        }
    }
    share.sum(&mut sums);
    let (whole, all) = sums.split_at(count + 1);
    let mean = |sums: &[f64]| sums[..count].iter().map(|sum| sum / sums[count]).collect();
    let replaces = whole[count] > 0.0;
    let width = match (replaces, all[count] > 0.0) {
        (true, _) => mean(whole),
        (false, true) => mean(all),
        (false, false) => vec![2.0; count],
    };
    StandIn { width, replaces }
}

/// Bonds of a point with their weights, those that cracks cut included.
fn whole_family<const D: usize>(
    cloud: &Cloud<D>,
    families: &Families<D>,
    severed: &[Severed],
    influence: Influence,
    point: usize,
) -> Vec<(Vector<D>, f64)> {
    let (x, horizon) = (cloud.position[point], families.horizon[point]);
    let bond = |neighbour: usize, image: u8| {
        let end = &cloud.position[neighbour];
        let xi = families.images.get(image).place(end) - x;
        let weight = influence.weight(xi.norm(), horizon) * cloud.volume[neighbour];
        (xi, weight)
    };
    let kept = families.family(point);
    let kept = kept.map(|b| bond(families.neighbour(b), families.image(b)));
    let cut = &severed[severed_range(severed, point)];
    kept.chain((cut.iter()).map(|cut| bond(cut.neighbour as usize, cut.image)))
        .collect()
}

/// Severed bonds of a point; they are sorted by owner.
fn severed_range(severed: &[Severed], point: usize) -> Range<usize> {
    let start = severed.partition_point(|bond| (bond.owner as usize) < point);
    let length = severed[start..].partition_point(|bond| bond.owner as usize == point);
    start..start + length
}

/// A number that families with the same widths over δ share: of ξ/δ, weights and λ/μ, in any order and up
/// to rounding.
fn fingerprint<const D: usize>(family: &WholeFamily<D>) -> u128 {
    let rounded = |value: f64| (value / ROUNDING).round() as i64;
    let total: f64 = family.bonds.iter().map(|(_, weight)| weight).sum();
    let bond = |(xi, weight): &(Vector<D>, f64)| {
        let place: [i64; D] = std::array::from_fn(|axis| rounded(xi[axis] / family.horizon));
        (place, rounded(weight / total))
    };
    let mut bonds: Vec<([i64; D], i64)> = family.bonds.iter().map(bond).collect();
    bonds.sort_unstable();
    let ratio = rounded(family.lame.lambda / family.lame.mu);
    let half = |salt: u8| {
        let mut hasher = DefaultHasher::new();
        (salt, ratio, &bonds).hash(&mut hasher);
        u128::from(hasher.finish())
    };
    half(0) << 64 | half(1)
}

/// Unit normals spread evenly over half a circle, or half a sphere (Fibonacci's spiral).
fn directions<const D: usize>() -> Vec<Vector<D>> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let unit = |k: usize| -> [f64; 3] {
        if D == 2 {
            let (sine, cosine) = (PI * k as f64 / IN_PLANE as f64).sin_cos();
            return [cosine, sine, 0.0];
        }
        let height = (k as f64 + 0.5) / IN_SPACE as f64;
        let (sine, cosine) = (golden * k as f64).sin_cos();
        let radius = (1.0 - height * height).sqrt();
        [radius * cosine, radius * sine, height]
    };
    let count = if D == 2 { IN_PLANE } else { IN_SPACE };
    (0..count)
        .map(|k| {
            let unit = unit(k);
            Vector::from_fn(|axis, _| unit[axis])
        })
        .collect()
}
