//! Bodies inside solids with caps, and on caps.

use super::meshes::{
    Tree, at, ball, capped, caps_of, closed_by_caps, cut, dot, made, open_cube, points, real_meshes,
};
use super::oracle::{Oracle, Triangle};
use crate::mesh_of;
use crate::support::data::{MeshData, by_suite, emulator_step, suite_step};
use crate::support::exact::meshes_meet;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, separate, torus};
use crate::support::turns::{pose, rotation};
use simdop::construct::Builder;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, Verdict};

/// A pose of a small body near a mesh, often near one of its holes.
fn placement(mesh: &MeshData, caps: &[Triangle], size: f64, rng: &mut Rng) -> Pose {
    let around = points(mesh, caps, 1, rng)[0];
    let shift = around.map(|x| x + rng.range(-size, size));
    pose(&rotation(rng), shift)
}

/// Every answer follows from that of the surface, and from which points are inside or on a cap.
fn check_bodies<N: Lanes>(mesh: &MeshData, count: usize, rng: &mut Rng, seen: &mut [usize; 4]) {
    let (tree, surface) = (capped::<N>(mesh), Builder::new().build_as::<N>(&mesh_of(mesh)).unwrap());
    let oracle = Oracle::new(closed_by_caps(mesh, &tree));
    let caps = caps_of(&tree);
    let size = mesh.diagonal() * *rng.pick(&[1e-3, 1e-2, 0.05]);
    let body = match rng.below(3) {
        0 => cuboid([-0.5 * size; 3], [0.5 * size; 3], false),
        1 => scaled(&torus(6, 4), 0.3 * size, [0.0; 3]),
        // A rod, and a flag.
        _ => separate([
            [[-4.0 * size, 0.0, 0.0], [4.0 * size, 0.0, 0.0], [4.0 * size, 0.0, 0.0]],
            [[9.0 * size, 0.0, 0.0], [10.0 * size, 0.0, size], [10.0 * size, size, 0.0]],
        ]),
    };
    let small: Bvh<N> = Builder::new().build_as(&mesh_of(&body)).unwrap();
    let (query, scalar) = (Query::new(Isa::detect()), Query::new(Isa::SCALAR));
    for _ in 0..count {
        let pose = placement(mesh, &caps, size, rng);
        let (bare, found) = (query.collide(&small, &surface, &pose), query.collide(&small, &tree, &pose));
        assert_eq!(scalar.collide(&small, &tree, &pose), found);
        let bare_far = query.distance(&small, &surface, &pose, 0.0).unwrap();
        let far = query.distance(&small, &tree, &pose, 0.0).unwrap();
        let near = 0.5 * bare_far.lower;
        if bare.hit().is_some() {
            seen[0] += 1;
            assert_eq!((found, far), (bare, bare_far), "contacts do not depend on caps");
            continue;
        }
        let moved: Vec<Triangle> = body.corners().iter().map(|t| t.map(|p| pose.apply(p))).collect();
        let is_in = moved.iter().flatten().any(|p| oracle.place(p, rng).is_in());
        let is_on = meshes_meet(&moved, &caps);
        assert_eq!(found.hit().is_some(), is_in || is_on, "{pose:?} {is_in} {is_on}");
        assert_eq!(found.is_free(), found.hit().is_none());
        let within = query.within(&small, &tree, &pose, near).unwrap();
        if let Some(pair) = found.hit() {
            seen[if is_on { 2 } else { 1 }] += 1;
            assert!((pair.a as usize) < body.triangles.len() && (pair.b as usize) < mesh.triangles.len());
            assert_eq!((far.lower, far.upper), (0.0, 0.0));
            let witness = far.witness.unwrap();
            assert!((witness.pair.b as usize) < mesh.triangles.len());
            let apart = glam::DVec3::from_array(witness.a).distance(witness.b.into());
            assert!(apart <= 1e-9 * mesh.diagonal());
            assert!(within.hit().is_some());
        } else {
            seen[3] += 1;
            let numbers = |d: &simdop::query::Distance| (d.lower, d.upper, d.witness, d.completion, d.hint);
            assert_eq!(numbers(&far), numbers(&bare_far), "distances do not depend on caps");
            assert!(within.is_free());
        }
        let more = query.within(&small, &tree, &pose, 2.0 * bare_far.upper).unwrap();
        assert!(more.hit().is_some());
        // Never falsely free within a budget.
        let budget = rng.below(found.stats.visits + 1);
        let few = query.with_budget(budget);
        let (part, part_far) =
            (few.collide(&small, &tree, &pose), few.distance(&small, &tree, &pose, 0.0).unwrap());
        assert!(part.stats.visits <= budget && part_far.stats.visits <= budget);
        assert!(part.verdict == found.verdict || matches!(part.verdict, Verdict::Unknown { .. }));
        assert!(found.is_free() || part_far.lower == 0.0);
    }
}

