//! Packings against exact arithmetic: every sphere is inside and all are disjoint, on generated shapes and on
//! real meshes. Also errors, the same result on any number of threads, and text that reads back.
//!
//! The oracle shares neither code nor method with the library: it compares rational distances without division,
//! and casts rays in other directions, in integers of any length.

mod support;

use core::ops::ControlFlow;
use simdop::construct::{BuildError, Mesh};
use simdop::packing::text::{TextError, read, write};
use simdop::packing::{Filling, PackError, Packer, Packing};
use simdop::primitive::Sphere;
use support::data::{MeshData, directory, suite_step};
use support::digest::digest;
use support::dyadic::{Dyadic, dot, dot_rounded};
use support::rng::Rng;
use support::shapes::{self, cuboid};

type Vector = [Dyadic; 3];

fn pack(mesh: &MeshData, spheres: usize) -> Packing {
    try_pack(mesh, spheres).unwrap_or_else(|error| panic!("{error}"))
}

fn try_pack(mesh: &MeshData, spheres: usize) -> Result<Packing, PackError> {
    Packer::new().spheres(spheres).pack(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles })
}

// ---- The oracle -------------------------------------------------------------------------------------------

fn exact(p: [f64; 3]) -> Vector {
    p.map(Dyadic::from)
}

fn minus(u: &Vector, v: &Vector) -> Vector {
    core::array::from_fn(|i| u[i].clone() - v[i].clone())
}

fn cross(u: &Vector, v: &Vector) -> Vector {
    let minor = |i: usize, j: usize| u[i].clone() * v[j].clone() - u[j].clone() * v[i].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn square(u: &Vector) -> Dyadic {
    dot(u.clone(), u.clone())
}

fn sign(x: &Dyadic) -> i32 {
    x.cmp(&Dyadic::zero()) as i32
}

fn difference(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| p[i] - q[i])
}

/// Whether one direction shows, despite rounding, that the triangle is farther from the centre than the radius.
/// This decides most triangles.
fn is_plainly_clear(t: &[[f64; 3]; 3], sphere: &Sphere) -> bool {
    let w = t.map(|p| difference(p, sphere.centre));
    let (u, v) = (difference(w[1], w[0]), difference(w[2], w[0]));
    let minor = |i: usize, j: usize| u[i] * v[j] - u[j] * v[i];
    let middle = core::array::from_fn(|i| w[0][i] + w[1][i] + w[2][i]);
    let size = w.as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    [middle, [minor(1, 2), minor(2, 0), minor(0, 1)], w[0], w[1], w[2]].into_iter().any(|axis| {
        let length = dot_rounded(&axis, &axis).sqrt();
        let along = w.map(|p| dot_rounded(&axis, &p));
        let (low, high) = (
            along.iter().fold(f64::INFINITY, |m, x| m.min(*x)),
            along.iter().fold(-f64::INFINITY, |m, x| m.max(*x)),
        );
        low.max(-high) > length * (sphere.radius + 1e-12 * size)
    })
}

/// Whether no point of a triangle is nearer to the centre than the radius: no point of its face, if the centre
/// is above it, and none of its three edges.
fn is_clear(t: &[[f64; 3]; 3], sphere: &Sphere) -> bool {
    if is_plainly_clear(t, sphere) {
        return true;
    }
    let (p, corners) = (exact(sphere.centre), t.map(exact));
    let reach = Dyadic::from(sphere.radius) * Dyadic::from(sphere.radius);
    let edges: [Vector; 3] = core::array::from_fn(|i| minus(&corners[(i + 1) % 3], &corners[i]));
    let offsets = corners.each_ref().map(|corner| minus(&p, corner));
    let n = cross(&edges[0], &edges[1]);
    let above = (0..3).all(|i| sign(&dot(cross(&edges[i], &offsets[i]), n.clone())) >= 0);
    if above && sign(&square(&n)) > 0 {
        let height = dot(n.clone(), offsets[0].clone());
        if height.clone() * height < reach.clone() * square(&n) {
            return false;
        }
    }
    (0..3).all(|i| {
        let (along, length) = (dot(edges[i].clone(), offsets[i].clone()), square(&edges[i]));
        if sign(&along) <= 0 || along >= length {
            // The next edge begins at the other end.
            square(&offsets[i]) >= reach
        } else {
            square(&offsets[i]) * length.clone() - along.clone() * along >= reach.clone() * length
        }
    })
}

