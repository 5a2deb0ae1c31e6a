//! Builder and baked tree: every plane of every lane equals exact arithmetic, for every node type, leaf size,
//! splitter and difficult mesh. Damaged bytes are always safe.

use crate::support::data::{MeshData, suite_step};
use crate::support::digest::digest_of_tree;
use crate::support::dyadic::{Dyadic, dot, is_rounded_up, is_rounded_up_to_half};
use crate::support::exact::{Tri, meeting_pairs, meshes_meet, triangles_meet};
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::{Line, aligned, mesh_of, pairs_that_meet};
use alloc::collections::BTreeSet;
use simdop::construct::{BuildError, Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::{Bvh, BvhRef, FormatError, Header};
use simdop::isa::Isa;
use simdop::low_level::directions;
use simdop::low_level::key::{Fixed, Key, Storage};
use simdop::node::{Child, Link, Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, Verdict};
use simdop::range::{MAX_COORDINATE, MIN_COORDINATE};
use std::time::Instant;

const SPLITTERS: [Splitter; 5] = [
    Splitter::LongestAxis,
    Splitter::ExtendedLongestAxis,
    Splitter::SurfaceArea,
    Splitter::MeanWidth,
    Splitter::BatchNeuralGas { magnification: Magnification::Area, seed: 1 },
];
const LEAF_SIZES: [u32; 4] = [1, 2, 5, 16];

fn build<N: Lanes>(mesh: &MeshData, leaf_size: u32, splitter: Splitter) -> Bvh<N> {
    Builder::new().leaf_size(leaf_size).splitter(splitter).build_as(&mesh_of(mesh)).unwrap()
}

fn default_build<N: Lanes>(mesh: &MeshData) -> Bvh<N> {
    build(mesh, 1, Splitter::default())
}

// ---- Planes, links and counts -----------------------------------------------------------------------------

/// The exact support of each triangle of a mesh in each direction, in the frame of its tree.
type Supports = Vec<Vec<Dyadic>>;

fn supports(mesh: &MeshData, header: &Header) -> Supports {
    let scale = Dyadic::power_of_two(header.exponent);
    let vectors = directions::table(header.k.into()).vectors;
    let support = |n: &[i8; 3], corners: &Tri| {
        let value = |p: &[f64; 3]| {
            let offset = |i: usize| Dyadic::from(p[i]) - Dyadic::from(header.centre[i]);
            dot(n.map(|x| Dyadic::from(f64::from(x))), [offset(0), offset(1), offset(2)]) * scale.clone()
        };
        corners.iter().map(value).max().unwrap()
    };
    mesh.corners().iter().map(|t| vectors.iter().map(|n| support(n, t)).collect()).collect()
}

/// Traverses a tree, checks each lane's planes against the triangles below it, and counts.
struct Walk<'t, N> {
    tree: BvhRef<'t, N>,
    supports: &'t Supports,
    /// How many leaves contain each triangle of the mesh.
    found: Vec<u32>,
    nodes: u32,
    leaves: u32,
    depth: u32,
}

impl<'t, N: Lanes> Walk<'t, N> {
    fn new(tree: BvhRef<'t, N>, supports: &'t Supports) -> Self {
        let mut walk = Self { tree, supports, found: vec![0; supports.len()], nodes: 0, leaves: 0, depth: 0 };
        if !tree.nodes().is_empty() {
            walk.node(0, 1);
        }
        walk
    }

    /// The greatest support, in each direction, of everything below a node.
    fn node(&mut self, index: u32, level: u32) -> Vec<Dyadic> {
        self.nodes += 1;
        self.depth = self.depth.max(level);
        let node = &self.tree.nodes()[index as usize];
        let mut whole = None;
        for (lane, child) in node.children().iter().enumerate() {
            let below = match child.link() {
                Link::Empty => {
                    assert!((0..N::K).all(|j| node.plane(j, lane) == i16::MIN), "unused lane of {index}");
                    continue;
                }
                Link::Inner(next) => self.node(next, level + 1),
                Link::Leaf { first, count } => self.leaf(first, count),
            };
            for (j, exact) in below.iter().enumerate() {
                let code = node.plane(j, lane);
                assert!(
                    if N::Storage::IS_HALF {
                        is_rounded_up_to_half(code, exact)
                    } else {
                        is_rounded_up(code, exact)
                    },
                    "node {index} lane {lane} plane {j}: {code} for {exact:?}"
                );
            }
            raise(&mut whole, &below);
        }
        whole.expect("a node has a used lane")
    }

