//! The divergence-consistent gradient: corrected weights whose column sums vanish inside.
//!
//! Where the spacing varies the area vectors of the plain gradient do not vanish, so a uniform flux
//! or stress is out of balance ("ghost forces"). The weights are corrected on the same bonds,
//! (C f)_i = Σ_b ω V_j (R λ)_b (f_j − f_i), with one multiplier field λ per component from
//! A λ = t − Gᵀ V 1, A = Rᵀ D(V_i ω V_j) R the hourglass matrix. R λ is orthogonal to linear
//! functions, so G + C stays exact for them.
//!
//! Column sums are taken in the cloud continued across its planes, each component with the parity
//! of its own linear function: odd across planes normal to it, even across the others. For flow the
//! correction is then a property of the geometry alone; boundary terms of a field's parity stay what
//! they are on a lattice. For a displacement the normal derivative of each component takes that
//! component's parity, which is odd across clamped planes too.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use perifrac_solvers::{
    Coordinates, CsrView, Problem, SolveError, SolverSpec, SpecError, Symmetry, multiply,
};

use super::{Pattern, PatternError, Refill, scalar};
use crate::geometry::{Side, Vector};
use crate::operators::{
    BondForm, Extension, Gradient, Hourglass, Neighbourhood, Parity, column_sums, family_gradient,
};

/// What the correction achieved.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Consistency {
    /// Largest column sum before, relative to the face of a cell.
    pub before: f64,
    /// Largest deviation of a column sum from its target after, relative to the face of a cell.
    pub after: f64,
    /// Largest ratio of a family's correction to its plain weights; beyond about one half the
    /// corrected gradient is no longer trustworthy.
    pub ratio: f64,
}

