//! Baked trees as bytes: changes to them, an independent reader, a traversal that trusts nothing, and checks that hold
//! for all bytes whatever the primitives.

use crate::planes::code;
use crate::values::is_plane;
use crate::{Input, NodeChoice};
use core::ops::Range;
use simdop::hierarchy::{Aligned, Bvh, BvhRef, FormatError, Header, MAGIC, MAX_DEPTH, VERSION};
use simdop::low_level::key::{Half, Storage};
use simdop::node::{Ball16, Link};
use simdop::primitive::Primitive;
use simdop::query::Lanes;

/// Aligned to 64, and large enough for every tree here.
pub type Buffer = Aligned<[u8; 32 << 10]>;

/// The node type in the header, if the bytes begin like a baked tree.
pub fn said_node(data: &[u8]) -> Option<NodeChoice> {
    let field = |at: usize| data.get(at).copied().unwrap_or(0);
    data.starts_with(&MAGIC[..4]).then(|| NodeChoice {
        k: field(12),
        four: field(14) == 4,
        half: u16::from(field(120)) == Half::CODE,
    })
}

/// Copies as many bytes as there is room for.
pub fn copied<'b>(buffer: &'b mut Buffer, data: &[u8]) -> &'b [u8] {
    let size = data.len().min(buffer.0.len());
    buffer.0[..size].copy_from_slice(&data[..size]);
    &buffer.0[..size]
}

/// Makes one change to the bytes of a tree, at some place in a region, with an arbitrary number or by `special`.
pub fn change(
    bytes: &mut [u8],
    region: &Range<usize>,
    input: &mut Input,
    special: impl FnOnce(&mut [u8], usize, &mut Input),
) {
    let mut place = |size: usize| {
        let at = region.start + usize::from(input.u16()) % region.len().max(1);
        (at - at % size).min(bytes.len() - size)
    };
    let (at, from) = (place(8), place(4));
    let at = at + input.below(8);
    match input.u8() % 8 {
        0 => bytes[at] ^= 1 << input.below(8),
        1 => bytes[at] = input.u8(),
        2 | 3 => special(bytes, at, input),
        4 => bytes[at & !3..][..4].copy_from_slice(&u32::from(input.u8()).to_le_bytes()),
        5 => bytes[at & !3..][..4].copy_from_slice(&input.u32().to_le_bytes()),
        6 => bytes[at & !7..][..8].copy_from_slice(&input.u64().to_le_bytes()),
        _ => bytes.copy_within(from..from + 4, at & !3),
    }
}

/// Writes the key of a plane, or any two bytes, at an even offset.
pub fn put_code(bytes: &mut [u8], at: usize, input: &mut Input) {
    bytes[at & !1..][..2].copy_from_slice(&code(input).to_le_bytes());
}

/// How many of the bytes are kept: nearly always all.
pub fn cut(len: usize, input: &mut Input) -> usize {
    if input.u8() == 0 { usize::from(input.u16()) % (len + 1) } else { len }
}

/// Little-endian, independent of the library's reader.
pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(*bytes[at..].first_chunk().unwrap())
}

/// Offsets of the parts that follow the nodes, and of the end.
#[derive(Copy, Clone, Debug)]
pub struct Parts {
    pub balls: usize,
    pub slabs: usize,
    pub vertices: usize,
    pub records: usize,
    pub sources: usize,
    pub parts: usize,
    pub end: usize,
}

impl Parts {
    pub fn of<N: Lanes, P: Primitive>(header: &Header) -> Self {
        let counts = [header.node_count, header.vertex_count, header.primitive_count];
        let [nodes, vertices, primitives] = counts.map(|count| count as usize);
        let balls = 128 + nodes * size_of::<N>();
        let slabs = balls + if header.has_balls == 1 { nodes * size_of::<Ball16>() } else { 0 };
        let start = slabs + if header.has_normal_slabs == 1 { nodes * N::ARITY * 8 } else { 0 };
        let records = start + vertices * usize::from(header.vertex_size);
        let sources = records + primitives * size_of::<P::Record>();
        let parts = sources + primitives * 4;
        let end = (parts + header.part_count as usize * 4).next_multiple_of(64);
        Self { balls, slabs, vertices: start, records, sources, parts, end }
    }
}

