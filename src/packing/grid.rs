//! The placed spheres in a spatial hash, by size and position.

use alloc::vec::Vec;
use glam::{DVec3, I64Vec3};

/// A ball, in the unit of packing.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct Ball {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

impl Ball {
    /// The distance of `p` from the ball, up to rounding; negative inside.
    pub(super) fn gap(&self, p: DVec3) -> f64 {
        self.centre.distance(p) - self.radius
    }
}

/// Balls of similar size: radii from `2^exponent` to twice that.
#[derive(Copy, Clone, Debug)]
struct SizeClass {
    exponent: i32,
    /// One over the width of a cell, which is twice the upper bound of the radii.
    per_cell: f64,
    greatest: f64,
}

/// Placed balls, hashed by the cells of one grid per size class. Collisions of cells only cost time: a query visits
/// more balls than are near.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    balls: Vec<Ball>,
    /// The next ball in the same bucket, as index + 1; 0 for none.
    next: Vec<u32>,
    /// The first ball of each bucket, as index + 1; 0 for none. The length is a power of two.
    buckets: Vec<u32>,
    /// Largest first.
    classes: Vec<SizeClass>,
}

impl Placed {
    /// Empty, sized for `count` balls.
    pub(super) fn new(count: usize) -> Self {
        let buckets = (4 * count.min(1 << 20)).next_power_of_two();
        Self { balls: Vec::new(), next: Vec::new(), buckets: alloc::vec![0; buckets], classes: Vec::new() }
    }

    /// The balls in order of placement.
    pub(super) fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// Adds a ball.
    pub(super) fn add(&mut self, ball: Ball) {
        let exponent = (ball.radius.to_bits() >> 52) as i32 - 1023;
        let class = match self.classes.iter().position(|class| class.exponent <= exponent) {
            Some(index) if self.classes[index].exponent == exponent => index,
            place => {
                let index = place.unwrap_or(self.classes.len());
                let width = 2.0 * f64::from_bits(((exponent + 1 + 1023) as u64) << 52);
                let class = SizeClass { exponent, per_cell: 1.0 / width, greatest: 0.0 };
                self.classes.insert(index, class);
                index
            }
        };
        let class = &mut self.classes[class];
        class.greatest = class.greatest.max(ball.radius);
        let cell = cell_of(ball.centre, class.per_cell);
        let bucket = self.bucket(exponent, cell.to_array());
        self.next.push(core::mem::replace(&mut self.buckets[bucket], self.balls.len() as u32 + 1));
        self.balls.push(ball);
    }

    /// Calls `visit` with every ball whose gap to `p` may be at most `limit`. `visit` may lower the limit.
    pub(super) fn near(&self, p: DVec3, mut limit: f64, mut visit: impl FnMut(u32, &Ball, &mut f64)) {
        for class in &self.classes {
            let reach = limit + class.greatest;
            let (low, high) = (cell_of(p - reach, class.per_cell), cell_of(p + reach, class.per_cell));
            let cells = (high - low + 1).as_dvec3().element_product();
            if cells > self.balls.len() as f64 {
                // More cells than balls: small balls, and much free space around the point.
                (0..).zip(&self.balls).for_each(|(index, ball)| visit(index, ball, &mut limit));
                return;
            }
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    for z in low.z..=high.z {
                        let mut entry = self.buckets[self.bucket(class.exponent, [x, y, z])];
                        while entry != 0 {
                            let index = entry - 1;
                            visit(index, &self.balls[index as usize], &mut limit);
                            entry = self.next[index as usize];
                        }
                    }
                }
            }
        }
    }

    /// The radius at which a ball is certainly disjoint from all others; at most its own.
    pub(super) fn certain_clearance(&self, ball: &Ball) -> f64 {
        /// Three differences, their squares, two sums and a root; the difference of two radii.
        const ROUNDINGS: f64 = 1.0 - 8.0 * f64::EPSILON;
        let mut free = ball.radius;
        // Search slightly farther, since gaps are rounded.
        self.near(ball.centre, 1.0001 * ball.radius, |_, other, _| {
            let apart = other.centre.distance(ball.centre) * ROUNDINGS;
            free = free.min((apart - other.radius) * ROUNDINGS);
        });
        free
    }

    /// All balls, in order of placement.
    pub(super) fn into_balls(self) -> Vec<Ball> {
        self.balls
    }

    /// The ball with the least gap to `p`, and that gap, if it is below `limit`.
    pub(super) fn nearest(&self, p: DVec3, limit: f64) -> Option<(f64, u32)> {
        let mut best: Option<(f64, u32)> = None;
        self.near(p, limit, |index, ball, limit| {
            let reach = *limit + ball.radius;
            // Most balls are rejected without a square root.
            if reach > 0.0 && ball.centre.distance_squared(p) < reach * reach {
                let gap = ball.gap(p);
                if gap < *limit {
                    *limit = gap;
                    best = Some((gap, index));
                }
            }
        });
        best
    }

    /// The hash bucket of a cell.
    fn bucket(&self, exponent: i32, cell: [i64; 3]) -> usize {
        const FACTORS: [u64; 3] = [0x9e37_79b9_7f4a_7c15, 0xc2b2_ae3d_27d4_eb4f, 0x1656_67b1_9e37_79f9];
        let mut hash = exponent as u64;
        for (x, factor) in cell.into_iter().zip(FACTORS) {
            hash = (hash ^ x as u64).wrapping_mul(factor);
            hash ^= hash >> 29;
        }
        hash as usize & (self.buckets.len() - 1)
    }
}

/// The cell of a point. Coordinates are far above -16, so truncation rounds down.
fn cell_of(p: DVec3, per_cell: f64) -> I64Vec3 {
    ((p + 16.0) * per_cell).as_i64vec3()
}
