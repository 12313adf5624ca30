//! Fields of one output as VTU. What a scene does not name has no array.

use std::borrow::Cow;
use std::path::Path;

use super::grid::Grid;
use crate::geometry::Matrix;
use crate::material::DamageModel;
use crate::model::{FlowModel, Model, SolidModel, VaryingProperty};
use crate::operators::{Damage, Lame};
use crate::output::{
    Field, OutputError, VtuData, append_vtkhdf, create_vtkhdf, write_pvtu, write_vtu,
};
use crate::plan::PointFields;
use crate::run::FieldValues;
use crate::schemes::State;

/// Rows and columns of the components of a stress: xx, yy, zz, xy, yz, xz.
const TENSOR: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];

/// An array of the file, owned or borrowed from the state.
struct Array<'a> {
    name: &'static str,
    unit: &'static str,
    components: usize,
    values: Cow<'a, [f64]>,
}

/// Whether a field stays as it is, so that nothing is drawn from it at an output.
fn is_constant(name: &str) -> bool {
    ["permeability", "material_id"].contains(&name) || VaryingProperty::NAMES.contains(&name)
}

impl Array<'_> {
    /// The same field with other values.
    fn with<'b>(&self, values: Cow<'b, [f64]>) -> Array<'b> {
        Array {
            name: self.name,
            unit: self.unit,
            components: self.components,
            values,
        }
    }

    fn field(&self) -> Field<'_> {
        Field {
            name: self.name,
            unit: self.unit,
            components: self.components,
            values: &self.values,
        }
    }
}

/// Fields of a state at the points of a file.
pub(super) struct Snapshot<'a> {
    arrays: Vec<Array<'a>>,
    positions: Vec<f64>,
    dimension: usize,
    time: f64,
}

impl<'a> Snapshot<'a> {
    /// Takes the fields at all points. Of several processes all must call this together.
    pub(super) fn take<const D: usize>(model: &'a Model<D>, state: &'a State) -> Self {
        let mut arrays = arrays(model, state);
        if model.subdomain().partition().is_some() {
            for array in &mut arrays {
                let mut values = std::mem::take(&mut array.values).into_owned();
                model.subdomain().complete(&mut values, array.components);
                array.values = values.into();
            }
        }
        Snapshot {
            arrays,
            positions: model.cloud.flat_positions(),
            dimension: D,
            time: state.time,
        }
    }

    /// Writes the points of `grid`, the cells between them and the fields to `path`.
    ///
    /// # Errors
    /// Those of [`write_vtu`].
    pub(super) fn write(&self, path: &Path, grid: &Grid) -> Result<(), OutputError> {
        let whole = grid.points.len() * self.dimension == self.positions.len();
        let some = (!whole || grid.ghosts.is_some()).then(|| self.at(&grid.points));
        let own = some.as_ref().unwrap_or(self);
        own.with_data(grid, |data| write_vtu(path, data))
    }

    /// Adds the fields to the file of all outputs, which the first of them, `number` 0, begins with the points and
    /// cells of `grid`.
    ///
    /// # Errors
    /// Those of [`create_vtkhdf`] and [`append_vtkhdf`].
    pub(super) fn append(
        &self,
        path: &Path,
        grid: &Grid,
        number: usize,
    ) -> Result<(), OutputError> {
        self.with_data(grid, |data| {
            if number == 0 {
                create_vtkhdf(path, data)?;
            }
            append_vtkhdf(path, self.time, data.fields)
        })
    }

