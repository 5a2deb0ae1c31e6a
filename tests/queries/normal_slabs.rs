//! Normal slabs: they bound what is below them, and tightly; damaged ones are rejected; they change no verdict;
//! and they save work.

use crate::support::data::{Approach, MeshData, suite_step};
use crate::support::dyadic::{Dyadic, dot};
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::{HalfNode, Line, aligned, pairs_that_meet};
use alloc::collections::BTreeSet;
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::{Bvh, BvhRef, FormatError, Header, Lane};
use simdop::isa::Isa;
use simdop::node::{Link, Node4, Node16, NormalSlab};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};

fn build<N: Lanes>(builder: Builder, mesh: &MeshData) -> Bvh<N> {
    builder.build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

/// A used lane, its slab, and the primitives below it by their indices in leaf order.
struct Volume {
    node: u32,
    lane: usize,
    slab: NormalSlab,
    below: Vec<u32>,
}

fn volumes<N: Lanes>(tree: &BvhRef<'_, N>) -> Vec<Volume> {
    let places = tree.nodes().len() * N::ARITY;
    let mut below = vec![Vec::new(); places];
    let mut walk = tree.walk();
    while let Some(Lane { child, .. }) = walk.next() {
        let Link::Leaf { first, count } = child.link() else { continue };
        for (node, lane) in walk.path() {
            below[node as usize * N::ARITY + lane].extend(first..first + count);
        }
    }
    assert_eq!(tree.normal_slabs().len(), places);
    let volume = |(place, below): (usize, Vec<u32>)| Volume {
        node: (place / N::ARITY) as u32,
        lane: place % N::ARITY,
        slab: tree.normal_slabs()[place],
        below,
    };
    below.into_iter().enumerate().map(volume).filter(|v| !v.below.is_empty()).collect()
}

/// The exact least and greatest support of a primitive along n, in the frame of its tree.
fn supports<N: Lanes>(tree: &BvhRef<'_, N>, n: [f64; 3], primitive: u32) -> [Dyadic; 2] {
    let frame = tree.frame();
    let along = |p: [f64; 3]| {
        let offset = |i: usize| Dyadic::from(p[i]) - Dyadic::from(frame.centre[i]);
        dot(n.map(Dyadic::from), [offset(0), offset(1), offset(2)]) * Dyadic::power_of_two(frame.exponent)
    };
    let all = tree.primitive(primitive).map(along);
    [all.iter().min().unwrap().clone(), all.iter().max().unwrap().clone()]
}

/// Meshes of every kind that is difficult for slabs.
fn meshes() -> Vec<MeshData> {
    let mut rng = Rng::new(1);
    let scaled = |mut mesh: MeshData, factor: f64, offset: f64| {
        mesh.vertices.iter_mut().flatten().for_each(|x| *x = *x * factor + offset);
        mesh
    };
    let mut mixed = shapes::torus(6, 5);
    let flat = shapes::without_area(&mixed, &mut rng, 20);
    shapes::append(&mut mixed, &flat);
    vec![
        shapes::separate([]),
        shapes::soup(&mut rng, 70, 0.3),
        shapes::flat_grid(6),
        shapes::torus(8, 6),
        mixed,
        shapes::coincident(20),
        shapes::collinear(20),
        shapes::separate([[[7.0, 8.0, 9.0]; 3]]),
        shapes::huge_among_tiny(&mut rng, 40),
        scaled(shapes::torus(6, 4), 1.0, 1e9),
        scaled(shapes::torus(6, 4), 1e-60, 0.0),
        scaled(shapes::torus(6, 4), 1e80, 3e80),
    ]
}

// ---- The slabs themselves ---------------------------------------------------------------------------------

/// The slabs bound, and are tight: within two steps, plus the rounding of the thickness, of the exact extent
/// along their own direction.
fn slabs_are_exact<N: Lanes>(meshes: &[MeshData]) {
    for (number, mesh) in meshes.iter().enumerate() {
        for leaf_size in [1, 3] {
            let what = format!("k {} arity {}, mesh {number}", N::K, N::ARITY);
            let tree = build::<N>(Builder::new().leaf_size(leaf_size), mesh);
            let tree = tree.view();
            tree.verify().unwrap_or_else(|e| panic!("{what}: {e}"));
            let step = 8.0;
            for Volume { node, lane, slab, below } in volumes(&tree) {
                let n = slab.normal();
                assert!(n[2] >= 0.0 && n.iter().map(|x| x.abs()).sum::<f64>() == 2047.0, "{what}: {n:?}");
                let all: Vec<_> = below.iter().map(|&p| supports(&tree, n, p)).collect();
                let low = all.iter().map(|s| &s[0]).min().unwrap().clone();
                let high = all.iter().map(|s| &s[1]).max().unwrap().clone();
                let degenerate = slab.ends()[1] == f64::INFINITY;
                if degenerate {
                    // Triangles without area have no normal.
                    assert!(number != 1 && number != 2 && number != 3, "{what}: node {node} lane {lane}");
                    continue;
                }
                let [least, greatest] = slab.ends().map(Dyadic::from);
                assert!(least <= low && greatest >= high, "{what}: node {node} lane {lane}");
                let slack = [low.clone() - least, greatest - high.clone()];
                let loose = Dyadic::from(2.0 * step) + (high - low) * Dyadic::from(0.002);
                assert!(
                    slack[0] <= Dyadic::from(2.0 * step) && slack[1] <= loose,
                    "{what}: node {node} lane {lane}"
                );
            }
        }
    }
}

#[test]
fn slabs_bound_what_is_below_and_no_more() {
    let meshes = meshes();
    for_each_node!(slabs_are_exact(&meshes));
}

/// The byte offset of a slab in its tree.
fn place<N: Lanes>(tree: &BvhRef<'_, N>, node: u32, lane: usize) -> usize {
    128 + size_of_val(tree.nodes()) + 8 * (node as usize * N::ARITY + lane)
}

/// The tree with other bits in one slab.
fn edited<N: Lanes>(tree: &Bvh<N>, at: usize, edit: impl FnOnce(u64) -> u64) -> Vec<Line> {
    let mut lines = aligned(tree.as_bytes());
    let field: &mut [u8; 8] = (&mut bytemuck::cast_slice_mut(&mut lines)[at..at + 8]).try_into().unwrap();
    *field = edit(u64::from_le_bytes(*field)).to_le_bytes();
    lines
}

fn tree_in<N: Lanes>(lines: &[Line]) -> Result<BvhRef<'_, N>, FormatError> {
    // Without the spare line.
    BvhRef::from_bytes(bytemuck::cast_slice(&lines[..lines.len() - 1]))
}

