//! Details: parts of a body that are too fine for its frame. That queries among them are exact, cost what they cost among
//! bodies of their size, and that their bytes are proved and checked as those of the body are.

use crate::judged::{Scene, check_all, check_margins};
use crate::support::corners::{inverse, near_corners};
use crate::support::data::{MeshData, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, room, scaled, soup, torus, wavy_torus};
use crate::{aligned, build, build_with_leaves, mesh_of, splitters};
use simdop::construct::Builder;
use simdop::hierarchy::{Bvh, BvhRef, Detail, FormatError, Header};
use simdop::isa::Isa;
use simdop::node::{Link, Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};

/// `full`, or `small` for emulators.
fn size(full: u32, small: u32) -> u32 {
    if suite_step() == 1 { full } else { small }
}

/// A body with a copy of `fine` at a scale at each of some of its corners; the last copy.
fn with_details(body: &MeshData, fine: &MeshData, scale: f64, count: usize) -> (MeshData, MeshData) {
    let mut scene = body.clone();
    let mut last = fine.clone();
    for i in 0..count {
        let corner = body.vertices[body.triangles[i * body.triangles.len() / count][0] as usize];
        last = scaled(fine, scale, corner);
        append(&mut scene, &last);
    }
    (scene, last)
}

fn details<N: Lanes>(mesh: &MeshData) -> usize {
    let tree = build::<N>(mesh);
    let view = tree.view();
    view.verify().unwrap();
    view.validate().unwrap();
    assert_eq!(Bvh::<N>::from_bytes(tree.as_bytes()).unwrap().as_bytes(), tree.as_bytes());
    assert_eq!(view.stats().details, view.details().len());
    view.details().len()
}

/// The index of a detail's frame is finer by what it is smaller.
fn are_finer<N: Lanes>(tree: &BvhRef<'_, N>) {
    for detail in tree.details() {
        let holder = tree.details().iter().rev().find(|other| other.first <= detail.node);
        let coarse = holder.map_or_else(|| tree.frame(), Detail::frame);
        assert!(detail.exponent >= coarse.exponent + 3, "{detail:?}");
    }
}

#[test]
fn answers_are_exact_in_details_of_any_size() {
    let (body, fine) = (room(size(800, 300)), torus(12, 10));
    for scale in [1e-2, 1e-3, 1e-4, 1e-6, 1e-9] {
        let (scene, detail) = with_details(&body, &fine, scale, 3);
        if scale <= 1e-3 {
            assert!(details::<Node16<18>>(&scene) >= 3 && details::<Node4<14>>(&scene) >= 3, "{scale:e}");
        }
        are_finer(&build::<Node16<32>>(&scene).view());
        let small = scaled(&fine, 0.7 * scale, [0.0; 3]);
        check_all(Scene::both_ways(&format!("details of {scale:e}"), &small, &scene, &detail, size(24, 12)));
    }
}

/// Both bodies have them: the frames of either, or of both, change.
#[test]
fn answers_are_exact_between_details_of_both_bodies() {
    let fine = torus(10, 8);
    for (one, other) in [(3e-4, 3e-4), (3e-4, 1e-4), (1e-5, 1e-4)] {
        // Few large triangles, so that those of the two seldom meet.
        let rng = &mut Rng::new(2);
        let mut sparse = |scale: f64| {
            let mut scene = soup(rng, 60, 0.03);
            append(&mut scene, &scaled(&fine, scale, [0.2; 3]));
            let last = scaled(&fine, scale, [0.7, 0.3, 0.4]);
            append(&mut scene, &last);
            (scene, last)
        };
        let ((a, detail_a), (b, detail_b)) = (sparse(one), sparse(other));
        assert!(details::<Node16<18>>(&a) >= 2 && details::<Node16<18>>(&b) >= 2, "{one:e} {other:e}");
        let poses = near_corners(&detail_a, &detail_b, 0.4, size(40, 20) as usize, &mut Rng::new(5));
        check_all([Scene::new(format!("details of {one:e} and {other:e}"), &a, &b, poses)]);
    }
}

#[test]
fn answers_are_exact_in_details_of_details() {
    let fine = torus(12, 10);
    let (middle, _) = with_details(&fine, &fine, 1e-3, 1);
    let (scene, detail) = with_details(&room(size(800, 300)), &middle, 1e-3, 2);
    let tree = build::<Node16<18>>(&scene);
    let nested = tree.view().details().iter().filter(|detail| detail.node >= tree.view().header().node_count);
    assert!(nested.count() >= 2, "{:?}", tree.view().details());
    are_finer(&tree.view());
    assert!(details::<Node4<14>>(&scene) >= 4);
    let innermost = MeshData { triangles: detail.triangles[fine.triangles.len()..].to_vec(), ..detail };
    let small = scaled(&fine, 0.8e-6, [0.0; 3]);
    check_all(Scene::both_ways("details of details", &small, &scene, &innermost, size(40, 12)));
}

