//! The reference answer without a tree.

use crate::lens::lens;
use simdop::pose::Pose;
use simdop::primitive::Sphere;

/// An answer.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Shared {
    pub(crate) volume: f64,
    /// Pairs of spheres that meet.
    pub(crate) pairs: u64,
}

/// Tests every sphere against every other.
pub(crate) fn by_all_pairs([a, b]: [&[Sphere]; 2], pose: &Pose) -> Shared {
    let (mut volume, mut pairs) = (0.0, 0);
    for p in a.iter().map(|sphere| Sphere { centre: pose.apply(sphere.centre), ..*sphere }) {
        for q in b {
            let [x, y, z] = [0, 1, 2].map(|i| (p.centre[i] - q.centre[i]) * (p.centre[i] - q.centre[i]));
            let (square, reach) = ((x + y) + z, p.radius + q.radius);
            if square <= reach * reach {
                pairs += 1;
                volume += lens(p.radius, q.radius, square.sqrt());
            }
        }
    }
    Shared { volume, pairs }
}