/// A slab that is one step thinner at either end is rejected exactly where it cuts something off, and the error
/// names the plane.
fn thinner_is_refused<N: Lanes>(meshes: &[MeshData]) {
    // An emulator need not repeat that for all k: the rejected slabs are the same.
    if suite_step() > 1 && N::K != 18 {
        return;
    }
    let (mut refused, mut accepted) = ([0, 0], 0);
    for mesh in meshes {
        let owned = build::<N>(Builder::new(), mesh);
        let tree = owned.view();
        for Volume { node, lane, slab, below } in volumes(&tree) {
            if slab.ends()[1] == f64::INFINITY {
                continue;
            }
            let edits: [fn(u64) -> u64; 2] =
                [|bits| bits.wrapping_add(1 << 40), |bits| bits.wrapping_sub(1 << 24)];
            for (end, edit) in edits.into_iter().enumerate() {
                let lines = edited(&owned, place(&tree, node, lane), edit);
                let thin = tree_in::<N>(&lines).unwrap();
                let ends = thin.normal_slabs()[node as usize * N::ARITY + lane].ends();
                assert!(if end == 0 { ends[0] > slab.ends()[0] } else { ends[1] < slab.ends()[1] });
                let beyond = |p: u32| {
                    let [low, high] = supports(&thin, slab.normal(), p);
                    if end == 0 { low < Dyadic::from(ends[0]) } else { high > Dyadic::from(ends[1]) }
                };
                let cut_off: BTreeSet<u32> =
                    below.iter().filter(|&&p| beyond(p)).map(|&p| tree.source(p)).collect();
                match thin.verify() {
                    Ok(()) => {
                        assert!(cut_off.is_empty(), "k {}: node {node} lane {lane} end {end}", N::K);
                        accepted += 1;
                    }
                    Err(e) => {
                        assert_eq!((e.node, e.lane as usize, e.plane as usize), (node, lane, N::K + end));
                        assert!(cut_off.contains(&e.primitive), "{e}");
                        refused[end] += 1;
                    }
                }
            }
        }
    }
    assert!(refused[0] > 50 && refused[1] > 50 && accepted > 10, "{refused:?} {accepted}");
}

