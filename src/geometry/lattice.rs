//! Clouds of equal cells side by side, first axis fastest: who is near whom is known without a search.

use super::{Cloud, Families, ImageTable, Vector};

/// How far a point may be from its place, in edges of its cell.
const ROUNDING: f64 = 1e-6;
/// Distances this near to a horizon, relative to it, are left to the search; horizons keep a millionth off them.
const DOUBTFUL: f64 = 1e-8;
/// Difference of lengths, relative to them, that is rounding.
const SAME: f64 = 1e-12;

/// Whether two lengths differ by rounding alone.
fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * other
}

/// Whether all lengths are that of the first.
pub(super) fn are_same(lengths: &[f64]) -> bool {
    let mut all = lengths.iter();
    lengths
        .first()
        .is_none_or(|first| all.all(|own| is_same(*own, *first)))
}

/// A cloud that is a full lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice<const D: usize> {
    /// Points along each axis.
    pub counts: [usize; D],
    edge: Vector<D>,
    size: Vector<D>,
    planes: bool,
}

/// Steps to the points of a family, and to their indices far from all sides.
struct Ball<const D: usize> {
    steps: Vec<[i64; D]>,
    offsets: Vec<i64>,
    /// Most steps along each axis.
    reach: [i64; D],
}

impl<const D: usize> Lattice<D> {
    /// The lattice that a cloud is; `None` if it is none.
    pub fn of(cloud: &Cloud<D>) -> Option<Self> {
        let edge = *cloud.cell.first()?;
        let size = cloud.domain.size();
        let counts: [usize; D] =
            std::array::from_fn(|axis| (size[axis] / edge[axis]).round() as usize);
        if counts.iter().product::<usize>() != cloud.len() {
            return None;
        }
        let fits = |(point, x): (usize, &Vector<D>)| {
            let mut rest = point;
            (0..D).all(|axis| {
                let place = (rest % counts[axis]) as f64 + 0.5;
                rest /= counts[axis];
                let off = (x[axis] - cloud.domain.lower[axis]) / edge[axis] - place;
                off.abs() <= ROUNDING
            })
        };
        let all = cloud.position.iter().enumerate().all(fits);
        all.then_some(Lattice {
            counts,
            edge,
            size,
            planes: cloud.domain.planes,
        })
    }

    /// First point that is like each, shape `(n,)`, where points with `margin` points and more to both sides along an
    /// axis are alike.
    pub fn alike(counts: [usize; D], margin: [usize; D]) -> Vec<u32> {
        let first = |mut point: usize| {
            let (mut first, mut stride) = (0, 1);
            for axis in 0..D {
                let place = point % counts[axis];
                let inside = place >= margin[axis] && place + margin[axis] < counts[axis];
                first += stride * if inside { margin[axis] } else { place };
                point /= counts[axis];
                stride *= counts[axis];
            }
            first as u32
        };
        (0..counts.iter().product()).map(first).collect()
    }

    /// Cells that a horizon of so many metres reaches along each axis.
    pub fn reach(&self, horizon: f64) -> [usize; D] {
        std::array::from_fn(|axis| (horizon / self.edge[axis]).ceil() as usize)
    }

    /// Steps of no more than `radius` metres, without that of no length, and the squares of their lengths; `None` where
    /// images beyond the first would be among them.
    fn steps(&self, radius: f64) -> Option<Vec<([i64; D], f64)>> {
        let reach = self.reach(radius);
        let fits = |axis: usize| reach[axis] < self.counts[axis] && radius <= self.size[axis];
        if !self.planes || !(0..D).all(fits) {
            return None;
        }
        let widths = reach.map(|own| 2 * own + 1);
        let all = (0..widths.iter().product::<usize>()).map(|mut index| {
            let step: [i64; D] = std::array::from_fn(|axis| {
                let own = (index % widths[axis]) as i64 - reach[axis] as i64;
                index /= widths[axis];
                own
            });
            let along = |axis: usize| (step[axis] as f64 * self.edge[axis]).powi(2);
            (step, (0..D).map(along).sum::<f64>())
        });
        let near = |(_, square): &([i64; D], f64)| *square > 0.0 && *square <= radius * radius;
        Some(all.filter(near).collect())
    }

