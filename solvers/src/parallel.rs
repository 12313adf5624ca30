//! Loops whose items do not depend on each other, on the threads of the pool.
//!
//! Every item is worked on by one thread, and results have places of their own, so that bits do not depend on the number
//! of threads. All loops share the one function that hands out parts: parallel iterators are compiled anew for every
//! loop, and were a sixth of the program.

use std::mem::MaybeUninit;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Calls `work` with parts of `0..items`, which are disjoint, cover it, and have `least` items or more where there are
/// as many. A part that a thread takes over from another is divided further.
pub fn parts(items: usize, least: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
    let threads = rayon::current_num_threads();
    if threads > 1 {
        let least = least.max(1);
        let task = Task {
            threads,
            least,
            work,
        };
        task.split(0..items, threads, false);
    } else if items > 0 {
        work(0..items);
    }
}

struct Task<'a> {
    threads: usize,
    least: usize,
    work: &'a (dyn Fn(Range<usize>) + Sync),
}

impl Task<'_> {
    /// Divides a part as parallel iterators do: `halvings` counts down, and begins anew where the part has `moved` to
    /// another thread.
    fn split(&self, items: Range<usize>, halvings: usize, moved: bool) {
        if items.len() / 2 < self.least || halvings == 0 && !moved {
            if !items.is_empty() {
                (self.work)(items);
            }
            return;
        }
        let halvings = match moved {
            true => self.threads.max(halvings / 2),
            false => halvings / 2,
        };
        let middle = items.start + items.len() / 2;
        rayon::join_context(
            |context| self.split(items.start..middle, halvings, context.migrated()),
            |context| self.split(middle..items.end, halvings, context.migrated()),
        );
    }
}

/// Places of results, of which every part of a loop writes its own.
pub(crate) struct Places<T>(*mut T);

// SAFETY: a part reaches the places of its own items alone, so that no place is shared by two threads.
unsafe impl<T: Send> Sync for Places<T> {}

impl<T> Places<T> {
    pub(crate) fn of(slice: &mut [T]) -> Self {
        Places(slice.as_mut_ptr())
    }

    /// # Safety
    /// The range lies within the slice, which outlives `'a`, and nothing else reaches its places.
    pub(crate) unsafe fn part<'a>(&self, range: Range<usize>) -> &'a mut [T] {
        // SAFETY: as the caller states.
        unsafe { std::slice::from_raw_parts_mut(self.0.add(range.start), range.len()) }
    }
}

/// Results of all items in their order, shape `(items,)`.
pub fn map<R: Send>(items: usize, at: impl Fn(usize) -> R + Sync) -> Vec<R> {
    map_with(items, 1, || (), |(), item| at(item))
}

/// As [`map`], in parts of `least` items or more that each begin with what `start` gives.
pub fn map_with<S, R: Send>(
    items: usize,
    least: usize,
    start: impl Fn() -> S + Sync,
    at: impl Fn(&mut S, usize) -> R + Sync,
) -> Vec<R> {
    let mut results: Vec<R> = Vec::with_capacity(items);
    let spare: &mut [MaybeUninit<R>] = results.spare_capacity_mut();
    let places = Places::of(&mut spare[..items]);
    parts(items, least, &|part| {
        // SAFETY: parts are disjoint and within `0..items`, and `results` outlives the loop.
        let own = unsafe { places.part(part.clone()) };
        let mut state = start();
        for (place, item) in own.iter_mut().zip(part) {
            place.write(at(&mut state, item));
        }
    });
    // SAFETY: the parts cover `0..items`, so that every place is written.
    unsafe { results.set_len(items) };
    results
}

