//! The poses, and the verdicts that geometry gives: two equal rings, one of them moved.

/// From the ring's centre to the middle of its tube.
pub const RING_RADIUS: f64 = 1.0;
/// Radius of the tube.
pub const TUBE_RADIUS: f64 = 0.25;

/// Name, pose by rows, and whether the moved ring meets the one at rest.
///
/// The first two moved rings stand upright: their tube passes the plane of the other at `t_x - 1` and `t_x +
/// 1`, and misses it when both are further than two tube radii from its middle line, that is from `x = -1`
/// and `x = 1`.
pub const POSES: [(&str, [[f64; 4]; 3], bool); 5] = [
    // At 0 and 2: two links of a chain. Their boxes and hulls overlap.
    ("linked", [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]], false),
    // At -0.7 and 1.3: 0.3 from the middle line.
    ("crossing", [[1.0, 0.0, 0.0, 0.3], [0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0]], true),
    // One above the other, 0.1 apart.
    ("above", [[0.6, -0.8, 0.0, 0.2], [0.8, 0.6, 0.0, 0.1], [0.0, 0.0, 1.0, 0.6]], false),
    // Both lie flat, 0.1 apart at their outer rims.
    ("beside", [[0.6, -0.8, 0.0, 2.6], [0.8, 0.6, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]], false),
    // Farther apart than both are wide.
    ("far", [[0.6, -0.8, 0.0, 2.5], [0.8, 0.6, 0.0, 1.5], [0.0, 0.0, 1.0, 0.5]], false),
];
