//! How many bytes of stack a query uses, including everything it calls: `cargo bench --bench stack` prints a table.
//! Seconds.
//!
//! The stack below a frame is painted, a query runs on it, and the part still painted afterwards was not used. Reports
//! the maximum over poses of a torus and a cube against themselves, some of which need exact arithmetic, which uses the
//! most. `tests/queries/stack.rs` checks the bounds given in the crate's documentation.

#![expect(unsafe_code, reason = "no variable lives on the stack below the own frame")]
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "support/page.rs"]
mod page;

use core::hint::black_box;
use core::ops::ControlFlow;
use page::show;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::BvhRef;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{DISTANCE_STACK_BYTES, Lanes, Query, STACK_BYTES};
use std::f64::consts::TAU;

/// More than any query uses.
const PAINTED: usize = 96 << 10;
const PAINT: u8 = 0xa5;

#[inline(never)]
fn paint() {
    let mut bytes = [0_u8; PAINTED];
    bytes.fill(PAINT);
    black_box(&bytes);
}

/// Bytes from `top` down to the lowest byte that is not painted.
#[inline(never)]
fn used(top: usize) -> usize {
    // The last page of the paint may be below what `paint` reached.
    let lowest = top - PAINTED + 4096;
    let painted = (lowest..top).take_while(|&address| {
        // SAFETY: `paint` has just used these bytes of this thread's stack, so they are mapped; the value read is only
        // compared.
        let byte = unsafe { core::ptr::read_volatile(address as *const u8) };
        byte == PAINT
    });
    top - lowest - painted.count()
}

/// Bytes of stack that `f` uses below this function's frame.
#[inline(never)]
fn measure(f: &mut dyn FnMut()) -> usize {
    let mark = 0_u8;
    let top = black_box(&raw const mark) as usize;
    paint();
    f();
    used(top)
}

fn torus(around: u32, along: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..around {
        for j in 0..along {
            let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(along));
            let r = 1.0 + 0.3 * b.cos();
            vertices.push([r * a.cos(), r * a.sin(), 0.3 * b.sin()]);
            let at = |i: u32, j: u32| i % around * along + j % along;
            triangles.extend([
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ]);
        }
    }
    (vertices, triangles)
}

fn cube() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from);
    let quad = |[p, q, r, s]: [u32; 4]| [[p, q, r], [p, r, s]];
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    ((0..8).map(corner).collect(), quads.into_iter().flat_map(quad).collect())
}

/// Apart, touching with whole faces, almost touching, and rotated.
fn poses() -> Vec<Pose> {
    let rows = (0..60).flat_map(|i| {
        let (x, angle) = (f64::from(i) * 0.05, f64::from(i) * 0.11);
        let (s, c) = angle.sin_cos();
        [
            [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 1e-12], [0.0, 0.0, 1.0, 1e-13]],
            [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0 + 1e-14 * f64::from(i)]],
            [[c, -s, 0.0, x], [s, c, 0.0, 0.3], [0.0, 0.0, 1.0, 0.01]],
            [[1.0, 0.0, 0.0, x], [0.0, c, -s, 0.3], [0.0, s, c, 1.0]],
        ]
    });
    rows.map(|rows| Pose::from_rows(rows).unwrap()).collect()
}

/// A row of the table for each instruction set.
fn rows<N: Lanes>() {
    let (bodies, poses) = ([torus(24, 16), cube()], poses());
    let build = |(vertices, triangles): &(Vec<_>, Vec<_>)| {
        Builder::new().build_as::<N>(&Mesh { vertices, triangles }).unwrap()
    };
    let trees = bodies.each_ref().map(build);
    for isa in Isa::available() {
        let query = Query::new(isa);
        let (mut greatest, mut exact) = ([0; 5], 0);
        let mut take =
            |column: usize, f: &mut dyn FnMut()| greatest[column] = measure(f).max(greatest[column]);
        for tree in &trees {
            let body = &tree.view();
            for pose in &poses {
                take(0, &mut || exact += black_box(query.collide(body, body, pose)).stats.exact_pairs);
                take(1, &mut || _ = black_box(query.within(body, body, pose, 0.01)));
                take(1, &mut || {
                    _ = black_box(query.for_each_pair(body, body, pose, |_| ControlFlow::Continue(())));
                });
                take(2, &mut || _ = black_box(query.distance(body, body, pose, 0.0)));
            }
            take(3, &mut || _ = black_box(BvhRef::<N>::from_bytes(tree.as_bytes())));
            take(4, &mut || _ = black_box(body.verify()));
        }
        assert!(exact > 0, "some poses need exact arithmetic");
        show!(
            "| {} | {} | {isa} | {} |",
            N::ARITY,
            N::K,
            greatest.map(|bytes| bytes.to_string()).join(" | ")
        );
    }
}

fn main() {
    page::begin(
        "Stack",
        "Bytes of stack that a query takes below its caller's frame, the maximum over poses of a torus and a \
         cube against themselves.",
    );
    show!("STACK_BYTES {STACK_BYTES}, DISTANCE_STACK_BYTES {DISTANCE_STACK_BYTES}\n");
    show!("| arity | k | isa | collide | within, for_each_pair | distance | from_bytes | verify |");
    show!("|--:|--:|---|--:|--:|--:|--:|--:|");
    macro_rules! all { ($($node:ty)*) => { $( rows::<$node>(); )* }; }
    // The default, and the ones that use the most.
    all!(Node16<18> Node16<32> Node4<18> Node4<32>);
    page::write();
}
