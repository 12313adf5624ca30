//! Mirror images of the cloud across its boundary planes.
//!
//! An image refers back to its real point. Along one axis it is numbered by `m`: 0 is the point
//! itself, ±1 its reflections in the two planes, ±2 the reflections of those, and so on; the place
//! of image `m` is x + mL for even `m` and −x + lower + upper + mL for odd `m`.

use super::{Domain, GeometryError, Vector};

/// One element of the reflection group, with its affine map of positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Image<const D: usize> {
    /// Image number per axis.
    pub order: [i32; D],
    scale: Vector<D>,
    shift: Vector<D>,
}

impl<const D: usize> Image<D> {
    fn new(order: [i32; D], domain: &Domain<D>) -> Self {
        let (mut scale, mut shift) = (Vector::repeat(1.0), Vector::zeros());
        for axis in 0..D {
            let (low, high) = (domain.lower[axis], domain.upper[axis]);
            let period = f64::from(order[axis]) * (high - low);
            if order[axis] % 2 == 0 {
                shift[axis] = period;
            } else {
                scale[axis] = -1.0;
                shift[axis] = low + high + period;
            }
        }
        Image {
            order,
            scale,
            shift,
        }
    }

    /// Place of this image of a point at `x`, in metres.
    #[inline]
    pub fn place(&self, x: &Vector<D>) -> Vector<D> {
        x.component_mul(&self.scale) + self.shift
    }

    /// Position whose image is at `y`, in metres.
    pub fn inverse(&self, y: &Vector<D>) -> Vector<D> {
        (y - self.shift).component_mul(&self.scale)
    }

    /// −1 where the image is turned round along an axis, else +1.
    pub fn parity(&self, axis: usize) -> f64 {
        self.scale[axis]
    }

    /// This image of a vector.
    pub fn reflect(&self, vector: &Vector<D>) -> Vector<D> {
        vector.component_mul(&self.scale)
    }
}

/// All images that families can reach; number 0 is the identity.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageTable<const D: usize> {
    images: Vec<Image<D>>,
}

/// Families store image numbers in eight bits.
const MAX_IMAGES: usize = 256;
/// Largest supported ratio of horizon to thickness: 2 × 2 + 1 images along each of three axes.
const MAX_ORDER: usize = 2;

impl<const D: usize> ImageTable<D> {
    /// Table with images out to `reach` metres beyond the sides of `domain`.
    ///
    /// # Errors
    /// [`GeometryError::TooManyImages`] if the reach is too many times the domain's thickness.
    pub fn new(domain: &Domain<D>, reach: f64) -> Result<Self, GeometryError> {
        let mut orders = vec![[0; D]];
        if domain.planes {
            for axis in 0..D {
                let thickness = domain.size()[axis];
                let most = (reach / thickness).ceil().max(1.0);
                // A thin strip may need more images along its one thin axis than three axes could.
                let limit = if D == 2 { 7 } else { MAX_ORDER };
                if most > limit as f64 {
                    return Err(GeometryError::TooManyImages {
                        horizon: reach,
                        thickness,
                        axis,
                        limit,
                    });
                }
                let most = most as i32;
                orders = (-most..=most)
                    .flat_map(|m| orders.iter().map(move |&order| with(order, axis, m)))
                    .collect();
            }
        }
        orders.sort_by_key(|order| order.iter().map(|m| m.abs()).sum::<i32>());
        debug_assert!(orders.len() <= MAX_IMAGES);
        Ok(ImageTable {
            images: orders.into_iter().map(|o| Image::new(o, domain)).collect(),
        })
    }

    /// Number of images, the identity included.
    pub fn len(&self) -> usize {
        self.images.len()
    }

    /// Never true: the identity is always there.
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// The image with the given number.
    #[inline]
    pub fn get(&self, number: u8) -> &Image<D> {
        &self.images[usize::from(number)]
    }

    /// All images in order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &Image<D>> {
        self.images.iter()
    }
}

fn with<const D: usize>(mut order: [i32; D], axis: usize, m: i32) -> [i32; D] {
    order[axis] = m;
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_square() -> Domain<2> {
        Domain {
            lower: Vector::zeros(),
            upper: Vector::repeat(1.0),
            planes: true,
        }
    }

    #[test]
    fn images_are_reflections_and_translations_of_the_square() {
        let table = ImageTable::new(&unit_square(), 0.3).unwrap();
        assert_eq!(table.len(), 9);
        let x = Vector::<2>::new(0.1, 0.4);
        for image in table.iter() {
            let y = image.place(&x);
            for axis in 0..2 {
                let expected = match image.order[axis] {
                    -1 => -x[axis],
                    1 => 2.0 - x[axis],
                    _ => x[axis],
                };
                assert!((y[axis] - expected).abs() < 1e-15);
            }
        }
        assert_eq!(table.get(0).order, [0, 0]);
    }

    #[test]
    fn a_thin_strip_has_images_of_images_and_a_much_too_thin_one_is_refused() {
        let mut domain = unit_square();
        domain.upper[1] = 0.1;
        let table = ImageTable::new(&domain, 0.25).unwrap();
        assert!(table.iter().any(|image| image.order == [0, 3]));
        domain.upper[1] = 0.01;
        let error = ImageTable::new(&domain, 0.25).unwrap_err();
        assert!(matches!(
            error,
            GeometryError::TooManyImages { axis: 1, .. }
        ));
    }

    #[test]
    fn a_cloud_without_planes_has_only_itself() {
        let domain = Domain {
            planes: false,
            ..unit_square()
        };
        assert_eq!(ImageTable::new(&domain, 0.3).unwrap().len(), 1);
    }
}