/// A mesh, sheared so that rays in a direction (x, y, 1) are parallel to the third axis: boxes in the plane of
/// the other axes.
struct Shadow {
    direction: [f64; 3],
    boxes: Vec<[[f64; 2]; 2]>,
    slack: f64,
}

impl Shadow {
    fn new(triangles: &[[[f64; 3]; 3]], direction: [f64; 3]) -> Self {
        let size = triangles.as_flattened().as_flattened().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let bounds = |t: &[[f64; 3]; 3]| {
            [0, 1].map(|i| {
                let x = t.map(|p| Self::sheared(&p, &direction)[i]);
                [x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2])]
            })
        };
        Self { direction, boxes: triangles.iter().map(bounds).collect(), slack: 1e-12 * size }
    }

    fn sheared(p: &[f64; 3], direction: &[f64; 3]) -> [f64; 2] {
        [p[0] - direction[0] * p[2], p[1] - direction[1] * p[2]]
    }

    /// Whether the ray crosses an odd number of triangles; `None` if it meets an edge.
    fn is_inside(&self, triangles: &[[[f64; 3]; 3]], centre: [f64; 3]) -> Option<bool> {
        let at = Self::sheared(&centre, &self.direction);
        let (p, d) = (exact(centre), exact(self.direction));
        let mut is_inside = false;
        for (t, bounds) in triangles.iter().zip(&self.boxes) {
            if (0..2).any(|i| at[i] < bounds[i][0] - self.slack || at[i] > bounds[i][1] + self.slack) {
                continue;
            }
            let w = t.map(|q| minus(&exact(q), &p));
            let sides = [0, 1, 2].map(|i| sign(&dot(cross(&w[i], &w[(i + 1) % 3]), d.clone())));
            if sides.contains(&1) && sides.contains(&-1) {
                continue;
            }
            if sides.contains(&0) {
                return None;
            }
            let ahead = sign(&dot(cross(&w[0], &w[1]), w[2].clone()));
            is_inside ^= ahead * sides[0] > 0;
        }
        Some(is_inside)
    }
}

/// Every sphere is inside the mesh, all are disjoint, and sizes and volumes are correct.
fn check(mesh: &MeshData, packing: &Packing) {
    let triangles = mesh.corners();
    let directions = [[5.0 / 64.0, 3.0 / 64.0, 1.0], [-0.1875, 0.3125, 1.0], [0.7109375, -0.5390625, 1.0]];
    let shadows = directions.map(|direction| Shadow::new(&triangles, direction));
    for (index, sphere) in packing.spheres.iter().enumerate() {
        assert!(sphere.radius > 0.0, "sphere {index}: {sphere:?}");
        let reach = sphere.radius * (1.0 + 1e-9);
        for (number, t) in triangles.iter().enumerate() {
            let is_far = (0..3).any(|i| {
                let x = t.map(|p| p[i] - sphere.centre[i]);
                x.iter().all(|x| *x > reach) || x.iter().all(|x| *x < -reach)
            });
            assert!(
                is_far || is_clear(t, sphere),
                "sphere {index}: {sphere:?} meets triangle {number}: {t:?}"
            );
        }
        let is_inside = shadows.iter().find_map(|shadow| shadow.is_inside(&triangles, sphere.centre));
        assert_eq!(is_inside, Some(true), "sphere {index}: {sphere:?}");
    }
    for (index, a) in packing.spheres.iter().enumerate() {
        for b in &packing.spheres[..index] {
            let (d, r) = (difference(a.centre, b.centre), a.radius + b.radius);
            if dot_rounded(&d, &d) * (1.0 - 1e-12) < r * r {
                let apart = square(&minus(&exact(a.centre), &exact(b.centre)));
                let sum = Dyadic::from(a.radius) + Dyadic::from(b.radius);
                assert!(apart >= sum.clone() * sum, "sphere {index}: {a:?} overlaps {b:?}");
            }
        }
    }
    let mut least = f64::INFINITY;
    for sphere in &packing.spheres {
        assert!(sphere.radius <= 1.5 * least, "{sphere:?} comes after one of radius {least}");
        least = least.min(sphere.radius);
    }
    let shares: Vec<f64> = packing.shares().collect();
    assert_eq!(shares.len(), packing.spheres.len());
    assert!(shares.is_sorted() && shares.last().is_none_or(|share| *share < 1.0), "{:?}", shares.last());
}

