//! Series of values as curves on the plot.

use plotters_backend::DrawingBackend;

use super::axes::{Axis, Frame};
use super::canvas::Canvas;
use super::decimate::{along, decimated, thinned};
use super::legend::Look;
use super::units::{axis_label, engineering, split_label};
use super::{Drawn, Place};
use super::{LinePlot, LineStyle, Series};

/// Most marks of one series; more are thinned evenly.
const MOST_MARKS: usize = 400;

/// Values of a solid curve up to which each has its mark; of longer ones some have.
const ALL_MARKED: usize = 24;

/// Marks of a longer solid curve.
const SPARSE_MARKS: usize = 7;

/// An axis with its label, both in the units shown.
pub(super) struct Shown {
    pub axis: Axis,
    pub divisor: f64,
    pub label: String,
}

/// A series as it appears: pieces between gaps, in pixels.
pub(super) struct Curve {
    pub look: Look,
    pub pieces: Vec<Vec<Place>>,
}

/// The horizontal axis that holds all curves.
pub(super) fn shown_x(plot: &LinePlot<'_>) -> Shown {
    let (mut axis, constant) = Axis::covering(pairs(plot).map(|(x, _)| x), plot.x_log);
    if !constant && has_marks(plot) {
        axis = widened(axis, 0.02);
    }
    shown(axis, plot.x_label)
}

/// The vertical axis that holds all curves.
pub(super) fn shown_y(plot: &LinePlot<'_>) -> Shown {
    let (axis, constant) = Axis::covering(pairs(plot).map(|(_, y)| y), plot.y_log);
    let mut wide = if constant { axis } else { widened(axis, 0.05) };
    // Curves of one sign that come close to zero are easier to judge with zero in sight.
    if !plot.y_log && axis.low >= 0.0 && axis.low < 0.2 * axis.high {
        wide.low = 0.0;
    }
    if !plot.y_log && axis.high <= 0.0 && axis.high > 0.2 * axis.low {
        wide.high = 0.0;
    }
    shown(wide, plot.y_label)
}

/// Whether marks stand at both ends of series.
fn has_marks(plot: &LinePlot<'_>) -> bool {
    let series = plot.series.iter();
    series.clone().any(|own| own.style == LineStyle::Markers)
        || series.filter(|own| own.style == LineStyle::Line).count() > 1
}

fn widened(axis: Axis, part: f64) -> Axis {
    Axis {
        low: axis.value(-part),
        high: axis.value(1.0 + part),
        ..axis
    }
}

fn shown(axis: Axis, label: &str) -> Shown {
    let (name, unit) = split_label(label);
    // Powers of ten stand at the marks of a logarithmic axis already.
    let largest = if axis.logarithmic {
        1.0
    } else {
        axis.high.abs().max(axis.low.abs())
    };
    let unit = engineering(unit, largest);
    let label = axis_label(name, &unit.unit);
    Shown {
        axis: axis.divided(unit.divisor),
        divisor: unit.divisor,
        label,
    }
}

/// All pairs that have a place on the plot.
pub(super) fn pairs<'a>(plot: &'a LinePlot<'_>) -> impl Iterator<Item = (f64, f64)> + 'a {
    let all = plot
        .series
        .iter()
        .flat_map(|s| s.x.iter().copied().zip(s.y.iter().copied()));
    all.filter(|&(x, y)| drawable(plot, x, y))
}

/// Whether a pair has a place on the plot.
pub(super) fn drawable(plot: &LinePlot<'_>, x: f64, y: f64) -> bool {
    let fine = |value: f64, log: bool| value.is_finite() && (!log || value > 0.0);
    fine(x, plot.x_log) && fine(y, plot.y_log)
}

/// All series as they appear in the frame.
pub(super) fn curves(
    plot: &LinePlot<'_>,
    looks: &[Look],
    frame: &Frame,
    x: &Shown,
    y: &Shown,
) -> Vec<Curve> {
    let place = |px: f64, py: f64| {
        frame.place((
            x.axis.fraction(px / x.divisor),
            y.axis.fraction(py / y.divisor),
        ))
    };
    let curve = |(series, look): (&Series<'_>, &Look)| {
        let mut pieces = vec![Vec::new()];
        for (&px, &py) in series.x.iter().zip(series.y) {
            match pieces.last_mut() {
                Some(piece) if drawable(plot, px, py) => piece.push(place(px, py)),
                _ => pieces.push(Vec::new()),
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        if series.style == LineStyle::Markers {
            pieces = vec![thinned(&pieces.concat(), MOST_MARKS)];
        } else {
            pieces
                .iter_mut()
                .for_each(|piece| *piece = decimated(piece));
        }
        Curve {
            look: *look,
            pieces,
        }
    };
    plot.series.iter().zip(looks).map(curve).collect()
}

/// Places along all curves, a few pixels apart, to find out what they cover.
pub(super) fn dense(curves: &[Curve]) -> Vec<Place> {
    let mut places = Vec::new();
    for curve in curves {
        for piece in &curve.pieces {
            places.extend_from_slice(piece);
            for pair in piece
                .windows(2)
                .filter(|_| curve.look.style != LineStyle::Markers)
            {
                let (from, to) = (pair[0], pair[1]);
                let steps = ((to.0 - from.0).hypot(to.1 - from.1) / 6.0)
                    .ceil()
                    .min(500.0);
                let at = |step: usize| {
                    let part = step as f64 / steps;
                    (
                        from.0 + part * (to.0 - from.0),
                        from.1 + part * (to.1 - from.1),
                    )
                };
                places.extend((1..steps as usize).map(at));
            }
        }
    }
    places
}

/// Draws one of `count` curves.
pub(super) fn draw_curve<B: DrawingBackend>(
    canvas: &mut Canvas<B>,
    curve: &Curve,
    count: usize,
) -> Drawn<()> {
    let look = &curve.look;
    for piece in &curve.pieces {
        if look.style == LineStyle::Thin {
            look.stroke(canvas, piece)?;
            continue;
        }
        if look.style == LineStyle::Markers || piece.len() == 1 {
            piece
                .iter()
                .try_for_each(|&place| look.mark(canvas, place))?;
            continue;
        }
        look.stroke(canvas, piece)?;
        if look.marked {
            // Of long curves others from curve to curve, so that marks show where curves coincide.
            let offset = (look.index as f64 + 0.5) / count as f64;
            let marks = match piece.len() > ALL_MARKED {
                true => along(piece, SPARSE_MARKS, offset),
                false => piece.clone(),
            };
            marks
                .into_iter()
                .try_for_each(|place| look.mark(canvas, place))?;
        }
    }
    Ok(())
}
