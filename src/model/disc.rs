//! Discs in space: their part in the domain, and places on them.

use std::f64::consts::PI;

use crate::effects::vector;
use crate::geometry::{Domain, OnCrack, Vector};
use crate::plan::CrackPlace;

/// A disc with two unit vectors in its plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc<const D: usize> {
    /// Centre, m.
    pub centre: Vector<D>,
    /// Unit normal.
    pub normal: Vector<D>,
    /// Radius, m.
    pub radius: f64,
    plane: [Vector<D>; 2],
}

/// Rays over which the area is summed: a corner that cuts the disc is met to 1/2000 of the angle.
const RAYS: usize = 2000;
/// Rays that are tried for places on the disc.
const TRIED: usize = 64;
/// Corners of a rim that is drawn: it leaves the circle by a thousandth of the radius.
const CORNERS: usize = 72;

impl<const D: usize> Disc<D> {
    /// The disc of a place in space; `None` for a chain.
    pub fn of(place: &CrackPlace) -> Option<Self> {
        let CrackPlace::Disc {
            centre,
            normal,
            radius,
        } = place
        else {
            return None;
        };
        let normal = vector::<D>(normal);
        // Any axis that is not along the normal spans the plane with it.
        let axis = normal.map(f64::abs).imin();
        let mut first = Vector::<D>::zeros();
        first[axis] = 1.0;
        first = (first - normal * normal[axis]).normalize();
        let mut second = Vector::<D>::zeros();
        if D == 3 {
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                second[a] = normal[b] * first[c] - normal[c] * first[b];
            }
        }
        Some(Disc {
            centre: vector(centre),
            normal,
            radius: *radius,
            plane: [first, second],
        })
    }

    fn direction(&self, angle: f64) -> Vector<D> {
        self.plane[0] * angle.cos() + self.plane[1] * angle.sin()
    }

    /// Corners of its rim, closed, m.
    pub fn rim(&self) -> Vec<Vector<D>> {
        let step = 2.0 * PI / CORNERS as f64;
        let corner = |k: usize| self.centre + self.direction(k as f64 * step) * self.radius;
        (0..=CORNERS).map(corner).collect()
    }

    /// Where a ray from the centre is in the domain, m from the centre.
    fn inside(&self, domain: &Domain<D>, direction: &Vector<D>) -> [f64; 2] {
        let (mut from, mut to) = (0.0_f64, self.radius);
        for axis in 0..D {
            let (at, slope) = (self.centre[axis], direction[axis]);
            // A centre on a side counts as in the domain.
            let slack = 1e-9 * domain.size()[axis];
            let ends = [
                domain.lower[axis] - slack - at,
                domain.upper[axis] + slack - at,
            ];
            if slope.abs() < 1e-12 {
                if ends[0] > 0.0 || ends[1] < 0.0 {
                    return [0.0, 0.0];
                }
                continue;
            }
            let cuts = ends.map(|end| end / slope);
            from = from.max(cuts[0].min(cuts[1]));
            to = to.min(cuts[0].max(cuts[1]));
        }
        [from, to.max(from)]
    }

    /// Area in the domain, m².
    pub fn area(&self, domain: &Domain<D>) -> f64 {
        let step = 2.0 * PI / RAYS as f64;
        let slice = |ray: usize| {
            let direction = self.direction((ray as f64 + 0.5) * step);
            let [from, to] = self.inside(domain, &direction);
            0.5 * (to * to - from * from) * step
        };
        (0..RAYS).map(slice).sum()
    }

    /// Middles of `count` equal parts of the radius that stays in the domain farthest; of several the
    /// first, with the direction of growing distance as the tangent.
    pub fn radius(&self, domain: &Domain<D>, count: usize) -> Vec<OnCrack<D>> {
        let step = 2.0 * PI / TRIED as f64;
        let reach = |ray: usize| {
            let direction = self.direction(ray as f64 * step);
            (self.inside(domain, &direction)[1], direction)
        };
        let better = |best: (f64, Vector<D>), next: (f64, Vector<D>)| match next.0
            > best.0 + 1e-9 * self.radius
        {
            true => next,
            false => best,
        };
        let (length, tangent) = (1..TRIED).map(reach).fold(reach(0), better);
        let middle = |k: usize| {
            let distance = length * (k as f64 + 0.5) / count as f64;
            OnCrack {
                at: self.centre + tangent * distance,
                distance,
                tangent,
                normal: self.normal,
            }
        };
        (0..count).map(middle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_cube() -> Domain<3> {
        Domain {
            lower: Vector::zeros(),
            upper: Vector::repeat(1.0),
            planes: true,
        }
    }

    fn disc(centre: [f64; 3], normal: [f64; 3], radius: f64) -> Disc<3> {
        let length = normal.iter().copied().fold(0.0, f64::hypot);
        let normal = normal.map(|x| x / length);
        let place = CrackPlace::Disc {
            centre,
            normal,
            radius,
        };
        Disc::of(&place).unwrap()
    }

    #[test]
    fn a_rim_lies_in_its_disc_as_far_as_its_radius() {
        let disc = disc([1.0, 2.0, 3.0], [1.0, 0.0, 1.0], 2.0);
        let rim = disc.rim();
        assert!((rim[0] - rim[rim.len() - 1]).norm() < 1e-12);
        for corner in rim {
            let arm = corner - disc.centre;
            assert!((arm.norm() - 2.0).abs() < 1e-12);
            assert!(arm.dot(&disc.normal).abs() < 1e-12);
        }
    }

    #[test]
    fn the_area_is_that_of_the_part_in_the_domain() {
        let circle = PI * 0.09;
        for (centre, normal, share) in [
            ([0.5, 0.5, 0.5], [0.0, 0.0, 1.0], 1.0),
            ([0.5, 0.5, 0.5], [1.0, -2.0, 3.0], 1.0),
            ([0.0, 0.5, 0.5], [0.0, 1.0, 1.0], 0.5),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.25),
            ([1.0, 0.0, 0.5], [0.0, 0.0, -1.0], 0.25),
        ] {
            let area = disc(centre, normal, 0.3).area(&unit_cube());
            assert!(
                (area / (share * circle) - 1.0).abs() < 2e-3,
                "{centre:?} {normal:?}: {area}"
            );
        }
    }

    #[test]
    fn the_radius_stays_in_the_domain_and_on_the_disc() {
        let disc = disc([1.0, 0.0, 0.5], [1.0, 1.0, 1.0], 0.3);
        let places = disc.radius(&unit_cube(), 10);
        assert!((places[9].distance - 0.285).abs() < 1e-12);
        for on in places {
            assert!((on.at - disc.centre).dot(&disc.normal).abs() < 1e-12);
            assert!(on.at.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x)));
        }
    }
}
