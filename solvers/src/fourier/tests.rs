//! Folded lattices, whose matrices are summed bond by bond with images, against what their products say.

use crate::lattice::Mirror::{Even, Odd};
use crate::lattice::{Lattice, LatticeAxis, Mirror};
use crate::test_support::{noisy_vector, ready, relative_error};
use crate::{CsrMatrix, Problem, SolveError, SolverSpec, Symmetry, multiply};

/// Mirrors of every unknown at both sides of an axis; none where bonds to images are left out.
type Sides = Vec<[Option<Mirror>; 2]>;

/// A lattice of bonds with up to two points along every axis.
struct Network {
    counts: Vec<usize>,
    /// For every axis.
    sides: Vec<Sides>,
    unknowns: usize,
    /// Stiffness by place along the last axis.
    layers: Vec<f64>,
    /// What holds every unknown.
    support: f64,
}

const ALL: [[Mirror; 2]; 4] = [[Even, Even], [Odd, Odd], [Even, Odd], [Odd, Even]];

/// Sides of a scalar, the same at every axis but the one given.
fn scalar(mirrors: [Mirror; 2]) -> Sides {
    vec![mirrors.map(Some)]
}

/// Sides of a vector and, with a third unknown, a pressure, along an axis: both mirrors, or the opposite.
fn symmetric(axis: usize, unknowns: usize, opposite: [bool; 2]) -> Sides {
    let mirror = |unknown: usize, opposite: bool| match (unknown == axis) != opposite {
        true => Some(Odd),
        false => Some(Even),
    };
    (0..unknowns)
        .map(|own| opposite.map(|opposite| mirror(own, opposite)))
        .collect()
}

impl Network {
    fn points(&self) -> usize {
        self.counts.iter().product()
    }

    fn places(&self, mut point: usize) -> Vec<usize> {
        let digits = self.counts.iter().map(|count| {
            let own = point % count;
            point /= count;
            own
        });
        digits.collect()
    }

    /// The point at a place, with the sign of every unknown there; none beyond open sides.
    fn image(&self, place: &[isize]) -> Option<(usize, Vec<f64>)> {
        let (mut point, mut stride, mut signs) = (0, 1, vec![1.0; self.unknowns]);
        for (axis, &count) in self.counts.iter().enumerate() {
            let mut own = place[axis];
            while own < 0 || own >= count as isize {
                let upper = usize::from(own >= 0);
                for (sign, sides) in signs.iter_mut().zip(&self.sides[axis]) {
                    *sign *= if sides[upper]? == Odd { -1.0 } else { 1.0 };
                }
                own = if upper == 1 {
                    2 * count as isize - 1 - own
                } else {
                    -1 - own
                };
            }
            point += own as usize * stride;
            stride *= count;
        }
        Some((point, signs))
    }

    fn offsets(&self) -> Vec<Vec<isize>> {
        let axes = self.counts.len();
        let all = (0..5_usize.pow(axes as u32)).map(|mut number| {
            let mut digits = Vec::new();
            for _ in 0..axes {
                digits.push((number % 5) as isize - 2);
                number /= 5;
            }
            digits
        });
        all.filter(|own| (1..=5).contains(&own.iter().map(|x| x * x).sum::<isize>()))
            .collect()
    }