/// Why the gradient could not be made divergence-consistent.
#[derive(Debug, thiserror::Error)]
pub enum ConsistencyError {
    /// A cloud without boundary planes has no known boundary layer.
    #[error(
        "the divergence-consistent gradient needs the boundary planes of the cloud; give \
         geometry.bounds, or set flow.gradient = \"plain\""
    )]
    NoPlanes,
    /// The multipliers could not be computed.
    #[error("the divergence-consistent gradient could not be computed: {0}")]
    Solve(#[from] SolveError),
    /// The solver is not there.
    #[error(transparent)]
    Solver(#[from] SpecError),
    /// The hourglass matrix is too large.
    #[error(transparent)]
    Pattern(#[from] PatternError),
}

/// What the planes of a cloud do to the field whose gradient is corrected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Planes {
    /// Sides beyond which families see no images.
    pub one_sided: Vec<bool>,
    /// Sides across which every component is odd.
    pub clamped: Vec<bool>,
}

impl Planes {
    /// Planes without clamped sides.
    pub fn natural(one_sided: &[bool]) -> Self {
        Planes {
            one_sided: one_sided.to_vec(),
            clamped: vec![false; one_sided.len()],
        }
    }

    /// Planes of a vector field whose components have the given continuations.
    pub fn of<const D: usize>(components: &[Extension<D>]) -> Self {
        let all = |wanted: Parity| {
            let has = |side: Side| components.iter().all(|own| own.parity(side) == wanted);
            Side::all(D).map(has).collect()
        };
        Planes {
            one_sided: all(Parity::OneSided),
            clamped: all(Parity::Odd),
        }
    }

    /// Parity of the component along `axis` at a side.
    fn parity(&self, axis: usize, side: Side) -> Parity {
        if self.one_sided[side.index()] {
            return Parity::OneSided;
        }
        match side.axis == axis || self.clamped[side.index()] {
            true => Parity::Odd,
            false => Parity::Even,
        }
    }
}

/// Corrects the plain gradient of `around`.
///
/// # Errors
/// [`ConsistencyError`] for a cloud without planes, or if a solve fails.
pub fn consistent_gradient<const D: usize>(
    around: &Arc<Neighbourhood<D>>,
    planes: &Planes,
) -> Result<(Gradient<D>, Consistency), ConsistencyError> {
    if !around.cloud.domain.planes {
        return Err(ConsistencyError::NoPlanes);
    }
    let plain = Arc::new(Gradient::plain(around));
    let form = Hourglass::new(around.clone(), plain.clone());
    let pattern = Pattern::new(&form)?;
    let mut corrected = plain.weight.clone();
    let mut quality = Consistency {
        before: 0.0,
        after: 0.0,
        ratio: 0.0,
    };
    for axis in 0..D {
        let natural = natural_extension(around, axis, planes);
        let sign = |_: usize, bond: usize| natural.sign(around.families.image(bond));
        let sums: Vec<f64> = column_sums(
            around,
            |a, b| if a == axis { plain.weight[b][a] } else { 0.0 },
            sign,
        )
        .into_iter()
        .map(|sum| sum[axis])
        .collect();
        let unseen = null_functions(around, axis, planes);
        // The area of a one-sided plane is normal to it: the other components have no layer there.
        let normal = |side: &Side| side.axis == axis && planes.one_sided[side.index()];
        let layer = boundary_layer(around, &Side::all(D).filter(normal).collect::<Vec<Side>>());
        let target = targets(&unseen, &layer, &sums);
        let rhs: Vec<f64> = target.iter().zip(&sums).map(|(t, s)| t - s).collect();
        quality.before = quality.before.max(relative(around, &rhs));
        let shift = if unseen.is_empty() {
            SHIFT
        } else {
            SINGULAR_SHIFT
        };
        let lambda = multipliers(&form, &natural, &pattern, &rhs, shift)?;
        add_correction(around, &natural, &lambda, axis, &mut corrected);
        let after = column_sums(
            around,
            |a, b| if a == axis { corrected[b][a] } else { 0.0 },
            sign,
        );
        let left: Vec<f64> = after
            .iter()
            .zip(&target)
            .map(|(s, t)| s[axis] - t)
            .collect();
        quality.after = quality.after.max(relative(around, &left));
    }
    quality.ratio = correction_ratio(around, &plain.weight, &corrected);
    Ok((Gradient { weight: corrected }, quality))
}

/// Continuation of the component along `axis`.
pub fn natural_extension<const D: usize>(
    around: &Neighbourhood<D>,
    axis: usize,
    planes: &Planes,
) -> Extension<D> {
    let parity: Vec<Parity> = Side::all(D).map(|side| planes.parity(axis, side)).collect();
    let places: Vec<f64> = Side::all(D)
        .map(|side| around.cloud.domain.plane(side))
        .collect();
    Extension::new(&around.families.images, &parity, &places)
}

/// Largest entry relative to the face of the point's cell.
fn relative<const D: usize>(around: &Neighbourhood<D>, sums: &[f64]) -> f64 {
    let face = |point: usize| around.cloud.volume[point] / around.cloud.spacing(point);
    sums.iter()
        .enumerate()
        .map(|(point, sum)| sum.abs() / face(point))
        .fold(0.0, f64::max)
}

/// Points whose column sums feel one of the `sides`, beyond which there are no images: those whose own
/// horizon, or that of a point that sees them, crosses it.
pub fn boundary_layer<const D: usize>(around: &Neighbourhood<D>, sides: &[Side]) -> Vec<bool> {
    let domain = &around.cloud.domain;
    let crosses = |point: usize| {
        sides.iter().any(|side| {
            let gap = (around.cloud.position[point][side.axis] - domain.plane(*side)).abs();
            gap < around.families.horizon[point]
        })
    };
    let crossing: Vec<bool> = (0..around.len()).map(crosses).collect();
    let feels = |point: usize| {
        let mut seen_by = around.families.dual(point);
        crossing[point] || seen_by.any(|(owner, _)| crossing[owner])
    };
    let mut layer: Vec<f64> = (0..around.len())
        .map(|point| f64::from(u8::from(feels(point))))
        .collect();
    // Across a crack a side is felt all the same: what the faces take is told apart.
    for bond in around.families.severed.iter().flatten() {
        if crossing[bond.owner as usize] {
            layer[bond.neighbour as usize] = 1.0;
        }
    }
    around.families.share.complete(&mut layer, 1);
    layer.into_iter().map(|own| own > 0.5).collect()
}

/// Column sums wanted: zero inside, the layer's own at one-sided planes, adjusted so that the
/// divergence theorem holds for the functions in `basis`, every linear one that the planes allow.
fn targets(basis: &[Vec<f64>], layer: &[bool], sums: &[f64]) -> Vec<f64> {
    let mut target: Vec<f64> = sums
        .iter()
        .zip(layer)
        .map(|(sum, layer)| if *layer { *sum } else { 0.0 })
        .collect();
    if basis.is_empty() {
        return target;
    }
    let size = basis.len();
    let weight: Vec<f64> = target.iter().map(|t| t.abs()).collect();
    let weighted = |f: &[f64], g: &[f64]| -> f64 {
        weight
            .iter()
            .zip(f)
            .zip(g)
            .map(|((w, f), g)| w * f * g)
            .sum()
    };
    let matrix = DMatrix::from_fn(size, size, |a, b| weighted(&basis[a], &basis[b]));
    let rhs = DVector::from_fn(size, |a, _| {
        basis[a]
            .iter()
            .zip(sums.iter().zip(&target))
            .map(|(f, (s, t))| f * (s - t))
            .sum()
    });
    if let Some(solution) = matrix.lu().solve(&rhs) {
        for (function, &amount) in basis.iter().zip(solution.iter()) {
            for ((t, w), f) in target.iter_mut().zip(&weight).zip(function) {
                *t += amount * w * f;
            }
        }
    }
    target
}

/// Values of the linear functions that the hourglass matrix of this component cannot see: those that
/// vanish on odd planes and do not change across even ones.
fn null_functions<const D: usize>(
    around: &Neighbourhood<D>,
    axis: usize,
    planes: &Planes,
) -> Vec<Vec<f64>> {
    let domain = &around.cloud.domain;
    let (centre, size) = ((domain.lower + domain.upper) * 0.5, domain.size());
    // Coefficients of 1 and of the coordinates from the centre, each over half the edge.
    let mut rules: Vec<Vec<f64>> = Vec::new();
    let unit = |k: usize| {
        (0..=D)
            .map(|i| f64::from(u8::from(i == k)))
            .collect::<Vec<f64>>()
    };
    for side in Side::all(D) {
        match planes.parity(axis, side) {
            Parity::OneSided => {}
            Parity::Even => rules.push(unit(1 + side.axis)),
            Parity::Odd => {
                rules.extend((0..D).filter(|&a| a != side.axis).map(|a| unit(1 + a)));
                let mut on_plane = unit(0);
                on_plane[1 + side.axis] = side.outward();
                rules.push(on_plane);
            }
        }
    }
    let normal = rules
        .iter()
        .fold(DMatrix::zeros(D + 1, D + 1), |sum, rule| {
            let rule = DVector::from_column_slice(rule);
            sum + &rule * rule.transpose()
        });
    let modes = SymmetricEigen::new(normal);
    let free = (0..=D).filter(|&k| modes.eigenvalues[k] < 1e-10);
    let value = |x: &Vector<D>, mode: usize| {
        let coefficient = modes.eigenvectors.column(mode);
        let along = |a: usize| coefficient[1 + a] * 2.0 * (x[a] - centre[a]) / size[a];
        coefficient[0] + (0..D).map(along).sum::<f64>()
    };
    free.map(|mode| {
        around
            .cloud
            .position
            .iter()
            .map(|x| value(x, mode))
            .collect()
    })
    .collect()
}

/// Shift of the diagonal against rounding errors in the factor, relative to it.
const SHIFT: f64 = 1e-13;
/// Shift where one-sided planes leave the matrix singular; the right-hand side has no share in what
/// it cannot see, so refinement removes the shift's effect.
const SINGULAR_SHIFT: f64 = 1e-9;
/// Corrections of the multipliers; each gains several digits.
const REFINEMENTS: usize = 12;

/// Factor of the shifted matrix over several processes.
const DISTRIBUTED: &str = "petsc:-ksp_type preonly -pc_type cholesky";

/// λ with A λ = rhs, by a factor of the shifted matrix and refinement with the true one.
fn multipliers<const D: usize>(
    form: &Hourglass<D>,
    natural: &Extension<D>,
    pattern: &Pattern,
    rhs: &[f64],
    shift: f64,
) -> Result<Vec<f64>, ConsistencyError> {
    let largest = rhs.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    let mut lambda = vec![0.0; rhs.len()];
    let around = form.neighbourhood();
    let face = around
        .cloud
        .volume
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    if largest <= 1e-15 * face {
        return Ok(lambda);
    }
    let mut values = vec![0.0; pattern.nonzeros()];
    let plan = Refill::new(form, natural, pattern);
    scalar::fill(form, natural, &[], pattern, &plan, &mut values);
    let mut shifted = values.clone();
    for (_, diagonal) in pattern.diagonals() {
        shifted[diagonal] *= 1.0 + shift;
    }
    let shape = (pattern.rows(), pattern.rows());
    let view = |values| CsrView::new(shape, &pattern.offsets[..], &pattern.columns[..], values);
    let coordinates = around.cloud.flat_positions();
    let share = &around.families.share;
    let name = match share.partition() {
        None => "faer-llt",
        Some(_) => DISTRIBUTED,
    };
    let mut solver = name.parse::<SolverSpec>()?.build()?;
    solver.analyse(&Problem {
        partition: share.partition(),
        coordinates: Some(Coordinates {
            dimension: D,
            values: &coordinates,
        }),
        ..Problem::new(view(&shifted), Symmetry::PositiveDefinite, 1)
    })?;
    solver.refresh(view(&shifted))?;
    let (mut residual, mut product, mut step) =
        (rhs.to_vec(), vec![0.0; rhs.len()], vec![0.0; rhs.len()]);
    for _ in 0..REFINEMENTS {
        solver.solve(view(&shifted), &residual, &mut step)?;
        lambda.iter_mut().zip(&step).for_each(|(l, s)| *l += s);
        multiply(view(&values), &lambda, &mut product);
        share.complete(&mut product, 1);
        residual
            .iter_mut()
            .zip(rhs.iter().zip(&product))
            .for_each(|(r, (b, p))| *r = b - p);
        if residual.iter().all(|r| r.abs() < 1e-15 * largest) {
            break;
        }
    }
    Ok(lambda)
}

/// Adds ω V_j (R λ)_b to one component of the weights.
fn add_correction<const D: usize>(
    around: &Neighbourhood<D>,
    natural: &Extension<D>,
    lambda: &[f64],
    axis: usize,
    weight: &mut [Vector<D>],
) {
    let families = &around.families;
    for owner in 0..around.len() {
        let difference = |b: usize| {
            natural.sign(families.image(b)) * lambda[families.neighbour(b)] - lambda[owner]
        };
        let slope = family_gradient(around, owner, difference);
        for bond in families.family(owner) {
            let residual = difference(bond) - slope.dot(&around.bond_vector(owner, bond));
            weight[bond][axis] += around.measure[bond] * residual;
        }
    }
}

fn correction_ratio<const D: usize>(
    around: &Neighbourhood<D>,
    plain: &[Vector<D>],
    corrected: &[Vector<D>],
) -> f64 {
    let norm = |weights: &mut dyn Iterator<Item = Vector<D>>| -> f64 {
        weights.map(|w| w.norm_squared()).sum::<f64>().sqrt()
    };
    (0..around.len())
        .map(|owner| {
            let family = around.families.family(owner);
            let change = norm(&mut family.clone().map(|b| corrected[b] - plain[b]));
            change / norm(&mut family.map(|b| plain[b]))
        })
        .fold(0.0, f64::max)
}
