//! Where theory puts the borders of stability: Fourier factors of the modes of a lattice.

use nalgebra::{DMatrix, DVector};

use crate::geometry::Influence;

/// A wave on the lattice as the operators see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mode {
    /// Eigenvalue of −∇² times Δx².
    pub diffusion: f64,
    /// Volume change under pressure over that of the continuum, 1/M: 1 for long waves, 0 for the
    /// chequerboard, which the gradient does not see.
    pub softness: f64,
}

/// What the modes depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lattice {
    /// 2 or 3.
    pub dimension: usize,
    /// Horizon over spacing.
    pub ratio: f64,
    /// How neighbours are weighed.
    pub influence: Influence,
    /// λ/μ of the solid.
    pub stiffness: f64,
    /// Whether flow goes between cells that touch (`flow.operator = "path"`) instead of along bonds.
    pub path: bool,
}

/// A bond: its direction in spacings, and its weight.
type Bond = (Vec<f64>, f64);

/// Waves per half turn and direction.
const WAVES: usize = 12;

impl Lattice {
    /// All waves that fit `WAVES` times into the lattice, the constant left out.
    ///
    /// Diffusion: the bond form (2d/m) Σ ω (1 − cos k·ξ) with m = Σ ω |ξ|², or the path form Σ c (1 − cos k·ξ)
    /// with 2/3 and 1/6 for faces and corners in the plane, 1/3 and 1/6 for faces and edges in space. Solid: Bᵀ C B with the
    /// gradient's own symbol and the hourglass term with p_hg = μ.
    pub(super) fn modes(&self) -> Vec<Mode> {
        let bonds = self.bonds();
        let steps = |axes: usize, from: i32, to: i32| -> Vec<Vec<i32>> {
            (0..axes).fold(vec![Vec::new()], |list: Vec<Vec<i32>>, _| {
                let longer = |head: &Vec<i32>| {
                    let head = head.clone();
                    (from..=to).map(move |n| [&head[..], &[n]].concat())
                };
                list.iter().flat_map(longer).collect()
            })
        };
        let unit = std::f64::consts::PI / WAVES as f64;
        let waves = steps(self.dimension, 0, WAVES as i32);
        let numbers = waves.iter().filter(|wave| wave.iter().any(|k| *k != 0));
        numbers
            .map(|wave| {
                let wave: Vec<f64> = wave.iter().map(|k| f64::from(*k) * unit).collect();
                self.mode(&bonds, &wave)
            })
            .collect()
    }

    fn bonds(&self) -> Vec<Bond> {
        let reach = self.ratio.floor() as i32;
        let line: Vec<f64> = (-reach..=reach).map(f64::from).collect();
        let all = (0..self.dimension).fold(vec![Vec::new()], |list: Vec<Vec<f64>>, _| {
            let longer = |head: &Vec<f64>| {
                let head = head.clone();
                line.clone()
                    .into_iter()
                    .map(move |n| [&head[..], &[n]].concat())
            };
            list.iter().flat_map(longer).collect()
        });
        let length = |bond: &Vec<f64>| bond.iter().map(|n| n * n).sum::<f64>().sqrt();
        let seen = all.into_iter().map(|bond| (length(&bond), bond));
        seen.filter(|(length, _)| *length > 0.0 && *length <= self.ratio * (1.0 + 1e-6))
            .map(|(length, bond)| (bond, self.influence.weight(length, self.ratio)))
            .collect()
    }

