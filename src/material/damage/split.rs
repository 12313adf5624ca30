//! The energy's two parts and their stresses.

use super::{DamageLaw, EnergySplit, PointState};
use crate::geometry::Matrix;
use crate::material::Lame;
use crate::material::eigen::eigen;

/// The parts of energy and stress of a strain, not degraded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitEnergies<const D: usize> {
    /// D = ψ⁺ + σ⁰:ε, J/m³.
    pub tensile_energy: f64,
    /// ψ⁻, J/m³.
    pub compressive_energy: f64,
    /// σ⁺ + σ⁰, Pa.
    pub degraded_stress: Matrix<D>,
    /// σ⁻, Pa.
    pub intact_stress: Matrix<D>,
}

impl DamageLaw {
    /// Splits energy and stress of a strain (plane strain in 2-D).
    pub fn parts<const D: usize>(
        &self,
        point: &PointState<D>,
        strain: &Matrix<D>,
    ) -> SplitEnergies<D> {
        let lame = point.lame;
        let mut parts = match self.split {
            EnergySplit::Spectral => spectral(lame, strain),
            EnergySplit::VolumetricDeviatoric => volumetric(lame, strain),
            EnergySplit::None => whole(lame, strain),
        };
        parts.tensile_energy += point.prestress.dot(strain);
        parts.degraded_stress += point.prestress;
        parts
    }
}

impl DamageLaw {
    /// Stresses across the plane of plane strain, σ⁺ and σ⁻ without σ⁰, Pa.
    pub fn across<const D: usize>(&self, lame: Lame, strain: &Matrix<D>) -> [f64; 2] {
        let trace = strain.trace();
        let (up, down) = (trace.max(0.0), trace.min(0.0));
        match self.split {
            // The third principal strain is zero: only the trace pulls there.
            EnergySplit::Spectral => [lame.lambda * up, lame.lambda * down],
            EnergySplit::VolumetricDeviatoric => {
                let bulk = lame.lambda + 2.0 / 3.0 * lame.mu;
                [bulk * up - 2.0 / 3.0 * lame.mu * trace, bulk * down]
            }
            EnergySplit::None => [lame.lambda * trace, 0.0],
        }
    }
}

fn whole<const D: usize>(lame: Lame, strain: &Matrix<D>) -> SplitEnergies<D> {
    let stress = lame.stress(strain);
    SplitEnergies {
        tensile_energy: 0.5 * stress.dot(strain),
        compressive_energy: 0.0,
        degraded_stress: stress,
        intact_stress: Matrix::zeros(),
    }
}

/// Positive and negative principal strains; the third one of plane strain is zero.
fn spectral<const D: usize>(lame: Lame, strain: &Matrix<D>) -> SplitEnergies<D> {
    let Lame { lambda, mu } = lame;
    let (values, vectors) = eigen(strain);
    let opened = values.map(|value| value.max(0.0));
    let positive = vectors * Matrix::from_diagonal(&opened) * vectors.transpose();
    let (up, down) = (strain.trace().max(0.0), strain.trace().min(0.0));
    let closed = values - opened;
    let stress =
        |part: Matrix<D>, trace: f64| part * (2.0 * mu) + Matrix::identity() * (lambda * trace);
    SplitEnergies {
        tensile_energy: 0.5 * lambda * up * up + mu * opened.norm_squared(),
        compressive_energy: 0.5 * lambda * down * down + mu * closed.norm_squared(),
        degraded_stress: stress(positive, up),
        intact_stress: stress(strain - positive, down),
    }
}

/// Expansion and the deviator, which in plane strain has a part across the plane.
fn volumetric<const D: usize>(lame: Lame, strain: &Matrix<D>) -> SplitEnergies<D> {
    let bulk = lame.lambda + 2.0 / 3.0 * lame.mu;
    let trace = strain.trace();
    let deviator = strain - Matrix::identity() * (trace / 3.0);
    let shape = strain.norm_squared() - trace * trace / 3.0;
    let (up, down) = (trace.max(0.0), trace.min(0.0));
    SplitEnergies {
        tensile_energy: 0.5 * bulk * up * up + lame.mu * shape,
        compressive_energy: 0.5 * bulk * down * down,
        degraded_stress: Matrix::identity() * (bulk * up) + deviator * (2.0 * lame.mu),
        intact_stress: Matrix::identity() * (bulk * down),
    }
}
