//! Triangles as the primitives of a tree.

use super::crossing::crossing;
use super::sides::Triangle;
use crate::pose::Pose;
use crate::primitive::{Kind, Lattice, LatticeCorners, OWN_DIRECTIONS, Primitive, Sphere, Store};
use crate::range::Point;
use crate::vector::cross;

/// Triangles, stored as the indices of their corners.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Triangles;

impl Primitive for Triangles {
    const KIND: Kind = Kind::TRIANGLES;
    const BOUNDS_SOLIDS: bool = true;
    const IS_ON_LATTICE: bool = true;

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

    #[inline(always)]
    fn balls(vertex: &Point) -> impl Iterator<Item = Sphere> {
        core::iter::once(Sphere { centre: *vertex, radius: 0.0 })
    }

    #[inline(always)]
    fn map(vertex: &Point, number: impl Fn(f64) -> f64) -> Point {
        vertex.map(number)
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

    #[inline(always)]
    fn on_lattice(
        store: &Store<'_, Self>,
        index: u32,
        lattice: &Lattice,
        is_moved: bool,
    ) -> Option<LatticeCorners> {
        let corner = |vertex: u32| {
            let p = store.vertex_by(vertex, |p| lattice.single(p), |p| lattice.double(p));
            if is_moved { lattice.moved(p) } else { p }
        };
        let [p, q, r] = *store.record(index);
        Some([corner(p), corner(q), corner(r)])
    }

    fn crossing(item: &Triangle, origin: &Point, exact: &mut u64) -> i8 {
        crossing(item, origin, exact)
    }

    // Within the range of coordinates no product under- or overflows.
    #[inline(always)]
    fn own_directions([p, q, r]: &Triangle) -> [[f64; OWN_DIRECTIONS]; 3] {
        let edge = |from: &Point, to: &Point| [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
        let edges = [edge(p, q), edge(q, r), edge(r, p)];
        let normal = cross(&edges[0], &edges[1]);
        let [a, b, c] = edges.map(
            #[inline(always)]
            |edge| cross(&edge, &normal),
        );
        let mut columns = [0, 1, 2].map(|i| [normal[i], a[i], b[i], c[i]]);
        for s in 0..OWN_DIRECTIONS {
            let greater = |x: f64, y: f64| if x > y { x } else { y };
            let size = greater(columns[0][s].abs(), greater(columns[1][s].abs(), columns[2][s].abs()));
            let inverse = if size > 0.0 { 1.0 / size } else { 0.0 };
            for column in &mut columns {
                column[s] *= inverse;
            }
        }
        columns
    }
}
