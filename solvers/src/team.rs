//! Processes, or threads in their place, that work on one run together.

use std::sync::{Arc, Barrier, Mutex, PoisonError};

/// Processes that work on one run together.
pub trait Communicator: Send + Sync + std::fmt::Debug {
    /// Number of this process, from 0.
    fn rank(&self) -> usize;

    /// Number of processes.
    fn size(&self) -> usize;

    /// Replaces every value by its sum over all processes, with the same bits everywhere.
    fn sum(&self, values: &mut [f64]);

    /// Brings blocks together: process `r` gives `values[starts[r]..starts[r + 1]]` and receives
    /// the blocks of the others. `starts` is the same everywhere.
    fn gather(&self, starts: &[usize], values: &mut [f64]);
}

/// A team of threads of this process, one member for each: what runs over several processes can be
/// tried without starting any. Every member must be given to a thread of its own.
#[must_use]
pub fn thread_team(size: usize) -> Vec<Arc<dyn Communicator>> {
    let shared = Arc::new(Shared {
        barrier: Barrier::new(size),
        board: Mutex::new(Vec::new()),
    });
    let member = |rank| {
        let shared = shared.clone();
        Arc::new(Member { rank, size, shared }) as Arc<dyn Communicator>
    };
    (0..size).map(member).collect()
}

/// What the members of a team of threads share.
#[derive(Debug)]
struct Shared {
    barrier: Barrier,
    /// Blocks of the exchange under way, rank after rank.
    board: Mutex<Vec<f64>>,
}

#[derive(Debug)]
struct Member {
    rank: usize,
    size: usize,
    shared: Arc<Shared>,
}

impl Member {
    /// Writes to the board, waits until all have, reads from it, and waits until all have.
    fn exchange(&self, write: impl FnOnce(&mut Vec<f64>), read: impl FnOnce(&[f64])) {
        let board = || {
            self.shared
                .board
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        write(&mut board());
        self.shared.barrier.wait();
        read(&board());
        self.shared.barrier.wait();
    }
}

impl Communicator for Member {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn sum(&self, values: &mut [f64]) {
        let length = values.len();
        let starts: Vec<usize> = (0..=self.size).map(|rank| rank * length).collect();
        let mut blocks = vec![0.0; self.size * length];
        blocks[starts[self.rank]..starts[self.rank + 1]].copy_from_slice(values);
        self.gather(&starts, &mut blocks);
        values.fill(0.0);
        for block in blocks.chunks(length.max(1)) {
            values
                .iter_mut()
                .zip(block)
                .for_each(|(sum, own)| *sum += own);
        }
    }

    fn gather(&self, starts: &[usize], values: &mut [f64]) {
        let own = starts[self.rank]..starts[self.rank + 1];
        let given = values[own.clone()].to_vec();
        self.exchange(
            |board| {
                board.resize(starts[self.size], 0.0);
                board[own].copy_from_slice(&given);
            },
            |board| values.copy_from_slice(&board[..starts[self.size]]),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_blocks_arrive_everywhere() {
        std::thread::scope(|scope| {
            for member in thread_team(3) {
                scope.spawn(move || {
                    let rank = member.rank() as f64;
                    let mut values = [rank, 1.0];
                    member.sum(&mut values);
                    assert_eq!(values.map(f64::to_bits), [3.0, 3.0].map(f64::to_bits));
                    let mut blocks = [rank; 4];
                    member.gather(&[0, 1, 3, 4], &mut blocks);
                    assert_eq!(
                        blocks.map(f64::to_bits),
                        [0.0, 1.0, 1.0, 2.0].map(f64::to_bits)
                    );
                });
            }
        });
    }
}
