//! The frame of a hierarchy, in which its planes are stored.
//!
//! Planes are supports of `(p - centre) * 2^exponent`, in steps of 1 ([`crate::key`]). The exponent is chosen so that
//! the greatest plane of a body just fits a key, in any unit.

use crate::directions::{SUPPORTED, table};
use crate::exact::wide::{Wide, unit_of};
use crate::exact::{Expansion, power_of_two, terms_of_multiple};
#[cfg(feature = "alloc")]
use crate::key::Fixed;
use crate::key::{Key, Storage};
use crate::range::Point;
use crate::vector::sqrt;

/// Maps a body's coordinates to its hierarchy's: translates, then scales by a power of two.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Frame {
    /// Centre of the body's bounding box.
    pub centre: Point,
    /// The scale is `2^exponent`.
    pub exponent: i32,
}

/// Bounds of a body and its planes, in and out of its frame, for the padding of re-alignment.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct BodyBounds {
    /// The frame of the planes.
    pub frame: Frame,
    /// Upper bound of the absolute coordinates of the body and of the frame's centre, in the body's unit.
    pub max_coordinate: f64,
    /// Upper bound of the distance of the body's points from the frame's centre, in the body's unit.
    pub radius: f64,
    /// Upper bounds of `|x|`, `|y|`, `|z|` of the body's points in the frame.
    pub half_width: [f32; 3],
    /// Largest absolute finite plane.
    pub max_plane: f32,
}

impl BodyBounds {
    /// The sum of the half widths, in the frame.
    #[inline(always)]
    pub(crate) fn width_sum(&self) -> f64 {
        let [x, y, z] = self.half_width.map(f64::from);
        (x + y) + z
    }
}

/// The greatest plane of a body is scaled to between 2^14 and 2^15, the range of a key, or just below.
#[cfg(feature = "alloc")]
const PLANE_EXPONENT: i32 = 14;

/// Largest absolute scale exponent: keeps `2^exponent` and its products normal.
pub(crate) const MAX_EXPONENT: i32 = 340;

/// Holds the square of a slack, which is a multiple of 2^-1074 (the least positive number) below 2^360, for any bytes.
type Room = Wide<46>;

/// The slack of a plane in exact arithmetic.
type SupportSum = Expansion<SUPPORT_TERMS>;

/// The maximum number of terms of a slack: the plane, and for each axis the coordinate and the centre, each once per
/// bit of the direction's component.
const SUPPORT_TERMS: usize = {
    let mut most = 0;
    let mut set = 0;
    while set < SUPPORTED.len() {
        let vectors = table(SUPPORTED[set]).vectors;
        let mut j = 0;
        while j < vectors.len() {
            let [x, y, z] = vectors[j];
            let terms =
                terms_of_multiple(x as i16) + terms_of_multiple(y as i16) + terms_of_multiple(z as i16);
            most = if terms > most { terms } else { most };
            j += 1;
        }
        set += 1;
    }
    1 + 2 * most
};

