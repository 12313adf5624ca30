//! Points that close where hourglass energy alone has broken them.
//!
//! In the split model hourglass energy drives damage where faces do not stick, and nothing does where they do. A point
//! that has just opened by next to nothing, in a strongly bent field, is thus driven far beyond its history, and would
//! be whole again if it closed: the energy is higher there by what the damage had released, forces jump, and no
//! equilibrium lies between. What opened has broken, so such a point keeps its damage.

use crate::operators::Response;

/// Raises the history (J/m³, shape `(n,)`) of points that are open in `here` and closed in `there` to what drove them
/// in `here`; whether there are any. The response `here` stays what it is.
pub(super) fn keep_broken<const D: usize>(
    here: &Response<D>,
    there: &Response<D>,
    history: &mut [f64],
) -> bool {
    let planes = here.planes.iter().zip(&there.planes);
    let mut kept = false;
    for ((planes, driving), history) in planes.zip(&here.driving).zip(history) {
        let closes = planes.0.open && !planes.1.open;
        if closes && *driving > *history {
            *history = *driving;
            kept = true;
        }
    }
    kept
}
