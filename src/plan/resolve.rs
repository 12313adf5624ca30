//! Scene → plan: SI numbers, files read, solver parsed. Rules that need only the scene are checked
//! there; here are those that need a file or another crate.

use perifrac_solvers::SolverSpec;

use super::files::{FileError, read_permeability, read_points};
use super::types::{
    FlowPlan, FluidPlan, GeometryPlan, GradientChoice, GravityPlan, Integrator, MaterialPlan,
    OperatorChoice, OutputPlan, PermeabilityPlan, Plan, Probe, Profile, ReferenceKind,
    ReferencePlan, RegionPressure, SchemeChoice, SideCondition, StepRule, TimeMode, TimePlan,
    WellPlan,
};
use crate::geometry::generate::{Refinement, Segment, divide};
use crate::geometry::{Horizon, Influence, Side};
use crate::material::storage_coefficient;
use crate::scene::quantity::{Length, values};
use crate::scene::{self, Condition, Diagnostic, LoadedScene, SceneErrors, Span, Spanned};

/// Resolves a loaded scene; `case` is its name in reports.
///
/// # Errors
/// [`SceneErrors`] with the place in the scene: files that cannot be used, a spacing that does not
/// divide the domain, an unknown solver, a reference that does not fit.
pub fn resolve(loaded: &LoadedScene, case: &str) -> Result<Plan, SceneErrors> {
    let mut faults = Vec::new();
    let plan = Resolver {
        loaded,
        faults: &mut faults,
    }
    .plan(case);
    match plan {
        Some(plan) if faults.is_empty() => Ok(plan),
        _ => Err(loaded.errors(faults)),
    }
}

struct Resolver<'a> {
    loaded: &'a LoadedScene,
    faults: &'a mut Vec<Diagnostic>,
}

