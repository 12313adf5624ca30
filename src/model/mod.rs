//! The model: a plan made concrete on a cloud. Pattern once, values as often as needed.

mod bands;
mod between;
mod cavitation;
mod cloud;
mod coefficients;
mod coupling;
mod crack_flow;
mod damage;
mod darcy;
mod diffusion;
mod disc;
mod error;
mod fields;
mod filling;
mod fit;
mod fixed;
mod flow;
mod fracture_flow;
mod in_situ;
mod interfaces;
mod laminate;
mod lattice;
mod level;
mod operator_choice;
mod places;
mod properties;
mod response;
mod rounding;
mod sample;
mod scaled_mass;
mod solid;
mod stabilisation;
mod varying;
mod walls;
mod wells;

use std::sync::Arc;

use perifrac_solvers::Communicator;

pub use bands::Bands;
pub use cavitation::Voids;
pub use cloud::{build_cloud, build_families, cut_cracks};
pub use coefficients::Coefficients;
pub use coupling::{Audit, Coupling};
pub use crack_flow::{CrackFlow, DRY, Spreading};
pub use disc::Disc;
pub use error::ModelError;
pub use filling::Filling;
pub use fixed::FixedPressure;
pub use flow::{FlowModel, exchange};
pub use fracture_flow::FractureFlow;
pub use laminate::LAYERED;
pub use operator_choice::{ChosenOperator, Form};
pub use places::{Faces, Places, crack_parts};
#[cfg(feature = "study")]
pub(crate) use properties::material_at;
pub use response::Fields;
pub use sample::{CoupledSample, FlowSample, PointLimit, Rock, Sample, SolidSample, sample};
pub use scaled_mass::{SHARE, undrained_modulus};
pub use solid::SolidModel;
pub use varying::VaryingProperty;
pub use walls::{Drive, MovingWall, driven_walls};
pub use wells::{Control, Well, WellNow, Wells};

use in_situ::InSitu;
use scaled_mass::scaled_mass;

use crate::effects::injection_shares;
use crate::geometry::{Cloud, Families, Horizon, Subdomain, Vector, horizons};
use crate::plan::capability::scales_mass;
use crate::plan::{CrackPlan, Plan, damage_width, manufactured, ratio_warning, width_warning};
use crate::reference::ExactPressure;
use crate::report::Timers;

/// Everything a scheme needs, the same throughout a run. A part that the plan does not name is absent.
///
/// Where rock that breaks conducts fluid the coefficients of flow belong to the state, and
/// [`Model::with`] gives the model at a state; such clones share all that does not depend on them.
///
/// ```
/// use perifrac::prelude::*;
///
/// # let scene = r#"
/// #     title = "A square that drains to the left"
/// #     geometry = { type = "lattice", size = ["1 m", "1 m"], points = [10, 10] }
/// #     fluid.viscosity = "1 mPa s"
/// #     materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
/// #     flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
/// #     time.end = "1 s"
/// # "#;
/// let model = Model::<2>::of(&Setup::text(scene).plan()?)?;
/// assert_eq!(model.cloud.len(), 100);
/// assert!((model.cloud.volume.iter().sum::<f64>() - 1.0).abs() < 1e-12);
/// assert!(model.flow.is_some() && model.solid.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Model<const D: usize> {
    /// The points.
    pub cloud: Arc<Cloud<D>>,
    /// Index into the plan's materials per point, shape `(n,)`.
    pub material: Vec<u16>,
    /// Permeability per point, m², shape `(n,)`; empty without flow.
    pub permeability: Vec<f64>,
    /// Other properties of the rock that vary from point to point.
    pub varying: Arc<Vec<VaryingProperty>>,
    /// The flow problem.
    pub flow: Option<FlowModel<D>>,
    /// The mechanical problem.
    pub solid: Option<Arc<SolidModel<D>>>,
    /// What couples the two.
    pub coupling: Option<Coupling>,
    /// How flow changes where rock breaks.
    pub fracture_flow: Option<FractureFlow<D>>,
    /// Points where fluid is pumped into each crack, with their shares; none where it is not.
    pub injections: Arc<Vec<Vec<(u32, f64)>>>,
    /// Where values between points are wanted.
    pub places: Arc<Places<D>>,
    /// Points of cracks that are damaged from the start.
    pub bands: Arc<Bands>,
    /// Largest pressure or stress that the data name, Pa: what rounding is relative to.
    pub level: f64,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// Where the time of the run goes.
    pub timers: Timers,
}

