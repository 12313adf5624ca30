//! Linear systems of the solver benches: flow, elasticity and both together on a unit square, intact,
//! with a crack band across its middle, or with a large contrast between its halves.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use perifrac::model::{FlowModel, Model, SolidModel};
use perifrac::plan::{Plan, resolve};
use perifrac::report::Timers;
use perifrac::scene;
use perifrac::schemes::BlockMatrix;
use perifrac_solvers::{Coordinates, CsrMatrix, NearNullspace, Problem, Symmetry};

/// Which equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Physics {
    /// Steady flow, correspondence form; on this lattice it reaches one hop.
    Flow,
    /// The same with a weaker hourglass term, which keeps the second hop.
    TwoHops,
    /// Steady flow, bond form.
    Bond,
    /// Linear elasticity, plane strain.
    Elasticity,
    /// Displacement and pressure in one matrix.
    Monolithic,
}

impl Physics {
    const ALL: [Physics; 5] = [
        Physics::Flow,
        Physics::TwoHops,
        Physics::Bond,
        Physics::Elasticity,
        Physics::Monolithic,
    ];

    /// Name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Physics::Flow => "flow",
            Physics::TwoHops => "flow-two-hops",
            Physics::Bond => "flow-bond",
            Physics::Elasticity => "elasticity",
            Physics::Monolithic => "monolithic",
        }
    }

    /// The physics of a name.
    pub fn parse(name: &str) -> Result<Self> {
        let found = Self::ALL.into_iter().find(|physics| physics.name() == name);
        found.with_context(|| format!("no physics {name}"))
    }
}

/// What the rock looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rock {
    /// One material.
    Intact,
    /// A band of 1 % of the points with the stiffness times this factor. The permeability is
    /// multiplied by it in systems of flow alone, and by 100 in coupled ones.
    Crack(f64),
    /// The right half is so many times as permeable (flow) or stiff (elasticity) as the left one.
    Contrast(f64),
}

impl Rock {
    /// Name in tables.
    pub fn name(self) -> String {
        match self {
            Rock::Intact => "intact".to_owned(),
            Rock::Crack(factor) => format!("crack {factor:.0e}"),
            Rock::Contrast(factor) => format!("contrast {factor:.0e}"),
        }
    }
}

impl Rock {
    /// As an argument of a process.
    pub fn text(self) -> String {
        match self {
            Rock::Intact => "intact".to_owned(),
            Rock::Crack(factor) => format!("crack={factor:e}"),
            Rock::Contrast(factor) => format!("contrast={factor:e}"),
        }
    }

    /// From [`Rock::text`].
    pub fn parse(text: &str) -> Result<Self> {
        match text.split_once('=') {
            Some(("crack", factor)) => Ok(Rock::Crack(factor.parse()?)),
            Some(("contrast", factor)) => Ok(Rock::Contrast(factor.parse()?)),
            _ => Ok(Rock::Intact),
        }
    }
}

/// A matrix with all that a solver may know of it.
pub struct LinearSystem {
    /// The matrix.
    pub matrix: CsrMatrix,
    symmetry: Symmetry,
    coordinates: Vec<f64>,
    unknowns_per_point: usize,
    schur_diagonal: Option<Vec<f64>>,
    /// The solid, if its crack may grow.
    solid: Option<SolidModel<2>>,
}

impl LinearSystem {
    /// Builds the system of `physics` in `rock` with `cells` points along each side. Only if it grows
    /// does it keep the solid beside the matrix.
    pub fn new(physics: Physics, rock: Rock, cells: usize, grows: bool) -> Result<Self> {
        let model = model(physics, rock, cells)?;
        let coordinates = model.cloud.flat_positions();
        let system = |matrix, symmetry, unknowns_per_point, schur_diagonal| LinearSystem {
            matrix,
            symmetry,
            coordinates,
            unknowns_per_point,
            schur_diagonal,
            solid: None,
        };
        match physics {
            Physics::Elasticity => {
                let solid = model.solid.and_then(std::sync::Arc::into_inner);
                let solid = solid.context("a solid of its own")?;
                if !grows {
                    let matrix = solid.stiffness.clone();
                    return Ok(system(matrix, Symmetry::PositiveDefinite, 2, None));
                }
                let matrix = solid.stiffness.clone();
                let own = system(matrix, Symmetry::PositiveDefinite, 2, None);
                Ok(LinearSystem {
                    solid: Some(solid),
                    ..own
                })
            }
            Physics::Monolithic => {
                let mut block = BlockMatrix::new(&model)?;
                block.fill(model.flow.as_ref().context("flow")?, STEP);
                let schur = Some(block.schur_diagonal);
                Ok(system(block.matrix, Symmetry::QuasiDefinite, 3, schur))
            }
            Physics::Flow | Physics::TwoHops | Physics::Bond => {
                let matrix = steady(model.flow.as_ref().context("flow")?);
                Ok(system(matrix, Symmetry::PositiveDefinite, 1, None))
            }
        }
    }

