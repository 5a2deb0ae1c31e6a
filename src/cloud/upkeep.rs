//! When to rebuild the tree (section 4.4 of the paper).

use super::{CloudRef, RangeStats};
use crate::vector::sqrt;

/// When to rebuild a cloud whose points move.
#[derive(Copy, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum Policy {
    /// Never: for points that stay near each other.
    Never,
    /// When the volume of a box has grown by this factor. The paper uses 10. A single outlying point can trigger it.
    Ratio(f64),
    /// When the searches have cost more extra work than a new tree saves. If a search takes `d` more work with every
    /// frame, and a build takes `b` more than a refit, rebuilding after `-1 + sqrt(1 + 2 b / d)` frames minimizes the
    /// work per frame. All work is counted, not timed, so every machine decides alike. This policy reacts only after
    /// a search: if points jump by a tenth of the scene between two frames, one search may take tens of times as
    /// long. The ratio detects that before the search.
    Work,
}

/// Decides when to rebuild, from the results of refits and searches.
///
/// ```
/// use simdop::cloud::{PointCloud, Policy, Queries, Radii, RangeSearch, Upkeep};
/// use simdop::isa::Isa;
///
/// let mut points: Vec<[f32; 3]> = (0..500).map(|i| [i as f32, 0.0, 0.0]).collect();
/// let mut cloud = PointCloud::new(&points)?;
/// let (search, mut upkeep) = (RangeSearch::new(Isa::detect()), Upkeep::new(Policy::Work));
/// let mut counts = [0; 500];
/// for frame in 0..100 {
///     points.iter_mut().enumerate().for_each(|(i, p)| p[0] += (i % 7) as f32);
///     let ratio = cloud.refit(&points)?;
///     let work = search.count(&cloud.view(), &Queries::own(), Radii::Same(2.0), &mut counts)?;
///     if upkeep.is_due(&cloud.view(), ratio, &work) {
///         cloud.rebuild()?;
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Upkeep {
    policy: Policy,
    /// Frames since the tree was built.
    frames: u32,
    /// The work of the first search since then.
    first: u64,
}

/// Cost of a build, in kernel calls per point and level of halving, and of a refit, per point. Measured on AVX2
/// (`benches/results`).
const BUILD: f64 = 0.8;
const REFIT: f64 = 1.4;

impl Upkeep {
    /// For a cloud that was just built.
    #[must_use]
    pub const fn new(policy: Policy) -> Self {
        Self { policy, frames: 0, first: 0 }
    }

    /// Whether to rebuild now, after a frame's refit, which returned `ratio`, and its searches, whose total work is
    /// `work`. If it returns true, the next frame is assumed to have a new tree.
    pub fn is_due(&mut self, cloud: &CloudRef<'_>, ratio: f64, work: &RangeStats) -> bool {
        let is_due = match self.policy {
            Policy::Never => false,
            Policy::Ratio(most) => ratio > most,
            Policy::Work => self.pays(cloud, work.boxes + work.buckets),
        };
        self.frames = if is_due { 0 } else { self.frames.saturating_add(1) };
        is_due
    }

    fn pays(&mut self, cloud: &CloudRef<'_>, work: u64) -> bool {
        if self.frames == 0 {
            self.first = work;
            return false;
        }
        let (frames, points) = (f64::from(self.frames), cloud.len() as f64);
        // Levels of halving from all points to a bucket, rounded up.
        let levels = f64::from(usize::BITS - cloud.buckets().len().leading_zeros());
        let saved = (BUILD * levels - REFIT) * points;
        let growth = work.saturating_sub(self.first) as f64 / frames;
        growth > 0.0 && frames >= sqrt(1.0 + 2.0 * f64::max(saved, 0.0) / growth) - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::{Aabb16, Bucket};

    #[test]
    fn policies_say_when() {
        let (nodes, buckets) = ([Aabb16::EMPTY; 1], [Bucket::EMPTY; 100]);
        let cloud =
            CloudRef { nodes: &nodes, buckets: &buckets, points: 1600, capacity: 1600, bucket_size: 16 };
        let due = |policy, ratio: f64, growth: u64| {
            let mut upkeep = Upkeep::new(policy);
            let work = |frame: u64| RangeStats { boxes: 10_000 + growth * frame, buckets: 5, neighbours: 0 };
            (0..10_000).find(|&frame| upkeep.is_due(&cloud, ratio, &work(frame)))
        };
        assert_eq!(due(Policy::Never, 1e9, 1000), None);
        assert_eq!(due(Policy::Ratio(10.0), 10.0, 1000), None);
        assert_eq!(due(Policy::Ratio(10.0), 10.5, 0), Some(0));
        assert_eq!(due(Policy::Work, 1e9, 0), None);
        // (0.8 * 7 - 1.4) * 1600 = 6720 for a build: -1 + sqrt(1 + 13440 / growth).
        assert_eq!(due(Policy::Work, 1.0, 13440), Some(1));
        assert_eq!(due(Policy::Work, 1.0, 13440 / 8 + 1), Some(2));
        assert_eq!(due(Policy::Work, 1.0, 13440 / 120 + 1), Some(10));
    }
}
