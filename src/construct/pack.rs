//! The packer: assignment in, baked tree out. The only code that makes nodes.

use super::{Assignment, BuildError, Mesh, parallel};
use crate::exact::round_up_f32;
use crate::frame::Frame;
use crate::hierarchy::{Bvh, Header, MAX_DEPTH};
use crate::key::{Key, decode};
use crate::node::{Child, Link, Node};
use crate::primitive::triangle;
use crate::range::Point;
use alloc::vec::Vec;

/// Bakes the tree of a checked mesh.
pub(super) fn pack<N: Node>(
    mesh: &Mesh<'_>,
    assignment: &Assignment,
    leaf_size: u32,
) -> Result<Bvh<N>, BuildError> {
    let (low, high) = bounding_box(mesh);
    let frame = Frame::around(low, high);
    let shape: Shape<N> = Shape::new(assignment, leaf_size);
    if shape.depth > MAX_DEPTH {
        return Err(BuildError::TooDeep);
    }
    let (vertices, triangles) = in_order_of_use(mesh, &shape.sources);
    let mesh = &Mesh { vertices: &vertices, triangles: &triangles };
    let mut nodes = shape.nodes;
    wrap(&mut nodes, &frame, mesh.vertices, mesh.triangles);

    let degenerate = |t: &&[u32; 3]| triangle::is_degenerate(&mesh.corners(t));
    let extent = |i: usize| low[i].abs().max(high[i].abs()).max(frame.centre[i].abs());
    let single = mesh.vertices.iter().flatten().all(|&x| f64::from(x as f32) == x);
    let mut header = Header {
        magic: crate::hierarchy::MAGIC,
        version: crate::hierarchy::VERSION,
        k: N::K as u16,
        arity: N::ARITY as u16,
        vertex_size: if single { 12 } else { 24 },
        leaf_size: leaf_size as u16,
        depth: shape.depth as u32,
        node_count: nodes.len() as u32,
        triangle_count: triangles.len() as u32,
        vertex_count: mesh.vertices.len() as u32,
        degenerate_count: triangles.iter().filter(degenerate).count() as u32,
        centre: frame.centre,
        extent: extent(0).max(extent(1)).max(extent(2)),
        exponent: frame.exponent,
        half_width: half_width(&frame, mesh),
        max_plane: max_plane(&nodes),
        reserved: [0; 9],
    };
    if mesh.vertices.is_empty() {
        header.extent = 0.0;
    }
    Ok(bake(&header, &nodes, mesh.vertices, &triangles, &shape.sources))
}

/// The triangles in the order of the leaves, and the vertices in the order of their first use: what a leaf needs lies together. Vertices that no triangle uses come last.
fn in_order_of_use(mesh: &Mesh<'_>, sources: &[u32]) -> (Vec<Point>, Vec<[u32; 3]>) {
    const UNSEEN: u32 = u32::MAX;
    let mut places = alloc::vec![UNSEEN; mesh.vertices.len()];
    let mut vertices = Vec::with_capacity(mesh.vertices.len());
    let mut place = |vertex: usize| {
        if places[vertex] == UNSEEN {
            places[vertex] = vertices.len() as u32;
            vertices.push(mesh.vertices[vertex]);
        }
        places[vertex]
    };
    let corners = |&source: &u32| mesh.triangles[source as usize];
    let triangles = sources.iter().map(corners).map(|t| t.map(|vertex| place(vertex as usize))).collect();
    (0..mesh.vertices.len()).for_each(|vertex| _ = place(vertex));
    (vertices, triangles)
}

/// Links of all nodes, without planes, and the triangles in the order of the leaves.
struct Shape<N> {
    nodes: Vec<N>,
    sources: Vec<u32>,
    depth: usize,
}

impl<N: Node> Shape<N> {
    fn new(assignment: &Assignment, leaf_size: u32) -> Self {
        let count = assignment.ends.len() / N::ARITY;
        let mut nodes = Vec::with_capacity(count);
        let mut sources = Vec::with_capacity(assignment.order.len());
        // Where the ranges of the nodes to come begin, and their level, in order.
        let mut starts = Vec::with_capacity(count);
        starts.push((0, 1));
        let mut depth = 0;
        for (index, ends) in assignment.ends.chunks_exact(N::ARITY).enumerate() {
            let (mut start, level) = starts[index];
            depth = level;
            let mut node = N::EMPTY;
            let mut lane = 0;
            for &end in ends {
                let count = end - start;
                if count > leaf_size {
                    node.set_child(lane, Child::inner(starts.len() as u32));
                    starts.push((start, level + 1));
                } else if count > 0 {
                    node.set_child(lane, Child::leaf(sources.len() as u32, count));
                    sources.extend_from_slice(&assignment.order[start as usize..end as usize]);
                }
                // Used lanes come first: an unused one is not worth a place in between.
                lane += usize::from(count > 0);
                start = end;
            }
            nodes.push(node);
        }
        Self { nodes, sources, depth }
    }
}