    /// Hands out the points of `grid`, which are those of the fields, its cells and the fields.
    fn with_data<T>(&self, grid: &Grid, then: impl FnOnce(&VtuData<'_>) -> T) -> T {
        let fields: Vec<Field<'_>> = self.arrays.iter().map(Array::field).collect();
        then(&VtuData {
            positions: &self.positions,
            dimension: self.dimension,
            time: self.time,
            cells: grid.cells(),
            kinds: &grid.kinds,
            fields: &fields,
            ghosts: grid.ghosts,
        })
    }
}

impl Snapshot<'_> {
    /// The fields that pictures of outputs are drawn from.
    pub(super) fn drawn(&self) -> Snapshot<'_> {
        let varies = |array: &&Array<'_>| !is_constant(array.name);
        let arrays = self.arrays.iter().filter(varies);
        Snapshot {
            arrays: arrays
                .map(|array| array.with(Cow::Borrowed(&array.values)))
                .collect(),
            positions: self.positions.clone(),
            ..*self
        }
    }

    /// Fields of some names at some points, without their places.
    pub(super) fn select(&self, names: &[&str], points: &[u32]) -> PointFields {
        let wanted = |array: &&Array<'_>| names.contains(&array.name);
        let own = |array: &Array<'_>| {
            let values = of_points(&array.values, array.components, points);
            (array.name.to_owned(), (array.components, values))
        };
        PointFields {
            time: Some(self.time),
            positions: Vec::new(),
            arrays: self.arrays.iter().filter(wanted).map(own).collect(),
        }
    }

    /// The fields at some points.
    fn at(&self, points: &[u32]) -> Snapshot<'static> {
        let own = |array: &Array<'_>| {
            array.with(of_points(&array.values, array.components, points).into())
        };
        Snapshot {
            arrays: self.arrays.iter().map(own).collect(),
            positions: of_points(&self.positions, self.dimension, points),
            dimension: self.dimension,
            time: self.time,
        }
    }
}

/// Writes the index of the pieces that all processes wrote.
///
/// # Errors
/// Those of [`write_pvtu`].
pub(super) fn write_index<const D: usize>(
    path: &Path,
    model: &Model<D>,
    state: &State,
    pieces: &[String],
) -> Result<(), OutputError> {
    let arrays = arrays(model, state);
    let fields: Vec<Field<'_>> = arrays.iter().map(Array::field).collect();
    write_pvtu(path, &fields, pieces)
}

/// All fields of a state, for a program.
pub(in crate::run) fn values<const D: usize>(model: &Model<D>, state: &State) -> Vec<FieldValues> {
    let owned = |array: Array<'_>| FieldValues {
        name: array.name,
        unit: array.unit,
        components: array.components,
        values: array.values.into_owned(),
    };
    arrays(model, state).into_iter().map(owned).collect()
}

/// Values of some points, `per_point` each.
fn of_points(values: &[f64], per_point: usize, points: &[u32]) -> Vec<f64> {
    let own = |point: &u32| &values[*point as usize * per_point..][..per_point];
    points.iter().flat_map(own).copied().collect()
}

/// All fields that the scene names.
fn arrays<'a, const D: usize>(model: &'a Model<D>, state: &'a State) -> Vec<Array<'a>> {
    let mut arrays = Vec::new();
    if let Some(flow) = &model.flow {
        arrays.extend(of_flow(model, flow, state));
    }
    if let Some(fractures) = &model.fracture_flow {
        arrays.push(array("aperture", "m", 1, &fractures.aperture[..]));
        if model.has_crack_content() {
            arrays.push(array("crack_void", volume_unit(D), 1, voids(model)));
        }
    }
    if let Some(solid) = &model.solid {
        let fluid = model.fluid_traction(&state.pressure);
        arrays.extend(of_solid(solid, state, &fluid));
    }
    let material: Vec<f64> = model.material.iter().map(|&m| f64::from(m)).collect();
    let volume = &model.cloud.volume[..];
    arrays.push(array("volume", volume_unit(D), 1, volume));
    arrays.push(array("material_id", "", 1, material));
    let own = |own: &'a VaryingProperty| array(own.name, own.unit, 1, &own.values[..]);
    arrays.extend(model.varying.iter().map(own));
    arrays
}

/// Volume without fluid in cracks per point, m^D.
fn voids<const D: usize>(model: &Model<D>) -> Vec<f64> {
    let mut dense = vec![0.0; model.cloud.len()];
    for (point, void) in model.voids() {
        dense[point as usize] = void.volume;
    }
    dense
}

/// Unit of a volume: in the plane that of an area.
fn volume_unit(dimension: usize) -> &'static str {
    match dimension {
        2 => "m^2",
        _ => "m^3",
    }
}

