//! Meshes made by rule. Correctly rounded operations only (no sines), so that every machine makes the same
//! ones.

use super::data::MeshData;
use super::rng::Rng;

/// Point `i` of `n` on the unit circle: evenly along a square, then normalised.
fn on_circle(i: u32, n: u32) -> [f64; 2] {
    let side = 4.0 * f64::from(i % n) / f64::from(n);
    let along = side - side.floor();
    let (x, y) = match side as u32 {
        0 => (1.0 - along, along),
        1 => (-along, 1.0 - along),
        2 => (along - 1.0, -along),
        _ => (along, along - 1.0),
    };
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

/// Triangles of a grid of `rows` x `columns` vertices, row by row; a closed direction joins its last line to
/// its first.
fn quads(rows: u32, columns: u32, closed: bool) -> Vec<[u32; 3]> {
    let open = u32::from(!closed);
    let index = |i: u32, j: u32| i % rows * columns + j % columns;
    let mut triangles = Vec::new();
    for i in 0..rows - open {
        for j in 0..columns - open {
            let [p, q, r, s] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    triangles
}

/// A ring of radius 1 with a tube of radius 0.4 about the z axis: 2 `around` `along` triangles, watertight.
pub(crate) fn torus(around: u32, along: u32) -> MeshData {
    let mut vertices = Vec::new();
    for i in 0..around {
        let [x, y] = on_circle(i, around);
        for j in 0..along {
            let [out, up] = on_circle(j, along);
            let radius = 1.0 + 0.4 * out;
            vertices.push([x * radius, y * radius, 0.4 * up]);
        }
    }
    MeshData { vertices, triangles: quads(around, along, true) }
}

/// A flat square of `side` x `side` vertices at integer places, turned out of the coordinate planes by adding
/// x to z.
pub(crate) fn flat_grid(side: u32) -> MeshData {
    let place = |i: u32| [f64::from(i % side), f64::from(i / side), f64::from(i % side)];
    MeshData { vertices: (0..side * side).map(place).collect(), triangles: quads(side, side, false) }
}

/// `n` separate triangles of about `size` with centres in the cube of half width 1.
pub(crate) fn soup(rng: &mut Rng, n: usize, size: f64) -> MeshData {
    let triangle = |rng: &mut Rng| {
        let centre: [f64; 3] = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        [(); 3].map(|()| centre.map(|c| c + rng.range(-size, size)))
    };
    separate((0..n).map(|_| triangle(rng)))
}

/// The same triangle `n` times.
pub(crate) fn coincident(n: usize) -> MeshData {
    separate(core::iter::repeat_n([[0.1, 0.2, 0.3], [0.7, -0.1, 0.2], [0.3, 0.4, -0.6]], n))
}

/// `n` triangles without area along one skew line.
pub(crate) fn collinear(n: usize) -> MeshData {
    let at = |t: f64| [t, 2.0 * t, -t];
    separate((0..n).map(|i| [0.0, 1.0, 3.0].map(|offset| at(i as f64 + offset))))
}

/// One triangle of size 1000 among `n` of size 0.001.
pub(crate) fn huge_among_tiny(rng: &mut Rng, n: usize) -> MeshData {
    let mut mesh = soup(rng, n, 1e-3);
    let huge = separate([[[-1e3, -1e3, 0.5], [1e3, -1e3, 0.25], [0.0, 1e3, -0.5]]]);
    append(&mut mesh, &huge);
    mesh
}

/// Points, segments and repeated corners on the vertices of `mesh`: `n` triangles without area.
pub(crate) fn without_area(mesh: &MeshData, rng: &mut Rng, n: usize) -> MeshData {
    let degenerate = |i: usize, rng: &mut Rng| {
        let [p, q] = [(); 2].map(|()| *rng.pick(&mesh.vertices));
        match i % 4 {
            0 => [p, p, p],
            1 => [p, q, p],
            2 => [p, q, q],
            // Halving, doubling and adding a power of two times a coordinate that it fits is exact: a
            // straight line.
            _ => [[0.0, 1.0, -1.0], [0.5, 1.25, -1.5], [1.0, 1.5, -2.0]],
        }
    };
    separate((0..n).map(|i| degenerate(i, rng)).collect::<Vec<_>>())
}

/// A mesh of triangles that share no vertex.
pub(crate) fn separate(triangles: impl IntoIterator<Item = [[f64; 3]; 3]>) -> MeshData {
    let vertices: Vec<[f64; 3]> = triangles.into_iter().flatten().collect();
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    MeshData { vertices, triangles }
}

/// Adds the triangles of `other` behind those of `mesh`.
pub(crate) fn append(mesh: &mut MeshData, other: &MeshData) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend_from_slice(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
}

/// Names every helper once, so that a test which needs only some of them compiles without a warning.
const _: () = {
    let _ = (torus, flat_grid, soup, coincident, collinear, huge_among_tiny, without_area, append);
};
