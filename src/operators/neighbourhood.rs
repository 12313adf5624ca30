//! Bond geometry shared by all operators: influence-weighted volumes and shape tensors.

use std::sync::Arc;

use crate::geometry::{Cloud, Families, GeometryError, Influence, Matrix, Vector};
use crate::parallel;

/// Families with their weights ω V_j and shape tensors K (Eq. 56).
#[derive(Debug, Clone)]
pub struct Neighbourhood<const D: usize> {
    /// The points.
    pub cloud: Arc<Cloud<D>>,
    /// Their bonds.
    pub families: Arc<Families<D>>,
    /// ω(ξ) V_j per bond, shape `(bonds,)`.
    pub measure: Vec<f64>,
    /// Inverse shape tensor K⁻¹ per point, shape `(n,)`.
    pub inverse_shape: Vec<Matrix<D>>,
    /// m = tr K per point (below Eq. 10), shape `(n,)`.
    pub moment: Vec<f64>,
    influence: Influence,
}

/// Smallest accepted ratio of a shape tensor's determinant to that of an isotropic one.
const SINGULAR: f64 = 1e-8;

impl<const D: usize> Neighbourhood<D> {
    /// Weighs all bonds.
    ///
    /// # Errors
    /// [`GeometryError::SingularShape`] where a family does not span the space.
    pub fn new(
        cloud: Arc<Cloud<D>>,
        families: Arc<Families<D>>,
        influence: Influence,
    ) -> Result<Self, GeometryError> {
        let around = Self::of_cells(cloud, families, influence);
        let missing = |owner: &usize| {
            around.families.share.holds(*owner)
                && around.inverse_shape[*owner] == Matrix::<D>::zeros()
        };
        match (0..around.len()).find(missing) {
            None => Ok(around),
            Some(first) => Err(singular(&around.cloud, &around.families, first)),
        }
    }

    /// The same for operators that take no gradient: a family that does not span the space, as in a strip
    /// one cell wide, has a zero for K⁻¹.
    pub fn of_cells(
        cloud: Arc<Cloud<D>>,
        families: Arc<Families<D>>,
        influence: Influence,
    ) -> Self {
        let weigh = |owner: usize, bond: usize| {
            let distance = families.bond_vector(&cloud, owner, bond).norm();
            let horizon = families.horizon[owner];
            influence.weight(distance, horizon) * cloud.volume[families.neighbour(bond)]
        };
        let alike = families.alike(&cloud);
        let measure = of_bonds(&families, alike.as_deref(), weigh);
        let shape = |owner: usize| invert(&cloud, &families, owner, &measure);
        let (inverse_shape, moment) = match &alike {
            Some(alike) => {
                let all = of_first(alike, shape);
                let own = alike.iter().filter_map(|owner| all[*owner as usize]);
                own.unzip()
            }
            None => {
                let shapes: Vec<(Matrix<D>, f64)> = parallel::map(families.len(), shape);
                shapes.into_iter().unzip()
            }
        };
        Neighbourhood {
            cloud,
            families,
            measure,
            inverse_shape,
            moment,
            influence,
        }
    }

    /// ω(ξ) V_j of a bond that may be severed, which has no `measure`.
    pub fn weigh(&self, owner: usize, end: usize, xi: &Vector<D>) -> f64 {
        let horizon = self.families.horizon[owner];
        self.influence.weight(xi.norm(), horizon) * self.cloud.volume[end]
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.families.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.families.is_empty()
    }

    /// Bond vector ξ in metres.
    pub fn bond_vector(&self, owner: usize, bond: usize) -> Vector<D> {
        self.families.bond_vector(&self.cloud, owner, bond)
    }

    /// Shape tensor K = Σ ω ξ⊗ξ V_j of a point (Eq. 56), summed afresh.
    pub fn shape(&self, owner: usize) -> Matrix<D> {
        shape_tensor(&self.cloud, &self.families, owner, &self.measure)
    }

    /// Bytes held, families included, the cloud excluded.
    pub fn bytes(&self) -> usize {
        self.families.bytes() + 8 * (self.measure.len() + self.moment.len() * (1 + D * D))
    }
}

/// Values of all bonds, shape `(bonds,)`. Those of points that are like others are copied, so that they agree to the last
/// bit; computed from positions they would not, and rows of matrices would not repeat.
pub(super) fn of_bonds<const D: usize, T: Copy + Send + Sync>(
    families: &Families<D>,
    alike: Option<&[u32]>,
    value: impl Fn(usize, usize) -> T + Sync,
) -> Vec<T> {
    let value = &value;
    let family = |owner: usize| families.family(owner).map(move |bond| value(owner, bond));
    let Some(alike) = alike else {
        return parallel::gather(families.len(), |owner, all| all.extend(family(owner)));
    };
    let all = of_first(alike, |owner| family(owner).collect::<Vec<T>>());
    let mut values = Vec::with_capacity(families.bonds());
    for own in alike
        .iter()
        .filter_map(|first| all[*first as usize].as_ref())
    {
        values.extend_from_slice(own);
    }
    values
}

