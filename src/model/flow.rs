//! The flow problem: S ṗ + L p = q on the points.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use perifrac_solvers::{CsrView, Lattice};

use crate::assembly::{Consistency, Pattern, Refill, ScalarOperator};
use crate::boundary::{self, BoundaryPlane};
use crate::effects::{self, Column, Context, Counted};
use crate::geometry::{Cloud, Families, Subdomain, Term, Vector};
use crate::operators::MirrorContinuation;
use crate::parallel;
use crate::plan::capability::System;
use crate::plan::{FlowPlan, Load, Plan, SideCondition};

use crate::report::{Flows, Timers};

use super::bands::Bands;
use super::diffusion::{CrackBonds, operator};
use super::fixed::{FixedPressure, fixed_points};
use super::lattice::lattice;
use super::operator_choice::ChosenOperator;
use super::properties::Properties;
use super::stabilisation::Stabilisation;
use super::wells::{Control, Wells};
use super::{Coupling, ModelError};

/// Operators, coefficients and effects of the flow problem. Clones share what does not depend on the
/// coefficients.
#[derive(Clone)]
pub struct FlowModel<const D: usize> {
    /// The diffusion operator.
    pub operator: Arc<dyn ScalarOperator<D>>,
    /// Continuation of the pressure across the sides.
    pub extension: MirrorContinuation<D>,
    /// Sparsity of L.
    pub pattern: Arc<Pattern>,
    /// Values of L, shape `(nonzeros,)`, m^D/(Pa s).
    pub conductance: Vec<f64>,
    /// Values of the stabilising storage in the same pattern, m^D/Pa; empty without one.
    pub stabilisation: Vec<f64>,
    /// K/μ per point, m²/(Pa s).
    pub mobility: Vec<f64>,
    /// V s per point: volume stored per pascal, m^D/Pa.
    pub capacity: Vec<f64>,
    /// Loads and sources.
    pub effects: Arc<Vec<Counted>>,
    /// Points with prescribed pressure.
    pub fixed: Vec<FixedPressure>,
    /// Their pressures over time.
    pub fixed_loads: Vec<Load>,
    /// What the divergence-consistent gradient achieved, if it is used.
    pub consistency: Option<Consistency>,
    /// Along which fluid moves in cracks that hold fluid of their own.
    pub(super) crack_bonds: Option<CrackBonds<D>>,
    /// Initial pressure, shape `(n,)`, Pa.
    pub initial: Vec<f64>,
    /// Wells whose bottom-hole pressure is known.
    pub wells: Arc<Wells>,
    /// What they are held at; L belongs to it. Set by [`FlowModel::set_controls`].
    pub controls: Vec<Control>,
    /// Sides of prescribed pressure.
    pub walls: Vec<BoundaryPlane>,
    /// Prescribed flux into the domain per side, m/s.
    pub(super) fluxes: Vec<Option<Load>>,
    /// The points as a lattice whose rows repeat, or why they are none.
    pub lattice: Arc<Result<Lattice, String>>,
    /// Where the time of the run goes.
    pub timers: Timers,
    column: Option<Column<D>>,
    refill_plan: Arc<Refill>,
    /// How often L was filled, by all clones.
    refills: Arc<AtomicU64>,
}

impl<const D: usize> FlowModel<D> {
    pub(super) fn build(
        plan: &Plan,
        flow: &FlowPlan,
        cloud: &Arc<Cloud<D>>,
        families: Families<D>,
        (points, bands): (&Properties, &Bands),
        warnings: &mut Vec<String>,
    ) -> Result<Self, ModelError> {
        let chosen = ChosenOperator::of(plan, flow, &points.permeability, cloud.irregular);
        warnings.extend(chosen.doubt);
        let points_and_families = (cloud, points, families);
        let built = operator(plan, flow, chosen.form, points_and_families, warnings)?;
        let mobility = points
            .permeability
            .iter()
            .map(|k| k / plan.fluid.viscosity)
            .collect();
        let column = Column::of(plan, cloud);
        let (fixed, fixed_loads) = fixed_points(plan, flow, cloud, bands)?;
        let initial = cloud.position.iter().map(|x| {
            let weight = column.as_ref().filter(|_| flow.hydrostatic_start);
            flow.initial_pressure
                + weight.map_or(0.0, |column| column.pressure_below(flow.datum, x))
        });
        Ok(FlowModel {
            lattice: Arc::new(lattice(plan, cloud, points, System::Flow)),
            capacity: points
                .storage
                .iter()
                .zip(&built.operator.neighbourhood().cloud.volume)
                .map(|(s, v)| s * v)
                .collect(),
            fluxes: flow.sides.iter().map(flux).collect(),
            initial: initial.collect(),
            wells: Arc::default(),
            controls: Vec::new(),
            walls: Vec::new(),
            refill_plan: Arc::default(),
            pattern: Arc::new(Pattern {
                offsets: vec![0],
                columns: Vec::new(),
            }),
            conductance: Vec::new(),
            stabilisation: Vec::new(),
            effects: Arc::default(),
            operator: built.operator,
            extension: built.extension,
            mobility,
            fixed,
            fixed_loads,
            refills: Arc::default(),
            consistency: built.consistency,
            crack_bonds: built.crack_bonds,
            timers: Timers::default(),
            column,
        })
    }

