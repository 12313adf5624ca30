//! Permeabilities: fields and tensors.

use super::Resolver;
use crate::plan::files::Property;
use crate::plan::types::{GeometryPlan, GradientChoice, OperatorChoice, PermeabilityPlan, Plan};
use crate::scene::{self, PermeabilityField, Span, Typed};

impl Resolver<'_> {
    pub(super) fn permeability(
        &mut self,
        field: &PermeabilityField,
        geometry: Option<&GeometryPlan>,
    ) -> Option<PermeabilityPlan> {
        let scalar = |own: &mut Self, typed| {
            let field = own.field(typed, Property::PERMEABILITY, geometry);
            field.map(PermeabilityPlan::Field)
        };
        Some(match field {
            PermeabilityField::Value(value) => scalar(self, Typed::Value(*value))?,
            PermeabilityField::File(file) => scalar(self, Typed::File(file))?,
            PermeabilityField::Distribution(random) => scalar(self, Typed::Distribution(random))?,
            PermeabilityField::K1(tensor) => {
                self.in_the_plane(tensor.k1.span(), geometry)?;
                principal(tensor)
            }
            PermeabilityField::Xx(tensor) => {
                self.in_the_plane(tensor.xx.span(), geometry)?;
                by_components(tensor)
            }
        })
    }

    /// Tensors exist in two dimensions only.
    fn in_the_plane(&mut self, place: Span, geometry: Option<&GeometryPlan>) -> Option<()> {
        match geometry.map(GeometryPlan::dimension) {
            Some(3) => self.fault(
                place,
                "a permeability tensor works in two dimensions only; give one value, or run a plane",
            ),
            _ => Some(()),
        }
    }

    /// Where permeabilities are tensors, what only numbers go together with is refused.
    pub(super) fn check_tensors(&mut self, plan: &Plan) {
        let scene = &self.loaded.scene;
        let Some(flow) = &scene.flow else {
            return;
        };
        let typed = scene.materials.iter();
        let mut typed = typed.filter_map(|entry| entry.value.permeability.as_ref());
        let Some(first) = typed.find(|own| own.is_tensor()) else {
            return;
        };
        if !matches!(plan.geometry, GeometryPlan::Lattice { jitter, .. } if jitter <= 0.0) {
            let message = "a permeability tensor needs a lattice without jitter: set geometry.type = \
                           \"lattice\", or give one value";
            self.fault::<()>(first.span, message);
        }
        let other = !matches!(
            flow.operator.value,
            OperatorChoice::Auto | OperatorChoice::Path
        );
        let gradient = flow.gradient.value != GradientChoice::Auto;
        let named = [(other, flow.operator.span), (gradient, flow.gradient.span)];
        if let Some((_, place)) = named.into_iter().find(|(named, _)| *named) {
            let message = "only the path operator knows permeability tensors: leave `operator` and `gradient` \
                           out, or give one value for the permeability";
            self.fault::<()>(place, message);
        }
        for (_, condition) in flow.boundary.iter() {
            if let scene::Condition::Flux(_) = condition.value {
                let message = "a prescribed flux and a permeability tensor do not go together: feed the side \
                               by a pressure, or by [wells] beside it";
                self.fault::<()>(condition.span, message);
            }
        }
    }
}

/// A tensor by its principal values and their axis.
fn principal(tensor: &scene::PrincipalPermeability) -> PermeabilityPlan {
    let [k1, k2] = [tensor.k1, tensor.k2].map(|own| own.value());
    let (sine, cosine) = tensor.angle.value().sin_cos();
    let largest = k1.max(k2);
    let [a, b] = [k1, k2].map(|own| own / largest);
    PermeabilityPlan::Tensor {
        largest,
        shape: [
            a * cosine * cosine + b * sine * sine,
            a * sine * sine + b * cosine * cosine,
            (a - b) * cosine * sine,
        ],
    }
}

fn by_components(tensor: &scene::PermeabilityTensor) -> PermeabilityPlan {
    let [xx, yy, xy] = [tensor.xx, tensor.yy, tensor.xy].map(|own| own.value());
    let largest = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    PermeabilityPlan::Tensor {
        largest,
        shape: [xx, yy, xy].map(|own| own / largest),
    }
}
