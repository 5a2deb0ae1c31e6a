//! Lenses, the volumes that pairs of spheres share, and sums over them that do not depend on the order.

use super::Penetration;
use crate::exact::power_of_two;
use crate::frame::Frame;
use crate::node::BoundingBall;
use crate::pose::Pose;
use crate::primitive::Sphere;
use crate::primitive::sphere::volume;
use crate::query::entry::{Completion, QueryStats};
use crate::range::Point;
use crate::vector::sqrt;
use core::f64::consts::PI;

/// Sums over pairs of spheres, relative to the centre of the smaller body's frame, in units of [`STEPS`] steps of that
/// frame. The shared volume lies inside the smaller body, at most 2^8 such units from the centre.
pub(super) struct LensSums {
    origin: Point,
    scale: f64,
    volume: Sum,
    direction: [Sum; 3],
    point: [Sum; 3],
    pairs: u64,
}

/// The unit of length, in steps of the frame. In this unit a body extends at most 2^7 from its frame's centre, which
/// the sums have room for.
const STEPS: f64 = 256.0;

/// Bounds and estimate of the volume when the budget is spent, in the bodies' unit.
#[derive(Copy, Clone, Debug)]
pub(super) struct Outlook {
    pub(super) estimate: f64,
    pub(super) upper: f64,
}

impl LensSums {
    pub(super) fn new(a: &Frame, b: &Frame, pose: &Pose) -> Self {
        let is_a = a.scale() > b.scale();
        let origin = if is_a { pose.apply(a.centre) } else { b.centre };
        let scale = (if is_a { a.scale() } else { b.scale() }) / STEPS;
        let (volume, direction, point) = (Sum::ZERO, [Sum::ZERO; 3], [Sum::ZERO; 3]);
        Self { origin, scale, volume, direction, point, pairs: 0 }
    }

    pub(super) fn finish(&self, rest: Option<Outlook>, stats: QueryStats) -> Penetration {
        let volume = self.volume.value();
        let unscale = 1.0 / self.scale;
        let mean = |sums: &[Sum; 3]| sums.each_ref().map(|sum| sum.value() / volume);
        let is_deep = volume > 0.0;
        let point = || {
            let mean = mean(&self.point);
            core::array::from_fn(|i| self.origin[i] + mean[i] * unscale)
        };
        let volume = self.volume();
        let Outlook { estimate, upper } = rest.unwrap_or(Outlook { estimate: volume, upper: volume });
        Penetration {
            volume,
            upper,
            estimate: f64::max(f64::min(estimate, upper), volume),
            direction: if is_deep { mean(&self.direction) } else { [0.0; 3] },
            point: is_deep.then(point),
            pairs: self.pairs,
            completion: if rest.is_none() { Completion::Complete } else { Completion::OutOfBudget },
            stats,
        }
    }

    /// Adds two spheres that meet, the first one a moved sphere of A.
    #[inline(always)]
    pub(super) fn add(&mut self, a: &Sphere, b: &Sphere) {
        self.pairs += 1;
        let (r_a, r_b) = (a.radius * self.scale, b.radius * self.scale);
        let apart: Point = core::array::from_fn(|i| (a.centre[i] - b.centre[i]) * self.scale);
        let distance = sqrt((apart[0] * apart[0] + apart[1] * apart[1]) + apart[2] * apart[2]);
        let volume = lens(r_a, r_b, distance);
        // Concentric spheres have no direction.
        let towards = apart.map(|x| if distance > 0.0 { x / distance } else { 0.0 });
        // On the line of centres, the lens begins at the later of the two near ends and stops at the earlier of the two
        // far ends.
        let low = f64::max(distance - r_a, -r_b);
        let high = f64::min(distance + r_a, r_b);
        let middle = 0.5 * (low + high);
        self.volume.add(volume);
        for (i, along) in towards.into_iter().enumerate() {
            let point = (b.centre[i] - self.origin[i]) * self.scale + middle * along;
            self.direction[i].add(volume * along);
            self.point[i].add(volume * point);
        }
    }

    /// The volume so far, in the bodies' unit.
    pub(super) fn volume(&self) -> f64 {
        let unscale = 1.0 / self.scale;
        self.volume.value() * unscale * unscale * unscale
    }
}

/// The volume that the spheres in two balls would share if they filled the balls evenly: the lens times the filled
/// fractions of both balls. NaN for balls of radius zero.
pub(super) fn expected(a: &BoundingBall, b: &BoundingBall) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|i| f64::from(b.centre[i] - a.centre[i]));
    let distance = sqrt((x * x + y * y) + z * z);
    let [of_a, of_b] = [a, b].map(|ball| volume(ball.radius.into()));
    // Overlapping spheres count as filling at most the whole ball.
    let taken = f64::min(a.volume.into(), of_a) * f64::min(b.volume.into(), of_b);
    lens(a.radius.into(), b.radius.into(), distance) * taken / (of_a * of_b)
}

/// The shared volume of two balls whose centres are `distance` apart.
fn lens(r_a: f64, r_b: f64, distance: f64) -> f64 {
    let (sum, difference) = (r_a + r_b, (r_a - r_b).abs());
    if distance >= sum {
        return 0.0;
    }
    let smaller = f64::min(r_a, r_b);
    if distance <= difference {
        return volume(smaller);
    }
    let depth = sum - distance;
    // (distance - difference) (distance + 3 difference) + 4 smaller distance, without a difference of squares.
    let rest = (distance - difference) * (distance + 3.0 * difference) + 4.0 * smaller * distance;
    PI * (depth * depth) * rest / (12.0 * distance)
}