    fn leaf(&mut self, first: u32, count: u32) -> Vec<Dyadic> {
        self.leaves += 1;
        assert!(
            (1..=u32::from(self.tree.header().leaf_size)).contains(&count),
            "{count} triangles in a leaf"
        );
        let mut whole = None;
        for index in first..first + count {
            let source = self.tree.source(index) as usize;
            self.found[source] += 1;
            raise(&mut whole, &self.supports[source]);
        }
        whole.expect("a leaf has triangles")
    }
}

fn raise(whole: &mut Option<Vec<Dyadic>>, part: &[Dyadic]) {
    match whole {
        None => *whole = Some(part.to_vec()),
        Some(whole) => whole.iter_mut().zip(part).for_each(|(w, p)| *w = w.clone().max(p.clone())),
    }
}

/// Whether twice the area is exactly zero.
fn has_no_area([a, b, c]: &Tri) -> bool {
    let edge =
        |p: &[f64; 3]| -> [Dyadic; 3] { core::array::from_fn(|i| Dyadic::from(p[i]) - Dyadic::from(a[i])) };
    let (u, v) = (edge(b), edge(c));
    [(1, 2), (2, 0), (0, 1)].iter().all(|&(i, j)| u[i].clone() * v[j].clone() == u[j].clone() * v[i].clone())
}

fn check_tree<N: Lanes>(mesh: &MeshData, supports: &Supports, leaf_size: u32, splitter: Splitter) {
    let what = format!("k {} arity {} leaf {leaf_size} {splitter:?} n {}", N::K, N::ARITY, supports.len());
    let tree = build::<N>(mesh, leaf_size, splitter);
    let view: BvhRef<'_, N> = tree.view();
    view.validate().unwrap_or_else(|e| panic!("{what}: {e}"));
    view.verify().unwrap_or_else(|e| panic!("{what}: {e}"));

    let header = view.header();
    let walk = Walk::new(view, supports);
    assert!(walk.found.iter().all(|&times| times == 1), "{what}: each triangle in one leaf");
    assert_eq!([walk.nodes, walk.depth], [header.node_count, header.depth], "{what}: nodes, levels");
    if leaf_size == 1 {
        let full = walk.leaves.saturating_sub(1).div_ceil(N::ARITY as u32 - 1);
        assert_eq!(walk.nodes, full.max(walk.leaves.min(1)), "{what}: all nodes but one are full");
    }
    let corners = mesh.corners();
    for index in 0..header.primitive_count {
        assert_eq!(view.primitive(index), corners[view.source(index) as usize], "{what}: corners are kept");
    }
    let degenerate = corners.iter().filter(|t| has_no_area(t)).count();
    assert_eq!(header.degenerate_count as usize, degenerate, "{what}: triangles without area");

    let borrowed: BvhRef<'_, N> = BvhRef::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!([borrowed.len(), borrowed.nodes().len()], [view.len(), view.nodes().len()], "{what}");
    let copied = Bvh::<N>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!(copied.as_bytes(), tree.as_bytes(), "{what}");
}

fn check_mesh<N: Lanes>(mesh: &MeshData) {
    // An emulator need not repeat that for all k: the trees are the same, bit for bit.
    if suite_step() > 1 && N::K != 18 {
        return;
    }
    let tree = default_build::<N>(mesh);
    let view: BvhRef<'_, N> = tree.view();
    let supports = supports(mesh, view.header());
    for leaf_size in LEAF_SIZES {
        for splitter in SPLITTERS {
            check_tree::<N>(mesh, &supports, leaf_size, splitter);
        }
    }
}

