//! Scene → plan: SI numbers, files read, solver parsed. Rules that need only the scene are checked
//! there; here are those that need a file or another crate.

mod control;
mod fields;
mod flow;
mod fracture;
mod geometry;
mod initial;
mod materials;
mod mechanics;
mod permeability;
mod places;
mod sets;
mod shortened;
#[cfg(test)]
mod tests;

use perifrac_solvers::SolverSpec;

use super::types::{
    GeometryPlan, MaterialPlan, Plan, SchemeChoice, SideCondition, StartPlan, TimeMode,
};
use crate::geometry::Side;
use crate::material::{Elasticity, Lame};
use crate::plan::capability;
use crate::scene::{self, Diagnostic, LoadedScene, SceneErrors, Span};

/// Resolves a loaded scene for a run in one process; `case` is its name in reports.
///
/// # Errors
/// As [`resolve_for`].
pub fn resolve(loaded: &LoadedScene, case: &str) -> Result<Plan, SceneErrors> {
    resolve_for(loaded, case, 1)
}

/// Resolves a loaded scene for a run by so many processes.
///
/// # Errors
/// [`SceneErrors`] with the place in the scene: files that cannot be used, a spacing that does not
/// divide the domain, an unknown solver, a reference that does not fit, and what cannot be combined. What
/// only the solver refuses is left to the run.
pub fn resolve_for(
    loaded: &LoadedScene,
    case: &str,
    processes: usize,
) -> Result<Plan, SceneErrors> {
    allowed(loaded, resolve_any(loaded, case)?, processes)
}

/// Resolves a loaded scene for a run in one process, with points in place of the file that it names.
///
/// # Errors
/// As [`resolve_for`].
pub(super) fn resolve_given(
    loaded: &LoadedScene,
    case: &str,
    points: Option<&super::PointTable>,
) -> Result<Plan, SceneErrors> {
    allowed(loaded, resolved(loaded, case, points)?, 1)
}

/// The plan, if its parts can be combined.
fn allowed(loaded: &LoadedScene, plan: Plan, processes: usize) -> Result<Plan, SceneErrors> {
    let scheme = plan.scheme.scheme();
    let features = capability::features(&plan, processes);
    let mut faults: Vec<Diagnostic> = capability::broken(scheme, &features)
        .flat_map(|rule| places::diagnostics(rule, &loaded.scene))
        .collect();
    faults.extend(format_fault(loaded, &plan, processes));
    match faults.is_empty() {
        true => Ok(plan),
        false => Err(loaded.errors(faults)),
    }
}

/// What one VTKHDF file cannot hold.
fn format_fault(loaded: &LoadedScene, plan: &Plan, processes: usize) -> Option<Diagnostic> {
    let has_polyhedra = match &plan.geometry {
        GeometryPlan::Points {
            mesh: Some(mesh), ..
        } => !mesh.dual.solids.is_empty(),
        _ => false,
    };
    let message = match (plan.output.vtkhdf, has_polyhedra) {
        (false, _) => return None,
        _ if processes > 1 => format!("one process writes `.vtkhdf`, and {processes} run"),
        (_, true) => "the cells between the points of a mesh in space are polyhedra, which `.vtkhdf` does not hold".to_owned(),
        _ => return None,
    };
    let fault = Diagnostic::new(message).at(loaded.scene.output.format.span);
    Some(fault.help("leave `format` out"))
}

/// Resolves a loaded scene whether its parts can be combined or not; see [`capability::refusals`].
///
/// # Errors
/// As [`resolve_for`], without what cannot be combined.
pub fn resolve_any(loaded: &LoadedScene, case: &str) -> Result<Plan, SceneErrors> {
    resolved(loaded, case, None)
}

