//! Whatever bytes `from_bytes` accepts are safe to walk and to query, and are what it says; whatever it
//! refuses, it refuses for a reason that is true.
//!
//! An input that begins as a baked tree does is taken as one. Any other is a list of changes to a tree of the
//! builder.
#![no_main]

#[path = "../../tests/support/mod.rs"]
mod support;

use libfuzzer_sys::fuzz_target;
use simdop::hierarchy::{Aligned, BakeError, Bvh, BvhRef, Header, MAGIC, MAX_DEPTH, VERSION};
use simdop::isa::Isa;
use simdop::node::Link;
use simdop::pose::Pose;
use simdop::primitive::Kind;
use simdop::query::{Lanes, Query, Verdict};
use simdop_fuzz::bodies::{bodies, pose};
use simdop_fuzz::planes::code;
use simdop_fuzz::{Input, Mode, for_node};
use support::dyadic::half_value;
use support::exact::{Tri, meshes_meet, triangles_meet};

/// At a multiple of 64, and large enough for every tree here.
type Buffer = Aligned<[u8; 32 << 10]>;

fuzz_target!(|data: &[u8]| {
    let mut buffer: Buffer = Aligned([0; _]);
    let mut input = Input::new(data);
    if data.starts_with(&MAGIC[..4]) {
        let size = data.len().min(buffer.0.len());
        buffer.0[..size].copy_from_slice(&data[..size]);
        let field = |at: usize| data.get(at).copied().unwrap_or(0);
        for_node!(field(12), field(14) == 4, examine(&buffer.0[..size], &mut input));
    } else {
        let (k, four) = (input.below(5), input.one_in(2));
        for_node!([6, 14, 18, 26, 32][k], four, change(&mut buffer, &mut input));
    }
});

/// Makes up to four changes to a sound tree.
fn change<N: Lanes>(buffer: &mut Buffer, input: &mut Input) {
    let tree = input.pick(&bodies::<N>().0).tree.as_bytes();
    let bytes = &mut buffer.0[..tree.len()];
    bytes.copy_from_slice(tree);
    let nodes_end = 128 + size_of_val(input_nodes::<N>(tree));
    for _ in 0..input.below(5) {
        let region = match input.u8() {
            0..64 => 0..128,
            64..160 => 128..nodes_end,
            _ => nodes_end..tree.len(),
        };
        let mut place = |size: usize| {
            let at = region.start + usize::from(input.u16()) % region.len().max(1);
            (at - at % size).min(tree.len() - size)
        };
        let (at, from) = (place(8), place(4));
        let at = at + input.below(8);
        match input.u8() % 8 {
            0 => bytes[at] ^= 1 << input.below(8),
            1 => bytes[at] = input.u8(),
            2 | 3 => bytes[at & !1..][..2].copy_from_slice(&code(input).to_le_bytes()),
            4 => bytes[at & !3..][..4].copy_from_slice(&u32::from(input.u8()).to_le_bytes()),
            5 => bytes[at & !3..][..4].copy_from_slice(&input.u32().to_le_bytes()),
            6 => bytes[at & !7..][..8].copy_from_slice(&input.u64().to_le_bytes()),
            _ => bytes.copy_within(from..from + 4, at & !3),
        }
    }
    let size = if input.u8() == 0 { usize::from(input.u16()) % (tree.len() + 1) } else { tree.len() };
    examine::<N>(&buffer.0[..size], input);
}

fn input_nodes<N: Lanes>(tree: &[u8]) -> &[N] {
    BvhRef::<N>::from_bytes(tree).unwrap().nodes()
}

fn examine<N: Lanes>(bytes: &[u8], input: &mut Input) {
    let owned = Bvh::<N>::from_bytes(bytes);
    match BvhRef::<N>::from_bytes(bytes) {
        Ok(view) => {
            is_what_the_bytes_say(&view, bytes);
            is_safe_to_walk(&view);
            let owned = owned.expect("what can be borrowed can be copied");
            assert_eq!(owned.as_bytes(), bytes, "encoded again");
            queries_agree(&view, input);
        }
        Err(error) => {
            assert!(is_true::<N>(error, bytes), "{error:?}");
            assert!(!error.to_string().is_empty());
            assert_eq!(owned.err(), Some(error));
        }
    }
}

/// Little-endian, whatever the library reads.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(*bytes[at..].first_chunk().unwrap())
}

fn is_true<N: Lanes>(error: BakeError, bytes: &[u8]) -> bool {
    let field = |at: usize| u32_at(bytes, at);
    match error {
        BakeError::NotATree => !bytes.starts_with(&MAGIC),
        BakeError::Version { found } => found == field(8) && found != VERSION,
        BakeError::OtherNode { k, arity } => {
            u32::from(k) | u32::from(arity) << 16 == field(12)
                && (usize::from(k), usize::from(arity)) != (N::K, N::ARITY)
        }
        BakeError::OtherPrimitive { kind } => {
            u32::from(kind) == field(16) & 0xffff && kind != Kind::TRIANGLES.code()
        }
        BakeError::Truncated { have, need } => have == bytes.len() && have < need,
        BakeError::TooLong { have, need } => have == bytes.len() && have > need,
        BakeError::Node { node, lane, .. } => node < field(24) && (lane as usize) < N::ARITY,
        BakeError::Vertex { index } => index < field(32),
        BakeError::Primitive { index } => {
            let header: &Header = Header::read(bytes).unwrap();
            let at = parts::<N>(header)[1] + 12 * index as usize;
            (0..3).any(|corner| field(at + 4 * corner) >= header.vertex_count)
        }
        BakeError::Source { index } => {
            let header: &Header = Header::read(bytes).unwrap();
            field(parts::<N>(header)[2] + 4 * index as usize) >= header.primitive_count
        }
        BakeError::Header { field } => !field.is_empty(),
        _ => false,
    }
}

