//! The bodies of the examples, generated so that no files are needed.

/// The surface of a box as a mesh: its corners, and two triangles for each of its six faces.
pub(crate) fn cuboid(low: [f64; 3], high: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // Bits 0, 1 and 2 of a corner's index select low or high along x, y and z.
    let corner = |i: usize| [[low, high][i & 1][0], [low, high][i >> 1 & 1][1], [low, high][i >> 2 & 1][2]];
    let triangles = vec![
        [0, 2, 3], // z = low
        [0, 3, 1],
        [4, 5, 7], // z = high
        [4, 7, 6],
        [0, 1, 5], // y = low
        [0, 5, 4],
        [2, 6, 7], // y = high
        [2, 7, 3],
        [0, 4, 6], // x = low
        [0, 6, 2],
        [1, 3, 7], // x = high
        [1, 7, 5],
    ];
    ((0..8).map(corner).collect(), triangles)
}
