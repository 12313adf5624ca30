//! The mechanical problem: K u + r w = f on the points, with moving walls w.
//!
//! A wall is one displacement component prescribed on one plane side. Walls at rest are part of the
//! mirror images; only walls that move (prescribed motion, or a rigid plate that finds its own place)
//! are degrees of freedom of their own.

use std::sync::Arc;

use nalgebra::DMatrix;
use perifrac_solvers::{CsrMatrix, CsrView, Lattice, RepeatedRows, multiply};

use crate::assembly::{
    Consistency, Pattern, PatternError, Planes, Repetition, consistent_gradient, fill_stiffness,
    matrix_bytes,
};
use crate::effects::{self, Counted, SolidContext};
use crate::geometry::{Cloud, Families, Matrix, Side, Subdomain, Vector};
use crate::operators::{
    Damage, Divergence, Elastic, ElasticForce, FamilyWidths, Lame, MirrorContinuation,
    Neighbourhood, Parity,
};
use crate::parallel;
use crate::plan::capability::{System, holds_stiffness};
use crate::plan::{MechanicsPlan, Plan};
use crate::report::Timers;

mod walls;

use super::ModelError;
use super::bands::Bands;
use super::in_situ::InSitu;
use super::interfaces::Interfaces;
use super::lattice::{lattice, repetition};
use super::properties::Properties;
use super::walls::{Drive, MovingWall, parity};

/// Operators, loads and walls of the mechanical problem.
pub struct SolidModel<const D: usize> {
    /// The elastic operator.
    pub elastic: Elastic<D>,
    /// Sparsity over points; empty where no matrix is held.
    pub points: Pattern,
    /// K over unknowns, N/m (per metre of thickness in 2-D); empty likewise.
    pub stiffness: CsrMatrix,
    /// Its rows, where they repeat.
    repeated: Option<RepeatedRows>,
    /// K u from bonds, where no matrix is held.
    pub force: Option<ElasticForce<D>>,
    /// Loads.
    pub effects: Vec<Counted>,
    /// Walls that move.
    pub walls: Vec<MovingWall>,
    /// Stiffness among the walls, N/m.
    pub wall_stiffness: DMatrix<f64>,
    /// Mass per point, kg; empty without inertia.
    pub mass: Vec<f64>,
    /// What the divergence-consistent gradient achieved, if it is used.
    pub consistency: Option<Consistency>,
    /// How often K was filled.
    pub refills: u64,
    /// Effective stress of the in-situ state per point, Pa, tension positive; empty if the plan names none. What
    /// strains adds to it.
    pub initial_stress: Vec<Matrix<D>>,
    /// Its components xx, yy, zz, xy, yz, xz per point, Pa, those across a plane included; empty likewise.
    pub initial_components: Vec<[f64; 6]>,
    /// Constant force that balances the in-situ state, shape `(n·D,)`, N; empty if the plan names none. What its
    /// stress asks of the sides, less what is prescribed there.
    pub implied: Vec<f64>,
    /// Largest in-situ stress times the surface of the domain, N: a scale of forces where all are in balance;
    /// zero without an in-situ state.
    pub in_situ_force: f64,
    /// Damage, if the plan names it; K is then that of intact rock.
    pub damage: Option<Damage<D>>,
    /// Effective widths of the families, if the strength of the rock follows from them.
    pub widths: Option<FamilyWidths<D>>,
    /// The points as a lattice whose rows repeat, or why they are none.
    pub lattice: Result<Lattice, String>,
    /// Where the time of the run goes.
    pub timers: Timers,
}