#[test]
fn margins_and_distances_are_exact_in_details() {
    let (scene, detail) = with_details(&wavy_torus(size(400, 200)), &torus(10, 8), 1e-4, 2);
    let small = scaled(&torus(10, 8), 1e-4, [0.0; 3]);
    for scene in Scene::both_ways("margins", &small, &scene, &detail, size(16, 8)) {
        check_margins::<Node16<18>>(&scene);
        check_margins::<Node4<14>>(&scene);
    }
    // Large triangles of A, each of which waits while a detail of B, and what is around it, is descended: of bodies of like
    // size, and of a body that is much larger.
    let rng = &mut Rng::new(4);
    let (large, mut scene) = (soup(rng, 40, 0.05), soup(rng, 60, 0.03));
    let detail = scaled(&torus(10, 8), 1e-4, [0.7, 0.3, 0.4]);
    append(&mut scene, &detail);
    for large in [scaled(&large, 30.0, [0.0; 3]), large] {
        let count = size(24, 12) as usize;
        let poses = near_corners(&detail, &large, 2.0, count, rng).iter().map(inverse).collect();
        let scene = Scene::new("large triangles".into(), &large, &scene, poses);
        assert!(scene.hits() < scene.judged.len() / 2);
        check_margins::<Node16<18>>(&scene);
        check_margins::<Node4<14>>(&scene);
    }
}

/// Trees of every splitter, with leaves of several primitives, and of many details in one another's way.
#[test]
fn every_splitter_has_details() {
    let mut scene = room(300);
    let (fine, count) = (torus(12, 10), size(40, 10) as usize);
    let rng = &mut Rng::new(3);
    for i in 0..count {
        let at = [rng.range(-4.0, 4.0), rng.range(-4.0, 4.0), rng.range(0.1, 2.9)];
        append(&mut scene, &scaled(&fine, [3e-4, 1e-4][i % 2], at));
    }
    for splitter in splitters(1) {
        let builder = Builder::new().splitter(splitter);
        let tree = builder.build(&mesh_of(&scene)).unwrap();
        tree.view().verify().unwrap();
        tree.view().validate().unwrap();
        let mut sources: Vec<u32> =
            (0..tree.view().len() as u32).map(|index| tree.view().source(index)).collect();
        sources.sort_unstable();
        assert!(sources.iter().copied().eq(0..scene.triangles.len() as u32), "{splitter:?}: each once");
        assert_eq!(tree.view().details().len(), count, "{splitter:?}: one for each");
        let thick = builder.without_normal_slabs().build_as::<Node4<14>>(&mesh_of(&scene)).unwrap();
        thick.view().verify().unwrap();
        assert_eq!(thick.view().details().len(), count, "{splitter:?}: one for each");
    }
    let tree = build_with_leaves::<Node16<18>>(&scene, 3);
    tree.view().verify().unwrap();
    assert!(tree.view().details().len() >= count, "{}", tree.view().details().len());
}

/// As many primitives as one likes in one place, and bodies that are points, are no details.
#[test]
fn most_bodies_have_none() {
    assert_eq!(details::<Node16<18>>(&room(3000)), 0);
    assert_eq!(details::<Node16<18>>(&wavy_torus(2000)), 0);
    assert_eq!(details::<Node4<14>>(&wavy_torus(2000)), 0);
    let mut points = room(300);
    let corner = points.vertices[0];
    let first = points.vertices.len() as u32;
    points.vertices.push(corner);
    points.triangles.extend([[first; 3]; 500]);
    assert_eq!(details::<Node16<18>>(&points), 0);
}

/// What a query near a detail visits does not depend on how small the detail is: about what it visits where that is a body
/// of its own.
#[test]
fn a_detail_costs_what_a_body_costs() {
    let fine = torus(40, 30);
    let query = Query::new(Isa::detect());
    let visits = |tree: &Bvh<Node16<18>>, small: &Bvh<Node16<18>>, poses: &[[[f64; 4]; 3]]| {
        let visits = |rows: &[[f64; 4]; 3]| {
            let stats = query.collide(small, tree, &Pose::from_rows(*rows).unwrap()).stats;
            stats.visits + stats.primitive_pairs
        };
        poses.iter().map(visits).sum::<u64>()
    };
    for scale in [1e-3, 1e-4, 1e-6] {
        let (scene, detail) = with_details(&room(800), &fine, scale, 1);
        let small = build(&scaled(&fine, scale, [0.0; 3]));
        let poses = near_corners(&scaled(&fine, scale, [0.0; 3]), &detail, 0.5, 100, &mut Rng::new(7));
        let (alone, baked_in) =
            (visits(&build(&detail), &small, &poses), visits(&build(&scene), &small, &poses));
        assert!(baked_in <= 2 * alone, "{scale:e}: {baked_in} visits and pairs of triangles, alone {alone}");
    }
}

