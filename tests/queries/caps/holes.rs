//! Holes and their caps.

use super::meshes::{at, ball, capped, caps_of, closed_by_caps, dot, open_cube};
use super::oracle::Triangle;
use crate::mesh_of;
use crate::support::data::MeshData;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate};
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, CapStats};
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::packing::{PackError, Packer};
use simdop::primitive::Spheres;
use simdop::query::Query;
use simdop::range::Point;

fn area([a, b, c]: &Triangle) -> f64 {
    let [u, v] = [b, c].map(|q| glam::DVec3::from_array(*q) - glam::DVec3::from_array(*a));
    u.cross(v).length()
}

/// Each hole has a cap with the area of its least fan.
#[test]
fn caps_are_the_least_fans() {
    let mut rng = Rng::new(5);
    for _ in 0..60 {
        let (low, count) = ([-1.0, -2.0, 0.5], 3 + rng.below(9) as usize);
        // A cone over a random polygon, without its base.
        let mut rim: Vec<Point> = (0..count)
            .map(|i| {
                let t = core::f64::consts::TAU * i as f64 / count as f64;
                let r = rng.range(0.4, 1.0);
                [low[0] + r * t.cos(), low[1] + r * t.sin(), low[2] + rng.range(-0.3, 0.3)]
            })
            .collect();
        let fan = |rim: &[Point], apex: usize| -> Vec<Triangle> {
            let at = |i: usize| rim[(apex + i) % rim.len()];
            (1..rim.len() - 1).map(|i| [at(0), at(i), at(i + 1)]).collect()
        };
        let total = |fan: &[Triangle]| fan.iter().map(area).sum::<f64>();
        let tip = [low[0], low[1], low[2] + 2.0];
        let sides = (0..count).map(|i| [rim[i], rim[(i + 1) % count], tip]).collect::<Vec<_>>();
        let tree = capped::<Node16<18>>(&separate(sides));
        let stats = tree.view().cap_stats();
        assert_eq!((stats.holes, stats.triangles), (1, count - 2));
        rim.reverse();
        let least = (0..count).map(|apex| total(&fan(&rim, apex))).fold(f64::INFINITY, f64::min);
        let found = total(&caps_of(&tree));
        assert!((found - least).abs() <= 1e-12 * least, "{found} {least}");
        let wide = rim
            .iter()
            .flat_map(|p| rim.iter().map(move |q| glam::DVec3::from_array(*p).distance((*q).into())));
        let wide = wide.fold(0.0, f64::max);
        assert!((stats.width - wide).abs() < 1e-6 * wide, "{} {wide}", stats.width);
    }
}

#[test]
fn holes_are_counted_and_measured() {
    let (limit, root) = (f64::INFINITY, 2.0_f64.sqrt());
    let stats = |mesh: &MeshData| mesh_of(mesh).caps(limit).unwrap().stats;
    let of = |holes, triangles, width| CapStats { holes, triangles, width };
    let closed = cuboid([-1.0; 3], [1.0; 3], false);
    assert_eq!(stats(&closed), CapStats::default());
    let (solid, same) = (Builder::new().solid(), Builder::new().solid_with_caps(0.0));
    let bytes =
        |builder: Builder, mesh: &MeshData| builder.build(&mesh_of(mesh)).unwrap().as_bytes().to_vec();
    assert!(bytes(solid, &closed) == bytes(same, &closed));

    assert_eq!(stats(&open_cube()), of(1, 2, 2.0 * root));
    assert_eq!(stats(&separate(open_cube().corners())), of(1, 2, 2.0 * root));
    // One cap cancels a triangle of reversed orientation, and another replaces it.
    let mut turned = closed.clone();
    turned.triangles[3].swap(0, 1);
    assert_eq!(stats(&turned), of(2, 2, 2.0 * root));
    // A doubled triangle, with edges of three.
    let mut double = closed.clone();
    double.triangles.push(double.triangles[5]);
    assert_eq!(stats(&double), of(1, 1, 2.0 * root));
    // A wall inside.
    let mut walled = closed.clone();
    walled.triangles.extend([[0, 1, 7], [0, 7, 6]]);
    assert_eq!(stats(&walled), of(1, 2, 12.0_f64.sqrt()));
    // Two holes that share a corner: a figure eight.
    let mut eight = ball(2, false);
    let corner = eight.triangles[0];
    let other = eight.triangles.iter().rposition(|t| t.iter().filter(|v| corner.contains(v)).count() == 1);
    eight.triangles.remove(other.unwrap());
    eight.triangles.remove(0);
    assert_eq!(stats(&eight), of(2, 2, root));
    // Unused vertices at the positions of used ones.
    let mut unused = MeshData { vertices: closed.vertices.clone(), triangles: Vec::new() };
    append(&mut unused, &open_cube());
    assert_eq!(stats(&unused), of(1, 2, 2.0 * root));
    for mesh in [turned, double, walled, eight, unused] {
        let tree = capped::<Node16<18>>(&mesh);
        let _ = closed_by_caps(&mesh, &tree);
        let dot = dot::<Node16<18>>();
        let query = Query::new(Isa::detect());
        assert!(!query.collide(&dot, &tree, &at([0.1, 0.2, 0.3])).is_free());
        assert!(query.collide(&dot, &tree, &at([0.1, 0.2, 1.3])).is_free());
    }
}

