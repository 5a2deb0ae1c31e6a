//! Bodies of different size, in any unit, far from their origins, with stray parts: every verdict, all pairs
//! and margins against brute force in exact arithmetic, with equal answers and statistics on every instruction
//! set.
//!
//! A small body is posed at random corners of a large one, once as A and once as B, at ratios of sizes from 1
//! to 10^12. `SIMDOP_SUITE=full` has larger bodies and more poses.

use crate::judged::{Answers, Scene, build, check_all, check_margins, flushed, moved};
use crate::support::corners::{inverse, near_corners};
use crate::support::data::{MeshData, by_suite, directory, emulator_step, suite_step};
use crate::support::exact_distance::mesh_distance;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, room, scaled, separate, wavy_torus};
use simdop::construct::BuildError;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::Query;
use simdop::range::MAX_COORDINATE;
use std::collections::BTreeSet;

/// The sizes of the two bodies.
const SIZES: [(f64, f64); 10] = [
    (1.0, 1.0),
    (0.3, 1.0),
    (0.1, 1.0),
    (0.01, 1.0),
    (1e-3, 1.0),
    (1e-4, 1.0),
    (1e-5, 1.0),
    (1e-6, 1.0),
    (1e-6, 1e3),
    (1e-6, 1e6),
];

fn torus_and_room() -> [(&'static str, MeshData); 2] {
    [("torus", wavy_torus(by_suite(2000, 512))), ("room", room(by_suite(3000, 640)))]
}

#[test]
fn answers_are_exact_at_every_ratio_of_sizes() {
    for (name, mesh) in torus_and_room() {
        let scenes = SIZES.iter().step_by(suite_step().min(3)).flat_map(|&(small, large)| {
            let name = format!("{name}, {small:e} against {large:e}");
            let (small, large) = (scaled(&mesh, small, [0.0; 3]), scaled(&mesh, large, [0.0; 3]));
            Scene::both_ways(&name, &small, &large, &large, by_suite(8, 4))
        });
        check_all(scenes);
    }
}

/// From units in which the small body's coordinates are a few times the least one, to units in which the large
/// body's coordinates are the greatest.
#[test]
fn answers_are_exact_in_every_unit() {
    let body = wavy_torus(by_suite(800, 200));
    let units = [1e-68, 1e-60, 1e-40, 1e-20, 1e-9, 1e9, 1e20, 1e40, 1e60, 5e89];
    check_all(units.into_iter().flat_map(|unit| {
        let (small, large) = (scaled(&body, 1e-3 * unit, [0.0; 3]), scaled(&body, unit, [0.0; 3]));
        Scene::both_ways(&format!("unit {unit:e}"), &small, &large, &large, by_suite(8, 3))
    }));
}

/// A body beyond the range of coordinates is rejected, and so is one that would become a point because all of
/// its coordinates are below the range. If only some are below it, the verdicts are those of the body that is
/// left, as `build` documents.
#[test]
fn units_beyond_the_range_are_refused() {
    let body = wavy_torus(200);
    for unit in [1e91, 1e100, 1e200, 1e300] {
        let large = scaled(&body, unit, [0.0; 3]);
        let first = large.vertices.iter().position(|p| p.iter().any(|x| x.abs() > MAX_COORDINATE));
        let want = BuildError::Vertex { index: first.expect("beyond the range") };
        assert_eq!(build::<Node16<18>>(&large).unwrap_err(), want, "{unit:e}");
        assert_eq!(build::<Node4<14>>(&large).unwrap_err(), want, "{unit:e}");
    }
    for unit in [1e-76, 1e-100, 1e-200, 1e-300] {
        let small = scaled(&body, unit, [0.0; 3]);
        assert_eq!(build::<Node16<18>>(&small).unwrap_err(), BuildError::TooSmall, "{unit:e}");
        assert_eq!(build::<Node4<14>>(&small).unwrap_err(), BuildError::TooSmall, "{unit:e}");
    }
    check_all([1e-75, 5e-76, 3e-76].into_iter().flat_map(|unit| {
        let small = scaled(&body, unit, [0.0; 3]);
        assert!(small.corners() != flushed(small.corners()), "{unit:e}: some coordinates are too small");
        Scene::both_ways(&format!("unit {unit:e}"), &small, &small, &small, by_suite(8, 6))
    }));
}

/// Bodies that are far from the origin of their own coordinates: by up to 10^9 of their diagonals, where a
/// corner's last place is 2^-23 of the diagonal, and by 10^12, where it is 2^-13 and the pads of the
/// realignment matter.
#[test]
fn answers_are_exact_far_from_the_origin() {
    let body = wavy_torus(by_suite(800, 200));
    let away = [0.48, -0.6, 0.64];
    let shifted = |factor: f64, diagonals: f64| {
        let by = diagonals * factor * body.diagonal();
        scaled(&body, factor, away.map(|x| x * by))
    };
    let offsets =
        [(1e3, 0.0), (0.0, 1e6), (1e6, 1e6), (1e9, 0.0), (0.0, 1e9), (1e9, 1e9), (1e12, 0.0), (1e12, 1e12)];
    check_all(offsets.into_iter().flat_map(|(of_small, of_large)| {
        let scenes = |factor| {
            let (small, large) = (shifted(factor, of_small), shifted(1.0, of_large));
            let name = format!("{factor:e} of the size, {of_small:e} and {of_large:e} diagonals away");
            Scene::both_ways(&name, &small, &large, &large, by_suite(6, 2))
        };
        [1.0, 1e-3].into_iter().flat_map(scenes).collect::<Vec<_>>()
    }));
}

/// However far apart two bodies are, they are free within a few visits. So are the exchanged bodies at the
/// inverse pose.
#[test]
fn bodies_that_are_far_apart_are_free_at_once() {
    let body = wavy_torus(by_suite(800, 200));
    let mut rng = Rng::new(2);
    for factor in [1.0, 1e-3, 1e-6, 1e-12] {
        let small = scaled(&body, factor, [0.0; 3]);
        for diagonals in [2.0, 1e3, 1e6, 1e9] {
            let turn = rng.rotation();
            let away = diagonals * body.diagonal();
            let rows = core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], away * turn[i][0]]);
            for (a, b, rows) in [(&small, &body, rows), (&body, &small, inverse(&rows))] {
                let scene = Scene::new(format!("{factor:e}, {diagonals:e} diagonals"), a, b, vec![rows]);
                assert_eq!(scene.hits(), 0, "{rows:?}");
                scene.check();
                let [a, b] = [a, b].map(|mesh| build::<Node16<18>>(mesh).unwrap());
                let pose = Pose::from_rows(rows).unwrap();
                let stats = Query::new(Isa::detect()).collide(&a, &b, &pose).stats;
                assert!(stats.visits <= 2 && stats.primitive_pairs == 0, "{stats:?} {rows:?}");
            }
        }
    }
}

