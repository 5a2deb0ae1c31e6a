//! simdop: its shapes, and the solid meshes that replaced them before.

use super::cases::Suite;
use super::entrants::{Distance, Entrant};
use crate::driver::{Kind, Solid};
use simdop::construct::{Builder, OwnedMesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::shape::Shape;
use simdop::query::Query;
use std::rc::Rc;

/// The name of our entrant, which ratios refer to.
pub(super) const OURS: &str = "simdop";

/// Prisms and pyramids deviate from their cylinders and cones by at most this share of the radius.
const ERROR: f64 = 1e-3;

/// Half-spaces are replaced by cubes this many of the other body's diagonals wide.
const GROUND: f64 = 1024.0;

pub(super) fn entrants(suite: &Suite) -> Vec<Entrant> {
    vec![shapes(suite), meshes(suite)]
}

fn poses(suite: &Suite) -> Vec<Pose> {
    suite.cases.iter().map(|case| Pose::from_rows(case.rows).expect("the poses are rigid")).collect()
}

fn shapes(suite: &Suite) -> Entrant {
    let query = Query::new(Isa::detect());
    let poses = poses(suite);
    let of: Vec<usize> = suite.cases.iter().map(|case| case.pair).collect();
    let pairs: Vec<[Shape; 2]> =
        suite.pairs.iter().map(|pair| pair.map(|solid: Solid| solid.shape())).collect();
    let kept = Rc::new((poses, of, pairs));
    let again = Rc::clone(&kept);
    Entrant {
        name: OURS.to_owned(),
        version: "f64".to_owned(),
        collide: Box::new(move |i| {
            let (poses, of, pairs) = &*kept;
            let [a, b] = &pairs[of[i]];
            query.collide_shapes(a, b, &poses[i]).hit().is_some()
        }),
        distance: Some(Box::new(move |i| {
            let (poses, of, pairs) = &*again;
            let [a, b] = &pairs[of[i]];
            let found = query.distance_shapes(a, b, &poses[i], 0.0, f64::INFINITY).ok()?;
            let witness = found.witness?;
            Some(Distance { distance: found.upper, points: [witness.a, witness.b] })
        })),
    }
}

/// A tree whose triangles have a radius, and the solid's origin in its frame.
struct Widened {
    tree: Bvh<Node16<18>>,
    radius: f64,
}

/// A triangle without area.
fn segment(long: f64) -> OwnedMesh {
    let ends = [-0.5, 0.5].map(|share| [0.0, 0.0, share * long]);
    OwnedMesh { vertices: ends.to_vec(), triangles: vec![[0, 1, 1]] }
}

fn mesh(solid: &Solid, diagonal: f64) -> Widened {
    let [x, y, _] = solid.size;
    let none = 0.0;
    let (mut mesh, radius) = match solid.kind {
        Kind::Sphere => (OwnedMesh { vertices: vec![[0.0; 3]], triangles: vec![[0; 3]] }, x),
        Kind::Capsule => (segment(y), x),
        Kind::Cuboid => (OwnedMesh::cuboid(solid.size).expect("lengths"), none),
        Kind::Cylinder => (OwnedMesh::cylinder(x, y, ERROR * x).expect("lengths"), none),
        Kind::Cone => (OwnedMesh::cone(x, y, ERROR * x).expect("lengths"), none),
        Kind::HalfSpace => (OwnedMesh::cuboid([GROUND * diagonal; 3]).expect("lengths"), none),
    };
    if solid.kind == Kind::HalfSpace {
        for vertex in &mut mesh.vertices {
            vertex[2] -= 0.5 * GROUND * diagonal;
        }
    }
    let builder = if radius > 0.0 { Builder::new() } else { Builder::new().solid() };
    Widened { tree: builder.build_as(&mesh.as_mesh()).expect("a closed mesh"), radius }
}

fn meshes(suite: &Suite) -> Entrant {
    let query = Query::new(Isa::detect());
    let poses = poses(suite);
    let of: Vec<usize> = suite.cases.iter().map(|case| case.pair).collect();
    let tree = |[a, b]: &[Solid; 2]| [a, b].map(|solid| mesh(solid, a.diagonal()));
    let pairs: Vec<[Widened; 2]> = suite.pairs.iter().map(tree).collect();
    let kept = Rc::new((poses, of, pairs));
    let again = Rc::clone(&kept);
    Entrant {
        name: "simdop meshes (before)".to_owned(),
        version: Isa::detect().name().to_owned(),
        collide: Box::new(move |i| {
            let (poses, of, pairs) = &*kept;
            let [a, b] = &pairs[of[i]];
            let answer = query.within(&a.tree.view(), &b.tree.view(), &poses[i], a.radius + b.radius);
            answer.expect("radii are margins").hit().is_some()
        }),
        distance: Some(Box::new(move |i| {
            let (poses, of, pairs) = &*again;
            let [a, b] = &pairs[of[i]];
            let found = query.distance(&a.tree.view(), &b.tree.view(), &poses[i], 0.0).expect("a tolerance");
            let points = found.witness.map(|witness| [witness.a, witness.b])?;
            let gap: [f64; 3] = core::array::from_fn(|j| points[1][j] - points[0][j]);
            // Moves points from the axes of capsules and the centres of spheres to their surfaces.
            let shift = |p: [f64; 3], by: f64| core::array::from_fn(|j| p[j] + gap[j] * (by / found.upper));
            let at = [shift(points[0], a.radius), shift(points[1], -b.radius)];
            Some(Distance { distance: found.upper - a.radius - b.radius, points: at })
        })),
    }
}
