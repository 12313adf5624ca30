//! Points of a problem as a lattice whose rows of the matrix repeat: what transforms need to know.

use crate::SolveError;

/// How an unknown goes on across a plane halfway to the next point that is not there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mirror {
    /// With the same values.
    Even,
    /// With the opposite values.
    Odd,
}

/// Points on a lattice, the first axis fastest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lattice {
    /// The axes, 1 to 3 of them.
    pub axes: Vec<LatticeAxis>,
}

/// An axis of a lattice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatticeAxis {
    /// Points along it.
    pub count: usize,
    /// How each unknown of a point goes on across the lower and the upper side, shape
    /// `(unknowns_per_point,)`, where the rows of the matrix are those of an endless lattice that is the
    /// same all along the axis, folded at both sides. Where they are not, the reason in words that
    /// end a sentence, such as "the permeability varies along it".
    pub mirrors: Result<Vec<[Mirror; 2]>, String>,
}

impl Lattice {
    /// Number of points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// The axes that transforms do not take apart, with the reasons; all others must.
    pub fn uneven(&self) -> impl Iterator<Item = (usize, &str)> {
        let reasons = self.axes.iter().map(|axis| axis.mirrors.as_ref().err());
        reasons
            .enumerate()
            .filter_map(|(axis, reason)| Some((axis, reason?.as_str())))
    }

    /// Whether transforms along all axes but one leave a banded system for every wavenumber.
    ///
    /// # Errors
    /// Why not, in words that end a sentence.
    pub fn separates(&self) -> Result<(), String> {
        let uneven: Vec<String> = self
            .uneven()
            .map(|(axis, reason)| format!("along {}, {reason}", ["x", "y", "z"][axis.min(2)]))
            .collect();
        match uneven.len() {
            0 | 1 => Ok(()),
            _ => Err(format!(
                "its rows repeat along all axes but one only, and here {}",
                uneven.join("; ")
            )),
        }
    }

    /// Checks that it describes so many points with so many unknowns each.
    ///
    /// # Errors
    /// [`SolveError::InvalidProblem`].
    pub(crate) fn validate(&self, points: usize, per_point: usize) -> Result<(), SolveError> {
        let invalid = |reason: String| Err(SolveError::InvalidProblem { reason });
        if !(1..=3).contains(&self.axes.len()) || self.points() != points {
            let counts: Vec<usize> = self.axes.iter().map(|axis| axis.count).collect();
            return invalid(format!(
                "a lattice of {counts:?} is none of {points} points"
            ));
        }
        for axis in &self.axes {
            if let Ok(mirrors) = &axis.mirrors
                && (mirrors.len() != per_point || !one_grid(mirrors))
            {
                return invalid(format!(
                    "the mirrors {mirrors:?} of a lattice are none of {per_point} unknowns a point"
                ));
            }
        }
        Ok(())
    }
}

/// Whether all unknowns have their wavenumbers in common: both sides alike for all, or different for all.
fn one_grid(mirrors: &[[Mirror; 2]]) -> bool {
    let alike = |own: &[Mirror; 2]| own[0] == own[1];
    mirrors
        .windows(2)
        .all(|pair| alike(&pair[0]) == alike(&pair[1]))
}
