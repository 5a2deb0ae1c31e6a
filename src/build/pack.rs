//! The packer: assignment in, baked tree out. The only code that makes nodes.

use super::{Assignment, BuildError, Mesh};
use crate::exact::round_up_f32;
use crate::frame::{Frame, Point};
use crate::hierarchy::{Bvh, Header, MAX_DEPTH};
use crate::key::{Key, decode};
use crate::node::{Child, Link, Node};
use crate::triangle;
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
    let triangles: Vec<[u32; 3]> = shape.sources.iter().map(|&s| mesh.triangles[s as usize]).collect();
    let mut nodes = shape.nodes;
    wrap(&mut nodes, &frame, |index| mesh.corners(&triangles[index as usize]));

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
/// supports is the greatest support rounded: a wrapped hierarchy, whether reduced from corners or from the lanes below.
fn wrap<N: Node>(nodes: &mut [N], frame: &Frame, corners: impl Fn(u32) -> [Point; 3]) {
    for index in (0..nodes.len()).rev() {
        for lane in 0..N::ARITY {
            match nodes[index].children()[lane].link() {
                Link::Empty => {}
                Link::Leaf { first, count } => {
                    for p in (first..first + count).flat_map(&corners) {
                        for j in 0..N::K {
                            nodes[index].raise_plane(j, lane, N::support(frame, j, p));
                        }
                    }
                }
                Link::Inner(below) => {
                    let below = nodes[below as usize];
                    for j in 0..N::K {
                        for code in (0..N::ARITY).map(|l| below.plane(j, l)) {
                            // Unused lanes hold the lowest code and are no key: they raise nothing.
                            if let Some(key) = Key::from_code(code) {
                                nodes[index].raise_plane(j, lane, key);
                            }
                        }
                    }
                }
            }
        }
    }
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

fn max_plane<N: Node>(nodes: &[N]) -> f32 {
    let planes =
        nodes.iter().flat_map(|n| (0..N::K).flat_map(move |j| (0..N::ARITY).map(move |l| n.plane(j, l))));
    let finite = planes.filter(|c| Key::from_code(*c).is_some_and(|k| k != Key::INFINITY));
    finite.map(|c| decode(c).abs()).fold(0.0, f32::max)
}

fn bake<N: Node>(
    header: &Header,
    nodes: &[N],
    vertices: &[Point],
    triangles: &[[u32; 3]],
    sources: &[u32],
) -> Bvh<N> {
    let mut bytes = Vec::new();
    let mut part = |align: usize, part: &[u8]| {
        bytes.resize(bytes.len().next_multiple_of(align), 0);
        bytes.extend_from_slice(part);
    };
    part(64, bytemuck::bytes_of(header));
    part(64, bytemuck::cast_slice(nodes));
    if header.vertex_size == 12 {
        let single: Vec<[f32; 3]> = vertices.iter().map(|p| p.map(|x| x as f32)).collect();
        part(8, bytemuck::cast_slice(&single));
    } else {
        part(8, bytemuck::cast_slice(vertices));
    }
    part(4, bytemuck::cast_slice(triangles));
    part(4, bytemuck::cast_slice(sources));
    part(64, &[]);
    Bvh::copy(&bytes)
}