/// A triangle far away makes the frame of the tree as coarse as its distance is great. A vertex that no
/// triangle uses does not affect the tree.
#[test]
fn stray_parts_change_no_answer() {
    let body = wavy_torus(200);
    let mut scenes = Vec::new();
    for (factor, way) in [(1.0, 1e3), (1.0, 1e9), (0.01, 1e3), (0.01, 1e9), (1e-5, 1e4)] {
        let small = scaled(&body, factor, [0.0; 3]);
        let stray = |mesh: &MeshData| {
            let far = way * mesh.diagonal();
            let mut mesh = mesh.clone();
            append(&mut mesh, &separate([[[far, 0.0, 0.0], [far, 0.5 * far, 0.0], [far, 0.0, 0.1 * far]]]));
            mesh
        };
        let poses = near_corners(&small, &body, 0.5, by_suite(4, 2) as usize, &mut Rng::new(way as u64));
        for (a, b) in
            [(stray(&small), body.clone()), (small.clone(), stray(&body)), (stray(&small), stray(&body))]
        {
            scenes.push(Scene::new(format!("{factor:e}, strays {way:e} away"), &a, &b, poses.clone()));
        }
    }
    check_all(scenes);

    let clean = build::<Node16<18>>(&body).unwrap();
    let mut more = body.clone();
    more.vertices.push([1e80, -1e-70, 3.0]);
    let with_vertex = build::<Node16<18>>(&more).unwrap();
    for rows in near_corners(&body, &body, 0.5, 20, &mut Rng::new(3)) {
        let pose = Pose::from_rows(rows).unwrap();
        let want = Answers::of(Isa::detect(), &clean, &clean, &pose);
        let got = Answers::of(Isa::detect(), &with_vertex, &with_vertex, &pose);
        assert!(got == want, "{rows:?}");
    }
}