/// Counts near full leaves and full nodes: 16 and 16^2, and the counts at which another node begins.
#[test]
fn trees_of_any_count_are_exact() {
    let mut rng = Rng::new(1);
    for count in [0, 1, 2, 3, 4, 5, 15, 16, 17, 31, 32, 33, 240, 241, 257] {
        let mesh = shapes::soup(&mut rng, count, 0.1);
        for_each_node!(check_mesh(&mesh));
    }
    if suite_step() == 1 {
        let mesh = shapes::soup(&mut rng, 1000, 0.05);
        for_each_node!(check_mesh(&mesh));
    }
}

#[test]
fn trees_of_awkward_meshes_are_exact() {
    let mut rng = Rng::new(2);
    let mut mixed = shapes::torus(8, 6);
    let flat = shapes::without_area(&mixed, &mut rng, 40);
    shapes::append(&mut mixed, &flat);
    let mut far = shapes::torus(8, 6);
    far.vertices.iter_mut().flatten().for_each(|x| *x += 1e9);
    let mut large = shapes::torus(6, 4);
    large.vertices.iter_mut().flatten().for_each(|x| *x *= MAX_COORDINATE * 0.5);
    let mut small = shapes::torus(6, 4);
    small.vertices.iter_mut().flatten().for_each(|x| {
        *x *= 1024.0 * MIN_COORDINATE;
        *x = if x.abs() < MIN_COORDINATE { 0.0 } else { *x };
    });
    let mut unused = shapes::torus(6, 4);
    unused.vertices.extend([[50.0, -60.0, 70.0], [0.0; 3]]);
    let meshes = [
        shapes::flat_grid(9),
        shapes::collinear(100),
        shapes::huge_among_tiny(&mut rng, 200),
        shapes::torus(12, 9),
        shapes::separate([[[7.0, 8.0, 9.0]; 3]]),
        mixed,
        far,
        large,
        small,
        unused,
    ];
    for mesh in &meshes {
        for_each_node!(check_mesh(mesh));
    }
}

/// No splitter can separate these triangles, so it splits by index: the tree is as deep as any other of that
/// count.
#[test]
fn coincident_triangles_are_split_by_index() {
    let n = 10_000 / suite_step();
    let mesh = shapes::coincident(n);
    check_coincident::<Node16<18>>(&mesh);
    check_coincident::<Node4<6>>(&mesh);
}

fn check_coincident<N: Lanes>(mesh: &MeshData) {
    let tree = build::<N>(mesh, 1, Splitter::ExtendedLongestAxis);
    let view: BvhRef<'_, N> = tree.view();
    let supports = supports(mesh, view.header());
    for splitter in SPLITTERS {
        check_tree::<N>(mesh, &supports, 1, splitter);
    }
    let levels = (mesh.triangles.len() as f64).log(N::ARITY as f64).ceil();
    let depth = f64::from(view.header().depth);
    assert!(depth <= levels + 1.0, "{depth} levels for {} triangles", mesh.triangles.len());
}

#[test]
fn planes_and_links_of_ten_thousand_triangles_stay_within_budget() {
    let mesh = shapes::soup(&mut Rng::new(3), 10_000, 0.01);
    bytes_per_triangle::<Node16<18>>(&mesh, 46.0);
    // An emulator need not repeat that for all k: the trees are the same, bit for bit.
    if cfg!(target_arch = "aarch64") {
        return;
    }
    bytes_per_triangle::<Node16<6>>(&mesh, 20.0);
    bytes_per_triangle::<Node16<14>>(&mesh, 36.0);
    bytes_per_triangle::<Node16<26>>(&mesh, 64.0);
}

fn bytes_per_triangle<N: Lanes>(mesh: &MeshData, budget: f64) {
    for splitter in SPLITTERS {
        let tree = build::<N>(mesh, 1, splitter);
        let view: BvhRef<'_, N> = tree.view();
        let stats = view.stats();
        assert_eq!(stats.node_bytes, size_of_val(view.nodes()));
        let bytes = stats.node_bytes as f64 / stats.primitives as f64;
        println!("k {:2}: {bytes:.2} bytes of planes and links a triangle, {splitter:?}", N::K);
        assert!(bytes <= budget, "k {}: {bytes} bytes a triangle, more than {budget}", N::K);
    }
}

