//! Which children a primitive slab separates is the same on every instruction set; and for a real tree these children
//! are separated from the triangle along the slab's direction, decided exactly.

use crate::bodies::{Body, bodies, pose, small_body};
use crate::planes::{float, narrow, pair, wide};
use crate::support::dyadic::apart_along;
use crate::support::exact::Tri;
use crate::{Input, Mode, for_k, on_every_isa};
use simdop::hierarchy::BvhRef;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::Storage;
use simdop::low_level::realign::{PrimitiveSlab, primitive_slabs};
use simdop::node::{Child, Link, Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Primitive, Triangles};
use simdop::query::Lanes;
use simdop::range::{MIN_COORDINATE, Point};

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, k) = (input.mode(), input.u8());
    for_k!(k, check(&mut input, mode));
}

fn check<const K: usize, S: Storage>(input: &mut Input, mode: Mode)
where
    Node16<K, S>: Lanes,
{
    if mode != Mode::Real && !input.one_in(4) {
        let slab = any_slab(input, mode, K as u8);
        let (wide, narrow) = (wide(pair::<16, K, S>(input, mode).1), narrow(pair::<4, K, S>(input, mode).1));
        kernels_agree::<K, S>(&slab, &wide, &narrow);
        return;
    }
    if mode == Mode::Real {
        let (body, other) = (input.pick(&bodies().0), input.pick(&bodies().0));
        what_is_beyond_is_apart(body, other, &pose(input, mode), input);
    } else if let (Some(body), Some(other)) = (small_body(input, mode), small_body(input, mode)) {
        what_is_beyond_is_apart(&body, &other, &pose(input, mode), input);
    }
}

/// Tests the children of a node of one body against a triangle of the other, in either role.
fn what_is_beyond_is_apart<const K: usize, S: Storage>(
    body: &Body<Node16<K, S>>,
    other: &Body<Node16<K, S>>,
    pose: &Pose,
    input: &mut Input,
) where
    Node16<K, S>: Lanes,
{
    let view = body.tree.view();
    if view.is_empty() || other.triangles.is_empty() {
        return;
    }
    let waiting: Tri = *input.pick(&other.triangles);
    // A pending triangle of A is at its pose in B's frame; one of B is tested as it is against nodes of A.
    let (mut triangle, placed) =
        if input.one_in(2) { (waiting.map(|p| pose.apply(p)), None) } else { (waiting, Some(pose)) };
    let moved = |p: Point| placed.map_or(p, |pose| pose.apply(p));
    if input.one_in(2) {
        touch(&mut triangle, moved(view.primitive(u32::from(input.u8()) % view.len() as u32)[0]));
    }
    let margin = [0.0, 0.0, 1e-3, 0.5][input.below(4)];
    let index = input.below(view.nodes().len());
    let node = &view.nodes()[index];
    let extent = view.extent();
    let four = narrow(node.planes.map(|p| [p[0], p[1], p[2], p[3]]));
    let directions = Triangles::own_directions(&triangle);
    for (s, slab) in primitive_slabs::<Triangles, K, S>(&triangle, margin, &extent, placed).iter().enumerate()
    {
        kernels_agree(slab, node, &four);
        let beyond = Scalar::new().beyond_16(slab, node);
        for (lane, child) in node.child.iter().enumerate().filter(|(lane, _)| beyond >> lane & 1 != 0) {
            let mut vertices = Vec::new();
            vertices_below(&view, *child, &mut vertices);
            // The result for an unused lane is arbitrary: it has no pairs to separate.
            assert_eq!(vertices.is_empty(), child.link() == Link::Empty, "k {K} lane {lane}");
            vertices.iter_mut().for_each(|p| *p = moved(*p));
            let n = directions.map(|column| column[s]);
            assert!(
                apart_along(&n, &triangle, &vertices, margin),
                "k {K} {slab:?}: {triangle:?} does not leave {vertices:?} beyond {margin}"
            );
        }
    }
}

/// Moves a triangle so that one of its corners is at `p`.
fn touch(triangle: &mut Tri, p: Point) {
    let from = triangle[0];
    let flush = |x: f64| if x.abs() < MIN_COORDINATE { 0.0 } else { x };
    for corner in triangle.iter_mut() {
        *corner = [0, 1, 2].map(|i| flush(p[i] + (corner[i] - from[i])));
    }
    triangle[0] = p;
}

fn vertices_below<const K: usize, S: Storage>(
    tree: &BvhRef<'_, Node16<K, S>>,
    child: Child,
    out: &mut Vec<Point>,
) where
    Node16<K, S>: Lanes,
{
    match child.link() {
        Link::Empty => {}
        Link::Inner(node) => {
            tree.nodes()[node as usize].child.iter().for_each(|child| vertices_below(tree, *child, out));
        }
        Link::Leaf { first, count } => {
            out.extend((first..first + count).flat_map(|index| tree.primitive(index)));
        }
    }
}

fn kernels_agree<const K: usize, S: Storage>(
    slab: &PrimitiveSlab,
    wide: &Node16<K, S>,
    narrow: &Node4<K, S>,
) {
    let want = (Scalar::new().beyond_16(slab, wide), Scalar::new().beyond_4(slab, narrow));
    on_every_isa!(kernel => {
        let got = (kernel.beyond_16(slab, wide), kernel.beyond_4(slab, narrow));
        assert_eq!(got, want, "{kernel:?} k {K} {slab:?} {wide:x?} {narrow:x?}");
    });
}

/// A slab with arbitrary values.
fn any_slab(input: &mut Input, mode: Mode, k: u8) -> PrimitiveSlab {
    PrimitiveSlab {
        sources: [(); 3].map(|()| input.u8() % k),
        weights: [(); 3].map(|()| float(input, mode)),
        limits: [(); 2].map(|()| float(input, mode)),
    }
}