/// What every item adds to the list that it is given, item after item.
pub fn gather<R: Send>(items: usize, at: impl Fn(usize, &mut Vec<R>) + Sync) -> Vec<R> {
    let found = Mutex::new(Vec::new());
    parts(items, 1, &|part| {
        let (first, mut own) = (part.start, Vec::new());
        part.for_each(|item| at(item, &mut own));
        let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
        found.push((first, own));
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    if found.len() <= 1 {
        return found.pop().map_or_else(Vec::new, |(_, own)| own);
    }
    found.sort_unstable_by_key(|(first, _)| *first);
    let mut all = Vec::with_capacity(found.iter().map(|(_, own)| own.len()).sum());
    found
        .into_iter()
        .for_each(|(_, mut own)| all.append(&mut own));
    all
}

/// Whether all items hold; what is left is skipped once one does not.
pub fn all(items: usize, least: usize, holds: impl Fn(usize) -> bool + Sync) -> bool {
    let fails = AtomicBool::new(false);
    parts(items, least, &|mut part| {
        if !fails.load(Ordering::Relaxed) && !part.all(&holds) {
            fails.store(true, Ordering::Relaxed);
        }
    });
    !fails.into_inner()
}

/// Calls `at` with every value and its number, in parts of `least` values or more.
pub fn each<T: Send>(values: &mut [T], least: usize, at: impl Fn(usize, &mut T) + Sync) {
    each_with(values, least, || (), |(), item, value| at(item, value));
}

/// As [`each`], in parts that each begin with what `start` gives.
pub fn each_with<S, T: Send>(
    values: &mut [T],
    least: usize,
    start: impl Fn() -> S + Sync,
    at: impl Fn(&mut S, usize, &mut T) + Sync,
) {
    let items = values.len();
    let places = Places::of(values);
    parts(items, least, &|part| {
        // SAFETY: parts are disjoint and within `values`, which is borrowed for the whole loop.
        let own = unsafe { places.part(part.clone()) };
        let mut state = start();
        for (value, item) in own.iter_mut().zip(part) {
            at(&mut state, item, value);
        }
    });
}

/// Calls `at` with every `width` values on end, and the number of the chunk; the last one may be shorter.
pub fn chunks<T: Send>(
    values: &mut [T],
    width: usize,
    least: usize,
    at: impl Fn(usize, &mut [T]) + Sync,
) {
    let (length, width) = (values.len(), width.max(1));
    let places = Places::of(values);
    parts(length.div_ceil(width), least, &|part| {
        let range = part.start * width..length.min(part.end * width);
        // SAFETY: chunks of disjoint parts are disjoint and within `values`, which is borrowed for the whole loop.
        let own = unsafe { places.part(range) };
        for (chunk, item) in own.chunks_mut(width).zip(part) {
            at(item, chunk);
        }
    });
}

/// As [`chunks`], for two lists at once: chunk `i` of `widths.0` values of one and of `widths.1` of the other.
pub fn chunk_pairs<T: Send, U: Send>(
    (first, second): (&mut [T], &mut [U]),
    widths: (usize, usize),
    least: usize,
    at: impl Fn(usize, &mut [T], &mut [U]) + Sync,
) {
    let (lengths, widths) = (
        (first.len(), second.len()),
        (widths.0.max(1), widths.1.max(1)),
    );
    let items = (lengths.0.div_ceil(widths.0)).min(lengths.1.div_ceil(widths.1));
    let places = (Places::of(first), Places::of(second));
    parts(items, least, &|part| {
        let range = |length: usize, width: usize| part.start * width..length.min(part.end * width);
        // SAFETY: chunks of disjoint parts are disjoint and within the lists, which are borrowed for the whole loop.
        let (own, other) = unsafe {
            (
                places.0.part(range(lengths.0, widths.0)),
                places.1.part(range(lengths.1, widths.1)),
            )
        };
        let pairs = own.chunks_mut(widths.0).zip(other.chunks_mut(widths.1));
        for ((own, other), item) in pairs.zip(part.clone()) {
            at(item, own, other);
        }
    });
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::test_support::in_pool;

    const ITEMS: [usize; 5] = [0, 1, 7, 511, 4097];

    #[test]
    fn parts_cover_all_items_once_and_are_no_shorter_than_asked() {
        for (threads, items, least) in [(1, 100, 1), (3, 4097, 1), (3, 4097, 600), (3, 5, 9)] {
            let seen: Vec<AtomicUsize> = (0..items).map(|_| AtomicUsize::new(0)).collect();
            in_pool(threads, || {
                parts(items, least, &|part| {
                    assert!(
                        part.len() >= items.min(least / 2),
                        "{part:?} of {items}, {least}"
                    );
                    part.for_each(|item| {
                        seen[item].fetch_add(1, Ordering::Relaxed);
                    });
                });
            });
            assert!(seen.iter().all(|count| count.load(Ordering::Relaxed) == 1));
        }
    }

    #[test]
    fn loops_give_what_plain_ones_give_on_any_number_of_threads() {
        for threads in [1, 3] {
            for items in ITEMS {
                in_pool(threads, || loops(items));
            }
        }
    }

    fn loops(items: usize) {
        let squares: Vec<String> = (0..items).map(|i| (i * i).to_string()).collect();
        assert_eq!(map(items, |i| (i * i).to_string()), squares);
        let few = |i: usize, found: &mut Vec<usize>| found.extend((0..i % 3).map(|k| 10 * i + k));
        let mut plain = Vec::new();
        (0..items).for_each(|i| few(i, &mut plain));
        assert_eq!(gather(items, few), plain);
        let mut values = vec![1; items];
        each(&mut values, 3, |i, value| *value += i);
        assert!(values.iter().enumerate().all(|(i, value)| *value == i + 1));
        chunks(&mut values, 4, 2, |number, chunk| {
            assert_eq!(chunk.len(), 4.min(items - 4 * number));
            chunk.fill(number);
        });
        assert!(values.iter().enumerate().all(|(i, value)| *value == i / 4));
        let mut other = vec![0.0; items.div_ceil(4)];
        chunk_pairs(
            (&mut values, &mut other),
            (4, 1),
            1,
            |number, own, other| {
                other[0] = (own.iter().sum::<usize>() + number) as f64;
            },
        );
        let sum = |number: usize| (number * (4.min(items - 4 * number) + 1)) as f64;
        let same = |(number, own): (usize, &f64)| (own - sum(number)).abs() < 0.5;
        assert!(other.iter().enumerate().all(same));
        assert!(all(items, 1, |i| i < items));
        assert_eq!(all(items, 1, |i| i + 1 != items), items == 0);
    }

    #[test]
    fn a_panic_in_a_part_reaches_the_caller_and_drops_nothing_twice() {
        let found = std::panic::catch_unwind(|| {
            in_pool(3, || {
                map(1000, |i| {
                    assert!(i != 777, "item 777");
                    Box::new(i)
                })
            })
        });
        assert!(found.is_err());
    }
}