#[test]
fn forty_thousand_triangles() {
    many_triangles(200, 100);
}

#[test]
#[ignore = "seconds"]
fn a_million_triangles() {
    many_triangles(1000, 500);
}

fn many_triangles(around: u32, along: u32) {
    let mesh = shapes::torus(around, along);
    let start = Instant::now();
    let tree = default_build::<Node16<18>>(&mesh);
    let build = start.elapsed();
    let view = tree.view();
    assert_eq!(view.len(), mesh.triangles.len());
    let start = Instant::now();
    view.validate().unwrap();
    let validate = start.elapsed();
    let start = Instant::now();
    view.verify().unwrap();
    println!(
        "{} triangles: built in {build:.2?}, validated in {validate:.2?}, verified in {:.2?}; {:?}",
        view.len(),
        start.elapsed(),
        view.stats()
    );
}

// ---- Input ------------------------------------------------------------------------------------------------

#[test]
fn bad_meshes_are_refused_by_name() {
    let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let triangles = [[0, 1, 2]];
    let good = Mesh { vertices: &vertices, triangles: &triangles };
    let build = |builder: Builder, mesh: Mesh<'_>| builder.build(&mesh).map(|_| ());
    assert_eq!(build(Builder::new(), good), Ok(()));
    for asked in [0, 17, u32::MAX] {
        assert_eq!(build(Builder::new().leaf_size(asked), good), Err(BuildError::LeafSize { asked }));
    }
    let beyond = MAX_COORDINATE * 2.0;
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, beyond, -beyond, MAX_COORDINATE.next_up()] {
        for axis in 0..3 {
            let mut vertices = vertices;
            vertices[1][axis] = bad;
            let mesh = Mesh { vertices: &vertices, ..good };
            assert_eq!(build(Builder::new(), mesh), Err(BuildError::Vertex { index: 1 }), "{bad}");
        }
    }
    for (greatest, want) in
        [(0.0, Ok(())), (MIN_COORDINATE, Ok(())), (MIN_COORDINATE.next_down(), Err(BuildError::TooSmall))]
    {
        let vertices = [[0.0; 3], [-greatest, 0.0, 0.0], [0.0, 5e-324_f64.min(greatest), 0.0]];
        assert_eq!(build(Builder::new(), Mesh { vertices: &vertices, ..good }), want, "{greatest:e}");
    }
    for bad in [3, u32::MAX] {
        let triangles = [[0, 1, 2], [0, 1, bad]];
        let mesh = Mesh { triangles: &triangles, ..good };
        assert_eq!(build(Builder::new(), mesh), Err(BuildError::Primitive { index: 1 }), "{bad}");
    }
    // Zeroed pages that are never accessed: the count is rejected before anything is read.
    #[cfg(target_pointer_width = "64")]
    {
        let count = Child::MAX_PRIMITIVES as usize + 1;
        let triangles = vec![[0; 3]; count];
        let mesh = Mesh { triangles: &triangles, ..good };
        assert_eq!(build(Builder::new(), mesh), Err(BuildError::TooLarge { count }));
    }
}

#[test]
fn the_largest_coordinates_are_accepted() {
    let far = MAX_COORDINATE;
    let mesh = shapes::separate([[[far, -far, far], [-far, far, 0.0], [0.0, 0.0, -far]]]);
    for_each_node!(check_mesh(&mesh));
}

#[test]
fn vertices_are_stored_without_loss() {
    let single = [0.1_f32, -3e38, 1e-40, f32::from_bits(1)].map(f64::from);
    let double = [0.1, 1e39, -1e-46, 1.0 + f64::EPSILON];
    for (values, size) in [(single, 12), (double, 24)] {
        for value in values {
            let corners = [[value, 1.0, 2.0], [0.0, value, 4.0], [5.0, 6.0, value]];
            let tree = default_build::<Node4<6>>(&shapes::separate([corners]));
            let view = tree.view();
            assert_eq!(view.header().vertex_size, size, "{value:e}");
            assert_eq!(view.primitive(0).map(|p| p.map(f64::to_bits)), corners.map(|p| p.map(f64::to_bits)));
        }
    }
}

