//! Triangles as the primitives of a tree.

use super::Triangle;
use crate::pose::Pose;
use crate::primitive::{Kind, Primitive, Store};
use crate::range::Point;

/// Triangles, stored as the indices of their corners.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Triangles;

impl Primitive for Triangles {
    const KIND: Kind = Kind::TRIANGLES;

    type Single = [f32; 3];
    type Double = Point;
    type Record = [u32; 3];
    type Item = Triangle;

    #[inline(always)]
    fn widen([x, y, z]: [f32; 3]) -> Point {
        [x.into(), y.into(), z.into()]
    }

    fn narrow(vertex: &Point) -> Option<[f32; 3]> {
        let single = vertex.map(|x| x as f32);
        (single.map(f64::from) == *vertex).then_some(single)
    }

    fn vertex_is(vertex: &Point, accepts: impl Fn(&Point) -> bool) -> bool {
        accepts(vertex)
    }

    fn is_among(record: &[u32; 3], vertices: u32) -> bool {
        record.iter().all(|&vertex| vertex < vertices)
    }

    #[inline(always)]
    fn item(store: &Store<'_, Self>, index: u32) -> Triangle {
        let [p, q, r] = *store.record(index);
        [store.vertex(p), store.vertex(q), store.vertex(r)]
    }

    #[inline(always)]
    fn corners(item: &Triangle) -> impl Iterator<Item = Point> {
        item.iter().copied()
    }

    #[inline(always)]
    fn moved([p, q, r]: &Triangle, pose: &Pose) -> Triangle {
        [pose.apply(*p), pose.apply(*q), pose.apply(*r)]
    }
}