#[test]
fn bodies_are_hits_inside_and_on_caps() {
    let (mut rng, mut seen) = (Rng::new(6), [0; 4]);
    let [closed, open] = real_meshes();
    let count = if cfg!(miri) { 2 } else { by_suite(800, 64 / emulator_step()) };
    for mesh in made().iter().chain(&made()) {
        check_bodies::<Node16<18>>(&cut(mesh, 12, &mut rng), count, &mut rng, &mut seen);
    }
    for mesh in made() {
        check_bodies::<Node4<14>>(&cut(&mesh, 12, &mut rng), count / 4, &mut rng, &mut seen);
    }
    for (name, mesh) in
        closed.iter().take(3).map(|(name, mesh)| (name, cut(mesh, 40, &mut rng))).collect::<Vec<_>>()
    {
        println!("{name}");
        check_bodies::<Node16<18>>(&mesh, count, &mut rng, &mut seen);
    }
    for (name, mesh) in open.iter().skip(by_suite(3, 0)) {
        println!("{name}");
        check_bodies::<Node16<18>>(mesh, count, &mut rng, &mut seen);
    }
    // The solid is the first body, and is moved.
    let dice = cuboid([-0.25; 3], [0.25; 3], false);
    let small: Tree = Builder::new().build_as(&mesh_of(&dice)).unwrap();
    let mut moved_seen = [0; 3];
    let (ball, torus) = (cut(&ball(2, false), 6, &mut rng), cut(&torus(8, 6), 6, &mut rng));
    // Few poses meet a cap and nothing else: all are tried in every suite.
    let moved = if cfg!(miri) { 1 } else { 200 };
    // The cube's opening is wide enough for the dice.
    for mesh in [ball, torus, open_cube()] {
        let tree = capped::<Node16<18>>(&mesh);
        for _ in 0..moved {
            let pose = pose(&rotation(&mut rng), [(); 3].map(|()| rng.range(-1.6, 1.6)));
            let place = |all: &[Triangle]| all.iter().map(|t| t.map(|p| pose.apply(p))).collect::<Vec<_>>();
            let found = Query::new(Isa::detect()).collide(&tree, &small, &pose);
            let far = Query::new(Isa::detect()).distance(&tree, &small, &pose, 0.0).unwrap();
            let is_touching = meshes_meet(&place(&mesh.corners()), &dice.corners());
            let is_on = meshes_meet(&place(&caps_of(&tree)), &dice.corners());
            let around = Oracle::new(place(&closed_by_caps(&mesh, &tree)));
            let is_in = dice.vertices.iter().any(|p| around.place(p, &mut rng).is_in());
            let is_hit = is_touching || is_on || is_in;
            assert_eq!(found.hit().is_some(), is_hit, "{pose:?}");
            assert_eq!((far.upper == 0.0, far.lower == 0.0), (is_hit, is_hit), "{pose:?}");
            if let Some(pair) = found.hit() {
                assert!((pair.a as usize) < mesh.triangles.len() && pair.b < 12);
                moved_seen[if is_touching { 0 } else { 1 + usize::from(is_on) }] += 1;
            }
        }
    }
    println!("{moved_seen:?} {seen:?} touching, inside, on a cap, free");
    assert!(count < 100 || moved_seen.iter().all(|&n| n > 0), "{moved_seen:?}");
    assert!(count < 100 || seen.iter().all(|&n| n > 2 * count), "{seen:?}");
}

