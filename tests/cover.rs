//! Covers of meshes by spheres: what they contain, and how far they reach, by brute force.

#[path = "support/data.rs"]
mod data;
#[path = "support/rng.rs"]
mod rng;
#[path = "support/shapes.rs"]
mod shapes;

use data::{MeshData, by_suite, directory, suite_step};
use glam::DVec3;
use rng::Rng;
use simdop::construct::{BuildError, CoverError, Mesh};
use simdop::primitive::Sphere;

type Triangle = [DVec3; 3];

fn triangles(mesh: &MeshData) -> Vec<Triangle> {
    let corner = |vertex: u32| DVec3::from_array(mesh.vertices[vertex as usize]);
    mesh.triangles.iter().map(|t| t.map(corner)).collect()
}

fn cover(mesh: &MeshData, error: f64) -> Vec<Sphere> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }.cover(error).unwrap()
}

/// Whether the spheres contain every point of a triangle: one sphere contains all corners, or the spheres
/// contain the four quarters of the triangle. At the greatest depth, where spheres meet, it suffices that they
/// contain the corners. Coordinates have so few digits that halving is exact; the rounding of the squares is
/// less than the tolerance.
fn is_held(t: &Triangle, spheres: &[Sphere], depth: u32) -> bool {
    let near: Vec<Sphere> = spheres
        .iter()
        .copied()
        .filter(|sphere| {
            let (centre, reach) =
                (DVec3::from_array(sphere.centre), t[0].distance(t[1]).max(t[0].distance(t[2])));
            t[0].distance(centre) <= sphere.radius + 2.0 * reach
        })
        .collect();
    let is_in = |p: &DVec3, sphere: &Sphere| {
        p.distance_squared(DVec3::from_array(sphere.centre)) <= sphere.radius * sphere.radius * (1.0 - 1e-15)
    };
    if near.iter().any(|sphere| t.iter().all(|p| is_in(p, sphere))) {
        return true;
    }
    if depth == 0 {
        return t.iter().all(|p| near.iter().any(|sphere| is_in(p, sphere)));
    }
    let [p, q, r] = *t;
    let [a, b, c] = [0.5 * (p + q), 0.5 * (q + r), 0.5 * (r + p)];
    [[p, a, c], [a, q, b], [c, b, r], [a, b, c]].iter().all(|t| is_held(t, &near, depth - 1))
}

/// The distance of a point from a triangle.
fn distance(x: DVec3, [p, q, r]: &Triangle) -> f64 {
    let of_edge = |p: DVec3, q: DVec3| {
        let (u, length) = (q - p, (q - p).length_squared());
        let along = if length > 0.0 { ((x - p).dot(u) / length).clamp(0.0, 1.0) } else { 0.0 };
        x.distance(p + along * u)
    };
    let edges = of_edge(*p, *q).min(of_edge(*q, *r)).min(of_edge(*r, *p));
    let normal = (*q - *p).cross(*r - *p);
    let inside = |p: DVec3, q: DVec3| (q - p).cross(x - p).dot(normal) >= 0.0;
    if normal.length_squared() > 0.0 && inside(*p, *q) && inside(*q, *r) && inside(*r, *p) {
        return edges.min((x - *p).dot(normal).abs() / normal.length());
    }
    edges
}

fn check(mesh: &MeshData, error: f64, what: &str) -> usize {
    let (all, spheres) = (triangles(mesh), cover(mesh, error));
    for (i, t) in all.iter().enumerate() {
        assert!(is_held(t, &spheres, 5), "{what}: triangle {i} is not held");
    }
    let mut rng = Rng::new(211);
    for sphere in &spheres {
        let direction = DVec3::from_array(core::array::from_fn(|_| rng.range(-1.0, 1.0))).normalize_or_zero();
        for reach in [0.0, sphere.radius] {
            let x = DVec3::from_array(sphere.centre) + reach * direction;
            let off = all.iter().map(|t| distance(x, t)).fold(f64::INFINITY, f64::min);
            assert!(off <= error * (1.0 + 1e-12), "{what}: {x} is {off} off");
        }
    }
    spheres.len()
}