    fn mode(&self, bonds: &[Bond], wave: &[f64]) -> Mode {
        let axes = self.dimension;
        let phase = |bond: &[f64]| bond.iter().zip(wave).map(|(n, k)| n * k).sum::<f64>();
        let moment: f64 = bonds
            .iter()
            .map(|(bond, w)| w * bond.iter().map(|n| n * n).sum::<f64>())
            .sum();
        let shape = moment / axes as f64;
        let mut gradient = DVector::<f64>::zeros(axes);
        for (bond, weight) in bonds {
            for axis in 0..axes {
                gradient[axis] += weight * bond[axis] * phase(bond).sin() / shape;
            }
        }
        let mut diffusion = 0.0;
        let mut hourglass = 0.0;
        for (bond, weight) in bonds {
            let (sine, cosine) = phase(bond).sin_cos();
            diffusion += weight * (1.0 - cosine);
            let linear: f64 = bond.iter().zip(gradient.iter()).map(|(n, g)| n * g).sum();
            hourglass += weight * ((1.0 - cosine).powi(2) + (sine - linear).powi(2));
        }
        diffusion *= 2.0 * axes as f64 / moment;
        if self.path {
            diffusion = touching(wave);
        }
        hourglass *= 2.0 / moment;
        // All over μ; M/μ = λ/μ + 2.
        let outer = &gradient * gradient.transpose() * (self.stiffness + 1.0);
        let shear = gradient.dot(&gradient) + hourglass;
        let stiffness: DMatrix<f64> = outer + DMatrix::identity(axes, axes) * shear;
        let moved = stiffness.lu().solve(&gradient);
        let softness = moved.map_or(0.0, |u| gradient.dot(&u) * (self.stiffness + 2.0));
        Mode {
            diffusion,
            softness,
        }
    }
}

/// Eigenvalue of the path form for a wave, times Δx².
fn touching(wave: &[f64]) -> f64 {
    let face = if wave.len() == 2 {
        2.0 / 3.0
    } else {
        1.0 / 3.0
    };
    let faces = wave.iter().map(|k| 2.0 * face * (1.0 - k.cos()));
    let pairs = (0..wave.len()).flat_map(|a| (0..a).map(move |b| (wave[a], wave[b])));
    // Both bonds across either diagonal: 2 (1 − cos(a + b)) + 2 (1 − cos(a − b)).
    let edges = pairs.map(|(a, b)| 4.0 / 6.0 * (1.0 - a.cos() * b.cos()));
    faces.chain(edges).sum()
}

/// How a method goes through the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Split {
    /// Forward Euler; strain lags, with a fixed-stress term `relaxation` times α²/M.
    Explicit {
        /// Fixed-stress term over α²/M.
        relaxation: f64,
    },
    /// Backward Euler, once per step; strain lags, with a fixed-stress term `relaxation` times α²/M.
    SemiImplicit {
        /// Fixed-stress term over α²/M.
        relaxation: f64,
    },
    /// Always stable.
    Unconditional,
}

