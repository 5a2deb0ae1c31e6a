//! A body that is a single point, with tight planes.

use crate::support::dyadic::key_value;
use crate::support::rng::Rng;
use crate::support::turns::random_point;
use simdop::low_level::directions;
use simdop::low_level::frame::{BodyBounds, Frame};
use simdop::low_level::key::{Fixed, Key};
use simdop::range::Point;

/// The bounds of a body that is the origin.
pub(crate) const NO_EXTENT: BodyBounds = BodyBounds {
    frame: Frame { centre: [0.0; 3], exponent: 0 },
    max_coordinate: 0.0,
    radius: 0.0,
    half_width: [0.0; 3],
    max_plane: 0.0,
};

/// A body that is a single point. Where the directions have an odd number of odd components (all of k = 6 and
/// 14), its planes are exactly keys, so that nothing is lost before the planes are rotated. The other planes
/// are half a step off.
pub(crate) struct OnePoint<const K: usize> {
    pub(crate) extent: BodyBounds,
    pub(crate) point: Point,
    pub(crate) planes: [i16; K],
}

impl<const K: usize> OnePoint<K> {
    pub(crate) fn new(rng: &mut Rng) -> Self {
        let largest = *rng.pick(&[3, 100, 5000]);
        let y = [(); 3].map(|()| rng.int(-largest, largest) as f64 + 0.5);
        let support = |n: &[i8; 3]| n.iter().zip(y).map(|(&n, y)| f64::from(n) * y).sum::<f64>();
        let supports: [f64; K] = core::array::from_fn(|j| support(&directions::table(K).vectors[j]));
        let mut extent = NO_EXTENT;
        extent.frame.exponent = rng.int(-3, 9) as i32;
        // Multiples of 2^-10, so that the point is at y in the frame without rounding.
        extent.frame.centre = random_point(rng, [0.0, 10.0, 1e6]).map(|x| (x * 1024.0).round() / 1024.0);
        let scale = f64::from_bits(((1023 - extent.frame.exponent) as u64) << 52);
        let point: Point = core::array::from_fn(|i| extent.frame.centre[i] + y[i] * scale);
        extent.max_coordinate = point.iter().chain(&extent.frame.centre).fold(0.0, |m, x| x.abs().max(m));
        extent.radius = 2.0 * (largest as f64 + 0.5) * scale;
        extent.half_width = y.map(|x| x.abs() as f32);
        extent.max_plane = supports.iter().fold(0.0, |m, x| x.abs().max(m)) as f32 + 0.5;
        let planes = supports.map(|x| {
            let key = Key::<Fixed>::round_up_f64(x).unwrap();
            let is_tight = x.fract().abs() == 0.5;
            assert_eq!(key_value(key.code()), if is_tight { x } else { x + 0.5 });
            key.code()
        });
        Self { extent, point, planes }
    }
}

/// Calls a generic function once for every k.
macro_rules! for_each_k {
    ($function:ident) => {
        $function::<6>();
        $function::<14>();
        $function::<18>();
        $function::<26>();
        $function::<32>();
    };
}

pub(crate) use for_each_k;
