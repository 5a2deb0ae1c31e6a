//! Generated meshes. They use correctly rounded operations only (no sines of a library), so that every machine
//! generates the same ones.

use super::data::MeshData;
use super::rng::Rng;

/// Point `i` of `n` on the unit circle: evenly spaced along a square, then normalised.
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

/// Cosine and sine of `i / n` of a full angle, by their series on an eighth of it: within 2^-52, and the same
/// on every machine.
fn at_angle(i: u32, n: u32) -> [f64; 2] {
    let eighths = 8.0 * f64::from(i % n) / f64::from(n);
    let (whole, part) = (eighths.floor(), eighths - eighths.floor());
    // Odd eighths run backwards, so that each quarter is symmetric.
    let odd = whole % 2.0 != 0.0;
    let x = if odd { 1.0 - part } else { part } * core::f64::consts::FRAC_PI_4;
    // From x^19 on, the terms of the series do not change any bit.
    let series = |first: f64, from: i32| {
        let (mut term, mut sum) = (first, first);
        for k in (from..from + 16).step_by(2) {
            term *= -(x * x) / f64::from(k * (k + 1));
            sum += term;
        }
        sum
    };
    let (c, s) = (series(1.0, 1), series(x, 2));
    match whole as u32 {
        0 => [c, s],
        1 => [s, c],
        2 => [-s, c],
        3 => [-c, s],
        4 => [-c, -s],
        5 => [-s, -c],
        6 => [s, -c],
        _ => [c, -s],
    }
}

/// The triangles of a grid of `rows` x `columns` vertices, row by row. In a closed direction the last line is
/// joined to the first.
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

/// A torus of radius 1 with a tube of radius 0.4 about the z axis: 2 `around` `along` triangles, watertight.
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

/// A torus with waves along and around its tube, smooth and watertight, nearly 6 across. It has 2 n^2 triangles
/// with the greatest n for which that is at most `triangles`, and at least 3.
pub(crate) fn wavy_torus(triangles: u32) -> MeshData {
    let n = (f64::from(triangles) / 2.0).sqrt().floor().max(3.0) as u32;
    let mut vertices = Vec::new();
    for i in 0..n {
        let ([x, y], [wave, _]) = (at_angle(i, n), at_angle(5 * i, n));
        for j in 0..n {
            let ([out, up], [_, bulge]) = (at_angle(j, n), at_angle(3 * j, n));
            let radius = 2.0 + (0.7 + 0.2 * wave) * out;
            vertices.push([radius * x, radius * y, 0.7 * up + 0.3 * bulge]);
        }
    }
    MeshData { vertices, triangles: quads(n, n, true) }
}

/// A box in a room: half widths, rotated about the z axis, around a centre.
struct Block {
    half: [f64; 3],
    turn: [f64; 2],
    centre: [f64; 3],
}

/// The furniture of a room of 10 x 8 x 3 m, and the room itself.
fn furniture() -> Vec<Block> {
    const STRAIGHT: [f64; 2] = [1.0, 0.0];
    let block = |half, turn, centre| Block { half, turn, centre };
    let mut blocks = vec![block([5.0, 4.0, 1.5], STRAIGHT, [0.0, 0.0, 1.5])];
    let turns = [STRAIGHT, [0.8, 0.6], [0.28, 0.96], [-0.6, 0.8]];
    // A table with four legs, and a stool in front of it.
    for (i, turn) in turns.into_iter().enumerate() {
        let centre = [-3.0 + 2.0 * i as f64, 1.5 - f64::from(i as u32 % 2) * 2.5];
        let at = |x: f64, y: f64, z: f64| {
            [centre[0] + (turn[0] * x - turn[1] * y), centre[1] + (turn[1] * x + turn[0] * y), z]
        };
        blocks.push(block([0.7, 0.4, 0.02], turn, at(0.0, 0.0, 0.74)));
        for (x, y) in [(-0.66, -0.36), (-0.66, 0.36), (0.66, -0.36), (0.66, 0.36)] {
            blocks.push(block([0.025, 0.025, 0.36], turn, at(x, y, 0.36)));
        }
        blocks.push(block([0.2, 0.2, 0.22], turn, at(0.1, -0.7, 0.22)));
    }
    // Shelves along a wall, each with two sides and five boards.
    for x in [-3.0, -1.0, 1.0, 3.0] {
        blocks.extend([-0.5, 0.5].map(|side| block([0.01, 0.15, 1.0], STRAIGHT, [x + side, 3.8, 1.0])));
        blocks.extend([0.1, 0.5, 0.9, 1.3, 1.7].map(|z| block([0.48, 0.14, 0.01], STRAIGHT, [x, 3.8, z])));
    }
    blocks
}