    /// Distance from every point to its `neighbours`-th nearest, m, images included; `None` unless so many are within
    /// `radius` and known.
    pub fn nearest_distance(&self, neighbours: usize, radius: f64) -> Option<f64> {
        let mut squares: Vec<f64> = self.steps(radius)?.into_iter().map(|own| own.1).collect();
        squares.sort_unstable_by(f64::total_cmp);
        let found = squares.get(neighbours.checked_sub(1)?)?;
        Some(found.sqrt())
    }

    fn ball(&self, horizon: f64) -> Option<Ball<D>> {
        let near = self.steps(horizon * (1.0 + DOUBTFUL))?;
        let certain = |square: f64| square.sqrt() < horizon * (1.0 - DOUBTFUL);
        if !near.iter().all(|(_, square)| certain(*square)) {
            return None;
        }
        let offset = |step: &[i64; D]| {
            let pairs = step.iter().zip(&self.counts).rev();
            pairs.fold(0, |offset, (own, count)| offset * *count as i64 + own)
        };
        let mut steps: Vec<[i64; D]> = near.into_iter().map(|own| own.0).collect();
        steps.sort_by_key(offset);
        let most = |axis: usize| steps.iter().map(|step| step[axis]).max();
        Some(Ball {
            offsets: steps.iter().map(offset).collect(),
            reach: std::array::from_fn(|axis| most(axis).unwrap_or(0)),
            steps,
        })
    }

    /// The families within `horizon` metres; `None` where they are better searched for.
    pub fn families(&self, horizon: f64, images: &ImageTable<D>) -> Option<LatticeFamilies<D>> {
        let mut numbers = vec![None; 3_usize.pow(D as u32)];
        for (number, image) in images.iter().enumerate() {
            if image.order.iter().all(|own| own.abs() <= 1) {
                numbers[place_of(&image.order)] = Some(number as u8);
            }
        }
        Some(LatticeFamilies {
            ball: self.ball(horizon)?,
            counts: self.counts,
            numbers,
        })
    }
}

/// The families of a lattice whose points all see as far.
pub struct LatticeFamilies<const D: usize> {
    ball: Ball<D>,
    counts: [usize; D],
    /// Image numbers by [`place_of`].
    numbers: Vec<Option<u8>>,
}

/// Place of an image that is one step away at most along every axis.
fn place_of<const D: usize>(order: &[i32; D]) -> usize {
    let digits = order.iter().rev();
    digits.fold(0, |place, own| 3 * place + (own + 1) as usize)
}

impl<const D: usize> LatticeFamilies<D> {
    /// Adds the bonds (neighbour, image number) of a point, sorted.
    pub fn add(&self, point: usize, bonds: &mut Vec<(u32, u8)>) {
        let (counts, ball) = (&self.counts, &self.ball);
        let mut rest = point;
        let at: [i64; D] = std::array::from_fn(|axis| {
            let own = rest % counts[axis];
            rest /= counts[axis];
            own as i64
        });
        let inside = |axis: usize| {
            at[axis] >= ball.reach[axis] && at[axis] + ball.reach[axis] < counts[axis] as i64
        };
        if (0..D).all(inside) {
            let ends = ball.offsets.iter().map(|own| (point as i64 + own) as u32);
            bonds.extend(ends.map(|end| (end, 0)));
            return;
        }
        let before = bonds.len();
        bonds.extend(ball.steps.iter().filter_map(|step| self.bond(&at, step)));
        bonds[before..].sort_unstable();
    }

    /// The bond from a place by a step; behind a side lies the image of what is before it.
    fn bond(&self, at: &[i64; D], step: &[i64; D]) -> Option<(u32, u8)> {
        let (mut end, mut order) = (0, [0; D]);
        for axis in (0..D).rev() {
            let count = self.counts[axis] as i64;
            let (place, side) = match at[axis] + step[axis] {
                below if below < 0 => (-1 - below, -1),
                above if above >= count => (2 * count - 1 - above, 1),
                inside => (inside, 0),
            };
            end = end * count + place;
            order[axis] = side;
        }
        let image = self.numbers[place_of(&order)]?;
        Some((end as u32, image))
    }
}

