//! Outputs of a search.

use super::List;
use crate::kernel::Kernel;
use crate::node::Bucket;
use core::ops::ControlFlow;

/// Receives the neighbours of each query.
pub(super) trait Sink {
    /// Starts a query.
    fn begin(&mut self, query: u32);
    /// Reports neighbours: the slots of a bucket that are set in `mask`.
    fn found<E: Kernel>(&mut self, kernel: E, mask: u16, bucket: &Bucket) -> ControlFlow<()>;
    /// Ends the query.
    fn end(&mut self, query: u32) -> ControlFlow<()>;
}

pub(super) struct Count<'a> {
    pub(super) counts: &'a mut [u32],
    pub(super) count: u32,
}

impl Sink for Count<'_> {
    #[inline(always)]
    fn begin(&mut self, _: u32) {
        self.count = 0;
    }

    #[inline(always)]
    fn found<E: Kernel>(&mut self, _: E, mask: u16, _: &Bucket) -> ControlFlow<()> {
        self.count += mask.count_ones();
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn end(&mut self, query: u32) -> ControlFlow<()> {
        self.counts[query as usize] = self.count;
        ControlFlow::Continue(())
    }
}

pub(super) struct Fill<'a> {
    pub(super) lists: &'a mut [List],
    pub(super) indices: &'a mut [u32],
    /// Start of the current list.
    pub(super) start: u64,
    /// Neighbours so far, including those that do not fit.
    pub(super) end: u64,
}

impl Sink for Fill<'_> {
    #[inline(always)]
    fn begin(&mut self, _: u32) {
        self.start = self.end;
    }

    #[inline(always)]
    fn found<E: Kernel>(&mut self, kernel: E, mask: u16, bucket: &Bucket) -> ControlFlow<()> {
        // `pick` writes up to sixteen elements; the next neighbours overwrite the excess.
        let (from, count) = (self.end as usize, mask.count_ones() as usize);
        self.end += count as u64;
        let room = self.indices.get_mut(from..).unwrap_or(&mut []);
        if let Some(places) = room.first_chunk_mut::<16>() {
            kernel.pick(mask, &bucket.indices, places);
        } else if let Some(places) = room.get_mut(..count) {
            let mut picked = [0; 16];
            kernel.pick(mask, &bucket.indices, &mut picked);
            places.copy_from_slice(&picked[..count]);
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn end(&mut self, query: u32) -> ControlFlow<()> {
        self.lists[query as usize] = List { start: self.start as u32, count: (self.end - self.start) as u32 };
        ControlFlow::Continue(())
    }
}

/// Buffers neighbours, so that the visitor is called in a loop over many: the end of a loop over those of one bucket
/// is hard to predict for a branch predictor.
pub(super) struct Visit<F> {
    query: u32,
    waiting: [u32; 64],
    count: usize,
    visit: F,
}

impl<F: FnMut(u32, u32) -> ControlFlow<()>> Visit<F> {
    pub(super) const fn new(visit: F) -> Self {
        Self { query: 0, waiting: [0; 64], count: 0, visit }
    }

    #[inline(always)]
    fn flush(&mut self) -> ControlFlow<()> {
        for &neighbour in &self.waiting[..core::mem::take(&mut self.count) & 63] {
            (self.visit)(self.query, neighbour)?;
        }
        ControlFlow::Continue(())
    }
}

impl<F: FnMut(u32, u32) -> ControlFlow<()>> Sink for Visit<F> {
    #[inline(always)]
    fn begin(&mut self, query: u32) {
        self.query = query;
    }

    #[inline(always)]
    fn found<E: Kernel>(&mut self, kernel: E, mask: u16, bucket: &Bucket) -> ControlFlow<()> {
        // There is room for sixteen more: the buffer is flushed above 47.
        if let Some(places) = self.waiting[self.count & 63..].first_chunk_mut::<16>() {
            kernel.pick(mask, &bucket.indices, places);
        }
        self.count += mask.count_ones() as usize;
        if self.count > 47 { self.flush() } else { ControlFlow::Continue(()) }
    }

    #[inline(always)]
    fn end(&mut self, _: u32) -> ControlFlow<()> {
        self.flush()
    }
}