// ---- Generated shapes -------------------------------------------------------------------------------------

/// Rotated out of the axes. Sums of products of numbers with few bits are exact, so flat faces stay flat.
fn turned(mesh: &MeshData) -> MeshData {
    let rows = [[0.375, -0.75, 0.5], [0.75, 0.125, -0.5], [0.5, 0.5, 0.625]];
    let place = |p: &[f64; 3]| rows.map(|row| dot_rounded(&row, &p.map(|x| f64::from(x as f32))));
    MeshData { vertices: mesh.vertices.iter().map(place).collect(), triangles: mesh.triangles.clone() }
}

fn joined(parts: &[MeshData]) -> MeshData {
    let mut mesh = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    parts.iter().for_each(|part| shapes::append(&mut mesh, part));
    mesh
}

fn generated() -> Vec<(&'static str, MeshData)> {
    let cube = |x: f64| cuboid([x; 3], [x + 1.0; 3], false);
    let corner = |x: f64, y: f64| cuboid([x, y, 0.0], [x + 1.0, y + 1.0, 1.0], false);
    let torus = shapes::torus(24, 12);
    let mut with_flat = torus.clone();
    // A spike without area, an edge there and back, and a point.
    with_flat.triangles.extend([[0, 100, 0], [5, 5, 5]]);
    let wavy = shapes::wavy_torus(1200);
    vec![
        ("cube", cube(0.0)),
        ("torus", torus.clone()),
        ("wavy torus", wavy.clone()),
        ("two parts", joined(&[cube(0.0), cube(3.0)])),
        ("two parts that share an edge", joined(&[corner(0.0, 0.0), corner(1.0, 1.0)])),
        ("hollow", joined(&[cuboid([-2.0; 3], [2.0; 3], false), cuboid([-1.0, -1.5, -1.0], [1.0; 3], true)])),
        ("plate", cuboid([0.0; 3], [1.0, 1.0, 1e-3], false)),
        ("turned plate", turned(&cuboid([0.0; 3], [1.0, 1.0, 1e-3], false))),
        ("needle", cuboid([0.0; 3], [1.0, 1e-4, 1e-4], false)),
        ("with flat triangles", with_flat),
        ("far from the origin", shapes::scaled(&torus, 1.0, [1e6, -3e6, 2e5])),
        ("tiny", shapes::scaled(&wavy, 1e-70, [0.0; 3])),
        ("huge", shapes::scaled(&wavy, 1e80, [0.0; 3])),
    ]
}

#[test]
fn spheres_are_inside_and_disjoint() {
    let step = suite_step();
    for (name, mesh) in generated().into_iter().step_by(if step > 1 { 3 } else { 1 }) {
        let packing = pack(&mesh, 240 / step);
        assert_eq!(packing.spheres.len(), 240 / step, "{name}");
        check(&mesh, &packing);
    }
}

#[test]
fn volumes_are_those_of_the_shapes() {
    let volume = |name: &str| {
        let (_, mesh) = generated().into_iter().find(|(other, _)| *other == name).unwrap();
        pack(&mesh, 1).volume
    };
    let close = |x: f64, y: f64| (x / y - 1.0).abs() < 1e-9;
    assert!(close(volume("cube"), 1.0));
    assert!(close(volume("two parts"), 2.0));
    assert!(close(volume("hollow"), 64.0 - 2.0 * 2.5 * 2.0));
    assert!(close(volume("plate"), 1e-3));
    assert!(close(volume("tiny"), 1e-210 * volume("wavy torus")));
    assert!(close(volume("huge"), 1e240 * volume("wavy torus")));
}

/// The places of the largest spheres are known.
#[test]
fn the_largest_come_first() {
    let packing = pack(&cuboid([-1.0; 3], [1.0; 3], false), 9);
    let radii: Vec<f64> = packing.spheres.iter().map(|sphere| sphere.radius).collect();
    assert!((0.999..=1.0).contains(&radii[0]), "{radii:?}");
    // Between the first sphere and a corner: a ball that touches the first and three faces.
    let second = (3.0_f64.sqrt() - 1.0) / (3.0_f64.sqrt() + 1.0);
    assert!(radii[1..].iter().all(|r| (0.995 * second..=second * 1.002).contains(r)), "{radii:?}");
    // Two parts of different size: the smaller part gets no sphere while the larger part has room for a larger
    // one.
    let parts = joined(&[cuboid([0.0; 3], [1.0; 3], false), cuboid([2.0; 3], [2.2; 3], false)]);
    let packing = pack(&parts, 60);
    let first = packing.spheres.iter().position(|sphere| sphere.centre[0] > 1.5).unwrap();
    assert!(packing.spheres[..first].iter().all(|sphere| sphere.radius > 0.6 * 0.1), "{first}");
}

