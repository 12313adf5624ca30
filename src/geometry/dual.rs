//! Dual cells: cells whose corners are points of the cloud, for contours and slices of what is known at points.
//!
//! A point is the middle of its own (primal) cell. The dual mesh joins the points around every inner corner of these:
//! four points of a lattice make a quadrilateral, eight a hexahedron.

use std::collections::HashMap;

use super::{Cloud, Cutter, Vector};

/// Kind of a cell, by its number in VTK.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum CellKind {
    /// A single point.
    Vertex = 1,
    /// Two points.
    Line = 3,
    /// Three points.
    Triangle = 5,
    /// Five points or more in a ring.
    Polygon = 7,
    /// Four points in a ring.
    Quadrilateral = 9,
    /// Four points below, four above them; some may be the same.
    Hexahedron = 12,
}

/// Cells by the numbers of their corners.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DualCells {
    /// Corners of all cells, one cell after another.
    pub corners: Vec<u32>,
    /// Where the corners of each cell end in `corners`.
    pub ends: Vec<u64>,
    /// Kinds of the cells.
    pub kinds: Vec<CellKind>,
    /// Further cells, polyhedra by the corners of their faces.
    pub solids: Vec<Vec<Vec<u32>>>,
}

/// Corners of a cell in the order of VTK; bit `k` of a number tells low or high along the cell's axis `k`.
const RING: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

impl DualCells {
    /// Adds a cell.
    pub fn push(&mut self, kind: CellKind, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u64);
        self.kinds.push(kind);
    }

    /// The cells one after another.
    pub fn iter(&self) -> impl Iterator<Item = (CellKind, &[u32])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = starts.zip(&self.ends);
        let cells = ranges.map(|(start, end)| &self.corners[start as usize..*end as usize]);
        self.kinds.iter().copied().zip(cells)
    }

    /// Cells between the points of a tensor grid of `counts` points along its axes, x fastest. Axes with a single
    /// point are left out: one layer of points in space has quadrilaterals.
    pub fn tensor(counts: &[usize]) -> Self {
        let strides = counts.iter().scan(1, |stride, count| {
            *stride *= count;
            Some(*stride / count)
        });
        let axes: Vec<(usize, usize)> = (counts.iter().copied().zip(strides))
            .filter(|(count, _)| *count > 1)
            .collect();
        let kind = match axes.len() {
            0 => return DualCells::default(),
            1 => CellKind::Line,
            2 => CellKind::Quadrilateral,
            _ => CellKind::Hexahedron,
        };
        let offset = |corner: &usize| {
            let steps =
                (axes.iter().enumerate()).map(|(k, (_, stride))| (corner >> k & 1) * stride);
            steps.sum::<usize>()
        };
        let offsets: Vec<usize> = RING[..1 << axes.len()].iter().map(offset).collect();
        let mut cells = DualCells::default();
        for mut index in 0..axes.iter().map(|(count, _)| count - 1).product() {
            let mut lowest = 0;
            for (count, stride) in &axes {
                lowest += index % (count - 1) * stride;
                index /= count - 1;
            }
            cells.push(kind, offsets.iter().map(|offset| (lowest + offset) as u32));
        }
        cells
    }

    /// Cells between the centres of 2:1 blocks. A block that meets two others on one side makes a triangle with
    /// them; in space such cells are hexahedra some of whose corners are the same, so that faces still fit.
    pub fn blocks<const D: usize>(cloud: &Cloud<D>) -> Self {
        let blocks = Blocks::new(cloud);
        let rings = blocks.inner_corners().into_iter();
        let mut rings: Vec<Vec<u32>> = rings.filter_map(|corner| blocks.around(corner)).collect();
        rings.sort_unstable_by_key(|ring| (ring.iter().min().copied(), ring.clone()));
        let mut cells = DualCells::default();
        for mut ring in rings {
            let kind = match D {
                2 => {
                    ring.dedup();
                    if ring.first() == ring.last() {
                        ring.pop();
                    }
                    match ring.len() {
                        3 => CellKind::Triangle,
                        _ => CellKind::Quadrilateral,
                    }
                }
                _ => CellKind::Hexahedron,
            };
            cells.push(kind, ring);
        }
        cells
    }

    /// Leaves out cells that a crack runs through: what is between their corners is no rock.
    pub fn cut<const D: usize>(&self, cloud: &Cloud<D>, cutter: &Cutter<D>) -> Self {
        let place = |point: &u32| &cloud.position[*point as usize];
        let is_cut = |corners: &[u32]| {
            let mut pairs = (corners.iter().enumerate())
                .flat_map(|(k, a)| corners[..k].iter().map(move |b| (a, b)));
            pairs.any(|(a, b)| cutter.first(place(a), place(b)).is_some())
        };
        // Cracks that cut lie in a plane, where there are no polyhedra.
        let mut left = DualCells::default();
        for (kind, corners) in self.iter().filter(|(_, corners)| !is_cut(corners)) {
            left.push(kind, corners.iter().copied());
        }
        left
    }
}