#[test]
fn coordinates_too_small_for_exact_signs_become_zero() {
    let tiny = MIN_COORDINATE.next_down();
    let corners =
        [[tiny, 1.0, -tiny], [MIN_COORDINATE, -MIN_COORDINATE, -0.0], [f64::from_bits(1), 2.0, 3.0]];
    let kept = [[0.0, 1.0, 0.0], [MIN_COORDINATE, -MIN_COORDINATE, 0.0], [0.0, 2.0, 3.0]];
    let tree = default_build::<Node4<14>>(&shapes::separate([corners]));
    let view = tree.view();
    assert_eq!(view.primitive(0).map(|p| p.map(f64::to_bits)), kept.map(|p| p.map(f64::to_bits)));
    view.validate().unwrap();
    view.verify().unwrap();
}

/// Triangles without area are kept and tested like others, and do not change the verdicts of the others.
#[test]
fn triangles_without_area_change_nobody_elses_verdict() {
    let mut rng = Rng::new(4);
    let proper = shapes::torus(16, 10);
    let mut mixed = proper.clone();
    let flat = shapes::without_area(&proper, &mut rng, 60);
    shapes::append(&mut mixed, &flat);
    let proper_count = proper.triangles.len() as u32;
    let still = mixed.corners();
    let mut both_seen = [false; 2];
    for _ in 0..12 {
        let rotation = rng.rotation();
        let pose = core::array::from_fn(|i| {
            let r = rotation[i];
            [r[0], r[1], r[2], rng.range(-0.8, 0.8)]
        });
        let want: BTreeSet<(u32, u32)> = meeting_pairs(&mixed.placed(&pose), &still)
            .into_iter()
            .map(|(i, j)| (i as u32, j as u32))
            .collect();
        assert_eq!(all_pairs(&mixed, &mixed, &pose), want);
        let among_proper: BTreeSet<_> =
            want.iter().copied().filter(|&(i, j)| i < proper_count && j < proper_count).collect();
        assert_eq!(all_pairs(&proper, &proper, &pose), among_proper);
        both_seen[usize::from(want.len() > among_proper.len())] = true;
    }
    assert!(both_seen[1], "some of the triangles without area were met");
}

fn all_pairs(a: &MeshData, b: &MeshData, pose: &[[f64; 4]; 3]) -> BTreeSet<(u32, u32)> {
    let (a, b) = (build::<Node16<18>>(a, 3, Splitter::default()), build(b, 3, Splitter::default()));
    pairs_that_meet(Query::new(Isa::detect()), &a, &b, &Pose::from_rows(*pose).unwrap()).0
}

// ---- Stored bytes -----------------------------------------------------------------------------------------

/// A change of these digests is a change of the format or of the trees. Increase `VERSION` for the former, and
/// mention both in CHANGELOG.md.
#[test]
fn golden_bytes() {
    let tetrahedron = MeshData {
        vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    };
    let tiny = build::<Node4<6>>(&tetrahedron, 1, Splitter::ExtendedLongestAxis);
    let torus = build::<Node16<18>>(&shapes::torus(24, 16), 1, Splitter::ExtendedLongestAxis);
    let large = build::<Node4<32>>(&shapes::torus(24, 16), 5, Splitter::LongestAxis);
    let got = [tiny.as_bytes(), torus.as_bytes(), large.as_bytes()].map(|b| (b.len(), digest_of_tree(b)));
    println!("{got:#x?}");
    assert_eq!(got, GOLDEN);
}

const GOLDEN: [(usize, u64); 3] =
    [(384, 0x13fd_91a1_ecb0_7ff5), (61_568, 0x6aa2_d524_bda8_781e), (37_184, 0x3fa6_eb73_7b2c_d9f7)];

