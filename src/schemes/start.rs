//! How runs without linear systems start: from an equilibrium that one factor finds, or that relaxation finds.

use perifrac_solvers::{Demand, SolverSpec};

use super::solid::{Assembled, SolidSolver};
use super::undrained::undrained;
use super::{SchemeCounters, State, StepError, flow_of, solid_of};
use crate::model::Model;
use crate::plan::{Plan, SchemeOptions, SchemeStart};

/// The start of an explicit run.
#[derive(Debug)]
pub(super) struct ExplicitStart {
    /// The linear problem, where it may be assembled and solved.
    demand: Option<Demand>,
    options: SchemeOptions,
    counters: SchemeCounters,
}

impl ExplicitStart {
    /// As the plan asks; the rows of one process are no matrix that could be solved here.
    pub(crate) fn new<const D: usize>(plan: &Plan, model: &Model<D>) -> Self {
        let whole = model.subdomain().partition().is_none();
        let assembled = plan.scheme_options.start == SchemeStart::Assembled;
        ExplicitStart {
            // The solver that is typed is for the systems of the steps, and need not take this one.
            demand: (whole && assembled).then(|| Demand {
                spec: SolverSpec::default(),
                solves: plan.solid_demand().solves,
            }),
            options: plan.scheme_options,
            counters: SchemeCounters::default(),
        }
    }

    /// Brings a state to the undrained response to its loads, or the solid to equilibrium at the pressure that is
    /// given; `relaxation` does so where no matrix may.
    ///
    /// # Errors
    /// [`StepError`].
    pub(crate) fn start<const D: usize>(
        &mut self,
        model: &Model<D>,
        relaxation: &mut dyn SolidSolver<D>,
        state: &mut State,
    ) -> Result<(), StepError> {
        let Some(coupling) = &model.coupling else {
            return Ok(());
        };
        let mut assembled = match &self.demand {
            Some(demand) => Some(Assembled::apart(demand, solid_of(model)?)?),
            None => None,
        };
        let solid: &mut dyn SolidSolver<D> = match &mut assembled {
            Some(own) => own,
            None => relaxation,
        };
        match coupling.undrained_start {
            true => undrained(model, solid, &self.options, state)?,
            false => solid.equilibrate(model, state).map(drop)?,
        }
        if let Some(own) = &assembled {
            self.counters.add(&SolidSolver::<D>::counters(own));
        }
        Ok(())
    }

    /// Whether the start is one that this does; a storage that couples points is part of a step without a length.
    ///
    /// # Errors
    /// [`StepError::MissingPart`] without flow.
    pub(crate) fn applies<const D: usize>(&self, model: &Model<D>) -> Result<bool, StepError> {
        Ok(flow_of(model)?.stabilisation.is_empty())
    }

    /// Work done so far.
    pub(crate) fn counters(&self) -> &SchemeCounters {
        &self.counters
    }
}
