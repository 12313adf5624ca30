//! The flow problem: S ṗ + L p = q on the points.

use std::sync::Arc;

use perifrac_solvers::CsrView;

use crate::assembly::{Consistency, Pattern, ScalarOperator, consistent_gradient};
use crate::effects::{self, Column, Context, Counted};
use crate::geometry::{Cloud, Families, Side, Vector};
use crate::operators::{
    BondConductance, Correspondence, Extension, Neighbourhood, Parity, family_gradient,
};
use crate::plan::{FlowPlan, Load, OperatorChoice, Plan, SideCondition};

use crate::report::Flows;

use super::ModelError;
use super::properties::Properties;

/// A point whose pressure is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedPressure {
    /// The point.
    pub point: usize,
    /// Index into [`FlowModel::fixed_loads`].
    pub load: usize,
}

/// Operators, coefficients and effects of the flow problem.
pub struct FlowModel<const D: usize> {
    /// The diffusion operator.
    pub operator: Box<dyn ScalarOperator<D>>,
    /// Continuation of the pressure across the sides.
    pub extension: Extension<D>,
    /// Sparsity of L.
    pub pattern: Pattern,
    /// Values of L, shape `(nonzeros,)`, m^D/(Pa s).
    pub conductance: Vec<f64>,
    /// K/μ per point, m²/(Pa s).
    pub mobility: Vec<f64>,
    /// V s per point: volume stored per pascal, m^D/Pa.
    pub capacity: Vec<f64>,
    /// Loads and sources.
    pub effects: Vec<Counted>,
    /// Points with prescribed pressure.
    pub fixed: Vec<FixedPressure>,
    /// Their pressures over time.
    pub fixed_loads: Vec<Load>,
    /// What the divergence-consistent gradient achieved, if it is used.
    pub consistency: Option<Consistency>,
    /// Initial pressure, shape `(n,)`, Pa.
    pub initial: Vec<f64>,
    /// How often L was filled.
    pub refills: u64,
    walls: Vec<Option<Load>>,
    column: Option<Column<D>>,
    outlets: Vec<u32>,
}

impl<const D: usize> FlowModel<D> {
    pub(super) fn build(
        plan: &Plan,
        flow: &FlowPlan,
        cloud: &Arc<Cloud<D>>,
        families: Families<D>,
        points: &Properties,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ModelError> {
        let parity: Vec<Parity> = flow.sides.iter().map(parity).collect();
        let one_sided: Vec<bool> = parity.iter().map(|p| *p == Parity::OneSided).collect();
        let planes: Vec<f64> = Side::all(D).map(|side| cloud.domain.plane(side)).collect();
        let extension = Extension::new(&families.images, &parity, &planes);
        let families = match one_sided.iter().any(|&o| o) {
            true => families.retain_images(|image| extension.keeps(image))?,
            false => families,
        };
        let around = Neighbourhood::new(cloud.clone(), Arc::new(families), plan.influence)?;
        let around = Arc::new(around);
        let mut consistency = None;
        let operator =
            build_operator(flow, &around, &one_sided, &mut consistency, warnings)?;
        let mobility = points.permeability.iter().map(|k| k / plan.fluid.viscosity).collect();
        let column = Column::of(plan, cloud);
        let (fixed, fixed_loads) = fixed_points(flow, cloud)?;
        let initial = cloud.position.iter().map(|x| {
            let weight = column.as_ref().filter(|_| flow.hydrostatic_start);
            flow.initial_pressure + weight.map_or(0.0, |column| column.pressure(x))
        });
        Ok(FlowModel {
            capacity: points.storage.iter().zip(&cloud.volume).map(|(s, v)| s * v).collect(),
            initial: initial.collect(),
            walls: flow.sides.iter().map(wall).collect(),
            outlets: operator.outlets(&extension),
            pattern: Pattern { offsets: vec![0], columns: Vec::new() },
            conductance: Vec::new(),
            effects: Vec::new(),
            operator,
            extension,
            mobility,
            fixed,
            fixed_loads,
            refills: 0,
            consistency,
            column,
        })
    }

    /// Builds the pattern, fills L and builds the effects.
    pub(super) fn assemble(mut self, plan: &Plan) -> Result<Self, ModelError> {
        self.pattern = self.operator.pattern()?;
        self.conductance = vec![0.0; self.pattern.nonzeros()];
        self.refill();
        let cloud = &self.operator.neighbourhood().cloud;
        let storage: Vec<f64> = self.capacity.iter().zip(&cloud.volume).map(|(c, v)| c / v).collect();
        self.effects = effects::build(&Context {
            plan,
            operator: &*self.operator,
            extension: &self.extension,
            mobility: &self.mobility,
            storage: &storage,
            column: self.column.as_ref(),
        })?;
        Ok(self)
    }

    /// Fills L anew from the current mobility, into the same pattern.
    pub fn refill(&mut self) {
        let (extension, pattern) = (&self.extension, &self.pattern);
        self.operator.fill(extension, &self.mobility, pattern, &mut self.conductance);
        self.refills += 1;
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.capacity.len()
    }

    /// L as a matrix.
    pub fn matrix(&self) -> CsrView<'_> {
        self.view(&self.conductance)
    }