impl<const D: usize> SolidModel<D> {
    pub(super) fn build(
        plan: &Plan,
        mechanics: &MechanicsPlan,
        cloud: &Arc<Cloud<D>>,
        families: &Families<D>,
        points: &Properties,
        warnings: &mut Vec<String>,
    ) -> Result<Self, ModelError> {
        let planes: Vec<f64> = Side::all(D).map(|side| cloud.domain.plane(side)).collect();
        let extension: Vec<MirrorContinuation<D>> = (0..D)
            .map(|component| {
                let parity: Vec<Parity> = Side::all(D)
                    .map(|side| parity(&mechanics.sides[side.index()], side, component))
                    .collect();
                MirrorContinuation::new(&families.images, &parity, &planes)
            })
            .collect();
        let widths = super::damage::widths(plan, mechanics, cloud, families, points);
        let families = families.retain_images(|image| extension[0].keeps(image))?;
        let around = Neighbourhood::new(cloud.clone(), Arc::new(families), plan.influence)?;
        let around = Arc::new(around);
        let mut consistency = None;
        let mut gradient = None;
        if mechanics.corrects_gradient(cloud.irregular, cloud.domain.planes) {
            let (corrected, quality) = consistent_gradient(&around, &Planes::of(&extension))?;
            warnings.extend(super::diffusion::doubts(&quality, cloud));
            consistency = Some(quality);
            gradient = Some(corrected);
        } else if plan.damage.is_none() && around.families.severed.is_none() {
            // The faces of cracks are surfaces that column sums feel by right.
            let one_sided = Planes::of(&extension).one_sided;
            super::diffusion::judge_plain("mechanics", &around, &one_sided, warnings)?;
        }
        let lame = points.lame.clone();
        let mass = match mechanics.inertia {
            true => points
                .density
                .iter()
                .zip(&cloud.volume)
                .map(|(d, v)| d * v)
                .collect(),
            false => Vec::new(),
        };
        let interfaces = Interfaces {
            plan,
            cloud,
            families: &around.families,
            material: &points.material,
        };
        let layers = || super::laminate::build(&interfaces, &around, gradient.as_ref(), &lame);
        let laminate = (mechanics.has_layers(plan.damage.is_some()).then(layers)).flatten();
        let (laminate, weights) =
            laminate.map_or((None, None), |(own, weights)| (Some(own), weights));
        let gradient = gradient.or(weights);
        let same = |own: &Lame| [own.lambda, own.mu].map(f64::to_bits);
        let uniform = lame.windows(2).all(|pair| same(&pair[0]) == same(&pair[1]));
        let mut elastic = Elastic::new(around, gradient, extension, lame, mechanics.hourglass);
        if uniform && plan.damage.is_none() {
            elastic = elastic.with_repeated_weights();
        }
        if let Some(laminate) = laminate {
            elastic = elastic.with_layers(laminate);
        }
        Ok(SolidModel {
            elastic,
            points: Pattern {
                offsets: vec![0],
                columns: Vec::new(),
            },
            stiffness: CsrMatrix::zero((0, 0)),
            repeated: None,
            force: None,
            effects: Vec::new(),
            walls: Vec::new(),
            wall_stiffness: DMatrix::zeros(0, 0),
            mass,
            consistency,
            refills: 0,
            initial_stress: Vec::new(),
            initial_components: Vec::new(),
            implied: Vec::new(),
            in_situ_force: 0.0,
            damage: None,
            widths,
            lattice: lattice(plan, cloud, points, System::Mechanics),
            timers: Timers::default(),
        })
    }

    /// Builds the pattern, fills K, and builds loads and walls; `coupling` tells what strain does to
    /// the pores.
    pub(super) fn assemble(
        mut self,
        plan: &Plan,
        mechanics: &MechanicsPlan,
        points: &Properties,
        bands: &Bands,
        coupling: Option<&Divergence>,
        in_situ: Option<&InSitu<'_, D>>,
    ) -> Result<Self, ModelError> {
        if let Some(in_situ) = in_situ {
            let points = 0..self.elastic.points();
            self.initial_components = points.map(|point| in_situ.effective(point)).collect();
            self.initial_stress = self
                .initial_components
                .iter()
                .map(effects::tensor)
                .collect();
        }
        let (widths, prestress) = (self.widths.as_ref(), &self.initial_stress);
        self.damage = super::damage::build(plan, prestress, &self.elastic, widths, points, bands);
        match holds_stiffness(plan) {
            true => self.hold(plan, points)?,
            false => self.force = Some(ElasticForce::new(&self.elastic)),
        }
        self.effects = effects::build_solid(&SolidContext {
            plan,
            mechanics,
            elastic: &self.elastic,
            density: &points.density,
            bands: &bands.points,
        })?;
        self.build_walls(mechanics, coupling);
        Ok(self)
    }

    /// Builds the pattern of K and fills it.
    fn hold(&mut self, plan: &Plan, points: &Properties) -> Result<(), ModelError> {
        self.points = Pattern::of_families(&self.elastic.around.families, |_| true)?;
        self.stiffness = self.points.expanded(D)?.into_matrix();
        let repetition = repetition(plan, points, &self.elastic.around, &self.points);
        self.fill(repetition.as_ref());
        Ok(())
    }

    /// K over unknowns as a matrix of its own, N/m; for a model that holds none.
    ///
    /// # Errors
    /// A pattern beyond 32-bit indices.
    pub fn assembled(&self) -> Result<CsrMatrix, PatternError> {
        let points = Pattern::of_families(&self.elastic.around.families, |_| true)?;
        let mut stiffness = points.expanded(D)?.into_matrix();
        let fill = || fill_stiffness(&self.elastic, None, &points, stiffness.data_mut());
        self.timers.time("assembly", fill);
        Ok(stiffness)
    }

    /// Fills K anew into the same pattern.
    pub fn refill(&mut self) {
        self.fill(None);
    }

    /// Fills K; rows that `repetition` knows to be those of others are copied.
    fn fill(&mut self, repetition: Option<&Repetition>) {
        let (elastic, values) = (&self.elastic, self.stiffness.data_mut());
        let fill = || fill_stiffness(elastic, repetition, &self.points, values);
        self.timers.time("assembly", fill);
        self.repeated = repetition.and_then(|_| RepeatedRows::of(self.stiffness.view()));
        self.refills += 1;
    }