/// Where vertices, triangles and sources begin, and where all ends. Nodes and thin slabs are before them.
fn parts<N: Lanes>(header: &Header) -> [usize; 4] {
    let slabs = if header.has_thin_slabs == 1 { N::ARITY * 8 } else { 0 };
    let vertices = 128 + header.node_count as usize * (size_of::<N>() + slabs);
    let triangles = vertices + header.vertex_count as usize * usize::from(header.vertex_size);
    let sources = triangles + header.primitive_count as usize * 12;
    [vertices, triangles, sources, (sources + header.primitive_count as usize * 4).next_multiple_of(64)]
}

/// The parts of the tree, read from the bytes by other means.
fn is_what_the_bytes_say<N: Lanes>(view: &BvhRef<'_, N>, bytes: &[u8]) {
    let header = view.header();
    let [vertices, triangles, sources, end] = parts::<N>(header);
    assert_eq!(end, bytes.len());
    assert_eq!(bytemuck::bytes_of(header), &bytes[..128]);
    let slabs = 128 + header.node_count as usize * size_of::<N>();
    assert_eq!(bytemuck::cast_slice::<N, u8>(view.nodes()), &bytes[128..slabs]);
    assert_eq!(bytemuck::cast_slice::<_, u8>(view.thin_slabs()), &bytes[slabs..vertices]);
    assert_eq!(view.len(), header.primitive_count as usize);
    let size = usize::from(header.vertex_size);
    for i in 0..view.len() {
        assert_eq!(view.source(i as u32), u32_at(bytes, sources + 4 * i));
        for (corner, p) in view.primitive(i as u32).iter().enumerate() {
            let vertex = vertices + size * u32_at(bytes, triangles + 12 * i + 4 * corner) as usize;
            for (axis, x) in p.iter().enumerate() {
                let stored = match size {
                    12 => f32::from_bits(u32_at(bytes, vertex + 4 * axis)).into(),
                    _ => f64::from_le_bytes(*bytes[vertex + 8 * axis..].first_chunk().unwrap()),
                };
                assert_eq!(x.to_bits(), stored.to_bits());
            }
        }
    }
}

/// Every node and every triangle is reached once, no deeper than the header says, by planes that bound
/// something.
fn is_safe_to_walk<N: Lanes>(view: &BvhRef<'_, N>) {
    let (mut nodes, mut seen) = (0, vec![false; view.len()]);
    let mut lanes = 0;
    let mut pending = if view.nodes().is_empty() { vec![] } else { vec![(0, 1)] };
    while let Some((index, level)) = pending.pop() {
        let node: &N = &view.nodes()[index as usize];
        nodes += 1;
        assert!(nodes <= view.nodes().len() && level <= view.header().depth && level as usize <= MAX_DEPTH);
        for (lane, child) in node.children().iter().enumerate() {
            let link = child.link();
            lanes += usize::from(link != Link::Empty);
            let bounds = |code| code != -1 && half_value(code) > f64::NEG_INFINITY;
            assert!((0..N::K).all(|j| bounds(node.plane(j, lane)) != (link == Link::Empty)));
            match link {
                Link::Empty => {}
                Link::Inner(below) => pending.push((below, level + 1)),
                Link::Leaf { first, count } => {
                    for triangle in first..first + count {
                        assert!(!core::mem::replace(&mut seen[triangle as usize], true), "twice");
                    }
                }
            }
        }
    }
    assert!(nodes == view.nodes().len() && seen.iter().all(|seen| *seen));
    let stats = view.stats();
    assert_eq!((stats.nodes, stats.primitives, stats.lanes_used), (nodes, seen.len(), lanes));
}

/// Queries end, alike on every instruction set, with true hits; and if the tree is proven, which takes a
/// while, with true verdicts.
fn queries_agree<N: Lanes>(view: &BvhRef<'_, N>, input: &mut Input) {
    let other = input.pick(&bodies::<N>().0).tree.view();
    let pose = pose(input, Mode::Real);
    let (a, b) = [(view, &other), (&other, view), (view, view)][input.below(3)];
    let proven = input.one_in(8) && view.verify().is_ok();
    let moved: Vec<Tri> = corners(a).map(|t| t.map(|p| pose.apply(p))).collect();
    let still: Vec<Tri> = corners(b).collect();
    // Planes at infinity can make a query test all pairs.
    let query = |isa| Query::new(isa).with_budget(300);
    let answer = query(Isa::SCALAR).collide(a, b, &pose);
    match answer.verdict {
        Verdict::Hit(pair) => {
            assert!(is_hit(a, b, &moved, &still, (pair.a, pair.b)), "a false hit: {pair:?}")
        }
        Verdict::Free => {
            assert!(!proven || !meshes_meet(&moved, &still), "a miss in a proven tree: {pose:?}")
        }
        Verdict::Unknown { .. } => assert_eq!(answer.counters.visits, 300),
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
