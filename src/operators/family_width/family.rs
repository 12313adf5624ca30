//! The width of one family: energy of the points beside a sharp crack.

use crate::geometry::{Matrix, Vector};
use crate::material::Lame;

/// Opening of the sharp crack by which widths are measured, squared, in G_c δ/E′.
///
/// So wide that a crack takes by its points about what it takes in the end. On the lattice of δ = 2.3 Δx with
/// ν = 0.3 the mean width over 2δ is 0.79, 0.88 and 0.92 at 20, 60 and 200 with g = (1 − s)², 0.87, 0.93 and
/// 0.94 with g = (1 − s)^(3/2), and that of the convex hull 0.94; with the widths of 60 a notched square took
/// 1.01 to 1.04 G_c in any direction.
const OPENING: f64 = 60.0;

/// A whole family, with the mirror images beyond sides and the bonds that cracks cut.
#[derive(Debug, Clone)]
pub struct WholeFamily<const D: usize> {
    /// Horizon δ, m.
    pub horizon: f64,
    /// Elastic constants of the point; only λ/μ matters.
    pub lame: Lame,
    /// Bond vectors ξ, m, with their weights ω V_j; only the ratios of weights matter.
    pub bonds: Vec<(Vector<D>, f64)>,
}

/// What breaking costs, in units of the strength c.
pub struct BandLaw {
    /// Share of the hourglass energy, in μ, that drives damage.
    pub hourglass: f64,
    /// F(X) = min over s of g(s) X + s²: energy of a point with the driving energy X c, over c. A constant 1
    /// gives widths of convex hulls.
    pub energy: Box<dyn Fn(f64) -> f64 + Send + Sync>,
}

/// Widths of one family, over its horizon.
#[derive(Debug, Clone)]
pub(super) struct Widths {
    /// W/δ per direction, shape `(directions,)`.
    pub width: Vec<f64>,
    /// How far the family reaches where it reaches least, over δ.
    pub reach: f64,
}

/// A family in units of its horizon and of E′.
struct Band<'a, const D: usize> {
    bonds: &'a [(Vector<D>, f64)],
    inverse_shape: Matrix<D>,
    lame: Lame,
    /// h/m, the hourglass modulus over the moment.
    hourglass: f64,
    law: &'a BandLaw,
}

impl<const D: usize> WholeFamily<D> {
    /// Effective widths W(n)/δ in the given directions; `None` if the family does not span the space.
    ///
    /// W(n) is the energy, per area and over c, of the points of a medium made of such families beside a
    /// crack of normal n with the opening w* n. At the distance d of a point from the crack it breaks the
    /// bonds with ξ·n > d, which leaves the gradient w* n⊗g, g = Σ_broken of the gradient's weights, and the
    /// driving energy w*² q,
    ///
    ///   q = (λ/2) a² + μ (a² + b²/2) + (h/m)(Σ_broken ωV − g·K g),   a = g·n,  a² + b² = |g|².
    ///
    /// W(n) = Σ_±n ∫₀^∞ F(w*² q(d)/c) dd, a sum as q is constant between the ends of bonds. In F the
    /// strength c is that of the hull, G_c/(max ξ·n − min ξ·n), and w*² = 60 G_c δ/E′.
    pub(super) fn widths(&self, directions: &[Vector<D>], law: &BandLaw) -> Option<Widths> {
        let scaled: Vec<(Vector<D>, f64)> = (self.bonds.iter())
            .map(|(xi, weight)| (xi / self.horizon, *weight))
            .collect();
        let shape: Matrix<D> = (scaled.iter())
            .map(|(xi, weight)| xi * xi.transpose() * *weight)
            .sum();
        let band = Band {
            inverse_shape: shape.try_inverse()?,
            hourglass: law.hourglass * self.lame.mu / shape.trace(),
            lame: self.lame,
            bonds: &scaled,
            law,
        };
        let mut order = Vec::with_capacity(scaled.len());
        let mut widths = Widths {
            width: Vec::with_capacity(directions.len()),
            reach: f64::INFINITY,
        };
        for normal in directions {
            let (width, reach) = band.width(normal, &mut order);
            widths.width.push(width);
            widths.reach = widths.reach.min(reach);
        }
        (widths.reach.is_finite() && widths.width.iter().all(|width| width.is_finite()))
            .then_some(widths)
    }
}

impl<const D: usize> Band<'_, D> {
    /// W(n)/δ, and the smaller of the family's reaches along ±n; `order` is room to work in.
    fn width(&self, normal: &Vector<D>, order: &mut Vec<(f64, usize)>) -> (f64, f64) {
        order.clear();
        let bonds = self.bonds.iter().enumerate();
        order.extend(bonds.map(|(bond, (xi, _))| (xi.dot(normal), bond)));
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let ends = |end: Option<&(f64, usize)>| end.map_or(0.0, |(along, _)| *along);
        let (up, down) = (ends(order.first()).max(0.0), -ends(order.last()).min(0.0));
        // w*²/c in units of δ²/E′.
        let scale = OPENING * (up + down) / plane_modulus(self.lame);
        let above = self.one_side(order.iter().copied(), normal, scale);
        let beneath = order.iter().rev().map(|&(along, bond)| (-along, bond));
        let below = self.one_side(beneath, &-normal, scale);
        (above + below, up.min(down))
    }

    /// ∫₀^∞ F dd on one side; bonds come by falling ξ·n.
    fn one_side(
        &self,
        bonds: impl Iterator<Item = (f64, usize)>,
        normal: &Vector<D>,
        scale: f64,
    ) -> f64 {
        let (mut sum, mut weight, mut width) = (Vector::zeros(), 0.0, 0.0);
        let mut bonds = bonds.take_while(|(along, _)| *along > 0.0).peekable();
        while let Some((along, bond)) = bonds.next() {
            let (xi, own) = &self.bonds[bond];
            sum += xi * *own;
            weight += own;
            let next = bonds.peek().map_or(0.0, |(next, _)| *next);
            if along > next {
                let driving = scale * self.driving(&sum, weight, normal);
                width += (along - next) * (self.law.energy)(driving);
            }
        }
        width
    }

    /// q of the broken bonds, whose Σ ωV ξ and Σ ωV are given.
    fn driving(&self, sum: &Vector<D>, weight: f64, normal: &Vector<D>) -> f64 {
        let gradient = self.inverse_shape * sum;
        let along = gradient.dot(normal).powi(2);
        let Lame { lambda, mu } = self.lame;
        let elastic = 0.5 * lambda * along + 0.5 * mu * (along + gradient.norm_squared());
        // Never negative but by rounding.
        let uneven = (weight - gradient.dot(sum)).max(0.0);
        elastic + self.hourglass * uneven
    }
}

/// E′ = E/(1 − ν²), the modulus of plane strain.
fn plane_modulus(Lame { lambda, mu }: Lame) -> f64 {
    4.0 * mu * (lambda + mu) / (lambda + 2.0 * mu)
}
