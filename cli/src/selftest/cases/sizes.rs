//! Bodies far from their origins, of different sizes, and of sizes at the limits of the number formats.

use crate::selftest::draw::{Draw, NO_TURN, power_of_two, scaled};
use crate::selftest::figures::{any_turn, blob, in_contact, poses, resized};
use crate::selftest::oracle::Figure;
use crate::selftest::trial::Trial;
use simdop::range::Point;

/// Two blobs of these sizes about these points, in contact.
fn blobs(draw: &mut Draw, sizes: [f64; 2], centres: [Point; 2]) -> Trial {
    let one = |draw: &mut Draw, size: f64, centre: &Point| {
        let triangles = resized(blob(draw), size);
        Figure::surface(draw.placed(&triangles, &NO_TURN, centre))
    };
    let (a, b) = (one(draw, sizes[0], &centres[0]), one(draw, sizes[1], &centres[1]));
    let smaller = sizes[0].min(sizes[1]);
    let poses = poses(draw, |draw| {
        let turn = any_turn(draw);
        in_contact(draw, [&a, &b], &turn, smaller)
    });
    Trial { a, b, poses }
}

fn far(draw: &mut Draw, distance: f64) -> Trial {
    let away = scaled(&draw.direction(), distance);
    let centres = draw.pick(&[[away, away], [away, [0.0; 3]], [[0.0; 3], away], [away, away.map(|x| -x)]]);
    blobs(draw, [1.0; 2], centres)
}

pub(super) fn far_1e4(draw: &mut Draw) -> Trial {
    far(draw, 1e4)
}

pub(super) fn far_1e6(draw: &mut Draw) -> Trial {
    far(draw, 1e6)
}

/// One body a million times as large as the other.
pub(super) fn scale_ratio(draw: &mut Draw) -> Trial {
    let size = draw.size(0, 0);
    let sizes = draw.pick(&[[size, 1e6], [1e6, size], [1e-6, size], [size, 1e-6], [1e-3, 1e3]]);
    blobs(draw, sizes, [[0.0; 3]; 2])
}

/// Bodies a few units of the smallest coordinates in size: subnormal numbers in single precision, and in double
/// precision, those that the library flushes to zero.
pub(super) fn denormal(draw: &mut Draw) -> Trial {
    let exponent = if draw.is_single { -146 } else { -248 };
    let size = draw.size(exponent, exponent + 6);
    blobs(draw, [size; 2], [[0.0; 3]; 2])
}

/// Bodies of which one is about 2^9 times as large as the other: in the frame of the smaller one, the planes of the
/// larger are far beyond the largest key.
pub(super) fn key_overflow(draw: &mut Draw) -> Trial {
    let ratio = draw.size(7, 10);
    let unit = power_of_two(draw.int(-8, 8));
    let sizes = draw.pick(&[[ratio * unit, unit], [unit, ratio * unit]]);
    blobs(draw, sizes, [[0.0; 3]; 2])
}
