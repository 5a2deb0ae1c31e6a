//! Selects the vector kernels that the target can run ([`conditions`]), and generates `$OUT_DIR/directions.rs`: for
//! each k the directions, the triangles of their convex hull with inverse matrices, and a grid of start faces for point
//! location. `src/directions.rs` includes that file and documents the direction sets and how they were chosen. Every
//! property that module relies on is asserted here.

type Vector = [i32; 3];
type Ray = [f64; 3];

/// Cells along one side of the octahedral grid. `src/directions.rs` masks with it, so it is a power of two.
const GRID_SIDE: usize = 16;
/// Largest number of steps from a cell's start face to the face of any ray in the cell. The library allows more.
const WALK: usize = 3;
/// Samples along one side of a cell that vote for its start face.
const VOTES: usize = 8;

struct Face {
    directions: [usize; 3],
    /// Row l times u is the weight of `directions[l]`.
    inverse: [Ray; 3],
    neighbours: [usize; 3],
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    conditions();
    let mut source = format!("pub(super) const GRID_SIDE: usize = {GRID_SIDE};\n");
    for k in [6, 14, 18, 26, 32] {
        let vectors = directions(k);
        let faces = triangulate(&vectors);
        let grid = start_faces(&faces);
        check_vectors(k, &vectors);
        check_faces(&vectors, &faces);
        check_cover(&faces);
        check_grid(&faces, &grid);
        emit(&mut source, &vectors, &faces, &grid);
    }
    let folder = std::env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    std::fs::write(format!("{folder}/directions.rs"), source).expect("OUT_DIR is writable");
}

/// Sets `simdop_x86` or `simdop_neon` if the target can pass and keep vector registers, so that kernels and tokens for
/// them exist. A soft-float ABI, such as that of `x86_64-unknown-none`, cannot. Sets `simdop_small` if there is little
/// room for code, above all where `f64` is emulated: functions that are inlined elsewhere are then called, except in
/// inner loops.
fn conditions() {
    let condition = |name: &str| std::env::var(name).unwrap_or_default();
    let (arch, features) = (condition("CARGO_CFG_TARGET_ARCH"), condition("CARGO_CFG_TARGET_FEATURE"));
    println!("cargo::rustc-check-cfg=cfg(simdop_x86, simdop_neon, simdop_small)");
    for (name, its_arch, feature) in [("simdop_x86", "x86_64", "sse2"), ("simdop_neon", "aarch64", "neon")] {
        if arch == its_arch && features.split(',').any(|f| f == feature) {
            println!("cargo::rustc-cfg={name}");
        }
    }
    if arch == "arm" {
        println!("cargo::rustc-cfg=simdop_small");
    }
}

/// One direction per slab, then its antipode: n_{2i+1} = -n_{2i}.
fn directions(k: usize) -> Vec<Vector> {
    let axes = rotations([1, 0, 0]);
    let corners = vec![[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]];
    let edges = [rotations([1, 1, 0]), rotations([1, -1, 0])].concat();
    let slabs = match k {
        6 => axes,
        14 => [axes, corners].concat(),
        18 => [axes, edges].concat(),
        26 => [axes, edges, corners].concat(),
        32 => {
            let twos = [rotations([2, -1, -1]), vec![[1, 1, 1]], rotations([1, 1, 0])].concat();
            let threes = [rotations([3, -2, 1]), rotations([3, 1, -2])].concat();
            [axes, twos, threes].concat()
        }
        _ => panic!("no direction set for k = {k}"),
    };
    slabs.iter().flat_map(|&n| [n, n.map(|x| -x)]).collect()
}

/// The three cyclic shifts of `n`.
fn rotations(n: Vector) -> Vec<Vector> {
    vec![n, [n[2], n[0], n[1]], [n[1], n[2], n[0]]]
}

/// The faces of the convex hull of the NORMALISED directions, antipodal faces at 2i and 2i+1.
///
/// Averaged over random orientations of a body, the offset of a plane is proportional to the length of its direction.
/// The mean width after realignment is therefore proportional to the sum of weight times length, which the triangles of
/// this hull minimise.
fn triangulate(vectors: &[Vector]) -> Vec<Face> {
    let k = vectors.len();
    let mut triples: Vec<[usize; 3]> = Vec::new();
    for a in 0..k {
        for b in a + 1..k {
            for c in b + 1..k {
                let antipode = [a ^ 1, b ^ 1, c ^ 1];
                if is_hull_face(vectors, [a, b, c]) && !triples.contains(&antipode) {
                    triples.extend([[a, b, c], antipode]);
                }
            }
        }
    }
    let face = |(index, &directions)| Face {
        directions,
        inverse: inverse(directions.map(|j| vectors[j])),
        neighbours: core::array::from_fn(|l| neighbour(&triples, index, l)),
    };
    triples.iter().enumerate().map(face).collect()
}

