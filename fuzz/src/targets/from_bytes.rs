//! Bytes that `from_bytes` accepts are safe to traverse and to query, and the tree is what they say; bytes that it
//! rejects have the error that it reports.
//!
//! An input that begins like a baked tree is used as one. Any other is a list of changes to a valid tree.

use crate::baked::{self, Buffer, Parts, change, copied, number_at, put_code, said_node, u32_at};
use crate::bodies::{bodies, pose};
use crate::support::exact::{Tri, meshes_meet, triangles_meet};
use crate::{Input, Mode, NodeChoice, for_node};
use simdop::hierarchy::{Aligned, BvhRef};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::query::{Lanes, Query, Verdict};

/// One run.
pub fn run(data: &[u8]) {
    let mut buffer: Buffer = Aligned([0; _]);
    let mut input = Input::new(data);
    if let Some(node) = said_node(data) {
        for_node!(node, examine(copied(&mut buffer, data), &mut input));
    } else {
        let node = NodeChoice::new(&mut input);
        for_node!(node, changed(&mut buffer, &mut input));
    }
}

/// Makes up to four changes to a valid tree.
fn changed<N: Lanes>(buffer: &mut Buffer, input: &mut Input) {
    let tree = &input.pick(&bodies::<N>().0).tree;
    let bytes = baked::changed(buffer, tree, input, |bytes, parts, input| {
        let region = match input.u8() {
            0..64 => 0..128,
            64..160 => 128..parts.balls,
            _ => parts.balls..parts.end,
        };
        change(bytes, &region, input, put_code);
    });
    examine::<N>(bytes, input);
}

fn examine<N: Lanes>(bytes: &[u8], input: &mut Input) {
    baked::examine::<N, Triangles>(bytes, |view| {
        are_its_triangles(view, bytes);
        queries_agree(view, input);
    });
}

/// Compares the corners of the triangles with an independent reader.
fn are_its_triangles<N: Lanes>(view: &BvhRef<'_, N>, bytes: &[u8]) {
    let header = view.header();
    let records = Parts::of::<N, Triangles>(header).records;
    for i in 0..view.len() {
        for (corner, p) in view.primitive(i as u32).iter().enumerate() {
            let vertex = u32_at(bytes, records + 12 * i + 4 * corner);
            for (axis, x) in p.iter().enumerate() {
                let stored = number_at::<N, Triangles>(header, bytes, vertex, axis);
                assert_eq!(x.to_bits(), stored.to_bits());
            }
        }
    }
}

/// Queries terminate with the same answers on every instruction set, and hits are true; if the tree is verified, which
/// takes a while, all verdicts are true.
fn queries_agree<N: Lanes>(view: &BvhRef<'_, N>, input: &mut Input) {
    let other = input.pick(&bodies::<N>().0).tree.view();
    let pose = pose(input, Mode::Real);
    let (a, b) = [(view, &other), (&other, view), (view, view)][input.below(3)];
    let proven = input.one_in(8) && view.verify().is_ok();
    let moved: Vec<Tri> = corners(a).map(|t| t.map(|p| pose.apply(p))).collect();
    let still: Vec<Tri> = corners(b).collect();
    // Infinite planes can make a query test all pairs.
    let query = |isa| Query::new(isa).with_budget(300);
    let answer = query(Isa::SCALAR).collide(a, b, &pose);
    match answer.verdict {
        // Bytes may claim to be a solid when they are not: then a ray can find anything.
        Verdict::Hit(_) if a.is_solid() || b.is_solid() => {}
        Verdict::Hit(pair) => {
            assert!(is_hit(a, b, &moved, &still, (pair.a, pair.b)), "a false hit: {pair:?}")
        }
        Verdict::Free => {
            assert!(!proven || !meshes_meet(&moved, &still), "a miss in a proven tree: {pose:?}")
        }
        Verdict::Unknown { .. } => assert_eq!(answer.stats.visits, 300),
    }
    for isa in Isa::available().filter(|isa| *isa != Isa::SCALAR) {
        assert_eq!(query(isa).collide(a, b, &pose), answer, "{isa}");
    }
    if input.one_in(4) {
        distances_agree(a, b, &pose);
    }
}

fn distances_agree<N: Lanes>(a: &BvhRef<'_, N>, b: &BvhRef<'_, N>, pose: &Pose) {
    let distance = |isa| Query::new(isa).with_budget(50).distance(a, b, pose, 0.1).unwrap();
    let want = distance(Isa::SCALAR);
    assert!(want.lower <= want.upper, "{want:?}");
    for isa in Isa::available() {
        assert_eq!(distance(isa), want, "{isa}");
    }
}

fn corners<N: Lanes>(view: &BvhRef<'_, N>) -> impl Iterator<Item = Tri> {
    (0..view.len()).map(|index| view.primitive(index as u32))
}

/// Whether triangles with these indices in the meshes meet. Damaged trees may use an index twice.
fn is_hit<N: Lanes>(
    a: &BvhRef<'_, N>,
    b: &BvhRef<'_, N>,
    moved: &[Tri],
    still: &[Tri],
    pair: (u32, u32),
) -> bool {
    let is_it = |i: usize, j: usize| (a.source(i as u32), b.source(j as u32)) == pair;
    (0..moved.len()).any(|i| (0..still.len()).any(|j| is_it(i, j) && triangles_meet(&moved[i], &still[j])))
}