impl<const D: usize> Model<D> {
    /// The model of a plan, without a record of the time it takes.
    ///
    /// # Errors
    /// As [`Model::build`].
    pub fn of(plan: &Plan) -> Result<Self, ModelError> {
        Self::build(plan, &mut Timers::default())
    }

    /// Builds cloud, families, operators and effects that the plan names.
    ///
    /// # Errors
    /// [`ModelError`], which says what in the plan does not fit.
    pub fn build(plan: &Plan, timers: &mut Timers) -> Result<Self, ModelError> {
        Self::build_with(plan, None, timers)
    }

    /// As [`Model::build`], but if there is a team with the bonds and matrix rows of this process only.
    ///
    /// # Errors
    /// As [`Model::build`].
    pub fn build_with(
        plan: &Plan,
        team: Option<&Arc<dyn Communicator>>,
        timers: &mut Timers,
    ) -> Result<Self, ModelError> {
        if plan.flow.is_none() && plan.mechanics.is_none() {
            return Err(ModelError::NothingToDo);
        }
        fit::check_effects(plan)?;
        let (cloud, table) = timers.time("cloud", || build_cloud::<D>(plan))?;
        fit::check(plan, &cloud)?;
        let cloud = Arc::new(cloud);
        // In parts of a cloud the families that places need are found with it.
        let mut places = match team {
            Some(_) => Some(Places::find(
                plan,
                &cloud,
                &horizons(&cloud, plan.horizon)?,
            )?),
            None => None,
        };
        // Only the leading process writes values between points.
        let leads = team.is_none_or(|team| team.rank() == 0);
        let watched = places
            .as_ref()
            .map_or_else(Vec::new, |places| places.points(leads));
        let families = timers.time("families", || build_families(plan, &cloud, team, &watched))?;
        let places = match places.take() {
            Some(places) => places,
            None => Places::find(plan, &cloud, &families.horizon)?,
        };
        let points = properties::assign(plan, &cloud, table)?;
        let varying = VaryingProperty::of(&points, plan.flow.is_some());
        let in_situ = InSitu::of(plan, &cloud, &points)?;
        let bands = Bands::find(plan, &cloud)?;
        fit::check_bands(plan, &bands)?;
        let mut warnings = Vec::new();
        warnings.extend(doubtful_widths(plan, &cloud, &families));
        let coupling = plan.coupling.map(|_| Coupling::new(plan, &cloud, &points));
        let mut solid = build_solid(
            plan,
            &cloud,
            &families,
            (&points, &bands),
            (coupling.as_ref(), in_situ.as_ref()),
            &mut warnings,
            timers,
        )?;
        let flow = build_flow(
            plan,
            &cloud,
            families,
            (&points, &bands),
            coupling.as_ref(),
            &mut warnings,
            timers,
        )?;
        if let (true, Some(solid), Some(coupling), Some(flow)) =
            (scales_mass(plan), &mut solid, &coupling, &flow)
        {
            solid.mass = scaled_mass(&cloud, solid, coupling, flow);
        }
        let fracture_flow =
            FractureFlow::of(plan, flow.as_ref(), coupling.as_ref(), &points.permeability);
        let injections = injections(plan, flow.as_ref(), &bands);
        let mut model = Model {
            level: level::level(plan, flow.as_ref()),
            fracture_flow,
            injections: Arc::new(injections),
            cloud,
            material: points.material,
            permeability: points.permeability,
            varying: Arc::new(varying),
            flow,
            solid: solid.map(Arc::new),
            coupling,
            places: Arc::new(places),
            bands: Arc::new(bands),
            warnings,
            timers: timers.clone(),
        };
        if let Some(in_situ) = &in_situ {
            in_situ::balance(plan, in_situ, &mut model)?;
        }
        Ok(model)
    }

    /// The rows and families that are stored here.
    pub fn subdomain(&self) -> &Subdomain {
        match (&self.flow, &self.solid) {
            (Some(flow), _) => flow.subdomain(),
            (None, Some(solid)) => solid.subdomain(),
            (None, None) => &Subdomain::WHOLE,
        }
    }

    /// Mean pressure where fluid is pumped into a crack, Pa.
    pub fn injection_pressure(&self, crack: usize, pressure: &[f64]) -> Option<f64> {
        let share = self
            .injections
            .get(crack)
            .filter(|share| !share.is_empty())?;
        Some(
            share
                .iter()
                .map(|&(point, share)| share * pressure[point as usize])
                .sum(),
        )
    }

