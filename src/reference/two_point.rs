//! The flux between two points per face, on a lattice of cells that are all full of one rock each: what
//! reservoir simulators compute, and the measure of other operators where cells differ by any contrast.

/// Flow through a plane lattice of cells (x fastest) from one side to the opposite one, for a unit pressure
/// drop along `axis`, m²/(Pa s) per metre of thickness.
///
/// Two cells exchange κ A/h with the harmonic mean of their mobilities, a cell and its side κ A/(h/2) (Aziz and
/// Settari 1979, Petroleum Reservoir Simulation, Sec. 3.5); the other sides are sealed. `edges` are those of a
/// cell, m; `mobility` has one value per cell, m²/(Pa s).
///
/// Cells are eliminated one by one: what a cell carries between any two of its neighbours takes its
/// place (star-mesh transformation). All terms are positive, so that no contrast costs digits.
#[must_use]
pub fn two_point_flow(cells: [usize; 2], edges: [f64; 2], mobility: &[f64], axis: usize) -> f64 {
    // Numbered along the shorter axis first, links reach that far ahead at most.
    let short = usize::from(cells[1] < cells[0]);
    let long = 1 - short;
    let band = cells[short];
    let mobility_of = |k: usize| {
        let (along, across) = (k % band, k / band);
        let (x, y) = if short == 0 {
            (along, across)
        } else {
            (across, along)
        };
        mobility[y * cells[0] + x]
    };
    let face = |axis: usize| edges[1 - axis] / edges[axis];
    let mut network = Network::new(cells[0] * cells[1], band);
    for k in 0..cells[0] * cells[1] {
        let own = mobility_of(k);
        let place = [k % band, k / band];
        for (axis_of_step, step, at) in [(short, 1, place[0]), (long, band, place[1])] {
            if at + 1 < cells[axis_of_step] {
                let end = mobility_of(k + step);
                // Without products of mobilities, which may underflow.
                let mean = 2.0 / (1.0 / own + 1.0 / end);
                network.link(k, step, face(axis_of_step) * mean);
            }
            if axis_of_step == axis {
                let half = 2.0 * face(axis) * own;
                let last = at + 1 == cells[axis];
                network.sides[k] = [
                    if at == 0 { half } else { 0.0 },
                    if last { half } else { 0.0 },
                ];
            }
        }
    }
    network.reduced()
}

/// Conductances of a numbered network between each node and those up to `band` ahead, and to two sides.
struct Network {
    band: usize,
    ahead: Vec<f64>,
    sides: Vec<[f64; 2]>,
}

impl Network {
    fn new(nodes: usize, band: usize) -> Self {
        Network {
            band,
            ahead: vec![0.0; nodes * band],
            sides: vec![[0.0; 2]; nodes],
        }
    }

    fn link(&mut self, node: usize, step: usize, conductance: f64) {
        self.ahead[node * self.band + step - 1] += conductance;
    }

    /// Conductance between the sides once all nodes are eliminated.
    fn reduced(mut self) -> f64 {
        let (band, nodes) = (self.band, self.sides.len());
        let mut between = 0.0;
        let mut row = vec![0.0; band];
        for node in 0..nodes {
            row.copy_from_slice(&self.ahead[node * band..][..band]);
            let [low, high] = self.sides[node];
            let sum: f64 = row.iter().sum::<f64>() + low + high;
            if sum <= 0.0 {
                continue;
            }
            between += low * (high / sum);
            for (first, &own) in row.iter().enumerate().filter(|(_, own)| **own > 0.0) {
                let share = own / sum;
                let end = node + 1 + first;
                self.sides[end][0] += share * low;
                self.sides[end][1] += share * high;
                for (second, other) in row.iter().enumerate().skip(first + 1) {
                    self.link(end, second - first, share * other);
                }
            }
        }
        between
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_in_series_and_side_by_side_are_exact_at_every_contrast() {
        for k in [1e-12, 1e-4, 1.0, 1e6, 1e12] {
            let layered: Vec<f64> = (0..30).map(|c| if c % 6 < 2 { k } else { 1.0 }).collect();
            let along = two_point_flow([6, 5], [0.5, 0.2], &layered, 0);
            let series = 1.0 / (1.0 / k + 2.0);
            assert!((along / series - 1.0).abs() < 1e-14, "{k:e}");
            let across = two_point_flow([6, 5], [0.5, 0.2], &layered, 1);
            assert!((across / (k + 2.0) - 1.0).abs() < 1e-14, "{k:e}");
        }
    }

    /// Turned by 90° the flow is the same; both ways of numbering the cells are tried.
    #[test]
    fn a_turned_lattice_carries_the_same() {
        let value = |x: usize, y: usize| 10_f64.powi(((7 * x + 5 * y * y) % 9) as i32 - 4);
        let own: Vec<f64> = (0..35).map(|c| value(c % 7, c / 7)).collect();
        let turned: Vec<f64> = (0..35).map(|c| value(c / 5, c % 5)).collect();
        for axis in 0..2 {
            let one = two_point_flow([7, 5], [1.0, 3.0], &own, axis);
            let other = two_point_flow([5, 7], [3.0, 1.0], &turned, 1 - axis);
            assert!((one / other - 1.0).abs() < 1e-13);
        }
    }
}