/// What every point that is the first of those like it has, shape `(n,)`.
fn of_first<T>(alike: &[u32], value: impl Fn(usize) -> T) -> Vec<Option<T>> {
    let own = |(point, first): (usize, &u32)| (*first as usize == point).then(|| value(point));
    alike.iter().enumerate().map(own).collect()
}

fn shape_tensor<const D: usize>(
    cloud: &Cloud<D>,
    families: &Families<D>,
    owner: usize,
    measure: &[f64],
) -> Matrix<D> {
    let mut shape = Matrix::zeros();
    for bond in families.family(owner) {
        let xi = families.bond_vector(cloud, owner, bond);
        shape += xi * xi.transpose() * measure[bond];
    }
    shape
}

/// Inverse shape tensor and moment of a point; a zero for the first if its family does not span the space.
fn invert<const D: usize>(
    cloud: &Cloud<D>,
    families: &Families<D>,
    owner: usize,
    measure: &[f64],
) -> (Matrix<D>, f64) {
    if !families.share.holds(owner) {
        // An infinite moment leaves no stiffness to a family that is not there.
        return (Matrix::zeros(), f64::INFINITY);
    }
    let shape = shape_tensor(cloud, families, owner, measure);
    let moment = shape.trace();
    // Scaled to the isotropic tensor the determinant is 1, and falls to 0 with the thinnest axis.
    let scaled = shape * (D as f64 / moment);
    let inverse = determinant(&scaled)
        .filter(|&d| d > SINGULAR)
        .and_then(|_| shape.try_inverse());
    (inverse.unwrap_or_else(Matrix::zeros), moment)
}

fn singular<const D: usize>(
    cloud: &Cloud<D>,
    families: &Families<D>,
    owner: usize,
) -> GeometryError {
    GeometryError::SingularShape {
        point: owner,
        position: cloud.position[owner].iter().copied().collect(),
        found: families.family(owner).len(),
        horizon: families.horizon[owner],
    }
}

/// Determinant by elimination; `None` when it is not a number.
fn determinant<const D: usize>(matrix: &Matrix<D>) -> Option<f64> {
    let mut a = *matrix;
    let mut product = 1.0;
    for k in 0..D {
        product *= a[(k, k)];
        for row in k + 1..D {
            let factor = a[(row, k)] / a[(k, k)];
            for column in k..D {
                a[(row, column)] -= factor * a[(k, column)];
            }
        }
    }
    product.is_finite().then_some(product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::lattice;
    use crate::geometry::{Horizon, horizons};

    #[test]
    fn fifteen_neighbours_are_the_full_twenty_point_shell_and_isotropic() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::repeat(1.0), [10, 10]).unwrap();
        let horizon = horizons(&cloud, Horizon::Neighbours(15)).unwrap();
        assert!((horizon[0] - 5_f64.sqrt() * 0.1).abs() < 1e-6);
        let families = Families::search(&cloud, horizon).unwrap();
        assert!(
            (0..100).all(|i| families.family(i).len() == 20),
            "mirrored families are all full"
        );
        let cloud = Arc::new(cloud);
        let around = Neighbourhood::new(cloud, Arc::new(families), Influence::default()).unwrap();
        // Σ ω ξ⊗ξ V = 20 V / 2 I with ω = 1/|ξ|².
        let expected = Matrix::<2>::identity() * (10.0 * 0.01);
        assert!((0..100).all(|i| (around.shape(i) - expected).amax() < 1e-15));
    }

    #[test]
    fn of_points_on_a_line_the_first_is_named_as_singular() {
        let cloud = lattice(
            Vector::<2>::zeros(),
            Vector::<2>::new(1.0, 1e-4),
            [10_000, 1],
        );
        let mut cloud = cloud.unwrap();
        cloud.domain.planes = false;
        let horizon = horizons(&cloud, Horizon::Radius(2.5e-4)).unwrap();
        let families = Families::search(&cloud, horizon).unwrap();
        let result = Neighbourhood::new(Arc::new(cloud), Arc::new(families), Influence::default());
        assert!(matches!(
            result,
            Err(GeometryError::SingularShape {
                point: 0,
                found: 2,
                ..
            })
        ));
    }
}
