//! Rock that breaks most and least easily, where its properties vary.

use crate::model::properties::Properties;
use crate::operators::Lame;
use crate::plan::{DamageModel, Plan};

/// What tells when rock breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rock {
    /// The modulus of a bar by the model of damage: λ + 2μ in the split model, else E, Pa.
    pub modulus: f64,
    /// Fracture energy G_c, J/m².
    pub energy: f64,
}

/// Per material the rocks with the smallest and largest energy, strength (√(M G)) and strain (√(G/M)) of all its points;
/// none of materials that are the same everywhere, and an empty list if all are.
pub(super) fn extremes(plan: &Plan, points: &Properties) -> Vec<Vec<Rock>> {
    let Some(damage) = &plan.damage else {
        return Vec::new();
    };
    let varies = |own: &crate::plan::MaterialPlan| {
        let energy = own.fracture_energy.as_ref();
        own.uniform_elasticity().is_none() || energy.is_some_and(|own| own.uniform().is_none())
    };
    let materials = plan.materials.iter();
    if !materials.clone().any(varies) {
        return Vec::new();
    }
    let mut rocks: Vec<Vec<Rock>> = vec![Vec::new(); plan.materials.len()];
    for (point, &number) in points.material.iter().enumerate() {
        let number = usize::from(number);
        if varies(&plan.materials[number]) {
            let rock = Rock {
                modulus: modulus(points.lame[point], damage.model),
                energy: points.fracture_energy[point],
            };
            widen(&mut rocks[number], rock);
        }
    }
    rocks
}

/// Keeps a rock in place of those it outdoes: least and most of each measure.
fn widen(kept: &mut Vec<Rock>, rock: Rock) {
    let measures: [fn(&Rock) -> f64; 3] = [
        |own| own.energy,
        |own| own.energy * own.modulus,
        |own| own.energy / own.modulus,
    ];
    if kept.is_empty() {
        kept.resize(2 * measures.len(), rock);
    }
    for (pair, measure) in kept.chunks_exact_mut(2).zip(measures) {
        if measure(&rock) < measure(&pair[0]) {
            pair[0] = rock;
        }
        if measure(&rock) > measure(&pair[1]) {
            pair[1] = rock;
        }
    }
}

fn modulus(lame: Lame, model: DamageModel) -> f64 {
    let Lame { lambda, mu } = lame;
    match model {
        DamageModel::Split => lambda + 2.0 * mu,
        DamageModel::Paper => mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extreme_rocks_are_kept() {
        let rock = |modulus, energy| Rock { modulus, energy };
        let mut kept = Vec::new();
        let all = [
            rock(2.0, 3.0),
            rock(1.0, 4.0),
            rock(8.0, 2.0),
            rock(2.5, 2.5),
        ];
        all.into_iter().for_each(|own| widen(&mut kept, own));
        let [soft, stiff] = [rock(1.0, 4.0), rock(8.0, 2.0)];
        assert_eq!(kept, [stiff, soft, soft, stiff, stiff, soft]);
    }

    #[test]
    fn a_modulus_of_a_bar_by_hand() {
        // E = 10 GPa, ν = 0.25: λ = μ = 4 GPa, λ + 2μ = 12 GPa.
        let lame = Lame {
            lambda: 4e9,
            mu: 4e9,
        };
        assert!((modulus(lame, DamageModel::Paper) - 1e10).abs() < 1.0);
        assert!((modulus(lame, DamageModel::Split) - 1.2e10).abs() < 1.0);
    }
}
