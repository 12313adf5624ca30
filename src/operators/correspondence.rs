//! The correspondence form of diffusion: κ |∇̃p|² plus the hourglass term (Eqs. 10 and 59).
//!
//! The hourglass residual R is an orthogonal projection in the measure ω V, so
//! Rᵀ D(ω V) R = D(ω V) − Gᵀ K G on one family, and the whole local form is
//!
//!   A_i = diag(2 c V_i ω V_j/m_i) κ_i + Gᵀ [V_i κ_i (I − (2c/m_i) K_i)] G.
//!
//! Where K_i is isotropic and c = D/2 the bracket vanishes: the family needs one hop only. Every
//! mirrored square lattice with c = 1 is such a case.

use std::sync::Arc;

use super::{BondForm, Coupling, Gradient, Neighbourhood, family_gradient};
use crate::geometry::{Matrix, Vector};
use crate::parallel;

/// Correspondence diffusion operator; the mobility of the family's owner counts.
#[derive(Debug, Clone)]
pub(crate) struct Correspondence<const D: usize> {
    around: Arc<Neighbourhood<D>>,
    hourglass: f64,
    /// What the second hop needs, present where it does not vanish.
    second_hop: Option<SecondHop<D>>,
}

#[derive(Debug, Clone)]
struct SecondHop<const D: usize> {
    couples: Vec<bool>,
    /// V_i (I − (2c/m_i) K_i), shape `(n,)`.
    bracket: Vec<Matrix<D>>,
    plain: Gradient<D>,
    /// Divergence-consistent gradient, if one is used.
    corrected: Option<Gradient<D>>,
}

/// Anisotropy of the shape tensor below which the second hop is rounding error.
const ISOTROPIC: f64 = 1e-11;

impl<const D: usize> Correspondence<D> {
    /// Operator with hourglass coefficient `hourglass` (c, 1 by default; Eq. 54 with its misprint
    /// corrected: the coefficient is c κ, not the shear modulus).
    pub(crate) fn new(
        around: Arc<Neighbourhood<D>>,
        hourglass: f64,
        corrected: Option<Gradient<D>>,
    ) -> Self {
        let bracket: Vec<Matrix<D>> =
            parallel::map(around.len(), |i| bracket(&around, i, hourglass));
        let couples: Vec<bool> = bracket
            .iter()
            .map(|b| corrected.is_some() || b.amax() > ISOTROPIC)
            .collect();
        let second_hop = couples.iter().any(|&c| c).then(|| SecondHop {
            couples,
            bracket: bracket
                .iter()
                .zip(&around.cloud.volume)
                .map(|(b, v)| b * *v)
                .collect(),
            plain: Gradient::plain(&around),
            corrected,
        });
        Correspondence {
            around,
            hourglass,
            second_hop,
        }
    }
}

/// I − (2c/m) K of one family.
fn bracket<const D: usize>(around: &Neighbourhood<D>, owner: usize, hourglass: f64) -> Matrix<D> {
    if !around.families.share.holds(owner) {
        return Matrix::zeros();
    }
    Matrix::identity() - around.shape(owner) * (2.0 * hourglass / around.moment[owner])
}

impl<const D: usize> BondForm<D> for Correspondence<D> {
    fn name(&self) -> &'static str {
        "correspondence"
    }

    fn neighbourhood(&self) -> &Neighbourhood<D> {
        &self.around
    }

    fn geometric(&self, owner: usize, bond: usize) -> f64 {
        let scale = 2.0 * self.hourglass / self.around.moment[owner];
        scale * self.around.cloud.volume[owner] * self.around.measure[bond]
    }

    fn mean(&self, owner: f64, _end: f64) -> f64 {
        owner
    }

    fn couples(&self, owner: usize) -> bool {
        self.second_hop
            .as_ref()
            .is_some_and(|hop| hop.couples[owner])
    }

    fn coupling(&self, owner: usize, mobility: &[f64]) -> [Option<Coupling<'_, D>>; 2] {
        let Some(hop) = self.second_hop.as_ref().filter(|hop| hop.couples[owner]) else {
            return [None, None];
        };
        let family = self.around.families.family(owner);
        let inner = hop.bracket[owner] * mobility[owner];
        let plain = &hop.plain.weight[family.clone()];
        match &hop.corrected {
            None => [
                Some(Coupling {
                    stiffness: inner,
                    weight: plain,
                }),
                None,
            ],
            Some(gradient) => {
                let full = Matrix::identity() * (self.around.cloud.volume[owner] * mobility[owner]);
                let weight = &gradient.weight[family];
                [
                    Some(Coupling {
                        stiffness: full,
                        weight,
                    }),
                    Some(Coupling {
                        stiffness: inner - full,
                        weight: plain,
                    }),
                ]
            }
        }
    }

    fn flux(&self, owner: usize, mobility: &[f64], difference: &dyn Fn(usize) -> f64) -> Vector<D> {
        let corrected = self
            .second_hop
            .as_ref()
            .and_then(|hop| hop.corrected.as_ref());
        let Some(gradient) = corrected else {
            return family_gradient(&self.around, owner, difference) * -mobility[owner];
        };
        let family = self.around.families.family(owner);
        let slope: Vector<D> = family
            .map(|bond| gradient.weight[bond] * difference(bond))
            .sum();
        slope * -mobility[owner]
    }

    fn bytes(&self) -> usize {
        self.second_hop.as_ref().map_or(0, |hop| {
            let corrected = hop.corrected.as_ref().map_or(0, Gradient::bytes);
            hop.couples.len() * (1 + 8 * D * D) + hop.plain.bytes() + corrected
        })
    }
}