#[test]
fn spheres_hold_the_mesh_and_stay_near_it() {
    let mut rng = Rng::new(210);
    // Coordinates with few digits.
    let round = |mut mesh: MeshData| {
        for x in mesh.vertices.iter_mut().flatten() {
            *x = (*x * 65536.0).round() / 65536.0;
        }
        mesh
    };
    for (name, mesh) in [
        ("cuboid", shapes::cuboid([-1.0, -0.5, 0.0], [2.0, 0.5, 0.25], false)),
        ("torus", shapes::torus(24, 16)),
        ("soup", shapes::soup(&mut rng, 40, 1.0)),
        ("a point", MeshData { vertices: vec![[1.0, 2.0, 3.0]], triangles: vec![[0; 3]] }),
        ("a segment", MeshData { vertices: vec![[1.0; 3], [-1.0; 3]], triangles: vec![[0, 1, 1]] }),
    ]
    .into_iter()
    .step_by(suite_step().min(2))
    {
        let mesh = round(mesh);
        let errors: &[f64] = by_suite(&[0.5, 0.1, 0.03], &[0.5, 0.2]);
        let counts: Vec<_> = errors.iter().map(|&error| check(&mesh, error, name)).collect();
        assert!(counts.is_sorted(), "{name}: {counts:?}");
        assert_eq!(cover(&mesh, 10.0).len(), 1, "{name}: one sphere is enough");
    }
    assert!(cover(&MeshData { vertices: vec![], triangles: vec![] }, 1.0).is_empty());
}

/// In any unit, and far from the origin.
#[test]
fn covers_have_no_scale() {
    let torus = shapes::torus(12, 8);
    let counted = cover(&torus, 0.25).len();
    for exponent in [-200, -20, 30, 280] {
        let scale = 2_f64.powi(exponent);
        let mut mesh = torus.clone();
        mesh.vertices.iter_mut().flatten().for_each(|x| *x *= scale);
        assert_eq!(cover(&mesh, 0.25 * scale).len(), counted, "2^{exponent}");
    }
    let mut far = torus;
    far.vertices.iter_mut().flatten().for_each(|x| *x = ((*x * 1024.0).round() / 1024.0) + 1048576.0);
    check(&far, 0.25, "far away");
}

/// The winding number of a surface around a point that is not on it, from the solid angles of its triangles.
fn winding(all: &[Triangle], x: DVec3) -> f64 {
    let angle = |t: &Triangle| {
        let [p, q, r] = t.map(|corner| corner - x);
        let (a, b, c) = (p.length(), q.length(), r.length());
        p.dot(q.cross(r)).atan2(a * b * c + p.dot(q) * c + q.dot(r) * a + r.dot(p) * b)
    };
    all.iter().map(angle).sum::<f64>() / core::f64::consts::TAU
}

fn cover_solid(mesh: &MeshData, error: f64) -> Vec<Sphere> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }.cover_solid(error).unwrap()
}

/// The spheres contain the surface and points inside, and no sphere reaches too far: checked at its centre and
/// on it.
fn check_solid(mesh: &MeshData, error: f64, points: usize, what: &str) -> usize {
    let (all, spheres) = (triangles(mesh), cover_solid(mesh, error));
    for (i, t) in all.iter().enumerate() {
        assert!(is_held(t, &spheres, 5), "{what}: triangle {i} is not held");
    }
    let away = |x: DVec3| all.iter().map(|t| distance(x, t)).fold(f64::INFINITY, f64::min);
    let is_inside = |x: DVec3| winding(&all, x).abs() > 0.5;
    let corners = || all.iter().flatten();
    let low = corners().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = corners().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let mut rng = Rng::new(212);
    let mut inside = 0;
    for i in 0..points {
        let mut share = || rng.range(0.0, 1.0);
        let x = if i % 2 == 0 {
            low + DVec3::new(share(), share(), share()) * (high - low)
        } else {
            // Just below the surface, where the covering spheres are separate.
            let [p, q, r] = all[i / 2 % all.len()];
            let (u, v) = (share(), share());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let normal = (q - p).cross(r - p).normalize();
            p + u * (q - p) + v * (r - p) + error * (0.2 * share() - 0.1) * normal
        };
        if is_inside(x) {
            inside += 1;
            let holds = |s: &Sphere| x.distance(DVec3::from_array(s.centre)) <= s.radius;
            assert!(spheres.iter().any(holds), "{what}: {x} is inside and not held");
        }
    }
    assert!(20 * inside > points, "{what}: {inside} of {points} points are inside");
    for sphere in &spheres {
        for _ in 0..4 {
            let direction =
                DVec3::from_array(core::array::from_fn(|_| rng.range(-1.0, 1.0))).normalize_or_zero();
            let x = DVec3::from_array(sphere.centre) + sphere.radius * direction;
            assert!(is_inside(x) || away(x) <= error * (1.0 + 1e-12), "{what}: {x} is {} off", away(x));
        }
    }
    spheres.len()
}