#[test]
fn holes_that_are_too_wide_are_named() {
    let (open, root) = (open_cube(), 8.0_f64.sqrt());
    for mesh in [open.clone(), separate(open.corners())] {
        for limit in [0.0, 1.0, root.next_down(), -1.0, f64::NAN] {
            let error = Builder::new().solid_with_caps(limit).build(&mesh_of(&mesh)).unwrap_err();
            let BuildError::Hole { edge: [a, b], corners, width, limit: said } = error else {
                panic!("{error}")
            };
            assert_eq!((width, said.to_bits()), (root, limit.to_bits()));
            assert_eq!(corners, [a, b].map(|v| mesh.vertices[v as usize]));
            assert!(a < b && corners.iter().all(|p| p[0] == 1.0), "an edge of the missing side: {corners:?}");
            let text = error.to_string();
            assert!(text.contains("hole 2.828") && text.contains(&format!("vertices {a} and {b}")), "{text}");
        }
        assert!(Builder::new().solid_with_caps(root).build(&mesh_of(&mesh)).is_ok());
    }
    // The widest of several, of one surface and of two in either order.
    let mut two = ball(8, false);
    let wide = two.triangles[9][0];
    two.triangles.retain(|t| !t.contains(&wide));
    two.triangles.pop();
    let error = mesh_of(&two).caps(0.4).unwrap_err();
    let BuildError::Hole { width, .. } = error else { panic!("{error}") };
    assert!(width > 0.5, "{width}");
    let small = scaled(&open, 0.25, [5.0, 0.0, 0.0]);
    for [first, last] in [[&open, &small], [&small, &open]] {
        let mut two = first.clone();
        append(&mut two, last);
        let error = mesh_of(&two).caps(0.4).unwrap_err();
        let BuildError::Hole { width, .. } = error else { panic!("{error}") };
        assert_eq!(width, root);
    }
    // Too many.
    let soup = separate((0..16_385).map(|i| [0.0, 0.25, 0.5].map(|x| [f64::from(i) + x, x * x, 0.0])));
    let error = mesh_of(&soup).caps(f64::INFINITY).unwrap_err();
    assert_eq!(
        error,
        BuildError::TooManyCaps { count: 16_385, edge: [0, 2], corners: [[0.0; 3], [0.5, 0.25, 0.0]] }
    );
    let few = MeshData { triangles: soup.triangles[1..].to_vec(), ..soup };
    assert_eq!(mesh_of(&few).caps(1.0).unwrap().stats.holes, 16_384);
    let tree = Builder::new().solid_with_caps(1.0).build_as::<Node4<32>>(&mesh_of(&few)).unwrap();
    assert_eq!(tree.view().cap_stats().holes, 16_384);
    // Invalid meshes.
    let bad = Mesh { vertices: &[[f64::NAN; 3]], triangles: &[] };
    assert_eq!(bad.caps(1.0), Err(BuildError::Vertex { index: 0 }));
    let bad = Mesh { vertices: &[[0.0; 3]], triangles: &[[0, 0, 1]] };
    assert_eq!(bad.caps(1.0), Err(BuildError::Primitive { index: 0 }));
}

/// In any unit.
#[test]
fn units_do_not_matter() {
    for exponent in [-240, -60, 0, 60, 290] {
        let unit = 2.0_f64.powi(exponent);
        let mesh = scaled(&open_cube(), unit, [0.0; 3]);
        let tree = capped::<Node16<18>>(&mesh);
        let width = tree.view().cap_stats().width / unit;
        assert!((width - 8.0_f64.sqrt()).abs() < 1e-6);
        let dot = dot::<Node16<18>>();
        let query = Query::new(Isa::detect());
        assert!(!query.collide(&dot, &tree, &at([0.9 * unit, 0.0, 0.0])).is_free());
        assert!(query.collide(&dot, &tree, &at([1.1 * unit, 0.0, 0.0])).is_free());
    }
}

#[test]
fn packings_and_covers_take_the_caps() {
    let (open, query) = (open_cube(), Query::new(Isa::detect()));
    let mut double = cuboid([-1.0; 3], [1.0; 3], false);
    double.triangles.push(double.triangles[5]);
    for mesh in [open, double] {
        // An edge of three triangles is a border like any other.
        assert!(matches!(Packer::new().pack(&mesh_of(&mesh)), Err(PackError::Open { .. })));
        assert!(mesh_of(&mesh).cover_solid(0.2).is_err());
        let caps = mesh_of(&mesh).caps(3.0).unwrap();
        let mut closed = mesh.clone();
        closed.triangles.extend(caps.triangles);
        let packing = Packer::new().spheres(20).pack(&mesh_of(&closed)).unwrap();
        assert!((packing.volume - 8.0).abs() < 1e-12 && packing.spheres.len() == 20);
        for sphere in &packing.spheres {
            assert!(sphere.centre.iter().all(|x| x.abs() + sphere.radius <= 1.0));
        }
        // Covers include the volume that caps close.
        let cover = mesh_of(&closed).cover_solid(0.2).unwrap();
        let cover: Bvh<Node16<18>, Spheres> = Builder::new()
            .build_geometry(&SphereSet { spheres: &cover }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let dot = dot::<Node16<18>>();
        let mut rng = Rng::new(9);
        for _ in 0..500 {
            let p = [(); 3].map(|()| rng.range(-1.0, 1.0));
            assert!(!query.collide(&dot, &cover, &at(p)).is_free(), "{p:?}");
        }
    }
}
