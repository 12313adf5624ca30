//! Named sets of a mesh: the cells that materials have, and regions.

use super::Resolver;
use crate::geometry::Shape;
use crate::plan::files::{MeshTable, PointSet};
use crate::plan::types::{GeometryPlan, Plan};
use crate::scene::{self, Diagnostic, Scene, SetShape};

impl Resolver<'_> {
    /// Gives every cell the material whose name one of its groups has; nothing where no group has the name of a
    /// material.
    ///
    /// Faults are cells in none, and in two of these.
    pub(super) fn materials_of(
        &mut self,
        file: &scene::MeshFile,
        mesh: &MeshTable,
    ) -> Option<Option<Vec<String>>> {
        let materials = &self.loaded.scene.materials;
        let named: Vec<&PointSet> = (mesh.sets.iter())
            .filter(|set| materials.get(&set.name).is_some())
            .collect();
        if named.is_empty() {
            return Some(None);
        }
        let mut own: Vec<Option<&str>> = vec![None; mesh.table.volume.len()];
        for set in named {
            for point in &set.points {
                if let Some(other) = own[*point as usize].replace(&set.name) {
                    let message = format!(
                        "a cell is in the groups `{other}` and `{}`, which are both names of materials; rename one",
                        set.name
                    );
                    return self.fault(file.path.span, message);
                }
            }
        }
        let bare = own.iter().filter(|name| name.is_none()).count();
        if bare > 0 {
            let message = format!(
                "{bare} of {} cells are in no group that has the name of a material; the groups are {}; add the cells to \
                 one, or rename the material that a group has the name of",
                own.len(),
                names(&mesh.sets)
            );
            return self.fault(file.path.span, message);
        }
        let names = own.into_iter().flatten().map(str::to_owned);
        Some(Some(names.collect()))
    }

    /// Gives regions that are sets their points. Faults are names that the mesh does not have, and sets as parts of a side.
    pub(super) fn fill_sets(&mut self, plan: &mut Plan) {
        let GeometryPlan::Points {
            table,
            mesh: Some(mesh),
            ..
        } = &plan.geometry
        else {
            return;
        };
        let sets = &mesh.sets;
        for typed in side_sets(&self.loaded.scene) {
            let fault = Diagnostic::new("a set is no part of a side: it has points, and no area")
                .at(typed.name.span);
            self.faults.push(
                fault.help("give the part of the side as a box, a disc, a polygon or a half-plane"),
            );
        }
        for typed in region_sets(&self.loaded.scene) {
            let name = &typed.name;
            if !sets.iter().any(|set| set.name == **name) {
                let closest = scene::closest(name, sets.iter().map(|set| set.name.as_str()));
                let help = match closest {
                    Some(close) => format!("did you mean `{close}`?"),
                    None => format!("its groups are {}", names(sets)),
                };
                let fault = Diagnostic::new(format!("the mesh has no group `{}`", name.value));
                self.faults.push(fault.at(name.span).help(help));
            }
        }
        let place = |point: &u32| {
            let first = *point as usize * table.dimension;
            table.position[first..first + table.dimension].to_vec()
        };
        let named = |set: &&PointSet| {
            let mut typed = region_sets(&self.loaded.scene).into_iter();
            typed.any(|own| *own.name == set.name)
        };
        let shape = |set: &PointSet| Shape::set(&set.name, set.points.iter().map(place).collect());
        let shapes: Vec<Shape> = sets.iter().filter(named).map(shape).collect();
        for region in regions(plan) {
            let same = |own: &&Shape| match (own, &*region) {
                (Shape::Set { name, .. }, Shape::Set { name: typed, .. }) => name == typed,
                _ => false,
            };
            if let Some(own) = shapes.iter().find(same) {
                *region = own.clone();
            }
        }
    }
}

/// Names of sets as a list for messages.
fn names(sets: &[PointSet]) -> String {
    match sets.is_empty() {
        true => "none".to_owned(),
        false => {
            let names = sets.iter().map(|set| format!("`{}`", set.name));
            names.collect::<Vec<_>>().join(", ")
        }
    }
}

/// Sets that the scene names as regions of points.
fn region_sets(scene: &Scene) -> Vec<&SetShape> {
    let materials = scene.materials.iter();
    let materials = materials.filter_map(|own| own.value.region.as_ref());
    let flow = scene.flow.iter().flat_map(|flow| &flow.regions);
    let initial = scene.initial.iter().flat_map(|own| &own.regions);
    let all = materials
        .chain(flow.map(|own| &own.region))
        .chain(initial.map(|own| &own.region));
    all.filter_map(|region| set_of(region)).collect()
}

/// Sets that the scene names as parts of a side.
fn side_sets(scene: &Scene) -> Vec<&SetShape> {
    let loads = scene.mechanics.iter().flat_map(|own| own.loads.iter());
    let regions = loads.filter_map(|own| own.value.region.as_ref());
    regions.filter_map(|region| set_of(region)).collect()
}

fn set_of(region: &scene::Shape) -> Option<&SetShape> {
    match region {
        scene::Shape::Set(set) => Some(set),
        _ => None,
    }
}

/// Regions of a plan that may be sets.
fn regions(plan: &mut Plan) -> Vec<&mut Shape> {
    let materials = plan.materials.iter_mut();
    let materials = materials.filter_map(|own| own.region.as_mut());
    let flow = plan.flow.iter_mut().flat_map(|flow| &mut flow.regions);
    let initial = plan.initial.iter_mut().flat_map(|own| &mut own.regions);
    materials
        .chain(flow.map(|own| &mut own.region))
        .chain(initial.map(|own| &mut own.0))
        .collect()
}
