//! The monolithic matrix: where displacement and pressure lie in it, and its values.

use perifrac_solvers::CsrMatrix;

use super::{StepError, coupling_of, flow_of, solid_of};
use crate::assembly::Pattern;
use crate::model::{Coupling, FlowModel, Model, SolidModel};

/// The matrix of displacement and scaled pressure, refilled when the coefficient of L changes.
pub struct BlockMatrix {
    /// Where the blocks lie.
    pub layout: Layout,
    /// The matrix as last filled; at first K and Q, scaled, alone.
    pub matrix: CsrMatrix,
    /// Whether the pressure of a point is prescribed, shape `(n,)`.
    pub is_fixed: Vec<bool>,
    /// Storage of the fixed-stress split in the scale of the matrix: what strain adds to the block of
    /// the pressures, roughly. Shape `(n,)`.
    pub schur_diagonal: Vec<f64>,
}

impl BlockMatrix {
    /// Builds the pattern and the part of the values that never changes.
    ///
    /// # Errors
    /// [`StepError::Pattern`] for a matrix that is too large.
    pub fn new<const D: usize>(model: &Model<D>) -> Result<Self, StepError> {
        let (flow, solid, coupling) = (flow_of(model)?, solid_of(model)?, coupling_of(model)?);
        let (layout, points) = Layout::over_points(flow, solid, coupling)?;
        let mut matrix = points.expanded(D + 1)?.into_matrix();
        layout.fill(&points, solid, coupling, matrix.data_mut());
        let square = layout.scale * layout.scale;
        Ok(BlockMatrix {
            is_fixed: flow.fixed_mask(),
            schur_diagonal: coupling.fixed_stress.iter().map(|b| square * b).collect(),
            layout,
            matrix,
        })
    }

    /// Fills in S + a L, with fixed pressures cut off: all that ever changes.
    pub fn fill<const D: usize>(&mut self, flow: &FlowModel<D>, a: f64) {
        let layout = &self.layout;
        let square = layout.scale * layout.scale;
        let values = self.matrix.data_mut();
        for (&place, conductance) in layout.exchange.iter().zip(&flow.conductance) {
            values[place as usize] = 0.0 - square * a * conductance;
        }
        for (&place, own) in layout.exchange.iter().zip(&flow.stabilisation) {
            values[place as usize] -= square * own;
        }
        for &(point, place) in &layout.diagonal {
            values[place as usize] -= square * flow.capacity[point as usize];
        }
        if !flow.fixed.is_empty() {
            self.fix_rows();
        }
    }

    /// Cuts the pressures of fixed points off everything else.
    fn fix_rows(&mut self) {
        let width = self.layout.dimension + 1;
        let is_fixed = &self.is_fixed;
        let fixed = |unknown: usize| unknown % width == width - 1 && is_fixed[unknown / width];
        for (row, mut entries) in self.matrix.outer_iterator_mut().enumerate() {
            for (column, value) in entries.iter_mut() {
                if column != row && (fixed(row) || fixed(column)) {
                    *value = 0.0;
                }
            }
        }
    }
}

/// Where the blocks lie.
pub struct Layout {
    /// Dimension of space; a point has one unknown more.
    pub dimension: usize,
    /// Place of every entry of L, shape of its values.
    pub exchange: Vec<u32>,
    /// Points whose rows are stored here, with the place of their own pressure entry.
    pub diagonal: Vec<(u32, u32)>,
    /// Pa per unit of the scaled pressure.
    pub scale: f64,
}

impl Layout {
    /// Layout of a model and its matrix, still zero.
    ///
    /// # Errors
    /// [`StepError::Pattern`] for a matrix that is too large.
    pub fn new<const D: usize>(
        flow: &FlowModel<D>,
        solid: &SolidModel<D>,
        coupling: &Coupling,
    ) -> Result<(Self, CsrMatrix), StepError> {
        let (layout, points) = Self::over_points(flow, solid, coupling)?;
        Ok((layout, points.expanded(D + 1)?.into_matrix()))
    }

