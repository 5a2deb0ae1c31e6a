//! Trees in floats: the shape from a splitter, planes from the triangles below, then the form of nodes of a system.

use super::traverse::System;
use crate::data::MeshData;
use core::array::from_fn;
use simdop::hierarchy::{BvhRef, Header};
use simdop::low_level::directions::Directions;
use simdop::low_level::frame::Frame;
use simdop::node::{Child, Link, Node16};
use simdop::primitive::triangle::Triangle;
use simdop::range::Point;

pub(crate) const K: usize = 18;

/// The planes of one k-DOP, rounded up.
pub(crate) type Dop = [f32; K];

/// The planes of an empty DOP.
const EMPTY: Dop = [f32::NEG_INFINITY; K];

/// The assignment of triangles to nodes. Children come after their parents.
pub(crate) struct Shape<const W: usize> {
    pub(crate) nodes: Vec<[Child; W]>,
    /// Triangles of the mesh in the order of the leaves, one triangle per leaf.
    pub(crate) order: Vec<u32>,
}

impl Shape<16> {
    /// The shape of the library's tree.
    pub(crate) fn of(tree: BvhRef<'_, Node16<K>>) -> Self {
        Self {
            nodes: tree.nodes().iter().map(|node| node.child).collect(),
            order: (0..tree.len() as u32).map(|i| tree.source(i)).collect(),
        }
    }
}

/// Links in the encoding of `simdop::node::Child`.
pub(crate) fn inner(node: usize) -> Child {
    bytemuck::cast(node as u32)
}

/// A link to one triangle.
pub(crate) fn leaf(triangle: usize) -> Child {
    bytemuck::cast(1 << 31 | triangle as u32)
}

/// A tree in a system's form.
pub(crate) struct Tree<const W: usize, S: System<W>> {
    pub(crate) nodes: Vec<S::Node>,
    /// A node above the root, which is its child 0.
    pub(crate) above: S::Node,
    pub(crate) header: Header,
    pub(crate) frame: Frame,
    vertices: Vec<Point>,
    /// Triangles, in the order of the leaves.
    triangles: Vec<[u32; 3]>,
}

impl<const W: usize, S: System<W>> Tree<W, S> {
    /// In the frame of the library's tree of the same mesh.
    pub(crate) fn new(mesh: &MeshData, shape: &Shape<W>, baked: BvhRef<'_, Node16<K>>) -> Self {
        let triangles: Vec<[u32; 3]> = shape.order.iter().map(|&i| mesh.triangles[i as usize]).collect();
        let frame = baked.frame();
        let mut dops = vec![[EMPTY; W]; shape.nodes.len()];
        for node in (0..dops.len()).rev() {
            dops[node] = shape.nodes[node].map(|child| match child.link() {
                Link::Empty => EMPTY,
                Link::Inner(below) => hull(&dops[below as usize]),
                Link::Leaf { first, .. } => {
                    let corners = triangles[first as usize].map(|v| mesh.vertices[v as usize]);
                    planes(&frame, &corners).map(round_up)
                }
            });
        }
        let (mut above, mut root) = ([EMPTY; W], [Child::EMPTY; W]);
        (above[0], root[0]) = (hull(&dops[0]), Child::ROOT);
        Self {
            nodes: dops.iter().zip(&shape.nodes).map(|(dops, children)| S::node(dops, children)).collect(),
            above: S::node(&above, &root),
            header: *baked.header(),
            frame,
            vertices: mesh.vertices.clone(),
            triangles,
        }
    }

    #[inline(always)]
    pub(crate) fn triangle(&self, leaf: Child) -> Triangle {
        let Link::Leaf { first, .. } = leaf.link() else { unreachable!("a leaf") };
        let [p, q, r] = self.triangles[first as usize];
        [self.vertices[p as usize], self.vertices[q as usize], self.vertices[r as usize]]
    }

    /// Bounds of a triangle.
    #[inline(always)]
    pub(crate) fn planes_of(&self, corners: &Triangle) -> [f64; K] {
        planes(&self.frame, corners)
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
    }
}

fn hull<const W: usize>(dops: &[Dop; W]) -> Dop {
    from_fn(|j| dops.iter().fold(f32::NEG_INFINITY, |m, dop| m.max(dop[j])))
}

/// Upper bounds on a triangle's supports in a frame.
#[inline(always)]
fn planes(frame: &Frame, corners: &Triangle) -> [f64; K] {
    let mut greatest = [f64::NEG_INFINITY; K];
    let mut size = 0.0;
    for p in corners {
        let c = frame.centre;
        let d = [p[0] - c[0], p[1] - c[1], p[2] - c[2]];
        for i in 0..3 {
            size = if p[i].abs() + c[i].abs() > size { p[i].abs() + c[i].abs() } else { size };
        }
        for j in (0..K).step_by(2) {
            let n = Directions::<K>::VECTORS[j];
            let support = (n[0] * d[0] + n[1] * d[1]) + n[2] * d[2];
            greatest[j] = if support > greatest[j] { support } else { greatest[j] };
            greatest[j + 1] = if -support > greatest[j + 1] { -support } else { greatest[j + 1] };
        }
    }
    // Rounding errors of a difference, three products of it with 0, 1 or -1, and two sums: a few 2^-53 of three
    // coordinates.
    let pad = 3.0 * size * (16.0 * f64::EPSILON);
    let scale = frame.scale();
    for plane in &mut greatest {
        *plane = (*plane + pad) * scale;
    }
    greatest
}

/// The smallest float that is not below.
#[inline(always)]
pub(crate) fn round_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}