/// The answer names the first of the triangles that the ray crosses, or that border the hole of a cap that it crosses.
#[test]
fn what_is_beside_a_cap_is_named() {
    let query = Query::new(Isa::detect());
    // With other triangles, the order of leaves is not that of the mesh.
    let mut more = open_cube();
    append(&mut more, &scaled(&ball(2, false), 0.1, [-4.0, 0.0, 0.0]));
    for (mut mesh, shift) in (0..10).flat_map(|shift| [(open_cube(), shift), (more.clone(), shift)]) {
        mesh.triangles.rotate_left(shift);
        let tree = capped::<Node16<18>>(&mesh);
        let is_at_hole = |index: u32| {
            let at = |&&v: &&u32| mesh.vertices[v as usize][0] == 1.0;
            mesh.triangles[index as usize].iter().filter(at).count() == 2
        };
        let dot = dot::<Node16<18>>();
        // The ray along x leaves through one cap or the other.
        for t in [[0.0, 0.5, 0.1], [0.0, 0.1, 0.5], [0.0, -0.5, 0.1], [0.0, 0.1, -0.5]] {
            let pair = query.collide(&dot, &tree, &at(t)).hit().unwrap();
            assert!(is_at_hole(pair.b), "{pair:?}");
            assert_eq!(query.distance(&dot, &tree, &at(t), 0.0).unwrap().witness.unwrap().pair, pair);
        }
        for x in [1.0, 1.05] {
            let flag = separate([[[0.0, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.0, 0.1]]]);
            let flag: Tree = Builder::new().build_as(&mesh_of(&flag)).unwrap();
            let pair = query.collide(&flag, &tree, &at([x, 0.2, 0.3])).hit().unwrap();
            assert!(is_at_hole(pair.b), "{pair:?}");
            let witness = query.distance(&flag, &tree, &at([x, 0.2, 0.3]), 0.0).unwrap().witness.unwrap();
            assert!(is_at_hole(witness.pair.b), "{witness:?}");
        }
    }
}

/// A cube wholly inside a link with holes is a hit if these are capped, and free of the surface.
#[test]
fn cubes_in_links_are_hits() {
    let (mut rng, query) = (Rng::new(7), Query::new(Isa::detect()));
    let [_, open] = real_meshes();
    for (name, mesh) in &open {
        let surface: Tree = Builder::new().build_as(&mesh_of(mesh)).unwrap();
        let tree = capped::<Node16<18>>(mesh);
        let oracle = Oracle::new(closed_by_caps(mesh, &tree));
        let half = 1e-3 * mesh.diagonal();
        let cube = cuboid([-half; 3], [half; 3], false);
        let body: Tree = Builder::new().solid().build_as(&mesh_of(&cube)).unwrap();
        let mut found = 0;
        for p in points(mesh, &[], 4000 / suite_step(), &mut rng) {
            let corners = || cube.vertices.iter().map(|q| core::array::from_fn(|i| p[i] + q[i]));
            if query.collide(&body, &surface, &at(p)).is_free()
                && corners().all(|q| oracle.place(&q, &mut rng).is_in())
            {
                found += 1;
                assert!(query.collide(&body, &tree, &at(p)).hit().is_some(), "{name} {p:?}");
                assert!(query.collide(&tree, &body, &at(p.map(|x| -x))).hit().is_some(), "{name} {p:?}");
            }
        }
        println!("{name}: {found} cubes, {:?}", tree.view().cap_stats());
        assert!(found > 10, "{name}");
    }
}