/// Whether the end of every other direction lies below the plane through these three. A fourth point on the plane would
/// make the triangulation ambiguous, so it is rejected.
fn is_hull_face(vectors: &[Vector], triple: [usize; 3]) -> bool {
    let [a, b, c] = triple.map(|j| normalised(vectors[j]));
    let normal = cross(sub(b, a), sub(c, a));
    let height = dot(normal, a);
    if height.abs() < 1e-9 {
        return false;
    }
    let slack = |j: usize| 1.0 - dot(normal, normalised(vectors[j])) / height;
    let least = (0..vectors.len()).filter(|j| !triple.contains(j)).map(slack).fold(f64::INFINITY, f64::min);
    assert!(least.abs() > 1e-6, "a hull face of k = {} has four corners: {triple:?}", vectors.len());
    least > 0.0
}

/// Inverse of the matrix with these columns: integer cofactors divided by an integer determinant, rounded once. Adding
/// 0 turns -0 into 0.
fn inverse(columns: [Vector; 3]) -> [Ray; 3] {
    let [a, b, c] = columns.map(|n| n.map(f64::from));
    let determinant = dot(a, cross(b, c));
    assert!(determinant.abs() > 0.5, "directions {columns:?} are linearly dependent");
    [cross(b, c), cross(c, a), cross(a, b)].map(|row| row.map(|x| x / determinant + 0.0))
}

/// The face that shares the edge opposite corner `l` of face `index`.
fn neighbour(triples: &[[usize; 3]], index: usize, l: usize) -> usize {
    let (p, q) = (triples[index][(l + 1) % 3], triples[index][(l + 2) % 3]);
    let shares = |&f: &usize| f != index && triples[f].contains(&p) && triples[f].contains(&q);
    let found: Vec<usize> = (0..triples.len()).filter(shares).collect();
    assert_eq!(found.len(), 1, "edge {p}-{q} must be shared by exactly two faces");
    found[0]
}

/// Start face of each grid cell: the one that holds most of the cell's samples.
fn start_faces(faces: &[Face]) -> Vec<usize> {
    let vote = |cell: usize| {
        let mut votes = vec![0; faces.len()];
        samples(cell).into_iter().for_each(|u| votes[containing(faces, u)] += 1);
        (0..faces.len()).max_by_key(|&f| (votes[f], faces.len() - f)).expect("there are faces")
    };
    (0..GRID_SIDE * GRID_SIDE).map(vote).collect()
}

/// Rays that `Table::start` maps to this cell. The octahedral map of the upper half sphere, rotated by 45 degrees to
/// fill the square: (x + y, x - y) / (|x| + |y| + |z|), scaled to 0..=GRID_SIDE-1, is rounded to (row, column).
fn samples(cell: usize) -> Vec<Ray> {
    let coordinate = |index: usize, sample: usize| {
        let offset = (sample as f64 + 0.5) / VOTES as f64 - 0.5;
        2.0 * (index as f64 + offset) / (GRID_SIDE - 1) as f64 - 1.0
    };
    let mut rays = Vec::new();
    for sample in 0..VOTES * VOTES {
        let sum = coordinate(cell / GRID_SIDE, sample / VOTES);
        let difference = coordinate(cell % GRID_SIDE, sample % VOTES);
        let height = 1.0 - sum.abs().max(difference.abs());
        if height >= 0.0 {
            rays.push([(sum + difference) / 2.0, (sum - difference) / 2.0, height]);
        }
    }
    rays
}

fn containing(faces: &[Face], u: Ray) -> usize {
    let least = |f: usize| least_weight(&faces[f], u);
    (0..faces.len()).max_by(|&f, &g| least(f).total_cmp(&least(g))).expect("there are faces")
}

fn least_weight(face: &Face, u: Ray) -> f64 {
    face.inverse.map(|row| dot(row, u)).into_iter().fold(f64::INFINITY, f64::min)
}

fn check_vectors(k: usize, vectors: &[Vector]) {
    assert_eq!(vectors.len(), k);
    for (j, n) in vectors.iter().enumerate() {
        assert_eq!(vectors[j ^ 1], n.map(|x| -x), "direction {j} of k = {k} has no antipode");
        assert!(
            n.iter().all(|x| x.abs() <= 4),
            "components stay small, so that a body fills most of the range of keys"
        );
        let parallel = |m: &Vector| cross(n.map(f64::from), m.map(f64::from)) == [0.0; 3];
        assert_eq!(
            vectors.iter().filter(|m| parallel(m)).count(),
            2,
            "slab {} of k = {k} is there twice",
            j / 2
        );
    }
}

