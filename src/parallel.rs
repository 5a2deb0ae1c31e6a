//! Work that may be shared among threads: by `rayon` with the feature of that name, else one after the other.
//! What is computed never depends on it: jobs write to places of their own, and sums are of integers.

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

/// Runs both.
#[cfg(feature = "rayon")]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    rayon::join(a, b)
}

/// Runs both.
#[cfg(not(feature = "rayon"))]
pub(crate) fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    (a(), b())
}

/// Runs `work` on each run of `size` items, the last maybe shorter, with its number.
#[cfg(feature = "rayon")]
pub(crate) fn for_each_chunk<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    use rayon::prelude::*;
    items.par_chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}

/// Runs `work` on each run of `size` items, the last maybe shorter, with its number.
#[cfg(all(feature = "alloc", not(feature = "rayon")))]
pub(crate) fn for_each_chunk<T: Send>(items: &mut [T], size: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    items.chunks_mut(size).enumerate().for_each(|(number, chunk)| work(number, chunk));
}