    /// The matrix: springs for every unknown, for vectors along the bond too; a pressure takes the divergence.
    fn matrix(&self) -> CsrMatrix {
        let size = self.points() * self.unknowns;
        let mut entries = sprs::TriMatI::<f64, u32>::new((size, size));
        for point in 0..self.points() {
            let places = self.places(point);
            let stiffness = *places
                .last()
                .and_then(|own| self.layers.get(*own))
                .unwrap_or(&1.0);
            for unknown in 0..self.unknowns {
                let row = point * self.unknowns + unknown;
                entries.add_triplet(row, row, self.support * self.sign(unknown));
            }
            let bonds: Vec<_> = (self.offsets().into_iter())
                .filter_map(|offset| {
                    let end: Vec<isize> = places
                        .iter()
                        .zip(&offset)
                        .map(|(own, step)| *own as isize + step)
                        .collect();
                    self.image(&end).map(|image| (offset, image))
                })
                .collect();
            let mut divergence = Vec::new();
            for (offset, (end, signs)) in &bonds {
                let length: f64 = offset.iter().map(|x| (x * x) as f64).sum();
                let own = stiffness / length;
                for (unknown, sign) in signs.iter().enumerate() {
                    let ends = [(*end, unknown, *sign), (point, unknown, -1.0)];
                    self.add(&mut entries, self.sign(unknown) * own, &ends);
                }
                let along: Vec<_> = (0..self.vector())
                    .flat_map(|axis| {
                        let part = offset[axis] as f64 / length;
                        [(*end, axis, part * signs[axis]), (point, axis, -part)]
                    })
                    .collect();
                self.add(&mut entries, 2.0 * own * length, &along);
                divergence.extend(along);
            }
            for &(other, axis, part) in divergence.iter().filter(|_| self.pressure().is_some()) {
                let (row, column) = (other * self.unknowns + axis, point * self.unknowns + 2);
                entries.add_triplet(row, column, -0.1 * part);
                entries.add_triplet(column, row, -0.1 * part);
            }
        }
        entries.to_csr()
    }

    /// Components of a displacement among the unknowns.
    fn vector(&self) -> usize {
        if self.unknowns == 1 {
            0
        } else {
            self.counts.len()
        }
    }

    fn pressure(&self) -> Option<usize> {
        (self.unknowns == 3 && self.counts.len() == 2).then_some(2)
    }

    fn sign(&self, unknown: usize) -> f64 {
        if self.pressure() == Some(unknown) {
            -1.0
        } else {
            1.0
        }
    }

    fn add(
        &self,
        entries: &mut sprs::TriMatI<f64, u32>,
        stiffness: f64,
        ends: &[(usize, usize, f64)],
    ) {
        for &(one, unknown, part) in ends {
            for &(other, second, factor) in ends {
                let (row, column) = (
                    one * self.unknowns + unknown,
                    other * self.unknowns + second,
                );
                entries.add_triplet(row, column, stiffness * part * factor);
            }
        }
    }

    fn lattice(&self) -> Lattice {
        let axes = self.counts.iter().enumerate().map(|(axis, &count)| {
            let last = axis + 1 == self.counts.len();
            let all: Option<Vec<[Mirror; 2]>> = (self.sides[axis].iter())
                .map(|own| Some([own[0]?, own[1]?]))
                .collect();
            let mirrors = all.filter(|_| !last || self.layers.is_empty());
            LatticeAxis {
                count,
                mirrors: mirrors.ok_or_else(|| "its layers differ".to_owned()),
            }
        });
        Lattice {
            axes: axes.collect(),
        }
    }

    fn symmetry(&self) -> Symmetry {
        match self.pressure() {
            Some(_) => Symmetry::QuasiDefinite,
            None => Symmetry::PositiveDefinite,
        }
    }

    /// Solves for the product of the matrix with known numbers; the error relative to these.
    fn solve(&self) -> Result<f64, SolveError> {
        let (matrix, lattice) = (self.matrix(), self.lattice());
        let exact = noisy_vector(matrix.rows());
        let mut rhs = vec![0.0; matrix.rows()];
        multiply(matrix.view(), &exact, &mut rhs);
        let (x, refinements) = solved(&matrix, &lattice, self, &rhs)?;
        assert!(refinements <= 1, "{refinements} refinements");
        Ok(relative_error(&x, &exact))
    }
}