impl Split {
    /// Smallest and largest stable step at coupling strength τ = α²/(S M), as the number Δt κ/(S Δx²);
    /// both 0 if there is none, 0 and infinite if all are.
    ///
    /// A mode with d = Δt κ k²/S and softness ρ obeys, with the fixed-stress term βτ,
    /// (1 + βτ) z² − (1 + βτ + (β − ρ)τ − d) z + (β − ρ)τ = 0, hence d ≤ 2(1 + (2β − ρ)τ), where the
    /// flow is explicit. Where it is implicit, d stands with z² instead,
    /// (1 + βτ + d) z² − (1 + (2β − ρ)τ) z + (β − ρ)τ = 0, hence d ≥ 2((ρ − 2β)τ − 1): damping by the
    /// flow is all that holds a lag that alone would diverge, so that small steps are the unstable ones.
    pub(super) fn stable(self, modes: &[Mode], tau: f64) -> (f64, f64) {
        match self {
            Split::Explicit { relaxation } => {
                let largest = |mode: &Mode| {
                    let room = 2.0 * (1.0 + (2.0 * relaxation - mode.softness) * tau);
                    // Nothing is stable where the smallest step is not.
                    room.max(0.0) / mode.diffusion
                };
                (0.0, modes.iter().map(largest).fold(f64::INFINITY, f64::min))
            }
            Split::SemiImplicit { relaxation } => {
                let smallest = |mode: &Mode| {
                    let lag = 2.0 * ((mode.softness - 2.0 * relaxation) * tau - 1.0);
                    lag.max(0.0) / mode.diffusion
                };
                (
                    modes.iter().map(smallest).fold(0.0, f64::max),
                    f64::INFINITY,
                )
            }
            Split::Unconditional => (0.0, f64::INFINITY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell() -> Lattice {
        Lattice {
            dimension: 2,
            ratio: 5_f64.sqrt(),
            influence: Influence::InverseSquare,
            stiffness: 0.0,
            path: false,
        }
    }

    /// The 20-point shell has 2.24 at (π, π) with ω = 1/|ξ|²; the five-point scheme has 8. The path form has
    /// 2 · 8/3 at (π, π), where its corners are at rest, and in space as much at (π, π, 0): 8/3 by faces, 8/3 by edges.
    #[test]
    fn the_largest_eigenvalues_are_those_known() {
        let largest = |lattice: Lattice| {
            lattice
                .modes()
                .iter()
                .map(|mode| mode.diffusion)
                .fold(0.0, f64::max)
        };
        assert!((largest(shell()) - 2.24).abs() < 1e-12);
        assert!(
            (largest(Lattice {
                ratio: 1.0,
                ..shell()
            }) - 8.0)
                .abs()
                < 1e-12
        );
        let path = |dimension: usize| Lattice {
            dimension,
            path: true,
            ..shell()
        };
        assert!((largest(path(2)) - 16.0 / 3.0).abs() < 1e-12);
        assert!((largest(path(3)) - 16.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn long_waves_are_as_soft_as_the_continuum_and_the_chequerboard_is_rigid() {
        let modes = shell().modes();
        let softest = modes.iter().map(|mode| mode.softness).fold(0.0, f64::max);
        assert!((0.95..1.0 + 1e-9).contains(&softest), "{softest}");
        let last = modes.last().unwrap();
        assert!(last.softness.abs() < 1e-12, "{last:?}");
    }

    /// Borders by hand for one mode: explicit 2(S + b) with β = 1, none beyond τ = 1 with β = 0.
    #[test]
    fn borders_of_one_mode() {
        let mode = [Mode {
            diffusion: 0.5,
            softness: 1.0,
        }];
        let explicit = |relaxation, tau| Split::Explicit { relaxation }.stable(&mode, tau).1;
        assert!((explicit(1.0, 3.0) - 16.0).abs() < 1e-12);
        assert!((explicit(0.0, 0.5) - 2.0).abs() < 1e-12);
        assert!(explicit(0.0, 2.0).abs() < 1e-12);
        let implicit = |relaxation, tau| Split::SemiImplicit { relaxation }.stable(&mode, tau).0;
        assert!((implicit(0.0, 3.0) - 8.0).abs() < 1e-12);
        assert!(implicit(0.0, 0.9).abs() < 1e-12 && implicit(1.0, 100.0).abs() < 1e-12);
    }

    /// The borders are those of the roots: within the unit circle on one side, beyond it on the other.
    #[test]
    fn the_roots_of_the_lagged_split_cross_the_unit_circle_at_the_border() {
        let (softness, tau) = (0.8, 3.0);
        let largest_root = |d: f64| {
            let (a, b, c) = (1.0 + d, softness * tau - 1.0, -softness * tau);
            let root = (b * b - 4.0 * a * c).sqrt();
            (0.5 * (root - b) / a)
                .abs()
                .max((0.5 * (root + b) / a).abs())
        };
        let mode = [Mode {
            diffusion: 1.0,
            softness,
        }];
        let border = Split::SemiImplicit { relaxation: 0.0 }.stable(&mode, tau).0;
        assert!(largest_root(0.99 * border) > 1.0 && largest_root(1.01 * border) < 1.0);
    }
}