/// With cavities, overlapping parts, reversed orientation, and parts so thin that no sphere is deep.
#[test]
fn spheres_hold_the_solid_and_stay_near_it() {
    let cuboid = |low, high| shapes::cuboid(low, high, false);
    let together = |mut mesh: MeshData, other: &MeshData| {
        shapes::append(&mut mesh, other);
        mesh
    };
    let cube = |half: f64| cuboid([-half; 3], [half; 3]);
    let points = 12_000 / suite_step();
    for (name, mesh) in [
        ("cuboid", cuboid([-1.0, -0.5, 0.0], [2.0, 0.5, 0.25])),
        ("cube", cube(1.0)),
        ("torus", shapes::torus(24, 16)),
        ("inside out", shapes::cuboid([0.0; 3], [1.0; 3], true)),
        ("cavity", together(cube(1.0), &shapes::cuboid([-0.5; 3], [0.5; 3], true))),
        ("winds twice", together(cube(1.0), &cube(0.5))),
        ("overlap", together(cuboid([0.0; 3], [1.0; 3]), &cuboid([0.5; 3], [1.5; 3]))),
        ("plate", cuboid([-1.0, -1.0, 0.0], [1.0, 1.0, 0.015625])),
    ]
    .into_iter()
    .step_by(suite_step().min(2))
    {
        let errors: &[f64] = by_suite(&[0.5, 0.25, 0.0625], &[0.5, 0.25]);
        let counts: Vec<_> = errors.iter().map(|&error| check_solid(&mesh, error, points, name)).collect();
        assert!(counts.is_sorted(), "{name}: {counts:?}");
        assert_eq!(cover_solid(&mesh, 10.0).len(), 1, "{name}: one sphere is enough");
    }
    assert!(cover_solid(&MeshData { vertices: vec![], triangles: vec![] }, 1.0).is_empty());
}

/// In any unit.
#[test]
fn covers_of_solids_have_no_scale() {
    let torus = shapes::torus(12, 8);
    let counted = cover_solid(&torus, 0.25).len();
    for exponent in [-200, -20, 30, 280] {
        let scale = 2_f64.powi(exponent);
        let mut mesh = torus.clone();
        mesh.vertices.iter_mut().flatten().for_each(|x| *x *= scale);
        assert_eq!(cover_solid(&mesh, 0.25 * scale).len(), counted, "2^{exponent}");
    }
}

#[test]
fn open_meshes_have_no_solid_to_cover() {
    let mut mesh = shapes::torus(12, 8);
    mesh.triangles.pop();
    let open = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    assert!(matches!(open.cover_solid(0.1), Err(CoverError::Mesh(BuildError::Open { .. }))));
    let cube = shapes::cuboid([0.0; 3], [1.0; 3], false);
    let cube = Mesh { vertices: &cube.vertices, triangles: &cube.triangles };
    for error in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-12] {
        assert!(matches!(cube.cover_solid(error), Err(CoverError::Error { .. })));
    }
}

/// So small an error takes more spheres than a tree can have.
#[test]
#[ignore = "seconds, or minutes in an emulator"]
fn more_spheres_than_a_tree_has_are_refused() {
    let cube = shapes::cuboid([0.0; 3], [1.0; 3], false);
    let cube = Mesh { vertices: &cube.vertices, triangles: &cube.triangles };
    assert_eq!(cube.cover_solid(1e-5), Err(CoverError::TooMany));
    let mesh = Mesh { vertices: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: &[[0, 1, 2]] };
    assert_eq!(mesh.cover(1e-5), Err(CoverError::TooMany));
}

/// A point is a triangle whose corners coincide.
#[test]
fn points_are_covered_by_few_spheres() {
    let mut rng = Rng::new(213);
    let vertices: Vec<[f64; 3]> = (0..2000).map(|_| core::array::from_fn(|_| rng.range(-1.0, 1.0))).collect();
    let triangles = (0..2000).map(|i| [i; 3]).collect();
    let cloud = MeshData { vertices, triangles };
    let count = check(&cloud, 0.5, "cloud");
    assert!(count < 150, "{count} spheres");
}

#[test]
fn scans_are_held() {
    let Some(data) = directory() else { return };
    let mesh = MeshData::obj(&data.join("meshes/cow.obj"));
    let all = triangles(&mesh);
    let (low, high) = all
        .iter()
        .flatten()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let spheres = cover(&mesh, 0.02 * low.distance(high));
    assert!(spheres.len() < all.len(), "{} spheres", spheres.len());
    for t in all.iter().step_by(7 * suite_step()) {
        assert!(is_held(t, &spheres, 5));
    }
}

#[test]
fn what_cannot_be_covered_is_refused() {
    let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh { vertices: &vertices, triangles: &[[0, 1, 2]] };
    for error in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-12] {
        let refused = mesh.cover(error).unwrap_err();
        assert!(matches!(refused, CoverError::Error { .. }) && refused.to_string().len() > 20, "{refused}");
    }
    let open = Mesh { vertices: &vertices, triangles: &[[0, 1, 3]] };
    assert_eq!(open.cover(0.1), Err(CoverError::Mesh(BuildError::Primitive { index: 0 })));
    let wrong = Mesh { vertices: &[[f64::NAN; 3]], triangles: &[] };
    assert_eq!(wrong.cover(0.1), Err(CoverError::Mesh(BuildError::Vertex { index: 0 })));
}
