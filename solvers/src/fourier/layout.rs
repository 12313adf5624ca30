//! Where the unknowns of a lattice lie: lines along one axis, lanes across it.

use crate::lattice::Lattice;
use crate::{Problem, SolveError};

use super::BACKEND;
use super::transform::Transform;

/// Points as lines along one axis; the axes across are transformed, and every wavenumber of theirs, a lane,
/// has a line of its own.
pub(super) struct Layout {
    /// Unknowns of a point.
    pub(super) unknowns: usize,
    /// Points of a line.
    pub(super) length: usize,
    /// Points from one of a line to the next, in the order of the problem.
    pub(super) stride: usize,
    /// The axes across.
    pub(super) across: Vec<Across>,
}

/// An axis across the lines.
pub(super) struct Across {
    /// Transforms along it.
    pub(super) transform: Transform,
    /// Points from one of it to the next, in the order of the problem.
    pub(super) stride: usize,
}

impl Layout {
    /// The layout of a problem.
    ///
    /// # Errors
    /// [`SolveError::Refused`] where it is no lattice whose rows repeat along all axes but one.
    pub(super) fn of(problem: &Problem<'_>) -> Result<Self, SolveError> {
        BACKEND.takes_points(problem.symmetry, problem.lattice)?;
        let lattice = problem
            .lattice
            .map_err(|reason| SolveError::InvalidProblem {
                reason: reason.to_owned(),
            })?;
        let line = line_axis(lattice);
        let mut stride = 1;
        let mut layout = Layout {
            unknowns: problem.unknowns_per_point,
            length: 1,
            stride: 1,
            across: Vec::new(),
        };
        for (axis, own) in lattice.axes.iter().enumerate() {
            match &own.mirrors {
                Ok(mirrors) if axis != line => layout.across.push(Across {
                    transform: Transform::new(own.count, mirrors),
                    stride,
                }),
                _ => (layout.length, layout.stride) = (own.count, stride),
            }
            stride *= own.count;
        }
        Ok(layout)
    }

    /// Rows of a line: its unknowns.
    pub(super) fn rows(&self) -> usize {
        self.length * self.unknowns
    }

    /// Number of wavenumbers.
    pub(super) fn lanes(&self) -> usize {
        self.across.iter().map(|own| own.transform.slots).product()
    }

    /// Points across the lines, along the axis of this number; 1 where there is none.
    pub(super) fn count(&self, number: usize) -> usize {
        let own = self.across.get(number);
        own.map_or(1, |own| own.transform.count)
    }

    /// Wavenumbers along the axis of this number; 1 where there is none.
    pub(super) fn slots(&self, number: usize) -> usize {
        let own = self.across.get(number);
        own.map_or(1, |own| own.transform.slots)
    }

    /// First wavenumber of an unknown along the axis of this number.
    pub(super) fn first(&self, number: usize, unknown: usize) -> usize {
        let own = self.across.get(number);
        own.map_or(0, |own| own.transform.first(unknown))
    }

    /// The point at these places along the lines and across.
    pub(super) fn point(&self, along: usize, places: [usize; 2]) -> usize {
        let across = self.across.iter().zip(places);
        along * self.stride + across.map(|(own, place)| own.stride * place).sum::<usize>()
    }

    /// Places of a point along the lines and across.
    pub(super) fn places(&self, point: usize) -> (usize, [usize; 2]) {
        let across = std::array::from_fn(|number| {
            let own = self.across.get(number);
            own.map_or(0, |own| point / own.stride % own.transform.count)
        });
        (point / self.stride % self.length, across)
    }

    /// Lane of a point's place if places were wavenumbers, shifted by the first ones of an unknown.
    pub(super) fn lane(&self, unknown: usize, places: [usize; 2]) -> usize {
        let slot = |number: usize| places[number] + self.first(number, unknown);
        slot(1) * self.slots(0) + slot(0)
    }
}

/// The axis that is not transformed: the one that cannot be, else the shortest, which leaves the most lines.
fn line_axis(lattice: &Lattice) -> usize {
    let uneven = lattice.uneven().next().map(|(axis, _)| axis);
    let shortest = (0..lattice.axes.len())
        .rev()
        .min_by_key(|axis| lattice.axes[*axis].count);
    uneven.or(shortest).unwrap_or(0)
}
