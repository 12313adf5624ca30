//! What is varied: the permeability of one of two rocks, or the spread of an array.

use crate::plan::{FieldPlan, PermeabilityPlan, Plan, with_contrast};
use crate::study::{StudyCase, StudyError};

/// What a contrast changes in a scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Varied {
    /// The material of the larger permeability: the contrast times that of the other, m².
    Layer { name: String, other: f64 },
    /// The array of the only material.
    Array { name: String },
}

impl Varied {
    /// Of two materials with one value each, or of one with an array.
    ///
    /// # Errors
    /// [`StudyError::Unsuited`] for all others.
    pub(super) fn of(subject: &StudyCase) -> Result<Self, StudyError> {
        let materials = &subject.plan.materials;
        if let [first, second] = &materials[..] {
            let values = [first, second].map(|own| {
                own.permeability
                    .as_ref()
                    .and_then(PermeabilityPlan::uniform)
            });
            if let [Some(one), Some(two)] = values {
                // The later one of equals: a region within the rock.
                let (most, other) = if one > two {
                    (first, two)
                } else {
                    (second, one)
                };
                return Ok(Varied::Layer {
                    name: most.name.clone(),
                    other,
                });
            }
        }
        if let [only] = &materials[..]
            && let Some(PermeabilityPlan::Field(FieldPlan::Table { values, .. })) =
                &only.permeability
            && with_contrast(values, 1.0).is_some()
        {
            return Ok(Varied::Array {
                name: only.name.clone(),
            });
        }
        Err(StudyError::Unsuited {
            study: "the contrast study",
            case: subject.plan.case.clone(),
            reason: "it needs exactly two materials with one permeability each, as two-layer, channel, \
                     barrier and inclusion have, or one with an array of different values, as spe10-1 has"
                .to_owned(),
        })
    }

    /// The key and value that give a scene this contrast.
    pub(super) fn override_for(&self, contrast: f64) -> String {
        match self {
            Varied::Layer { name, other } => {
                format!("materials.{name}.permeability={:e}", contrast * other)
            }
            Varied::Array { name } => {
                format!("materials.{name}.permeability.contrast={contrast:e}")
            }
        }
    }

    /// The plan at this contrast, as the override makes it.
    pub(super) fn plan_at(&self, plan: &Plan, contrast: f64) -> Plan {
        let mut plan = plan.clone();
        let (Varied::Layer { name, .. } | Varied::Array { name }) = self;
        for own in plan.materials.iter_mut().filter(|own| own.name == *name) {
            match (self, &mut own.permeability) {
                (
                    Varied::Layer { other, .. },
                    Some(PermeabilityPlan::Field(FieldPlan::Uniform(value))),
                ) => {
                    *value = contrast * other;
                }
                (
                    Varied::Array { .. },
                    Some(PermeabilityPlan::Field(FieldPlan::Table { values, .. })),
                ) => {
                    if let Some(stretched) = with_contrast(values, contrast) {
                        *values = stretched;
                    }
                }
                _ => {}
            }
        }
        plan
    }
}