    /// Number of displacement unknowns.
    pub fn unknowns(&self) -> usize {
        D * self.elastic.points()
    }

    /// The rows that are stored here.
    pub fn subdomain(&self) -> &Subdomain {
        &self.elastic.around.families.share
    }

    /// K as a matrix.
    pub fn matrix(&self) -> CsrView<'_> {
        self.stiffness.view()
    }

    /// External forces at `time`, shape `(n·D,)`, N, with what balances the in-situ state; walls and pressure
    /// not included.
    pub fn loads(&self, time: f64, force: &mut [f64]) {
        force.fill(0.0);
        self.effects
            .iter()
            .for_each(|effect| effect.add_rate(time, force));
        force
            .iter_mut()
            .zip(&self.implied)
            .for_each(|(force, implied)| *force += implied);
    }

    /// Takes K u + r w off `force`, shape `(n·D,)`, N.
    pub fn subtract_internal(&self, displacement: &[f64], walls: &[f64], force: &mut [f64]) {
        match &self.force {
            Some(own) => own.subtract(&self.elastic, displacement, force),
            None => {
                let mut product = vec![0.0; displacement.len()];
                self.multiply(displacement, &mut product);
                force.iter_mut().zip(&product).for_each(|(f, p)| *f -= p);
            }
        }
        for (wall, &place) in self.walls.iter().zip(walls) {
            for &(unknown, response) in &wall.response {
                force[unknown as usize] -= response * place;
            }
        }
    }

    /// K u into `product`, shape `(n·D,)`, N; walls at rest.
    pub fn multiply(&self, displacement: &[f64], product: &mut [f64]) {
        match &self.force {
            Some(force) => force.evaluate(&self.elastic, displacement, product),
            None => {
                match &self.repeated {
                    Some(rows) => rows.multiply(displacement, product),
                    None => multiply(self.matrix(), displacement, product),
                }
                self.subdomain().complete(product, D);
            }
        }
    }

    /// Bond difference with the walls where they are, m.
    pub fn difference(
        &self,
        displacement: &[f64],
        walls: &[f64],
        owner: usize,
        bond: usize,
    ) -> Vector<D> {
        let image = self.elastic.around.families.image(bond);
        let mut value = self.elastic.difference(displacement, owner, bond);
        if image != 0 {
            for (wall, place) in self.walls.iter().zip(walls) {
                let mut unit = [0.0; 6];
                unit[wall.side.index()] = *place;
                let extension = &self.elastic.extension[wall.component];
                value[wall.component] += extension.wall_offset(image, &unit[..2 * D]);
            }
        }
        value
    }

    /// Displacement gradient per point, shape `(n,)`; rows are components. Zero at points of other
    /// processes.
    pub fn slopes(&self, displacement: &[f64], walls: &[f64]) -> Vec<Matrix<D>> {
        let at = |point| {
            let difference = |bond| self.difference(displacement, walls, point, bond);
            self.elastic.gradient_of(point, difference)
        };
        parallel::map(self.elastic.points(), at)
    }

    /// Times at which a load's slope jumps.
    pub fn breakpoints(&self) -> Vec<f64> {
        let effects = self
            .effects
            .iter()
            .flat_map(|effect| effect.effect().breakpoints());
        let walls = self.walls.iter().flat_map(|wall| match &wall.drive {
            Drive::Displacement(load) | Drive::Force(load) => load.breakpoints().to_vec(),
        });
        effects.chain(walls).collect()
    }

    /// Bytes held, by what holds them.
    pub fn bytes(&self) -> Vec<(&'static str, usize)> {
        let effects: usize = self
            .effects
            .iter()
            .map(|effect| effect.effect().bytes())
            .sum();
        let walls: usize = self
            .walls
            .iter()
            .map(|w| 16 * (w.response.len() + w.content.len()))
            .sum();
        vec![
            ("solid-bonds", self.elastic.around.bytes()),
            ("solid-operator", self.elastic.bytes()),
            (
                "solid-matrix",
                self.points.bytes()
                    + matrix_bytes(&self.stiffness)
                    + self.repeated.as_ref().map_or(0, RepeatedRows::bytes),
            ),
            (
                "solid-forces",
                self.force.as_ref().map_or(0, ElasticForce::bytes),
            ),
            ("solid-mass", 8 * self.mass.len()),
            ("damage", self.damage.as_ref().map_or(0, Damage::bytes)),
            (
                "family-widths",
                self.widths.as_ref().map_or(0, FamilyWidths::bytes),
            ),
            ("solid-effects", effects + walls),
        ]
    }
}

fn sparse(values: Vec<f64>) -> Vec<(u32, f64)> {
    (0_u32..)
        .zip(values)
        .filter(|(_, value)| *value != 0.0)
        .collect()
}
