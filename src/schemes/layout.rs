//! The monolithic matrix: where displacement and pressure lie in it, and its values.

use perifrac_solvers::CsrMatrix;

use super::{StepError, coupling_of, flow_of, solid_of};
use crate::model::{Coupling, FlowModel, Model, SolidModel};

/// The matrix of displacement and scaled pressure, refilled when the coefficient of L changes.
pub struct BlockMatrix {
    /// Where the blocks lie.
    pub layout: Layout,
    /// Values of K and Q, scaled; entries between pressures are zero.
    template: Vec<f64>,
    /// The matrix as last filled.
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
        let (layout, matrix) = Layout::new(flow, solid, coupling)?;
        let square = layout.scale * layout.scale;
        Ok(BlockMatrix {
            template: layout.template(&matrix, solid, coupling),
            is_fixed: flow.fixed_mask(),
            schur_diagonal: coupling.fixed_stress.iter().map(|b| square * b).collect(),
            layout,
            matrix,
        })
    }

    /// Fills in S + a L, with fixed pressures cut off.
    pub fn fill<const D: usize>(&mut self, flow: &FlowModel<D>, a: f64) {
        let layout = &self.layout;
        let square = layout.scale * layout.scale;
        let values = self.matrix.data_mut();
        values.copy_from_slice(&self.template);
        for (&place, conductance) in layout.exchange.iter().zip(&flow.conductance) {
            values[place as usize] -= square * a * conductance;
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
        let points = solid.points.union(&flow.pattern)?;
        let pattern = points.expanded(D + 1)?;
        // Places in the expanded pattern of the entry between two pressures.
        let place = |row: usize, column: usize| {
            let (start, width) = (points.row(row).start, points.row(row).len());
            let within = points.find(row, column)? - start;
            let first = start * (D + 1) * (D + 1) + D * width * (D + 1);
            Some((first + within * (D + 1) + D) as u32)
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
        Ok((layout, pattern.into_matrix()))
    }

    /// K and −c Q in their places.
    fn template<const D: usize>(
        &self,
        matrix: &CsrMatrix,
        solid: &SolidModel<D>,
        coupling: &Coupling,
    ) -> Vec<f64> {
        let mut values = vec![0.0; matrix.nnz()];
        let width = D + 1;
        let mut add = |row: usize, column: usize, value: f64| {
            if let Some(place) = matrix.nnz_index(row, column) {
                values[place.0] += value;
            }
        };
        for (row, entries) in solid.stiffness.outer_iterator().enumerate() {
            for (column, value) in entries.iter() {
                let unknown = |u: usize| u / D * width + u % D;
                add(unknown(row), unknown(column), *value);
            }
        }
        let elastic = &solid.elastic;
        let families = &elastic.around.families;
        for owner in 0..elastic.points() {
            let strength = -self.scale * coupling.divergence.weight[owner];
            for bond in families.family(owner) {
                let (weight, sign) = (elastic.gradient.weight[bond], elastic.signs(bond));
                let end = families.neighbour(bond);
                for axis in 0..D {
                    let pressure = owner * width + D;
                    for (point, entry) in [(end, sign[axis] * weight[axis]), (owner, -weight[axis])]
                    {
                        add(pressure, point * width + axis, strength * entry);
                        add(point * width + axis, pressure, strength * entry);
                    }
                }
            }
        }
        values
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
