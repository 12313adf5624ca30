//! Layers of rock in one family: the averages of Backus.
//!
//! Across layers with the normal n the traction T is continuous, along them the strain ε_t = PεP is, P = I − n⊗n. With
//! M = λ + 2μ and means ⟨·⟩ over the layers the strain of the whole tells
//!
//!   T_n = (ε_nn + ⟨λ/M⟩ tr ε_t)/⟨1/M⟩,  T_t = 2 (εn)_t/⟨1/μ⟩,
//!
//! and its energy ½⟨1/M⟩T_n² + ½⟨1/μ⟩|T_t|² + ⟨μ⟩ ε_t:ε_t + ½⟨λ − λ²/M⟩(tr ε_t)² is that of the layers exactly
//! (G. E. Backus, J. Geophys. Res. 67, 1962, 4427).

use super::Lame;
use crate::geometry::{Matrix, Vector};

/// Means of a stack of layers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Backus {
    /// ⟨1/M⟩, 1/Pa.
    pub compliance: f64,
    /// ⟨1/μ⟩, 1/Pa.
    pub shear_compliance: f64,
    /// ⟨λ/M⟩.
    pub ratio: f64,
    /// ⟨μ⟩, Pa.
    pub shear: f64,
    /// ⟨λ − λ²/M⟩, Pa.
    pub area: f64,
}

impl Backus {
    /// Rock without layers.
    pub fn of(lame: Lame) -> Self {
        let Lame { lambda, mu } = lame;
        let modulus = lambda + 2.0 * mu;
        Backus {
            compliance: modulus.recip(),
            shear_compliance: mu.recip(),
            ratio: lambda / modulus,
            shear: mu,
            area: lambda - lambda * lambda / modulus,
        }
    }

    /// Σ share · layer over (share, layer).
    pub fn sum(layers: impl IntoIterator<Item = (f64, Backus)>) -> Self {
        let mut sum = Backus::default();
        for (share, own) in layers {
            sum.compliance += share * own.compliance;
            sum.shear_compliance += share * own.shear_compliance;
            sum.ratio += share * own.ratio;
            sum.shear += share * own.shear;
            sum.area += share * own.area;
        }
        sum
    }

    /// The same with every mean between the least and the largest of `layers`, which shares that are not all
    /// positive may leave.
    pub fn within(self, layers: &[Backus]) -> Self {
        let bound = |value: f64, of: fn(&Backus) -> f64| {
            let values = layers.iter().map(of);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            value.clamp(low, values.fold(low, f64::max))
        };
        Backus {
            compliance: bound(self.compliance, |own| own.compliance),
            shear_compliance: bound(self.shear_compliance, |own| own.shear_compliance),
            ratio: bound(self.ratio, |own| own.ratio),
            shear: bound(self.shear, |own| own.shear),
            area: bound(self.area, |own| own.area),
        }
    }

    /// Stress of the whole, Pa.
    pub fn stress<const D: usize>(&self, normal: &Vector<D>, strain: &Matrix<D>) -> Matrix<D> {
        let split = Split::of(self, normal, strain);
        split.stress(normal, self)
    }

    /// Stress in a layer of the given moduli, and across the plane of plane strain, Pa.
    pub fn stress_in<const D: usize>(
        &self,
        layer: Lame,
        normal: &Vector<D>,
        strain: &Matrix<D>,
    ) -> (Matrix<D>, f64) {
        let split = Split::of(self, normal, strain);
        let own = Backus::of(layer);
        let across = own.ratio * split.pull + own.area * split.spread;
        (split.stress(normal, &own), across)
    }

    /// The larger one of the moduli of uniaxial strain across and along the layers, Pa.
    pub fn stiffest(&self) -> f64 {
        let across = self.compliance.recip();
        across.max(2.0 * self.shear + self.area + self.ratio * self.ratio * across)
    }
}

/// What layers share: tractions and the strain along them.
struct Split<const D: usize> {
    /// T_n, Pa.
    pull: f64,
    /// T_t, Pa.
    shear: Vector<D>,
    /// ε_t.
    along: Matrix<D>,
    /// tr ε_t.
    spread: f64,
}

impl<const D: usize> Split<D> {
    fn of(means: &Backus, normal: &Vector<D>, strain: &Matrix<D>) -> Self {
        let turned = strain * normal;
        let stretch = turned.dot(normal);
        let sheared = turned - normal * stretch;
        let spread = strain.trace() - stretch;
        let mixed = sheared * normal.transpose();
        Split {
            pull: (stretch + means.ratio * spread) / means.compliance,
            shear: sheared * (2.0 / means.shear_compliance),
            along: strain - mixed - mixed.transpose() - normal * normal.transpose() * stretch,
            spread,
        }
    }

