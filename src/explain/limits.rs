//! Limits of the time step.

use super::Limit;
use crate::model::{FlowSample, PointLimit, Sample};
use crate::plan::{Plan, TimeMode};

/// Limits of all schemes that could run the plan.
pub(super) fn limits(plan: &Plan, sample: &Sample) -> Vec<Limit> {
    let mut limits = Vec::new();
    if plan.time.mode == TimeMode::Steady {
        return limits;
    }
    limits.extend(sample.flow.as_ref().map(|flow| diffusion(plan, flow)));
    let inertia = (plan.mechanics.as_ref()).is_some_and(|mechanics| mechanics.inertia);
    if !inertia {
        limits.push(Limit {
            scheme: "implicit".to_owned(),
            dt: f64::INFINITY,
            steps: None,
            limiter: match sample.flow {
                Some(_) => "none: accuracy alone".to_owned(),
                None => "none: every step ends in equilibrium".to_owned(),
            },
        });
    }
    if let Some(waves) = sample.solid.as_ref().and_then(|solid| solid.waves.as_ref()) {
        let modulus = match plan.coupling {
            Some(_) => "(λ + 2μ + α²/s)",
            None => "(λ + 2μ)",
        };
        let what = format!(
            "waves {}: 0.7 Δx √(ρ/{modulus}) (Eqs. 60 and 61)",
            at(waves)
        );
        limits.push(limit(plan, "dynamic", waves, what));
    }
    if let Some(coupling) = &sample.coupling {
        let what = format!(
            "coupling {}: 0.5 Δx²/c_v with c_v = κ/(s + α²/(λ + 2μ)) (Eq. 71); the strain of \
             the last step is a poor guess for longer ones",
            at(&coupling.limit)
        );
        limits.push(limit(plan, "lagged strain", &coupling.limit, what));
    }
    limits
}

fn diffusion(plan: &Plan, flow: &FlowSample) -> Limit {
    let inertia = (plan.mechanics.as_ref()).is_some_and(|mechanics| mechanics.inertia);
    let time = match plan.coupling {
        Some(_) if !inertia => "Δx²·(s + β α²/(λ + 2μ/D))/κ",
        _ => "Δx²·s/κ",
    };
    let run = match plan.fracture_flow {
        Some(_) => "the run itself keeps to a tenth of it, and steps shrink as fractures open",
        None => "the run itself uses the operator's own eigenvalue",
    };
    let place = at(&flow.limit);
    let what = format!("diffusion {place}: {time} is smallest there; {run}");
    limit(plan, "explicit", &flow.limit, what)
}

fn at(limit: &PointLimit) -> String {
    format!("at point {} {:?}", limit.point, limit.position)
}

fn limit(plan: &Plan, scheme: &str, limit: &PointLimit, limiter: String) -> Limit {
    Limit {
        scheme: scheme.to_owned(),
        dt: limit.dt,
        steps: Some((plan.time.end / limit.dt).ceil() as u64),
        limiter,
    }
}