    /// A matrix of the same pattern with other values, shape `(nonzeros,)`.
    pub fn view<'a>(&'a self, values: &'a [f64]) -> CsrView<'a> {
        let shape = (self.points(), self.points());
        CsrView::new(shape, &self.pattern.offsets[..], &self.pattern.columns[..], values)
    }

    /// Rate q at `time`: everything that does not depend on the pressure, shape `(n,)`, m^D/s.
    pub fn rate(&self, time: f64, rate: &mut [f64]) {
        rate.fill(0.0);
        self.effects.iter().for_each(|effect| effect.add_rate(time, rate));
    }

    /// Rates at which the boundary and the sources move fluid in the state `pressure` at `time`;
    /// what comes in at fixed points is added by [`FlowModel::fixed_inflow`].
    pub fn flows(&self, pressure: &[f64], time: f64) -> Flows {
        let injection = |effect: &Counted| effect.effect().injection(time);
        Flows {
            injected: self.effects.iter().map(injection).sum(),
            gross: self.effects.iter().map(|effect| injection(effect).abs()).sum(),
            outflow: self.outflow(pressure, time),
            fixed: 0.0,
        }
    }

    /// Rate that enters at the points of prescribed pressure, from the imbalance q − L p with the
    /// rate of storage taken off, m^D/s.
    pub fn fixed_inflow(&self, imbalance: &[f64]) -> f64 {
        self.fixed.iter().map(|fixed| -imbalance[fixed.point]).sum()
    }

    /// Whether all loads are constant in time, so that the rate needs to be evaluated once only.
    pub fn is_constant(&self) -> bool {
        self.breakpoints().is_empty() && self.effects.iter().all(|e| e.effect().is_constant())
    }

    /// Prescribed pressures of the sides at `time`; zero where none is prescribed, shape `(2D,)`.
    pub fn walls(&self, time: f64) -> Vec<f64> {
        self.walls.iter().map(|load| load.as_ref().map_or(0.0, |load| load.at(time))).collect()
    }

    /// The prescribed pressures alone, at `time`, Pa.
    pub fn prescribed(&self, time: f64) -> Vec<f64> {
        let loads = self.walls.iter().flatten().chain(&self.fixed_loads);
        loads.map(|load| load.at(time)).collect()
    }

    /// Slope of the pressure at a point, Pa/m.
    pub fn slope(&self, pressure: &[f64], time: f64, point: usize) -> Vector<D> {
        let walls = self.walls(time);
        let around = self.operator.neighbourhood();
        let families = &around.families;
        family_gradient(around, point, |bond| {
            let image = families.image(bond);
            self.extension.sign(image) * pressure[families.neighbour(bond)]
                + self.extension.wall_offset(image, &walls)
                - pressure[point]
        })
    }

