//! A broken point is rock cut by a plane: only the traction there is lost, and the fluid adds to it.
//!
//! With σ = C₀:ε + σ⁰, the normal n, M = λ + 2μ and N = C₀:(n⊗n) = λI + 2μ n⊗n, the traction that a
//! crack would have to carry is q = σn + z n, z being what the fluid adds; q_n = n·q, q_t = q − q_n n. What it can
//! carry is a cone of friction, |q_t| ≤ −f q_n; r is what sticks out of it in the norm of the energy:
//!
//!   Y = r_n²/2M + |r_t|²/2μ + e_hg,  G = r_n N/M + 2 sym(n⊗r_t),  σ̄ = σ − (1 − g) G,
//!
//! e_hg being the hourglass energy. Faces that are apart carry nothing, r = q; those that slide carry what friction
//! holds and open by f times what they slide; those that stick respond like rock, and nothing drives damage there.
//! The energy ½ ε:C₀:ε + σ⁰:ε + e_hg − (1 − g) Y + c s² has a derivative everywhere. The crack holds (1 − g) r_n/M
//! of fluid per volume. Until the normal is settled it is the axis of the largest principal stress, so that q_t = 0.
//! Compression never breaks.

use super::tangent::BOUND;
use super::{DamageLaw, PointResponse, PointState, Tangent, TangentKind};
use crate::geometry::{Matrix, Vector};
use crate::material::Lame;
use crate::material::eigen::eigen;

/// Share of the shear stiffness that a turning normal may give up in the exact tangent: none is known where two
/// principal stresses are equal. `two-cracks/smoke` takes 749, 645, 372 and 387 passes with 1, 2, 10 and 1e3.
const FASTEST: f64 = 1e3;

/// The plane of a crack and what it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrackPlane<const D: usize> {
    /// Unit normal n.
    pub normal: Vector<D>,
    /// Whether the faces do not stick.
    pub open: bool,
    /// r_n/M: opening per volume of what is broken all through.
    pub strain: f64,
    /// (1 − g) r_n/M, opening per volume.
    pub opening: f64,
    /// Opening that the fluid's pressure brings at fixed damage, 1/Pa.
    pub yielding: f64,
    /// Opening that strain brings at fixed damage.
    pub parting: Matrix<D>,
    /// G, Pa.
    pub released: Matrix<D>,
}

impl<const D: usize> Default for CrackPlane<D> {
    fn default() -> Self {
        CrackPlane {
            normal: Vector::zeros(),
            open: false,
            strain: 0.0,
            opening: 0.0,
            yielding: 0.0,
            parting: Matrix::zeros(),
            released: Matrix::zeros(),
        }
    }
}

/// What the faces of a crack do.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Faces {
    Stick,
    /// Sliding by so much more than friction holds, Pa.
    Slide(f64),
    Apart,
}

/// A plane with the traction on it.
struct Cut<const D: usize> {
    /// Axes, the normal first; the direction of sliding second where faces slide.
    basis: Matrix<D>,
    /// Principal stresses in that order less q_n's; none where the normal is settled.
    gaps: Option<Vector<D>>,
    /// σ, Pa.
    stress: Matrix<D>,
    faces: Faces,
    /// r_n, Pa.
    pull: f64,
    /// r_t, Pa.
    shear: Vector<D>,
    /// |q_t|, Pa.
    sliding: f64,
}

impl<const D: usize> Cut<D> {
    fn of(point: &PointState<D>, friction: f64, strain: &Matrix<D>) -> Self {
        let stress = point.lame.stress(strain) + point.prestress;
        let Some(normal) = point.normal else {
            return Self::principal(stress, point.fluid);
        };
        let traction = stress * normal + normal * point.fluid;
        let pull = traction.dot(&normal);
        let tangential = traction - normal * pull;
        let sliding = tangential.norm();
        let direction = tangential.try_normalize(0.0).unwrap_or_else(Vector::zeros);
        let (modulus, mu) = (point.lame.lambda + 2.0 * point.lame.mu, point.lame.mu);
        let excess = sliding + friction * pull;
        let faces = if mu * pull > friction * modulus * sliding {
            Faces::Apart
        } else if excess > 0.0 {
            Faces::Slide(excess)
        } else {
            Faces::Stick
        };
        let share = excess / (mu + friction * friction * modulus);
        let (pull, shear) = match faces {
            Faces::Stick => (0.0, Vector::zeros()),
            Faces::Slide(_) => (share * friction * modulus, direction * (share * mu)),
            Faces::Apart => (pull, tangential),
        };
        Cut {
            basis: basis(&normal, &direction),
            gaps: None,
            stress,
            faces,
            pull,
            shear,
            sliding,
        }
    }

