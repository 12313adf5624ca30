//! The scheme of a plan, put together from its parts.

use super::start::ExplicitStart;
use super::{
    Assembled, FlowStage, ForwardEuler, Fracture, FractureFlowStep, Implicit, ImplicitSystem,
    LaggedFracture, Monolithic, QuasiStatic, Relaxation, Scheme, SolidSolver, Stage, Staggered,
    StepError, Verlet, coupling_of, flow_of, solid_of,
};
use crate::model::Model;
use crate::plan::capability::{Method, Refusal, method, refusals, scales_mass};
use crate::plan::{DamagePlan, Integrator, Plan, StepRule};

/// Refuses what cannot be combined in a run by so many processes.
///
/// # Errors
/// [`StepError`] of the first [refusal](refusals).
pub fn check(plan: &Plan, processes: usize) -> Result<(), StepError> {
    match refusals(plan, processes).into_iter().next() {
        None => Ok(()),
        Some(Refusal::Solver(error)) => Err(error.into()),
        Some(refusal) => Err(StepError::Refused(refusal)),
    }
}

/// Builds the scheme of a plan: its [`Method`].
///
/// # Errors
/// [`StepError`] if the plan is refused, or if the solver cannot be built.
pub fn build<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn Scheme<D>>, StepError> {
    let team = model
        .subdomain()
        .partition()
        .map(|partition| partition.team());
    check(plan, team.map_or(1, |team| team.size()))?;
    let options = plan.scheme_options;
    Ok(match method(plan) {
        Method::Steady => return Err(StepError::MissingPart { part: "time.end" }),
        Method::ForwardEuler => Box::new(ForwardEuler::new(model)?),
        Method::Relaxation => Box::new(QuasiStatic::new(Box::new(Relaxation::new(options)))),
        Method::Equilibrium => Box::new(QuasiStatic::new(assembled(plan, model)?)),
        Method::Fracture => {
            let fracture = Fracture::new(&plan.fracture_demand(), model, damage_of(plan)?)?;
            Box::new(QuasiStatic::new(Box::new(fracture)))
        }
        Method::Verlet if scales_mass(plan) => {
            Box::new(Verlet::new(model, None)?.with_scaled_mass(plan, model))
        }
        Method::Verlet => Box::new(Verlet::new(model, None)?),
        Method::VerletWithFlow => Box::new(Verlet::new(model, Some(system(plan, model)?))?),
        Method::RelaxedExplicit => {
            let solid = Box::new(Relaxation::new(options));
            let name = SolidSolver::<D>::name(&*solid);
            let parts = (flow_of(model)?, coupling_of(model)?);
            let passes = Staggered::pointwise(solid, parts, options, true);
            Box::new(ForwardEuler::coupled(plan, model, passes, name)?)
        }
        Method::LaggedFracture => Box::new(LaggedFracture::new(plan, model)?),
        Method::StaggeredFracture | Method::MonolithicFracture => {
            Box::new(FractureFlowStep::new(plan, damage_of(plan)?, model)?)
        }
        Method::ImplicitFlow | Method::RelaxedImplicit | Method::Staggered | Method::Monolithic => {
            let adaptive = plan.time.step == StepRule::Adaptive;
            let integrator = (plan.scheme.integrator()).unwrap_or(Integrator::BackwardEuler);
            Box::new(Implicit::new(integrator, stage(plan, model)?, adaptive))
        }
    })
}

/// What a stage of an implicit integrator solves.
fn stage<const D: usize>(plan: &Plan, model: &Model<D>) -> Result<Box<dyn Stage<D>>, StepError> {
    let options = plan.scheme_options;
    Ok(match method(plan) {
        Method::RelaxedImplicit => {
            let solid = Box::new(Relaxation::new(options));
            let parts = (flow_of(model)?, coupling_of(model)?);
            let passes = Staggered::lagged(system(plan, model)?, solid, parts, options);
            Box::new(passes.with_start(ExplicitStart::new(plan, model)))
        }
        Method::Staggered => {
            let solid = assembled(plan, model)?;
            let parts = (flow_of(model)?, coupling_of(model)?);
            Box::new(Staggered::iterated(
                system(plan, model)?,
                solid,
                parts,
                options,
            ))
        }
        Method::Monolithic => Box::new(Monolithic::new(&plan.stage_demand(), model)?),
        _ => Box::new(FlowStage::new(&plan.stage_demand(), flow_of(model)?)?),
    })
}

fn system<const D: usize>(plan: &Plan, model: &Model<D>) -> Result<ImplicitSystem, StepError> {
    ImplicitSystem::new(&plan.stage_demand(), flow_of(model)?)
}

fn assembled<const D: usize>(
    plan: &Plan,
    model: &Model<D>,
) -> Result<Box<dyn SolidSolver<D>>, StepError> {
    Ok(Box::new(Assembled::new(
        &plan.solid_demand(),
        solid_of(model)?,
    )?))
}

fn damage_of(plan: &Plan) -> Result<DamagePlan, StepError> {
    plan.damage
        .ok_or(StepError::MissingPart { part: "[damage]" })
}
