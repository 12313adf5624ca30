use super::*;
use crate::geometry::generate::{Refinement, Segment, blocks, graded, jitter, lattice};
use crate::geometry::{Horizon, Matrix, Shape, horizons};

fn path<const D: usize>(cloud: Cloud<D>, cells: Cells) -> Path<D> {
    let horizon = horizons(&cloud, Horizon::Ratio(1.8)).unwrap();
    let families = Families::search(&cloud, horizon).unwrap();
    let found = Tessellation::new(&cloud, families, cells).unwrap();
    let cloud = Arc::new(cloud);
    let influence = Influence::default();
    Path::new(&cloud, &found, true, influence, |_| true, |_, _| None).unwrap()
}

fn square(cells: [usize; 2], size: Vector<2>) -> Path<2> {
    path(
        lattice(Vector::zeros(), size, cells).unwrap(),
        Cells::Lattice,
    )
}

fn cube(cells: [usize; 3]) -> Path<3> {
    let size = Vector::<3>::from_fn(|axis, _| cells[axis] as f64);
    path(
        lattice(Vector::zeros(), size, cells).unwrap(),
        Cells::Lattice,
    )
}

fn jittered<const D: usize>(count: usize, amount: f64) -> Path<D> {
    let mut cloud = lattice(Vector::zeros(), Vector::repeat(1.0), [count; D]).unwrap();
    jitter(&mut cloud, amount, 5);
    path(cloud, Cells::Scattered)
}

fn refined<const D: usize>() -> Path<D> {
    let region = Shape::Box {
        min: vec![0.0; D],
        max: vec![0.5; D],
    };
    let refinements = [Refinement { region, levels: 1 }];
    let cloud = blocks(Vector::zeros(), Vector::repeat(1.0), 0.125, &refinements).unwrap();
    path(cloud, Cells::Scattered)
}

fn tensor() -> Path<2> {
    let axis = |first, last| {
        let length = 1.0;
        vec![Segment {
            length,
            first,
            last,
        }]
    };
    let cloud = graded(Vector::zeros(), &[axis(0.01, 0.15), axis(0.1, 0.02)]).unwrap();
    path(cloud, Cells::Tensor)
}

/// Reproducible numbers between 0 and 1.
fn noise(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| ((i * 7919 + 13) % 1009) as f64 / 1009.0)
        .collect()
}