/// Margins near the exact distance, and the distance, at different sizes.
#[test]
fn margins_are_kept_at_every_ratio_of_sizes() {
    let step = by_suite(1, 2 * emulator_step());
    for (name, mesh) in torus_and_room() {
        let mut apart = 0;
        for (small, large) in SIZES.into_iter().step_by(step) {
            let name = format!("{name}, {small:e} against {large:e}");
            let (small, large) = (scaled(&mesh, small, [0.0; 3]), scaled(&mesh, large, [0.0; 3]));
            for scene in Scene::both_ways(&name, &small, &large, &large, by_suite(3, 2)) {
                apart += scene.judged.len() - scene.hits();
                check_margins::<Node16<18>>(&scene);
                check_margins::<Node4<14>>(&scene);
            }
        }
        assert!(apart > SIZES.len() / step, "{apart} poses apart are few");
    }
}

/// Distances and margins near large triangles, whose k-DOPs contain the whole small body. Still only few of its
/// triangles may be tested.
#[test]
fn distances_beside_large_triangles_take_little_work() {
    let (cube, torus) = (cuboid([-0.5; 3], [0.5; 3], false), wavy_torus(by_suite(8000, 2000)));
    for scale in [0.05, 1e-3, 1e-5].into_iter().step_by(emulator_step().div_ceil(2)) {
        let small = scaled(&torus, scale, [0.0; 3]);
        let (mut rng, apart) = (Rng::new(3), 0.5 + 1.5 * small.diagonal());
        // Above a face of the cube, and beyond its edges and corners.
        let mut pose = |i: u32| {
            let mut along = |beyond: bool| if beyond { apart } else { rng.range(-0.4, 0.4) };
            let place = [along(i % 2 == 1), along(i % 4 > 1), apart];
            let turn = rng.rotation();
            core::array::from_fn(|j| [turn[j][0], turn[j][1], turn[j][2], place[j]])
        };
        let poses: Vec<_> = (0..by_suite(8, 4)).map(&mut pose).collect();
        let back: Vec<_> = poses.iter().map(inverse).collect();
        for (a, b, poses) in [(&small, &cube, poses), (&cube, &small, back)] {
            let (a_tree, b_tree) = (build::<Node16<18>>(a).unwrap(), build::<Node16<18>>(b).unwrap());
            let still = b.corners();
            for rows in poses {
                let pose = Pose::from_rows(rows).unwrap();
                let mut first = None;
                for isa in Isa::available() {
                    let found = Query::new(isa).distance(&a_tree, &b_tree, &pose, 0.01).unwrap();
                    let margin = 0.9 * found.lower;
                    let within = Query::new(isa).within(&a_tree, &b_tree, &pose, margin).unwrap();
                    assert_eq!((found, within), *first.get_or_insert((found, within)), "{isa} {rows:?}");
                }
                let (found, within) = first.unwrap();
                let want = mesh_distance(&moved(a, &rows), &still, found.upper * (1.0 + 1e-9));
                assert!(found.lower <= want && want <= found.upper * (1.0 + 1e-12), "{want} {found:?}");
                assert!(
                    found.upper <= 1.01 * found.lower * (1.0 + 1e-9) && within.is_free(),
                    "{found:?} {within:?}"
                );
                assert!(found.stats.primitive_pairs <= 300, "{scale:e} {:?}", found.stats);
                assert!(within.stats.primitive_pairs <= 300, "{scale:e} {:?}", within.stats);
            }
        }
    }
}