/// A sum that does not depend on the order of its terms: integers, in three parts. Terms have a magnitude below 2^40
/// and are truncated at 2^-124. At most 2^60 terms.
#[derive(Copy, Clone)]
struct Sum([i128; 3]);

/// The unit of each part of a sum.
const UNITS: [f64; 3] = [power_of_two(-20), power_of_two(-72), power_of_two(-124)];

impl Sum {
    const ZERO: Self = Self([0; 3]);

    #[inline(always)]
    fn add(&mut self, mut x: f64) {
        for (sum, unit) in self.0.iter_mut().zip(UNITS) {
            // Exact: the units are powers of two, and the remainder has no more bits than `x`.
            let whole = (x * (1.0 / unit)) as i64;
            *sum += i128::from(whole);
            x -= whole as f64 * unit;
        }
    }

    fn value(&self) -> f64 {
        let [high, middle, low] = self.0.map(|sum| sum as f64);
        high * UNITS[0] + (middle * UNITS[1] + low * UNITS[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use alloc::vec::Vec;

    #[test]
    fn sums_are_those_of_any_order() {
        let mut rng = Rng::new(1);
        let mut random = |bits: u32| rng.u64() >> (64 - bits);
        // From 2^-140 to 2^32, of both signs.
        let numbers: Vec<f64> = (0..2000)
            .map(|_| {
                let x = random(53) as f64 * power_of_two(random(7) as i32 - 180 + random(5) as i32);
                if random(1) == 0 { x } else { -x }
            })
            .collect();
        let sum = |numbers: &mut dyn Iterator<Item = &f64>| {
            let mut sum = Sum::ZERO;
            numbers.for_each(|x| sum.add(*x));
            (sum.0, sum.value())
        };
        let (forth, back) = (sum(&mut numbers.iter()), sum(&mut numbers.iter().rev()));
        assert_eq!(forth, back);
        // Each term loses less than a unit; a multiple of the unit loses nothing.
        for x in &numbers {
            let (_, alone) = sum(&mut core::iter::once(x));
            assert!((alone - x).abs() <= UNITS[2], "{x:e} {alone:e}");
            assert!(x.abs() < power_of_two(-70) || alone == *x, "{x:e} {alone:e}");
        }
    }

    /// The volume as two caps. Loses digits where the lens is thin.
    fn by_caps(r_a: f64, r_b: f64, d: f64) -> f64 {
        let cap = |r: f64, h: f64| PI * h * h * (3.0 * r - h) / 3.0;
        let t = (d * d + r_b * r_b - r_a * r_a) / (2.0 * d);
        cap(r_b, r_b - t) + cap(r_a, r_a - (d - t))
    }

    #[test]
    fn lenses_are_two_caps() {
        for r_a in [1.0, 0.3, 2.5] {
            for r_b in [1.0, 0.7, 10.0] {
                let (from, to) = (f64::abs(r_a - r_b), r_a + r_b);
                let smaller = f64::min(r_a, r_b);
                let whole = 4.0 / 3.0 * PI * smaller.powi(3);
                for step in 1..=1000 {
                    let d = from + (to - from) * f64::from(step) / 1001.0;
                    let (got, want) = (lens(r_a, r_b, d), by_caps(r_a, r_b, d));
                    assert!(
                        (got - want).abs() <= 1e-13 * whole * r_b.max(r_a),
                        "{r_a} {r_b} {d}: {got} {want}"
                    );
                    assert_eq!(got, lens(r_b, r_a, d));
                }
                for inside in [0.0, 0.5, 1.0] {
                    assert_eq!(lens(r_a, r_b, from * inside), whole);
                }
                // The volume is continuous where one sphere stops being inside the other, and where they separate.
                // Squares of smaller differences of coordinates underflow to zero.
                let just_out = f64::max(from.next_up(), 1e-160);
                assert!((lens(r_a, r_b, just_out) - whole).abs() < 1e-13 * whole);
                assert_eq!([lens(r_a, r_b, to), lens(r_a, r_b, 2.0 * to)], [0.0; 2]);
                let thin = lens(r_a, r_b, to - 1e-6 * smaller);
                assert!(thin > 0.0 && thin < 1e-10 * whole, "{thin:e}");
            }
        }
    }

    #[test]
    fn expected_shares_are_those_of_evenly_spread_spheres() {
        let ball = |x: f32, radius: f32, share: f64| BoundingBall {
            centre: [x, 0.0, 0.0],
            radius,
            volume: (share * volume(radius.into())) as f32,
        };
        let close = |got: f64, want: f64| assert!((got - want).abs() <= 1e-6 * want, "{got} {want}");
        // Two unit balls at distance 1 share 5 / 16 of one.
        let unit = volume(1.0);
        for (of_a, of_b) in [(1.0, 1.0), (0.5, 1.0), (0.25, 0.5)] {
            close(expected(&ball(0.0, 1.0, of_a), &ball(1.0, 1.0, of_b)), unit * 5.0 / 16.0 * of_a * of_b);
            close(expected(&ball(0.0, 4.0, of_a), &ball(1.0, 1.0, of_b)), unit * of_a * of_b);
        }
        // Overlapping spheres share at most the whole ball.
        close(expected(&ball(0.0, 1.0, 3.0), &ball(1.0, 1.0, 1.0)), unit * 5.0 / 16.0);
        assert_eq!(expected(&ball(0.0, 1.0, 0.5), &ball(2.5, 1.0, 0.5)), 0.0);
        assert!(expected(&ball(0.0, 0.0, 1.0), &ball(0.0, 1.0, 1.0)).is_nan());
    }
}
