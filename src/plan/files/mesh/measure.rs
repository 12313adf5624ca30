//! Volume and centroid of an element.

use super::{Element, ElementKind};

/// Volume of an element and where its centroid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measure {
    /// Area or volume, negative where the nodes run the other way round.
    pub(super) volume: f64,
    /// Centroid.
    pub(super) centroid: [f64; 3],
}

/// Volume relative to the cube of an element's extent from which on it counts as flat: what rounding of
/// coordinates of the size of the extent leaves, with room for a mesh far from its origin.
const FLAT: f64 = 1e-10;

/// Measures an element that fills a plane of constant z, or space.
///
/// # Errors
/// Why it has no centroid that could stand for it.
pub(super) fn measure(element: &Element, nodes: &[[f64; 3]]) -> Result<Measure, &'static str> {
    let corners: Vec<[f64; 3]> = element
        .nodes
        .iter()
        .map(|node| nodes[*node as usize])
        .collect();
    let measure = match element.kind.dimension() {
        3 => solid(element.kind, &corners)?,
        _ => ring(&corners)?,
    };
    let extent = corners
        .iter()
        .map(|x| distance(x, &corners[0]))
        .fold(0.0, f64::max);
    let cube = extent.powi(element.kind.dimension() as i32);
    match measure.volume.abs() > FLAT * cube {
        true => Ok(measure),
        false => Err("its nodes enclose nothing; remove or mend it"),
    }
}

const FOLDED: &str =
    "it is folded: its nodes are in another order than the format has, or one is far off; mend it";

/// Area of a ring of corners in x and y, by triangles from its first corner.
fn ring(corners: &[[f64; 3]]) -> Result<Measure, &'static str> {
    let (first, count) = (corners[0], corners.len());
    let mut sum = Sum::default();
    for pair in corners[1..].windows(2) {
        let [a, b] = [minus(&pair[0], &first), minus(&pair[1], &first)];
        sum.add(
            (a[0] * b[1] - a[1] * b[0]) / 2.0,
            &[&first, &pair[0], &pair[1]],
        );
    }
    // Of four corners one may point inwards; two do only where edges cross.
    let turn = |k: usize| {
        let at = |k: usize| corners[k % count];
        let [a, b] = [minus(&at(k + 1), &at(k)), minus(&at(k + 2), &at(k + 1))];
        a[0] * b[1] - a[1] * b[0]
    };
    let turns: Vec<f64> = (0..count).map(turn).collect();
    let [left, right] =
        [1.0, -1.0].map(|way| turns.iter().filter(|turn| way * **turn > 0.0).count());
    match count == 4 && left > 1 && right > 1 {
        true => Err(FOLDED),
        false => Ok(sum.measure()),
    }
}

/// Volume between faces, by tetrahedra from the mean of the corners. A face of four corners need not be flat: it is the
/// mean of its two halvings.
fn solid(kind: ElementKind, corners: &[[f64; 3]]) -> Result<Measure, &'static str> {
    let count = corners.len() as f64;
    let middle = std::array::from_fn(|axis| corners.iter().map(|x| x[axis]).sum::<f64>() / count);
    let mut sum = Sum::default();
    for face in kind.faces() {
        let halves: &[[usize; 3]] = match face.len() {
            3 => &[[0, 1, 2]],
            _ => &[[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3]],
        };
        let share = if face.len() == 3 { 1.0 } else { 0.5 };
        for half in halves {
            let [a, b, c] = half.map(|k| corners[face[k]]);
            let volume = share * triple(&[a, b, c].map(|x| minus(&x, &middle))) / 6.0;
            sum.add(volume, &[&middle, &a, &b, &c]);
        }
    }
    let against = |(k, ends): (usize, [usize; 3])| {
        let edges = ends.map(|end| minus(&corners[end], &corners[k]));
        triple(&edges) * sum.volume < -FLAT * sum.volume * sum.volume
    };
    match edges_at_corners(kind).into_iter().any(against) {
        true => Err(FOLDED),
        false => Ok(sum.measure()),
    }
}

/// Corners with the ends of the three edges there, all the same way round. In a cell that is not folded the edges of every
/// corner span a volume of the same sign, or none.
fn edges_at_corners(kind: ElementKind) -> Vec<(usize, [usize; 3])> {
    let prism = |n: usize| {
        let lower = move |k: usize| (k, [(k + 1) % n, (k + n - 1) % n, k + n]);
        let upper = move |k: usize| (k + n, [n + (k + n - 1) % n, n + (k + 1) % n, k]);
        (0..n).map(lower).chain((0..n).map(upper)).collect()
    };
    match kind {
        ElementKind::Hexahedron => prism(4),
        ElementKind::Wedge => prism(3),
        ElementKind::Pyramid => (0..4).map(|k| (k, [(k + 1) % 4, (k + 3) % 4, 4])).collect(),
        // A tetrahedron cannot be folded, and the others are no solids.
        _ => Vec::new(),
    }
}

/// Simplices so far.
#[derive(Default)]
struct Sum {
    volume: f64,
    moment: [f64; 3],
}

impl Sum {
    fn add(&mut self, volume: f64, corners: &[&[f64; 3]]) {
        self.volume += volume;
        for (axis, moment) in self.moment.iter_mut().enumerate() {
            let sum: f64 = corners.iter().map(|x| x[axis]).sum();
            *moment += volume * sum / corners.len() as f64;
        }
    }

    fn measure(&self) -> Measure {
        Measure {
            volume: self.volume,
            centroid: self.moment.map(|moment| moment / self.volume),
        }
    }
}

fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    minus(a, b).iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn triple([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}