/// 2:1 blocks by their lowest corners, in edges of the smallest one.
struct Blocks<const D: usize> {
    /// Number of the block with an edge and a lowest corner.
    number: HashMap<(i64, [i64; D]), u32>,
    /// Highest corner of the domain.
    upper: [i64; D],
    /// Edge of the largest block.
    largest: i64,
}

impl<const D: usize> Blocks<D> {
    fn new(cloud: &Cloud<D>) -> Self {
        let cells = || cloud.cell.iter();
        let finest = cells().fold(Vector::repeat(f64::INFINITY), |low: Vector<D>, cell| {
            low.inf(cell)
        });
        let whole = |length: f64, axis: usize| (length / finest[axis]).round() as i64;
        let key = |(x, cell): (&Vector<D>, &Vector<D>)| {
            let low = x - cell * 0.5 - cloud.domain.lower;
            let low = std::array::from_fn(|axis| whole(low[axis], axis));
            (whole(cell[0], 0), low)
        };
        let keys = cloud.position.iter().zip(&cloud.cell).map(key);
        let number: HashMap<_, _> = keys.zip(0_u32..).collect();
        let size = cloud.domain.size();
        Blocks {
            largest: number.keys().map(|(edge, _)| *edge).max().unwrap_or(1),
            number,
            upper: std::array::from_fn(|axis| whole(size[axis], axis)),
        }
    }

