//! Cracks as chains of segments in a plane, and which bonds they cut.

use super::{ImageTable, Vector};

/// A chain of straight segments, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Crack<const D: usize> {
    /// From one tip over the corners to the other.
    pub points: Vec<Vector<D>>,
}

/// A place on a crack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnCrack<const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// Distance along the crack from its first tip, m.
    pub distance: f64,
    /// Unit vector along the crack.
    pub tangent: Vector<D>,
    /// Unit vector across it, to the left of the tangent.
    pub normal: Vector<D>,
}

impl<const D: usize> Crack<D> {
    fn segments(&self) -> impl Iterator<Item = [Vector<D>; 2]> + '_ {
        self.points.windows(2).map(|pair| [pair[0], pair[1]])
    }

    /// Length along the crack, m.
    pub fn length(&self) -> f64 {
        self.segments().map(|[a, b]| (b - a).norm()).sum()
    }

    /// Middles of `count` equal parts of the crack.
    pub fn middles(&self, count: usize) -> Vec<OnCrack<D>> {
        let part = self.length() / count as f64;
        let middle = |k: usize| self.place(part * (k as f64 + 0.5));
        (0..count).filter_map(middle).collect()
    }

    /// `count` equal parts of the crack, each from its start over the corners in it to its end.
    pub fn parts(&self, count: usize) -> Vec<Vec<Vector<D>>> {
        let length = self.length();
        let starts = self.segments().scan(0.0, |before, [a, b]| {
            let start = *before;
            *before += (b - a).norm();
            Some((start, a))
        });
        let corners: Vec<(f64, Vector<D>)> = starts.skip(1).collect();
        let part = |k: usize| {
            let [from, to] = [k, k + 1].map(|k| length * k as f64 / count as f64);
            let inside = |corner: &&(f64, Vector<D>)| from < corner.0 && corner.0 < to;
            let between = corners.iter().filter(inside).map(|corner| corner.1);
            let end = |distance| self.place(distance).map(|place| place.at);
            end(from)
                .into_iter()
                .chain(between)
                .chain(end(to))
                .collect()
        };
        (0..count).map(part).collect()
    }

    /// Distance to a place beside the crack, m; `None` beyond its tips.
    pub fn gap(&self, x: &Vector<D>) -> Option<f64> {
        let beside = |[a, b]: [Vector<D>; 2]| {
            let (along, arm) = (b - a, x - a);
            let share = arm.dot(&along) / along.norm_squared();
            (0.0..=1.0)
                .contains(&share)
                .then(|| (arm - along * share).norm())
        };
        let corners = self.points.iter().skip(1).rev().skip(1);
        let gaps = self.segments().filter_map(beside);
        gaps.chain(corners.map(|corner| (x - corner).norm()))
            .reduce(f64::min)
    }

    /// Distance to the nearest segment, m, and the unit normal of that segment.
    pub fn nearest(&self, x: &Vector<D>) -> Option<(f64, Vector<D>)> {
        let to = |[a, b]: [Vector<D>; 2]| {
            let (along, arm) = (b - a, x - a);
            let share = (arm.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            ((arm - along * share).norm(), normal(&along.normalize()))
        };
        let segments = self.segments().map(to);
        segments.min_by(|one, other| one.0.total_cmp(&other.0))
    }

    fn place(&self, distance: f64) -> Option<OnCrack<D>> {
        let mut before = 0.0;
        let mut found = None;
        for [a, b] in self.segments() {
            let length = (b - a).norm();
            let tangent = (b - a) / length;
            found = Some(OnCrack {
                at: a + tangent * (distance - before),
                distance,
                tangent,
                normal: normal(&tangent),
            });
            before += length;
            if distance <= before {
                break;
            }
        }
        found
    }
}

/// Unit vector to the left of a tangent in the plane.
fn normal<const D: usize>(tangent: &Vector<D>) -> Vector<D> {
    let mut normal = Vector::zeros();
    (normal[0], normal[1]) = (-tangent[1], tangent[0]);
    normal
}

/// Cracks with all their mirror images.
pub struct Cutter<const D: usize> {
    /// Number of the crack, and one of its segments or of their images.
    segments: Vec<(u16, [Vector<D>; 2])>,
}

impl<const D: usize> Cutter<D> {
    /// Prepares the cracks.
    pub fn new(cracks: &[Crack<D>], images: &ImageTable<D>) -> Self {
        let mut segments = Vec::new();
        for (number, crack) in (0_u16..).zip(cracks) {
            for segment in crack.segments() {
                let place = |image: &super::Image<D>| segment.map(|end| image.place(&end));
                segments.extend(images.iter().map(|image| (number, place(image))));
            }
        }
        Cutter { segments }
    }

    /// Prepares the cracks themselves, for what lies within the domain.
    pub fn without_images(cracks: &[Crack<D>]) -> Self {
        let own = |(number, crack)| Crack::segments(crack).map(move |segment| (number, segment));
        Cutter {
            segments: (0_u16..).zip(cracks).flat_map(own).collect(),
        }
    }