fn check_faces(vectors: &[Vector], faces: &[Face]) {
    let k = vectors.len();
    // Euler: V - E + F = 2 with E = 3 F / 2, when every direction is a vertex.
    assert_eq!(k + faces.len(), 3 * faces.len() / 2 + 2, "k = {k}: the hull is not one closed surface");
    for j in 0..k {
        assert!(faces.iter().any(|f| f.directions.contains(&j)), "k = {k}: direction {j} is on no face");
    }
    for (index, face) in faces.iter().enumerate() {
        let [a, b, c] = face.directions.map(|j| normalised(vectors[j]));
        assert!(dot(a, cross(b, c)).abs() > 0.05, "k = {k}: face {index} is nearly flat");
        assert_eq!(
            faces[index ^ 1].directions,
            face.directions.map(|j| j ^ 1),
            "k = {k}: face {index} has no antipode"
        );
        for l in 0..3 {
            let ray = vectors[face.directions[l]].map(f64::from);
            for (m, row) in face.inverse.iter().enumerate() {
                let expected = if l == m { 1.0 } else { 0.0 };
                assert!((dot(*row, ray) - expected).abs() <= 1e-12, "k = {k}: face {index}: wrong inverse");
            }
            let other = &faces[face.neighbours[l]];
            assert!(other.neighbours.contains(&index), "k = {k}: neighbours of face {index} are not mutual");
            assert!(
                !other.directions.contains(&face.directions[l]),
                "k = {k}: face {index}: wrong neighbour"
            );
        }
    }
}

/// Checks evenly spread rays (a Fibonacci spiral): each lies in a face, and in only one unless it is on an edge.
fn check_cover(faces: &[Face]) {
    const RAYS: i32 = 5000;
    for i in 0..RAYS {
        let z = (2.0 * f64::from(i) + 1.0) / f64::from(RAYS) - 1.0;
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let u = [cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z];
        let inside = faces.iter().filter(|f| least_weight(f, u) > 1e-9).count();
        let touching = faces.iter().filter(|f| least_weight(f, u) > -1e-9).count();
        assert!(inside == 1 || (inside == 0 && touching >= 2), "{u:?} lies in {inside} faces");
    }
}

/// Checks that a walk across the most negative weight, from the start face of its cell, finds every ray's face within
/// `WALK` steps.
fn check_grid(faces: &[Face], grid: &[usize]) {
    for (cell, &start) in grid.iter().enumerate() {
        for u in samples(cell) {
            let mut face = &faces[start];
            for _ in 0..WALK {
                let weights = face.inverse.map(|row| dot(row, u));
                let least = (0..3).min_by(|&l, &m| weights[l].total_cmp(&weights[m])).expect("three");
                if weights[least] < 0.0 {
                    face = &faces[face.neighbours[least]];
                }
            }
            assert!(least_weight(face, u) > -1e-9, "grid cell {cell} starts too far from {u:?}");
        }
    }
}

fn emit(source: &mut String, vectors: &[Vector], faces: &[Face], grid: &[usize]) {
    let k = vectors.len();
    let lengths = vectors.iter().map(|&n| format!("f64::from_bits({:#x})", length_above(n).to_bits()));
    let face = |f: &Face| {
        let Face { directions, inverse, neighbours } = f;
        format!("Face {{ directions: {directions:?}, inverse: {inverse:?}, neighbours: {neighbours:?} }}")
    };
    emit_array(source, &format!("VECTORS_{k}"), "[i8; 3]", vectors.iter().map(|n| format!("{n:?}")));
    emit_array(source, &format!("LENGTHS_{k}"), "f64", lengths);
    emit_array(source, &format!("FACES_{k}"), "Face", faces.iter().map(face));
    emit_array(source, &format!("GRID_{k}"), "u8", grid.iter().map(usize::to_string));
    let fields = format!("vectors: &VECTORS_{k}, lengths: &LENGTHS_{k}, faces: &FACES_{k}, grid: &GRID_{k}");
    source.push_str(&format!("pub(super) const TABLE_{k}: Table = Table {{ {fields} }};\n"));
}

fn emit_array(source: &mut String, name: &str, element: &str, items: impl Iterator<Item = String>) {
    let items: Vec<String> = items.collect();
    source.push_str(&format!("static {name}: [{element}; {}] = [{}];\n", items.len(), items.join(", ")));
}

/// The Euclidean length, rounded up.
fn length_above(n: Vector) -> f64 {
    let square = f64::from(n.iter().map(|x| x * x).sum::<i32>());
    let root = square.sqrt();
    if root == root.round() { root } else { root.next_up() }
}

fn normalised(n: Vector) -> Ray {
    let ray = n.map(f64::from);
    ray.map(|x| x / dot(ray, ray).sqrt())
}

fn sub(a: Ray, b: Ray) -> Ray {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Ray, b: Ray) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Ray, b: Ray) -> Ray {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
