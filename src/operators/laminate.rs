//! Families in which moduli vary: the strain of layers in the mean, kinked bonds in the hourglass energy.
//!
//! The strain ε of a family is the mean of a strain that jumps from layer to layer. Its energy is that of
//! [`Backus`], with the means of what lies along the bonds, ⟨·⟩ = Σ_b w_b (·)_b with w_b = (g_b·n)(ξ_b·n), g being the
//! weights of the gradient. A bond of the family is then not expected to stretch by Hξ but by
//!
//!   A_b H = Hξ + ξ_n [n (α ε_nn + β tr ε_t) + γ 2(εn)_t],
//!   α = (1/M)_b/⟨1/M⟩ − 1,  β = (1/M)_b ⟨λ/M⟩/⟨1/M⟩ − (λ/M)_b,  γ = (1/μ)_b/⟨1/μ⟩ − 1,
//!
//! and its hourglass energy is that of the rest. Displacements of layers with continuous tractions have no rest.
//!
//! Along an interface that is curved, strain varies across it, and beyond a contrast of 10 the mean is no longer near
//! what the stiffer side has: there the derivatives along the interface take bonds as far as what lies along them is
//! as stiff as the point, and the stiffness along it is that of the point.

use super::Neighbourhood;
use crate::geometry::{Matrix, Vector};
use crate::material::{Backus, Lame};

/// A family with layers.
#[derive(Debug, Clone)]
pub struct Layered<const D: usize> {
    /// The point whose family it is.
    pub owner: usize,
    /// Unit normal n of its layers.
    pub normal: Vector<D>,
    /// What lies along each of its bonds.
    pub along: Vec<Backus>,
    /// Moduli of the point, where the stiffness along the layers is that of the point and not the mean.
    pub own: Option<Lame>,
}

impl<const D: usize> Layered<D> {
    /// Weights of the gradient whose derivatives along the layers are those of bonds in rock as stiff as the
    /// point, from the weights `weight` of the family; `None` where the mean counts.
    pub fn weights(
        &self,
        around: &Neighbourhood<D>,
        weight: &[Vector<D>],
    ) -> Option<Vec<Vector<D>>> {
        let own = self.own?;
        let family = around.families.family(self.owner);
        let scaled = |(bond, along): (usize, &Backus)| {
            let stiffness = (along.shear_compliance * own.mu).recip().min(1.0);
            around.measure[bond] * (stiffness + SINGULAR)
        };
        let measure: Vec<f64> = family.clone().zip(&self.along).map(scaled).collect();
        let arms = family.map(|bond| around.bond_vector(self.owner, bond));
        let arms: Vec<Vector<D>> = arms.collect();
        let mut shape = Matrix::zeros();
        for (xi, measure) in arms.iter().zip(&measure) {
            shape += xi * xi.transpose() * *measure;
        }
        let inverse = shape.try_inverse()?;
        let weights = arms.iter().zip(&measure).zip(weight);
        let turned = weights.map(|((xi, measure), plain)| {
            let along = inverse * xi * *measure;
            along + self.normal * (plain - along).dot(&self.normal)
        });
        Some(turned.collect())
    }
}

/// Part of a bond's weight that softer rock along it leaves, as in the prototype: a family that is all soft but for
/// its point would have no derivative.
const SINGULAR: f64 = 1e-6;

/// All families with layers.
#[derive(Debug, Clone)]
pub struct Laminate<const D: usize> {
    /// Place in `families` per point, shape `(n,)`; `NONE` where moduli do not vary.
    place: Vec<u32>,
    families: Vec<Stack<D>>,
    /// Of the bonds of these families, one after the other.
    kinks: Vec<Kink>,
    /// Σ_b ω V A_bᵀA_b of these families, D⁴ each, rows (component, axis).
    squares: Vec<f64>,
}

const NONE: u32 = u32::MAX;

#[derive(Debug, Clone)]
struct Stack<const D: usize> {
    normal: Vector<D>,
    means: Backus,
    first: u32,
}

/// How much more or less than the mean the layers along a bond give way: α, β and γ.
#[derive(Debug, Clone, Copy)]
struct Kink {
    stretch: f64,
    spread: f64,
    shear: f64,
}

/// The layers of one family.
#[derive(Debug, Clone, Copy)]
pub struct Layers<'a, const D: usize> {
    /// Unit normal n.
    pub normal: &'a Vector<D>,
    /// Means over the family.
    pub means: &'a Backus,
    kinks: &'a [Kink],
    squares: &'a [f64],
}

impl<const D: usize> Laminate<D> {
    /// Layers of the given families under the given weights of the gradient, 1/m per bond.
    pub fn new(
        around: &Neighbourhood<D>,
        weight: &[Vector<D>],
        layered: impl IntoIterator<Item = Layered<D>>,
    ) -> Self {
        let mut laminate = Laminate {
            place: vec![NONE; around.len()],
            families: Vec::new(),
            kinks: Vec::new(),
            squares: Vec::new(),
        };
        for own in layered {
            laminate.place[own.owner] = laminate.families.len() as u32;
            laminate.push(around, weight, &own);
        }
        laminate
    }

