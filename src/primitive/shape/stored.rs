//! Shapes as the primitives of a tree.

use super::convex::Shape;
use super::core::Core;
use super::error::ShapeError;
use super::hull::{Hull, radius_of};
use crate::pose::Pose;
use crate::primitive::{Kind, OWN_DIRECTIONS, Primitive, Sphere, Store};
use crate::range::Point;
use crate::vector::{difference, length};

/// Shapes, stored as their numbers: 56 bytes where `f32` holds these exactly, else 112, plus 4 for the index. They may
/// overlap. Half-spaces, which are not bounded, cannot be stored.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Shapes;

/// The most numbers of a shape: a cuboid's centre, half edges and radius.
const NUMBERS: usize = 13;

/// The numbers of a shape: those of its core, zeros, and last the radius around it.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ShapeNumbers {
    numbers: [f64; NUMBERS],
    kind: u64,
}

/// The numbers of a shape in single precision.
#[derive(Copy, Clone, PartialEq, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SingleShapeNumbers {
    numbers: [f32; NUMBERS],
    kind: u32,
}

const POINT: u64 = 1;
const SEGMENT: u64 = 2;
const TRIANGLE: u64 = 3;
const CUBOID: u64 = 4;
const CYLINDER: u64 = 5;
const CONE: u64 = 6;

impl TryFrom<&Shape> for ShapeNumbers {
    type Error = ShapeError;

    fn try_from(shape: &Shape) -> Result<Self, ShapeError> {
        let (kind, parts): (u64, [Point; 4]) = match shape.core {
            Core::Point(p) => (POINT, [p, [0.0; 3], [0.0; 3], [0.0; 3]]),
            Core::Segment([p, q]) => (SEGMENT, [p, q, [0.0; 3], [0.0; 3]]),
            Core::Triangle([p, q, r]) => (TRIANGLE, [p, q, r, [0.0; 3]]),
            Core::Cuboid { centre, half: [x, y, z] } => (CUBOID, [centre, x, y, z]),
            Core::Cylinder { centre, half_axis, radius } => {
                (CYLINDER, [centre, half_axis, [radius, 0.0, 0.0], [0.0; 3]])
            }
            Core::Cone { base, axis, radius } => (CONE, [base, axis, [radius, 0.0, 0.0], [0.0; 3]]),
            Core::HalfSpace { .. } => return Err(ShapeError::Unbounded),
        };
        let mut numbers = [0.0; NUMBERS];
        numbers[..NUMBERS - 1].copy_from_slice(parts.as_flattened());
        numbers[NUMBERS - 1] = shape.radius;
        Ok(Self { numbers, kind })
    }
}

impl ShapeNumbers {
    fn part(&self, index: usize) -> Point {
        let n = &self.numbers[3 * index..];
        [n[0], n[1], n[2]]
    }

    /// The shape, unchecked. `None` if there is no such kind.
    #[inline(always)]
    fn unchecked(&self) -> Option<Shape> {
        let part = |index: usize| self.part(index);
        let core = match self.kind {
            POINT => Core::Point(part(0)),
            SEGMENT => Core::Segment([part(0), part(1)]),
            TRIANGLE => Core::Triangle([part(0), part(1), part(2)]),
            CUBOID => Core::Cuboid { centre: part(0), half: [part(1), part(2), part(3)] },
            CYLINDER => Core::Cylinder { centre: part(0), half_axis: part(1), radius: self.numbers[6] },
            CONE => Core::Cone { base: part(0), axis: part(1), radius: self.numbers[6] },
            _ => return None,
        };
        Some(Shape { core, radius: self.numbers[NUMBERS - 1] })
    }

    /// The shape, if the numbers are those of one.
    fn checked(&self) -> Option<Shape> {
        let shape = self.unchecked()?;
        Shape::new(shape.core, shape.radius).ok().filter(|shape| Self::try_from(shape) == Ok(*self))
    }
}