    /// Bond difference that drives the flux: pressure, wall values and weight, Pa.
    fn drive<'a>(
        &'a self,
        pressure: &'a [f64],
        walls: &'a [f64],
    ) -> impl Fn(usize, usize) -> f64 + Sync + 'a {
        let around = self.operator.neighbourhood();
        let families = &around.families;
        move |owner, bond| {
            let image = families.image(bond);
            let end = self.extension.sign(image) * pressure[families.neighbour(bond)]
                + self.extension.wall_offset(image, walls);
            let weight = self.column.as_ref().map_or(0.0, |column| {
                column.difference(&around.cloud, families, &self.extension, owner, bond)
            });
            end - pressure[owner] + weight
        }
    }

    /// Rates of outflow through the sides, shape `(2D,)`, m^D/s.
    pub fn outflow(&self, pressure: &[f64], time: f64) -> Vec<f64> {
        let walls = self.walls(time);
        let drive = self.drive(pressure, &walls);
        self.operator.outflow(&self.extension, &self.outlets, &self.mobility, &drive)
    }

    /// Volume stored above zero pressure, Σ V s p, m^D.
    pub fn stored(&self, pressure: &[f64]) -> f64 {
        perifrac_solvers::dot(&self.capacity, pressure)
    }

    /// Darcy velocity −κ(∇̃p − ρ_f g) (Eq. 37), shape `(n,)`, m/s.
    pub fn velocity(&self, pressure: &[f64], time: f64) -> Vec<Vector<D>> {
        use rayon::prelude::*;
        let walls = self.walls(time);
        let drive = self.drive(pressure, &walls);
        let around = self.operator.neighbourhood();
        let at = |owner| family_gradient(around, owner, |bond| drive(owner, bond));
        (0..self.points()).into_par_iter().map(|i| at(i) * -self.mobility[i]).collect()
    }

    /// Times at which a load's slope jumps, sorted.
    pub fn breakpoints(&self) -> Vec<f64> {
        let effects = self.effects.iter().flat_map(|effect| effect.effect().breakpoints());
        let fixed = self.fixed_loads.iter().flat_map(|load| load.breakpoints().to_vec());
        let mut times: Vec<f64> = effects.chain(fixed).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Whether a side or a point has a prescribed pressure.
    pub fn is_anchored(&self) -> bool {
        !self.fixed.is_empty() || self.walls.iter().any(Option::is_some)
    }

    /// Bytes held, by what holds them.
    pub fn bytes(&self) -> Vec<(&'static str, usize)> {
        let effects: usize = self.effects.iter().map(|effect| effect.effect().bytes()).sum();
        vec![
            ("bonds", self.operator.neighbourhood().bytes()),
            ("operator", self.operator.bytes()),
            ("matrix", self.pattern.bytes() + 8 * self.conductance.len()),
            ("coefficients", 8 * (self.mobility.len() + self.capacity.len() + self.initial.len())),
            ("effects", effects),
        ]
    }
}

fn parity(side: &SideCondition) -> Parity {
    match side {
        SideCondition::Sealed => Parity::Even,
        SideCondition::Pressure { .. } => Parity::Odd,
        SideCondition::Flux(_) => Parity::OneSided,
    }
}

fn wall(side: &SideCondition) -> Option<Load> {
    match side {
        SideCondition::Pressure { value, .. } => Some(value.clone()),
        SideCondition::Sealed | SideCondition::Flux(_) => None,
    }
}

/// Share of a family's weights beyond which its correction is not trusted.
const TRUSTED: f64 = 0.5;

fn build_operator<const D: usize>(
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
        let (gradient, quality) = consistent_gradient(around, one_sided)?;
        if quality.ratio > TRUSTED {
            warnings.push(format!(
                "the divergence-consistent correction is {:.0} % of the gradient's own weights \
                 somewhere; enlarge the horizon or smooth the grading",
                100.0 * quality.ratio
            ));
        }
        *consistency = Some(quality);
        corrected = Some(gradient);
    }
    Ok(Box::new(Correspondence::new(around.clone(), flow.hourglass, corrected)))
}

/// Points of the regions with prescribed pressure; a later region wins.
fn fixed_points<const D: usize>(
    flow: &FlowPlan,
    cloud: &Cloud<D>,
) -> Result<(Vec<FixedPressure>, Vec<Load>), ModelError> {
    let mut chosen = vec![None; if flow.regions.is_empty() { 0 } else { cloud.len() }];
    for (load, region) in flow.regions.iter().enumerate() {
        let mut found = false;
        for (own, x) in chosen.iter_mut().zip(&cloud.position) {
            if region.region.contains(x.as_slice()) {
                (*own, found) = (Some(load), true);
            }
        }
        if !found {
            return Err(ModelError::EmptyPressureRegion { number: load + 1 });
        }
    }
    let points = chosen.into_iter().enumerate();
    let fixed = points.filter_map(|(point, load)| load.map(|load| FixedPressure { point, load }));
    Ok((fixed.collect(), flow.regions.iter().map(|region| region.pressure.clone()).collect()))
}
