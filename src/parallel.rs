//! Work on data that is stored range by range, one range per row or family.

pub(crate) use perifrac_solvers::parallel::*;

/// Ranges that one task works on.
pub(crate) const TASK: usize = 512;

/// Calls `work(i, its part of data)` for all ranges in parallel and gives what it returned, shape
/// `(offsets.len() − 1,)`; range `i` of `data` starts at `offsets[i]`.
///
/// Every range is owned by one call, so results do not depend on the number of threads.
pub(crate) fn by_ranges<T: Send, R: Send + Clone + Default>(
    offsets: &[u32],
    data: &mut [T],
    work: impl Fn(usize, &mut [T]) -> R + Sync,
) -> Vec<R> {
    let ranges = offsets.len().saturating_sub(1);
    let mut results = vec![R::default(); ranges];
    let mut rest = data;
    let mut tasks = Vec::with_capacity(ranges.div_ceil(TASK));
    for (task, results) in results.chunks_mut(TASK).enumerate() {
        let first = task * TASK;
        let length = offsets[first + results.len()] - offsets[first];
        let (part, tail) = rest.split_at_mut(length as usize);
        tasks.push((first, part, results));
        rest = tail;
    }
    each(&mut tasks, 1, |_, (first, part, results)| {
        let mut part = std::mem::take(part);
        for (i, result) in (*first..).zip(results.iter_mut()) {
            let (own, tail) = part.split_at_mut((offsets[i + 1] - offsets[i]) as usize);
            *result = work(i, own);
            part = tail;
        }
    });
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_range_is_worked_on_once_empty_ones_too() {
        let lengths: Vec<u32> = (0..3 * TASK as u32 + 7).map(|i| i % 4).collect();
        let mut offsets = vec![0];
        for length in &lengths {
            offsets.push(offsets[offsets.len() - 1] + length);
        }
        let mut data = vec![0_usize; offsets[lengths.len()] as usize];
        let seen = by_ranges(&offsets, &mut data, |i, own| {
            own.iter_mut().for_each(|value| *value += i + 1);
            own.len() as u32
        });
        assert_eq!(seen, lengths);
        for (i, pair) in offsets.windows(2).enumerate() {
            let own = &data[pair[0] as usize..pair[1] as usize];
            assert!(own.iter().all(|value| *value == i + 1));
        }
        assert!(by_ranges(&[0], &mut [0.0; 0], |_, _| ()).is_empty());
    }
}