/// A linear field has no sources, Σ c ξ = 0, and the right flux, Σ c ξ⊗(x_face − x) = V I; conductances
/// are positive and the same from both ends.
fn holds_uniform_flow<const D: usize>(form: &Path<D>) {
    let (families, cloud) = (&form.around.families, &form.around.cloud);
    let mut from_ends = std::collections::BTreeMap::new();
    for owner in 0..form.around.len() {
        let (mut first, mut second) = (Vector::<D>::zeros(), Matrix::<D>::zeros());
        for bond in families.family(owner) {
            let xi = form.around.bond_vector(owner, bond);
            let conductance = 2.0 * form.geometric[bond];
            assert!(conductance > 0.0);
            first += xi * conductance;
            second += form.arm[bond] * xi.transpose() * conductance;
            let end = families.neighbour(bond);
            if families.image(bond) == 0 {
                from_ends.insert((owner, end), conductance);
            }
        }
        let face = cloud.volume[owner] / cloud.spacing(owner);
        assert!(first.amax() < 1e-13 * face * 10.0, "{owner}: {first}");
        let wrong = second / cloud.volume[owner] - Matrix::identity();
        assert!(wrong.amax() < 1e-12, "{owner}: {wrong}");
    }
    for (&(a, b), conductance) in &from_ends {
        let back = from_ends[&(b, a)];
        assert!(
            (conductance / back - 1.0).abs() < 1e-9,
            "{conductance} {back}"
        );
    }
    let volume = cloud.domain.size().product();
    assert!((cloud.volume.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
}

#[test]
fn uniform_flow_is_exact_on_every_cloud() {
    holds_uniform_flow(&square([7, 5], Vector::<2>::new(7.0, 5.0)));
    holds_uniform_flow(&square([7, 5], Vector::<2>::new(7.0, 9.0)));
    holds_uniform_flow(&square([7, 5], Vector::<2>::new(7.0, 50.0)));
    holds_uniform_flow(&cube([4, 3, 5]));
    holds_uniform_flow(&tensor());
    holds_uniform_flow(&jittered::<2>(12, 0.45));
    holds_uniform_flow(&jittered::<3>(6, 0.3));
    holds_uniform_flow(&refined::<2>());
    holds_uniform_flow(&refined::<3>());
}

#[test]
fn lattices_have_eight_and_eighteen_neighbours_and_elongated_cells_four() {
    let bonds = |form: &Path<2>| form.around.families.bonds() / form.around.len();
    assert_eq!(bonds(&square([5, 5], Vector::repeat(1.0))), 8);
    assert_eq!(bonds(&square([5, 5], Vector::<2>::new(1.0, 2.5))), 4);
    let form = cube([4, 4, 4]);
    assert_eq!(form.around.families.bonds(), 18 * 64);
}

/// Volumes against the share of a fine grid of places that are nearest to each point.
fn fills_what_is_nearest<const D: usize>(form: &Path<D>, grid: usize) {
    let cloud = &form.around.cloud;
    let mut found = vec![0.0; cloud.len()];
    let places = lattice(Vector::<D>::zeros(), Vector::repeat(1.0), [grid; D]).unwrap();
    for (x, volume) in places.position.iter().zip(&places.volume) {
        found[cloud.nearest(x).unwrap()] += volume;
    }
    for (found, volume) in found.iter().zip(&cloud.volume) {
        assert!((found / volume - 1.0).abs() < 0.05, "{found} {volume}");
    }
}

#[test]
fn cells_of_scattered_points_hold_the_places_nearest_to_them() {
    fills_what_is_nearest(&jittered::<2>(6, 0.4), 400);
    fills_what_is_nearest(&jittered::<3>(4, 0.3), 100);
}

/// The page's rule over whole rectangles of a lattice whose cells are numbered by place, for one bond.
fn by_rectangles<const D: usize>(
    mobility: &dyn Fn([i64; D]) -> f64,
    weights: [f64; 2],
    at: [i64; D],
    steps: [i64; D],
) -> f64 {
    let add = |a: [i64; D], b: [i64; D]| std::array::from_fn(|axis| a[axis] + b[axis]);
    let axes: Vec<usize> = (0..D).filter(|axis| steps[*axis] != 0).collect();
    let harmonic = |a: f64, b: f64| 2.0 / (1.0 / a + 1.0 / b);
    let theta = |one: [i64; D], other: [i64; D]| {
        let both = add(one, other);
        let four = [at, add(at, one), add(at, other), add(at, both)].map(mobility);
        let low = four.iter().copied().fold(f64::INFINITY, f64::min);
        (low / four.iter().copied().fold(0.0, f64::max)).powi(2)
    };
    let unit = |axis: usize, sign: i64| {
        let mut step = [0; D];
        step[axis] = sign;
        step
    };
    let mean = harmonic(mobility(at), mobility(add(at, steps)));
    match axes[..] {
        [a] => {
            let beside = (0..D)
                .filter(|b| *b != a)
                .flat_map(|b| [unit(b, 1), unit(b, -1)]);
            let moved: f64 = beside.map(|other| 1.0 - theta(steps, other)).sum();
            (weights[0] + weights[1] * moved) * mean
        }
        [a, b] => weights[1] * theta(unit(a, steps[a]), unit(b, steps[b])) * mean,
        _ => 0.0,
    }
}

fn collapses_as_the_rectangles_say<const D: usize>(
    form: &Path<D>,
    cells: [usize; D],
    weights: [f64; 2],
) {
    let mobility: Vec<f64> = (noise(form.around.len()).iter())
        .map(|n| 10_f64.powf(4.0 * n - 2.0))
        .collect();
    let at = |place: [i64; D]| {
        // Beyond a side lies its mirror image.
        let inside = |axis: usize| {
            let n = cells[axis] as i64;
            let k = place[axis].rem_euclid(2 * n);
            k.min(2 * n - 1 - k)
        };
        let index = (0..D)
            .rev()
            .fold(0, |index, axis| index * cells[axis] as i64 + inside(axis));
        mobility[index as usize]
    };
    for owner in 0..form.around.len() {
        let family = form.around.families.family(owner);
        let mut found = vec![0.0; family.len()];
        form.conductances(owner, &mobility, &mut found);
        let mut rest = owner;
        let place: [i64; D] = std::array::from_fn(|axis| {
            let k = rest % cells[axis];
            rest /= cells[axis];
            k as i64
        });
        for (bond, found) in family.zip(found) {
            let xi = form.around.bond_vector(owner, bond);
            let steps = std::array::from_fn(|axis| xi[axis].round() as i64);
            let wanted = 0.5 * by_rectangles(&at, weights, place, steps);
            assert!((found / wanted - 1.0).abs() < 1e-12, "{found} {wanted}");
        }
    }
}

#[test]
fn corners_collapse_as_the_rule_over_rectangles_says() {
    let form = square([6, 5], Vector::<2>::new(6.0, 5.0));
    collapses_as_the_rectangles_say(&form, [6, 5], [2.0 / 3.0, 1.0 / 6.0]);
    collapses_as_the_rectangles_say(&cube([4, 3, 5]), [4, 3, 5], [1.0 / 3.0, 1.0 / 6.0]);
}

#[test]
fn a_uniform_field_is_not_collapsed() {
    let form = cube([4, 3, 5]);
    let mobility = vec![3.0; form.around.len()];
    for owner in 0..form.around.len() {
        let family = form.around.families.family(owner);
        let mut found = vec![0.0; family.len()];
        form.conductances(owner, &mobility, &mut found);
        let geometric = form.geometric[family].iter();
        assert!(
            found
                .iter()
                .zip(geometric)
                .all(|(found, own)| (*found - own * 3.0).abs() < 1e-15)
        );
    }
}

/// Collapsed or not, what a linear pressure drives along layers into a point leaves it again.
#[test]
fn first_moments_survive_the_collapse() {
    let form = square([6, 5], Vector::<2>::new(6.0, 5.0));
    let families = &form.around.families;
    let layer = |point: usize| {
        if form.around.cloud.position[point][1] < 2.0 {
            1e6
        } else {
            1.0
        }
    };
    let mobility: Vec<f64> = (0..form.around.len()).map(layer).collect();
    for owner in 0..form.around.len() {
        let family = families.family(owner);
        let mut found = vec![0.0; family.len()];
        form.conductances(owner, &mobility, &mut found);
        let along = family
            .zip(&found)
            .map(|(b, c)| c * form.around.bond_vector(owner, b)[0]);
        assert!(along.sum::<f64>().abs() < 1e-13 * mobility[owner]);
    }
}

/// At a side without images the faces along it conduct what bonds across its edges would.
#[test]
fn without_images_the_flow_along_a_side_is_whole() {
    let cloud = Arc::new(lattice(Vector::zeros(), Vector::<2>::new(6.0, 5.0), [6, 5]).unwrap());
    let horizon = horizons(&cloud, Horizon::Ratio(1.8)).unwrap();
    let families = Families::search(&cloud, horizon).unwrap();
    let found = Tessellation::new(&cloud, families, Cells::Lattice).unwrap();
    let keeps = |image: u8| found.families.images.get(image).order[1] >= 0;
    let influence = Influence::default();
    let form = Path::new(&cloud, &found, false, influence, keeps, |_, _| None).unwrap();
    for owner in 0..form.around.len() {
        let bonds = form.around.families.family(owner);
        let along = |bond: usize| form.around.bond_vector(owner, bond)[0].powi(2);
        let sum: f64 = bonds.map(|bond| form.geometric[bond] * along(bond)).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{owner}: {sum}");
    }
    let faces = form.open_faces();
    assert_eq!(faces.len(), 6);
    assert!(
        faces
            .iter()
            .all(|face| face.side.name() == "bottom" && (face.area - 1.0).abs() < 1e-15)
    );
    assert!(
        faces
            .iter()
            .all(|face| face.arm == Vector::<2>::new(0.0, -0.5))
    );
}

/// Flat cells, whose faces lie far beyond the horizon, get the families of the grid without a search.
#[test]
fn flat_cells_have_all_their_faces_whatever_the_horizon() {
    let cloud = lattice(Vector::zeros(), Vector::<3>::new(3.0, 4.0, 0.5), [3, 4, 50]).unwrap();
    let form = path(cloud, Cells::Lattice);
    assert_eq!(form.around.families.bonds(), 6 * 600);
    holds_uniform_flow(&form);
    holds_uniform_flow(&path(
        lattice(Vector::zeros(), Vector::<2>::new(1.0, 9.0), [1, 9]).unwrap(),
        Cells::Lattice,
    ));
    holds_uniform_flow(&path(
        lattice(Vector::zeros(), Vector::<2>::new(90.0, 1.0), [9, 10]).unwrap(),
        Cells::Lattice,
    ));
}