fn array<'a>(
    name: &'static str,
    unit: &'static str,
    components: usize,
    values: impl Into<Cow<'a, [f64]>>,
) -> Array<'a> {
    Array {
        name,
        unit,
        components,
        values: values.into(),
    }
}

/// Pressure, Darcy velocity and permeability.
fn of_flow<'a, const D: usize>(
    model: &'a Model<D>,
    flow: &FlowModel<D>,
    state: &'a State,
) -> [Array<'a>; 3] {
    let velocity: Vec<f64> = flow
        .velocity(&state.pressure, state.time)
        .iter()
        .flat_map(|v| v.iter().copied())
        .collect();
    [
        array("pressure", "Pa", 1, &state.pressure[..]),
        array("velocity", "m/s", D, velocity),
        array("permeability", "m^2", 1, &model.permeability[..]),
    ]
}

/// Displacement, effective stress (tension positive), volumetric strain, and the velocity of the
/// solid if it has one.
fn of_solid<'a, const D: usize>(
    solid: &SolidModel<D>,
    state: &'a State,
    fluid: &[f64],
) -> Vec<Array<'a>> {
    let initial = |point: usize| (solid.initial_components.get(point)).map_or([0.0; 6], |own| *own);
    let slopes = solid.slopes(&state.displacement, &state.walls);
    let stress: Vec<f64> = match &solid.damage {
        None => (slopes.iter().enumerate())
            .flat_map(|(point, slope)| {
                let strain = (slope + slope.transpose()) * 0.5;
                components(solid.elastic.stress_at(point, &strain), &initial(point))
            })
            .collect(),
        Some(damage) => (slopes.iter().enumerate())
            .flat_map(|(point, slope)| {
                damaged_stress(solid, damage, state, point, slope, (&initial(point), fluid))
            })
            .collect(),
    };
    let volumetric: Vec<f64> = slopes.iter().map(Matrix::trace).collect();
    let mut arrays = vec![
        array("displacement", "m", D, state.shown_displacement()),
        array("effective_stress", "Pa", 6, stress),
        array("volumetric_strain", "", 1, volumetric),
    ];
    if let Some(damage) = &solid.damage {
        arrays.push(array("damage", "", 1, damage.of(&state.history)));
    }
    if !state.velocity.is_empty() {
        arrays.push(array("solid_velocity", "m/s", D, &state.velocity[..]));
    }
    arrays
}

/// Effective stress of a point with damage, Pa: xx, yy, zz, xy, yz, xz. Across a plane the initial
/// stress is lost as rock breaks like that within it.
fn damaged_stress<const D: usize>(
    solid: &SolidModel<D>,
    damage: &Damage<D>,
    state: &State,
    point: usize,
    slope: &Matrix<D>,
    (initial, fluid): (&[f64; 6], &[f64]),
) -> [f64; 6] {
    let strain = (slope + slope.transpose()) * 0.5;
    let own = damage.point(&solid.elastic, state.view().damage(fluid), point);
    let response = damage.law.response(&own, &strain, 0.0);
    let lame = solid.elastic.lame[point];
    if damage.law.model == DamageModel::Split {
        // What a crack releases across the plane is λ/M of its traction.
        let mut stress = stress(lame, slope, initial);
        stress[2] -= lame.lambda * response.plane.opening;
        for (k, own) in stress.iter_mut().enumerate() {
            let (a, b) = TENSOR[k];
            if a.max(b) < D {
                *own = response.stress[(a, b)];
            }
        }
        return stress;
    }
    let left = damage.law.degradation(response.damage);
    let [degraded_stress, intact_stress] = damage.law.across(lame, &strain);
    let component = |k: usize| match TENSOR[k] {
        (a, b) if a.max(b) < D => response.stress[(a, b)],
        (a, b) if a == b => left * (degraded_stress + initial[k]) + intact_stress,
        _ => left * initial[k],
    };
    std::array::from_fn(component)
}

