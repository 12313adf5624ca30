//! Fewer vertices for the same picture, and dashes.

use super::Place;

/// Most dashes of one curve; longer curves get longer dashes.
const MOST_DASHES: f64 = 500.0;

/// Most vertices of one curve, reached only by curves that run back and forth.
const MOST_VERTICES: usize = 4000;

/// Keeps of all neighbouring vertices in one column of pixels the first, lowest, highest and last:
/// the drawn curve covers the same pixels.
pub(super) fn decimated(places: &[Place]) -> Vec<Place> {
    let mut kept: Vec<Place> = Vec::new();
    for column in places.chunk_by(|a, b| a.0.floor() as i64 == b.0.floor() as i64) {
        let extreme = |sign: f64| {
            let key = |&(index, place): &(usize, &Place)| (sign * place.1, index);
            let best = column.iter().enumerate().map(|pair| (key(&pair), pair.0));
            best.min_by(|a, b| a.0.0.total_cmp(&b.0.0))
                .map_or(0, |(_, index)| index)
        };
        let mut indices = [0, extreme(1.0), extreme(-1.0), column.len() - 1];
        indices.sort_unstable();
        for (position, &index) in indices.iter().enumerate() {
            if position == 0 || indices[position - 1] != index {
                kept.push(column[index]);
            }
        }
    }
    thinned(&kept, MOST_VERTICES)
}

/// At most `most` entries, evenly spaced, with the first and the last.
pub(super) fn thinned(places: &[Place], most: usize) -> Vec<Place> {
    if places.len() <= most || most < 2 {
        return places.to_vec();
    }
    let last = places.len() - 1;
    (0..most)
        .map(|index| places[index * last / (most - 1)])
        .collect()
}

/// Cuts a curve into dashes; `pattern` holds the lengths of dash, gap, dash, gap … in pixels.
pub(super) fn dashes(places: &[Place], pattern: &[f64]) -> Vec<Vec<Place>> {
    let total: f64 = places
        .windows(2)
        .map(|pair| distance(pair[0], pair[1]))
        .sum();
    let period: f64 = pattern.iter().sum();
    let stretch = (total / period / MOST_DASHES).max(1.0);
    let mut pieces = Vec::new();
    let Some(&start) = places.first() else {
        return pieces;
    };
    let (mut slot, mut left) = (0, pattern[0] * stretch);
    let mut piece = vec![start];
    for pair in places.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        let mut rest = distance(from, to);
        while rest > left {
            let part = left / rest;
            from = (
                from.0 + part * (to.0 - from.0),
                from.1 + part * (to.1 - from.1),
            );
            rest -= left;
            piece.push(from);
            if slot % 2 == 0 {
                pieces.push(std::mem::take(&mut piece));
            }
            slot = (slot + 1) % pattern.len();
            left = pattern[slot] * stretch;
            piece = vec![from];
        }
        left -= rest;
        piece.push(to);
    }
    if slot.is_multiple_of(2) && piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

/// Vertices of a curve about evenly far apart, the first about `offset` of that distance after its start.
pub(super) fn along(places: &[Place], count: usize, offset: f64) -> Vec<Place> {
    let total: f64 = places
        .windows(2)
        .map(|pair| distance(pair[0], pair[1]))
        .sum();
    let step = total / count as f64;
    let (mut found, mut next, mut walked) = (Vec::new(), offset * step, 0.0);
    for pair in places.windows(2) {
        let length = distance(pair[0], pair[1]);
        while next <= walked + length && length > 0.0 && found.len() < count {
            let nearer = usize::from(next - walked > 0.5 * length);
            found.push(pair[nearer]);
            next += step;
        }
        walked += length;
    }
    found
}

fn distance(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_keeps_its_ends_and_its_sharp_peak() {
        let mut places: Vec<Place> = (0..100_000)
            .map(|i| (f64::from(i) * 0.007, (f64::from(i) * 0.001).sin()))
            .collect();
        places[43_210].1 = 99.0;
        let kept = decimated(&places);
        assert!(kept.len() <= 4 * 701, "{}", kept.len());
        assert_eq!((kept.first(), kept.last()), (places.first(), places.last()));
        assert!(kept.contains(&places[43_210]));
    }

    #[test]
    fn a_short_curve_is_left_as_it_is() {
        let places = [(0.0, 1.0), (5.0, 2.0), (9.0, -1.0), (3.0, 0.0)];
        assert_eq!(decimated(&places), places);
    }

    #[test]
    fn dashes_have_the_lengths_of_the_pattern_around_corners() {
        let corner = [(0.0, 0.0), (5.0, 0.0), (5.0, 100.0)];
        let pieces = dashes(&corner, &[8.0, 4.0]);
        let length = |p: &Vec<Place>| p.windows(2).map(|w| distance(w[0], w[1])).sum::<f64>();
        assert_eq!(pieces.len(), 9);
        assert!(
            pieces
                .iter()
                .all(|piece| (length(piece) - 8.0).abs() < 1e-9)
        );
        assert_eq!(pieces[0].len(), 3, "the first dash bends at the corner");
    }

    #[test]
    fn a_very_long_curve_does_not_become_thousands_of_dashes() {
        let zigzag: Vec<Place> = (0..4000)
            .map(|i| (f64::from(i), f64::from(i % 2) * 400.0))
            .collect();
        assert!(dashes(&zigzag, &[8.0, 4.0]).len() <= 501);
    }

    #[test]
    fn marks_along_a_curve_are_vertices_about_evenly_spaced() {
        let vertices: Vec<Place> = (0..=33).map(|k| (3.0 * f64::from(k), 0.0)).collect();
        let marks = along(&vertices, 5, 0.5);
        assert_eq!(marks.len(), 5);
        for (mark, even) in marks.iter().zip([9.9, 29.7, 49.5, 69.3, 89.1]) {
            assert!(vertices.contains(mark), "{mark:?}");
            assert!((mark.0 - even).abs() <= 1.5 + 1e-9, "{mark:?}");
        }
    }
}
