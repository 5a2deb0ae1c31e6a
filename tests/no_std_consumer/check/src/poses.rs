//! The poses, and the verdicts that geometry gives: two equal rings, one of them moved.

use simdop::query::Answer;

/// From the ring's centre to the centre of its tube.
pub const RING_RADIUS: f64 = 1.0;
/// Radius of the tube.
pub const TUBE_RADIUS: f64 = 0.25;

/// Name, pose by rows, and whether the moved ring meets the one at rest.
///
/// The first two moved rings stand upright: their tube crosses the plane of the other ring at `t_x - 1` and `t_x + 1`.
/// They miss it if both are farther than two tube radii from its centre line, that is from `x = -1` and `x = 1`.
pub const POSES: [(&str, [[f64; 4]; 3], bool); 5] = [
    // At 0 and 2: two links of a chain. Their boxes and hulls overlap.
    ("linked", [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]], false),
    // At -0.7 and 1.3: 0.3 from the centre line.
    ("crossing", [[1.0, 0.0, 0.0, 0.3], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]], true),
    // One above the other, 0.1 apart.
    ("above", [[0.6, -0.8, 0.0, 0.2], [0.8, 0.6, 0.0, 0.1], [0.0, 0.0, 1.0, 0.6]], false),
    // Both lie flat, 0.1 apart at their outer rims.
    ("beside", [[0.6, -0.8, 0.0, 2.6], [0.8, 0.6, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]], false),
    // Farther apart than both are wide.
    ("far", [[0.6, -0.8, 0.0, 2.5], [0.8, 0.6, 0.0, 1.5], [0.0, 0.0, 1.0, 0.5]], false),
];

/// Number of random poses of the same two rings, at various depths.
///
/// A rotation by a random quaternion, and a translation in a random direction by at most 2.4. Rings whose centres are
/// farther apart than 2.5 cannot meet.
pub const RANDOM: u32 = 120;

pub fn random(number: u32) -> [[f64; 4]; 3] {
    let mut state = number;
    let mut unit = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // From -1 to 1. Discards the lowest bits, which are not random.
        f64::from(state >> 8) / f64::from(1_u32 << 23) - 1.0
    };
    // The first numbers of neighbouring seeds are similar.
    let _ = (unit(), unit(), unit());
    let [w, x, y, z] = [unit(), unit(), unit(), unit()];
    let twice = 2.0 / (w * w + x * x + y * y + z * z);
    // Maps a point of the plane to the sphere.
    let (u, v) = (unit(), unit());
    let length = 1.2 * (1.0 + unit()) / (1.0 + u * u + v * v);
    let way = [2.0 * u * length, 2.0 * v * length, (1.0 - u * u - v * v) * length];
    [
        [1.0 - twice * (y * y + z * z), twice * (x * y - w * z), twice * (x * z + w * y), way[0]],
        [twice * (x * y + w * z), 1.0 - twice * (x * x + z * z), twice * (y * z - w * x), way[1]],
        [twice * (x * z - w * y), twice * (y * z + w * x), 1.0 - twice * (x * x + y * y), way[2]],
    ]
}

/// Counts an answer: hits, and each of the query statistics.
pub fn tally(sums: &mut [u64; 6], answer: &Answer) {
    let c = &answer.stats;
    let one = [
        u64::from(answer.hit().is_some()),
        c.visits,
        c.kernels,
        c.realignments,
        c.primitive_pairs,
        c.exact_pairs,
    ];
    sums.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
}
