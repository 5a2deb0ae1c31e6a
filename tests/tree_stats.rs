//! `TreeStats` of trees whose values are computed by hand, and of trees that must differ.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod support;

use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::TreeStats;
use simdop::node::{Dop, Node4, Node16};
use support::data::MeshData;
use support::shapes;

fn stats_by<N: Dop>(mesh: &MeshData, splitter: Splitter) -> TreeStats {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Builder::new().splitter(splitter).build_as::<N>(&mesh).unwrap().view().tree_stats()
}

fn stats<N: Dop>(mesh: &MeshData) -> TreeStats {
    stats_by::<N>(mesh, Splitter::ExtendedLongestAxis)
}

/// Triangles whose boxes are unit cubes, with their low corners at `places` on the x axis.
fn cubes(places: &[f64]) -> MeshData {
    shapes::separate(places.iter().map(|&x| [[x, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x + 1.0, 1.0, 1.0]]))
}

#[track_caller]
fn assert_close(got: f64, want: f64) {
    assert!((got - want).abs() <= 1e-12 * want.abs(), "{got}, should be {want}");
}

#[test]
fn nothing_and_one() {
    let zero =
        TreeStats { expected_visits: 0.0, area_ratio: 0.0, overlap: 0.0, lanes_used: 0.0, mean_depth: 0.0 };
    assert_eq!(stats::<Node16<18>>(&cubes(&[])), zero);
    let one =
        TreeStats { expected_visits: 1.0, area_ratio: 1.0, overlap: 0.0, lanes_used: 0.25, mean_depth: 1.0 };
    assert_eq!(stats::<Node4<6>>(&cubes(&[3.0])), one);
}

/// The root has three leaves and a node with two. Its box is 31.5 x 1 x 1: S = 128, m = 33.5, V = 31.5. The
/// node's is 1.5 x 1 x 1: S = 8, m = 3.5, V = 1.5. A leaf's is a unit cube: S = 6, m = 3, V = 1.
#[test]
fn two_levels() {
    let got = stats::<Node4<14>>(&cubes(&[0.0, 10.0, 20.0, 30.0, 30.5]));
    let roots = 4.0 * (31.5 + 31.5) + 128.0 * 33.5 + 128.0 * 33.5;
    let nodes = 4.0 * (1.5 + 1.5) + 8.0 * 3.5 + 8.0 * 3.5;
    let leaf_and_node = 4.0 * (1.0 + 1.5) + 6.0 * 3.5 + 8.0 * 3.0;
    assert_close(got.expected_visits, 1.0 + (nodes + 2.0 * 3.0 * leaf_and_node) / roots);
    // For the root (3 x 6 + 8) / 128, for the node (6 + 6) / 8.
    assert_close(got.area_ratio, 0.5 * (26.0 / 128.0 + 12.0 / 8.0));
    // The root's lanes do not overlap; the node's share 0.5 of 2.
    assert_close(got.overlap, 0.5 * (0.0 + 0.25));
    assert_close(got.lanes_used, 6.0 / 8.0);
    assert_close(got.mean_depth, (3.0 * 1.0 + 2.0 * 2.0) / 5.0);
}

/// A leaf meets the nodes of every lower level: in a chain of three nodes, also the third.
#[test]
fn leaves_meet_deeper_nodes() {
    let got = stats::<Node4<6>>(&cubes(&[0.0; 8]));
    // All coincide, so every pair meets. With eight leaves the root has 2 leaves and 2 nodes of three lanes, or
    // 3 leaves and a node of four lanes that has a node of two. Either way the depths determine the value.
    let deep = (got.mean_depth * 8.0).round();
    let want = if deep == 14.0 { 1.0 + (4.0 + 2.0 * 4.0) } else { 1.0 + (1.0 + 6.0) + (1.0 + 12.0) };
    assert_close(got.expected_visits, want);
}

/// Nothing has an area: every pair counts as meeting.
#[test]
fn without_area_every_pair_meets() {
    let segment = |i: u32| [0.0, 1.0, 3.0].map(|x| [f64::from(i) + x, 0.0, 0.0]);
    let got = stats::<Node16<6>>(&shapes::separate((0..17).map(segment)));
    // 15 leaves and a node with two leaves.
    assert_eq!(got.expected_visits, 1.0 + (1.0 + 2.0 * 15.0));
    assert_eq!((got.area_ratio, got.overlap), (0.0, 0.0));
}

/// The better tree has the lower values.
#[test]
fn slices_are_worse_than_clusters() {
    let mesh = shapes::torus(100, 37);
    let [slices, halves, clusters] =
        [Splitter::LongestAxis, Splitter::ExtendedLongestAxis, Splitter::MeanWidth]
            .map(|splitter| stats_by::<Node16<18>>(&mesh, splitter));
    println!("{slices:?}\n{halves:?}\n{clusters:?}");
    assert!(slices.expected_visits > halves.expected_visits);
    assert!(halves.expected_visits > clusters.expected_visits);
}