impl Resolver<'_> {
    fn fault<T>(&mut self, place: Span, message: impl ToString) -> Option<T> {
        self.faults
            .push(Diagnostic::new(message.to_string()).at(place));
        None
    }

    fn plan(&mut self, case: &str) -> Option<Plan> {
        let scene = &self.loaded.scene;
        let geometry = self.geometry();
        let materials: Vec<Option<MaterialPlan>> = scene
            .materials
            .iter()
            .map(|entry| self.material(&entry.name, &entry.value))
            .collect();
        let solver = self.solver();
        let geometry = geometry?;
        let mut plan = Plan {
            case: case.to_owned(),
            title: scene.title.clone(),
            dimension: geometry.dimension(),
            geometry,
            horizon: horizon(&scene.horizon),
            influence: influence(scene.horizon.influence),
            materials: materials.into_iter().collect::<Option<_>>()?,
            fluid: fluid(scene),
            flow: scene.flow.as_ref().map(|flow| flow_plan(flow)),
            gravity: scene.gravity.as_ref().map(|gravity| GravityPlan {
                acceleration: values(&gravity.acceleration),
            }),
            wells: wells(scene),
            time: time(&scene.time),
            scheme: scheme(scene),
            solver: solver?,
            output: output(&scene.output, &scene.time),
            reference: scene
                .reference
                .as_ref()
                .map(|reference| reference_plan(reference)),
            warnings: Vec::new(),
        };
        self.check_reference(&plan);
        self.check_planes(&plan);
        plan.warnings = warnings(&plan);
        Some(plan)
    }

    fn geometry(&mut self) -> Option<GeometryPlan> {
        let geometry = &self.loaded.scene.geometry;
        let origin = |given: &Option<Spanned<Vec<Length>>>, dimension: usize| {
            given
                .as_ref()
                .map_or_else(|| vec![0.0; dimension], |origin| values(origin))
        };
        match &geometry.value {
            scene::Geometry::Lattice(lattice) => {
                let size = values(&lattice.size);
                Some(GeometryPlan::Lattice {
                    origin: origin(&lattice.origin, size.len()),
                    cells: self.cells(lattice, &size)?,
                    size,
                    jitter: lattice.jitter.value(),
                    seed: lattice.seed,
                })
            }
            scene::Geometry::Graded(graded) => Some(GeometryPlan::Graded {
                origin: origin(&graded.origin, graded.axes.len()),
                axes: graded
                    .axes
                    .iter()
                    .map(|axis| axis.iter().map(segment).collect())
                    .collect(),
            }),
            scene::Geometry::Blocks(blocks) => {
                let size = values(&blocks.size);
                let refinement = |refine: &scene::Refinement| Refinement {
                    region: refine.region.resolved(),
                    levels: refine.levels.value as u32,
                };
                Some(GeometryPlan::Blocks {
                    origin: origin(&blocks.origin, size.len()),
                    size,
                    spacing: blocks.spacing.value(),
                    refinements: blocks.refine.iter().map(refinement).collect(),
                })
            }
            scene::Geometry::File(file) => self.points(file),
        }
    }

    fn cells(&mut self, lattice: &scene::Lattice, size: &[f64]) -> Option<Vec<usize>> {
        if let Some(points) = &lattice.points {
            return Some(points.iter().map(|n| n.value as usize).collect());
        }
        let spacing = lattice.spacing?;
        let cells: Result<Vec<usize>, _> = (0..size.len())
            .map(|axis| divide(size[axis], spacing.value(), axis))
            .collect();
        match cells {
            Ok(cells) => Some(cells),
            Err(error) => self.fault(spacing.span(), error),
        }
    }

    fn points(&mut self, file: &scene::PointFile) -> Option<GeometryPlan> {
        let path = self.loaded.path(&file.path);
        match read_points(&path) {
            Err(error) => self.fault(file.path.span, error),
            Ok(table) => {
                let bounds = file
                    .bounds
                    .as_ref()
                    .map(|bounds| (values(&bounds.min), values(&bounds.max)));
                if let (Some(given), Some((min, _))) = (&file.bounds, &bounds)
                    && min.len() != table.dimension
                {
                    let message = format!(
                        "the points in {} are {}-dimensional, the bounds {}-dimensional",
                        path.display(),
                        table.dimension,
                        min.len()
                    );
                    return self.fault(given.min.span, message);
                }
                Some(GeometryPlan::Points {
                    path: file.path.value.clone(),
                    table,
                    bounds,
                })
            }
        }
    }

    fn material(&mut self, name: &str, material: &scene::Material) -> Option<MaterialPlan> {
        let permeability = match &material.permeability.value {
            scene::PermeabilityField::Value(value) => PermeabilityPlan::Uniform(value.value()),
            scene::PermeabilityField::File(file) => self.permeability_file(file)?,
            scene::PermeabilityField::Distribution(field) => PermeabilityPlan::LogNormal {
                median: field.median.value(),
                log10_std: field.log10_std.value(),
                decades: field
                    .decades
                    .map_or(f64::INFINITY, |decades| decades.value()),
                correlation_length: field.correlation_length.map(|length| length.value()),
                seed: field.seed,
            },
        };
        Some(MaterialPlan {
            name: name.to_owned(),
            region: material.region.as_ref().map(|region| region.resolved()),
            permeability,
            storage: storage(&self.loaded.scene, material),
        })
    }

    fn permeability_file(&mut self, file: &scene::PermeabilityFile) -> Option<PermeabilityPlan> {
        let path = self.loaded.path(&file.file);
        let column = file.column.as_ref().map(|column| column.value.as_str());
        let read: Result<Vec<f64>, FileError> = read_permeability(&path, column);
        match read {
            Ok(values) => Some(PermeabilityPlan::Table {
                path: file.file.value.clone(),
                values,
            }),
            Err(error) => self.fault(file.file.span, error),
        }
    }

    fn solver(&mut self) -> Option<SolverSpec> {
        let name = &self.loaded.scene.solver.name;
        match name.value.parse() {
            Ok(spec) => Some(spec),
            Err(error) => self.fault::<SolverSpec>(name.span, error),
        }
    }

    /// A cloud without planes has no sides to put conditions on.
    fn check_planes(&mut self, plan: &Plan) {
        let Some(flow) = self
            .loaded
            .scene
            .flow
            .as_ref()
            .filter(|_| plan.geometry.bounds().is_none())
        else {
            return;
        };
        let sides: Vec<Span> = flow
            .boundary
            .iter()
            .map(|(_, condition)| condition.span)
            .collect();
        for place in sides {
            self.fault::<()>(
                place,
                "a cloud from a file has sides only with geometry.bounds; give the bounds, or \
                 prescribe pressures on flow.regions",
            );
        }
    }

    fn check_reference(&mut self, plan: &Plan) {
        if let (Err(message), Some(reference)) = (
            super::exact::exact_pressure(plan),
            &self.loaded.scene.reference,
        ) {
            self.fault::<()>(reference.kind.span, message);
        }
    }
}