    /// Stress with these tractions where the moduli along the layers are `own`.
    fn stress(&self, normal: &Vector<D>, own: &Backus) -> Matrix<D> {
        let mixed = self.shear * normal.transpose();
        let across = normal * normal.transpose();
        let spread = own.area * self.spread + own.ratio * self.pull;
        across * self.pull
            + mixed
            + mixed.transpose()
            + self.along * (2.0 * own.shear)
            + (Matrix::identity() - across) * spread
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRAIN: [f64; 9] = [1.0, 0.3, -0.2, 0.3, -0.5, 0.7, -0.2, 0.7, 0.4];

    fn lame(lambda: f64, mu: f64) -> Lame {
        Lame { lambda, mu }
    }

    /// One kind of rock has no layers: Hooke's law in any direction.
    #[test]
    fn equal_layers_are_isotropic() {
        let rock = lame(4.0, 3.0);
        let strain = Matrix::<3>::from_row_slice(&STRAIN);
        for normal in [
            [1.0, 0.0, 0.0],
            [0.6, 0.0, -0.8],
            [2.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0],
        ] {
            let normal = Vector::<3>::from_row_slice(&normal);
            let means = Backus::sum([(0.25, Backus::of(rock)), (0.75, Backus::of(rock))]);
            let found = means.stress(&normal, &strain);
            let (own, _) = means.stress_in(rock, &normal, &strain);
            assert!((found - rock.stress(&strain)).amax() < 1e-13);
            assert!((own - rock.stress(&strain)).amax() < 1e-13);
            assert!((means.stiffest() - 10.0).abs() < 1e-13);
        }
    }

    /// Stresses of layers, each with the strain that its traction asks for, have the mean stress of the whole, their
    /// strains its mean strain.
    #[test]
    fn layers_have_the_mean_strain_and_the_mean_stress_of_the_whole() {
        let layers = [(0.3, lame(4.0, 3.0)), (0.7, lame(0.1, 20.0))];
        let means = Backus::sum(layers.map(|(share, rock)| (share, Backus::of(rock))));
        let strain = Matrix::<3>::from_row_slice(&STRAIN);
        let normal = Vector::<3>::new(0.6, 0.0, -0.8);
        let (mut mean, mut stress) = (Matrix::zeros(), Matrix::zeros());
        for (share, rock) in layers {
            let (own, _) = means.stress_in(rock, &normal, &strain);
            let bulk = own.trace() / (3.0 * rock.lambda + 2.0 * rock.mu);
            mean += (own - Matrix::identity() * (rock.lambda * bulk)) * (share / (2.0 * rock.mu));
            stress += own * share;
        }
        assert!((mean - strain).amax() < 1e-14, "{mean}");
        let found = means.stress(&normal, &strain);
        assert!((stress - found).amax() < 1e-13, "{stress} {found}");
        // That of the stiffer layer is 40.1.
        assert!(
            (28.0..40.1).contains(&means.stiffest()),
            "{}",
            means.stiffest()
        );
    }

    /// In plane strain the stress across the plane is that of space.
    #[test]
    fn plane_strain_is_a_plane_of_space() {
        let rock = lame(4.0, 3.0);
        let means = Backus::sum([(0.5, Backus::of(rock)), (0.5, Backus::of(lame(1.0, 9.0)))]);
        let (flat, across) = means.stress_in(
            rock,
            &Vector::<2>::new(0.6, 0.8),
            &Matrix::<2>::new(1.0, 0.3, 0.3, -0.5),
        );
        let strain = Matrix::<3>::from_row_slice(&[1.0, 0.3, 0.0, 0.3, -0.5, 0.0, 0.0, 0.0, 0.0]);
        let (solid, _) = means.stress_in(rock, &Vector::<3>::new(0.6, 0.8, 0.0), &strain);
        assert!((solid[(2, 2)] - across).abs() < 1e-14);
        assert!((solid.fixed_view::<2, 2>(0, 0) - flat).amax() < 1e-14);
    }

    #[test]
    fn means_stay_between_those_of_the_layers() {
        let layers = [Backus::of(lame(4.0, 3.0)), Backus::of(lame(1.0, 9.0))];
        let odd = Backus::sum([(1.5, layers[0]), (-0.5, layers[1])]).within(&layers);
        assert!((odd.shear - 3.0).abs() < 1e-15, "{odd:?}");
        assert!((odd.compliance - 0.1).abs() < 1e-15, "{odd:?}");
    }
}