/// Effective stress C:ε + σ⁰ of a displacement gradient, Pa: xx, yy, zz, xy, yz, xz.
///
/// In plane strain zz is λ tr(ε), and yz and xz are those of σ⁰.
fn stress<const D: usize>(lame: Lame, slope: &Matrix<D>, initial: &[f64; 6]) -> [f64; 6] {
    let strain = (slope + slope.transpose()) * 0.5;
    components(
        (lame.stress(&strain), lame.lambda * strain.trace()),
        initial,
    )
}

/// Components of a stress in the plane and across it, on top of those of σ⁰.
fn components<const D: usize>((stress, across): (Matrix<D>, f64), initial: &[f64; 6]) -> [f64; 6] {
    let component = |(a, b): (usize, usize)| match a.max(b) < D {
        true => stress[(a, b)],
        false if a == b => across,
        false => 0.0,
    };
    std::array::from_fn(|k| component(TENSOR[k]) + initial[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Timers;

    const LAME: Lame = Lame {
        lambda: 4.0,
        mu: 3.0,
    };

    fn assert_close(found: [f64; 6], expected: [f64; 6]) {
        let near = found
            .iter()
            .zip(expected)
            .all(|(f, e)| (f - e).abs() < 1e-12);
        assert!(near, "{found:?} {expected:?}");
    }

    /// By hand: ε = (2, 1; 1, 3), tr ε = 5, σ = 4·5 + 6 ε; the thickness cannot stretch.
    #[test]
    fn plane_strain_has_a_stress_across_the_plane() {
        let slope = Matrix::<2>::new(2.0, 0.5, 1.5, 3.0);
        let found = stress(LAME, &slope, &[0.0; 6]);
        assert_close(found, [32.0, 38.0, 20.0, 6.0, 0.0, 0.0]);
    }

    /// By hand: only ε_yz = 1/2 and ε_xz = 1 differ from zero, σ = 6 ε, on top of 1 to 6.
    #[test]
    fn shear_in_space_stands_in_the_order_of_the_file_on_top_of_the_initial_stress() {
        let slope = Matrix::<3>::new(0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let found = stress(LAME, &slope, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_close(found, [1.0, 2.0, 3.0, 4.0, 8.0, 12.0]);
    }

    /// By hand, with λ = μ = 400 MPa and ε_yy = −1e-4: squeezed rock carries λ tr(ε) across the plane,
    /// broken or not; what it had there before is lost as it breaks.
    #[test]
    fn damage_keeps_the_stress_across_the_plane() {
        let initial = [0.0, 0.0, -2e6, 0.0, 0.0, 0.0];
        for split in ["spectral", "volumetric-deviatoric", "none"] {
            let damage = format!("damage={{length_scale=0.5, model=\"paper\", split=\"{split}\"}}");
            let plan = super::super::tests::plan(&[
                "materials.rock.fracture_energy=1e6",
                "mechanics.initial_stress={zz=\"-2 MPa\"}",
                "mechanics.boundary.top={free=true}",
                &damage,
            ]);
            let model = Model::<2>::build(&plan, &mut Timers::default()).unwrap();
            let mut state = State::initial(&model);
            let solid = model.solid.as_ref().unwrap();
            let damage = solid.damage.as_ref().unwrap();
            let slope = Matrix::<2>::new(0.0, 0.0, 0.0, -1e-4);
            let found = damaged_stress(solid, damage, &state, 14, &slope, (&initial, &[]));
            for (found, exact) in found.iter().zip([-4e4, -1.2e5, -2.04e6, 0.0, 0.0, 0.0]) {
                assert!((found - exact).abs() < 20.0, "{split}: {found} {exact}");
            }
            state.history.fill(1e12);
            let [.., across, _, _, _] =
                damaged_stress(solid, damage, &state, 14, &slope, (&initial, &[]));
            let exact = match split {
                "spectral" => -4e4,
                // The volume alone is kept: −(λ + 2/3 μ) 1e-4.
                "volumetric-deviatoric" => -2.0 / 3.0 * 1e5,
                _ => 0.0,
            };
            let lost = 2.1e6 * damage.law.residual_stiffness + 20.0;
            assert!((across - exact).abs() < lost, "{split}: {across} {exact}");
        }
    }
}