#[test]
fn a_mesh_turned_inside_out_packs_the_same() {
    let mesh = shapes::wavy_torus(800);
    let mut turned = mesh.clone();
    turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let (one, other) = (pack(&mesh, 60), pack(&turned, 60));
    assert!((one.volume / other.volume - 1.0).abs() < 1e-12);
    check(&turned, &other);
    let covered = |packing: &Packing| packing.shares().last().unwrap();
    assert!((covered(&one) - covered(&other)).abs() < 0.01);
}

/// The numbers fit single precision, for a mesh where that is precise enough. Scaling by a power of two changes
/// nothing.
#[test]
fn spheres_are_in_single_precision() {
    let mesh = shapes::wavy_torus(800);
    let packing = pack(&mesh, 100);
    for sphere in &packing.spheres {
        let numbers = sphere.centre.into_iter().chain([sphere.radius]);
        assert!(numbers.clone().all(|x| f64::from(x as f32) == x), "{sphere:?}");
    }
    let factor = 2.0_f64.powi(-37);
    let scaled = pack(&shapes::scaled(&mesh, factor, [0.0; 3]), 100);
    let shrunk = |sphere: &Sphere| Sphere {
        centre: sphere.centre.map(|x| x * factor),
        radius: sphere.radius * factor,
    };
    assert_eq!(packing.spheres.iter().map(shrunk).collect::<Vec<_>>(), scaled.spheres);
}

// ---- The same everywhere ----------------------------------------------------------------------------------

fn bytes(packing: &Packing) -> Vec<u8> {
    let numbers = packing.spheres.iter().flat_map(|s| s.centre.into_iter().chain([s.radius]));
    numbers.chain([packing.volume]).flat_map(f64::to_le_bytes).collect()
}

/// Recorded on x86-64. Every machine and every number of threads gives this digest.
#[test]
fn packings_are_the_same_on_every_machine() {
    assert_eq!(digest(&bytes(&pack(&shapes::wavy_torus(400), 100))), GOLDEN);
}

const GOLDEN: u64 = 15_516_579_247_828_177_103;

#[cfg(feature = "rayon")]
#[test]
fn packings_do_not_depend_on_the_number_of_threads() {
    let mesh = shapes::wavy_torus(2000);
    let spheres = 800 / suite_step();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bytes(&pack(&mesh, spheres)))
    };
    let want = with(1);
    for threads in [2, 3, 8] {
        assert!(with(threads) == want, "{threads} threads");
    }
}

// ---- Progress and errors ----------------------------------------------------------------------------------

