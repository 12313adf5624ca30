//! The part of a line that lies in a rectangle.

/// The pieces of a line of corners within a rectangle, given by its lower left and upper right
/// corner; all lengths in one unit.
pub(super) fn clipped(line: &[[f64; 2]], bounds: [[f64; 2]; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    for ends in line.windows(2) {
        let Some((from, to)) = segment(ends[0], ends[1], bounds) else {
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The part of one segment within the rectangle (Liang and Barsky 1984). Ends inside stay exact.
fn segment(
    from: [f64; 2],
    to: [f64; 2],
    [low, high]: [[f64; 2]; 2],
) -> Option<([f64; 2], [f64; 2])> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        let (below, above) = (low[axis] - from[axis], high[axis] - from[axis]);
        if step.abs() < f64::MIN_POSITIVE {
            if below > 0.0 || above < 0.0 {
                return None;
            }
            continue;
        }
        let (first, second) = (below / step, above / step);
        enter = enter.max(first.min(second));
        leave = leave.min(first.max(second));
    }
    let at = |part: f64| [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
    let start = if enter > 0.0 { at(enter) } else { from };
    let end = if leave < 1.0 { at(leave) } else { to };
    (enter < leave).then_some((start, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [[f64; 2]; 2] = [[0.0, 0.0], [1.0, 1.0]];

    #[test]
    fn a_line_inside_stays_as_it_is() {
        let line = [[0.1, 0.2], [0.7, 0.3], [1.0, 1.0]];
        assert_eq!(clipped(&line, UNIT), [line.to_vec()]);
    }

    #[test]
    fn a_line_through_a_side_ends_there() {
        let pieces = clipped(&[[0.5, 0.5], [1.5, 0.5]], UNIT);
        assert_eq!(pieces, [vec![[0.5, 0.5], [1.0, 0.5]]]);
        let pieces = clipped(&[[0.5, -3.0], [0.5, 3.0]], UNIT);
        assert_eq!(pieces, [vec![[0.5, 0.0], [0.5, 1.0]]]);
    }

    #[test]
    fn a_line_that_leaves_and_returns_becomes_two_pieces() {
        let line = [[0.5, 0.25], [1.5, 0.25], [1.5, 0.75], [0.5, 0.75]];
        assert_eq!(clipped(&line, UNIT).len(), 2);
    }

    #[test]
    fn nothing_is_left_of_lines_outside_or_without_length() {
        for line in [
            [[1.5, 0.0], [1.5, 1.0]],
            [[0.0, 1.5], [1.5, 1.2]],
            [[-1.0, 0.5], [0.5, 2.5]],
            [[2.0, 2.0], [2.0, 2.0]],
        ] {
            assert!(clipped(&line, UNIT).is_empty(), "{line:?}");
        }
        assert!(clipped(&[[0.5, 0.5]], UNIT).is_empty());
    }
}