fn segment(segment: &scene::Segment) -> Segment {
    let (first, last) = match &segment.spacing {
        scene::SegmentSpacing::Value(spacing) => (spacing.value(), spacing.value()),
        scene::SegmentSpacing::List([first, last]) => (first.value(), last.value()),
    };
    Segment {
        length: segment.length.value(),
        first,
        last,
    }
}

fn horizon(horizon: &scene::Horizon) -> Horizon {
    match horizon.size() {
        scene::HorizonSize::Neighbours(count) => Horizon::Neighbours(count),
        scene::HorizonSize::Radius(radius) => Horizon::Radius(radius),
        scene::HorizonSize::Ratio(ratio) => Horizon::Ratio(ratio),
    }
}

fn influence(influence: scene::Influence) -> Influence {
    match influence {
        scene::Influence::InverseSquare => Influence::InverseSquare,
        scene::Influence::Inverse => Influence::Inverse,
        scene::Influence::Constant => Influence::Constant,
        scene::Influence::Gaussian => Influence::Gaussian,
    }
}

fn fluid(scene: &scene::Scene) -> FluidPlan {
    let fluid = scene.fluid.as_ref();
    FluidPlan {
        viscosity: fluid.map_or(1.0, |fluid| fluid.viscosity.value()),
        density: fluid.map_or(1000.0, |fluid| fluid.density.value()),
    }
}

/// Storage of a material. A steady run needs none; there it only weighs how a sealed part shares a
/// constant, evenly by volume.
fn storage(scene: &scene::Scene, material: &scene::Material) -> f64 {
    match material.storage() {
        None => 1.0,
        Some(scene::Storage::Given(storage)) => storage,
        Some(scene::Storage::Derived {
            porosity,
            biot_coefficient,
            bulk_modulus,
        }) => {
            let fluid = scene.fluid.as_ref().and_then(|fluid| fluid.bulk_modulus);
            let fluid = fluid.map_or(f64::INFINITY, |modulus| modulus.value());
            storage_coefficient(porosity, biot_coefficient, bulk_modulus, fluid)
        }
    }
}

fn flow_plan(flow: &scene::Flow) -> FlowPlan {
    let mut sides = vec![SideCondition::Sealed; 6];
    for (side, condition) in flow.boundary.iter() {
        let index = Side {
            axis: side.axis(),
            upper: side.is_high(),
        }
        .index();
        sides[index] = match &condition.value {
            Condition::Sealed(_) => SideCondition::Sealed,
            Condition::Flux(flux) => SideCondition::Flux(flux.flux.resolved()),
            Condition::Pressure(pressure) => SideCondition::Pressure {
                value: pressure.pressure.resolved(),
                hydrostatic: pressure.hydrostatic.value,
            },
        };
    }
    FlowPlan {
        operator: match flow.operator {
            scene::Operator::Correspondence => OperatorChoice::Correspondence,
            scene::Operator::Bond => OperatorChoice::Bond,
        },
        hourglass: flow.hourglass.value(),
        gradient: match flow.gradient.value {
            scene::Gradient::Auto => GradientChoice::Auto,
            scene::Gradient::Plain => GradientChoice::Plain,
            scene::Gradient::DivergenceConsistent => GradientChoice::DivergenceConsistent,
        },
        initial_pressure: flow.initial_pressure.value(),
        hydrostatic_start: flow.hydrostatic_start.value,
        sides,
        regions: flow
            .regions
            .iter()
            .map(|region| RegionPressure {
                region: region.region.resolved(),
                pressure: region.pressure.resolved(),
            })
            .collect(),
    }
}