/// The planes of every lane: the supports of the corners below it. Rounding up is monotone, so the greatest of the rounded
/// supports is the greatest support rounded: a wrapped hierarchy, whether reduced from corners or from the lanes below. So each
/// vertex is rounded once, though some six triangles and all their ancestors use it.
fn wrap<N: Node>(nodes: &mut [N], frame: &Frame, vertices: &[Point], triangles: &[[u32; 3]]) {
    let keys = supports::<N>(frame, vertices);
    let keys_of = |vertex: u32| &keys[vertex as usize * N::K..][..N::K];
    parallel::for_each_chunk(nodes, NODES_PER_TASK, |_, nodes| {
        for node in nodes {
            for lane in 0..N::ARITY {
                let Link::Leaf { first, count } = node.children()[lane].link() else { continue };
                for [p, q, r] in &triangles[first as usize..][..count as usize] {
                    let corners = keys_of(*p).iter().zip(keys_of(*q)).zip(keys_of(*r));
                    for (j, ((p, q), r)) in corners.enumerate() {
                        node.raise_plane(j, lane, *p.max(q).max(r));
                    }
                }
            }
        }
    });
    for index in (0..nodes.len()).rev() {
        for lane in 0..N::ARITY {
            let Link::Inner(below) = nodes[index].children()[lane].link() else { continue };
            let below = nodes[below as usize];
            for j in 0..N::K {
                // Unused lanes hold the lowest code, and a node has at least one lane in use.
                let code = (0..N::ARITY).map(|lane| below.plane(j, lane)).fold(i16::MIN, i16::max);
                if let Some(key) = Key::from_code(code) {
                    nodes[index].raise_plane(j, lane, key);
                }
            }
        }
    }
}

const NODES_PER_TASK: usize = 512;
const VERTICES_PER_TASK: usize = 2048;

/// The key of each direction's support of each vertex, `K` a vertex.
fn supports<N: Node>(frame: &Frame, vertices: &[Point]) -> Vec<Key> {
    let mut keys = alloc::vec![Key::ZERO; vertices.len() * N::K];
    parallel::for_each_chunk(&mut keys, VERTICES_PER_TASK * N::K, |task, keys| {
        let vertices = &vertices[task * VERTICES_PER_TASK..];
        for (keys, p) in keys.chunks_exact_mut(N::K).zip(vertices) {
            N::supports(frame, *p, keys);
        }
    });
    keys
}

/// Bounding box of the vertices that triangles use; of nothing, the origin.
fn bounding_box(mesh: &Mesh<'_>) -> (Point, Point) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in mesh.vertices {
        for i in 0..3 {
            low[i] = low[i].min(p[i]);
            high[i] = high[i].max(p[i]);
        }
    }
    if mesh.vertices.is_empty() { ([0.0; 3], [0.0; 3]) } else { (low, high) }
}

fn half_width(frame: &Frame, mesh: &Mesh<'_>) -> [f32; 3] {
    core::array::from_fn(|i| {
        let width = |p: &Point| ((p[i] - frame.centre[i]) * frame.scale()).abs();
        round_up_f32(mesh.vertices.iter().map(width).fold(0.0, f64::max))
    })
}

/// The largest magnitude of a finite plane. Codes order as what they stand for, so the least and the greatest have it.
fn max_plane<N: Node>(nodes: &[N]) -> f32 {
    let (mut least, mut greatest) = (0, 0);
    for node in nodes {
        for j in 0..N::K {
            for code in (0..N::ARITY).map(|lane| node.plane(j, lane)) {
                let finite = code >= Key::LOWEST.code() && code < Key::INFINITY.code();
                least = if finite { code.min(least) } else { least };
                greatest = if finite { code.max(greatest) } else { greatest };
            }
        }
    }
    decode(least).abs().max(decode(greatest))
}

fn bake<N: Node>(
    header: &Header,
    nodes: &[N],
    vertices: &[Point],
    triangles: &[[u32; 3]],
    sources: &[u32],
) -> Bvh<N> {
    let single: Vec<[f32; 3]>;
    let vertex_bytes = if header.vertex_size == 12 {
        single = vertices.iter().map(|p| p.map(|x| x as f32)).collect();
        bytemuck::cast_slice(&single)
    } else {
        bytemuck::cast_slice(vertices)
    };
    // Each with its alignment: `Header::layout` reads them in this order.
    Bvh::assemble(&[
        (64, bytemuck::bytes_of(header)),
        (64, bytemuck::cast_slice(nodes)),
        (8, vertex_bytes),
        (4, bytemuck::cast_slice(triangles)),
        (4, bytemuck::cast_slice(sources)),
    ])
}