fn solved(
    matrix: &CsrMatrix,
    lattice: &Lattice,
    network: &Network,
    rhs: &[f64],
) -> Result<(Vec<f64>, u64), SolveError> {
    let mut solver = "fourier".parse::<SolverSpec>().unwrap().build().unwrap();
    solver.analyse(&Problem {
        lattice: Ok(lattice),
        ..Problem::new(matrix.view(), network.symmetry(), network.unknowns)
    })?;
    solver.refresh(matrix.view())?;
    let mut x = vec![0.0; rhs.len()];
    solver.solve(matrix.view(), rhs, &mut x)?;
    Ok((x, solver.counters().refinements))
}

#[test]
fn scalars_between_all_pairs_of_sides_are_solved_to_rounding() {
    for one in ALL {
        for other in ALL {
            for counts in [vec![11, 9], vec![4, 13], vec![3, 2], vec![5, 6, 4]] {
                let mut sides = vec![scalar(one), scalar(other)];
                sides.resize(counts.len(), scalar(one));
                let network = Network {
                    counts,
                    sides,
                    unknowns: 1,
                    layers: Vec::new(),
                    support: 0.1,
                };
                let error = network.solve().unwrap();
                assert!(
                    error < 1e-12,
                    "{:?} {one:?} {other:?}: {error:e}",
                    network.counts
                );
            }
        }
    }
}

#[test]
fn layers_and_open_sides_along_the_last_axis_are_exact() {
    let layers: Vec<f64> = (0..12).map(|place| 10.0_f64.powi(place % 4)).collect();
    for across in ALL {
        for last in [[None, None], [Some(Odd), None], [Some(Even), Some(Odd)]] {
            let network = Network {
                counts: vec![10, 12],
                sides: vec![scalar(across), vec![last]],
                unknowns: 1,
                layers: layers.clone(),
                support: 0.1,
            };
            // Stiffnesses differ by 1000.
            let error = network.solve().unwrap();
            assert!(error < 1e-10, "{across:?} {last:?}: {error:e}");
        }
    }
}

/// Displacements, and displacements with a pressure, between mirrors and their opposites; clamped or open ends.
#[test]
fn vectors_are_solved_to_rounding_and_so_are_coupled_fields() {
    let ends = |unknowns: usize| {
        let clamped = vec![[Some(Odd); 2]; unknowns];
        let open = vec![[Some(Odd), None]; unknowns];
        [clamped, open, symmetric(1, unknowns, [false, true])]
    };
    for unknowns in [2, 3] {
        for opposite in [[false, false], [true, true], [false, true], [true, false]] {
            for (number, last) in ends(unknowns).into_iter().enumerate() {
                // Clamped and open sides are no mirrors of a vector.
                let layers = vec![1.0; if number < 2 { 10 } else { 0 }];
                let network = Network {
                    counts: vec![9, 10],
                    sides: vec![symmetric(0, unknowns, opposite), last],
                    unknowns,
                    layers,
                    support: 0.1,
                };
                let error = network.solve().unwrap();
                assert!(error < 1e-12, "{unknowns} {opposite:?}: {error:e}");
            }
        }
    }
    let network = Network {
        counts: vec![4, 5, 6],
        sides: vec![
            symmetric(0, 3, [false, true]),
            symmetric(1, 3, [false, false]),
            vec![[Some(Odd), None]; 3],
        ],
        unknowns: 3,
        layers: vec![1.0; 6],
        support: 0.1,
    };
    assert!(network.solve().unwrap() < 1e-12);
}

fn sealed(counts: Vec<usize>) -> Network {
    let sides = vec![scalar([Even, Even]); counts.len()];
    Network {
        counts,
        sides,
        unknowns: 1,
        layers: Vec::new(),
        support: 0.0,
    }
}