    /// Layout of a model and the pattern over its points, which the matrix has for D + 1 unknowns a point.
    fn over_points<const D: usize>(
        flow: &FlowModel<D>,
        solid: &SolidModel<D>,
        coupling: &Coupling,
    ) -> Result<(Self, Pattern), StepError> {
        let points = solid.points.union(&flow.pattern)?;
        let place = |row: usize, column: usize| {
            Some(Block::find::<D>(&points, row, column)?.place(D, D) as u32)
        };
        let entries = (0..flow.points()).flat_map(|row| {
            flow.pattern
                .row(row)
                .filter_map(move |k| place(row, flow.pattern.columns[k] as usize))
        });
        let layout = Layout {
            dimension: D,
            exchange: entries.collect(),
            diagonal: (0..flow.points())
                .filter_map(|row| Some((row as u32, place(row, row)?)))
                .collect(),
            scale: pressure_scale(solid, coupling),
        };
        Ok((layout, points))
    }

    /// Adds K and −c Q in their places.
    fn fill<const D: usize>(
        &self,
        points: &Pattern,
        solid: &SolidModel<D>,
        coupling: &Coupling,
        values: &mut [f64],
    ) {
        add_stiffness(points, solid, values);
        let elastic = &solid.elastic;
        let families = &elastic.around.families;
        for owner in 0..elastic.points() {
            let strength = -self.scale * coupling.divergence.weight[owner];
            // What other processes hold is not there.
            let within = Block::find::<D>(points, owner, owner);
            for bond in families.family(owner) {
                let (weight, sign) = (elastic.gradient.weight[bond], elastic.signs(bond));
                let end = families.neighbour(bond);
                let ahead = Block::find::<D>(points, owner, end);
                let back = Block::find::<D>(points, end, owner);
                for axis in 0..D {
                    let far = strength * (sign[axis] * weight[axis]);
                    let near = strength * -weight[axis];
                    let pressure = |block: &Option<Block>| Some(block.as_ref()?.place(D, axis));
                    let force = |block: &Option<Block>| Some(block.as_ref()?.place(axis, D));
                    let mut add = |place: Option<usize>, value: f64| {
                        if let Some(place) = place {
                            values[place] += value;
                        }
                    };
                    add(pressure(&ahead), far);
                    add(force(&back), far);
                    add(pressure(&within), near);
                    add(force(&within), near);
                }
            }
        }
    }
}

/// Adds K in its places.
fn add_stiffness<const D: usize>(points: &Pattern, solid: &SolidModel<D>, values: &mut [f64]) {
    let (own, stiffness) = (&solid.points, solid.stiffness.data());
    for row in 0..own.rows() {
        let columns = &own.columns[own.row(row)];
        let mut all = points.row(row).zip(&points.columns[points.row(row)]);
        for (within, column) in columns.iter().enumerate() {
            // Both are sorted.
            let Some((place, _)) = all.find(|(_, other)| *other == column) else {
                break;
            };
            let (from, to) = (
                Block::at(own, row, within, D),
                Block::at(points, row, place - points.row(row).start, D + 1),
            );
            for (a, b) in (0..D).flat_map(|a| (0..D).map(move |b| (a, b))) {
                values[to.place(a, b)] += stiffness[from.place(a, b)];
            }
        }
    }
}

/// The entries between the unknowns of two points in an expanded pattern.
struct Block {
    first: usize,
    /// Entries from one row to the next.
    stride: usize,
}

impl Block {
    /// Where displacement and pressure are the unknowns; `None` if the points do not meet.
    fn find<const D: usize>(points: &Pattern, row: usize, column: usize) -> Option<Self> {
        let within = points.find(row, column)? - points.row(row).start;
        Some(Self::at(points, row, within, D + 1))
    }

    /// The block of an entry of a row, with so many unknowns a point.
    fn at(points: &Pattern, row: usize, within: usize, unknowns: usize) -> Self {
        let range = points.row(row);
        Block {
            first: range.start * unknowns * unknowns + within * unknowns,
            stride: range.len() * unknowns,
        }
    }

