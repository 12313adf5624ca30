//! The matrix of displacement and pressure of a breaking solid: all of its blocks change.

use perifrac_solvers::CsrMatrix;
use rayon::prelude::*;

use crate::model::{Coupling, FlowModel, SolidModel};
use crate::schemes::StepError;
use crate::schemes::layout::Layout;

/// The monolithic matrix with the place of every entry of its blocks.
pub struct FractureBlock {
    /// Where the blocks lie.
    pub layout: Layout,
    /// The matrix as last filled.
    pub matrix: CsrMatrix,
    /// Place of every entry of K.
    stiffness: Vec<u32>,
    /// Places of what a bond couples along every axis: pressure row and displacement row of its end,
    /// and of its owner. Shape `(bonds · D,)`.
    content: Vec<[u32; 4]>,
    /// Entries of fixed pressures, which are cut off.
    cut: Vec<u32>,
}

impl FractureBlock {
    /// Builds the pattern and finds all places.
    ///
    /// # Errors
    /// [`StepError::Pattern`] for a matrix that is too large.
    pub fn new<const D: usize>(
        flow: &FlowModel<D>,
        solid: &SolidModel<D>,
        coupling: &Coupling,
    ) -> Result<Self, StepError> {
        let (layout, matrix) = Layout::new(flow, solid, coupling)?;
        Ok(FractureBlock {
            stiffness: stiffness_places(solid, &matrix),
            content: content_places(solid, &matrix),
            cut: cut_places::<D>(&matrix, &flow.fixed_mask()),
            layout,
            matrix,
        })
    }

    /// Fills in the stiffness `values`, Q and S + a L, with fixed pressures cut off.
    pub fn fill<const D: usize>(
        &mut self,
        stiffness: &[f64],
        solid: &SolidModel<D>,
        flow: &FlowModel<D>,
        coupling: &Coupling,
        a: f64,
    ) {
        let scale = self.layout.scale;
        let values = self.matrix.data_mut();
        values.fill(0.0);
        for (&place, own) in self.stiffness.iter().zip(stiffness) {
            values[place as usize] = *own;
        }
        let elastic = &solid.elastic;
        let families = &elastic.around.families;
        for owner in 0..elastic.points() {
            let strength = -scale * coupling.divergence.weight[owner];
            for bond in families.family(owner) {
                let (weight, sign) = (elastic.gradient.weight[bond], elastic.signs(bond));
                for axis in 0..D {
                    let [end, end_turned, own, own_turned] = self.content[bond * D + axis];
                    let entry = strength * weight[axis];
                    values[end as usize] += entry * sign[axis];
                    values[end_turned as usize] += entry * sign[axis];
                    values[own as usize] -= entry;
                    values[own_turned as usize] -= entry;
                }
            }
        }
        let square = scale * scale;
        for (&place, conductance) in self.layout.exchange.iter().zip(&flow.conductance) {
            values[place as usize] -= square * a * conductance;
        }
        for &(point, place) in &self.layout.diagonal {
            values[place as usize] -= square * flow.capacity[point as usize];
        }
        self.cut
            .iter()
            .for_each(|place| values[*place as usize] = 0.0);
    }
}

/// Place of every entry of K in the matrix.
fn stiffness_places<const D: usize>(solid: &SolidModel<D>, matrix: &CsrMatrix) -> Vec<u32> {
    let width = D + 1;
    let unknown = |u: usize| u / D * width + u % D;
    let offsets = solid.stiffness.indptr();
    let columns = solid.stiffness.indices();
    let row = |row: usize| -> Vec<u32> {
        let range = offsets.outer_inds_sz(row);
        let place = |&column: &u32| place(matrix, unknown(row), unknown(column as usize));
        columns[range].iter().map(place).collect()
    };
    (0..solid.unknowns())
        .into_par_iter()
        .flat_map_iter(row)
        .collect()
}

fn content_places<const D: usize>(solid: &SolidModel<D>, matrix: &CsrMatrix) -> Vec<[u32; 4]> {
    let (families, width) = (&solid.elastic.around.families, D + 1);
    let family = |owner: usize| {
        let pressure = owner * width + D;
        families.family(owner).flat_map(move |bond| {
            let end = families.neighbour(bond);
            (0..D).map(move |axis| {
                let [end, own] = [end, owner].map(|point| point * width + axis);
                [
                    (pressure, end),
                    (end, pressure),
                    (pressure, own),
                    (own, pressure),
                ]
                .map(|(row, column)| place(matrix, row, column))
            })
        })
    };
    (0..families.len())
        .into_par_iter()
        .flat_map_iter(family)
        .collect()
}

/// Entries off the diagonal in rows and columns of fixed pressures.
fn cut_places<const D: usize>(matrix: &CsrMatrix, is_fixed: &[bool]) -> Vec<u32> {
    let width = D + 1;
    let fixed = |unknown: usize| unknown % width == D && is_fixed[unknown / width];
    let offsets = matrix.indptr();
    let row = |row: usize| {
        let range = offsets.outer_inds_sz(row);
        range.filter(move |&k| {
            let column = matrix.indices()[k] as usize;
            column != row && (fixed(row) || fixed(column))
        })
    };
    (0..matrix.rows()).flat_map(row).map(|k| k as u32).collect()
}

/// Where an entry lies; every one that is asked for is part of the pattern.
fn place(matrix: &CsrMatrix, row: usize, column: usize) -> u32 {
    matrix
        .nnz_index(row, column)
        .map_or(u32::MAX, |place| place.0 as u32)
}