/// Whether the bytes have the reported error.
fn is_true<N: Lanes, P: Primitive>(error: FormatError, bytes: &[u8]) -> bool {
    let field = |at: usize| u32_at(bytes, at);
    match error {
        FormatError::NotATree => !bytes.starts_with(&MAGIC),
        FormatError::Version { found } => found == field(8) && found != VERSION,
        FormatError::OtherNode { k, arity } => {
            u32::from(k) | u32::from(arity) << 16 == field(12)
                && (usize::from(k), usize::from(arity)) != (N::K, N::ARITY)
        }
        FormatError::OtherStorage { storage } => {
            u32::from(storage) == field(120) & 0xffff && storage != <N::Storage as Storage>::CODE
        }
        FormatError::OtherPrimitive { kind } => {
            u32::from(kind) == field(16) & 0xffff && kind != P::KIND.code()
        }
        FormatError::Truncated { have, need } => have == bytes.len() && have < need,
        FormatError::TooLong { have, need } => have == bytes.len() && have > need,
        FormatError::Node { node, lane, .. } => {
            let header: &Header = Header::read(bytes).unwrap();
            node < header.node_count && (lane as usize) < N::ARITY
        }
        FormatError::Vertex { index } => index < field(32),
        FormatError::Primitive { index } => {
            let header: &Header = Header::read(bytes).unwrap();
            let size = size_of::<P::Record>();
            let at = Parts::of::<N, P>(header).records + size * index as usize;
            (0..size).step_by(4).any(|corner| field(at + corner) >= header.vertex_count)
        }
        FormatError::Source { index } => {
            let header: &Header = Header::read(bytes).unwrap();
            field(Parts::of::<N, P>(header).sources + 4 * index as usize) >= header.primitive_count
        }
        FormatError::Part { index } => {
            let header: &Header = Header::read(bytes).unwrap();
            let part = |index: u32| field(Parts::of::<N, P>(header).parts + 4 * index as usize);
            part(index) >= header.primitive_count || index > 0 && part(index) <= part(index - 1)
        }
        FormatError::Header { field } => !field.is_empty(),
        _ => false,
    }
}

/// The bytes of a valid tree after up to four changes.
pub fn changed<'b, N: Lanes, P: Primitive>(
    buffer: &'b mut Buffer,
    tree: &Bvh<N, P>,
    input: &mut Input,
    mut change: impl FnMut(&mut [u8], &Parts, &mut Input),
) -> &'b [u8] {
    let len = copied(buffer, tree.as_bytes()).len();
    let parts = Parts::of::<N, P>(tree.view().header());
    for _ in 0..input.below(5) {
        change(&mut buffer.0[..len], &parts, input);
    }
    let size = cut(len, input);
    &buffer.0[..size]
}

