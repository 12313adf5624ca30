//! Which process owns which points, and how values of all points are brought together.
//!
//! Every process knows all points and holds fields of all points, but bonds and matrix rows only
//! for its own. A field is complete everywhere once each process has given the values of its own
//! points. Decisions taken from complete fields are then the same everywhere.

use std::sync::Arc;

use crate::Communicator;
use crate::problem::Coordinates;

/// Points dealt out to the processes of a team, in compact regions of equal size.
#[derive(Debug, Clone)]
pub struct Partition {
    team: Arc<dyn Communicator>,
    /// All points, process after process, ascending within each.
    order: Vec<u32>,
    /// Start of each process in `order`, shape `(size + 1,)`.
    starts: Vec<usize>,
}

impl Partition {
    /// Recursive coordinate bisection: halves the points across the longer extent, over and over.
    /// Every process computes the same result. Points of equal coordinates go by index.
    #[must_use]
    pub fn bisection(team: Arc<dyn Communicator>, coordinates: &Coordinates<'_>) -> Self {
        let points = coordinates.values.len() / coordinates.dimension.max(1);
        let mut order: Vec<u32> = (0..points as u32).collect();
        let mut starts = vec![0];
        bisect(coordinates, &mut order, team.size(), &mut starts);
        for rank in 0..team.size() {
            order[starts[rank]..starts[rank + 1]].sort_unstable();
        }
        Self {
            team,
            order,
            starts,
        }
    }

    /// The processes.
    #[must_use]
    pub fn team(&self) -> &Arc<dyn Communicator> {
        &self.team
    }

    /// Points of this process, ascending.
    #[must_use]
    pub fn own(&self) -> &[u32] {
        let rank = self.team.rank();
        &self.order[self.starts[rank]..self.starts[rank + 1]]
    }

    /// All points, process after process.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Start of each process in [`Self::order`], shape `(processes + 1,)`.
    #[must_use]
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// Whether this process owns each point, shape `(points,)`.
    #[must_use]
    pub fn mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.order.len()];
        self.own().iter().for_each(|p| mask[*p as usize] = true);
        mask
    }

    /// Replaces the values of the points of other processes by theirs. `values` has `per_point`
    /// values for every point.
    pub fn complete(&self, values: &mut [f64], per_point: usize) {
        if self.team.size() == 1 {
            return;
        }
        let starts: Vec<usize> = self.starts.iter().map(|start| start * per_point).collect();
        let mut buffer = vec![0.0; values.len()];
        let rank = self.team.rank();
        let own = &mut buffer[starts[rank]..starts[rank + 1]];
        for (slot, point) in own.chunks_exact_mut(per_point).zip(self.own()) {
            slot.copy_from_slice(&values[*point as usize * per_point..][..per_point]);
        }
        self.team.gather(&starts, &mut buffer);
        for (slot, point) in buffer.chunks_exact(per_point).zip(&self.order) {
            values[*point as usize * per_point..][..per_point].copy_from_slice(slot);
        }
    }
}

/// Deals `points` out to `parts` processes and appends the end of each to `starts`.
fn bisect(
    coordinates: &Coordinates<'_>,
    points: &mut [u32],
    parts: usize,
    starts: &mut Vec<usize>,
) {
    if parts <= 1 {
        let start = starts.last().copied().unwrap_or(0);
        starts.push(start + points.len());
        return;
    }
    let axis = longest_axis(coordinates, points);
    let low_parts = parts / 2;
    let middle = points.len() * low_parts / parts;
    if middle > 0 {
        points.select_nth_unstable_by(middle, |a, b| {
            let key = |point| coordinates.along(axis, point);
            key(*a).total_cmp(&key(*b)).then_with(|| a.cmp(b))
        });
    }
    let (low, high) = points.split_at_mut(middle);
    bisect(coordinates, low, low_parts, starts);
    bisect(coordinates, high, parts - low_parts, starts);
}

fn longest_axis(coordinates: &Coordinates<'_>, points: &[u32]) -> usize {
    let extent = |axis: &usize| {
        let along = points.iter().map(|point| coordinates.along(*axis, *point));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        high - low
    };
    let axes = 0..coordinates.dimension;
    // Of equal extents the last: clouds count along the first axis first, so that shares are then
    // contiguous in memory.
    axes.max_by(|a, b| extent(a).total_cmp(&extent(b)).then(a.cmp(b)))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::jittered_grid;
    use crate::thread_team as team;

    #[test]
    fn every_point_has_one_owner_and_shares_differ_by_few() {
        let cloud = jittered_grid(13, 7, 0.2);
        let coordinates = Coordinates {
            dimension: 2,
            values: &cloud.coordinates,
        };
        for size in 1..=5 {
            let mut owners = vec![0; 91];
            for member in team(size) {
                let partition = Partition::bisection(member, &coordinates);
                assert!(partition.own().len() >= 91 / size - 1);
                assert!(partition.own().len() <= 91 / size + 2);
                for point in partition.own() {
                    owners[*point as usize] += 1;
                }
            }
            assert!(owners.iter().all(|count| *count == 1), "{size}");
        }
    }

    #[test]
    fn two_parts_of_a_long_grid_meet_across_its_length() {
        let cloud = jittered_grid(20, 3, 0.0);
        let coordinates = Coordinates {
            dimension: 2,
            values: &cloud.coordinates,
        };
        let partition = Partition::bisection(team(2)[0].clone(), &coordinates);
        assert!(partition.own().iter().all(|point| point % 20 < 10));
    }

    #[test]
    fn a_field_is_complete_once_all_have_given_their_part() {
        let cloud = jittered_grid(9, 5, 0.1);
        let members = team(3);
        std::thread::scope(|scope| {
            for member in members {
                let coordinates = Coordinates {
                    dimension: 2,
                    values: &cloud.coordinates,
                };
                scope.spawn(move || {
                    let partition = Partition::bisection(member, &coordinates);
                    let mut field = vec![f64::NAN; 90];
                    for point in partition.own() {
                        field[2 * *point as usize] = f64::from(*point);
                        field[2 * *point as usize + 1] = -f64::from(*point);
                    }
                    partition.complete(&mut field, 2);
                    for point in 0..45 {
                        assert_eq!(field[2 * point..][..2], [point as f64, -(point as f64)]);
                    }
                });
            }
        });
    }
}