    /// Times at which a load's slope jumps, sorted.
    pub fn breakpoints(&self) -> Vec<f64> {
        let flow = self.flow.iter().flat_map(FlowModel::breakpoints);
        let solid = self.solid.iter().flat_map(|solid| solid.breakpoints());
        let mut times: Vec<f64> = flow.chain(solid).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Bytes held, by what holds them.
    pub fn bytes(&self) -> Vec<(&'static str, usize)> {
        let flow = self.flow.iter().flat_map(FlowModel::bytes);
        let solid = self.solid.iter().flat_map(|solid| solid.bytes());
        let coupling = self.coupling.iter().map(|c| ("coupling", c.bytes()));
        let cracks = self
            .fracture_flow
            .iter()
            .map(|f| ("fracture-flow", f.bytes()));
        flow.chain(solid).chain(coupling).chain(cracks).collect()
    }
}

/// Warnings where the smallest horizon makes cracks cost something else than their fracture energy.
fn doubtful_widths<const D: usize>(
    plan: &Plan,
    cloud: &Cloud<D>,
    families: &Families<D>,
) -> Vec<String> {
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let horizon = least(&mut families.horizon.iter().copied());
    let spacing = least(&mut (0..cloud.len()).map(|point| cloud.spacing(point)));
    width_doubts(plan, cloud.irregular, horizon, spacing)
}

/// Doubts about what cracks take where the smallest horizon is `horizon` and the smallest spacing
/// `spacing`, m. On an irregular cloud their ratio tells of families only where it is prescribed.
pub fn width_doubts(plan: &Plan, irregular: bool, horizon: f64, spacing: f64) -> Vec<String> {
    let Some(damage) = &plan.damage else {
        return Vec::new();
    };
    let told = !irregular || matches!(plan.horizon, Horizon::Ratio(_));
    let ratio = told.then(|| ratio_warning(horizon / spacing)).flatten();
    let width = width_warning(damage_width(horizon, damage), damage);
    width.into_iter().chain(ratio).collect()
}

fn injections<const D: usize>(
    plan: &Plan,
    flow: Option<&FlowModel<D>>,
    bands: &Bands,
) -> Vec<Vec<(u32, f64)>> {
    let shares = |(crack, band): (&CrackPlan, &Vec<u32>)| {
        let (injection, flow) = (crack.injection.as_ref()?, flow?);
        let at = crate::effects::vector(&injection.at);
        Some(injection_shares(flow.operator.neighbourhood(), &at, band))
    };
    let cracks = plan.cracks.iter().zip(&bands.points);
    cracks
        .map(|crack| shares(crack).unwrap_or_default())
        .collect()
}

fn build_flow<const D: usize>(
    plan: &Plan,
    cloud: &Arc<Cloud<D>>,
    families: Families<D>,
    (points, bands): (&properties::Properties, &Bands),
    coupling: Option<&Coupling>,
    warnings: &mut Vec<String>,
    timers: &mut Timers,
) -> Result<Option<FlowModel<D>>, ModelError> {
    let Some(flow) = &plan.flow else {
        return Ok(None);
    };
    let mut flow = timers.time("operators", || {
        FlowModel::build(plan, flow, cloud, families, (points, bands), warnings)
    })?;
    flow.timers = timers.clone();
    let mut flow = timers.time("assembly", || {
        flow.assemble(plan, (points, bands), coupling)
    })?;
    if let Ok(Some(solution)) = manufactured(plan) {
        let exact = |x: &Vector<D>| solution.pressure(x.as_slice(), 0.0);
        flow.initial = cloud.position.iter().map(exact).collect();
    }
    Ok(Some(flow))
}

fn build_solid<const D: usize>(
    plan: &Plan,
    cloud: &Arc<Cloud<D>>,
    families: &Families<D>,
    (points, bands): (&properties::Properties, &Bands),
    (coupling, in_situ): (Option<&Coupling>, Option<&InSitu<'_, D>>),
    warnings: &mut Vec<String>,
    timers: &mut Timers,
) -> Result<Option<SolidModel<D>>, ModelError> {
    let Some(mechanics) = &plan.mechanics else {
        return Ok(None);
    };
    let mut solid = timers.time("operators", || {
        SolidModel::build(plan, mechanics, cloud, families, points, warnings)
    })?;
    solid.timers = timers.clone();
    let divergence = coupling.map(|coupling| &coupling.divergence);
    let solid = timers.time("assembly", || {
        solid.assemble(plan, mechanics, points, bands, divergence, in_situ)
    })?;
    Ok(Some(solid))
}