/// A pending large triangle keeps culling a small body's nodes without rotating them into the triangle's frame.
#[test]
fn nodes_are_not_turned_for_large_triangles_that_cut_them() {
    let (cube, torus) = (cuboid([-0.5; 3], [0.5; 3], false), wavy_torus(by_suite(20_000, 5000)));
    for scale in [1e-3, 1e-4] {
        let small = scaled(&torus, scale, [0.0; 3]);
        let poses = near_corners(&small, &cube, 0.3, 40, &mut Rng::new(5));
        let back = poses.iter().map(inverse).collect();
        for (a, b, poses) in [(&small, &cube, poses), (&cube, &small, back)] {
            let (a, b) = (build::<Node16<18>>(a).unwrap(), build::<Node16<18>>(b).unwrap());
            let (mut visits, mut realignments) = (0, 0);
            for rows in poses {
                let answer = Query::new(Isa::SCALAR).collide(&a, &b, &Pose::from_rows(rows).unwrap());
                visits += answer.stats.visits;
                realignments += answer.stats.realignments;
            }
            // The root, and seldom a node below it.
            assert!(visits > 100 && realignments * 2 < visits, "{scale:e}: {realignments} of {visits}");
        }
    }
}

#[test]
fn answers_are_exact_at_details_of_scenes() {
    for (name, mesh) in torus_and_room() {
        check_all(Scene::both_ways_at_a_detail(name, &mesh, by_suite(12, 6)));
    }
}

#[test]
fn answers_are_exact_on_real_meshes_of_unlike_size() {
    let Some(data) = directory() else { return };
    let read = |file: &str| MeshData::obj(&data.join(file));
    let (cow, hall) = (read("meshes/cow.obj"), read("planning/unc_env.obj"));
    let poses = by_suite(12, 2);
    let mut scenes = Vec::new();
    for factor in [0.01, 0.1, 1e-4, 1e-6].into_iter().take(by_suite(4, 1) as usize) {
        let small = scaled(&cow, factor, [0.0; 3]);
        scenes.extend(Scene::both_ways(&format!("cow, {factor:e}"), &small, &cow, &cow, poses));
    }
    // The hall is in millimetres.
    for link in ["finger", "hand"].into_iter().take(by_suite(2, usize::from(emulator_step() == 1))) {
        let link = scaled(&read(&format!("robots/panda/meshes/{link}.obj")), 1e3, [0.0; 3]);
        scenes.extend(Scene::both_ways("a link in a hall", &link, &hall, &hall, poses));
    }
    scenes.extend(Scene::both_ways_at_a_detail("cow", &cow, poses));
    check_all(scenes);
}

/// The sizes of the generated bodies, by the formula and by their edges.
#[test]
fn generated_bodies_are_what_they_say() {
    let n = 50;
    let torus = wavy_torus(2 * n * n + 7);
    assert_eq!(torus.triangles.len(), 2 * (n * n) as usize);
    let mut edges = BTreeSet::new();
    for t in &torus.triangles {
        assert!((0..3).all(|i| edges.insert([t[i], t[(i + 1) % 3]])), "an edge is run through once");
    }
    assert!(edges.iter().all(|&[from, to]| edges.contains(&[to, from])), "and once backwards");
    for (index, p) in (0..).zip(&torus.vertices) {
        let [i, j] = [index / n, index % n].map(|i| f64::from(i) / f64::from(n) * core::f64::consts::TAU);
        let radius = 2.0 + (0.7 + 0.2 * (5.0 * i).cos()) * j.cos();
        let want = [radius * i.cos(), radius * i.sin(), 0.7 * j.sin() + 0.3 * (3.0 * j).sin()];
        assert!((0..3).all(|k| (p[k] - want[k]).abs() < 1e-14), "{index}: {p:?} {want:?}");
    }
    for triangles in [1000, 10_000, 100_000] {
        let room = room(triangles);
        let count = room.triangles.len();
        assert!(count <= triangles as usize && count * 10 > triangles as usize * 9, "{count} of {triangles}");
        let (low, high) = room.bounds();
        assert_eq!((low, high), ([-5.0, -4.0, 0.0], [5.0, 4.0, 3.0]), "all is in the room");
    }
}
