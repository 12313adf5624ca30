//! Values of the assembled elastic operator, row by row: rows are owned, so threads never meet.

use std::cell::RefCell;

use super::scalar::by_rows;
use super::{Pattern, Repetition};
use crate::geometry::{Matrix, Vector};
use crate::material::unit_strain;
use crate::operators::{Elastic, Lame, Layers};

thread_local! {
    /// Column → place in the current row of points; one per thread.
    static PLACE: RefCell<Vec<u32>> = const { RefCell::new(Vec::new()) };
}

/// What the stiffness of families is made of.
pub(crate) trait Moduli<const D: usize>: Sync {
    /// Stresses at the owner of a family, times its volume, per displacement along each axis of a point
    /// whose weight in the strain is `weight` (1/m).
    fn stresses(&self, owner: usize, weight: &Vector<D>) -> [Matrix<D>; D];

    /// Factor of the hourglass stiffness of a family.
    fn hourglass(&self, _owner: usize) -> f64 {
        1.0
    }

    /// A coefficient q in 1/J and a force f per bond of a family in N: q f fᵀ is added to its stiffness.
    fn drive(&self, _owner: usize) -> Option<(f64, &[Vector<D>])> {
        None
    }
}

/// Linear elasticity: isotropic, or that of layers.
struct Isotropic<'a, const D: usize>(&'a Elastic<D>);

impl<const D: usize> Moduli<D> for Isotropic<'_, D> {
    fn stresses(&self, owner: usize, weight: &Vector<D>) -> [Matrix<D>; D] {
        let scaled = weight * self.0.around.cloud.volume[owner];
        if let Some(layers) = self.0.layers(owner) {
            return std::array::from_fn(|axis| layers.stress(&unit_strain(axis, &scaled)));
        }
        let Lame { lambda, mu } = self.0.lame[owner];
        std::array::from_fn(|axis| {
            let mut stress = Matrix::identity() * (lambda * scaled[axis]);
            for k in 0..D {
                stress[(axis, k)] += mu * scaled[k];
                stress[(k, axis)] += mu * scaled[k];
            }
            stress
        })
    }
}

/// Fills `values` with the stiffness matrix K of `elastic`.
///
/// `points` is the pattern over points, every family coupled; `values` has the layout of
/// `points.expanded(D)`: all columns of a point's first component, then of the next. Rows are summed
/// in a fixed order, so the bits do not depend on the number of threads. Rows that `repetition` knows to be
/// those of others are copied.
pub(crate) fn fill_stiffness<const D: usize>(
    elastic: &Elastic<D>,
    repetition: Option<&Repetition>,
    points: &Pattern,
    values: &mut [f64],
) {
    let fill = |values: &mut [f64], wanted: &(dyn Fn(usize) -> bool + Sync)| {
        fill_wanted(elastic, &Isotropic(elastic), wanted, points, values);
    };
    match repetition {
        Some(own) => own.fill(&expanded_offsets::<D>(points), values, fill),
        None => fill(values, &|_| true),
    }
}

/// Starts of the rows of all components of every point.
fn expanded_offsets<const D: usize>(points: &Pattern) -> Vec<u32> {
    points.offsets.iter().map(|o| o * (D * D) as u32).collect()
}

/// As [`fill_stiffness`] with other moduli, and only the rows of points in whose own family or in whose
/// neighbours' families `changed` (shape `(n,)`) is set.
pub(crate) fn fill_rows<const D: usize>(
    elastic: &Elastic<D>,
    moduli: &impl Moduli<D>,
    changed: Option<&[bool]>,
    points: &Pattern,
    values: &mut [f64],
) {
    let families = &elastic.around.families;
    let touched = |point: usize| {
        let touches = |changed: &[bool]| {
            changed[point] || families.dual(point).any(|(owner, _)| changed[owner])
        };
        changed.is_none_or(touches)
    };
    fill_wanted(elastic, moduli, &touched, points, values);
}

