//! Where in a scene an error of its model belongs.

use std::path::Path;

use crate::effects::EffectError;
use crate::geometry::GeometryError;
use crate::model::ModelError;
use crate::plan::FileError;
use crate::scene::{self, Diagnostic, LoadedScene, Scene, SceneErrors, Span};

/// An error of the model, underlined in the scene where it has a place there.
pub fn locate(loaded: &LoadedScene, error: &ModelError) -> SceneErrors {
    let mut diagnostic = Diagnostic::new(error.to_string());
    if let Some(place) = place(&loaded.scene, error) {
        diagnostic = diagnostic.at(place);
    }
    if let Some(help) = remedy(&loaded.scene, error) {
        diagnostic = diagnostic.help(help);
    }
    loaded.errors(vec![diagnostic])
}

fn place(scene: &Scene, error: &ModelError) -> Option<Span> {
    let material = |name: &String| scene.materials.get(name);
    let well = |name: &String| scene.wells.get(name).map(|well| well.at.span);
    let horizon = match scene.horizon.span() {
        span if span.is_somewhere() => span,
        _ => scene.geometry.span,
    };
    match error {
        ModelError::Geometry(GeometryError::TooLarge { .. })
        | ModelError::Generate(_)
        | ModelError::Unresolved { .. } => Some(scene.geometry.span),
        ModelError::Geometry(_) => Some(horizon),
        ModelError::CrackThroughPoint { name, .. } | ModelError::CrackAtBoundary { name, .. } => {
            scene.cracks.get(name).map(scene::Crack::span)
        }
        ModelError::EmptyRegion { material: name }
        | ModelError::CoveredRegion { material: name }
        | ModelError::UnusedRegion { material: name } => {
            material(name)?.region.as_ref().map(|region| region.span)
        }
        ModelError::EmptyBand { name } => scene.cracks.get(name).map(scene::Crack::span),
        ModelError::ProbeOffPoints { what, name, .. } => match *what {
            "output.probes" => Some(scene.output.probes.get(name)?.at.span),
            _ => Some(scene.output.profiles.get(name)?.from.span),
        },
        ModelError::EmptyPressureRegion { number }
        | ModelError::CoveredPressureRegion { number } => scene
            .flow
            .as_ref()?
            .regions
            .get(number - 1)
            .map(|region| region.region.span),
        ModelError::Table(FileError::Length { path, .. }) => {
            let mut files = scene.materials.iter().flat_map(|entry| entry.value.files());
            let named = files.find(|file| Path::new(&file.file.value) == path);
            named.map(|file| file.file.span)
        }
        ModelError::Points { .. }
        | ModelError::UnknownMaterial { .. }
        | ModelError::UntoldMaterial { .. } => {
            let path = scene.geometry.value.path();
            Some(path.map_or(scene.geometry.span, |path| path.span))
        }
        ModelError::NoMaterial { .. } => scene.materials.iter().next().map(|entry| entry.span),
        ModelError::Effect(
            EffectError::EmptyWell { name, .. } | EffectError::CrampedWell { name, .. },
        ) => well(name),
        ModelError::Effect(EffectError::WideHole { name, .. }) => {
            let hole = scene.wells.get(name)?.wellbore_radius?;
            Some(hole.span())
        }
        ModelError::Effect(EffectError::EmptyInjection { name, .. }) => {
            Some(scene.cracks.get(name)?.injection.as_ref()?.at.span)
        }
        ModelError::Effect(EffectError::OverlappingWells { second, .. }) => well(second),
        ModelError::Effect(EffectError::EmptyLoad { name, .. }) => {
            let mut loads = scene.mechanics.as_ref()?.loads.iter();
            loads.find(|entry| entry.name == *name).map(|e| e.span)
        }
        ModelError::PorosityAboveBiot { material: name, .. } => {
            material(name)?.porosity.as_ref().map(|own| own.span)
        }
        ModelError::MissingProperty { material: name, .. } => {
            let mut materials = scene.materials.iter();
            materials.find(|entry| entry.name == *name).map(|e| e.span)
        }
        ModelError::Consistency(_) => match (&scene.flow, &scene.mechanics) {
            (Some(flow), _) => Some(flow.gradient.span),
            (None, mechanics) => Some(mechanics.as_ref()?.gradient.span),
        },
        _ => None,
    }
}

/// What to do where the error itself cannot know the keys of a scene.
fn remedy(scene: &Scene, error: &ModelError) -> Option<&'static str> {
    match error {
        ModelError::Geometry(GeometryError::TooFewPoints { .. }) => {
            Some("add points, or set horizon.neighbours to fewer, or horizon.radius to a length")
        }
        ModelError::Effect(EffectError::EmptyWell { .. }) => {
            Some("enlarge its radius, leave the radius out, or refine the cloud there")
        }
        ModelError::MissingProperty { .. } => {
            Some("add it to the material, or take out the section that asks for it")
        }
        ModelError::Consistency(_) if scene.flow.is_none() => {
            Some("here it is mechanics.gradient that asks for it; \"plain\" does without")
        }
        _ => None,
    }
}