impl Shape {
    /// A ball around the shape about a point of it: the centre and the radius. NaN for half-spaces.
    pub(crate) fn ball(&self) -> (Point, f64) {
        let (hull, centre) = (Hull::of(self), Shapes::point(self));
        let farthest = hull.corners().map(|p| length(&difference(&p, &centre))).fold(0.0, f64::max);
        (centre, farthest + hull.radius)
    }
}

impl Primitive for Shapes {
    const KIND: Kind = Kind::SHAPES;
    const IS_ROUND: bool = true;
    const ARE_PARTS: bool = true;

    type Single = SingleShapeNumbers;
    type Double = ShapeNumbers;
    type Record = [u32; 1];
    type Item = Shape;

    #[inline(always)]
    fn widen(single: SingleShapeNumbers) -> ShapeNumbers {
        ShapeNumbers { numbers: single.numbers.map(f64::from), kind: single.kind.into() }
    }

    fn narrow(vertex: &ShapeNumbers) -> Option<SingleShapeNumbers> {
        let single =
            SingleShapeNumbers { numbers: vertex.numbers.map(|x| x as f32), kind: vertex.kind as u32 };
        (Self::widen(single) == *vertex).then_some(single)
    }

    fn balls(vertex: &ShapeNumbers) -> impl Iterator<Item = Sphere> {
        // A half-space has no hull but NaN.
        let none = Shape { core: Core::HalfSpace { normal: [1.0, 0.0, 0.0], offset: 0.0 }, radius: 0.0 };
        let hull = Hull::of(&vertex.checked().unwrap_or(none));
        hull.corners().map(move |centre| Sphere { centre, radius: hull.radius })
    }

    fn map(vertex: &ShapeNumbers, number: impl Fn(f64) -> f64) -> ShapeNumbers {
        ShapeNumbers { numbers: vertex.numbers.map(number), ..*vertex }
    }

    fn is_among([vertex]: &[u32; 1], vertices: u32) -> bool {
        *vertex < vertices
    }

    #[inline(always)]
    fn item(store: &Store<'_, Self>, index: u32) -> Shape {
        let [vertex] = *store.record(index);
        // Stores are validated, so that each vertex is a shape.
        store.vertex(vertex).unchecked().unwrap_or_default()
    }

    /// The corners of a polytope around the core.
    #[inline(always)]
    fn corners(item: &Shape) -> impl Iterator<Item = Point> {
        Hull::of(item).corners()
    }

    #[inline(always)]
    fn radius(item: &Shape) -> f64 {
        radius_of(item)
    }

    #[inline(always)]
    fn point(item: &Shape) -> Point {
        match item.core {
            Core::Point(p)
            | Core::Segment([p, _])
            | Core::Triangle([p, ..])
            | Core::Cuboid { centre: p, .. }
            | Core::Cylinder { centre: p, .. }
            | Core::Cone { base: p, .. } => p,
            // Trees contain no half-spaces.
            Core::HalfSpace { .. } => [0.0; 3],
        }
    }

    #[inline(always)]
    fn moved(item: &Shape, pose: &Pose) -> Shape {
        item.moved(pose)
    }

    fn own_directions(item: &Shape) -> [[f64; OWN_DIRECTIONS]; 3] {
        let along: [Point; 3] = match &item.core {
            Core::Cuboid { half, .. } => *half,
            Core::Cylinder { half_axis: axis, .. } | Core::Cone { axis, .. } => [*axis, [0.0; 3], [0.0; 3]],
            Core::Point(_) | Core::Segment(_) | Core::Triangle(_) | Core::HalfSpace { .. } => [[0.0; 3]; 3],
        };
        let mut columns = [[0.0; OWN_DIRECTIONS]; 3];
        for (s, n) in along.iter().enumerate() {
            let size = n[0].abs().max(n[1].abs()).max(n[2].abs());
            if size > 0.0 {
                for i in 0..3 {
                    columns[i][s] = n[i] / size;
                }
            }
        }
        columns
    }
}