impl Frame {
    /// The frame for a body in the box `min ..= max`, whose coordinates are within [`crate::range::MAX_COORDINATE`]:
    /// the finest in which [`Key`]s can hold its planes in these directions.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub(crate) fn around(min: Point, max: Point, directions: &[Point]) -> Self {
        let centre = core::array::from_fn(|i| 0.5 * min[i] + 0.5 * max[i]);
        let half_width: Point = core::array::from_fn(|i| (max[i] - centre[i]).max(centre[i] - min[i]));
        let reach = |n: &Point| (0..3).map(|i| n[i].abs() * half_width[i]).sum::<f64>();
        // Exceeds the rounding error.
        let most = directions.iter().map(reach).fold(0.0, f64::max) * (1.0 + power_of_two(-40));
        // A body of a single point has no size to scale by.
        let exponent = if most > 0.0 { PLANE_EXPONENT - binary_exponent(most) } else { 0 };
        let exponent = exponent.clamp(-MAX_EXPONENT, MAX_EXPONENT);
        let is_above = most * power_of_two(exponent) > Key::<Fixed>::GREATEST.to_f64();
        Self { centre, exponent: if is_above { exponent - 1 } else { exponent } }
    }

    /// `2^exponent`.
    #[inline]
    #[must_use]
    pub fn scale(&self) -> f64 {
        power_of_two(self.exponent)
    }

    /// Upper bound of the distance from the centre to any point within `radius` of p.
    #[cfg(feature = "alloc")]
    pub(crate) fn reach(&self, p: Point, radius: f64) -> f64 {
        (sqrt(self.square_of_way(p)) + radius) * (1.0 + power_of_two(-46))
    }

    /// Whether all points within `radius` of p are certainly within `reach` of the centre. True if `reach` is at
    /// least [`Frame::reach`].
    // Without a square root, which some machines compute in software.
    pub(crate) fn is_in_reach(&self, p: Point, radius: f64, reach: f64) -> bool {
        let room = reach - radius;
        room >= 0.0 && self.square_of_way(p) * (1.0 + power_of_two(-48)) <= room * room
    }

    fn square_of_way(&self, p: Point) -> f64 {
        let [x, y, z] = [p[0] - self.centre[0], p[1] - self.centre[1], p[2] - self.centre[2]];
        (x * x + y * y) + z * z
    }

    /// Raises each key to the direction's support of the ball of `radius` about `p`: the exact value of
    /// `(n . (p - centre) + |n| radius) * 2^exponent`, rounded up.
    #[cfg(feature = "alloc")]
    #[inline(always)]
    pub(crate) fn raise_supports<S: Storage>(
        &self,
        directions: &[Point],
        p: Point,
        radius: f64,
        keys: &mut [Key<S>],
    ) {
        let d: Point = core::array::from_fn(|i| p[i] - self.centre[i]);
        let scale = self.scale();
        for (n, key) in directions.iter().zip(keys) {
            let (x, y, z) = (n[0] * d[0], n[1] * d[1], n[2] * d[2]);
            let (mut sum, mut size) = ((x + y) + z, (x.abs() + y.abs()) + z.abs());
            if radius > 0.0 {
                let reach = sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2]) * radius;
                (sum, size) = (sum + reach, size + reach);
            }
            let value = sum * scale;
            // Five roundings, each with an error below 2^-53 of a partial result.
            let error = size * scale * power_of_two(-50);
            let rounded = Key::round_up_alike(value - error, value + error);
            *key = (*key).max(rounded.unwrap_or_else(|| self.support_exact(n, p, radius, value)));
        }
    }

    #[cfg(feature = "alloc")]
    #[cold]
    fn support_exact<S: Storage>(&self, direction: &Point, p: Point, radius: f64, near: f64) -> Key<S> {
        let mut key = Key::<S>::round_up_or_unbounded(near);
        // `near` is within a fraction of a step, so at most one step either way is needed.
        while let Some(lower) = key.below()
            && self.is_bounded_around(direction, p, radius, lower)
        {
            key = lower;
        }
        while !self.is_bounded_around(direction, p, radius, key) {
            key = key.next();
        }
        key
    }

    /// Whether plane `key` bounds the support of `p` in `direction`, one of
    /// [`low_level::directions`](crate::low_level::directions). Decided in exact arithmetic.
    ///
    /// # Panics
    /// If `direction` has larger components: the exact sum has no room for more terms.
    #[must_use]
    pub fn is_bounded<S: Storage>(&self, direction: &Point, p: Point, key: Key<S>) -> bool {
        if key == Key::INFINITY {
            return true;
        }
        let plane = key.to_f64() * power_of_two(-self.exponent);
        let (mut rounded, mut size) = (plane, plane.abs());
        for i in 0..3 {
            rounded -= direction[i] * (p[i] - self.centre[i]);
            size += direction[i].abs() * (p[i].abs() + self.centre[i].abs());
        }
        // A dozen roundings, each with an error of at most 2^-53 of a partial sum.
        if rounded.abs() > power_of_two(-48) * size {
            return rounded > 0.0;
        }
        self.is_bounded_exactly(direction, p, plane)
    }

    #[cold]
    #[inline(never)]
    fn is_bounded_exactly(&self, direction: &Point, p: Point, plane: f64) -> bool {
        // Components of directions are small integers.
        let n = direction.map(|x| x as i16);
        let mut slack = SupportSum::ZERO;
        slack.add(plane);
        for axis in 0..3 {
            slack.add_multiple(-n[axis], p[axis]);
            slack.add_multiple(n[axis], self.centre[axis]);
        }
        slack.sign() >= 0
    }

    /// Whether plane `key` bounds the ball of `radius` about `p` in `direction`: [`Frame::is_bounded`] for radius 0,
    /// and as exact for any other. The length of n is a square root, so squares are compared: of the slack between
    /// the plane and `p`, and of `|n| radius`.
    #[must_use]
    pub fn is_bounded_around<S: Storage>(
        &self,
        direction: &Point,
        p: Point,
        radius: f64,
        key: Key<S>,
    ) -> bool {
        if radius > 0.0 && key != Key::INFINITY {
            self.has_room(direction, p, radius, key)
        } else {
            self.is_bounded(direction, p, key)
        }
    }

    fn has_room<S: Storage>(&self, n: &Point, p: Point, radius: f64, key: Key<S>) -> bool {
        let plane = key.to_f64() * power_of_two(-self.exponent);
        let (mut slack, mut size) = (plane, plane.abs());
        for i in 0..3 {
            slack -= n[i] * (p[i] - self.centre[i]);
            size += n[i].abs() * (p[i].abs() + self.centre[i].abs());
        }
        let square = (n[0] * n[0] + n[1] * n[1]) + n[2] * n[2];
        let reach = sqrt(square) * radius;
        // A dozen roundings, each with an error of at most 2^-53 of a partial sum.
        if (slack - reach).abs() > power_of_two(-48) * (size + reach) {
            return slack > reach;
        }
        self.has_room_exactly(n, p, radius, plane)
    }

    #[cold]
    #[inline(never)]
    fn has_room_exactly(&self, n: &Point, p: Point, radius: f64, plane: f64) -> bool {
        let unit = unit_of(p.into_iter().chain(self.centre).chain([radius, plane]));
        let (number, integer) = (|x: f64| Room::new(x, unit), |x: f64| Room::new(x, 0));
        let (mut slack, mut square) = (number(plane), Room::ZERO);
        for i in 0..3 {
            let d = number(p[i]).minus(&number(self.centre[i]));
            let component = integer(n[i]);
            slack = slack.minus(&component.times(&d));
            square = square.plus(&component.times(&component));
        }
        let radius = number(radius);
        let (room, reach): (Room, Room) = (slack.times(&slack), radius.times(&radius));
        slack.sign() >= 0 && room.minus(&square.times(&reach)).sign() >= 0
    }

    /// Whether the ball of radius `reach` about p is inside a ball of this frame. Decided in exact arithmetic.
    #[must_use]
    pub(crate) fn is_in_ball(&self, centre: &Point, radius: f64, p: Point, reach: f64) -> bool {
        let scale = self.scale();
        let (mut square, mut size) = (0.0, radius + reach * scale);
        for i in 0..3 {
            let d = (p[i] - self.centre[i]) * scale - centre[i];
            square += d * d;
            size += (p[i].abs() + self.centre[i].abs()) * scale + centre[i].abs();
        }
        let (distance, room) = (sqrt(square), radius - reach * scale);
        // A dozen roundings, each with an error of at most 2^-53 of a partial sum.
        if (room - distance).abs() > power_of_two(-48) * size {
            return room > distance;
        }
        self.is_in_ball_exactly(centre, radius, p, reach)
    }

    #[cold]
    #[inline(never)]
    fn is_in_ball_exactly(&self, centre: &Point, radius: f64, p: Point, reach: f64) -> bool {
        let unscale = power_of_two(-self.exponent);
        let (centre, radius) = (centre.map(|x| x * unscale), radius * unscale);
        let unit = unit_of(p.into_iter().chain(self.centre).chain(centre).chain([radius, reach]));
        let number = |x: f64| Room::new(x, unit);
        let mut square = Room::ZERO;
        for i in 0..3 {
            let d = number(p[i]).minus(&number(self.centre[i])).minus(&number(centre[i]));
            square = square.plus(&d.times(&d));
        }
        let room = number(radius).minus(&number(reach));
        room.sign() >= 0 && room.times::<46, 46>(&room).minus(&square).sign() >= 0
    }

    /// -1, 0 or 1: the sign of `n . (p - centre) * 2^exponent - bound`, in exact arithmetic, for a vector n of
    /// integers below 2^11.
    #[must_use]
    pub(crate) fn side(&self, n: &Point, p: Point, bound: f64) -> i32 {
        let mut terms = Expansion::<SIDE_TERMS>::ZERO;
        let bound = bound * power_of_two(-self.exponent);
        let (mut value, mut size) = (-bound, bound.abs());
        for i in 0..3 {
            value += n[i] * (p[i] - self.centre[i]);
            size += n[i].abs() * (p[i].abs() + self.centre[i].abs());
        }
        // A dozen roundings, each with an error of at most 2^-53 of a partial sum.
        if value.abs() > power_of_two(-48) * size {
            return if value > 0.0 { 1 } else { -1 };
        }
        terms.add(-bound);
        for i in 0..3 {
            terms.add_multiple(n[i] as i16, p[i]);
            terms.add_multiple(-n[i] as i16, self.centre[i]);
        }
        terms.sign()
    }
}