    /// Corners of blocks that do not lie on the boundary, ascending.
    fn inner_corners(&self) -> Vec<[i64; D]> {
        let of_block = |(edge, low): &(i64, [i64; D])| {
            let (edge, low) = (*edge, *low);
            (0..1_usize << D).map(move |corner| {
                std::array::from_fn(|axis| low[axis] + edge * (corner >> axis & 1) as i64)
            })
        };
        let inner = |corner: &[i64; D]| {
            let mut axes = corner.iter().zip(&self.upper);
            axes.all(|(at, upper)| 0 < *at && at < upper)
        };
        let mut corners: Vec<[i64; D]> = self.number.keys().flat_map(of_block).collect();
        corners.retain(inner);
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// The blocks around a corner in the order of VTK.
    fn around(&self, corner: [i64; D]) -> Option<Vec<u32>> {
        let octants = RING[..1 << D].iter();
        octants
            .map(|octant| {
                // The smallest block there could be.
                let low: [i64; D] =
                    std::array::from_fn(|axis| corner[axis] - 1 + (octant >> axis & 1) as i64);
                let edges = std::iter::successors(Some(1), |edge| Some(2 * edge));
                let mut edges = edges.take_while(|edge| *edge <= self.largest);
                edges.find_map(|edge| {
                    let key = (edge, low.map(|at| at - at % edge));
                    self.number.get(&key).copied()
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::generate::{Refinement, blocks, jitter, lattice};
    use crate::geometry::{Crack, Shape};

    fn area(cloud: &Cloud<2>, ring: &[u32]) -> f64 {
        let at = |k: usize| cloud.position[ring[k % ring.len()] as usize];
        let cross = |k: usize| at(k)[0] * at(k + 1)[1] - at(k)[1] * at(k + 1)[0];
        (0..ring.len()).map(cross).sum::<f64>() / 2.0
    }

    /// Six times the volume by tetrahedra from the centre to halves of the faces.
    fn volume(cloud: &Cloud<3>, corners: &[u32]) -> f64 {
        const FACES: [[usize; 4]; 6] = [
            [0, 3, 2, 1],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ];
        let at = |k: usize| cloud.position[corners[k] as usize];
        let centre = (0..8).map(at).sum::<Vector<3>>() / 8.0;
        let tetrahedron = |face: [usize; 4]| {
            // The mean of both diagonals is right for faces that are not flat, and the same from both sides.
            let arm = |k: usize| at(face[k]) - centre;
            let part = |a: usize, b: usize, c: usize| arm(a).cross(&arm(b)).dot(&arm(c)) / 6.0;
            (part(0, 1, 2) + part(0, 2, 3) + part(0, 1, 3) + part(1, 2, 3)) / 2.0
        };
        FACES.map(tetrahedron).iter().sum()
    }

    fn refined<const D: usize>(levels: u32) -> Cloud<D> {
        let region = Shape::Box {
            min: vec![0.3; D],
            max: vec![0.45; D],
        };
        let refinements = [Refinement { region, levels }];
        blocks(Vector::zeros(), Vector::repeat(1.0), 0.125, &refinements).unwrap()
    }

    #[test]
    fn cells_of_a_jittered_lattice_fill_what_its_border_points_enclose() {
        let mut cloud = lattice(Vector::<2>::zeros(), Vector::<2>::new(3.0, 2.0), [6, 5]).unwrap();
        let cells = DualCells::tensor(&[6, 5]);
        assert_eq!(cells.kinds, [CellKind::Quadrilateral; 20]);
        let all = |cloud: &Cloud<2>| cells.iter().map(|(_, ring)| area(cloud, ring)).sum::<f64>();
        assert!((all(&cloud) - 2.5 * 1.6).abs() < 1e-12);
        let before = cloud.clone();
        jitter(&mut cloud, 0.3, 7);
        // Inner points do not change the sum; those on the border are put back.
        for (index, x) in cloud.position.iter_mut().enumerate() {
            if index % 6 % 5 == 0 || index / 6 % 4 == 0 {
                *x = before.position[index];
            }
        }
        assert!((all(&cloud) - 2.5 * 1.6).abs() < 1e-12);
        assert!(cells.iter().all(|(_, ring)| area(&cloud, ring) > 0.0));
    }

    #[test]
    fn cells_in_space_have_positive_volumes_that_add_up() {
        let cloud = lattice(Vector::<3>::zeros(), Vector::repeat(4.0), [4, 4, 4]).unwrap();
        let cells = DualCells::tensor(&[4, 4, 4]);
        let volumes: Vec<f64> = cells.iter().map(|(_, c)| volume(&cloud, c)).collect();
        assert_eq!(volumes.len(), 27);
        assert!(volumes.iter().all(|v| (v - 1.0).abs() < 1e-12));
    }

    #[test]
    fn axes_with_one_point_are_left_out() {
        assert_eq!(DualCells::tensor(&[1, 1, 1]), DualCells::default());
        let line = DualCells::tensor(&[1, 3]);
        assert_eq!(
            (&line.corners[..], line.kinds[0]),
            (&[0, 1, 1, 2][..], CellKind::Line)
        );
        let layer = DualCells::tensor(&[2, 1, 2]);
        assert_eq!(layer.corners, [0, 1, 3, 2]);
        assert_eq!(layer.kinds, [CellKind::Quadrilateral]);
    }

    #[test]
    fn blocks_without_refinement_have_the_cells_of_the_lattice() {
        let cloud = blocks(Vector::<2>::zeros(), Vector::repeat(1.0), 0.25, &[]).unwrap();
        let cells = DualCells::blocks(&cloud);
        assert_eq!(cells.kinds, [CellKind::Quadrilateral; 9]);
        assert!(
            cells
                .iter()
                .all(|(_, ring)| (area(&cloud, ring) - 0.0625).abs() < 1e-14)
        );
    }

    /// Coarse blocks are along all sides, so that the cells fill a square (cube) half a coarse block within.
    #[test]
    fn cells_between_blocks_of_two_sizes_leave_no_gap() {
        for levels in 1..4 {
            let plane = refined::<2>(levels);
            let cells = DualCells::blocks(&plane);
            let areas: Vec<f64> = cells.iter().map(|(_, ring)| area(&plane, ring)).collect();
            assert!(areas.iter().all(|area| *area > 0.0));
            assert!((areas.iter().sum::<f64>() - 0.875 * 0.875).abs() < 1e-12);
            assert!(cells.kinds.contains(&CellKind::Triangle));
        }
        let space = refined::<3>(2);
        let volumes = DualCells::blocks(&space);
        let volumes: Vec<f64> = volumes.iter().map(|(_, c)| volume(&space, c)).collect();
        assert!(volumes.iter().all(|volume| *volume > 0.0));
        assert!((volumes.iter().sum::<f64>() - 0.875_f64.powi(3)).abs() < 1e-12);
    }

    #[test]
    fn cells_across_a_crack_are_left_out() {
        let cloud = lattice(Vector::<2>::zeros(), Vector::repeat(4.0), [4, 4]).unwrap();
        let points = vec![Vector::<2>::new(0.0, 2.0), Vector::<2>::new(2.0, 2.0)];
        let cutter = Cutter::without_images(&[Crack { points }]);
        let cells = DualCells::tensor(&[4, 4]).cut(&cloud, &cutter);
        // Of the three cells that straddle the line the crack runs through one and ends within the next.
        assert_eq!(cells.kinds.len(), 7);
    }
}