/// A sealed body is singular but for the point that is held; what it is held with decides the constant.
#[test]
fn a_sealed_body_is_held_by_its_grounded_point() {
    for point in [0, 17] {
        let network = sealed(vec![8, 9]);
        let (mut matrix, lattice) = (network.matrix(), network.lattice());
        let diagonal = matrix.get_mut(point, point).unwrap();
        *diagonal *= 2.0;
        let exact = noisy_vector(72);
        let mut rhs = vec![0.0; 72];
        multiply(matrix.view(), &exact, &mut rhs);
        let (x, _) = solved(&matrix, &lattice, &network, &rhs).unwrap();
        assert!(relative_error(&x, &exact) < 1e-12);
    }
    let free = sealed(vec![8, 9]).solve();
    assert!(
        matches!(free, Err(SolveError::NotPositiveDefinite { .. })),
        "{free:?}"
    );
}

/// What holds a sealed body is far below the rounding errors of row sums; its mean is told by it all the same.
#[test]
fn a_hardly_held_constant_is_found() {
    let network = Network {
        support: 1e-13,
        ..sealed(vec![30, 40])
    };
    let (matrix, lattice) = (network.matrix(), network.lattice());
    // One unit in balance, and 1e-13 all over.
    let mut rhs = vec![1e-13; 1200];
    rhs[100] += 1.0;
    rhs[700] -= 1.0;
    let (x, _) = solved(&matrix, &lattice, &network, &rhs).unwrap();
    let mean = x.iter().sum::<f64>() / 1200.0;
    assert!((mean - 1.0).abs() < 0.2, "{mean}");
}

#[test]
fn an_interrupt_is_heard_in_every_stage() {
    let network = Network {
        support: 1.0,
        ..sealed(vec![8, 9])
    };
    let (matrix, lattice) = (network.matrix(), network.lattice());
    let problem = Problem {
        lattice: Ok(&lattice),
        ..Problem::new(matrix.view(), network.symmetry(), 1)
    };
    let mut solver = ready("fourier", &problem).unwrap();
    let interrupt = crate::Interrupt::default();
    interrupt.raise();
    let mut x = vec![0.0; 72];
    let stopped = interrupt.during(|| {
        let solved = solver.solve(matrix.view(), &noisy_vector(72), &mut x);
        [solved.map(|_| ()), solver.refresh(matrix.view())]
    });
    assert!(
        stopped
            .iter()
            .all(|own| *own == Err(SolveError::Interrupted)),
        "{stopped:?}"
    );
}

#[test]
fn what_does_not_repeat_is_refused_by_name() {
    let network = sealed(vec![8, 9]);
    let mut lattice = network.lattice();
    let mut matrix = network.matrix();
    for row in 0..72 {
        *matrix.get_mut(row, row).unwrap() += if row == 30 { 2.0 } else { 1.0 };
    }
    let rhs = noisy_vector(72);
    let message = solved(&matrix, &lattice, &network, &rhs)
        .unwrap_err()
        .to_string();
    assert!(message.contains("row 30 differs by"), "{message}");
    for axis in &mut lattice.axes {
        axis.mirrors = Err("the permeability varies".into());
    }
    let message = solved(&matrix, &lattice, &network, &rhs)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("along y, the permeability varies"),
        "{message}"
    );
    let unknown = Problem::new(matrix.view(), Symmetry::PositiveDefinite, 1);
    let mut solver = "fourier".parse::<SolverSpec>().unwrap().build().unwrap();
    let message = solver.analyse(&unknown).unwrap_err().to_string();
    assert!(
        message.contains("nothing is known of the order"),
        "{message}"
    );
}

#[test]
fn results_have_the_same_bits_for_any_number_of_threads() {
    let network = Network {
        counts: vec![37, 41],
        sides: vec![symmetric(0, 2, [false, false]), vec![[Some(Odd), None]; 2]],
        unknowns: 2,
        layers: Vec::new(),
        support: 0.1,
    };
    let (matrix, lattice) = (network.matrix(), network.lattice());
    let rhs = noisy_vector(matrix.rows());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| solved(&matrix, &lattice, &network, &rhs).unwrap().0)
    };
    let (one, three) = (with(1), with(3));
    assert!(
        one.iter()
            .zip(&three)
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
}
