//! Shared by the tests: bodies and poses, through the C functions and through the library.

pub(crate) mod answers;
#[path = "../../../tests/support/rng.rs"]
mod rng;
pub(crate) mod robot;

pub(crate) use rng::Rng;

use simdop::construct::{Builder, ConvexHull, Mesh, OwnedMesh, ShapeSet, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::low_level::key::{Half, Storage};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::{Shape, Shapes, Sphere, Spheres};
use simdop_capi::*;
use std::ffi::c_int;
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// A body, through both interfaces.
pub(crate) struct Twice<T> {
    pub(crate) c: &'static simdop_body,
    pub(crate) rust: T,
}

/// What a function writes through its last pointer, or its error.
pub(crate) fn answer<T>(
    ask: impl FnOnce(Option<&mut MaybeUninit<T>>) -> simdop_error,
) -> Result<T, simdop_error> {
    let mut place = MaybeUninit::uninit();
    match ask(Some(&mut place)) {
        // SAFETY: written on success.
        simdop_error::None => Ok(unsafe { place.assume_init() }),
        error => Err(error),
    }
}

/// A new handle. It is NULL on failure.
pub(crate) fn handle<T>(
    make: impl FnOnce(Option<&mut MaybeUninit<Option<Box<T>>>>) -> simdop_error,
) -> Result<Box<T>, simdop_error> {
    let mut place = MaybeUninit::uninit();
    let error = make(Some(&mut place));
    // SAFETY: written on success and on failure.
    let handle = unsafe { place.assume_init() };
    assert_eq!(handle.is_some(), error == simdop_error::None);
    handle.ok_or(error)
}

pub(crate) fn surface(mesh: &Mesh<'_>) -> Result<Box<simdop_body>, simdop_error> {
    let (vertices, triangles) = (mesh.vertices, mesh.triangles);
    handle(|body| {
        // SAFETY: the lengths are those of the slices.
        unsafe {
            simdop_body_build_surface(
                vertices.as_ptr().cast(),
                vertices.len(),
                triangles.as_ptr().cast(),
                triangles.len(),
                body,
            )
        }
    })
}

pub(crate) fn solid(mesh: &Mesh<'_>) -> Result<Box<simdop_body>, simdop_error> {
    let (vertices, triangles) = (mesh.vertices, mesh.triangles);
    handle(|body| {
        // SAFETY: the lengths are those of the slices.
        unsafe {
            simdop_body_build_solid(
                vertices.as_ptr().cast(),
                vertices.len(),
                triangles.as_ptr().cast(),
                triangles.len(),
                body,
            )
        }
    })
}

pub(crate) fn triangles_as(
    mesh: &Mesh<'_>,
    is_solid: bool,
    storage: c_int,
) -> Result<Box<simdop_body>, simdop_error> {
    let (vertices, triangles) = (mesh.vertices, mesh.triangles);
    handle(|body| {
        // SAFETY: the lengths are those of the slices.
        unsafe {
            simdop_body_build_triangles_as(
                vertices.as_ptr().cast(),
                vertices.len(),
                triangles.as_ptr().cast(),
                triangles.len(),
                is_solid.into(),
                storage,
                body,
            )
        }
    })
}

pub(crate) fn hull(points: &[[f64; 3]], storage: c_int) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|body| unsafe { simdop_body_build_hull_as(points.as_ptr().cast(), points.len(), storage, body) })
}

pub(crate) fn capped(mesh: &Mesh<'_>, width: f64, storage: c_int) -> Result<Box<simdop_body>, simdop_error> {
    let (vertices, triangles) = (mesh.vertices, mesh.triangles);
    handle(|body| {
        // SAFETY: the lengths are those of the slices.
        unsafe {
            simdop_body_build_solid_with_caps(
                vertices.as_ptr().cast(),
                vertices.len(),
                triangles.as_ptr().cast(),
                triangles.len(),
                width,
                storage,
                body,
            )
        }
    })
}

pub(crate) fn spheres_as(spheres: &[[f64; 4]], storage: c_int) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|body| unsafe {
        simdop_body_build_spheres_as(spheres.as_ptr().cast(), spheres.len(), storage, body)
    })
}

