//! Fields of the plan, point by point.

use std::borrow::Cow;

use crate::geometry::{Cloud, Vector};
use crate::material::{Elasticity, Lame, log_normal, storage_coefficient};
use crate::plan::{
    ElasticityPlan, FieldPlan, MaterialPlan, Plan, PorousPlan, StoragePlan, check_length,
};

use super::ModelError;

/// A cloud whose points have materials, for which fields are asked.
pub(super) struct Fields<'a, const D: usize> {
    pub(super) plan: &'a Plan,
    pub(super) cloud: &'a Cloud<D>,
    /// Material per point.
    pub(super) material: &'a [u16],
}

impl<const D: usize> Fields<'_, D> {
    /// A property of every point, or nothing where no effect needs it.
    pub(super) fn needed(
        &self,
        needed: bool,
        property: &'static str,
        of: impl Fn(&MaterialPlan) -> Option<&FieldPlan>,
    ) -> Result<Vec<f64>, ModelError> {
        if !needed {
            return Ok(Vec::new());
        }
        self.spread(&self.all(property, of)?)
    }

    /// What every material has; it is an error if one has none.
    fn all<'a, T: ?Sized>(
        &'a self,
        property: &'static str,
        of: impl Fn(&'a MaterialPlan) -> Option<&'a T>,
    ) -> Result<Vec<&'a T>, ModelError> {
        let value = |own: &'a MaterialPlan| {
            of(own).ok_or_else(|| ModelError::MissingProperty {
                material: own.name.clone(),
                property,
            })
        };
        self.plan.materials.iter().map(value).collect()
    }

    /// The elastic constants of every point.
    pub(super) fn lame(&self) -> Result<Vec<Lame>, ModelError> {
        let all = self.all("elastic moduli", |own| own.elasticity.as_ref())?;
        let uniform: Option<Vec<Lame>> = (all.iter().copied())
            .map(|own| Some(ElasticityPlan::uniform(own)?.lame()))
            .collect();
        if let Some(values) = uniform {
            return Ok(self.by_material(&values));
        }
        let part = |of: fn(&ElasticityPlan) -> &FieldPlan| {
            self.spread(&all.iter().map(|own| of(own)).collect::<Vec<_>>())
        };
        let moduli = part(|own| &own.youngs_modulus)?;
        let ratios = part(|own| &own.poissons_ratio)?;
        let lame = |(&youngs_modulus, &poissons_ratio)| {
            let rock = Elasticity {
                youngs_modulus,
                poissons_ratio,
            };
            rock.lame()
        };
        Ok(moduli.iter().zip(&ratios).map(lame).collect())
    }

    /// The storage of every point, 1/Pa.
    pub(super) fn storage(&self) -> Result<Vec<f64>, ModelError> {
        // Points of porous materials are filled in below.
        let placeholder = FieldPlan::Uniform(1.0);
        let fields = self.plan.materials.iter().map(|own| match &own.storage {
            StoragePlan::Given(field) => field,
            StoragePlan::Porous(_) => &placeholder,
        });
        let mut storage = self.spread(&fields.collect::<Vec<_>>())?;
        for (number, own) in self.plan.materials.iter().enumerate() {
            if let StoragePlan::Porous(porous) = &own.storage {
                self.porous(number, porous, &mut storage)?;
            }
        }
        Ok(storage)
    }

    /// Storage by Eq. 38 at the points of a material.
    fn porous(
        &self,
        number: usize,
        porous: &PorousPlan,
        storage: &mut [f64],
    ) -> Result<(), ModelError> {
        let porosity = self.values(&porous.porosity)?;
        let biot = self.values(&porous.biot_coefficient)?;
        let rock = self.values(&porous.bulk_modulus)?;
        for point in self.points_of(number) {
            let (n, alpha) = (porosity.at(point), biot.at(point));
            if n > alpha {
                return Err(ModelError::PorosityAboveBiot {
                    material: self.plan.materials[number].name.clone(),
                    point,
                    position: self.cloud.position[point].iter().copied().collect(),
                    porosity: n,
                    biot: alpha,
                });
            }
            storage[point] = storage_coefficient(n, alpha, rock.at(point), porous.fluid);
        }
        Ok(())
    }

    fn points_of(&self, number: usize) -> impl Iterator<Item = usize> {
        let points = self.material.iter().enumerate();
        points.filter_map(move |(point, own)| (usize::from(*own) == number).then_some(point))
    }

    /// The value of every point by its material, whose fields are given in the order of the materials.
    pub(super) fn spread(&self, fields: &[&FieldPlan]) -> Result<Vec<f64>, ModelError> {
        let uniform: Option<Vec<f64>> = fields.iter().map(|own| own.uniform()).collect();
        if let Some(values) = uniform {
            return Ok(self.by_material(&values));
        }
        let mut all = vec![0.0; self.cloud.len()];
        for (number, own) in fields.iter().enumerate() {
            let values = self.values(own)?;
            for point in self.points_of(number) {
                all[point] = values.at(point);
            }
        }
        Ok(all)
    }

    fn by_material<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let value = |own: &u16| values[usize::from(*own)];
        self.material.iter().map(value).collect()
    }

    /// A field at all points, those of other materials included, so that fields of one seed draw the same numbers.
    fn values<'a>(&self, field: &'a FieldPlan) -> Result<Values<'a>, ModelError> {
        let cloud = self.cloud;
        Ok(Values::Each(match field {
            FieldPlan::Uniform(value) => return Ok(Values::One(*value)),
            FieldPlan::Table {
                values,
                cells: Some(cells),
                ..
            } => Cow::Owned(laid_over(cloud, values, cells)),
            FieldPlan::Table {
                path,
                values,
                cells: None,
            } => {
                // A table of a finer cloud, whose own length has been checked, is thinned.
                let points = cloud.len();
                match self.plan.geometry.count() {
                    Some(count) if count != points => Cow::Owned(thinned(values, points)),
                    _ => {
                        check_length(path, values.len(), points)?;
                        Cow::Borrowed(values)
                    }
                }
            }
            FieldPlan::LogNormal {
                median,
                log10_std,
                decades,
                correlation_length,
                seed,
            } => Cow::Owned(log_normal(
                &cloud.position,
                *median,
                *log10_std,
                *decades,
                *correlation_length,
                *seed,
            )),
        }))
    }
}

/// Values of a field.
enum Values<'a> {
    One(f64),
    Each(Cow<'a, [f64]>),
}

impl Values<'_> {
    fn at(&self, point: usize) -> f64 {
        match self {
            Self::One(value) => *value,
            Self::Each(values) => values[point],
        }
    }
}

fn thinned(values: &[f64], points: usize) -> Vec<f64> {
    (0..points)
        .map(|i| values[i * values.len() / points])
        .collect()
}

/// Every point's value of an array (x fastest) of `cells` that is laid over the domain.
fn laid_over<const D: usize>(cloud: &Cloud<D>, values: &[f64], cells: &[usize]) -> Vec<f64> {
    let (lower, size) = (cloud.domain.lower, cloud.domain.size());
    let value = |x: &Vector<D>| {
        let index = (0..D).rev().fold(0, |index, axis| {
            let place = (x[axis] - lower[axis]) / size[axis] * cells[axis] as f64;
            index * cells[axis] + (place as usize).min(cells[axis] - 1)
        });
        values[index]
    };
    cloud.position.iter().map(value).collect()
}