#[test]
fn slabs_one_step_thinner_are_refused() {
    let mut rng = Rng::new(2);
    let meshes = [shapes::torus(8, 6), shapes::soup(&mut rng, 40, 0.3), shapes::flat_grid(6)];
    for_each_node!(thinner_is_refused(&meshes));
}

/// Every way in which a slab's 64 bits can be invalid, in a used and in an unused lane.
fn bad_bits_are_refused<N: Lanes>(mesh: &MeshData) {
    let owned = build::<N>(Builder::new(), mesh);
    let tree = owned.view();
    // |x| + |y| of 2048, in three ways; a thickness of -0, below 0, NaN, and negative NaN.
    let normal = |x: i64, y: i64| (x as u64 & 0xfff) | (y as u64 & 0xfff) << 12;
    let bad = [
        (0xff_ffff, normal(1024, 1024)),
        (0xff_ffff, normal(-2048, 0)),
        (0xff_ffff, normal(0, -2048)),
        (0xff_ffff, normal(-2047, -1)),
        (0xffff << 24, 0xffff << 24),
        (0xffff << 24, 0x8000 << 24),
        (0xffff << 24, 0x7c01 << 24),
        (0xffff << 24, 0x7fff << 24),
    ];
    let good = [
        (0xff_ffff, normal(1024, -1023)),
        (0xff_ffff, normal(-2047, 0)),
        (0xffff << 24, 0x7c00 << 24),
        (0xffff << 24, 0),
        (0xff_ffff << 40, 0x80_0000 << 40),
    ];
    let last = tree.nodes().len() as u32 - 1;
    for (node, lane) in [(0, 0), (0, N::ARITY - 1), (last, 0), (last, N::ARITY - 1)] {
        let at = place(&tree, node, lane);
        for (mask, bits) in bad {
            let lines = edited(&owned, at, |was| was & !mask | bits);
            let problem = "a normal slab has no direction, or no thickness";
            let want = FormatError::Node { node, lane: lane as u32, problem };
            assert_eq!(tree_in::<N>(&lines).err(), Some(want), "{bits:x}");
        }
        for (mask, bits) in good {
            let lines = edited(&owned, at, |was| was & !mask | bits);
            assert!(tree_in::<N>(&lines).is_ok(), "{bits:x}");
        }
    }
}

#[test]
fn bits_that_are_no_slab_are_refused() {
    let mesh = shapes::torus(5, 3);
    for_each_node!(bad_bits_are_refused(&mesh));
}

/// The offset of the flag of normal slabs in the header.
const FLAG: usize = core::mem::offset_of!(Header, has_normal_slabs);

#[test]
fn the_flag_must_be_true() {
    let mesh = shapes::torus(8, 6);
    let with = build::<Node16<18>>(Builder::new(), &mesh);
    let without = build::<Node16<18>>(Builder::new().without_normal_slabs(), &mesh);
    let need = |tree: &Bvh<Node16<18>>| tree.as_bytes().len();
    assert!(need(&without) < need(&with));
    let flagged = |tree: &Bvh<Node16<18>>, was: u8, flag: u8| {
        let mut lines = aligned(tree.as_bytes());
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        assert_eq!((bytes[FLAG], bytes[FLAG + 1]), (was, 0));
        bytes[FLAG] = flag;
        tree_in::<Node16<18>>(&lines).err()
    };
    let (have, shorter) = (need(&with), need(&without));
    assert_eq!(flagged(&with, 1, 0), Some(FormatError::TooLong { have, need: shorter }));
    assert_eq!(flagged(&without, 0, 1), Some(FormatError::Truncated { have: shorter, need: have }));
    assert_eq!(flagged(&with, 1, 2), Some(FormatError::Header { field: "has_normal_slabs" }));
    let slabs = size_of_val(with.view().normal_slabs());
    let lines = aligned(with.as_bytes());
    for end in [0, 8, slabs - 8, slabs] {
        let cut = 128 + size_of_val(with.view().nodes()) + end;
        let error = BvhRef::<Node16<18>>::from_bytes(&bytemuck::cast_slice(&lines)[..cut]).err();
        assert_eq!(error, Some(FormatError::Truncated { have: cut, need: have }));
    }
}