fn wells(scene: &scene::Scene) -> Vec<WellPlan> {
    let well = |entry: &scene::Entry<scene::Well>| WellPlan {
        name: entry.name.clone(),
        at: values(&entry.value.at),
        rate: entry.value.rate.resolved(),
        radius: entry.value.radius.map(|radius| radius.value()),
    };
    scene.wells.iter().map(well).collect()
}

fn time(time: &scene::TimeControl) -> TimePlan {
    let steady = time.is_steady();
    TimePlan {
        mode: if steady {
            TimeMode::Steady
        } else {
            TimeMode::Transient
        },
        end: time.end.filter(|_| !steady).map_or(0.0, |end| end.value()),
        step: time
            .step
            .map_or(StepRule::Adaptive, |step| StepRule::Fixed(step.value())),
        tolerance: time.tolerance.value(),
        first_step: time.first_step.map(|step| step.value()),
        max_step: time.max_step.map(|step| step.value()),
        safety: time.safety.value(),
        max_steps: usize::try_from(time.max_steps.value).unwrap_or(usize::MAX),
    }
}

fn scheme(scene: &scene::Scene) -> SchemeChoice {
    match (scene.scheme.name.value, scene.time.integrator) {
        (scene::SchemeName::Explicit, _) => SchemeChoice::Explicit,
        (_, scene::Integrator::TrBdf2) => SchemeChoice::Implicit(Integrator::TrBdf2),
        (_, scene::Integrator::BackwardEuler) => SchemeChoice::Implicit(Integrator::BackwardEuler),
    }
}

fn output(output: &scene::Output, time: &scene::TimeControl) -> OutputPlan {
    let end = time.end.map_or(0.0, |end| end.value());
    let mut times = output
        .times
        .as_ref()
        .map_or_else(Vec::new, |times| values(times));
    if let Some(every) = output.every {
        let count = (end / every.value() * (1.0 + 1e-12)).floor() as usize;
        times = (1..=count).map(|k| k as f64 * every.value()).collect();
    }
    OutputPlan {
        times,
        vtu: output.vtu,
        plots: output.plots,
        probes: output
            .probes
            .iter()
            .map(|entry| Probe {
                name: entry.name.clone(),
                at: values(&entry.value.at),
            })
            .collect(),
        profiles: output
            .profiles
            .iter()
            .map(|entry| Profile {
                name: entry.name.clone(),
                from: values(&entry.value.from),
                to: values(&entry.value.to),
                points: entry.value.points.value as usize,
            })
            .collect(),
    }
}

fn reference_plan(reference: &scene::Reference) -> ReferencePlan {
    ReferencePlan {
        kind: match reference.kind.value {
            scene::ReferenceKind::FiveSpot => ReferenceKind::FiveSpot,
            scene::ReferenceKind::TwoLayer => ReferenceKind::TwoLayer,
            scene::ReferenceKind::Theis => ReferenceKind::Theis,
            scene::ReferenceKind::Manufactured => ReferenceKind::Manufactured,
        },
        exclude: reference.exclude.map(|radius| radius.value()),
    }
}

/// Doubts about the plan that do not stop it.
fn warnings(plan: &Plan) -> Vec<String> {
    let mut warnings = Vec::new();
    let (Some(flow), Some(gravity)) = (&plan.flow, &plan.gravity) else {
        return warnings;
    };
    for side in Side::all(plan.dimension) {
        let along = |axis: &usize| *axis != side.axis && gravity.acceleration[*axis] != 0.0;
        let uniform = SideCondition::Pressure {
            value: crate::load::Load::constant(0.0),
            hydrostatic: false,
        };
        let is_uniform = std::mem::discriminant(&flow.sides[side.index()])
            == std::mem::discriminant(&uniform)
            && !matches!(
                flow.sides[side.index()],
                SideCondition::Pressure {
                    hydrostatic: true,
                    ..
                }
            );
        if is_uniform && (0..plan.dimension).any(|axis| along(&axis)) {
            warnings.push(format!(
                "the pressure on side {side} is uniform although gravity acts along it: fluid will \
                 seep through it, and the layer of one horizon next to it is first-order accurate; \
                 hydrostatic = true gives a state of rest"
            ));
        }
    }
    warnings
}
