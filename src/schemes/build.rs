//! Which scheme a plan gets: one place where names, effects and schemes meet.

use super::{
    Assembled, FlowStage, ForwardEuler, Fracture, FractureFlowStep, Implicit, ImplicitSystem,
    LaggedFracture, Monolithic, QuasiStatic, Relaxation, Scheme, SolidSolver, Staggered, StepError,
    Verlet, coupling_of, flow_of, solid_of,
};
use crate::model::{Drive, Model};
use crate::plan::{Integrator, Plan, SchemeChoice, StepRule};

/// Builds the scheme of the plan.
///
/// Without mechanics there is nothing to couple: every implicit scheme is the implicit flow scheme.
/// Without flow every implicit scheme solves for equilibrium, every explicit one relaxes to it.
///
/// # Errors
/// [`StepError::Refused`] if the scheme cannot run the scene; [`StepError`] if the solver cannot be
/// built.
pub fn build<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn Scheme<D>>, StepError> {
    let inertia = (plan.mechanics.as_ref()).is_some_and(|mechanics| mechanics.inertia);
    let relaxes = matches!(
        plan.scheme,
        SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_)
    );
    if model.share().partition().is_some() && (inertia || relaxes) {
        return Err(StepError::Refused {
            scheme: plan.scheme.name(),
            reason: "it works in one process; start it without mpirun, or use --scheme implicit, \
                     staggered or monolithic",
        });
    }
    if plan.damage.is_some() {
        check_damage(plan, model)?;
    }
    if inertia {
        return dynamic(plan, model);
    }
    match (&model.flow, &model.solid) {
        (Some(_), None) => flow_alone(plan, model),
        (None, _) => Ok(Box::new(QuasiStatic::new(solid_alone(plan, model)?))),
        (Some(_), Some(_)) => coupled(plan, model),
    }
}

/// What rock that breaks does not go together with.
fn check_damage<const D: usize>(plan: &Plan, model: &Model<D>) -> Result<(), StepError> {
    let refused = |reason| {
        Err(StepError::Refused {
            scheme: plan.scheme.name(),
            reason,
        })
    };
    if model.share().partition().is_some() {
        return refused("damage works in one process; start it without mpirun");
    }
    if model.flow.is_some() && model.fracture_flow.is_none() {
        return refused(
            "flow would not follow damage; add [fracture_flow], or leave [flow] or [damage] out",
        );
    }
    Ok(())
}

fn flow_alone<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn Scheme<D>>, StepError> {
    let Some(integrator) = plan.scheme.integrator() else {
        return Ok(Box::new(ForwardEuler::new(model)?));
    };
    let stage = FlowStage::new(&plan.stage_demand(), flow_of(model)?)?;
    Ok(Box::new(Implicit::new(
        integrator,
        Box::new(stage),
        adaptive(plan),
    )))
}

/// Whether step control asks for error estimates.
fn adaptive(plan: &Plan) -> bool {
    plan.time.step == StepRule::Adaptive
}

fn solid_alone<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn SolidSolver<D>>, StepError> {
    Ok(match plan.scheme {
        SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_) => {
            Box::new(Relaxation::new(plan.scheme_options))
        }
        _ => match plan.damage {
            Some(damage) => Box::new(Fracture::new(&plan.fracture_demand(), model, damage)?),
            None => Box::new(Assembled::new(&plan.solid_demand(), solid_of(model)?)?),
        },
    })
}

fn coupled<const D: usize>(plan: &Plan, model: &Model<D>) -> Result<Box<dyn Scheme<D>>, StepError> {
    if let (Some(damage), true) = (plan.damage, model.fracture_flow.is_some()) {
        return Ok(match plan.scheme {
            SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_) => {
                Box::new(LaggedFracture::new(plan, model)?)
            }
            _ => Box::new(FractureFlowStep::new(plan, damage, model)?),
        });
    }
    let options = plan.scheme_options;
    let parts = (flow_of(model)?, coupling_of(model)?);
    let flow = || ImplicitSystem::new(&plan.stage_demand(), parts.0);
    Ok(match plan.scheme {
        SchemeChoice::Explicit if !parts.0.stabilisation.is_empty() => {
            return Err(StepError::Refused {
                scheme: "explicit",
                reason: "coupling.stabilisation needs a linear system; set it to 0, or use an implicit \
                         scheme",
            });
        }
        SchemeChoice::Explicit => {
            let solid = Box::new(Relaxation::new(options));
            let name = SolidSolver::<D>::name(&*solid);
            let passes = Staggered::pointwise(solid, parts, options, true);
            Box::new(ForwardEuler::coupled(model, passes, name)?)
        }
        SchemeChoice::SemiImplicit(integrator) => {
            let solid = Box::new(Relaxation::new(options));
            let stage = Staggered::lagged(flow()?, solid, parts, options);
            Box::new(Implicit::new(integrator, Box::new(stage), adaptive(plan)))
        }
        SchemeChoice::Staggered(integrator) => {
            let solid = Box::new(Assembled::new(&plan.solid_demand(), solid_of(model)?)?);
            let stage = Staggered::iterated(flow()?, solid, parts, options);
            Box::new(Implicit::new(integrator, Box::new(stage), adaptive(plan)))
        }
        SchemeChoice::Implicit(integrator) | SchemeChoice::Monolithic(integrator) => {
            let stage = Monolithic::new(&plan.stage_demand(), model)?;
            Box::new(Implicit::new(integrator, Box::new(stage), adaptive(plan)))
        }
    })
}

fn dynamic<const D: usize>(plan: &Plan, model: &Model<D>) -> Result<Box<dyn Scheme<D>>, StepError> {
    let refused = |reason| {
        Err(StepError::Refused {
            scheme: plan.scheme.name(),
            reason,
        })
    };
    let plate = |wall: &crate::model::MovingWall| matches!(wall.drive, Drive::Force(_));
    if solid_of(model)?.walls.iter().any(plate) {
        return refused("a rigid plate has no mass; use mechanics.mode = \"quasi-static\"");
    }
    match (plan.scheme, &model.flow) {
        (SchemeChoice::Explicit, _) | (SchemeChoice::SemiImplicit(_), None) => {
            Ok(Box::new(Verlet::new(model, None)?))
        }
        (SchemeChoice::SemiImplicit(Integrator::BackwardEuler), Some(flow)) => {
            let system = ImplicitSystem::new(&plan.stage_demand(), flow)?;
            Ok(Box::new(Verlet::new(model, Some(system))?))
        }
        (SchemeChoice::SemiImplicit(Integrator::TrBdf2), Some(_)) => refused(
            "dynamics take the pressure by backward Euler; set time.integrator = \"backward-euler\"",
        ),
        _ => refused("it has no inertia; use explicit or semi-implicit, or quasi-static mechanics"),
    }
}
