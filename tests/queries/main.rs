//! All tests of queries in one program, so that the queries of each node type and instruction set are compiled
//! once, and not once for each file. A file's tests have the name of its module:
//! `cargo test --profile suite --test queries distance::`.
//!
//! Compiling them takes most of the time. So the tests run on three node types: the default one, one of half
//! floats, and one of arity 4. `RUSTFLAGS="--cfg simdop_all_nodes"` adds the others: `.ci/sweep nodes`.

extern crate alloc;

#[path = "../support/columns.rs"]
mod columns;
#[path = "../support/judged.rs"]
mod judged;
#[path = "../support/lens.rs"]
mod lens;
#[path = "../support/one_point.rs"]
mod one_point;
#[path = "../support/mod.rs"]
mod support;

/// Half floats, and the most planes that a type-erased tree has.
type HalfNode = simdop::node::Node16<26, simdop::low_level::key::Half>;

/// Calls a generic function with the arguments, once for each node type.
macro_rules! for_each_node {
    ($function:ident($($argument:expr),*)) => {
        for_each_node!(@ $function ($($argument),*)
            Node16<18>, crate::HalfNode, Node4<14>);
        #[cfg(simdop_all_nodes)]
        for_each_node!(@ $function ($($argument),*)
            Node16<6>, Node16<14>, Node16<26>, Node16<32>, Node4<6>, Node4<18>, Node4<26>, Node4<32>,
            Node16<14, simdop::low_level::key::Half>, Node16<18, simdop::low_level::key::Half>,
            Node4<18, simdop::low_level::key::Half>)
    };
    (@ $function:ident $arguments:tt $($node:ty),*) => { $( $function::<$node> $arguments; )* };
}

mod allocations;
mod assignments;
mod balls;
mod caps;
mod classify_pair;
mod counters;
mod digests;
mod distance;
mod edge;
mod far;
mod hierarchy;
mod hints;
mod many;
mod mesh_poses;
mod motion;
mod normal_slabs;
mod order;
mod owned_and_any;
mod penetration;
mod primitive_slabs;
mod primitives;
mod reject;
mod scene;
mod sizes;
mod solid;
mod solids;
mod spheres;
mod stack;
mod storage;
mod threads;
mod two_bodies;
mod world;

use alloc::collections::BTreeSet;
use core::ops::ControlFlow;
use simdop::construct::{Builder, Magnification, Mesh, Splitter};
use simdop::hierarchy::{AsBvh, Bvh, BvhRef};
use simdop::pose::Pose;
use simdop::query::{Completion, Lanes, Pair, PrimitivePair, Query, QueryStats};
use support::data::MeshData;

fn mesh_of(mesh: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }
}

fn build<N: Lanes>(mesh: &MeshData) -> Bvh<N> {
    build_with_leaves(mesh, 1)
}

fn build_with_leaves<N: Lanes>(mesh: &MeshData, leaf_size: u32) -> Bvh<N> {
    Builder::new().leaf_size(leaf_size).build_as(&mesh_of(mesh)).unwrap()
}

/// Every splitter; the random ones have this seed.
fn splitters(seed: u32) -> [Splitter; 6] {
    let gas = |magnification| Splitter::BatchNeuralGas { magnification, seed };
    [
        Splitter::LongestAxis,
        Splitter::ExtendedLongestAxis,
        Splitter::SurfaceArea,
        Splitter::MeanWidth,
        gas(Magnification::None),
        gas(Magnification::Area),
    ]
}

/// Sixty-four bytes on a cache line.
#[derive(Copy, Clone, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

/// A copy of the bytes at an address that is a multiple of 64, with 64 more bytes behind it.
fn aligned(bytes: &[u8]) -> Vec<Line> {
    let mut lines = vec![Line([0; 64]); bytes.len().div_ceil(64) + 1];
    bytemuck::cast_slice_mut(&mut lines)[..bytes.len()].copy_from_slice(bytes);
    lines
}

/// Indices of primitives of A and B.
type Pairs = BTreeSet<(u32, u32)>;

/// [`Query::for_each_pair`] is compiled for each type of closure: here there is only one.
fn each_pair<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
    query: Query,
    a: &BvhRef<'_, N, P>,
    b: &BvhRef<'_, N, Q>,
    pose: &Pose,
    visit: &mut dyn FnMut(Pair) -> ControlFlow<()>,
) -> (Completion, QueryStats) {
    query.for_each_pair(a, b, pose, visit)
}

/// All pairs that meet, each reported once, and the work.
fn pairs_that_meet<A: AsBvh, B: AsBvh<Node = A::Node>>(
    query: Query,
    a: &A,
    b: &B,
    pose: &Pose,
) -> (Pairs, QueryStats)
where
    A::Node: Lanes,
    A::Primitive: PrimitivePair<B::Primitive>,
    B::Primitive: PrimitivePair<A::Primitive>,
{
    let mut pairs = Pairs::new();
    let (completion, stats) = each_pair(query, &a.as_bvh(), &b.as_bvh(), pose, &mut |pair| {
        assert!(pairs.insert((pair.a, pair.b)), "each pair once");
        ControlFlow::Continue(())
    });
    assert_eq!(completion, Completion::Complete);
    (pairs, stats)
}
