//! Points inside solids with caps, against winding numbers of the closed meshes.

use super::meshes::{at, ball, capped, caps_of, closed_by_caps, cut, dot, made, points, real_meshes};
use super::oracle::{Oracle, Place};
use crate::support::data::{MeshData, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::wavy_torus;
use core::ops::ControlFlow;
use simdop::cloud::{PointCloud, RangeSearch};
use simdop::construct::{Builder, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::low_level::key::Half;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Lanes, Query};

#[derive(Default, Debug)]
struct Seen {
    inside: usize,
    outside: usize,
    on: usize,
}

/// Compares the answers for a point, a sphere of radius 0 and a point of a cloud with the oracle.
fn check_points<N: Lanes>(mesh: &MeshData, count: usize, rng: &mut Rng, seen: &mut Seen) {
    let tree = capped::<N>(mesh);
    let oracle = Oracle::new(closed_by_caps(mesh, &tree));
    let dot = dot::<N>();
    let ball = [Sphere { centre: [0.0; 3], radius: 0.0 }];
    let ball: Bvh<N, Spheres> = Builder::new()
        .build_geometry(&SphereSet { spheres: &ball }, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let (query, scalar) = (Query::new(Isa::detect()), Query::new(Isa::SCALAR));
    for (i, p) in points(mesh, &caps_of(&tree), count, rng).into_iter().enumerate() {
        // In single precision, for the cloud.
        let p = if i % 16 == 0 { p.map(|x| f64::from(x as f32)) } else { p };
        let place = oracle.place(&p, rng);
        *(match place {
            Place::OnSurface => &mut seen.on,
            Place::Around(0) => &mut seen.outside,
            Place::Around(_) => &mut seen.inside,
        }) += 1;
        let found = query.collide(&dot, &tree, &at(p));
        assert_eq!(!found.is_free(), place.is_in(), "{p:?} {place:?}");
        if i % 16 == 0 {
            assert_eq!(scalar.collide(&dot, &tree, &at(p)), found);
            assert_eq!(!query.collide(&ball, &tree, &at(p)).is_free(), place.is_in(), "{p:?}");
            assert_eq!(query.within(&dot, &tree, &at(p), 0.0).unwrap(), found);
            let far = query.distance(&dot, &tree, &at(p), 0.0).unwrap();
            assert_eq!(far.upper == 0.0, place.is_in(), "{p:?} {place:?} {far:?}");
            let cloud = PointCloud::new(&[p.map(|x| x as f32)]).unwrap();
            let search = RangeSearch::new(Isa::detect());
            if place != Place::OnSurface {
                let near = search.body_within(&cloud.view(), &tree, &Pose::IDENTITY, 0.0).unwrap();
                assert_eq!(near.is_some(), place.is_in(), "{p:?}");
            }
        }
        if i % 512 == 0 {
            // The solid is the first body, and is moved.
            let back = at(p.map(|x| -x));
            let moved = oracle.triangles.iter().map(|t| t.map(|q| back.apply(q))).collect();
            let is_in = Oracle::new(moved).place(&[0.0; 3], rng).is_in();
            assert_eq!(!query.collide(&tree, &dot, &back).is_free(), is_in, "{p:?}");
        }
    }
}

fn random_points(count: usize, seed: u64) {
    let (mut rng, mut seen) = (Rng::new(seed), Seen::default());
    let [closed, open] = real_meshes();
    let made = made();
    let rounds = made.len() * 2 + closed.len() + open.len();
    let each = count / rounds;
    for mesh in made.iter().chain(&made) {
        check_points::<Node16<18>>(&cut(mesh, 12, &mut rng), each, &mut rng, &mut seen);
    }
    for (name, mesh) in &closed {
        println!("{name}");
        check_points::<Node16<18>>(&cut(mesh, 40, &mut rng), each, &mut rng, &mut seen);
    }
    for (name, mesh) in &open {
        println!("{name}");
        check_points::<Node16<18>>(mesh, each, &mut rng, &mut seen);
    }
    println!("{seen:?}");
    if count > 10_000 {
        assert!(seen.inside > count / 8 && seen.outside > count / 8 && seen.on > 0, "{seen:?}");
    }
}

#[test]
fn points_are_inside_by_the_winding_number_of_triangles_and_caps() {
    random_points(if cfg!(miri) { 60 } else { 100_000 / suite_step().pow(2) }, 1);
}

#[test]
#[ignore = "minutes"]
fn a_million_points() {
    random_points(1_000_000, 2);
}

#[test]
fn so_it_is_for_other_node_types() {
    let (mut rng, mut seen) = (Rng::new(3), Seen::default());
    for mesh in made() {
        let (count, mesh) = (if cfg!(miri) { 4 } else { 400 }, cut(&mesh, 12, &mut rng));
        check_points::<Node4<14>>(&mesh, count, &mut rng, &mut seen);
        check_points::<Node16<26, Half>>(&mesh, count, &mut rng, &mut seen);
    }
}

/// Far from the holes, and everywhere if these are flat, the inside is that of the mesh before they were cut.
#[test]
fn what_was_inside_still_is() {
    let mut rng = Rng::new(4);
    for (mesh, is_flat) in [(ball(6, false), true), (ball(8, true), false), (wavy_torus(3000), false)] {
        for _ in 0..8 {
            let mut open = mesh.clone();
            let middle = mesh.triangles[rng.below(mesh.triangles.len() as u64) as usize][0];
            let normal_axis = |t: &[u32; 3]| {
                (0..3).find(|&i| {
                    t.iter().all(|&v| mesh.vertices[v as usize][i] == mesh.vertices[t[0] as usize][i])
                })
            };
            let face = mesh.triangles.iter().find(|t| t.contains(&middle)).and_then(normal_axis);
            open.triangles.retain(|t| !t.contains(&middle) || is_flat && normal_axis(t) != face);
            let tree = capped::<Node16<18>>(&open);
            let (caps, width) = (caps_of(&tree), tree.view().cap_stats().width);
            assert_eq!(tree.view().cap_stats().holes, 1);
            assert!(caps.len() >= if is_flat { 1 } else { 4 });
            let dot = dot::<Node16<18>>();
            let (whole, query) = (Oracle::new(mesh.corners()), Query::new(Isa::detect()));
            let centre = mesh.vertices[middle as usize];
            for p in points(&open, &caps, 2000, &mut rng) {
                let is_far = (0..3).map(|i| (p[i] - centre[i]).powi(2)).sum::<f64>().sqrt() > width;
                if is_far || is_flat {
                    let is_in = whole.place(&p, &mut rng).is_in();
                    assert_eq!(!query.collide(&dot, &tree, &at(p)).is_free(), is_in, "{p:?}");
                }
            }
        }
    }
}
