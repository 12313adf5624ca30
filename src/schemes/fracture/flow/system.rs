//! The linear systems of a step: both fields, or the displacement where fields take turns.

use perifrac_solvers::{Coordinates, Demand, NearNullspace, Problem, Symmetry};

use crate::material::TangentKind;
use crate::model::Model;
use crate::plan::{DamagePlan, DescentSettings, Plan};
use crate::schemes::descent::{Direction, TangentSolver, Trial};
use crate::schemes::fracture::block::FractureBlock;
use crate::schemes::solid::{ratio, volume_stiffness};
use crate::schemes::{State, StepError, coupling_of, flow_of, solid_of};

/// The matrix of a pass and its solver.
pub(super) struct FractureSystem<const D: usize> {
    pub linear: TangentSolver<D>,
    /// The matrix of both fields; `None` where they take turns.
    block: Option<FractureBlock>,
    /// Whether the pressure of a point is prescribed.
    pub is_fixed: Vec<bool>,
    /// Residual of the systems of both fields: smaller where passes turn out to suffer from it.
    pub forcing: f64,
    settings: DescentSettings,
}

impl<const D: usize> FractureSystem<D> {
    /// Chooses and analyses the solver once, for both fields together or for the displacement alone.
    ///
    /// # Errors
    /// [`StepError`] if it is refused.
    pub(crate) fn new(
        plan: &Plan,
        damage: &DamagePlan,
        model: &Model<D>,
        (demand, together): (&Demand, bool),
    ) -> Result<Self, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let block = together
            .then(|| FractureBlock::new(flow, solid, coupling))
            .transpose()?;
        let coordinates = model.cloud.flat_positions();
        let scale = block.as_ref().map_or(1.0, |block| block.layout.scale);
        let fixed_stress = coupling.fixed_stress.iter();
        let schur: Vec<f64> = fixed_stress.map(|b| scale * scale * b).collect();
        let plain = match &block {
            Some(block) => Problem {
                schur_diagonal: Some(&schur),
                ..Problem::new(block.matrix.view(), Symmetry::QuasiDefinite, D + 1)
            },
            None => Problem::new(solid.matrix(), Symmetry::PositiveDefinite, D),
        };
        let problem = Problem {
            solves: demand.solves,
            lags: block.is_some(),
            contrast: ratio(flow.mobility.iter().copied()).max(plan.expected_contrast()),
            volume_stiffness: volume_stiffness(solid),
            coordinates: Some(Coordinates {
                dimension: D,
                values: &coordinates,
            }),
            near_nullspace: NearNullspace::RigidModes,
            ..plain
        };
        let settings = damage.descent;
        Ok(FractureSystem {
            linear: TangentSolver::new(demand, &problem, solid, &settings)?,
            block,
            is_fixed: flow.fixed_mask(),
            forcing: settings.coupled_forcing,
            settings,
        })
    }

    /// Whether there is a matrix of both fields.
    pub(crate) fn is_coupled(&self) -> bool {
        self.block.is_some()
    }

    /// Residual of the systems of the first pass of a step, after that of the last one.
    pub(crate) fn relax(&mut self) {
        self.forcing = (10.0 * self.forcing).min(self.settings.coupled_forcing);
    }

    /// A smaller residual, but not below `least`.
    pub(crate) fn sharpen(&mut self, least: f64) {
        self.forcing = (0.1 * self.forcing).max(least);
    }

    /// Changes of displacement and pressure that balance forces and fluid as far as the tangent tells; `mass`
    /// is what points must still take up, m^D, empty where that is nothing.
    ///
    /// # Errors
    /// [`StepError`] if the solver refuses, or where fields take turns.
    pub(crate) fn solve_together(
        &mut self,
        model: &Model<D>,
        state: &State,
        (at, mass): (&Trial<D>, &[f64]),
        (dt, kind): (f64, TangentKind),
    ) -> Result<Direction, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        self.linear.follow(solid, state, at, kind)?;
        let part = "the matrix of both fields";
        let block = (self.block.as_mut()).ok_or(StepError::MissingPart { part })?;
        let tangent = &self.linear.tangent;
        let fill = || {
            let parts = (coupling, model.cracks());
            block.fill(tangent.matrix.data(), solid, flow, parts, dt);
            if let Some(cracks) = model.cracks() {
                block.add_cracks(solid, cracks, coupling, tangent, &at.response);
                block.hold_pressures(model.void_points());
            }
        };
        model.timers.time("assembly", fill);
        let (width, scale) = (D + 1, block.layout.scale);
        let mut rhs = vec![0.0; block.matrix.rows()];
        for (own, force) in rhs.chunks_mut(width).zip(at.force.chunks(D)) {
            own[..D].copy_from_slice(force);
        }
        for (own, mass) in rhs.chunks_mut(width).zip(mass) {
            own[D] = -scale * mass;
        }
        let matrix = block.matrix.view();
        let x = self.linear.solve_with(matrix, &rhs, self.forcing)?;
        let unknowns = x.chunks(width);
        Ok(Direction {
            displacement: unknowns.clone().flat_map(|own| own[..D].to_vec()).collect(),
            pressure: unknowns.map(|own| scale * own[D]).collect(),
            ..Direction::default()
        })
    }

    /// Change of the displacement alone that balances the forces as far as the tangent tells.
    ///
    /// # Errors
    /// [`StepError`] if the solver refuses.
    pub(crate) fn solve_alone(
        &mut self,
        model: &Model<D>,
        state: &State,
        at: &Trial<D>,
        kind: TangentKind,
    ) -> Result<Direction, StepError> {
        self.linear.follow(solid_of(model)?, state, at, kind)?;
        let displacement = self.linear.solve(&at.force, self.settings.solid_forcing)?;
        Ok(Direction {
            displacement,
            ..Direction::default()
        })
    }
}