#[test]
fn bytes_are_refused_by_name() {
    let tree = default_build::<Node16<18>>(&shapes::torus(6, 4));
    let bytes = tree.as_bytes();
    let mut lines = aligned(bytes);
    let buffer: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
    let size = bytes.len();

    for offset in 1..64 {
        buffer[offset..offset + size].copy_from_slice(bytes);
        let moved = &buffer[offset..offset + size];
        assert_eq!(BvhRef::<Node16<18>>::from_bytes(moved).err(), Some(FormatError::Misaligned));
        assert_eq!(
            Bvh::<Node16<18>>::from_bytes(moved).unwrap().as_bytes(),
            bytes,
            "copied to a better place"
        );
        buffer[..size].copy_from_slice(bytes);
    }
    let read = |bytes: &[u8]| BvhRef::<Node16<18>>::from_bytes(bytes).err();
    assert_eq!(read(&buffer[..size]), None);
    for have in 0..size {
        let want = match have {
            0..8 => FormatError::NotATree,
            8..128 => FormatError::Truncated { have, need: 128 },
            _ => FormatError::Truncated { have, need: size },
        };
        assert_eq!(read(&buffer[..have]), Some(want));
        assert_eq!(Bvh::<Node16<18>>::from_bytes(&buffer[..have]).err(), Some(want), "copied");
    }
    for have in size + 1..size + 64 {
        let want = Some(FormatError::TooLong { have, need: size });
        assert_eq!(read(&buffer[..have]), want);
        assert_eq!(Bvh::<Node16<18>>::from_bytes(&buffer[..have]).err(), want, "copied");
    }
    let other = FormatError::OtherNode { k: 18, arity: 16 };
    assert_eq!(BvhRef::<Node16<14>>::from_bytes(&buffer[..size]).err(), Some(other));
    assert_eq!(BvhRef::<Node4<18>>::from_bytes(&buffer[..size]).err(), Some(other));
    buffer[8] = 9;
    assert_eq!(read(&buffer[..size]), Some(FormatError::Version { found: 9 }));
    buffer[0] = b's';
    assert_eq!(read(&buffer[..size]), Some(FormatError::NotATree));
}

/// A caller uses these indices for its own triangles.
#[test]
fn an_index_that_the_mesh_has_not_is_refused() {
    let mesh = shapes::torus(6, 4);
    let count = mesh.triangles.len();
    let mut lines = aligned(default_build::<Node16<18>>(&mesh).as_bytes());
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
    let size = bytes.len() - 64;
    let padding = bytes[..size].iter().rev().take_while(|byte| **byte == 0).count();
    // The sources are the last part. The last source itself ends in zeros.
    let end = (size - padding).next_multiple_of(4);
    for (index, source) in [(count - 1, count as u32), (0, u32::MAX), (count / 2, 1 << 31)] {
        let at = end - 4 * (count - index);
        let before = *bytes[at..].first_chunk::<4>().unwrap();
        bytes[at..at + 4].copy_from_slice(&source.to_le_bytes());
        let want = Some(FormatError::Source { index: index as u32 });
        assert_eq!(BvhRef::<Node16<18>>::from_bytes(&bytes[..size]).err(), want);
        bytes[at..at + 4].copy_from_slice(&before);
    }
    assert!(BvhRef::<Node16<18>>::from_bytes(&bytes[..size]).is_ok());
}

/// The five bits of a link that state the width of its node's volume; for the root they are in the header.
#[test]
fn a_width_that_is_not_of_the_planes_is_refused() {
    widths_are_checked::<Node16<18>>();
    widths_are_checked::<Node4<6>>();
}

fn widths_are_checked<N: Lanes>() {
    let tree = default_build::<N>(&shapes::torus(12, 9));
    let mut lines = aligned(tree.as_bytes());
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
    let size = tree.as_bytes().len();
    let mut refusal = |at: usize, flip: u32| {
        let link = u32::from_le_bytes(*bytes[at..].first_chunk().unwrap());
        bytes[at..at + 4].copy_from_slice(&(link ^ flip << 26).to_le_bytes());
        let found = BvhRef::<N>::from_bytes(&bytes[..size]).err();
        bytes[at..at + 4].copy_from_slice(&link.to_le_bytes());
        found
    };
    let mut links = 0;
    for (index, node) in tree.view().nodes().iter().enumerate() {
        for (lane, child) in node.children().iter().enumerate() {
            if let Link::Inner(_) = child.link() {
                links += 1;
                // A node's links are its last part.
                let at = 128 + (index + 1) * size_of::<N>() - 4 * (N::ARITY - lane);
                for flip in 1..32 {
                    match refusal(at, flip) {
                        Some(FormatError::Node { node, lane: at, problem }) => {
                            assert_eq!((node as usize, at as usize), (index, lane));
                            assert!(problem.contains("width"), "{problem}");
                        }
                        other => panic!("node {index} lane {lane}: {other:?}"),
                    }
                }
            }
        }
    }
    assert_eq!(links + 1, tree.view().nodes().len(), "each node but the root");
    let root = core::mem::offset_of!(Header, root);
    for flip in 1..32 {
        assert_eq!(refusal(root, flip), Some(FormatError::Header { field: "root" }));
    }
    assert_eq!(refusal(root, 0), None, "unchanged");
}

