//! Poses that bring a small body to a corner of a large one.

use super::data::MeshData;
use super::rng::Rng;

type Rows = [[f64; 4]; 3];

/// `count` poses of `small` in the frame of `large`: a random rotation; a random corner of a triangle of
/// `small` coincides with a random corner of `large`; then a shift of at most `share` of the diagonal of
/// `small` along each axis.
pub(crate) fn near_corners(
    small: &MeshData,
    large: &MeshData,
    share: f64,
    count: usize,
    rng: &mut Rng,
) -> Vec<Rows> {
    let reach = share * small.diagonal();
    let mut pose = || {
        let rotation = rng.rotation();
        let [from, to] = [small, large].map(|mesh| mesh.vertices[rng.pick(&mesh.triangles)[0] as usize]);
        let shift: [f64; 3] = core::array::from_fn(|_| rng.range(-reach, reach));
        core::array::from_fn(|i| {
            let [x, y, z] = rotation[i];
            [x, y, z, (to[i] + shift[i]) - ((x * from[0] + y * from[1]) + z * from[2])]
        })
    };
    (0..count).map(|_| pose()).collect()
}

/// The pose of the other body in the frame of the posed one, up to rounding.
pub(crate) fn inverse(rows: &Rows) -> Rows {
    core::array::from_fn(|i| {
        let column = rows.map(|row| row[i]);
        let shift = (column[0] * rows[0][3] + column[1] * rows[1][3]) + column[2] * rows[2][3];
        [column[0], column[1], column[2], -shift]
    })
}

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (near_corners, inverse);
};
