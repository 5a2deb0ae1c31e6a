//! The splitters that minimise a cost, `SurfaceArea` and `MeanWidth`. For every mesh, their trees hold each
//! triangle once and bound it. They have the same bytes on every machine, and give the same answers as the
//! trees of any other splitter, with fewer visits.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod support;

use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::{Bvh, MAX_DEPTH};
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, QueryStats};
use support::data::{MeshData, Suite, directory, emulator_step, suite_step, suites};
use support::digest::digest_of_tree;
use support::rng::Rng;
use support::shapes;

const SPLITTERS: [Splitter; 2] = [Splitter::SurfaceArea, Splitter::MeanWidth];

fn build<N: Lanes>(mesh: &MeshData, leaf_size: u32, splitter: Splitter) -> Bvh<N> {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Builder::new().leaf_size(leaf_size).splitter(splitter).build_as(&mesh).unwrap()
}

// ---- Every mesh -------------------------------------------------------------------------------------------

fn check_tree<N: Lanes>(what: &str, mesh: &MeshData, leaf_size: u32, splitter: Splitter) {
    let what = format!("{what}, k {} arity {} leaf {leaf_size} {splitter:?}", N::K, N::ARITY);
    let tree = build::<N>(mesh, leaf_size, splitter);
    let view = tree.view();
    view.validate().unwrap_or_else(|e| panic!("{what}: {e}"));
    view.verify().unwrap_or_else(|e| panic!("{what}: {e}"));
    let mut sources: Vec<u32> = (0..view.len() as u32).map(|i| view.source(i)).collect();
    sources.sort_unstable();
    assert!(sources.iter().copied().eq(0..mesh.triangles.len() as u32), "{what}: each triangle once");

    // Full nodes: if every leaf is full, at most one node has unused lanes.
    let stats = view.stats();
    let leaves = mesh.triangles.len().div_ceil(leaf_size as usize);
    let full = leaves.saturating_sub(1).div_ceil(N::ARITY - 1).max(leaves.min(1));
    let nodes = view.header().node_count as usize;
    assert_eq!(nodes, full, "{what}: {nodes} nodes, {full} needed");
    assert!(stats.depth <= MAX_DEPTH, "{what}: {} levels", stats.depth);
}

fn check_mesh(what: &str, mesh: &MeshData) {
    for splitter in SPLITTERS {
        for leaf_size in [1, 2, 5, 16].into_iter().step_by(emulator_step()) {
            check_tree::<Node16<18>>(what, mesh, leaf_size, splitter);
            check_tree::<Node4<6>>(what, mesh, leaf_size, splitter);
        }
    }
}

#[test]
fn trees_of_any_count() {
    let mut rng = Rng::new(1);
    for count in [0, 1, 2, 3, 15, 16, 17, 18, 31, 32, 33, 255, 256, 257, 1023, 1024, 1025, 1041, 3000] {
        check_mesh(&format!("{count} random"), &shapes::soup(&mut rng, count, 0.1));
    }
}

#[test]
fn trees_of_awkward_meshes() {
    let mut rng = Rng::new(2);
    let n = 3000 / suite_step();
    check_mesh("collinear", &shapes::collinear(n));
    check_mesh("planar", &shapes::flat_grid(40));
    check_mesh("one huge among tiny", &shapes::huge_among_tiny(&mut rng, n));
    check_mesh("growing", &growing(900));
    let mut half = shapes::coincident(n / 2);
    shapes::append(&mut half, &shapes::soup(&mut rng, n / 2, 0.01));
    check_mesh("half coincident", &half);
}

/// Each triangle is twice as far out and twice as large as the last one, up to the range of coordinates; then
/// the sequence repeats.
fn growing(n: usize) -> MeshData {
    let at = |i: usize| {
        let size = f64::from(2.0_f32).powi((i % 300) as i32 - 50);
        [[size, 0.0, 0.0], [1.5 * size, 0.5 * size, 0.0], [size, 0.0, 0.5 * size]]
    };
    shapes::separate((0..n).map(at))
}

/// No splitter can separate these triangles.
#[test]
fn a_hundred_thousand_coincident_triangles() {
    let mesh = shapes::coincident(100_000 / suite_step());
    for splitter in SPLITTERS {
        check_tree::<Node16<6>>("coincident", &mesh, 1, splitter);
        check_tree::<Node4<6>>("coincident", &mesh, 3, splitter);
    }
}