#[test]
fn progress_is_told_and_packing_can_be_cancelled() {
    let mesh = shapes::torus(24, 12);
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    let mut told: Vec<Filling> = Vec::new();
    let mut observe = |filling: Filling| {
        told.push(filling);
        ControlFlow::Continue(())
    };
    let packer = Packer::new().spheres(100);
    let packing = packer.pack_with(&mesh, &mut observe).unwrap();
    assert!(told.len() > 5 && told.is_sorted_by(|a, b| a.placed < b.placed && a.share < b.share));
    let last = told.last().unwrap();
    assert_eq!((last.placed, last.asked), (100, 100));
    assert!((last.share - packing.shares().last().unwrap()).abs() < 1e-12);
    let mut calls = 0;
    let mut stop = |_: Filling| {
        calls += 1;
        if calls == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    assert_eq!(packer.pack_with(&mesh, &mut stop), Err(PackError::Cancelled));
    assert_eq!(calls, 3);
    assert_eq!(packing, packer.pack(&mesh).unwrap());
    assert_eq!(Packer::new().spheres(0).pack(&mesh).unwrap().spheres, []);
}

#[test]
fn an_open_mesh_names_an_edge() {
    let whole = shapes::torus(24, 12);
    let mut open = whole.clone();
    let gone = open.triangles.remove(100);
    let Err(PackError::Open { edge: [a, b], corners, forward, backward }) = try_pack(&open, 1) else {
        panic!("the mesh is open")
    };
    assert!(gone.contains(&a) && gone.contains(&b) && a != b, "{a} {b}, of {gone:?}");
    assert_eq!(corners, [a, b].map(|v| whole.vertices[v as usize]));
    assert_eq!(forward + backward, 1);
    let message = try_pack(&open, 1).unwrap_err().to_string();
    assert!(message.contains(&format!("vertices {a} and {b}")), "{message}");

    let mut turned = whole.clone();
    turned.triangles[100].swap(0, 1);
    let Err(PackError::Open { edge: [a, b], forward, backward, .. }) = try_pack(&turned, 1) else {
        panic!("a triangle is turned")
    };
    assert!(gone.contains(&a) && gone.contains(&b));
    assert_eq!([forward, backward].iter().max(), Some(&2));

    // Every triangle has corners of its own: equal corners are joined, also 0 and -0.
    let mut soup = shapes::separate(whole.corners());
    assert_eq!(pack(&soup, 20).spheres, pack(&whole, 20).spheres);
    soup.vertices.iter_mut().flatten().step_by(2).filter(|x| **x == 0.0).for_each(|x| *x = -*x);
    assert_eq!(pack(&soup, 20).spheres, pack(&whole, 20).spheres);
    soup.vertices[7][0] = soup.vertices[7][0].next_up();
    assert!(matches!(try_pack(&soup, 1), Err(PackError::Open { .. })));
}

#[test]
fn meshes_that_cannot_be_filled_are_errors() {
    let cube = || cuboid([0.0; 3], [1.0; 3], false);
    assert_eq!(try_pack(&MeshData { triangles: vec![], ..cube() }, 1), Err(PackError::Empty));
    for bad in [f64::NAN, f64::INFINITY, -1e91] {
        let mut mesh = cube();
        mesh.vertices[5][1] = bad;
        assert_eq!(try_pack(&mesh, 1), Err(PackError::Mesh(BuildError::Vertex { index: 5 })), "{bad}");
    }
    let mut mesh = cube();
    mesh.triangles[3][2] = 8;
    assert_eq!(try_pack(&mesh, 1), Err(PackError::Mesh(BuildError::Primitive { index: 3 })));
    let flat = MeshData { vertices: cube().vertices, triangles: vec![[1, 2, 4], [1, 4, 2]] };
    assert_eq!(try_pack(&flat, 1), Err(PackError::Flat));
    assert_eq!(try_pack(&cuboid([0.0; 3], [1.0, 1.0, 0.0], false), 1), Err(PackError::Flat));
    for error in
        [PackError::Empty, PackError::Flat, PackError::Cancelled, PackError::Mesh(BuildError::TooDeep)]
    {
        assert!(!error.to_string().is_empty());
    }
}

// ---- Real meshes ------------------------------------------------------------------------------------------

/// Reads the vertices and triangles of a binary little-endian PLY whose vertices are three floats, such as the
/// brain.
fn ply(path: &std::path::Path) -> MeshData {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let count = |element: &str| -> usize {
        let line = head.lines().find(|line| line.starts_with(&format!("element {element} "))).unwrap();
        line.rsplit(' ').next().unwrap().parse().unwrap()
    };
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().unwrap() };
    let vertex =
        |i: usize| core::array::from_fn(|k| f64::from(f32::from_le_bytes(word(end + 12 * i + 4 * k))));
    let faces = end + 12 * count("vertex");
    let face = |i: usize| core::array::from_fn(|k| u32::from_le_bytes(word(faces + 13 * i + 1 + 4 * k)));
    MeshData {
        vertices: (0..count("vertex")).map(vertex).collect(),
        triangles: (0..count("face")).map(face).collect(),
    }
}

/// The part of the volume that the first spheres cover, in per cent, from the sum of their volumes.
fn covered(packing: &Packing, count: usize) -> f64 {
    let volume = |s: &Sphere| 4.0 / 3.0 * core::f64::consts::PI * s.radius.powi(3);
    100.0 * packing.spheres[..count].iter().map(volume).sum::<f64>() / packing.volume
}

#[test]
fn cow_is_filled() {
    let Some(data) = directory() else { return };
    let mesh = MeshData::obj(&data.join("meshes/cow.obj"));
    let count = if suite_step() > 1 { 100 } else { 10_000 };
    let packing = pack(&mesh, count);
    check(&mesh, &packing);
    for (spheres, least) in [(100, 68.0), (2_000, 82.0), (10_000, 86.5)] {
        if spheres <= count {
            let share = covered(&packing, spheres);
            assert!(share >= least, "{spheres} spheres cover {share} %");
            assert!((share - 100.0 * packing.shares().nth(spheres - 1).unwrap()).abs() < 1e-9);
        }
    }
}