#[test]
fn solids_have_details() {
    let outer = cuboid([-1.0; 3], [1.0; 3], false);
    let (fine, scale) = (torus(12, 10), 1e-4);
    let mut scene = outer;
    append(&mut scene, &scaled(&fine, scale, [5.0, 0.0, 0.0]));
    let solid = Builder::new().solid().build(&mesh_of(&scene)).unwrap();
    assert!(!solid.view().details().is_empty());
    let surface = build::<Node16<18>>(&scene);
    let small = build::<Node16<18>>(&scaled(&torus(6, 5), 1e-7, [0.0; 3]));
    let (mut inside, mut outside) = (0, 0);
    let rng = &mut Rng::new(1);
    for _ in 0..200 {
        // About the middle of the ring, along its round.
        let angle = rng.range(0.0, core::f64::consts::TAU);
        let radius = scale * rng.range(0.5, 1.5);
        let at = [5.0 + radius * angle.cos(), radius * angle.sin(), 0.0];
        let rows = core::array::from_fn(|i| {
            core::array::from_fn(|j| if j == 3 { at[i] } else { f64::from(u8::from(i == j)) })
        });
        let pose = Pose::from_rows(rows).unwrap();
        let is_hit =
            |tree: &Bvh<Node16<18>>| !Query::new(Isa::detect()).collide(&small, tree, &pose).is_free();
        if is_hit(&surface) {
            continue;
        }
        let want = winds(&scene, at);
        assert_eq!(is_hit(&solid), want, "{at:?}");
        if want { inside += 1 } else { outside += 1 }
    }
    assert!(inside > 20 && outside > 20, "{inside} inside, {outside} outside");
}

