//! What the case gives the theory: one cloud, one material that is varied, the waves of its lattice.

use super::theory::{Lattice, Mode, Split};
use crate::geometry::Horizon;
use crate::plan::{FlowPlan, GeometryPlan, GradientChoice, OperatorChoice};
use crate::study::{Grid, Measured, Options, StudyCase, StudyError};

/// What the case gives the theory.
pub(super) struct Setting {
    /// The coarsest cloud.
    pub grid: Grid,
    modes: Vec<Mode>,
    /// Material whose storage (coupled) or permeability (flow alone) is varied.
    pub material: String,
    /// α²/M, 1/Pa; 0 without coupling.
    softening: f64,
    /// Largest mobility at strength or contrast 1, m²/(Pa s).
    mobility: f64,
    /// Permeability that a contrast of 1 has, m².
    pub permeability: f64,
    /// Storage at contrast 1, 1/Pa.
    storage: f64,
}

impl Setting {
    /// With the coarsest cloud, as borders are in units of its own limit.
    ///
    /// # Errors
    /// [`StudyError::Unsuited`] where the theory does not know the cloud, the horizon or the materials.
    pub(super) fn new(subject: &StudyCase, options: &Options) -> Result<Self, StudyError> {
        let grids = subject.grids(options, (30, 1000));
        Self::of(subject, grids.into_iter().next())
    }

    /// With the cloud that runs of the study had.
    ///
    /// # Errors
    /// As [`Setting::new`].
    pub(super) fn seen(subject: &StudyCase, runs: &[Measured]) -> Result<Self, StudyError> {
        let spacing = runs.first().map(|run| run.variant.value("spacing"));
        Self::of(
            subject,
            spacing.and_then(|spacing| subject.grid_within(spacing)),
        )
    }

    fn of(subject: &StudyCase, grid: Option<Grid>) -> Result<Self, StudyError> {
        let unsuited = |reason: &str| StudyError::Unsuited {
            study: "the stability study",
            case: subject.plan.case.clone(),
            reason: reason.to_owned(),
        };
        let plan = &subject.plan;
        let grid = grid.filter(|grid| grid.overrides.is_some());
        let grid = grid.ok_or_else(|| unsuited("theory knows lattices only"))?;
        let uniform: Vec<(&crate::plan::MaterialPlan, f64)> = plan
            .materials
            .iter()
            .filter_map(|material| {
                let permeability = material.permeability.as_ref()?;
                Some((material, permeability.uniform()?))
            })
            .collect();
        let most = uniform.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let least = uniform.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let (Some((material, _)), Some((_, lowest))) = (most, least) else {
            return Err(unsuited("it needs a material with one permeability"));
        };
        let coupled = subject.is_coupled();
        if coupled && plan.materials.len() != 1 {
            return Err(unsuited("the theory of coupling needs one material"));
        }
        let one = |known: Option<f64>, what: &str| {
            known.ok_or_else(|| unsuited(&format!("it needs one {what} of the material")))
        };
        let storage = one(material.storage.uniform(), "storage")?;
        let biot = material.biot_coefficient.as_ref();
        let biot = one(
            biot.map_or(Some(1.0), |own| own.uniform()),
            "biot_coefficient",
        )?;
        let elasticity = match material.elasticity.as_ref().filter(|_| coupled) {
            Some(own) => Some(
                own.uniform()
                    .ok_or_else(|| unsuited("it needs one pair of elastic moduli"))?,
            ),
            None => None,
        };
        let softening = elasticity.map_or(0.0, |elasticity| {
            biot.powi(2) / elasticity.oedometer_modulus()
        });
        let ratio = match plan.horizon {
            // The shells of the square and the cubic lattice that the default gives.
            Horizon::Neighbours(15) if plan.dimension == 2 => 5_f64.sqrt(),
            Horizon::Ratio(ratio) => ratio,
            _ => {
                return Err(unsuited(
                    "theory knows the default horizon and horizon.ratio",
                ));
            }
        };
        let lattice = Lattice {
            dimension: plan.dimension,
            ratio,
            influence: plan.influence,
            stiffness: elasticity.map_or(0.0, |e| e.lambda() / e.shear_modulus()),
            path: (plan.flow.as_ref()).is_some_and(takes_path),
        };
        let mut modes = lattice.modes();
        modes.push(longest(plan.geometry.clone(), grid.spacing));
        Ok(Setting {
            grid,
            modes,
            material: material.name.clone(),
            softening,
            mobility: lowest / plan.fluid.viscosity,
            permeability: *lowest,
            storage,
        })
    }

    /// Storage of a strength, or that of the case, 1/Pa.
    pub(super) fn storage(&self, strength: f64) -> f64 {
        match self.softening > 0.0 {
            true => self.softening / strength,
            false => self.storage,
        }
    }

    /// Strength τ for the theory: none without coupling.
    fn tau(&self, strength: f64) -> f64 {
        if self.softening > 0.0 { strength } else { 0.0 }
    }

    /// Δx² S/κ of the fastest material, s: the unit of the theory's steps.
    fn unit(&self, strength: f64) -> f64 {
        let contrast = if self.softening > 0.0 { 1.0 } else { strength };
        self.grid.spacing.powi(2) * self.storage(strength) / (self.mobility * contrast)
    }

    /// The step that the axis counts in, s: the stable one of forward Euler with storage S + α²/M.
    pub(super) fn limit(&self, strength: f64) -> f64 {
        let largest = self
            .modes
            .iter()
            .map(|mode| mode.diffusion)
            .fold(0.0, f64::max);
        2.0 * (1.0 + self.tau(strength)) / largest * self.unit(strength)
    }

    /// Smallest and largest stable step of a split, in units of the limit.
    pub(super) fn stable(&self, split: Split, strength: f64) -> (f64, f64) {
        let (from, to) = split.stable(&self.modes, self.tau(strength));
        let unit = self.unit(strength) / self.limit(strength);
        (from * unit, to * unit)
    }
}

/// Whether a uniform lattice without fractures gets the path form.
fn takes_path(flow: &FlowPlan) -> bool {
    match flow.operator {
        OperatorChoice::Path => true,
        OperatorChoice::Auto => flow.gradient == GradientChoice::Auto,
        OperatorChoice::Bond | OperatorChoice::Correspondence => false,
    }
}

/// The longest wave: half a wave along the longest side with one open end is a quarter of a wave.
fn longest(geometry: GeometryPlan, spacing: f64) -> Mode {
    let side = match geometry {
        GeometryPlan::Lattice { size, .. } => size.into_iter().fold(0.0, f64::max),
        _ => spacing,
    };
    let wave = std::f64::consts::PI / (2.0 * side);
    Mode {
        diffusion: (wave * spacing).powi(2),
        softness: 1.0,
    }
}