    /// Builds the pattern, fills L and builds the effects.
    pub(super) fn assemble(
        mut self,
        plan: &Plan,
        (points, bands): (&Properties, &Bands),
        coupling: Option<&Coupling>,
    ) -> Result<Self, ModelError> {
        let mut pattern = self.operator.pattern()?;
        let strength = plan.coupling.map_or(0.0, |coupling| coupling.stabilisation);
        if let Some(coupling) = coupling.filter(|_| strength > 0.0) {
            let term = Stabilisation::new(self.operator.neighbourhood(), coupling, strength);
            pattern = pattern.union(&term.pattern()?)?;
            self.stabilisation = term.values(&pattern);
        }
        if let Some(bonds) = &self.crack_bonds {
            let families = &bonds.around.families;
            pattern = pattern.union(&Pattern::of_families(families, |_| false)?)?;
        }
        let spreads = effects::known_wells(&self.context(plan, bands))?;
        pattern = Self::with_wells(pattern, &spreads, &plan.wells)?;
        self.conductance = vec![0.0; pattern.nonzeros()];
        self.refill_plan = Arc::new(self.operator.refill_plan(&self.extension, &pattern));
        self.pattern = Arc::new(pattern);
        self.refill();
        let wells = self.wells(&self.context(plan, bands), spreads, &points.tensor)?;
        self.controls = vec![Control::Given; wells.iter().len()];
        self.wells = Arc::new(wells);
        self.enter_wells();
        self.effects = Arc::new(effects::build(&self.context(plan, bands))?);
        self.walls = boundary::walls(
            plan,
            &*self.operator,
            &self.extension,
            &self.mobility,
            self.column.as_ref(),
        );
        Ok(self)
    }