#[test]
fn the_hand_is_filled() {
    filled("hand.obj", 60.0);
}

#[test]
fn the_armadillo_is_filled() {
    filled("armadillo.obj", 60.0);
}

#[test]
fn the_brain_is_filled() {
    filled("brain_pia_lh.ply", 40.0);
}

/// 2,000 spheres fill at least this share of the mesh, in percent.
fn filled(name: &str, least: f64) {
    let Some(data) = directory() else { return };
    let is_small = suite_step() > 1;
    if is_small && name != "hand.obj" {
        return;
    }
    let path = data.join("meshes").join(name);
    let mesh = if name.ends_with(".ply") { ply(&path) } else { MeshData::obj(&path) };
    let count = if is_small { 50 } else { 2_000 };
    let packing = pack(&mesh, count);
    check(&mesh, &packing);
    let share = covered(&packing, count);
    assert!(is_small || share >= least, "{name}: {share} %");
}

// ---- Text -------------------------------------------------------------------------------------------------

#[test]
fn text_reads_back_bit_equal() {
    let mut rng = Rng::new(4);
    let mut spheres = pack(&shapes::torus(24, 12), 50).spheres;
    let odd = [0.0, -0.0, 5e-324, f64::MIN_POSITIVE, 1e-300, 0.1, 1.0 / 3.0, 1e16, 2.0_f64.powi(300), -1e90];
    spheres.extend(odd.map(|x| Sphere { centre: [x, -x, 1.0], radius: x.abs() }));
    for _ in 0..2000 / suite_step() {
        let mut number = || loop {
            let x = f64::from_bits(rng.u64());
            if x.abs() <= 2.0_f64.powi(300) {
                break x;
            }
        };
        spheres.push(Sphere { centre: [number(), number(), number()], radius: number().abs() });
    }
    let mut text = String::new();
    write(&spheres, &mut text).unwrap();
    let bits = |spheres: &[Sphere]| -> Vec<[u64; 4]> {
        let of = |s: &Sphere| [s.centre[0], s.centre[1], s.centre[2], s.radius].map(f64::to_bits);
        spheres.iter().map(of).collect()
    };
    assert_eq!(bits(&read(&text).unwrap()), bits(&spheres));
    assert_eq!(text.lines().count(), spheres.len());
}

#[test]
fn text_may_have_comments_and_blank_lines() {
    let want = [Sphere { centre: [1.0, -2.0, 0.5], radius: 0.25 }, Sphere { centre: [0.0; 3], radius: 0.0 }];
    for text in [
        "1 -2 .5 .25\n0 0 0 0\n",
        "# a packing\r\n\r\n\t1  -2.0 5e-1\t0.25 # the first\r\n  0 0 0 0\r\n#\r\n",
        "1 -2 0.5 25e-2\r0 0 0 0\r\r",
    ] {
        assert_eq!(read(text).unwrap(), want, "{text:?}");
    }
}

#[test]
fn faults_of_a_text_have_their_line() {
    for (text, want) in [
        ("", TextError::Empty),
        ("\n# nothing\n", TextError::Empty),
        ("1 2 3 4\n1 2 x 4\n", TextError::Word { line: 2, word: 2 }),
        ("1,2,3,4\n", TextError::Word { line: 1, word: 0 }),
        ("\n\n1 2 3\n", TextError::Count { line: 3, count: 3 }),
        ("1 2 3 4 5\n", TextError::Count { line: 1, count: 5 }),
        ("1 2 3 4\r\n1 NaN 3 4\r\n", TextError::Range { line: 2, word: 1 }),
        ("1 2 3 inf\n", TextError::Range { line: 1, word: 3 }),
        ("1e91 2 3 4\n", TextError::Range { line: 1, word: 0 }),
        ("1 2 3 -4\n", TextError::Negative { line: 1 }),
        ("1 2 3 4\n1 2 3 4", TextError::Cut { line: 2 }),
        ("1 2 3 4\n# cut", TextError::Cut { line: 2 }),
    ] {
        assert_eq!(read(text), Err(want), "{text:?}");
        let message = want.to_string();
        assert!(want.line().is_none_or(|line| message.starts_with(&format!("line {line}: "))), "{message}");
    }
}