/// A ball of radius 1 about the origin.
pub(crate) const BALL: simdop_shape = simdop_shape {
    kind: simdop_shape_kind::Sphere as u32,
    numbers: [1.0, 0.0, 0.0, 0.0],
    radius: 0.0,
    pose: IDENTITY,
};

pub(crate) fn shape(shape: &simdop_shape) -> Result<Box<simdop_body>, simdop_error> {
    handle(|body| simdop_body_build_shape(Some(shape), body))
}

pub(crate) fn shapes(shapes: &[simdop_shape]) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|body| unsafe { simdop_body_build_shapes(shapes.as_ptr(), shapes.len(), body) })
}

pub(crate) fn shapes_as(shapes: &[simdop_shape], storage: c_int) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|body| unsafe { simdop_body_build_shapes_as(shapes.as_ptr(), shapes.len(), storage, body) })
}

/// The number of a storage in C.
pub(crate) fn number<S: Storage>() -> c_int {
    if S::IS_HALF { simdop_storage::Half as c_int } else { simdop_storage::Fixed as c_int }
}

pub(crate) fn spheres(spheres: &[[f64; 4]]) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice.
    handle(|body| unsafe { simdop_body_build_spheres(spheres.as_ptr().cast(), spheres.len(), body) })
}

pub(crate) fn open(bytes: &[u8]) -> Result<Box<simdop_body>, simdop_error> {
    // SAFETY: the length is that of the slice, which the callers keep longer than the body.
    handle(|body| unsafe { simdop_body_open(bytes.as_ptr(), bytes.len(), body) })
}

pub(crate) fn bytes(body: &simdop_body) -> &[u8] {
    let mut first = MaybeUninit::uninit();
    let count = answer(|count| simdop_body_bytes(Some(body), Some(&mut first), count)).unwrap();
    // SAFETY: written on success.
    let first = unsafe { first.assume_init() };
    // SAFETY: there are that many bytes, which live as long as the body.
    unsafe { std::slice::from_raw_parts(first, count) }
}

/// Surfaces of random triangles, and solids.
pub(crate) fn meshes_of<S: Storage>(rng: &mut Rng) -> Vec<Twice<Bvh<Node16<18, S>>>> {
    let mut all = Vec::new();
    for count in [1, 7, 60] {
        let vertices: Vec<_> = (0..3 * count).map(|_| [0; 3].map(|_| rng.range(-1.0, 1.0))).collect();
        let triangles: Vec<_> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { vertices: &vertices, triangles: &triangles };
        let rust = Builder::new().build_as(&mesh).unwrap();
        all.push(Twice { c: Box::leak(triangles_as(&mesh, false, number::<S>()).unwrap()), rust });
    }
    for sides in [[2.0, 2.0, 2.0], [0.1, 0.2, 0.3]] {
        let mesh = OwnedMesh::cuboid(sides).unwrap();
        let rust = Builder::new().solid().build_as(&mesh.as_mesh()).unwrap();
        all.push(Twice { c: Box::leak(triangles_as(&mesh.as_mesh(), true, number::<S>()).unwrap()), rust });
    }
    // A side is missing, and capped.
    let mut mesh = OwnedMesh::cuboid([1.5; 3]).unwrap();
    mesh.triangles.truncate(10);
    let rust = Builder::new().solid_with_caps(2.2).build_as(&mesh.as_mesh()).unwrap();
    all.push(Twice { c: Box::leak(capped(&mesh.as_mesh(), 2.2, number::<S>()).unwrap()), rust });
    // A solid hull, and a flat one.
    for flat in [1.0, 0.0] {
        let points: Vec<_> = (0..30).map(|_| [1.0, 1.0, flat].map(|most| rng.range(-most, most))).collect();
        let mesh = ConvexHull::of(&points).unwrap().mesh;
        let builder = if flat == 0.0 { Builder::new() } else { Builder::new().solid() };
        let rust = builder.build_as(&mesh.as_mesh()).unwrap();
        all.push(Twice { c: Box::leak(hull(&points, number::<S>()).unwrap()), rust });
    }
    all
}

