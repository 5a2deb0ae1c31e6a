//! Spheres.
//!
//! A sphere is a closed ball. Whether two of them meet, or one and a triangle, is decided exactly for the given
//! numbers: centres where [`Pose::apply`] puts them, and radii as stored. The tests run in plain `f64` with an error
//! bound, and fall back on integers where that does not decide. They compare squares, of degree two between spheres and
//! of degree six against the face of a triangle.
//!
//! The range of coordinates applies to the centre and to all points of the sphere: the radius is zero or at least
//! [`MIN_COORDINATE`](crate::range::MIN_COORDINATE), and no point has a coordinate beyond
//! [`MAX_COORDINATE`](crate::range::MAX_COORDINATE).

pub(crate) mod against_sphere;

pub use super::ball::Sphere;
pub(crate) use super::ball::volume;
use super::{Kind, Primitive, Store};
use crate::pose::Pose;
use crate::range::Point;

/// Spheres, stored as centre and radius: 16 bytes where `f32` holds the four numbers exactly, else 32, plus 4 for the
/// index. They may overlap.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Spheres;

impl Primitive for Spheres {
    const KIND: Kind = Kind::SPHERES;
    const IS_ROUND: bool = true;
    const HAS_BALLS: bool = true;
    const ARE_PARTS: bool = true;

    type Single = [f32; 4];
    type Double = Sphere;
    type Record = [u32; 1];
    type Item = Sphere;

    #[inline(always)]
    fn widen([x, y, z, radius]: [f32; 4]) -> Sphere {
        Sphere { centre: [x.into(), y.into(), z.into()], radius: radius.into() }
    }

    fn narrow(vertex: &Sphere) -> Option<[f32; 4]> {
        let Sphere { centre: [x, y, z], radius } = *vertex;
        let single = [x as f32, y as f32, z as f32, radius as f32];
        (Self::widen(single) == *vertex).then_some(single)
    }

    #[inline(always)]
    fn balls(vertex: &Sphere) -> impl Iterator<Item = Sphere> {
        core::iter::once(*vertex)
    }

    fn map(vertex: &Sphere, number: impl Fn(f64) -> f64) -> Sphere {
        Sphere { centre: vertex.centre.map(&number), radius: number(vertex.radius) }
    }

    fn is_among([vertex]: &[u32; 1], vertices: u32) -> bool {
        *vertex < vertices
    }

    #[inline(always)]
    fn item(store: &Store<'_, Self>, index: u32) -> Sphere {
        let [vertex] = *store.record(index);
        store.vertex(vertex)
    }

    #[inline(always)]
    fn corners(item: &Sphere) -> impl Iterator<Item = Point> {
        core::iter::once(item.centre)
    }

    #[inline(always)]
    fn radius(item: &Sphere) -> f64 {
        item.radius
    }

    #[inline(always)]
    fn moved(item: &Sphere, pose: &Pose) -> Sphere {
        Sphere { centre: pose.apply(item.centre), radius: item.radius }
    }
}
