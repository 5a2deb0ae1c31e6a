//! Where the first shape of a pair is: as it is given, or at a pose.

use super::convex::Shape;
use crate::pose::Pose;
use crate::range::{Point, flush};

/// Moves the numbers of a shape, with the bits of [`Shape::moved`].
pub(super) trait Placement: Copy {
    fn point(self, p: &Point) -> Point;
    fn vector(self, v: &Point) -> Point;
    /// Calls `f` with these vectors where they are.
    fn with_vectors<R>(self, vectors: &[Point; 3], f: impl FnOnce(&[Point; 3]) -> R) -> R;
    /// Calls `f` with the shape where it is.
    fn with<R>(self, shape: &Shape, f: impl FnOnce(&Shape) -> R) -> R;
}

/// The shape is not moved.
#[derive(Copy, Clone)]
pub(super) struct InPlace;

impl Placement for InPlace {
    #[inline(always)]
    fn point(self, p: &Point) -> Point {
        *p
    }

    #[inline(always)]
    fn vector(self, v: &Point) -> Point {
        *v
    }

    #[inline(always)]
    fn with_vectors<R>(self, vectors: &[Point; 3], f: impl FnOnce(&[Point; 3]) -> R) -> R {
        f(vectors)
    }

    #[inline(always)]
    fn with<R>(self, shape: &Shape, f: impl FnOnce(&Shape) -> R) -> R {
        f(shape)
    }
}

impl Placement for &Pose {
    #[inline(always)]
    fn point(self, p: &Point) -> Point {
        self.apply(*p)
    }

    #[inline(always)]
    fn vector(self, v: &Point) -> Point {
        let [x, y, z] = self.rotate(v);
        [flush(x), flush(y), flush(z)]
    }

    #[inline(always)]
    fn with_vectors<R>(self, [u, v, w]: &[Point; 3], f: impl FnOnce(&[Point; 3]) -> R) -> R {
        f(&[self.vector(u), self.vector(v), self.vector(w)])
    }

    #[inline(always)]
    fn with<R>(self, shape: &Shape, f: impl FnOnce(&Shape) -> R) -> R {
        f(&shape.moved_here(self))
    }
}
