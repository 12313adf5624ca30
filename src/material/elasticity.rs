//! Isotropic linear elasticity.

use crate::geometry::{Matrix, Vector};

/// Lamé's constants of one point, Pa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lame {
    /// First constant λ.
    pub lambda: f64,
    /// Shear modulus μ.
    pub mu: f64,
}

impl Lame {
    /// (λ + 2μ)/μ: resistance to changes of volume over that to changes of shape.
    pub fn volume_stiffness(self) -> f64 {
        self.lambda / self.mu + 2.0
    }

    /// Stress λ tr(ε) I + 2 μ ε of a strain (plane strain in 2-D), Pa.
    pub fn stress<const D: usize>(self, strain: &Matrix<D>) -> Matrix<D> {
        strain * (2.0 * self.mu) + Matrix::identity() * (self.lambda * strain.trace())
    }
}

/// Strain of the displacement gradient e_axis ⊗ `weight`.
pub(crate) fn unit_strain<const D: usize>(axis: usize, weight: &Vector<D>) -> Matrix<D> {
    let mut strain = Matrix::zeros();
    for k in 0..D {
        strain[(axis, k)] += 0.5 * weight[k];
        strain[(k, axis)] += 0.5 * weight[k];
    }
    strain
}

/// Elastic constants of the drained rock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elasticity {
    /// Young's modulus E, Pa; positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν, from 0, below 0.5.
    pub poissons_ratio: f64,
}

impl Elasticity {
    /// Lamé's first constant λ = E ν / ((1 + ν)(1 − 2ν)), Pa (plane strain in 2-D).
    pub fn lambda(&self) -> f64 {
        let (modulus, ratio) = (self.youngs_modulus, self.poissons_ratio);
        modulus * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio))
    }

    /// Shear modulus μ = E / (2(1 + ν)), Pa.
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poissons_ratio)
    }

    /// Modulus of uniaxial strain λ + 2μ, Pa.
    pub fn oedometer_modulus(&self) -> f64 {
        self.lambda() + 2.0 * self.shear_modulus()
    }

    /// Lamé's constants, Pa.
    pub fn lame(&self) -> Lame {
        Lame {
            lambda: self.lambda(),
            mu: self.shear_modulus(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_of_a_rock_by_hand() {
        // E = 10 GPa, ν = 0.25: μ = 10/2.5 = 4, λ = 2.5/(1.25 · 0.5) = 4, λ + 2μ = 12 GPa.
        let rock = Elasticity {
            youngs_modulus: 1e10,
            poissons_ratio: 0.25,
        };
        let Lame { lambda, mu } = rock.lame();
        assert!((lambda - 4e9).abs() < 1.0);
        assert!((mu - 4e9).abs() < 1.0);
        assert!((rock.oedometer_modulus() - 1.2e10).abs() < 1.0);
    }
}
