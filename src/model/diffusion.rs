//! The diffusion operator that a plan chooses.

use std::sync::Arc;

use crate::assembly::{Consistency, Planes, ScalarOperator, consistent_gradient};
use crate::operators::{BondConductance, Correspondence, Neighbourhood};
use crate::plan::{FlowPlan, OperatorChoice};

use super::ModelError;

/// Share of a family's weights beyond which its correction is not trusted.
const TRUSTED: f64 = 0.5;

/// A warning if the corrected gradient is not to be trusted.
pub(super) fn doubt(quality: &Consistency) -> Option<String> {
    (quality.ratio > TRUSTED).then(|| {
        format!(
            "the divergence-consistent correction is {:.0} % of the gradient's own weights \
             somewhere; enlarge the horizon or smooth the grading",
            100.0 * quality.ratio
        )
    })
}

/// Builds the operator of `flow` over the families of `around`.
///
/// # Errors
/// [`ModelError::Consistency`] if the gradient cannot be corrected.
pub(super) fn build_operator<const D: usize>(
    flow: &FlowPlan,
    around: &Arc<Neighbourhood<D>>,
    one_sided: &[bool],
    consistency: &mut Option<Consistency>,
    warnings: &mut Vec<String>,
) -> Result<Box<dyn ScalarOperator<D>>, ModelError> {
    if flow.operator == OperatorChoice::Bond {
        let form = BondConductance::new(around.clone());
        if form.uncorrected() > 0 {
            warnings.push(format!(
                "the bond operator is not consistent at {} of {} points (their families are too \
                 uneven for positive weights); compare with flow.operator = \"correspondence\"",
                form.uncorrected(),
                around.len()
            ));
        }
        return Ok(Box::new(form));
    }
    let correct = flow.corrects_gradient(around.cloud.irregular, around.cloud.domain.planes);
    let mut corrected = None;
    if correct {
        let (gradient, quality) = consistent_gradient(around, &Planes::natural(one_sided))?;
        warnings.extend(doubt(&quality));
        *consistency = Some(quality);
        corrected = Some(gradient);
    }
    Ok(Box::new(Correspondence::new(
        around.clone(),
        flow.hourglass,
        corrected,
    )))
}
