//! Where bonds leave the region of one material for that of another.

use crate::geometry::{Cloud, Families, Image, Matrix, Vector, border};
use crate::material::{Lame, eigen};
use crate::plan::Plan;

use super::properties::material_at;

/// Places per spacing at which a bond is asked for its material; what is thinner may be missed.
const PLACES: f64 = 4.0;

/// Radius, in spacings, of the circles on which the direction of an interface is found, and places on them. A plane
/// interface is found to rounding with any; a small circle sees no other interface.
const RADIUS: f64 = 0.05;
const ANGLES: usize = 16;

/// A part of a bond within one material.
#[derive(Debug, Clone, Copy)]
pub(super) struct Run<const D: usize> {
    /// The material.
    pub(super) material: u16,
    /// Part of the bond's length.
    pub(super) share: f64,
    /// Where it begins.
    pub(super) start: Vector<D>,
}

/// The regions of a plan's materials along the bonds of a cloud.
pub(super) struct Interfaces<'a, const D: usize> {
    pub(super) plan: &'a Plan,
    pub(super) cloud: &'a Cloud<D>,
    pub(super) families: &'a Families<D>,
    /// Material per point.
    pub(super) material: &'a [u16],
}

impl<const D: usize> Interfaces<'_, D> {
    /// Part of a bond in the material of its owner; `None` where both ends are of one material, and where
    /// materials have no regions.
    pub(super) fn share(&self, owner: usize, bond: usize) -> Option<f64> {
        let own = self.material[owner];
        if self.material[self.families.neighbour(bond)] == own {
            return None;
        }
        let xi = self.families.bond_vector(self.cloud, owner, bond);
        let image = self.families.images.get(self.families.image(bond));
        let holds = |share: f64| {
            let x = self.cloud.position[owner] + xi * share;
            self.at(image, &x) == Some(own)
        };
        if !holds(0.0) || holds(1.0) {
            return None;
        }
        Some(border((0.0, 1.0), holds))
    }

    /// The material at a place, which may lie in an image.
    fn at(&self, image: &Image<D>, x: &Vector<D>) -> Option<u16> {
        let domain = &self.cloud.domain;
        let inside = *x >= domain.lower && *x <= domain.upper;
        let x = if inside { *x } else { image.inverse(x) };
        material_at(self.plan, &x)
    }

    /// The materials along a bond, from its owner on.
    pub(super) fn runs(&self, owner: usize, bond: usize) -> Vec<Run<D>> {
        let xi = self.families.bond_vector(self.cloud, owner, bond);
        let image = self.families.images.get(self.families.image(bond));
        let from = self.cloud.position[owner];
        let at = |share: f64| self.at(image, &(from + xi * share));
        let own = self.material[owner];
        let mut runs = vec![Run {
            material: own,
            share: 1.0,
            start: from,
        }];
        let places = (PLACES * xi.norm() / self.cloud.spacing(owner)).ceil();
        let (mut last, mut begin, mut before) = (own, 0.0, 0.0);
        for place in 1..=places as usize {
            let share = place as f64 / places;
            let found = at(share).unwrap_or(last);
            if found != last {
                let change = border((before, share), |share| at(share) == Some(last));
                if let Some(run) = runs.last_mut() {
                    run.share = change - begin;
                }
                runs.push(Run {
                    material: found,
                    share: 1.0 - change,
                    start: from + xi * change,
                });
                (last, begin) = (found, change);
            }
            before = share;
        }
        runs
    }

    /// n⊗n of the interface at which a part of a bond begins; along the bond where none is found.
    pub(super) fn facing(&self, owner: usize, bond: usize, run: &Run<D>) -> Matrix<D> {
        let image = self.families.images.get(self.families.image(bond));
        let radius = RADIUS * self.cloud.spacing(owner);
        let mut spread = Matrix::zeros();
        for first in 0..D {
            for second in first + 1..D {
                let arm = |angle: f64| {
                    let mut arm = Vector::zeros();
                    arm[first] = radius * angle.cos();
                    arm[second] = radius * angle.sin();
                    arm
                };
                let holds =
                    |angle: f64| self.at(image, &(run.start + arm(angle))) == Some(run.material);
                let angle = |k: usize| std::f64::consts::TAU * k as f64 / ANGLES as f64;
                for k in 0..ANGLES {
                    let (low, high) = (angle(k), angle(k + 1));
                    let (inside, after) = (holds(low), holds(high));
                    if inside != after {
                        let arm = arm(border((low, high), |angle| holds(angle) == inside));
                        spread += arm * arm.transpose();
                    }
                }
            }
        }
        let (values, vectors) = eigen(&spread);
        let xi = self
            .families
            .bond_vector(self.cloud, owner, bond)
            .normalize();
        let normal = match values.amax() > 0.0 {
            true => vectors.column(values.imin()).into_owned(),
            false => xi,
        };
        normal * normal.transpose()
    }

    /// Moduli of a material, if they are the same everywhere in it.
    pub(super) fn moduli(&self, material: u16) -> Option<Lame> {
        let elasticity = self.plan.materials[usize::from(material)].uniform_elasticity()?;
        Some(elasticity.lame())
    }
}