/// Sets of random spheres.
pub(crate) fn sphere_sets_of<S: Storage>(rng: &mut Rng) -> Vec<Twice<Bvh<Node16<18, S>, Spheres>>> {
    let mut all = Vec::new();
    for count in [1, 40] {
        let balls: Vec<[f64; 4]> = (0..count)
            .map(|_| [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(0.0, 0.2)])
            .collect();
        let sphere = |&[x, y, z, radius]: &[f64; 4]| Sphere { centre: [x, y, z], radius };
        let set: Vec<_> = balls.iter().map(sphere).collect();
        let set = SphereSet { spheres: &set };
        let rust = Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
        all.push(Twice { c: Box::leak(spheres_as(&balls, number::<S>()).unwrap()), rust });
    }
    all
}

/// A random shape of a kind, through both interfaces.
fn random_shape(rng: &mut Rng, kind: simdop_shape_kind) -> (simdop_shape, Shape) {
    let (ignored, at) = (f64::NAN, pose(rng));
    let (radius, [x, y, z]) = (*rng.pick(&[0.0, 0.1]), [(); 3].map(|()| rng.range(0.1, 1.0)));
    let (numbers, shape) = match kind {
        simdop_shape_kind::Sphere => ([x, ignored, ignored, ignored], Shape::sphere(x)),
        simdop_shape_kind::Capsule => ([x, y, ignored, ignored], Shape::capsule(x, y)),
        simdop_shape_kind::Cuboid => ([x, y, z, ignored], Shape::cuboid([x, y, z])),
        simdop_shape_kind::Cylinder => ([x, y, ignored, ignored], Shape::cylinder(x, y)),
        simdop_shape_kind::Cone => ([x, y, ignored, ignored], Shape::cone(x, y)),
        simdop_shape_kind::HalfSpace => ([x, -y, z, -1.0], Shape::half_space([x, -y, z], -1.0)),
    };
    let shape = shape.unwrap().widened(radius).unwrap().moved(&at.1);
    (simdop_shape { kind: kind as u32, numbers, radius, pose: at.0 }, shape)
}

const BOUNDED: [simdop_shape_kind; 5] = [
    simdop_shape_kind::Sphere,
    simdop_shape_kind::Capsule,
    simdop_shape_kind::Cuboid,
    simdop_shape_kind::Cylinder,
    simdop_shape_kind::Cone,
];

/// Bodies of one shape, of each kind.
pub(crate) fn single_shapes(rng: &mut Rng) -> Vec<Twice<Shape>> {
    let kinds = BOUNDED.into_iter().chain([simdop_shape_kind::HalfSpace]);
    let shape = |kind| {
        let (c, rust) = random_shape(rng, kind);
        Twice { c: Box::leak(shape(&c).unwrap()), rust }
    };
    kinds.map(shape).collect()
}

/// Sets of random shapes.
pub(crate) fn shape_sets_of<S: Storage>(rng: &mut Rng) -> Vec<Twice<Bvh<Node16<18, S>, Shapes>>> {
    let mut all = Vec::new();
    for count in [0, 1, 30] {
        let mut any = |_| {
            let kind = *rng.pick(&BOUNDED);
            random_shape(rng, kind)
        };
        let (c, rust): (Vec<_>, Vec<_>) = (0..count).map(&mut any).unzip();
        let set = ShapeSet::new(&rust).unwrap();
        let rust = Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
        all.push(Twice { c: Box::leak(shapes_as(&c, number::<S>()).unwrap()), rust });
    }
    all
}

/// A random pose. The bodies meet in about half of all cases.
pub(crate) fn pose(rng: &mut Rng) -> (simdop_pose, Pose) {
    let rotation = rng.rotation();
    let row = |r: [f64; 3], t: f64| [r[0], r[1], r[2], t];
    let rows = rotation.map(|r| row(r, rng.range(-1.5, 1.5)));
    (simdop_pose { rows }, Pose::from_rows(rows).unwrap())
}

pub(crate) const IDENTITY: simdop_pose =
    simdop_pose { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

/// Names items that only some of the tests use, so that the others compile without a warning.
const _: () = {
    let _ = (open, bytes, pose, IDENTITY, surface, solid, spheres, capped);
    let _ = (meshes_of::<Half>, sphere_sets_of::<Half>, shape_sets_of::<Half>, number::<Half>);
    let _ = (BALL, shape, shapes, single_shapes);
    let _ = |twice: Twice<()>| (twice.c, twice.rust);
};
