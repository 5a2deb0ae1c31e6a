//! What a tree must find, without one.

use simdop::pose::Pose;
use simdop::primitive::Sphere;

/// An answer.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Shared {
    pub(crate) volume: f64,
    /// Of spheres that meet.
    pub(crate) pairs: u64,
}

/// Of every sphere with every other, one by one.
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

/// What two balls share: a cap of each, on the two sides of the circle in which they meet.
fn lens(r: f64, s: f64, distance: f64) -> f64 {
    let (r, s) = (r.max(s), r.min(s));
    let pi = core::f64::consts::PI;
    if distance >= r + s {
        return 0.0;
    }
    if distance + s <= r {
        return 4.0 / 3.0 * pi * s * s * s;
    }
    let height = |r: f64, s: f64| (s - (distance - r)) * (s + (distance - r)) / (2.0 * distance);
    let cap = |r: f64, h: f64| pi * h * h * (r - h / 3.0);
    cap(r, height(r, s)) + cap(s, height(s, r))
}
