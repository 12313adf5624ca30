//! Gravity: the weight of the fluid column, ρ_f **g** in Darcy's law (Eq. 37, with the sign that
//! makes a hydrostatic pressure a state of rest).
//!
//! The flux is driven by ∇p − ρ_f g. The weight is a linear function, so across a sealed side it
//! mirrors like the pressure and across a prescribed one it continues; a hydrostatic column is
//! therefore at rest to rounding.

use super::{Context, Effect, EffectError, vector};
use crate::geometry::{Cloud, Families, Side, Vector};
use crate::operators::MirrorContinuation;
use crate::plan::{Plan, SideCondition};

/// Weight of the fluid per volume and where hydrostatic side pressures have their datum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column<const D: usize> {
    /// ρ_f g in Pa/m.
    pub weight: Vector<D>,
    /// Per side, whether its pressure is hydrostatic.
    hydrostatic: Vec<bool>,
    /// Highest corner of the domain, m: where side and initial pressures are given.
    datum: Vector<D>,
}

impl<const D: usize> Column<D> {
    /// The column of a plan, if it names gravity.
    pub(crate) fn of(plan: &Plan, cloud: &Cloud<D>) -> Option<Self> {
        let gravity = plan.gravity.as_ref()?;
        let weight: Vector<D> = vector::<D>(&gravity.acceleration) * plan.fluid.density;
        let (lower, upper) = (&cloud.domain.lower, &cloud.domain.upper);
        let datum = Vector::from_fn(|a, _| if weight[a] < 0.0 { upper[a] } else { lower[a] });
        let sides = plan.flow.as_ref().map_or(&[][..], |flow| &flow.sides);
        let hydrostatic = sides
            .iter()
            .map(|side| {
                matches!(
                    side,
                    SideCondition::Pressure {
                        hydrostatic: true,
                        ..
                    }
                )
            })
            .collect();
        Some(Column {
            weight,
            hydrostatic,
            datum,
        })
    }

    /// Hydrostatic pressure at `x` above that at the highest point, Pa.
    pub(crate) fn pressure(&self, x: &Vector<D>) -> f64 {
        self.weight.dot(&(x - self.datum))
    }

    /// Hydrostatic pressure at `x` above that at a height (m, against gravity from the origin), Pa; above that
    /// at the highest point if there is none.
    pub(crate) fn pressure_below(&self, height: Option<f64>, x: &Vector<D>) -> f64 {
        let weight = self.weight.norm();
        match height {
            Some(height) => self.weight.dot(x) + weight * height,
            None => self.pressure(x),
        }
    }

    /// What a hydrostatic side adds to its prescribed value at `x` on the side, Pa; the value
    /// itself holds at the highest point of the side.
    fn on_wall(&self, side: Side, x: &Vector<D>) -> f64 {
        if !self.hydrostatic[side.index()] {
            return 0.0;
        }
        let mut along = x - self.datum;
        along[side.axis] = 0.0;
        self.weight.dot(&along)
    }

    /// Bond difference that gravity adds to that of the pressure, Pa.
    pub(crate) fn difference(
        &self,
        cloud: &Cloud<D>,
        families: &Families<D>,
        extension: &MirrorContinuation<D>,
        owner: usize,
        bond: usize,
    ) -> f64 {
        let image = families.image(bond);
        let end = &cloud.position[families.neighbour(bond)];
        if image == 0 {
            return -self.weight.dot(&(end - cloud.position[owner]));
        }
        self.on_image(extension, image, end) + self.weight.dot(&cloud.position[owner])
    }

    /// What gravity adds to the value of the image of a point at `x`, less the weight there, Pa.
    pub(crate) fn on_image(
        &self,
        extension: &MirrorContinuation<D>,
        image: u8,
        x: &Vector<D>,
    ) -> f64 {
        let foot = extension.foot(image, x);
        extension.offset(image, x, |side, x| self.on_wall(side, x)) - self.weight.dot(&foot)
    }
}

/// The constant rate that the weight drives.
struct Gravity {
    rate: Vec<f64>,
}

pub(super) fn build<const D: usize>(
    context: &Context<'_, D>,
) -> Result<Vec<Box<dyn Effect>>, EffectError> {
    let Some(column) = context.column else {
        return Ok(Vec::new());
    };
    let around = context.operator.neighbourhood();
    let difference = |owner: usize, bond: usize| {
        column.difference(
            &around.cloud,
            &around.families,
            context.extension,
            owner,
            bond,
        )
    };
    let force = context
        .operator
        .force(context.extension, context.mobility, &difference);
    Ok(vec![Box::new(Gravity {
        rate: force.into_iter().map(|f| -f).collect(),
    })])
}

impl Effect for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn add_rate(&self, _time: f64, rate: &mut [f64]) {
        rate.iter_mut()
            .zip(&self.rate)
            .for_each(|(total, own)| *total += own);
    }

    fn bytes(&self) -> usize {
        8 * self.rate.len()
    }
}