/// The outcomes of damaged bytes.
#[derive(Default, Debug)]
struct Damage {
    refused: u32,
    /// Safe to traverse, but some plane cuts off a triangle.
    accepted: u32,
    /// Safe to traverse, and every plane bounds what is below it.
    proven: u32,
}

/// A valid tree, a pose at which parts of it meet, and one at which none do.
struct Patient<N> {
    tree: Bvh<N>,
    poses: [Pose; 2],
    seen: Damage,
}

impl<N: Lanes> Patient<N> {
    fn new(mesh: &MeshData) -> Self {
        let tree = default_build::<N>(mesh);
        let pose = |x: f64| {
            Pose::from_rows([[0.6, -0.8, 0.0, x], [0.8, 0.6, 0.0, 0.25], [0.0, 0.0, 1.0, 0.125]]).unwrap()
        };
        Self { tree, poses: [pose(0.75), pose(3.0)], seen: Damage::default() }
    }

    /// For any bytes: an error, or a tree on which queries terminate with correct hits; and if it can be
    /// verified, with correct verdicts. If the bytes claim a solid, it need not be closed, so a ray may have
    /// any result.
    fn examine(&mut self, bytes: &[u8]) {
        let Ok(view) = BvhRef::<N>::from_bytes(bytes) else {
            self.seen.refused += 1;
            return;
        };
        let proven = view.verify().is_ok();
        *(if proven { &mut self.seen.proven } else { &mut self.seen.accepted }) += 1;
        let good = self.tree.view();
        for pose in &self.poses {
            for (a, b) in [(&view, &good), (&good, &view)] {
                let moved: Vec<Tri> =
                    (0..a.len()).map(|i| a.primitive(i as u32).map(|p| pose.apply(p))).collect();
                let still: Vec<Tri> = (0..b.len()).map(|i| b.primitive(i as u32)).collect();
                let query = Query::new(Isa::detect());
                let is_solid = a.is_solid() || b.is_solid();
                let distance = query.distance(a, b, pose, 0.1).unwrap();
                let touches = distance.upper == 0.0;
                let is_true = touches == meshes_meet(&moved, &still) || touches && is_solid;
                assert!(!proven || is_true, "{distance:?}");
                let answer = query.collide(a, b, pose);
                match answer.verdict {
                    Verdict::Hit(pair) => {
                        let mut pairs = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j)));
                        let is_it =
                            |i: usize, j: usize| a.source(i as u32) == pair.a && b.source(j as u32) == pair.b;
                        let meets = pairs.any(|(i, j)| is_it(i, j) && triangles_meet(&moved[i], &still[j]));
                        assert!(meets || is_solid, "a false hit: {pair:?}");
                    }
                    Verdict::Free => {
                        assert!(!proven || !meshes_meet(&moved, &still), "a miss in a proven tree");
                    }
                    Verdict::Unknown { .. } => panic!("the budget was not limited"),
                }
            }
        }
    }
}

