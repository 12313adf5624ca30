//! How a scalar field continues across the boundary planes: parities of mirror images.

use crate::geometry::{ImageTable, Side, Vector};

/// What a field does at a plane side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// No flux or symmetry: the image has the value of the point.
    Even,
    /// Prescribed value w: the image has the value 2w − value.
    Odd,
    /// Natural boundary: there are no images beyond the side.
    OneSided,
}

/// Continuation of one field to every image: value of image = sign · value + Σ wall · wall values.
#[derive(Debug, Clone, PartialEq)]
pub struct MirrorContinuation<const D: usize> {
    parity: Vec<Parity>,
    sign: Vec<f64>,
    wall: Vec<Vec<f64>>,
    kept: Vec<bool>,
    walks: Vec<Vec<Vec<Side>>>,
    planes: Vec<f64>,
}

impl<const D: usize> MirrorContinuation<D> {
    /// Continuation for the given parity per side (in the order of [`Side::index`]); `planes` are
    /// the coordinates of the sides in metres.
    pub fn new(images: &ImageTable<D>, parity: &[Parity], planes: &[f64]) -> Self {
        let mut extension = MirrorContinuation {
            parity: parity.to_vec(),
            sign: Vec::new(),
            wall: Vec::new(),
            kept: Vec::new(),
            walks: images.iter().map(|image| walks(&image.order)).collect(),
            planes: planes.to_vec(),
        };
        for image in 0..images.len() {
            let walk = &extension.walks[image][0];
            let odd = walk
                .iter()
                .filter(|side| parity[side.index()] == Parity::Odd)
                .count();
            extension
                .kept
                .push(walk.iter().all(|s| parity[s.index()] != Parity::OneSided));
            extension.sign.push(if odd % 2 == 0 { 1.0 } else { -1.0 });
            let unit =
                |chosen: usize| move |side: Side, _: &Vector<D>| f64::from(side.index() == chosen);
            let origin = Vector::zeros();
            let wall = (0..2 * D)
                .map(|s| extension.offset(image as u8, &origin, unit(s)))
                .collect();
            extension.wall.push(wall);
        }
        extension
    }

    /// Parity at a side.
    pub fn parity(&self, side: Side) -> Parity {
        self.parity[side.index()]
    }

    /// Whether bonds to this image exist for the field.
    pub fn keeps(&self, image: u8) -> bool {
        self.kept[usize::from(image)]
    }

    /// +1 or −1.
    #[inline]
    pub fn sign(&self, image: u8) -> f64 {
        self.sign[usize::from(image)]
    }

    /// Part of the image's value that the wall values (one per side) contribute.
    pub fn wall_offset(&self, image: u8, walls: &[f64]) -> f64 {
        if image == 0 {
            return 0.0;
        }
        self.wall[usize::from(image)]
            .iter()
            .zip(walls)
            .map(|(c, w)| c * w)
            .sum()
    }

    /// Side through which a bond to this image leaves, if the image is odd.
    ///
    /// A bond whose end changes sign carries flux out of the domain; where it crosses several
    /// prescribed sides the last one crossed counts.
    pub fn outlet(&self, image: u8) -> Option<Side> {
        let odd = |side: &&Side| self.parity[side.index()] == Parity::Odd;
        let walk = self.walks[usize::from(image)].first()?;
        (self.sign(image) < 0.0)
            .then(|| walk.iter().rev().find(odd).copied())
            .flatten()
    }

    /// Constant part of the image's value where the wall values vary along the walls.
    ///
    /// `wall(side, x)` is the prescribed value at `x` on the side. Reflections along different axes
    /// do not commute when their walls disagree at the corner, so all orders are averaged.
    pub fn offset(&self, image: u8, x: &Vector<D>, wall: impl Fn(Side, &Vector<D>) -> f64) -> f64 {
        let walks = &self.walks[usize::from(image)];
        let total: f64 = walks.iter().map(|walk| self.walk(walk, x, &wall).0).sum();
        total / walks.len() as f64
    }

    /// Where a linear field continues to: the coordinates of the image along axes with prescribed
    /// values, those of the point itself along mirrored ones.
    pub fn foot(&self, image: u8, x: &Vector<D>) -> Vector<D> {
        self.walk(&self.walks[usize::from(image)][0], x, &|_, _| 0.0)
            .1
    }

