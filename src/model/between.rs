//! Displacement between points.

use super::SolidModel;
use crate::geometry::{Matrix, Place, Stencil, Term, Vector, sources};
use crate::operators::point_value;

impl<const D: usize> SolidModel<D> {
    /// Displacement at places, m: the points around each, continued along their slopes and blended; images
    /// as the sides have it. Linear displacements are exact.
    pub fn displacements_at(
        &self,
        displacement: &[f64],
        walls: &[f64],
        places: &[Stencil<D>],
    ) -> Vec<Vector<D>> {
        let points = sources(places);
        let slope = |point: &usize| {
            let difference = |bond| self.difference(displacement, walls, *point, bond);
            self.elastic.gradient_of(*point, difference)
        };
        let slopes: Vec<Matrix<D>> = points.iter().map(slope).collect();
        let blend = |place: &Stencil<D>| {
            let kept = |term: &&Term<D>| self.elastic.extension[0].keeps(term.image);
            let (mut sum, mut all) = (Vector::zeros(), 0.0);
            for term in place.terms.iter().filter(kept) {
                let slope = points
                    .binary_search(&term.point)
                    .map_or(Matrix::zeros(), |k| slopes[k]);
                let own = point_value::<D>(displacement, term.point) + slope * term.arm;
                sum += self.on_image(term.image, own, walls) * term.weight;
                all += term.weight;
            }
            sum / all
        };
        places.iter().map(blend).collect()
    }

    /// What an image makes of a displacement, with the walls where they are, m.
    fn on_image(&self, image: u8, own: Vector<D>, walls: &[f64]) -> Vector<D> {
        if image == 0 {
            return own;
        }
        let sign = |axis: usize, _| self.elastic.extension[axis].sign(image);
        let mut value = Vector::<D>::from_fn(sign).component_mul(&own);
        for (wall, place) in self.walls.iter().zip(walls) {
            let mut unit = [0.0; 6];
            unit[wall.side.index()] = *place;
            let extension = &self.elastic.extension[wall.component];
            value[wall.component] += extension.wall_offset(image, &unit[..2 * D]);
        }
        value
    }

    /// Displacement at a place on one side of a crack: value and slope of the nearest point there,
    /// averaged over equally near ones, m.
    pub fn displacement_at(
        &self,
        displacement: &[f64],
        walls: &[f64],
        place: &Place<D>,
    ) -> Vector<D> {
        let cloud = &self.elastic.around.cloud;
        let value = |&point: &usize| {
            let difference = |bond| self.difference(displacement, walls, point, bond);
            let slope = self.elastic.gradient_of(point, difference);
            point_value::<D>(displacement, point) + slope * (place.at - cloud.position[point])
        };
        place.nearest.iter().map(value).sum::<Vector<D>>() / place.nearest.len() as f64
    }
}