/// Changes every byte, one at a time, in every way in `flips`.
fn damage_each_byte<N: Lanes>(mesh: &MeshData, flips: impl Iterator<Item = u8> + Clone) {
    let mut patient = Patient::<N>::new(mesh);
    let mut lines = aligned(patient.tree.as_bytes());
    let size = patient.tree.as_bytes().len();
    for at in 0..size {
        for flip in flips.clone() {
            bytemuck::cast_slice_mut::<Line, u8>(&mut lines)[at] ^= flip;
            patient.examine(&bytemuck::cast_slice(&lines)[..size]);
            bytemuck::cast_slice_mut::<Line, u8>(&mut lines)[at] ^= flip;
        }
    }
    println!("k {} arity {}, {size} bytes: {:?}", N::K, N::ARITY, patient.seen);
    let Damage { refused, accepted, proven } = patient.seen;
    assert!(refused > 0 && accepted > 0 && proven > 0, "all three happen: {:?}", patient.seen);
}

#[test]
fn no_changed_byte_does_harm() {
    let tetrahedron = shapes::separate([
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.0, 1.0, 1.0], [1.0, 0.5, 0.5], [0.5, 0.5, 1.0]],
    ]);
    damage_each_byte::<Node4<6>>(&tetrahedron, (1..=255).step_by(suite_step()));
    let bits = || (0..8).step_by(suite_step().min(7)).map(|bit| 1 << bit);
    damage_each_byte::<Node16<18>>(&tetrahedron, bits());
    let doubles = shapes::soup(&mut Rng::new(5), 9, 0.5);
    damage_each_byte::<Node4<14>>(&doubles, bits().chain([0xff]));
}

/// Changes several bytes at a time; some are copies from elsewhere in the tree, and so plausible.
#[test]
fn no_damage_does_harm() {
    let mut rng = Rng::new(6);
    let mut patient = Patient::<Node4<14>>::new(&shapes::soup(&mut rng, 21, 0.4));
    let sound = patient.tree.as_bytes().to_vec();
    for _ in 0..20_000 / suite_step() {
        let mut lines = aligned(&sound);
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        for _ in 0..rng.int(1, 4) {
            let width = *rng.pick(&[1, 2, 4, 8, 12]);
            let place = |rng: &mut Rng| rng.below((sound.len() / width) as u64) as usize * width;
            let (from, to) = (place(&mut rng), place(&mut rng));
            match rng.below(3) {
                0 => bytes.copy_within(from..from + width, to),
                1 => bytes[to..to + width].iter_mut().for_each(|b| *b = rng.u64() as u8),
                _ => bytes[to..to + width].fill(*rng.pick(&[0, 0xff, 0x7f, 0x80])),
            }
        }
        patient.examine(&bytes[..sound.len()]);
    }
    println!("{:?}", patient.seen);
    assert!(patient.seen.accepted + patient.seen.proven > 100, "some of it passes: {:?}", patient.seen);
}

/// `verify` finds a plane that is one step too low, and nothing else does: the tree stays safe to traverse.
#[test]
fn every_plane_that_is_a_step_too_low_is_found() {
    let tree = default_build::<Node4<14>>(&shapes::soup(&mut Rng::new(7), 12, 0.3));
    let mut lines = aligned(tree.as_bytes());
    let (count, size) = (tree.view().nodes().len(), size_of::<Node4<14>>());
    let mut lowered = 0;
    for node in 0..count {
        for lane in (0..4).filter(|&lane| tree.view().nodes()[node].child[lane].link() != Link::Empty) {
            for j in 0..14 {
                let code = tree.view().nodes()[node].planes[j][lane];
                let lower = Key::<Fixed>::from_code(code - 1).unwrap().code();
                let at = 128 + node * size + (j * 4 + lane) * 2;
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
                bytes[at..at + 2].copy_from_slice(&lower.to_le_bytes());
                match BvhRef::<Node4<14>>::from_bytes(&bytes[..tree.as_bytes().len()]) {
                    Ok(view) => {
                        let error = view.verify().unwrap_err();
                        let place = (error.node as usize, error.lane as usize, error.plane as usize);
                        assert_eq!(place, (node, lane, j));
                        lowered += 1;
                    }
                    // The lowest plane of all, lowered, has a greater magnitude than the header states.
                    Err(e) => assert!(matches!(e, FormatError::Node { .. }), "{e}"),
                }
                bytes[at..at + 2].copy_from_slice(&code.to_le_bytes());
            }
        }
    }
    assert!(lowered > count * 14 * 2, "{lowered} planes of {count} nodes");
}