impl<const D: usize> Families<D> {
    /// First point with the family of every point, shape `(n,)`, where points of a lattice of equal cells all see as
    /// far; `None` elsewhere and where cracks cut bonds. Lengths of bonds and images agree, neighbours are shifted.
    pub fn alike(&self, cloud: &Cloud<D>) -> Option<Vec<u32>> {
        let whole = self.share.partition().is_none() && self.severed.is_none();
        let (horizon, edge) = (*self.horizon.first()?, cloud.cell.first()?);
        let same = |own: &Vector<D>| (0..D).all(|axis| is_same(own[axis], edge[axis]));
        if !whole || !are_same(&self.horizon) || !cloud.cell.iter().all(same) {
            return None;
        }
        let lattice = Lattice::of(cloud)?;
        let alike = Lattice::alike(lattice.counts, lattice.reach(horizon));
        let length = |point: usize| self.family(point).len();
        let mut pairs = alike.iter().enumerate();
        let fits = pairs.all(|(point, first)| length(point) == length(*first as usize));
        fits.then_some(alike)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::lattice;
    use crate::geometry::{Horizon, Subdomain, horizons};

    fn compare<const D: usize>(size: Vector<D>, counts: [usize; D], horizon: Horizon) {
        let cloud = lattice(Vector::<D>::repeat(-0.3), size, counts).unwrap();
        let radii = horizons(&cloud, horizon).unwrap();
        let searched = Families::by_search(&cloud, radii.clone()).unwrap();
        let own = Lattice::of(&cloud).unwrap();
        let found = own.families(radii[0], &searched.images).unwrap();
        let images = searched.images.clone();
        let known = Families::of(radii, images, Subdomain::WHOLE, |point, bonds| {
            found.add(point, bonds);
        });
        let known = known.unwrap();
        assert_eq!(known.offsets(), searched.offsets());
        for bond in 0..known.bonds() {
            assert_eq!(known.neighbour(bond), searched.neighbour(bond));
            assert_eq!(known.image(bond), searched.image(bond));
        }
    }

    #[test]
    fn families_are_those_of_a_search() {
        for horizon in [
            Horizon::Neighbours(15),
            Horizon::Ratio(3.015),
            Horizon::Ratio(1.5),
        ] {
            compare(Vector::<2>::new(1.0, 2.0), [9, 14], horizon);
            compare(Vector::<3>::new(1.0, 1.1, 0.9), [6, 7, 5], horizon);
        }
    }

    #[test]
    fn distances_are_those_of_a_search() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::<2>::new(1.0, 2.0), [9, 14]).unwrap();
        let own = Lattice::of(&cloud).unwrap();
        let searched = Families::by_search(&cloud, vec![0.6; cloud.len()]).unwrap();
        for neighbours in [1, 4, 8, 15, 24] {
            let found = own.nearest_distance(neighbours, 0.6).unwrap();
            for point in [0, 5, 70] {
                let bonds = searched.family(point);
                let length = |bond| searched.bond_vector(&cloud, point, bond).norm();
                let mut lengths: Vec<f64> = bonds.map(length).collect();
                lengths.sort_unstable_by(f64::total_cmp);
                assert!((lengths[neighbours - 1] - found).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn points_that_are_alike_see_their_neighbours_at_the_same_places() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::<2>::new(1.0, 2.0), [12, 14]).unwrap();
        let radii = horizons(&cloud, Horizon::Neighbours(15)).unwrap();
        let families = Families::by_search(&cloud, radii).unwrap();
        let alike = families.alike(&cloud).unwrap();
        let mut kinds = alike.clone();
        kinds.sort_unstable();
        kinds.dedup();
        assert!(kinds.len() < cloud.len());
        for (point, first) in alike.into_iter().enumerate() {
            let first = first as usize;
            for (own, other) in families.family(point).zip(families.family(first)) {
                let arm = families.bond_vector(&cloud, point, own);
                let like = families.bond_vector(&cloud, first, other);
                assert!((arm - like).amax() < 1e-14);
                assert_eq!(families.image(own), families.image(other));
            }
        }
    }

    #[test]
    fn what_is_no_lattice_or_has_no_images_is_searched() {
        let mut cloud =
            lattice(Vector::<2>::zeros(), Vector::<2>::new(1.0, 1.0), [10, 10]).unwrap();
        let own = Lattice::of(&cloud).unwrap();
        assert!(own.nearest_distance(8, 2.0).is_none(), "images of images");
        cloud.domain.planes = false;
        let open = Lattice::of(&cloud).unwrap();
        assert!(open.nearest_distance(8, 0.3).is_none());
        cloud.position[17][0] += 1e-3;
        assert!(Lattice::of(&cloud).is_none());
    }
}