    /// The problem as solvers take it.
    pub fn problem(&self) -> Problem<'_> {
        let coordinates = Coordinates {
            dimension: 2,
            values: &self.coordinates,
        };
        Problem {
            coordinates: Some(coordinates),
            near_nullspace: match self.unknowns_per_point {
                1 => NearNullspace::Constants,
                _ => NearNullspace::RigidModes,
            },
            schur_diagonal: self.schur_diagonal.as_deref(),
            ..Problem::new(self.matrix.view(), self.symmetry, self.unknowns_per_point)
        }
    }

    /// Grows the crack at its right end by a tenth of its length in points of the lattice: 20 on 200².
    pub fn grow(&mut self, step: usize) -> Result<()> {
        let solid = self.solid.as_mut().context("a solid")?;
        let start = 0.75 + 0.025 * step as f64;
        for (point, x) in self.coordinates.chunks_exact(2).enumerate() {
            if x[0] > start && x[0] < start + 0.025 && (x[1] - 0.5).abs() < 0.01 {
                solid.elastic.degrade(point, 1e-6);
            }
        }
        solid.refill();
        self.matrix
            .data_mut()
            .copy_from_slice(solid.stiffness.data());
        Ok(())
    }

    /// The forces of the scene's traction.
    pub fn load(&self) -> Vec<f64> {
        let mut force = vec![0.0; self.matrix.rows()];
        if let Some(solid) = &self.solid {
            solid.loads(0.0, &mut force);
        }
        force
    }

    /// A right-hand side with a share of every mode: the product with a rough field.
    pub fn rhs(&self) -> Vec<f64> {
        let rough = |i: usize| 1.0 + (0.37 * i as f64).sin() + 1e-3 * i as f64;
        let field: Vec<f64> = (0..self.matrix.rows()).map(rough).collect();
        let mut rhs = vec![0.0; field.len()];
        perifrac_solvers::multiply(self.matrix.view(), &field, &mut rhs);
        rhs
    }
}

/// Coefficient of L in the monolithic matrix, s: a step of consolidation.
const STEP: f64 = 10.0;

/// The model of a system.
pub fn model(physics: Physics, rock: Rock, cells: usize) -> Result<Model<2>> {
    Ok(Model::build(
        &plan(physics, rock, cells)?,
        &mut Timers::default(),
    )?)
}

fn plan(physics: Physics, rock: Rock, cells: usize) -> Result<Plan> {
    let text = scene_text(physics, rock, cells);
    let loaded = scene::load_str("bench", &text, Path::new(""), &[]).map_err(|e| anyhow!("{e}"))?;
    resolve(&loaded, "bench").map_err(|e| anyhow!("{e}"))
}

fn scene_text(physics: Physics, rock: Rock, cells: usize) -> String {
    let flows = physics != Physics::Elasticity;
    let solid = matches!(physics, Physics::Elasticity | Physics::Monolithic);
    let mut text = format!(
        "title = \"bench\"\n[geometry]\ntype = \"lattice\"\nsize = [1, 1]\npoints = [{cells}, {cells}]\n[time]\nend = 1\n"
    );
    text += &material("rock", physics, 1.0, 1.0, "");
    match rock {
        Rock::Intact => {}
        Rock::Crack(factor) => {
            let flow = if solid { 100.0 } else { factor };
            let band = "{ type = \"box\", min = [0.25, 0.49], max = [0.75, 0.51] }";
            text += &material("crack", physics, factor, flow, band);
        }
        Rock::Contrast(factor) => {
            let stiff = if physics == Physics::Elasticity {
                factor
            } else {
                1.0
            };
            let half = "{ type = \"box\", min = [0.5, 0], max = [1, 1] }";
            text += &material("right", physics, stiff, factor, half);
        }
    }
    if flows {
        let operator = if physics == Physics::Bond {
            "bond"
        } else {
            "correspondence"
        };
        text += &format!("[fluid]\nviscosity = 1e-3\n[flow]\noperator = \"{operator}\"\n");
        if physics == Physics::TwoHops {
            text += "hourglass = 0.5\n";
        }
        text += "[flow.boundary.left]\npressure = 1e6\n[flow.boundary.right]\npressure = 0\n";
    }
    if solid {
        text += "[mechanics]\n[mechanics.boundary.bottom]\nclamped = true\n\
                 [mechanics.boundary.top]\ntraction = [0, 1e6]\n";
    }
    if physics == Physics::Monolithic {
        text += "[coupling]\n[scheme]\nname = \"monolithic\"\n";
    }
    text
}

fn material(name: &str, physics: Physics, stiff: f64, flow: f64, region: &str) -> String {
    let mut text = format!("[materials.{name}]\n");
    if physics != Physics::Elasticity {
        text += &format!("permeability = {:e}\nstorage = 1e-10\n", 1e-13 * flow);
    }
    if matches!(physics, Physics::Elasticity | Physics::Monolithic) {
        text += &format!(
            "youngs_modulus = {:e}\npoissons_ratio = 0.25\n",
            1e10 * stiff
        );
    }
    if physics == Physics::Monolithic {
        text += "biot_coefficient = 0.8\n";
    }
    if !region.is_empty() {
        text += &format!("region = {region}\n");
    }
    text
}

/// L of a steady state.
fn steady(flow: &FlowModel<2>) -> CsrMatrix {
    let shape = (flow.points(), flow.points());
    let pattern = &flow.pattern;
    CsrMatrix::new(
        shape,
        pattern.offsets.clone(),
        pattern.columns.clone(),
        flow.conductance.clone(),
    )
}