fn resolved(
    loaded: &LoadedScene,
    case: &str,
    points: Option<&super::PointTable>,
) -> Result<Plan, SceneErrors> {
    let mut faults = Vec::new();
    let plan = Resolver {
        loaded,
        points,
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
    /// In place of a file of points.
    points: Option<&'a super::PointTable>,
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
            .map(|entry| self.material(&entry.name, &entry.value, geometry.as_ref()))
            .collect();
        let solver = self.solver();
        let geometry = geometry?;
        let dimension = geometry.dimension();
        let thickness = self.thickness(dimension)?;
        let mechanics = match &scene.mechanics {
            Some(typed) => Some(self.mechanics(typed, dimension, thickness)?),
            None => None,
        };
        self.check_cracks(dimension);
        let (mut time, mut output) = (
            control::time(&scene.time, scene.fracture_flow.is_some()),
            control::output(&scene.output, &scene.time),
        );
        let mut damage = fracture::damage(scene, time.end);
        let cut = shortened::cut_to_end(scene, &mut time, &mut output, damage.as_mut());
        let mut plan = Plan {
            case: case.to_owned(),
            title: scene.title.clone().unwrap_or_else(|| case.to_owned()),
            dimension,
            thickness,
            geometry,
            horizon: geometry::horizon(scene),
            influence: geometry::influence(scene.horizon.influence),
            materials: materials.into_iter().collect::<Option<_>>()?,
            fluid: materials::fluid(scene),
            flow: scene.flow.as_deref().map(|own| flow::flow_plan(own, scene)),
            initial: initial::initial(scene),
            mechanics,
            coupling: scene.coupling.as_deref().map(mechanics::coupling),
            damage,
            fracture_flow: fracture::fracture_flow(scene),
            gravity: scene.gravity.as_deref().map(flow::gravity),
            own_effects: Vec::new(),
            cracks: fracture::cracks(scene, thickness),
            wells: flow::wells(scene, thickness),
            start: scene.start.as_deref().map(|start| self.start(start)),
            time,
            scheme: control::scheme(scene),
            scheme_options: control::scheme_options(&scene.scheme, dimension),
            solver: solver?,
            audit: control::audit(scene),
            output,
            reference: scene.reference.as_deref().map(control::reference_plan),
            warnings: Vec::new(),
        };
        self.fill_sets(&mut plan);
        self.check_reference(&plan);
        self.check_planes(&plan);
        self.check_tensors(&plan);
        plan.warnings = cut.into_iter().chain(warnings(&plan)).collect();
        Some(plan)
    }

    fn start(&self, start: &scene::Start) -> StartPlan {
        StartPlan {
            from: self.loaded.path(&start.from.value),
            keeps_clock: start.clock.value == scene::StartClock::Keep,
            resets_displacement: start.displacement.value == scene::StartDisplacement::Reset,
        }
    }

    fn solver(&mut self) -> Option<SolverSpec> {
        let name = &self.loaded.scene.solver.name;
        let spec: SolverSpec = match name.value.parse() {
            Ok(spec) => spec,
            Err(error) => return self.fault::<SolverSpec>(name.span, error),
        };
        let others = spec.unconfined_flags();
        if others.is_empty() || self.loaded.sources.is_typed(name.span) {
            return Some(spec);
        }
        let message = format!(
            "a scene must not give a solver `{}`, which may read or write files or print",
            others.join("`, `")
        );
        let help = "leave it out here, or give the solver on the command line with --solver";
        self.faults
            .push(Diagnostic::new(message).at(name.span).help(help));
        None
    }

    /// A cloud without planes has no sides to put conditions on.
    fn check_planes(&mut self, plan: &Plan) {
        if plan.geometry.bounds().is_some() {
            return;
        }
        let scene = &self.loaded.scene;
        let needs = "a cloud from a file has sides only with geometry.bounds; give the bounds";
        if let Some(flow) = &scene.flow {
            for (_, condition) in flow.boundary.iter() {
                let message = format!("{needs}, or prescribe pressures on flow.regions");
                self.fault::<()>(condition.span, message);
            }
        }
        if let Some(mechanics) = &scene.mechanics {
            for (_, support) in mechanics.boundary.iter() {
                self.fault::<()>(support.span, needs);
            }
            for load in &mechanics.loads {
                self.fault::<()>(load.value.side.span, needs);
            }
        }
    }

    fn check_reference(&mut self, plan: &Plan) {
        let Some(reference) = &self.loaded.scene.reference else {
            return;
        };
        let pressure = super::exact::exact_pressure(plan).map(|_| ());
        let opening = super::exact::exact_opening(plan).map(|_| ());
        if let Err(message) = pressure.and(opening) {
            self.fault::<()>(reference.kind.span, message);
        }
    }
}

/// Doubts about the plan that do not stop it.
fn warnings(plan: &Plan) -> Vec<String> {
    let mut warnings: Vec<String> = split_doubt(plan).into_iter().collect();
    if plan.scheme_options.single_pass && matches!(plan.scheme, SchemeChoice::SemiImplicit(_)) {
        warnings.push(
            "scheme.single_pass takes the strain of the last step, however flow and mechanics disagree"
                .to_owned(),
        );
    }
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

/// A warning if passing between flow and mechanics makes errors grow.
///
/// With τ = α²/(s(λ + 2μ)), τ_b = α²/(s(λ + 2μ/D)) and the relaxation β an error grows from pass to
/// pass by (τ − β τ_b)/(1 + β τ_b) as steps go to zero, which is above 1 where τ > 1 + 2 β τ_b.
fn split_doubt(plan: &Plan) -> Option<String> {
    let relaxation = plan.scheme_options.relaxation;
    let splits = matches!(
        plan.scheme,
        SchemeChoice::Explicit | SchemeChoice::SemiImplicit(_) | SchemeChoice::Staggered(_)
    );
    let rests = plan.mechanics.as_ref().is_some_and(|m| !m.inertia);
    if !splits || !rests || plan.coupling.is_none() || plan.time.mode == TimeMode::Steady {
        return None;
    }
    let closer = |a: &(f64, f64), b: &(f64, f64)| (a.0 / a.1).total_cmp(&(b.0 / b.1));
    let strength = |material: &MaterialPlan| {
        let alpha = material.biot_coefficient.as_ref()?.range()[1];
        let strain = alpha.powi(2) / material.storage.least();
        let of = |rock: Elasticity| {
            let Lame { lambda, mu } = rock.lame();
            let bulk = lambda + 2.0 * mu / plan.dimension as f64;
            let bar = 1.0 + 2.0 * relaxation * strain / bulk;
            (strain / (lambda + 2.0 * mu), bar)
        };
        let softest = material.elasticity.as_ref()?.softest().map(of);
        softest.into_iter().max_by(closer)
    };
    let worst = (plan.materials.iter()).filter_map(strength).max_by(closer);
    worst.filter(|(own, bar)| own > bar).map(|(own, bar)| {
        format!(
            "scheme.relaxation = {relaxation} with coupling strength {own:.1}: the split alone \
             diverges above {bar}; set scheme.relaxation = 1"
        )
    })
}