    /// The first crack that the straight line from `a` to `b` meets, ends and tips included. Exact.
    pub fn first(&self, a: &Vector<D>, b: &Vector<D>) -> Option<u16> {
        let meeting = |(_, segment): &&(u16, [Vector<D>; 2])| meet(&[*a, *b], segment);
        self.segments.iter().find(meeting).map(|found| found.0)
    }
}

/// Whether two segments have a place in common.
fn meet<const D: usize>(one: &[Vector<D>; 2], other: &[Vector<D>; 2]) -> bool {
    let apart = |axis: usize| {
        let (low, high) = (
            one[0][axis].min(one[1][axis]),
            one[0][axis].max(one[1][axis]),
        );
        let ends = [other[0][axis], other[1][axis]];
        ends.iter().all(|x| *x < low) || ends.iter().all(|x| *x > high)
    };
    if apart(0) || apart(1) {
        return false;
    }
    let splits = |line: &[Vector<D>; 2], ends: &[Vector<D>; 2]| {
        let [first, second] = [side(line, &ends[0]), side(line, &ends[1])];
        !(first > 0.0 && second > 0.0 || first < 0.0 && second < 0.0)
    };
    splits(one, other) && splits(other, one)
}

/// Positive to the left of the line, negative to its right, zero on it; exact (Shewchuk).
fn side<const D: usize>(line: &[Vector<D>; 2], x: &Vector<D>) -> f64 {
    let place = |x: &Vector<D>| robust::Coord { x: x[0], y: x[1] };
    robust::orient2d(place(&line[0]), place(&line[1]), place(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Domain;

    type Place = Vector<2>;

    fn cutter(points: &[[f64; 2]]) -> Cutter<2> {
        let domain = Domain {
            lower: Place::zeros(),
            upper: Place::repeat(1.0),
            planes: true,
        };
        let points = points.iter().map(|x| Place::from(*x)).collect();
        let images = ImageTable::new(&domain, 0.2).unwrap();
        Cutter::new(&[Crack { points }], &images)
    }

    #[test]
    fn lines_across_a_crack_meet_it_and_others_do_not() {
        let cutter = cutter(&[[0.2, 0.5], [0.6, 0.5], [0.6, 0.9]]);
        let meets = |a: [f64; 2], b: [f64; 2]| {
            let (a, b) = (Place::from(a), Place::from(b));
            let both = [cutter.first(&a, &b), cutter.first(&b, &a)];
            assert_eq!(both[0], both[1], "{a} {b}");
            both[0].is_some()
        };
        assert!(meets([0.3, 0.45], [0.35, 0.55]));
        assert!(meets([0.55, 0.7], [0.65, 0.6]), "the second segment");
        assert!(meets([0.2, 0.4], [0.2, 0.6]), "through a tip");
        assert!(meets([0.1, 0.5], [0.3, 0.5]), "along the crack");
        assert!(!meets([0.0, 0.5], [0.1, 0.5]), "on its line before the tip");
        assert!(!meets([0.15, 0.4], [0.15, 0.6]), "past the tip");
        assert!(!meets([0.3, 0.45], [0.5, 0.499_999_999]), "beside it");
        assert!(meets([-0.3, 0.45], [-0.3, 0.55]), "its mirror image");
    }

    #[test]
    fn parts_follow_the_chain_around_its_corners() {
        let points = vec![Place::zeros(), Place::new(1.0, 0.0), Place::new(1.0, 0.5)];
        let parts = Crack { points }.parts(2);
        let place = |x: f64, y: f64| Place::new(x, y);
        let near = |found: &[Place], exact: &[Place]| {
            assert_eq!(found.len(), exact.len());
            assert!(
                found.iter().zip(exact).all(|(a, b)| (a - b).norm() < 1e-15),
                "{found:?}"
            );
        };
        near(&parts[0], &[place(0.0, 0.0), place(0.75, 0.0)]);
        near(
            &parts[1],
            &[place(0.75, 0.0), place(1.0, 0.0), place(1.0, 0.5)],
        );
    }

    #[test]
    fn middles_are_evenly_spaced_along_the_chain() {
        let points = vec![Place::zeros(), Place::new(1.0, 0.0), Place::new(1.0, 1.0)];
        let crack = Crack { points };
        let middles = crack.middles(4);
        let at: Vec<Place> = middles.iter().map(|m| m.at).collect();
        let expected = [[0.25, 0.0], [0.75, 0.0], [1.0, 0.25], [1.0, 0.75]].map(Place::from);
        assert!(
            at.iter()
                .zip(&expected)
                .all(|(a, b)| (a - b).norm() < 1e-15)
        );
        assert_eq!(middles[3].normal, Place::new(-1.0, 0.0));
        assert!((crack.length() - 2.0).abs() < 1e-15);
    }
}