/// A room with walls, floor, ceiling and furniture, in metres, in cells of similar size: at most `triangles`
/// triangles and nearly as many, but at least 12 for each box. Faces share no vertices.
pub(crate) fn room(triangles: u32) -> MeshData {
    let blocks = furniture();
    let cells = |length: f64, cell: f64| (2.0 * length / cell).ceil().max(1.0);
    let count = |cell: f64| -> f64 {
        let faces = |half: &[f64; 3]| {
            let [x, y, z] = half.map(|length| cells(length, cell));
            4.0 * (x * y + y * z + z * x)
        };
        blocks.iter().map(|block| faces(&block.half)).sum()
    };
    let (mut fine, mut coarse) = (1e-4, 20.0);
    for _ in 0..60 {
        let middle = 0.5 * (fine + coarse);
        if count(middle) > f64::from(triangles) { fine = middle } else { coarse = middle }
    }
    let mut room = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    for Block { half, turn, centre } in &blocks {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let (along, across) = ((axis + 1) % 3, (axis + 2) % 3);
            let [rows, columns] = [along, across].map(|axis| cells(half[axis], coarse) as u32 + 1);
            let step = |i: u32, of: u32| 2.0 * f64::from(i) / f64::from(of - 1) - 1.0;
            let vertex = |i: u32, j: u32| {
                let mut p = [0.0; 3];
                p[axis] = side * half[axis];
                p[along] = step(i, rows) * half[along];
                p[across] = step(j, columns) * half[across];
                let [x, y] = [turn[0] * p[0] - turn[1] * p[1], turn[1] * p[0] + turn[0] * p[1]];
                [centre[0] + x, centre[1] + y, centre[2] + p[2]]
            };
            let vertices = (0..rows).flat_map(|i| (0..columns).map(move |j| vertex(i, j))).collect();
            append(&mut room, &MeshData { vertices, triangles: quads(rows, columns, false) });
        }
    }
    room
}

/// The mesh, scaled by `factor` and then shifted.
pub(crate) fn scaled(mesh: &MeshData, factor: f64, shift: [f64; 3]) -> MeshData {
    let place = |p: &[f64; 3]| core::array::from_fn(|i| p[i] * factor + shift[i]);
    MeshData { vertices: mesh.vertices.iter().map(place).collect(), triangles: mesh.triangles.clone() }
}

/// A box from `low` to `high`, or the same with its faces turned inward.
pub(crate) fn cuboid(low: [f64; 3], high: [f64; 3], inside_out: bool) -> MeshData {
    let vertices =
        (0..8).map(|i| core::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] }));
    let triangles = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let turn = |[a, b, c]: [u32; 3]| if inside_out { [a, c, b] } else { [a, b, c] };
    MeshData { vertices: vertices.collect(), triangles: triangles.map(turn).to_vec() }
}

/// A flat square of `side` x `side` vertices at integer coordinates, tilted by adding x to z.
pub(crate) fn flat_grid(side: u32) -> MeshData {
    let place = |i: u32| [f64::from(i % side), f64::from(i / side), f64::from(i % side)];
    MeshData { vertices: (0..side * side).map(place).collect(), triangles: quads(side, side, false) }
}

/// `n` separate triangles of about `size`, with centres in the cube of half width 1.
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

/// One triangle of size 1000 among `n` triangles of size 0.001.
pub(crate) fn huge_among_tiny(rng: &mut Rng, n: usize) -> MeshData {
    let mut mesh = soup(rng, n, 1e-3);
    let huge = separate([[[-1e3, -1e3, 0.5], [1e3, -1e3, 0.25], [0.0, 1e3, -0.5]]]);
    append(&mut mesh, &huge);
    mesh
}

/// `n` triangles without area on the vertices of `mesh`: points, segments and repeated corners.
pub(crate) fn without_area(mesh: &MeshData, rng: &mut Rng, n: usize) -> MeshData {
    let degenerate = |i: usize, rng: &mut Rng| {
        let [p, q] = [(); 2].map(|()| *rng.pick(&mesh.vertices));
        match i % 4 {
            0 => [p, p, p],
            1 => [p, q, p],
            2 => [p, q, q],
            // Three distinct collinear points, exact in floating point.
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

/// Appends the triangles of `other` to `mesh`.
pub(crate) fn append(mesh: &mut MeshData, other: &MeshData) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend_from_slice(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
}

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (torus, flat_grid, soup, coincident, collinear, huge_among_tiny, without_area, append);
    let _ = (wavy_torus, room, scaled, cuboid);
};