/// The bound, and for each axis the coordinate and the centre, with eleven powers of two each.
const SIDE_TERMS: usize = 1 + 3 * 2 * 11;

/// A power of two that scales `x`, zero or in the range of coordinates, to below 2.
#[cfg(feature = "alloc")]
pub(crate) fn scale_to_one(x: f64) -> f64 {
    power_of_two(-binary_exponent(x).clamp(-MAX_EXPONENT, MAX_EXPONENT))
}

/// `e` with `2^e <= x < 2^(e+1)`, for a positive normal `x`.
#[cfg(feature = "alloc")]
const fn binary_exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::Directions;

    /// Points up to 2^10 roundings off a plane.
    #[test]
    fn rounded_sums_decide_as_exact_ones() {
        const K: usize = 26;
        let mut bits = 1_u64;
        let mut random = || {
            // Marsaglia's xorshift.
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            bits as f64 * power_of_two(-63) - 1.0
        };
        let mut decided = [0; 2];
        for case in 0..20_000 {
            let frame = Frame { centre: [random(), random(), random()], exponent: 14 };
            let n = &Directions::<K>::VECTORS[case % K];
            let key = Key::<Fixed>::from_code((30_000.0 * random()) as i16).unwrap();
            let axis = (0..3).find(|&i| n[i] != 0.0).unwrap();
            let mut p = [random(), random(), random()];
            let others: f64 = (0..3).filter(|&i| i != axis).map(|i| n[i] * (p[i] - frame.centre[i])).sum();
            let plane = key.to_f64() * power_of_two(-frame.exponent);
            p[axis] = frame.centre[axis] + (plane - others) / n[axis];
            p[axis] += random() * power_of_two(-53 + (case % 11) as i32);
            let want = frame.is_bounded_exactly(n, p, plane);
            assert_eq!(frame.is_bounded(n, p, key), want, "{frame:?} {n:?} {p:?} {key:?}");
            decided[usize::from(want)] += 1;
        }
        assert!(decided.iter().all(|count| *count > 5000), "{decided:?}");
    }

    /// Points on a plane and a few ulps off it, with sums that no single `f64` represents.
    fn planes_are_decided_exactly<const K: usize>() {
        let frame = Frame { centre: [1.0 + f64::EPSILON, -1.0 / 3.0, 0.7], exponent: 20 };
        for j in 0..K {
            let n = &Directions::<K>::VECTORS[j];
            for height in [-1.0, 1.0] {
                let mut p = frame.centre;
                // Along an axis where the direction is not zero: half a step, and then off the plane.
                let axis = (0..3).find(|&i| n[i] != 0.0).unwrap_or(0);
                if n[axis].abs() == 3.0 {
                    continue;
                }
                p[axis] += power_of_two(-21) / n[axis];
                let key = Key::<Fixed>::from_code(0).unwrap();
                assert!(frame.is_bounded(n, p, key), "k {K} direction {j}: on the plane");
                p[axis] += power_of_two(-50) * height * n[axis].signum();
                assert_eq!(frame.is_bounded(n, p, key), height < 0.0, "k {K} direction {j}");
            }
        }
    }

    /// Sides of planes whose directions use all available terms, for points on them and one ulp off.
    #[test]
    fn sides_of_any_plane_are_decided_exactly() {
        let frame = Frame { centre: [1.0 + f64::EPSILON, -1.0 / 3.0, 1e-9], exponent: -3 };
        let normals =
            [[683.0, -682.0, 682.0], [-1023.0, 1023.0, 1.0], [2047.0, 0.0, 0.0], [0.0, -2047.0, 0.0]];
        for n in normals {
            assert_eq!(frame.side(&n, frame.centre, 0.0), 0, "{n:?}: on the plane");
            for (axis, height) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
                let mut p = frame.centre;
                p[axis] += power_of_two(-50) * height;
                let sign = if n[axis] == 0.0 { 0 } else { (n[axis] * height).signum() as i32 };
                assert_eq!(frame.side(&n, p, 0.0), sign, "{n:?}, axis {axis}");
            }
        }
        // 2047 (1 + 2^-52) / 8 lies between these neighbours, nearer to the upper.
        let upper = 2047.0 * (1.0 + f64::EPSILON) / 8.0;
        let p = [2.0 * frame.centre[0], 0.0, 0.0];
        assert_eq!(frame.side(&normals[2], p, upper), -1);
        assert_eq!(frame.side(&normals[2], p, upper.next_down()), 1);
        // 1 + 2^-53 + 2^-80 rounds to 1 + 2^-52. Minus 2^-53 + 2^-79, the exact value is below 1, and the rounded one
        // above.
        let [half, x, y] = [-53, -80, -79].map(power_of_two);
        let frame = Frame { centre: [-half - x, half + y, 0.0], exponent: 0 };
        assert_eq!(frame.side(&[1.0, 1.0, 2045.0], [1.0, 0.0, 0.0], 1.0), -1);
    }

    /// Balls that spheres touch from inside, or miss by one ulp.
    #[test]
    fn is_in_ball_is_decided_exactly() {
        let frame = Frame { centre: [1.0, -2.0, 3.0], exponent: -1 };
        // In the frame's unit, p is at (1, 2, 2), three units from the ball's centre at the origin.
        let p = [3.0, 2.0, 7.0];
        let is_in = |radius: f64, reach: f64| frame.is_in_ball(&[0.0; 3], radius, p, reach);
        for reach in [0.0, 1.0, 0.1 + 0.2, 2.0_f64.powi(-40)] {
            // Sums that round up and down.
            let radius = 3.0 + 0.5 * reach;
            let exact = (radius - 3.0) - 0.5 * reach;
            assert_eq!(is_in(radius, reach), exact >= 0.0, "{reach}");
            assert!(is_in(radius.next_up(), reach) && !is_in(radius.next_down(), reach), "{reach}");
        }
        let far = power_of_two(-60);
        assert!(frame.is_in_ball(&[0.0, 0.0, far], 3.0, p, 0.0), "a little nearer");
        assert!(!frame.is_in_ball(&[0.0, 0.0, -far], 3.0, p, 0.0), "a little farther");
        // A sphere larger than the ball, with the same centre: comparing squares alone would accept it.
        assert!(!frame.is_in_ball(&[0.0; 3], 1.0, frame.centre, 2.0_f64.next_up()));
        assert!(frame.is_in_ball(&[0.0; 3], 1.0, frame.centre, 2.0));
        let lowest = f64::from_bits(1);
        assert!(!frame.is_in_ball(&[0.0; 3], 0.0, frame.centre, lowest));
    }

    #[test]
    fn the_slack_of_every_direction_has_room() {
        planes_are_decided_exactly::<6>();
        planes_are_decided_exactly::<14>();
        planes_are_decided_exactly::<18>();
        planes_are_decided_exactly::<26>();
        planes_are_decided_exactly::<32>();
        assert_eq!(SUPPORT_TERMS, 9, "the plane, and (3, -2, 1) in four powers of two, twice");
    }
}
