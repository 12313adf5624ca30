//! Deformation of the rock, and what holds and loads it.

use super::Resolver;
use crate::load::Load;
use crate::plan::types::{
    CouplingPlan, CrackKind, GradientChoice, MechanicsPlan, Support, TractionPlan,
};
use crate::scene::quantity::{Dimension, values};
use crate::scene::{self, Coupling, Mechanics};

impl Resolver<'_> {
    /// The deformation in a domain of `dimension` axes that is `thickness` metres thick.
    pub(super) fn mechanics(
        &mut self,
        mechanics: &Mechanics,
        dimension: usize,
        thickness: f64,
    ) -> Option<MechanicsPlan> {
        if let Some(force) = &mechanics.body_force
            && force.len() != dimension
        {
            // Points from a file tell the dimension only now.
            let found = force.len();
            let message = format!("`body_force` needs {dimension} components, found {found}");
            return self.fault(force.span, message);
        }
        let mut sides = vec![Support::Free; 6];
        for (side, typed) in mechanics.boundary.iter() {
            sides[side.resolved().index()] = support(&typed.value, dimension, thickness);
        }
        Some(MechanicsPlan {
            inertia: mechanics.is_dynamic(),
            hourglass: mechanics.hourglass.value(),
            gradient: solid_gradient(mechanics, &self.loaded.scene),
            interfaces: mechanics.interfaces.value,
            body_force: mechanics.body_force.as_ref().map(|force| values(force)),
            sides,
            loads: mechanics.loads.iter().map(traction).collect(),
        })
    }
}

/// The gradient of the displacement, plain where the scene does not ask for another and cracks are cut, as their faces are
/// no layer that the divergence-consistent gradient knows, and in the model of the paper, which has it.
fn solid_gradient(mechanics: &Mechanics, scene: &scene::Scene) -> GradientChoice {
    let cut = |crack: &scene::Entry<scene::Crack>| crack.value.kind.value == CrackKind::Cut;
    let paper =
        (scene.damage.as_ref()).is_some_and(|damage| damage.model == scene::DamageModel::Paper);
    let plain = paper || scene.cracks.iter().any(cut);
    match mechanics.gradient.value {
        GradientChoice::Auto if plain => GradientChoice::Plain,
        chosen => chosen,
    }
}

pub(super) fn coupling(coupling: &Coupling) -> CouplingPlan {
    CouplingPlan {
        undrained_start: coupling.undrained_start,
        stabilisation: coupling.stabilisation.value(),
    }
}

fn support(support: &scene::Support, dimension: usize, thickness: f64) -> Support {
    let zero = Load::constant(0.0);
    match support {
        scene::Support::Free { .. } => Support::Free,
        scene::Support::Clamped { .. } => Support::Prescribed(vec![zero; dimension]),
        scene::Support::Roller { .. } => Support::Roller(zero),
        scene::Support::Traction { traction } => Support::Traction(loads(traction)),
        scene::Support::Displacement { displacement } => Support::Prescribed(loads(displacement)),
        scene::Support::NormalDisplacement {
            normal_displacement,
        } => Support::Roller(normal_displacement.resolved()),
        scene::Support::Plate { plate } => Support::Plate(plate.per_thickness(thickness)),
    }
}

fn traction(entry: &scene::Entry<scene::TractionLoad>) -> TractionPlan {
    TractionPlan {
        name: entry.name.clone(),
        side: entry.value.side.resolved(),
        region: entry.value.region.as_ref().map(|region| region.resolved()),
        traction: loads(&entry.value.traction),
    }
}

fn loads<D: Dimension>(loads: &[scene::Load<D>]) -> Vec<Load> {
    loads.iter().map(scene::Load::resolved).collect()
}
