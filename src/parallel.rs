//! Parallel loops: by `rayon` with the feature of that name, else sequential. Results do not depend on it: jobs write
//! to separate places, and sums are of integers.

/// Runs `work` on every job, each thread with its own scratch memory.
#[cfg(feature = "rayon")]
pub(crate) fn for_each<J: Send, S: Default>(jobs: alloc::vec::Vec<J>, work: impl Fn(&mut S, J) + Sync) {
    use rayon::prelude::*;
    jobs.into_par_iter().for_each_init(S::default, &work);
}

/// Runs `work` on every job, with one scratch memory for all.
#[cfg(all(feature = "alloc", not(feature = "rayon")))]
pub(crate) fn for_each<J: Send, S: Default>(jobs: alloc::vec::Vec<J>, work: impl Fn(&mut S, J) + Sync) {
    let mut scratch = S::default();
    for job in jobs {
        work(&mut scratch, job);
    }
}

/// Runs both closures.
#[cfg(feature = "rayon")]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Runs both closures.
#[cfg(not(feature = "rayon"))]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

/// Runs `work` on each chunk of `size` items, of which the last may be shorter, with its index.
#[cfg(feature = "rayon")]
pub(crate) fn for_each_chunk<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    use rayon::prelude::*;
    items.par_chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}

/// Runs `work` on each chunk of `size` items, of which the last may be shorter, with its index.
#[cfg(all(feature = "alloc", not(feature = "rayon")))]
pub(crate) fn for_each_chunk<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    items.chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}
