//! How far to walk along a direction in which a potential falls.

use super::DescentSettings;
use crate::schemes::StepError;

/// A place along the direction.
pub(super) struct Reached<T> {
    /// Length in units of the direction.
    pub length: f64,
    /// How far the potential has fallen, J.
    pub fallen: f64,
    /// Slope with which it still falls, J per unit of length.
    pub left: f64,
    /// What was found there.
    pub found: T,
}

/// Finds a place where the potential has fallen enough for its `slope` at the start; `None` if there is
/// none. Differences below `rounding` (J) say nothing.
///
/// Evaluations cost little beside the direction, so that a slope that lasts is followed.
///
/// # Errors
/// Those of `visit`, which evaluates a length.
pub(super) fn line_search<T>(
    settings: &DescentSettings,
    slope: f64,
    rounding: f64,
    mut visit: impl FnMut(f64) -> Result<Reached<T>, StepError>,
) -> Result<Option<Reached<T>>, StepError> {
    let mut length = 1.0;
    for _ in 0..settings.most_cuts {
        let reached = visit(length)?;
        if reached.fallen >= settings.sufficient_decrease * length * slope - rounding {
            let ends = length < 1.0 || reached.left <= settings.curvature_condition * slope;
            return match ends {
                true => Ok(Some(reached)),
                false => expand(settings, slope, reached, visit).map(Some),
            };
        }
        // Minimum of the parabola through both values and the slope at the start.
        let bent = 2.0 * (slope * length - reached.fallen);
        let best = if bent > 0.0 {
            slope * length / bent
        } else {
            0.5
        };
        length *= best.clamp(0.1, 0.5);
    }
    Ok(None)
}

/// Longer steps as long as the potential keeps falling.
fn expand<T>(
    settings: &DescentSettings,
    slope: f64,
    first: Reached<T>,
    mut visit: impl FnMut(f64) -> Result<Reached<T>, StepError>,
) -> Result<Reached<T>, StepError> {
    let mut best = first;
    let mut before = slope;
    while best.left > settings.curvature_condition * slope && best.length < settings.longest_step {
        // Where the slope would vanish if it went on changing as it did, but not too far.
        let step = match before > best.left {
            true => (best.left / (before - best.left)).min(3.0),
            false => 3.0,
        };
        let next = visit(best.length * (1.0 + step.max(0.5)))?;
        if next.fallen <= best.fallen || next.left < -slope {
            break;
        }
        before = best.left;
        best = next;
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(potential: impl Fn(f64) -> f64, slope: f64) -> (f64, usize) {
        let mut visits = 0;
        let visit = |length: f64| {
            visits += 1;
            let by = 1e-6 * length;
            let left = (potential(length - by) - potential(length + by)) / (2.0 * by);
            let fallen = potential(0.0) - potential(length);
            Ok(Reached {
                length,
                fallen,
                left,
                found: (),
            })
        };
        let found = line_search(&DescentSettings::default(), slope, 0.0, visit)
            .unwrap()
            .unwrap();
        (found.length, visits)
    }

    #[test]
    fn a_good_step_is_kept_an_overshoot_cut_and_a_long_slope_followed() {
        // A parabola with its minimum at 1, at 0.2, and at 30.
        let parabola = |minimum: f64| move |x: f64| (x - minimum).powi(2);
        assert_eq!(walk(parabola(1.0), 2.0), (1.0, 1));
        let (short, _) = walk(parabola(0.2), 0.4);
        assert!((short - 0.2).abs() < 1e-9, "{short}");
        let (long, visits) = walk(parabola(30.0), 60.0);
        assert!(
            (20.0..=40.0).contains(&long) && visits < 8,
            "{long} {visits}"
        );
    }
}
