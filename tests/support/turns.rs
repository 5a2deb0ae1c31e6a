//! Rotations and points that are difficult in different ways.

use super::rng::Rng;
use simdop::pose::Pose;

/// A matrix by rows.
pub(crate) type Rows = [[f64; 3]; 3];

fn from_quaternion(q: [f64; 4]) -> Rows {
    let length = ((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3])).sqrt();
    let [x, y, z, w] = q.map(|c| c / length);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// A rotation by about `angle` about a random axis.
fn small_turn(rng: &mut Rng, angle: f64) -> Rows {
    let mut component = || 0.5 * angle * rng.range(-1.0, 1.0);
    let (x, y, z) = (component(), component(), component());
    from_quaternion([x, y, z, 1.0])
}

/// Maps axes to axes: with most sets of directions every direction is mapped to another one.
fn axis_turn(rng: &mut Rng) -> Rows {
    const STEP: Rows = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    const QUARTER: Rows = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let product = |a: Rows, b: Rows| -> Rows {
        core::array::from_fn(|i| core::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    (0..6).fold(STEP, |m, _| product(m, if rng.below(2) == 0 { STEP } else { QUARTER }))
}

pub(crate) fn rotation(rng: &mut Rng) -> Rows {
    match rng.below(8) {
        0 => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        1 => small_turn(rng, 1e-9),
        2 => small_turn(rng, 1e-3),
        3 => axis_turn(rng),
        4 => [[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
        // As far from a rotation as a pose may be.
        5 => rng.rotation().map(|row| row.map(|x| x + rng.range(-2e-5, 2e-5))),
        _ => rng.rotation(),
    }
}

/// A random point in a cube, whose half width is one of these sizes.
pub(crate) fn random_point<const N: usize>(rng: &mut Rng, sizes: [f64; N]) -> [f64; 3] {
    let size = *rng.pick(&sizes);
    [(); 3].map(|()| rng.range(-size, size))
}

pub(crate) fn add(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| p[i] + q[i])
}

/// The pose that first rotates and then translates.
pub(crate) fn pose(turn: &Rows, t: [f64; 3]) -> Pose {
    Pose::from_rows(core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]])).unwrap()
}

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (rotation, random_point::<1>, add, pose);
};