    /// Place of an entry among the values.
    fn place(&self, row: usize, column: usize) -> usize {
        self.first + row * self.stride + column
    }
}

/// Pressure whose push on a point is as large as the stiffness of the point per metre.
fn pressure_scale<const D: usize>(solid: &SolidModel<D>, coupling: &Coupling) -> f64 {
    let elastic = &solid.elastic;
    let stiffness: f64 = (0..solid.unknowns())
        .filter_map(|row| solid.stiffness.get(row, row))
        .sum();
    let push: f64 = (0..elastic.points())
        .filter(|owner| solid.subdomain().owns(*owner))
        .map(|owner| {
            let family = elastic.around.families.family(owner);
            let sum: f64 = family
                .map(|bond| elastic.gradient.weight[bond].amax())
                .sum();
            coupling.divergence.weight[owner] * sum
        })
        .sum();
    let mut sums = [stiffness, push];
    solid.subdomain().sum(&mut sums);
    let stiffness = sums[0] / solid.unknowns() as f64;
    let push = sums[1] / elastic.points() as f64;
    // A power of two scales without rounding.
    match push > 0.0 {
        true => (stiffness / push).log2().round().exp2(),
        false => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Setup;

    const COLUMN: &str = r#"title = "A column"
geometry = { type = "lattice", size = ["0.9 m", "0.5 m"], points = [9, 5] }
fluid.viscosity = "1 mPa s"
flow.boundary = { left = { pressure = 0 } }
coupling.stabilisation = 0.5
time.end = "1 s"
[materials.rock]
youngs_modulus = "100 MPa"
poissons_ratio = 0.2
biot_coefficient = 0.5
permeability = "1e-12 m^2"
storage = "1.65e-10 1/Pa"
[mechanics.boundary]
left = { traction = ["10 kPa", 0] }
right = { clamped = true }
bottom = { roller = true }
"#;

    /// K and −c Q, looked up entry by entry.
    fn by_search(model: &Model<2>, layout: &Layout, matrix: &CsrMatrix) -> Vec<f64> {
        let (solid, coupling) = (solid_of(model).unwrap(), coupling_of(model).unwrap());
        let mut values = vec![0.0; matrix.nnz()];
        let mut add = |row: usize, column: usize, value: f64| {
            values[matrix.nnz_index(row, column).unwrap().0] += value;
        };
        for (row, entries) in solid.stiffness.outer_iterator().enumerate() {
            for (column, value) in entries.iter() {
                let unknown = |u: usize| u / 2 * 3 + u % 2;
                add(unknown(row), unknown(column), *value);
            }
        }
        let elastic = &solid.elastic;
        for owner in 0..elastic.points() {
            let strength = -layout.scale * coupling.divergence.weight[owner];
            for bond in elastic.around.families.family(owner) {
                let (weight, sign) = (elastic.gradient.weight[bond], elastic.signs(bond));
                let end = elastic.around.families.neighbour(bond);
                for axis in 0..2 {
                    for (point, entry) in [(end, sign[axis] * weight[axis]), (owner, -weight[axis])]
                    {
                        add(owner * 3 + 2, point * 3 + axis, strength * entry);
                        add(point * 3 + axis, owner * 3 + 2, strength * entry);
                    }
                }
            }
        }
        values
    }

    #[test]
    fn entries_in_blocks_are_those_found_one_by_one_and_coefficients_leave_no_trace() {
        let model = Model::<2>::of(&Setup::text(COLUMN).plan().unwrap()).unwrap();
        let flow = flow_of(&model).unwrap();
        let mut block = BlockMatrix::new(&model).unwrap();
        let slow = by_search(&model, &block.layout, &block.matrix);
        assert_eq!(block.matrix.data(), slow);
        block.fill(flow, 0.3);
        let once = block.matrix.clone();
        assert!(once.data() != slow);
        block.fill(flow, 7.0);
        assert!(block.matrix != once);
        block.fill(flow, 0.3);
        assert_eq!(block.matrix, once);
    }
}
