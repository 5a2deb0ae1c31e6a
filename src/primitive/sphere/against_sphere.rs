//! Two spheres: do they meet or come within a margin, and what is their distance?

use super::Sphere;
use crate::exact::power_of_two;
use crate::exact::wide::{Wide, unit_of};
use crate::primitive::Separation;
use crate::range::{MIN_COORDINATE, Point};
use crate::vector::sqrt;

/// Relative allowance for a dozen roundings.
pub(in crate::primitive) const ROUNDING: f64 = power_of_two(-48);

/// Differences of coordinates, and sums of radii: multiples of 2^-302 below 2^305. Their squares have 1218 bits.
type OfDegreeOne = Wide<10>;
type Square = Wide<20>;

/// Whether the two are at most `margin` apart. Exact; a margin above 0 and below [`MIN_COORDINATE`] counts as
/// [`MIN_COORDINATE`].
#[inline(always)]
pub(crate) fn is_within(a: &Sphere, b: &Sphere, margin: f64, exact: &mut u64) -> bool {
    let square = square_between(&a.centre, &b.centre);
    let reach = (a.radius + b.radius) + margin;
    let limit = reach * reach;
    // Five roundings in each. Neither side under- or overflows where they could be equal.
    if square < limit * (1.0 - ROUNDING) {
        return true;
    }
    if square > limit * (1.0 + ROUNDING) {
        return false;
    }
    *exact += 1;
    excess(a, b, margin) <= 0.0
}

/// The distance between the two, or `None` if it is certainly greater than `limit`. The relative difference of the
/// bounds is at most `tolerance`, which is at least 2^-42.
#[inline(always)]
pub(crate) fn nearer(
    a: &Sphere,
    b: &Sphere,
    limit: f64,
    tolerance: f64,
    exact: &mut u64,
) -> Option<Separation> {
    let between = sqrt(square_between(&a.centre, &b.centre));
    let reach = a.radius + b.radius;
    let (gap, error) = (between - reach, ROUNDING * (between + reach));
    if gap - error > limit {
        return None;
    }
    let (lower, upper) = if 2.0 * error <= tolerance * (gap - error) {
        (gap - error, gap + error)
    } else if gap < -error {
        (0.0, 0.0)
    } else {
        *exact += 1;
        bounds_of_gap(excess(a, b, 0.0), between + reach)
    };
    let [p, q] = if upper > 0.0 { nearest_points(a, b, between) } else { [common_point(a, b); 2] };
    Some(Separation { lower, upper, a: p, b: q })
}

/// Bounds of `(x^2 - y^2) / (x + y)`, which is x - y without cancellation; zeros if it is not positive.
pub(in crate::primitive) fn bounds_of_gap(difference_of_squares: f64, sum: f64) -> (f64, f64) {
    if difference_of_squares <= 0.0 {
        return (0.0, 0.0);
    }
    let gap = difference_of_squares / sum;
    let upper = gap * (1.0 + ROUNDING);
    // Subnormal results have no relative precision.
    let is_normal = gap >= f64::MIN_POSITIVE && difference_of_squares > f64::MIN_POSITIVE;
    let lower = if is_normal { gap * (1.0 - ROUNDING) } else { 0.0 };
    (lower, if upper > f64::MIN_POSITIVE { upper } else { f64::MIN_POSITIVE })
}

/// The squared distance between the centres minus the square of the radii plus the margin. Its sign is exact, and its
/// value is accurate to 2^-50.
#[cold]
#[inline(never)]
fn excess(a: &Sphere, b: &Sphere, margin: f64) -> f64 {
    let margin = if margin > 0.0 && margin < MIN_COORDINATE { MIN_COORDINATE } else { margin };
    let unit = unit_of(a.centre.into_iter().chain(b.centre).chain([a.radius, b.radius, margin]));
    let number = |x: f64| OfDegreeOne::new(x, unit);
    let mut excess = Square::ZERO;
    for i in 0..3 {
        let d = number(a.centre[i]).minus(&number(b.centre[i]));
        excess = excess.plus(&d.times(&d));
    }
    let reach = number(a.radius).plus(&number(b.radius)).plus(&number(margin));
    excess.minus(&reach.times(&reach)).over(&OfDegreeOne::new(1.0, 0), 2 * unit)
}

/// The point of each that is nearest to the other. `between` is the distance between the centres.
#[inline(always)]
fn nearest_points(a: &Sphere, b: &Sphere, between: f64) -> [Point; 2] {
    let (p, q) = (&a.centre, &b.centre);
    let (from_a, from_b) = (a.radius / between, b.radius / between);
    let coordinate = |i: usize| (p[i] + (q[i] - p[i]) * from_a, q[i] + (p[i] - q[i]) * from_b);
    let [(x, u), (y, v), (z, w)] = [coordinate(0), coordinate(1), coordinate(2)];
    [[x, y, z], [u, v, w]]
}

/// A common point of two spheres that meet: on the segment between the centres, where its powers with respect to the
/// two are equal, or at the end of the segment nearest to there.
fn common_point(a: &Sphere, b: &Sphere) -> Point {
    let square = square_between(&a.centre, &b.centre);
    let share = 0.5 + 0.5 * ((a.radius - b.radius) * (a.radius + b.radius)) / square;
    // Equal centres give infinity or NaN.
    let share = if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 };
    core::array::from_fn(|i| a.centre[i] + (b.centre[i] - a.centre[i]) * share)
}

#[inline(always)]
fn square_between(p: &Point, q: &Point) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y) + z * z
}
