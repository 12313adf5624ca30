//! Plane sides of prescribed pressure: the affine part of the odd mirror images.

use crate::assembly::ScalarOperator;
use crate::effects::Column;
use crate::geometry::Side;
use crate::load::Load;
use crate::operators::{MirrorContinuation, Parity};
use crate::plan::{Plan, SideCondition};

/// One side and what a pressure on it does to the points near it.
#[derive(Debug, Clone)]
pub struct BoundaryPlane {
    /// The side.
    pub side: Side,
    /// Its pressure over time, Pa.
    pub pressure: Load,
    /// Conductance between the side and each point it reaches, m^D/(Pa s).
    response: Vec<(u32, f64)>,
    /// Rate that gravity alone drives out through the side, m^D/s.
    seepage: f64,
}

impl BoundaryPlane {
    /// Brings the response to a mobility (m²/(Pa s), shape `(n,)`); without gravity.
    pub fn follow<const D: usize>(
        &mut self,
        operator: &dyn ScalarOperator<D>,
        extension: &MirrorContinuation<D>,
        mobility: &[f64],
    ) {
        self.response = response(operator, extension, mobility, self.side);
    }

    /// Adds the rate that enters the points from the side, m^D/s.
    ///
    /// Seepage is part of the rate of gravity.
    pub fn add_rate(&self, time: f64, pressure: &[f64], rate: &mut [f64]) {
        self.each_rate(time, pressure, |point, own| rate[point] += own);
    }

    /// Calls `visit(point, rate)` for every point the side reaches.
    pub fn each_rate(&self, time: f64, pressure: &[f64], mut visit: impl FnMut(usize, f64)) {
        let own = self.pressure.at(time);
        for &(point, response) in &self.response {
            let point = point as usize;
            visit(point, response * (own - pressure[point]));
        }
    }

    /// Rate that leaves through the side, net and in absolute amounts, m^D/s.
    pub fn outflow(&self, time: f64, pressure: &[f64]) -> (f64, f64) {
        let own = self.pressure.at(time);
        let start = (self.seepage, self.seepage.abs());
        self.response
            .iter()
            .fold(start, |(net, gross), &(point, response)| {
                let rate = response * (pressure[point as usize] - own);
                (net + rate, gross + rate.abs())
            })
    }

    /// Points that the side reaches.
    pub fn points(&self) -> impl Iterator<Item = usize> + '_ {
        self.response.iter().map(|&(point, _)| point as usize)
    }

    /// Adds each point's conductance to the side to `total`.
    pub fn add_leak(&self, total: &mut [f64]) {
        self.response
            .iter()
            .for_each(|&(point, response)| total[point as usize] += response);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.response.len() * size_of::<(u32, f64)>()
    }
}

/// Conductance between a side and each point it reaches, m^D/(Pa s).
fn response<const D: usize>(
    operator: &dyn ScalarOperator<D>,
    extension: &MirrorContinuation<D>,
    mobility: &[f64],
    side: Side,
) -> Vec<(u32, f64)> {
    let families = &operator.neighbourhood().families;
    let mut unit = vec![0.0; 2 * D];
    unit[side.index()] = 1.0;
    let offset = |_: usize, bond: usize| extension.wall_offset(families.image(bond), &unit);
    let force = operator.force(extension, mobility, &offset);
    let reached = (0_u32..).zip(force).filter(|(_, f)| *f != 0.0);
    reached.map(|(i, f)| (i, -f)).collect()
}

/// The sides of prescribed pressure of a plan.
pub(crate) fn walls<const D: usize>(
    plan: &Plan,
    operator: &dyn ScalarOperator<D>,
    extension: &MirrorContinuation<D>,
    mobility: &[f64],
    column: Option<&Column<D>>,
) -> Vec<BoundaryPlane> {
    let Some(flow) = &plan.flow else {
        return Vec::new();
    };
    let families = &operator.neighbourhood().families;
    let seepage = column.map_or_else(
        || vec![0.0; 2 * D],
        |column| {
            let cloud = &operator.neighbourhood().cloud;
            let weight = |owner: usize, bond: usize| {
                column.difference(cloud, families, extension, owner, bond)
            };
            operator.outflow(extension, &operator.outlets(extension), mobility, &weight)
        },
    );
    let prescribed = Side::all(D).filter(|side| extension.parity(*side) == Parity::Odd);
    prescribed
        .filter_map(|side| {
            let SideCondition::Pressure { value, .. } = &flow.sides[side.index()] else {
                return None;
            };
            Some(BoundaryPlane {
                side,
                pressure: value.clone(),
                response: response(operator, extension, mobility, side),
                seepage: seepage[side.index()],
            })
        })
        .collect()
}