/// Fills the rows of the points that are wanted.
fn fill_wanted<const D: usize>(
    elastic: &Elastic<D>,
    moduli: &impl Moduli<D>,
    wanted: &(dyn Fn(usize) -> bool + Sync),
    points: &Pattern,
    values: &mut [f64],
) {
    let families = &elastic.around.families;
    by_rows(&expanded_offsets::<D>(points), values, |point, values| {
        if !wanted(point) {
            return;
        }
        values.fill(0.0);
        PLACE.with_borrow_mut(|place| {
            place.resize(place.len().max(points.rows()), 0);
            let columns = &points.columns[points.row(point)];
            for (k, &column) in columns.iter().enumerate() {
                place[column as usize] = k as u32;
            }
            let width = columns.len() * D;
            let mut row = Row {
                elastic,
                moduli,
                place,
                width,
                values,
            };
            row.own(point);
            for (owner, bond) in families.dual(point) {
                row.dual(owner, bond);
            }
        });
    });
}

/// The rows of one point's components.
struct Row<'a, const D: usize, M> {
    elastic: &'a Elastic<D>,
    moduli: &'a M,
    place: &'a [u32],
    width: usize,
    values: &'a mut [f64],
}

/// How the row's point enters the family of `owner`.
struct Subdomain<'a, const D: usize> {
    owner: usize,
    /// Weight in the strain of the family.
    strain: Vector<D>,
    /// Weight in the plain gradient, times the shape tensor and h.
    hourglass: Vector<D>,
    /// Force in the outer product, N.
    drive: Vector<D>,
    sign: Vector<D>,
    layered: Option<LayeredShare<'a, D>>,
}

/// How the row's point enters the hourglass energy of a family with layers.
struct LayeredShare<'a, const D: usize> {
    layers: Layers<'a, D>,
    /// h of the family.
    stiffness: f64,
    /// h ω V A of the bond of the row's point, or minus the sum of all for the owner, less h Σ ω V AᵀA for its
    /// weight in the gradient.
    forward: [Matrix<D>; D],
}

impl<const D: usize> LayeredShare<'_, D> {
    /// Minus what the bond at `place` adds to the stiffness beyond its own spring.
    fn rest(
        &self,
        elastic: &Elastic<D>,
        share: &Subdomain<'_, D>,
        (place, bond): (usize, usize),
    ) -> Matrix<D> {
        let weight = &elastic.gradient.weight[bond];
        let xi = elastic.around.bond_vector(share.owner, bond);
        let lever = self.layers.lever(place, &xi);
        let stretch = self.stiffness * elastic.around.measure[bond];
        Matrix::from_fn(|a, b| {
            let forward = self.forward[a].row(b).transpose();
            let back = lever[b].row(a).transpose();
            forward.dot(weight) + stretch * back.dot(&share.strain)
        })
    }
}

impl<'a, const D: usize, M: Moduli<D>> Row<'a, D, M> {
    /// The point as the owner of its family, with minus the sum of all bonds.
    fn own(&mut self, point: usize) {
        let elastic = self.elastic;
        let around = &elastic.around;
        let family = around.families.family(point);
        let stiffness = elastic.hourglass(point).1 * self.moduli.hourglass(point);
        let (mut strain, mut hourglass) = (Vector::zeros(), Vector::zeros());
        for bond in family {
            let own = stiffness * around.measure[bond];
            strain -= elastic.gradient.weight[bond];
            hourglass -= around.bond_vector(point, bond) * own;
            self.stretch(point, bond, elastic.signs(bond), own, Vector::repeat(-1.0));
        }
        let sign = Vector::repeat(1.0);
        let drive = self.moduli.drive(point);
        let layered = self.layered(point, stiffness, &strain, None);
        self.couple(&Subdomain {
            owner: point,
            strain,
            hourglass,
            drive: drive.map_or_else(Vector::zeros, |(_, forces)| {
                -forces.iter().sum::<Vector<D>>()
            }),
            sign,
            layered,
        });
    }