/// Whether the triangles wind around a point, by the sum of their solid angles (van Oosterom and Strackee 1983).
fn winds(mesh: &MeshData, at: [f64; 3]) -> bool {
    let angle = |corners: [[f64; 3]; 3]| {
        let [a, b, c] = corners.map(|p| glam::DVec3::from_array(core::array::from_fn(|i| p[i] - at[i])));
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    mesh.corners().into_iter().map(angle).sum::<f64>().abs() > core::f64::consts::TAU
}

// ---- Bytes ------------------------------------------------------------------------------------------------

fn baked() -> Bvh<Node16<18>> {
    let fine = torus(12, 10);
    let (middle, _) = with_details(&fine, &fine, 1e-3, 1);
    build(&with_details(&room(300), &middle, 1e-3, 2).0)
}

/// Every plane of a detail that is tight, moved in by a step.
#[test]
fn a_plane_of_a_detail_that_is_too_low_is_found() {
    let tree = baked();
    let view = tree.view();
    let first = view.details()[0].first as usize;
    let mut found = 0;
    for node in (first..view.nodes().len()).step_by(7) {
        for (j, lane) in [(0, 0), (5, 1), (17, 2)] {
            if view.nodes()[node].child[lane].link() == Link::Empty {
                continue;
            }
            let mut lines = aligned(tree.as_bytes());
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
            let at = 128 + node * 640 + j * 32 + 2 * lane;
            let code = i16::from_le_bytes([bytes[at], bytes[at + 1]]) - 1;
            bytes[at..at + 2].copy_from_slice(&code.to_le_bytes());
            // The width in a link may change with it.
            let Ok(changed) = BvhRef::<Node16<18>>::from_bytes(&bytes[..tree.as_bytes().len()]) else {
                continue;
            };
            let error = changed.verify().unwrap_err();
            assert_eq!([error.node, error.lane, error.plane], [node as u32, lane as u32, j as u32]);
            found += 1;
        }
    }
    assert!(found > 30, "{found}");
}

#[test]
fn damaged_details_are_refused() {
    let tree = baked();
    let (bytes, view) = (tree.as_bytes(), tree.view());
    let count = view.details().len();
    assert!(count >= 4);
    let table = 128 + size_of_val(view.nodes()) + size_of_val(view.normal_slabs());
    let with = |change: &dyn Fn(&mut [Detail])| {
        let mut lines = aligned(bytes);
        let changed: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        change(bytemuck::cast_slice_mut(&mut changed[table..table + 64 * count]));
        BvhRef::<Node16<18>>::from_bytes(&changed[..bytes.len()]).err()
    };
    assert_eq!(with(&|_| ()), None);
    let index_of = |error: Option<FormatError>| match error {
        Some(FormatError::Detail { index, .. }) => index,
        other => panic!("{other:?}"),
    };
    let moved = with(&|d| d[1].first += 1);
    assert!(
        matches!(moved, Some(FormatError::Node { problem: "no link leads to this node", .. })),
        "{moved:?}"
    );
    assert_eq!(index_of(with(&|d| d[0].first -= 1)), 0);
    for (error, at) in [(with(&|d| d[1].node = d[0].node), 1), (with(&|d| d[0].node = 0), 0)] {
        let problem = "it stands for no node, or for one before that of the detail before";
        assert_eq!(error, Some(FormatError::Detail { index: at, problem }));
    }
    assert_eq!(index_of(with(&|d| d[3].node = d[3].first)), 3);
    assert_eq!(index_of(with(&|d| d[1].node += 1)), 1);
    assert_eq!(index_of(with(&|d| d[2].centre[1] = f64::NAN)), 2);
    assert_eq!(index_of(with(&|d| d[2].max_coordinate = 1e300)), 2);
    assert_eq!(index_of(with(&|d| d[2].max_coordinate = d[2].max_coordinate.next_down())), 2);
    assert_eq!(index_of(with(&|d| d[2].exponent += 1)), 2);
    assert_eq!(index_of(with(&|d| d[2].exponent = 1 << 20)), 2);
    assert_eq!(index_of(with(&|d| d[2].half_width[2] = f32::INFINITY)), 2);
    assert_eq!(index_of(with(&|d| d[2].half_width[0] = d[2].half_width[0].next_down())), 2);
    assert_eq!(index_of(with(&|d| d[2].max_plane = f32::NAN)), 2);
    let plane = with(&|d| d[2].max_plane = d[2].max_plane.next_down());
    assert!(
        matches!(plane, Some(FormatError::Node { problem: "a plane is beyond max_plane", .. })),
        "{plane:?}"
    );

    let at = |field: usize, value: u32| {
        let mut lines = aligned(bytes);
        let changed: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        changed[field..field + 4].copy_from_slice(&value.to_le_bytes());
        BvhRef::<Node16<18>>::from_bytes(&changed[..bytes.len()]).err()
    };
    let [detail_count, detail_nodes] =
        [core::mem::offset_of!(Header, detail_count), core::mem::offset_of!(Header, detail_node_count)];
    for error in [at(detail_count, 0), at(detail_count, 1), at(detail_nodes, 0), at(detail_nodes, u32::MAX)] {
        assert!(error.is_some());
    }
}

/// Bytes that are taken although they are damaged are safe to query.
#[test]
fn damaged_details_do_no_harm() {
    let tree = baked();
    let bytes = tree.as_bytes();
    let view = tree.view();
    let first = 128 + view.details()[0].first as usize * 640;
    let table = 128 + size_of_val(view.nodes()) + size_of_val(view.normal_slabs());
    let small = build::<Node16<18>>(&scaled(&torus(6, 5), 1e-3, [0.0; 3]));
    let rng = &mut Rng::new(11);
    let (mut taken, mut refused) = (0, 0);
    for _ in 0..size(400, 60) {
        let mut lines = aligned(bytes);
        let changed: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        let place = if rng.u64().is_multiple_of(2) {
            table + (rng.u64() % (64 * view.details().len() as u64)) as usize
        } else {
            first + (rng.u64() % (128 + size_of_val(view.nodes()) - first) as u64) as usize
        };
        changed[place] = rng.u64() as u8;
        let Ok(tree) = BvhRef::<Node16<18>>::from_bytes(&changed[..bytes.len()]) else {
            refused += 1;
            continue;
        };
        taken += 1;
        for rows in near_corners(&scaled(&torus(6, 5), 1e-3, [0.0; 3]), &room(300), 0.5, 2, rng) {
            let pose = Pose::from_rows(rows).unwrap();
            let mut first = None;
            for isa in Isa::available() {
                let answer = Query::new(isa).collide(&small, &tree, &pose);
                assert_eq!(answer, *first.get_or_insert(answer));
            }
        }
        let _ = tree.verify();
    }
    assert!(taken > 20 && refused > 20, "{taken} taken, {refused} refused");
}
