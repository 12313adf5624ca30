//! The matrix of displacement and pressure of a breaking solid: all of its blocks change.

use perifrac_solvers::CsrMatrix;

use crate::geometry::Vector;
use crate::model::{Coupling, CrackFlow, FlowModel, SolidModel};
use crate::operators::Response;
use crate::parallel;
use crate::schemes::StepError;
use crate::schemes::descent::TangentMatrix;
use crate::schemes::layout::Layout;

/// The monolithic matrix with the place of every entry of its blocks.
pub(crate) struct FractureBlock {
    /// Where the blocks lie.
    pub layout: Layout,
    /// The matrix as last filled.
    pub matrix: CsrMatrix,
    /// Iterate of every entry of K.
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
    pub(crate) fn new<const D: usize>(
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
    pub(crate) fn fill<const D: usize>(
        &mut self,
        stiffness: &[f64],
        solid: &SolidModel<D>,
        flow: &FlowModel<D>,
        (coupling, cracks): (&Coupling, Option<&CrackFlow<D>>),
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
            // Pores in cracks are sealed.
            let strength = match cracks.is_some_and(|cracks| cracks.is_wet(owner)) {
                true => continue,
                false => -scale * coupling.divergence.weight[owner],
            };
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

impl FractureBlock {
    /// Adds what open cracks couple: opening of their fluid, and what it yields, at a response with its tangents.
    ///
    /// With the factors β of the pressures in the traction, strain and pressures bring the opening at fixed damage,
    /// and by the softening of damage with the derivative of the driving energy.
    pub(crate) fn add_cracks<const D: usize>(
        &mut self,
        solid: &SolidModel<D>,
        cracks: &CrackFlow<D>,
        coupling: &Coupling,
        tangent: &TangentMatrix<D>,
        response: &Response<D>,
    ) {
        let (elastic, families) = (&solid.elastic, &solid.elastic.around.families);
        for (owner, plane) in response.planes.iter().enumerate().filter(|(_, p)| p.open) {
            let volume = elastic.around.cloud.volume[owner];
            let biot = coupling.divergence.weight[owner] / volume;
            let pressing: Vec<(usize, f64)> = cracks.pressing(owner, biot).collect();
            if pressing.is_empty() {
                continue;
            }
            let parting = plane.parting * volume;
            let (softening, drive) = tangent.softening(elastic, owner);
            let soft = softening * plane.strain;
            for (k, bond) in families.family(owner).enumerate() {
                let mut content = parting * elastic.gradient.weight[bond];
                if let Some(drive) = drive.get(k) {
                    content += drive * soft;
                }
                self.add_content(solid, (owner, bond), &content, &pressing);
            }
            let yields = volume * (plane.yielding + soft * plane.strain);
            self.add_storage(yields, &pressing);
        }
        let values = self.matrix.data_mut();
        self.cut
            .iter()
            .for_each(|place| values[*place as usize] = 0.0);
    }

    /// Content of a bond (m^(D−1) per metre) in the rows of the pressures that act on it.
    fn add_content<const D: usize>(
        &mut self,
        solid: &SolidModel<D>,
        (owner, bond): (usize, usize),
        content: &Vector<D>,
        pressing: &[(usize, f64)],
    ) {
        let width = D + 1;
        let end = solid.elastic.around.families.neighbour(bond);
        let sign = solid.elastic.signs(bond);
        for &(point, factor) in pressing {
            let row = point * width + D;
            for axis in 0..D {
                let entry = -self.layout.scale * factor * content[axis];
                for (column, value) in [
                    (end * width + axis, entry * sign[axis]),
                    (owner * width + axis, -entry),
                ] {
                    self.add(row, column, value);
                    self.add(column, row, value);
                }
            }
        }
    }

    /// Storage (m^D/Pa) among the pressures that act on a crack.
    fn add_storage(&mut self, yields: f64, pressing: &[(usize, f64)]) {
        let (width, square) = (self.layout.dimension + 1, self.layout.scale.powi(2));
        for &(row, one) in pressing {
            for &(column, other) in pressing {
                let value = -square * yields * one * other;
                self.add(row * width + width - 1, column * width + width - 1, value);
            }
        }
    }

    /// Cuts off the pressures of points, which stay as they are.
    pub(crate) fn hold_pressures(&mut self, points: impl Iterator<Item = usize>) {
        let width = self.layout.dimension + 1;
        for row in points.map(|point| point * width + width - 1) {
            let columns = self.matrix.indptr().outer_inds_sz(row);
            for k in columns {
                let column = self.matrix.indices()[k] as usize;
                let mirrored = self.matrix.nnz_index(column, row).filter(|_| column != row);
                if let Some(mirrored) = mirrored {
                    self.matrix.data_mut()[k] = 0.0;
                    self.matrix.data_mut()[mirrored.0] = 0.0;
                }
            }
        }
    }

    fn add(&mut self, row: usize, column: usize, value: f64) {
        if let Some(place) = self.matrix.nnz_index(row, column) {
            self.matrix.data_mut()[place.0] += value;
        }
    }
}

/// Iterate of every entry of K in the matrix.
fn stiffness_places<const D: usize>(solid: &SolidModel<D>, matrix: &CsrMatrix) -> Vec<u32> {
    let width = D + 1;
    let unknown = |u: usize| u / D * width + u % D;
    let offsets = solid.stiffness.indptr();
    let columns = solid.stiffness.indices();
    let row = |row: usize| {
        let range = offsets.outer_inds_sz(row);
        let place = move |&column: &u32| place(matrix, unknown(row), unknown(column as usize));
        columns[range].iter().map(place)
    };
    parallel::gather(solid.unknowns(), |own, all| all.extend(row(own)))
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
    parallel::gather(families.len(), |owner, all| all.extend(family(owner)))
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