/// Checks that rejected bytes have the reported error, and that accepted ones are read correctly, safe to traverse, and
/// equal after copying. Accepted trees are then passed to `then`.
pub fn examine<N: Lanes, P: Primitive>(bytes: &[u8], then: impl FnOnce(&BvhRef<'_, N, P>)) {
    let owned = Bvh::<N, P>::from_bytes(bytes);
    match BvhRef::<N, P>::from_bytes(bytes) {
        Ok(view) => {
            is_what_the_bytes_say(&view, bytes);
            is_safe_to_walk(&view);
            let owned = owned.expect("what can be borrowed can be copied");
            assert_eq!(owned.as_bytes(), bytes, "encoded again");
            then(&view);
        }
        Err(error) => {
            assert!(is_true::<N, P>(error, bytes), "{error:?}");
            assert!(!error.to_string().is_empty());
            assert_eq!(owned.err(), Some(error));
        }
    }
}

/// Compares the parts of the tree, except its primitives, with an independent reader.
fn is_what_the_bytes_say<N: Lanes, P: Primitive>(view: &BvhRef<'_, N, P>, bytes: &[u8]) {
    let header = view.header();
    let parts = Parts::of::<N, P>(header);
    assert_eq!(parts.end, bytes.len());
    assert_eq!(bytemuck::bytes_of(header), &bytes[..128]);
    assert_eq!(bytemuck::cast_slice::<N, u8>(view.nodes()), &bytes[128..parts.balls]);
    assert_eq!(bytemuck::cast_slice::<_, u8>(view.balls()), &bytes[parts.balls..parts.slabs]);
    assert_eq!(bytemuck::cast_slice::<_, u8>(view.normal_slabs()), &bytes[parts.slabs..parts.vertices]);
    assert_eq!(view.len(), header.primitive_count as usize);
    for i in 0..view.len() {
        assert_eq!(view.source(i as u32), u32_at(bytes, parts.sources + 4 * i));
    }
    if header.part_count > 0 {
        let said = (0..header.part_count as usize).map(|i| u32_at(bytes, parts.parts + 4 * i));
        assert!(view.parts().eq(said) && view.parts().is_sorted());
    }
    assert!(view.parts().all(|part| part < header.primitive_count));
}

/// Number `i` of a vertex, in either precision.
pub fn number_at<N: Lanes, P: Primitive>(header: &Header, bytes: &[u8], vertex: u32, i: usize) -> f64 {
    let size = usize::from(header.vertex_size);
    let at = Parts::of::<N, P>(header).vertices + size * vertex as usize;
    if size == size_of::<P::Single>() {
        f32::from_bits(u32_at(bytes, at + 4 * i)).into()
    } else {
        f64::from_le_bytes(*bytes[at + 8 * i..].first_chunk().unwrap())
    }
}

/// Checks that every node and every primitive is reached once, no deeper than the header says, through planes that
/// bound something.
fn is_safe_to_walk<N: Lanes, P: Primitive>(view: &BvhRef<'_, N, P>) {
    let whole = if view.nodes().is_empty() { None } else { Some(0) };
    let (nodes, lanes, seen) = walked(view, whole);
    assert!(nodes == view.header().node_count as usize && seen.iter().all(|seen| *seen));
    let stats = view.stats();
    assert_eq!((stats.nodes, stats.primitives, stats.lanes_used), (nodes, view.len(), lanes));
    assert_eq!(stats.nodes, view.nodes().len());
}

/// The number of nodes and lanes below a root, and which primitives are; each is reached once.
fn walked<N: Lanes, P: Primitive>(view: &BvhRef<'_, N, P>, root: Option<u32>) -> (usize, usize, Vec<bool>) {
    let (mut nodes, mut lanes, mut seen) = (0, 0, vec![false; view.len()]);
    let mut pending: Vec<_> = root.into_iter().map(|root| (root, 1)).collect();
    while let Some((index, level)) = pending.pop() {
        let node: &N = &view.nodes()[index as usize];
        nodes += 1;
        assert!(nodes <= view.nodes().len() && level <= view.header().depth && level as usize <= MAX_DEPTH);
        for (lane, child) in node.children().iter().enumerate() {
            let link = child.link();
            lanes += usize::from(link != Link::Empty);
            let bounds = is_plane::<N::Storage>;
            assert!((0..N::K).all(|j| bounds(node.plane(j, lane)) != (link == Link::Empty)));
            match link {
                Link::Empty => {}
                Link::Inner(below) => pending.push((below, level + 1)),
                Link::Leaf { first, count } => {
                    for primitive in first..first + count {
                        assert!(!core::mem::replace(&mut seen[primitive as usize], true), "twice");
                    }
                }
            }
        }
    }
    (nodes, lanes, seen)
}

/// Writes a number of 4 or 8 bytes that differs from the previous one, but is often near it, at a multiple of its size.
pub fn put_number(bytes: &mut [u8], at: usize, size: usize, input: &mut Input) {
    let at = at - at % size;
    let old = match size {
        4 => f32::from_bits(u32_at(bytes, at)).into(),
        _ => f64::from_le_bytes(*bytes[at..].first_chunk().unwrap()),
    };
    let step = (-(input.int(1, 30) as f64)).exp2();
    let new = match input.u8() % 12 {
        0 => 0.0,
        1 => -old,
        2 => f64::NAN,
        3 => f64::INFINITY,
        4 => f64::from(input.int(-128, 127)),
        5..8 => old * (1.0 - step),
        _ => old * (1.0 + step),
    };
    match size {
        4 => bytes[at..][..4].copy_from_slice(&(new as f32).to_le_bytes()),
        _ => bytes[at..][..8].copy_from_slice(&new.to_le_bytes()),
    }
}