    /// The plane across the largest principal stress.
    fn principal(stress: Matrix<D>, fluid: f64) -> Self {
        let (values, axes) = eigen(&stress);
        let first = values.imax();
        let mut basis = axes;
        basis.swap_columns(0, first);
        let mut ordered = values;
        ordered.swap_rows(0, first);
        let pull = ordered[0] + fluid;
        Cut {
            basis,
            gaps: Some(ordered.map(|value| ordered[0] - value)),
            stress,
            faces: if pull > 0.0 {
                Faces::Apart
            } else {
                Faces::Stick
            },
            pull: pull.max(0.0),
            shear: Vector::zeros(),
            sliding: 0.0,
        }
    }

    /// Opening that the fluid brings, 1/Pa, and that strain brings, where nothing of the stiffness is left.
    fn yielding(&self, lame: Lame, friction: f64) -> (f64, Matrix<D>) {
        let modulus = lame.lambda + 2.0 * lame.mu;
        match self.faces {
            Faces::Stick => (0.0, Matrix::zeros()),
            Faces::Apart => (modulus.recip(), across(lame, &self.normal()) / modulus),
            Faces::Slide(_) => {
                let share = friction / (lame.mu + friction * friction * modulus);
                (share * friction, self.slip(lame, friction) * share)
            }
        }
    }

    /// Derivative of what sticks out of the cone by the strain, f N + 2μ sym(n⊗t), Pa.
    fn slip(&self, lame: Lame, friction: f64) -> Matrix<D> {
        let (normal, along) = (self.normal(), self.basis.column(1));
        let sheared = normal * along.transpose() * lame.mu;
        across(lame, &normal) * friction + sheared + sheared.transpose()
    }

    fn normal(&self) -> Vector<D> {
        self.basis.column(0).into_owned()
    }

    /// Energy without hourglass, J/m³.
    fn energy(&self, lame: Lame) -> f64 {
        let modulus = lame.lambda + 2.0 * lame.mu;
        0.5 * (self.pull * self.pull / modulus + self.shear.norm_squared() / lame.mu)
    }

    /// G, Pa.
    fn released(&self, lame: Lame) -> Matrix<D> {
        let normal = self.normal();
        let sheared = normal * self.shear.transpose();
        across(lame, &normal) * (self.pull / (lame.lambda + 2.0 * lame.mu))
            + sheared
            + sheared.transpose()
    }
}

/// N = C₀:(n⊗n), Pa.
pub(crate) fn across<const D: usize>(lame: Lame, normal: &Vector<D>) -> Matrix<D> {
    Matrix::identity() * lame.lambda + normal * normal.transpose() * (2.0 * lame.mu)
}

/// Orthonormal axes, the given unit normal first and then the direction of sliding, if there is one.
fn basis<const D: usize>(normal: &Vector<D>, direction: &Vector<D>) -> Matrix<D> {
    // Eigenvectors of a matrix that orders them: the normal, the direction, and what is left.
    let ordering = normal * normal.transpose() * 2.0 + direction * direction.transpose();
    let (mut values, mut basis) = eigen(&ordering);
    for (column, known) in [normal, direction].into_iter().enumerate() {
        let rest = (column..D).max_by(|a, b| values[*a].total_cmp(&values[*b]));
        let chosen = rest.unwrap_or(column);
        basis.swap_columns(column, chosen);
        values.swap_rows(column, chosen);
        if known.norm_squared() > 0.0 {
            basis.set_column(column, known);
        }
    }
    basis
}