    /// What effects look at while they are built.
    fn context<'a>(&'a self, plan: &'a Plan, bands: &'a Bands) -> Context<'a, D> {
        Context {
            plan,
            operator: &*self.operator,
            extension: &self.extension,
            mobility: &self.mobility,
            column: self.column.as_ref(),
            bands: &bands.points,
        }
    }

    /// Values of L at a mobility (shape `(n,)`), without wells, into `values` (shape `(nonzeros,)`).
    pub(super) fn fill_with(&self, mobility: &[f64], values: &mut [f64]) {
        let plan = &self.refill_plan;
        self.operator
            .fill(&self.extension, mobility, &self.pattern, plan, values);
    }

    /// Fills L anew from the current mobility, into the same pattern. Where L follows what breaks no well holds a pressure.
    pub fn refill(&mut self) {
        let (timers, values) = (self.timers.clone(), &mut self.conductance);
        timers.time("assembly", || {
            self.operator.fill(
                &self.extension,
                &self.mobility,
                &self.pattern,
                &self.refill_plan,
                values,
            );
        });
        self.refills.fetch_add(1, Ordering::Relaxed);
    }

    /// Adds conductances between pairs of points (m^D/(Pa s)) to L.
    pub fn add_conductances(&mut self, pairs: impl Iterator<Item = (usize, usize, f64)>) {
        let pattern = &self.pattern;
        for (one, other, value) in pairs {
            for (row, column) in [(one, other), (other, one)] {
                if let Some(place) = pattern.find(row, column) {
                    self.conductance[place] -= value;
                    self.conductance[pattern.diagonal(row)] += value;
                }
            }
        }
    }

    /// How often L was filled, by this model and those it shares its parts with.
    pub fn refills(&self) -> u64 {
        self.refills.load(Ordering::Relaxed)
    }

    /// Brings the sides of prescribed pressure to the current mobility.
    pub fn follow_walls(&mut self) {
        for wall in &mut self.walls {
            wall.follow(&*self.operator, &self.extension, &self.mobility);
        }
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
        CsrView::new(
            shape,
            &self.pattern.offsets[..],
            &self.pattern.columns[..],
            values,
        )
    }

    /// Rate of the effects at `time`, shape `(n,)`, m^D/s; sides of prescribed pressure and wells that are held at one not
    /// included.
    pub fn rate(&self, time: f64, rate: &mut [f64]) {
        rate.fill(0.0);
        self.effects
            .iter()
            .for_each(|effect| effect.add_rate(time, rate));
        self.wells.add_rate(&self.controls, time, rate);
    }

    /// Imbalance q − L p at `time`, shape `(n,)`, m^D/s: what storage takes up.
    pub fn imbalance(&self, time: f64, pressure: &[f64], imbalance: &mut [f64]) {
        self.timers.time("flow", || {
            self.sources(time, pressure, imbalance);
            self.subtract_exchange(pressure, imbalance);
        });
    }

    /// What loads, sides and wells bring to every point, m^D/s, into `rate` of shape `(n,)`.
    pub fn sources(&self, time: f64, pressure: &[f64], rate: &mut [f64]) {
        self.rate(time, rate);
        self.walls
            .iter()
            .for_each(|wall| wall.add_rate(time, pressure, rate));
        self.add_well_inflow(time, pressure, rate);
    }

    /// Takes Σ_j L_ij (p_j − p_i) off every entry: the exchange between points.
    ///
    /// Written with differences, what leaves one point enters the other to the last bit, and large
    /// conductances do not amplify the rounding errors of large pressures.
    pub fn subtract_exchange(&self, pressure: &[f64], result: &mut [f64]) {
        let (pattern, conductance) = (&self.pattern, &self.conductance);
        parallel::each(result, 1024, |row, result| {
            *result -= exchange(pattern, conductance, pressure, row);
        });
        self.subdomain().complete(result, 1);
    }

    /// The rows that are stored here.
    pub fn subdomain(&self) -> &Subdomain {
        &self.operator.neighbourhood().families.share
    }

    /// Σ_j |L_ij|, about twice what a point exchanges for every pascal, m^D/(Pa s).
    pub fn exchange_rate(&self, point: usize) -> f64 {
        let row = &self.conductance[self.pattern.row(point)];
        row.iter().map(|value| value.abs()).sum()
    }

    /// Takes what the stabilising storage holds at `pressure` off every entry, m^D.
    pub fn subtract_stabilisation(&self, pressure: &[f64], result: &mut [f64]) {
        if self.stabilisation.is_empty() {
            return;
        }
        let (pattern, values) = (&self.pattern, &self.stabilisation);
        parallel::each(result, 1024, |row, result| {
            *result -= exchange(pattern, values, pressure, row);
        });
        self.subdomain().complete(result, 1);
    }

    /// Rates at which the boundary and the sources move fluid in the state `pressure` at `time`;
    /// what comes in at fixed points is added by [`FlowModel::add_fixed_inflow`].
    pub fn flows(&self, pressure: &[f64], time: f64) -> Flows {
        let effects = self.effects.iter().map(Counted::effect);
        let mut flows = Flows {
            injected: effects.clone().map(|effect| effect.injection(time)).sum(),
            gross: effects.map(|effect| effect.gross(time)).sum(),
            outflow: vec![0.0; 2 * D],
            fixed: 0.0,
            held: vec![0.0; self.fixed_loads.len()],
        };
        for wall in &self.walls {
            let (net, gross) = wall.outflow(time, pressure);
            flows.outflow[wall.side.index()] = net;
            flows.gross += gross;
        }
        self.wells
            .add_flows(&self.controls, time, pressure, &mut flows);
        flows
    }

    /// Conductance of every point to the sides of prescribed pressure and to wells that are held at one, its row sum of L,
    /// shape `(n,)`.
    pub fn leak(&self) -> Vec<f64> {
        let mut leak = vec![0.0; self.points()];
        self.walls.iter().for_each(|wall| wall.add_leak(&mut leak));
        self.wells.add_leak(&self.controls, &mut leak);
        leak
    }

    /// Whether all loads are constant in time, so that the rate needs to be evaluated once only.
    pub fn is_constant(&self) -> bool {
        // Limits may change what a well is held at.
        let steady = self.breakpoints().is_empty() && self.wells.loads().next().is_none();
        steady && self.effects.iter().all(|e| e.effect().is_constant())
    }

    /// Prescribed pressures of the sides at `time`; zero where none is prescribed, shape `(2D,)`.
    pub(super) fn wall_values(&self, time: f64) -> Vec<f64> {
        let mut values = vec![0.0; 2 * D];
        for wall in &self.walls {
            values[wall.side.index()] = wall.pressure.at(time);
        }
        values
    }

    /// The prescribed pressures alone, at `time`, Pa.
    pub fn prescribed(&self, time: f64) -> Vec<f64> {
        let loads = self
            .walls
            .iter()
            .map(|wall| &wall.pressure)
            .chain(&self.fixed_loads);
        loads.map(|load| load.at(time)).collect()
    }

    /// Weight of the fluid per volume, ρ_f g, Pa/m; zero without gravity.
    pub(super) fn weight(&self) -> Vector<D> {
        let column = self.column.as_ref();
        column.map_or_else(Vector::zeros, |column| column.weight)
    }

    /// Pressure at the place `at` that an image has where the field of its real point is `own` at the
    /// mirrored place, Pa.
    pub(super) fn image_value(
        &self,
        term: &Term<D>,
        own: f64,
        at: &Vector<D>,
        walls: &[f64],
    ) -> f64 {
        let image = term.image;
        if image == 0 {
            return own;
        }
        let mirrored = self.operator.neighbourhood().cloud.position[term.point] + term.arm;
        let column = self.column.as_ref();
        let weight = column.map_or(0.0, |column| {
            column.on_image(&self.extension, image, &mirrored) + column.weight.dot(at)
        });
        self.extension.sign(image) * own + self.extension.wall_offset(image, walls) + weight
    }

    /// Bond difference that drives the flux: pressure, wall values and weight, Pa.
    pub(super) fn drive<'a>(
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
        self.flows(pressure, time).outflow
    }

    /// Volume stored above zero pressure, Σ V s p, m^D.
    pub fn stored(&self, pressure: &[f64]) -> f64 {
        perifrac_solvers::dot(&self.capacity, pressure)
    }

    /// Times at which a load's slope jumps, sorted.
    pub fn breakpoints(&self) -> Vec<f64> {
        let effects = self
            .effects
            .iter()
            .flat_map(|effect| effect.effect().breakpoints());
        let walls = self.walls.iter().map(|wall| &wall.pressure);
        let loads = walls
            .chain(&self.fixed_loads)
            .chain(self.wells.loads())
            .flat_map(|load| load.breakpoints().to_vec());
        let mut times: Vec<f64> = effects.chain(loads).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        times
    }

    /// Bytes held, by what holds them.
    pub fn bytes(&self) -> Vec<(&'static str, usize)> {
        let effects: usize = self
            .effects
            .iter()
            .map(|effect| effect.effect().bytes())
            .sum();
        let walls: usize = self.walls.iter().map(BoundaryPlane::bytes).sum();
        let mut bytes = vec![
            ("bonds", self.operator.neighbourhood().bytes()),
            ("operator", self.operator.bytes()),
            (
                "matrix",
                self.pattern.bytes()
                    + self.refill_plan.bytes()
                    + 8 * (self.conductance.len() + self.stabilisation.len()),
            ),
            (
                "coefficients",
                8 * (self.mobility.len() + self.capacity.len() + self.initial.len()),
            ),
            ("effects", effects + walls),
        ];
        if !self.wells.is_empty() {
            bytes.push(("wells", self.wells.bytes()));
        }
        bytes
    }
}

fn flux(side: &SideCondition) -> Option<Load> {
    match side {
        SideCondition::Flux(flux) => Some(flux.clone()),
        _ => None,
    }
}

/// Σ_j L_ij (p_j − p_i) of one row.
#[inline]
pub fn exchange(pattern: &Pattern, conductance: &[f64], pressure: &[f64], row: usize) -> f64 {
    let range = pattern.row(row);
    let own = pressure[row];
    let entries = conductance[range.clone()]
        .iter()
        .zip(&pattern.columns[range]);
    entries
        .map(|(value, &column)| value * (pressure[column as usize] - own))
        .sum()
}