/// A tree without slabs has the bytes of the tree with them, except for the slabs and the flag.
fn less_the_slabs<N: Lanes>(meshes: &[MeshData]) {
    for mesh in meshes {
        let with = build::<N>(Builder::new(), mesh);
        let without = build::<N>(Builder::new().without_normal_slabs(), mesh);
        without.view().verify().unwrap();
        assert_eq!(without.view().normal_slabs(), []);
        let (stats, other) = (with.view().stats(), without.view().stats());
        assert_eq!(stats.normal_slab_bytes, 8 * N::ARITY * stats.nodes);
        assert_eq!((other.normal_slab_bytes, other.node_bytes), (0, stats.node_bytes));
        let slabs = 128 + stats.node_bytes..128 + stats.node_bytes + stats.normal_slab_bytes;
        let mut expected = with.as_bytes().to_vec();
        expected.drain(slabs);
        expected[FLAG] = 0;
        // Both are padded to a multiple of 64.
        let len = without.as_bytes().len().min(expected.len());
        assert_eq!(without.as_bytes()[..len], expected[..len]);
        let rest = without.as_bytes()[len..].iter().chain(&expected[len..]);
        assert!(rest.clone().count() < 64 && rest.clone().all(|byte| *byte == 0));
    }
}

#[test]
fn a_tree_without_slabs_is_the_same_but_for_them() {
    let meshes = meshes();
    for_each_node!(less_the_slabs(&meshes));
}

// ---- Long queries -----------------------------------------------------------------------------------------

/// A torus with waves along and around its tube, smooth: 2 n^2 triangles.
fn wavy_torus(n: u32) -> MeshData {
    let mut mesh = shapes::torus(n, n);
    for p in &mut mesh.vertices {
        let [x, y, z] = *p;
        // Cosine and sine of five times the angle about the axis, by powers of a complex number.
        let length = (x * x + y * y).sqrt();
        let (c, s) = (x / length, y / length);
        let (mut re, mut im) = (1.0, 0.0);
        for _ in 0..5 {
            (re, im) = (re * c - im * s, re * s + im * c);
        }
        let (out, wave) = ((length - 1.0) * (1.0 + 0.3 * re), 0.15 * im);
        *p = [(2.0 + 2.0 * out) * c, (2.0 + 2.0 * out) * s, 2.0 * (z + wave)];
    }
    mesh
}

/// Poses of a body against itself, in contact except for a gap.
fn poses<N: Lanes>(mesh: &MeshData, tree: &Bvh<N>, gap: f64, count: usize) -> Vec<Pose> {
    let mut rng = Rng::new(3);
    let query = Query::new(Isa::detect());
    let size = mesh.diagonal();
    let mut found = Vec::new();
    while found.len() < count {
        let (rotation, towards) = (rng.rotation(), rng.rotation()[0]);
        let line = Approach { rotation, target: mesh.centre(), towards, centre: mesh.centre() };
        let at = |distance: f64| Pose::from_rows(line.at(distance)).unwrap();
        let meets = |distance: f64| !query.collide(tree, tree, &at(distance)).is_free();
        let (mut inside, mut outside) = (0.0, 2.0 * size);
        for i in (0..100).rev() {
            let distance = 2.0 * size * f64::from(i) / 100.0;
            if meets(distance) {
                inside = distance;
                break;
            }
            outside = distance;
        }
        for _ in 0..30 {
            let middle = 0.5 * (inside + outside);
            if meets(middle) { inside = middle } else { outside = middle }
        }
        found.push(at(outside + gap * size));
    }
    found
}

/// The total visits of all poses for the collision of a tree with itself.
fn visits<N: Lanes>(tree: &Bvh<N>, poses: &[Pose]) -> u64 {
    let query = Query::new(Isa::detect());
    let visits = |pose: &Pose| {
        let answer = query.collide(tree, tree, pose);
        assert!(answer.is_free());
        answer.stats.visits
    };
    poses.iter().map(visits).sum()
}