impl DamageLaw {
    pub(super) fn cut_response<const D: usize>(
        &self,
        point: &PointState<D>,
        strain: &Matrix<D>,
        hourglass_energy: f64,
    ) -> PointResponse<D> {
        let lame = point.lame;
        let cut = Cut::of(point, self.friction, strain);
        let open = cut.faces != Faces::Stick;
        let driving = match open {
            true => cut.energy(lame) + hourglass_energy,
            false => 0.0,
        };
        let damage = self.damage(point.history.max(driving), point.toughness);
        let lost = 1.0 - self.degradation(damage);
        let elastic = 0.5 * lame.stress(strain).dot(strain) + point.prestress.dot(strain);
        let released = cut.released(lame);
        let (yielding, parting) = cut.yielding(lame, self.friction);
        let opened = cut.pull / (lame.lambda + 2.0 * lame.mu);
        let kept = point.toughness * damage * damage - lost * (cut.energy(lame) + hourglass_energy);
        PointResponse {
            stress: cut.stress - released * lost,
            driving,
            damage,
            // Held or not by the faces: a jump where they meet would leave forces without a balance.
            hourglass: 1.0 - lost,
            energy: elastic + hourglass_energy + kept,
            plane: CrackPlane {
                normal: cut.normal(),
                open,
                strain: opened,
                opening: lost * opened,
                yielding: lost * yielding,
                parting: parting * lost,
                released,
            },
        }
    }

    /// Tangent of a point whose response to `strain` drove `driving`.
    pub(super) fn cut_tangent<const D: usize>(
        &self,
        point: &PointState<D>,
        driving: f64,
        strain: &Matrix<D>,
        softening: TangentKind,
    ) -> Tangent<D> {
        let lame = point.lame;
        let cut = Cut::of(point, self.friction, strain);
        let most = point.history.max(driving);
        let left = self.degradation(self.damage(most, point.toughness));
        let mut tangent = cut.tangent(lame, self.friction, 1.0 - left, softening);
        let drives = cut.faces != Faces::Stick && driving > point.history;
        if drives && softening != TangentKind::Secant {
            let exact = self.softening(driving, point.toughness);
            let bound = BOUND * left / (2.0 * driving).max(f64::MIN_POSITIVE);
            tangent.direction = cut.released(lame);
            tangent.softening = match softening {
                TangentKind::Bounded => -exact.min(bound),
                _ => -exact,
            };
        }
        tangent
    }
}

impl<const D: usize> Cut<D> {
    /// Tangent at fixed damage with the share `lost` of the stiffness gone.
    fn tangent(&self, lame: Lame, friction: f64, lost: f64, kind: TangentKind) -> Tangent<D> {
        let mut tangent = Tangent::elastic(lame);
        let modulus = lame.lambda + 2.0 * lame.mu;
        tangent.basis = self.basis;
        let mut weaken = |axis: usize, share: f64| {
            let left = 2.0 * lame.mu * (1.0 - lost * share);
            tangent.shear[(0, axis)] = left;
            tangent.shear[(axis, 0)] = left;
        };
        match self.faces {
            Faces::Stick => {}
            Faces::Apart => {
                (1..D).for_each(|axis| weaken(axis, self.turning(lame, axis, kind)));
                tangent.release = -lost / modulus;
                tangent.cut = across(lame, &self.normal());
            }
            Faces::Slide(excess) => {
                let held = lame.mu + friction * friction * modulus;
                // What slides may turn within the plane.
                let turn = lame.mu / held * excess / self.sliding.max(f64::MIN_POSITIVE);
                (2..D).for_each(|axis| weaken(axis, turn));
                tangent.release = -lost / held;
                tangent.cut = self.slip(lame, friction);
            }
        }
        tangent
    }

    /// Share of the shear stiffness along an axis that faces apart give up: all where the normal is settled, else
    /// as much as the normal turns with the stress. More than all is not positive, and for the exact tangent only.
    fn turning(&self, lame: Lame, axis: usize, kind: TangentKind) -> f64 {
        let Some(gaps) = &self.gaps else { return 1.0 };
        let turning = 2.0 * lame.mu * self.pull / (lame.lambda + 2.0 * lame.mu);
        let most = match kind {
            TangentKind::Consistent => FASTEST,
            TangentKind::Secant | TangentKind::Bounded => 1.0,
        };
        (turning / gaps[axis].max(f64::MIN_POSITIVE)).min(most)
    }
}