    fn walk(
        &self,
        walk: &[Side],
        x: &Vector<D>,
        wall: &impl Fn(Side, &Vector<D>) -> f64,
    ) -> (f64, Vector<D>) {
        let (mut value, mut at) = (0.0, *x);
        for &side in walk
            .iter()
            .filter(|side| self.parity[side.index()] == Parity::Odd)
        {
            let plane = self.planes[side.index()];
            let mut on_wall = at;
            on_wall[side.axis] = plane;
            value = 2.0 * wall(side, &on_wall) - value;
            at[side.axis] = 2.0 * plane - at[side.axis];
        }
        (value, at)
    }
}

/// The reflections that lead from a point to its image, innermost first, in every order of axes.
fn walks<const D: usize>(order: &[i32; D]) -> Vec<Vec<Side>> {
    let along: Vec<Vec<Side>> = (0..D).map(|axis| reflections(axis, order[axis])).collect();
    permutations(D)
        .into_iter()
        .map(|axes| {
            axes.into_iter()
                .flat_map(|axis| along[axis].clone())
                .collect()
        })
        .collect()
}

/// Image m lies behind the upper plane for m > 0 and is the reflection of image 1 − m there;
/// likewise −1 − m and the lower plane for m < 0.
fn reflections(axis: usize, mut m: i32) -> Vec<Side> {
    let mut sides = Vec::new();
    while m != 0 {
        let upper = m > 0;
        sides.push(Side { axis, upper });
        m = if upper { 1 - m } else { -1 - m };
    }
    sides.reverse();
    sides
}

fn permutations(count: usize) -> Vec<Vec<usize>> {
    match count {
        2 => vec![vec![0, 1], vec![1, 0]],
        _ => vec![
            vec![0, 1, 2],
            vec![0, 2, 1],
            vec![1, 0, 2],
            vec![1, 2, 0],
            vec![2, 0, 1],
            vec![2, 1, 0],
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Domain;

    fn strip() -> (Domain<2>, ImageTable<2>) {
        let domain = Domain {
            lower: Vector::zeros(),
            upper: Vector::<2>::new(1.0, 0.2),
            planes: true,
        };
        let images = ImageTable::new(&domain, 0.5).unwrap();
        (domain, images)
    }

    /// A linear field that the sides allow continues linearly to every image.
    #[test]
    fn a_linear_field_with_its_own_wall_values_continues_linearly() {
        let (domain, images) = strip();
        let parity = [Parity::Odd, Parity::Odd, Parity::Even, Parity::Even];
        let extension = MirrorContinuation::new(&images, &parity, &[0.0, 1.0, 0.0, 0.2]);
        let field = |x: &Vector<2>| 3.0 - 2.0 * x[0];
        let x = Vector::<2>::new(0.15, 0.07);
        let walls = [3.0, 1.0, 0.0, 0.0];
        for (number, image) in images.iter().enumerate() {
            let number = number as u8;
            let value = extension.sign(number) * field(&x) + extension.wall_offset(number, &walls);
            assert!((value - field(&image.place(&x))).abs() < 1e-14);
        }
        assert!(domain.planes);
    }

    #[test]
    fn wall_values_that_vary_along_the_wall_are_taken_at_the_foot() {
        let (_, images) = strip();
        let extension = MirrorContinuation::new(&images, &[Parity::Odd; 4], &[0.0, 1.0, 0.0, 0.2]);
        let field = |x: &Vector<2>| 1.0 + 2.0 * x[0] - 3.0 * x[1];
        let x = Vector::<2>::new(0.9, 0.07);
        for (number, image) in images.iter().enumerate() {
            let number = number as u8;
            let offset = extension.offset(number, &x, |_, on_wall| field(on_wall));
            let value = extension.sign(number) * field(&x) + offset;
            assert!((value - field(&image.place(&x))).abs() < 1e-13);
            assert!((extension.foot(number, &x) - image.place(&x)).amax() < 1e-14);
        }
    }

    #[test]
    fn one_sided_walls_drop_their_images_and_outlets_name_the_prescribed_side() {
        let (_, images) = strip();
        let parity = [Parity::Odd, Parity::OneSided, Parity::Even, Parity::Even];
        let extension = MirrorContinuation::new(&images, &parity, &[0.0, 1.0, 0.0, 0.2]);
        for (number, image) in images.iter().enumerate() {
            let number = number as u8;
            assert_eq!(
                extension.keeps(number),
                image.order[0] <= 0 && image.order[0] >= -1
            );
            if image.order[0] == -1 {
                assert_eq!(extension.outlet(number).map(Side::name), Some("left"));
            }
        }
    }
}