/// Both trees of a torus of 2 n^2 triangles, with slabs and without, and poses with a gap of a thousandth.
fn near_tori(n: u32) -> [u64; 2] {
    let mesh = wavy_torus(n);
    let builder = Builder::fast();
    let with = build::<Node16<18>>(builder, &mesh);
    let without = build::<Node16<18>>(builder.without_normal_slabs(), &mesh);
    let poses = poses(&mesh, &with, 1e-3, 40);
    let found = [visits(&with, &poses), visits(&without, &poses)];
    println!(
        "{} triangles: {} visits a pose with slabs, {} without",
        2 * n * n,
        found[0] / 40,
        found[1] / 40
    );
    found
}

#[test]
#[ignore = "meshes of 80,000 triangles and more"]
fn near_smooth_bodies_take_half_the_visits() {
    let [coarse, fine, finest] = [100, 200, 400].map(near_tori);
    assert!(10 * fine[0] <= 6 * fine[1], "{fine:?}");
    assert!(10 * finest[0] <= 16 * coarse[0], "{coarse:?} {finest:?}");
}

/// Long queries of trees with slabs, with slabs in one tree only, and without: the same answers on every
/// instruction set, with the same work.
fn answers_agree<N: Lanes>(mesh: &MeshData) {
    let builder = Builder::new().splitter(Splitter::ExtendedLongestAxis);
    let with = build::<N>(builder, mesh);
    let without = build::<N>(builder.without_normal_slabs(), mesh);
    let (mut long, mut spared) = (0, 0);
    for (gap, margin) in [(1e-3, 0.0), (1e-3, 2e-3), (-1e-3, 1e-4), (-2e-2, 1e-4)] {
        for pose in poses(mesh, &with, gap, 8 / suite_step()) {
            let (want, without_slabs) = pairs_that_meet(Query::new(Isa::SCALAR), &without, &without, &pose);
            assert_eq!(want.is_empty(), gap > 0.0);
            for (a, b) in [(&with, &with), (&with, &without), (&without, &with)] {
                let (found, stats) = pairs_that_meet(Query::new(Isa::SCALAR), a, b, &pose);
                assert_eq!(found, want, "k {} arity {}: {pose:?}", N::K, N::ARITY);
                let both = core::ptr::eq(a, b);
                if !both {
                    assert_eq!(stats, without_slabs, "slabs are asked where both trees have them");
                }
                long += usize::from(both && stats.visits > 100);
                spared += usize::from(stats.visits < without_slabs.visits);
                let margin = margin * mesh.diagonal();
                let near = Query::new(Isa::SCALAR).within(a, b, &pose, margin).unwrap();
                let expected = Query::new(Isa::SCALAR).within(&without, &without, &pose, margin).unwrap();
                assert_eq!(near.is_free(), expected.is_free());
                for isa in Isa::available() {
                    assert_eq!(
                        pairs_that_meet(Query::new(isa), a, b, &pose),
                        (found.clone(), stats),
                        "{isa:?}"
                    );
                    let on = Query::new(isa).within(a, b, &pose, margin).unwrap();
                    assert_eq!((on.verdict, on.stats), (near.verdict, near.stats), "{isa:?}");
                }
            }
        }
    }
    // The small suite has four poses, and none of them need be long.
    let is_long = long > 0 || suite_step() > 1;
    assert!(is_long && spared > 0, "k {} arity {}: {long} were long, {spared} shorter", N::K, N::ARITY);
}

#[test]
fn long_queries_agree_with_and_without_slabs() {
    // Each is compiled for every instruction set. `tests/queries/mesh_poses.rs` has all node types.
    let mesh = wavy_torus(if suite_step() > 1 { 30 } else { 60 });
    #[cfg(simdop_all_nodes)]
    {
        answers_agree::<Node16<6>>(&mesh);
        answers_agree::<Node16<32>>(&mesh);
    }
    answers_agree::<Node16<18>>(&mesh);
    answers_agree::<HalfNode>(&mesh);
    answers_agree::<Node4<14>>(&mesh);
}
