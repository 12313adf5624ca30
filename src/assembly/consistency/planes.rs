//! What the planes of a cloud do to the components of the corrected gradient.

use crate::geometry::Side;
use crate::operators::{MirrorContinuation, Neighbourhood, Parity};

/// What the planes of a cloud do to the field whose gradient is corrected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Planes {
    /// Sides beyond which families see no images.
    pub one_sided: Vec<bool>,
    /// Sides across which every component is odd.
    pub clamped: Vec<bool>,
}

impl Planes {
    /// Planes without clamped sides.
    pub(crate) fn natural(one_sided: &[bool]) -> Self {
        Planes {
            one_sided: one_sided.to_vec(),
            clamped: vec![false; one_sided.len()],
        }
    }

    /// Planes of a vector field whose components have the given continuations.
    pub(crate) fn of<const D: usize>(components: &[MirrorContinuation<D>]) -> Self {
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
    pub(super) fn parity(&self, axis: usize, side: Side) -> Parity {
        if self.one_sided[side.index()] {
            return Parity::OneSided;
        }
        match side.axis == axis || self.clamped[side.index()] {
            true => Parity::Odd,
            false => Parity::Even,
        }
    }
}

/// Continuation of the component along `axis`.
pub(crate) fn natural_extension<const D: usize>(
    around: &Neighbourhood<D>,
    axis: usize,
    planes: &Planes,
) -> MirrorContinuation<D> {
    let parity: Vec<Parity> = Side::all(D).map(|side| planes.parity(axis, side)).collect();
    let places: Vec<f64> = Side::all(D)
        .map(|side| around.cloud.domain.plane(side))
        .collect();
    MirrorContinuation::new(&around.families.images, &parity, &places)
}