    fn push(&mut self, around: &Neighbourhood<D>, weight: &[Vector<D>], own: &Layered<D>) {
        let (owner, normal) = (own.owner, own.normal);
        let family = around.families.family(owner);
        let share =
            |bond: usize| weight[bond].dot(&normal) * around.bond_vector(owner, bond).dot(&normal);
        let means = Backus::sum(family.clone().map(share).zip(own.along.iter().copied()));
        let mut means = means.within(&own.along);
        if let Some(own) = own.own {
            (means.shear, means.area) = (own.mu, Backus::of(own).area);
        }
        let first = self.kinks.len();
        self.kinks.extend(own.along.iter().map(|bond| Kink {
            stretch: bond.compliance / means.compliance - 1.0,
            spread: bond.compliance / means.compliance * means.ratio - bond.ratio,
            shear: bond.shear_compliance / means.shear_compliance - 1.0,
        }));
        let mut squares = vec![0.0; D * D * D * D];
        for (bond, kink) in family.zip(&self.kinks[first..]) {
            let lever = kink.lever(&normal, &around.bond_vector(owner, bond));
            add_square(&mut squares, &lever, around.measure[bond]);
        }
        self.squares.extend(squares);
        self.families.push(Stack {
            normal,
            means,
            first: first as u32,
        });
    }

    /// The layers of a point's family, if it has any.
    pub fn of(&self, owner: usize) -> Option<Layers<'_, D>> {
        let place = self.place[owner];
        let stack = self.families.get(place as usize)?;
        let next = self.families.get(place as usize + 1);
        let end = next.map_or(self.kinks.len(), |next| next.first as usize);
        let squares = D * D * D * D;
        Some(Layers {
            normal: &stack.normal,
            means: &stack.means,
            kinks: &self.kinks[stack.first as usize..end],
            squares: &self.squares[place as usize * squares..][..squares],
        })
    }

    /// Number of families with layers.
    pub fn len(&self) -> usize {
        self.families.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.families.is_empty()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        4 * self.place.len()
            + size_of::<Stack<D>>() * self.families.len()
            + size_of::<Kink>() * self.kinks.len()
            + 8 * self.squares.len()
    }
}

/// Adds weight · AᵀA of the map A of one bond.
fn add_square<const D: usize>(squares: &mut [f64], lever: &[Matrix<D>; D], weight: f64) {
    let rows = squares.chunks_exact_mut(D * D).enumerate();
    for (row, squares) in rows {
        let at = (row / D, row % D);
        for (column, square) in squares.iter_mut().enumerate() {
            let other = (column / D, column % D);
            let products = lever.iter().map(|own| own[at] * own[other]);
            *square += weight * products.sum::<f64>();
        }
    }
}

impl Kink {
    /// A_b: per component of the stretch its weights of the components of H.
    fn lever<const D: usize>(&self, normal: &Vector<D>, xi: &Vector<D>) -> [Matrix<D>; D] {
        let across = normal * normal.transpose();
        let plane = Matrix::identity() - across;
        let inner = across * self.stretch + plane * self.spread;
        let reach = xi.dot(normal);
        std::array::from_fn(|axis| {
            let mixed = plane.column(axis) * normal.transpose() * self.shear;
            let mut own = (inner * normal[axis] + mixed + mixed.transpose()) * reach;
            for k in 0..D {
                own[(axis, k)] += xi[k];
            }
            own
        })
    }
}

impl<const D: usize> Layers<'_, D> {
    /// Stretch of a bond of the family that the displacement gradient `slope` lets expect, m.
    pub fn stretch(&self, place: usize, xi: &Vector<D>, slope: &Matrix<D>) -> Vector<D> {
        let (kink, normal) = (&self.kinks[place], self.normal);
        let turned = (slope + slope.transpose()) * normal * 0.5;
        let stretch = turned.dot(normal);
        let sheared = turned - normal * stretch;
        let spread = slope.trace() - stretch;
        let along = normal * (kink.stretch * stretch + kink.spread * spread);
        slope * xi + (along + sheared * (2.0 * kink.shear)) * xi.dot(normal)
    }

    /// A_bᵀ f of a force on the end of a bond, N m.
    pub fn pull(&self, place: usize, xi: &Vector<D>, force: &Vector<D>) -> Matrix<D> {
        let (kink, normal) = (&self.kinks[place], self.normal);
        let across = normal * normal.transpose();
        let along = force.dot(normal);
        let mixed = (force - normal * along) * normal.transpose() * kink.shear;
        let inner = across * kink.stretch + (Matrix::identity() - across) * kink.spread;
        force * xi.transpose() + (inner * along + mixed + mixed.transpose()) * xi.dot(normal)
    }

    /// A_b of a bond of the family.
    pub fn lever(&self, place: usize, xi: &Vector<D>) -> [Matrix<D>; D] {
        self.kinks[place].lever(self.normal, xi)
    }

    /// Σ_b ω V A_bᵀA_b for H = e_k ⊗ weight, as one matrix over (component, axis) per k.
    pub fn squares(&self, weight: &Vector<D>) -> [Matrix<D>; D] {
        std::array::from_fn(|component| {
            Matrix::from_fn(|other, axis| {
                let column = other * D + axis;
                let row = |k: usize| self.squares[(component * D + k) * D * D + column];
                (0..D).map(|k| row(k) * weight[k]).sum()
            })
        })
    }

    /// Stress of the family, Pa.
    pub fn stress(&self, strain: &Matrix<D>) -> Matrix<D> {
        self.means.stress(self.normal, strain)
    }

    /// Stress at its point, and across the plane of plane strain, Pa.
    pub fn stress_in(&self, layer: Lame, strain: &Matrix<D>) -> (Matrix<D>, f64) {
        self.means.stress_in(layer, self.normal, strain)
    }
}
