//! The kernels are inlined in the traversal, because a call for each row would cost as much as the row.
//!
//! The test reads the symbol table of its own binary. Of the modules `simdop::kernel::{avx2, avx512, neon}` no
//! function may be left but the realignment and two filters of primitives. This program queries with each arity and
//! storage and searches a cloud in every way, on every instruction set, and does not use the kernels otherwise. A
//! function that is called has a symbol. So `overlap_1v16`, `overlap_16v1`, `overlap_4v4`, `boxes_near`,
//! `points_near`, `pick` and their parts (loads, masks) are inlined in each of those traversals.
//! `#[inline(never)]` on any of them fails the test. Needs an optimised ELF binary. `.ci/sweep nodes` queries with
//! every node type.
#![cfg(target_os = "linux")]

mod support;

use core::ops::ControlFlow;
use simdop::cloud::{List, Neighbour, PointCloud, Queries, Radii, RangeSearch, Seat};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query};
use std::hint::black_box;
use support::data::notice;

/// One query on every instruction set, so that each traversal is compiled.
fn query<N: Lanes>() {
    let triangle = Mesh { vertices: &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: &[[0, 1, 2]] };
    let tree: Bvh<N> = Builder::new().build_as(&triangle).unwrap();
    for isa in Isa::available() {
        let answer = Query::new(isa).collide(&tree.view(), &tree.view(), black_box(&Pose::IDENTITY));
        assert!(answer.hit().is_some(), "{isa}");
    }
}

/// Every search of a cloud on every instruction set. Returns the number of searches.
fn search() -> usize {
    let points: Vec<_> = (0..500).map(|i| [i % 10, i / 10 % 10, i / 100].map(|x| x as f32)).collect();
    let cloud = black_box(PointCloud::new(&points).unwrap());
    let (view, own, radii) = (cloud.view(), Queries::own(), Radii::Same(black_box(1.0)));
    let (mut counts, mut lists, mut indices) = ([0; 500], [List::default(); 500], [0; 4000]);
    let (mut seats, mut found) = ([Seat::default(); 500], [Neighbour::NONE; 7]);
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        let work = search.count(&view, &own, radii, &mut counts).unwrap();
        assert_eq!(search.fill(&view, &own, radii, &mut lists, &mut indices), Ok(work), "{isa}");
        let mut seen = 0;
        let visit = |_, _| {
            seen += 1;
            ControlFlow::Continue(())
        };
        assert_eq!(search.visit(&view, &own, radii, visit), Ok(work), "{isa}");
        assert_eq!(seen, work.neighbours, "{isa}");
        let others = search.seat(&view, &points, &mut seats).unwrap();
        let same = search.count(&view, &others, radii, &mut counts).unwrap();
        assert_eq!(same.neighbours, work.neighbours, "{isa}");
        assert_eq!(search.any_within(&view, points[55], 0.5), Ok(true), "{isa}");
        let mut near = 0;
        let visit = |_| {
            near += 1;
            ControlFlow::Continue(())
        };
        search.each_within(&view, points[255], 1.0, visit).unwrap();
        assert_eq!((near, search.k_nearest(&view, points[255], &mut found)), (7, Ok(7)), "{isa}");
    }
    // Count, fill, visit, seat, any_within, each_within, k_nearest.
    7
}

/// The mangled names of all functions in a 64-bit little-endian ELF file (System V ABI, chapter 4).
fn functions(elf: &[u8]) -> Vec<String> {
    let int = |at: usize, size: usize| {
        elf[at..at + size].iter().rev().fold(0, |x, byte| x << 8 | usize::from(*byte))
    };
    assert!(elf.starts_with(b"\x7fELF\x02\x01"), "a 64-bit little-endian ELF file");
    let section = |index: usize| int(0x28, 8) + index * int(0x3a, 2);
    let (type_of, offset, size, link) =
        (|s| int(s + 4, 4), |s| int(s + 0x18, 8), |s| int(s + 0x20, 8), |s| int(s + 0x28, 4));
    let mut names = Vec::new();
    for table in (0..int(0x3c, 2)).map(section).filter(|s| type_of(*s) == 2) {
        let strings = offset(section(link(table)));
        for symbol in (offset(table)..offset(table) + size(table)).step_by(24) {
            if elf[symbol + 4] & 0xf == 2 {
                let name = &elf[strings + int(symbol, 4)..];
                let end = name.iter().position(|byte| *byte == 0).unwrap();
                names.push(String::from_utf8_lossy(&name[..end]).into_owned());
            }
        }
    }
    names
}

/// Queries with each node type. Returns the number of node types.
macro_rules! query_each {
    ($($node:ident<$k:literal, $storage:ident>)*) => { [$(query::<$node<$k, $storage>>()),*].len() };
}

#[test]
fn kernels_leave_no_function_of_their_own() {
    let node_types = query_each! { Node16<18, Fixed> Node16<26, Half> Node4<32, Fixed> };
    #[cfg(simdop_all_nodes)]
    let node_types = node_types
        + query_each! {
            Node16<6, Fixed> Node16<14, Fixed> Node16<26, Fixed> Node16<32, Fixed>
            Node4<6, Fixed> Node4<14, Fixed> Node4<18, Fixed> Node4<26, Fixed>
        };
    let searches = search();
    if cfg!(debug_assertions) {
        notice("NOT CHECKED: needs an optimised build: cargo test --profile suite");
        return;
    }
    let functions = functions(&std::fs::read(std::env::current_exe().unwrap()).unwrap());
    // If names were mangled differently than expected, the test would find none and pass; so it requires
    // others. On x86-64 a function that is compiled for an instruction set cannot be inlined in one that is
    // not, so each traversal has a gate of its own. NEON is enabled for a whole aarch64 program, so there gates
    // are inlined in the traversals, which are not inlined themselves.
    let gates = functions.iter().filter(|name| name.contains("12compiled_for")).count();
    let traversals = functions.iter().filter(|name| name.contains("7descend17h")).count();
    println!("{} functions, {gates} gates, {traversals} traversals", functions.len());
    let (found, at_least) = if cfg!(target_arch = "x86_64") {
        (gates, 2 * (node_types + searches))
    } else {
        (traversals, node_types)
    };
    assert!(found >= at_least, "{found} of {at_least}: a gate, or a traversal, for each node type");
    let apart: Vec<_> = functions.iter().filter(|name| is_kernel(name) && !may_be_apart(name)).collect();
    assert!(apart.is_empty(), "not inlined: {apart:#?}");
}

fn is_kernel(name: &str) -> bool {
    ["6simdop6kernel4avx2", "6simdop6kernel6avx512", "6simdop6kernel4neon"]
        .iter()
        .any(|path| name.contains(path))
}

/// Realignment is called once for up to 16 rows, and the filter once for up to four pairs of triangles. Each is
/// hundreds of instructions, so the compiler shares them between queries. They are compiled for the same
/// features, and their parts must still be inlined in them. A slab of a primitive is compared once with sixteen
/// children; some traversals call that at the test suite's level of optimisation, but not at a release's.
fn may_be_apart(name: &str) -> bool {
    ["10realign_16", "9realign_4", "7realign17h", "7apart_4", "9beyond_16"]
        .iter()
        .any(|function| name.contains(function))
}