    /// The point as the end of a bond.
    fn dual(&mut self, owner: usize, bond: usize) {
        let elastic = self.elastic;
        let stiffness = elastic.hourglass(owner).1 * self.moduli.hourglass(owner);
        let own = stiffness * elastic.around.measure[bond];
        let sign = elastic.signs(bond);
        self.stretch(owner, bond, sign, own, sign);
        let first = elastic.around.families.family(owner).start;
        let drive = self.moduli.drive(owner);
        self.couple(&Subdomain {
            owner,
            strain: elastic.gradient.weight[bond],
            hourglass: elastic.around.bond_vector(owner, bond) * own,
            drive: drive.map_or_else(Vector::zeros, |(_, forces)| forces[bond - first]),
            sign,
            layered: self.layered(owner, stiffness, &elastic.gradient.weight[bond], Some(bond)),
        });
    }

    /// The layers of a family for the point at the end of `bond`, or for its owner.
    fn layered(
        &self,
        owner: usize,
        stiffness: f64,
        weight: &Vector<D>,
        bond: Option<usize>,
    ) -> Option<LayeredShare<'a, D>> {
        let elastic = self.elastic;
        let layers = elastic.layers(owner)?;
        let family = elastic.around.families.family(owner);
        let lever = |bond: usize| {
            let xi = elastic.around.bond_vector(owner, bond);
            let scale = stiffness * elastic.around.measure[bond];
            (layers.lever(bond - family.start, &xi)).map(|own| own * scale)
        };
        let lever = match bond {
            Some(bond) => lever(bond),
            None => family
                .clone()
                .map(lever)
                .fold([Matrix::zeros(); D], |sum, own| {
                    std::array::from_fn(|axis| sum[axis] - own[axis])
                }),
        };
        let squares = layers.squares(weight);
        Some(LayeredShare {
            layers,
            stiffness,
            forward: std::array::from_fn(|axis| lever[axis] - squares[axis] * stiffness),
        })
    }

    /// Adds the diagonal part of the hourglass energy of one bond to a row with weights `row`.
    fn stretch(
        &mut self,
        owner: usize,
        bond: usize,
        sign: Vector<D>,
        stiffness: f64,
        row: Vector<D>,
    ) {
        let end = self.elastic.around.families.neighbour(bond);
        let (end, own) = (self.place[end] as usize, self.place[owner] as usize);
        for axis in 0..D {
            let force = stiffness * row[axis];
            self.values[axis * self.width + end * D + axis] += force * sign[axis];
            self.values[axis * self.width + own * D + axis] -= force;
        }
    }

    /// Adds what couples the row's point to all points of one family.
    fn couple(&mut self, share: &Subdomain<'_, D>) {
        let elastic = self.elastic;
        let families = &elastic.around.families;
        let stresses = self.moduli.stresses(share.owner, &share.strain);
        let (plain, _) = elastic.hourglass(share.owner);
        let drive = self.moduli.drive(share.owner);
        let mut own = [[0.0; D]; D];
        for (k, bond) in families.family(share.owner).enumerate() {
            let weight = &elastic.gradient.weight[bond];
            let softened = drive.map(|(factor, forces)| forces[k] * factor);
            let rest = match &share.layered {
                None => Matrix::identity() * share.hourglass.dot(&plain.weight[bond]),
                Some(layered) => layered.rest(elastic, share, (k, bond)),
            };
            let place = self.place[families.neighbour(bond)] as usize;
            let sign = elastic.signs(bond);
            for a in 0..D {
                let row = &mut self.values[a * self.width + place * D..][..D];
                let mut traction = stresses[a] * weight;
                if let Some(softened) = &softened {
                    traction += softened * share.drive[a];
                }
                for b in 0..D {
                    let entry = (traction[b] - rest[(a, b)]) * share.sign[a];
                    row[b] += entry * sign[b];
                    own[a][b] -= entry;
                }
            }
        }
        let place = self.place[share.owner] as usize;
        for (a, own) in own.iter().enumerate() {
            let row = &mut self.values[a * self.width + place * D..][..D];
            row.iter_mut()
                .zip(own)
                .for_each(|(entry, own)| *entry += own);
        }
    }
}