// ---- The same bytes on every machine ----------------------------------------------------------------------

/// The trees of a generated mesh, byte for byte. A change of the splitter or of the format changes them.
#[test]
fn trees_have_the_bytes_written_here() {
    let mut mesh = shapes::torus(60, 40);
    shapes::append(&mut mesh, &shapes::soup(&mut Rng::new(3), 2000, 0.02));
    let digests = |splitter| {
        let wide = build::<Node16<18>>(&mesh, 1, splitter);
        let narrow = build::<Node4<14>>(&mesh, 2, splitter);
        [digest_of_tree(wide.as_bytes()), digest_of_tree(narrow.as_bytes())]
    };
    let got = SPLITTERS.map(digests);
    assert_eq!(got, GOLDEN, "should be {got:#018x?}");
}

const GOLDEN: [[u64; 2]; 2] =
    [[0x130d_d1d7_8767_149b, 0x8bd3_74fb_608e_de7d], [0x2fed_ed3f_e36e_3d4b, 0xe0bd_5679_7ea5_f52a]];

// ---- Queries ----------------------------------------------------------------------------------------------

/// The sums over the poses of a suite, by verdict: free, hit.
fn stats<N: Lanes>(suite: &Suite, poses: &[Pose], splitter: Splitter) -> (Vec<bool>, [QueryStats; 2]) {
    let (a, b) = (build::<N>(&suite.a, 1, splitter), build::<N>(&suite.b, 1, splitter));
    let mut sums = [QueryStats::default(); 2];
    let verdict = |pose| {
        let answer = Query::new(Isa::detect()).collide(&a.view(), &b.view(), pose);
        let sum = &mut sums[usize::from(answer.hit().is_some())];
        sum.visits += answer.stats.visits;
        sum.kernels += answer.stats.kernels;
        sum.primitive_pairs += answer.stats.primitive_pairs;
        answer.hit().is_some()
    };
    (poses.iter().map(verdict).collect(), sums)
}

fn poses(suite: &Suite) -> Vec<Pose> {
    let [a, b] = [&suite.a, &suite.b].map(|mesh| build::<Node16<18>>(mesh, 1, Splitter::ExtendedLongestAxis));
    let pose = |rows: &[[f64; 4]; 3]| Pose::from_rows(*rows).unwrap();
    let meets =
        |rows: &_| Query::new(Isa::detect()).collide(&a.view(), &b.view(), &pose(rows)).hit().is_some();
    suite.poses(suite_step(), meets).iter().map(pose).collect()
}

#[test]
fn answers_are_those_of_other_splitters() {
    let Some(suites) = suites() else { return };
    for suite in &suites {
        let poses = poses(suite);
        let (want, _) = stats::<Node16<18>>(suite, &poses, Splitter::ExtendedLongestAxis);
        for splitter in SPLITTERS {
            assert!(want == stats::<Node16<18>>(suite, &poses, splitter).0, "{}", suite.name);
            assert!(want == stats::<Node4<26>>(suite, &poses, splitter).0, "{}", suite.name);
        }
    }
}

/// The benefit of the longer build.
#[test]
fn mean_width_needs_fewer_visits() {
    let Some(data) = directory() else { return };
    for name in ["cow", "camel"] {
        let mesh = MeshData::obj(&data.join("meshes").join(name).with_extension("obj"));
        let suite = Suite { name, a: mesh.clone(), b: mesh };
        let poses = poses(&suite);
        let sums = |splitter| stats::<Node16<18>>(&suite, &poses, splitter).1;
        let (halved, by_cost) = (sums(Splitter::ExtendedLongestAxis), sums(Splitter::MeanWidth));
        for (verdict, halved, by_cost) in [("free", halved[0], by_cost[0]), ("hit", halved[1], by_cost[1])] {
            println!("{name}, {verdict}: {halved:?} by halving, {by_cost:?} by mean width");
            assert!(by_cost.visits < halved.visits, "{name}, {verdict}: visits");
            assert!(by_cost.kernels < halved.kernels, "{name}, {verdict}: kernels");
        }
    }
}
