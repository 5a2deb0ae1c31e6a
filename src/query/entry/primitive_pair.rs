//! The tests of pairs of primitives.

use crate::exact::power_of_two;
use crate::kernel::Kernel;
use crate::primitive::shape::{self, Core, Depth};
use crate::primitive::sphere::against_sphere;
use crate::primitive::sphere_against_triangle as against_triangle;
use crate::primitive::triangle::distance::{nearer, within};
use crate::primitive::triangle::{Probe, Triangle, Triangles};
use crate::primitive::{Primitive, Separation, Shape, Shapes, Sphere, Spheres};
use crate::vector::{difference, length};

/// The tests of a primitive of this kind against one of the `Other` kind. A query between two bodies needs them for
/// both orders, since a leaf of either body may be tested against several of the other.
///
/// Verdicts are exact for the primitives as given; `exact` is increased by 1 where a test needed more than `f64`.
pub trait PrimitivePair<Other: Primitive>: Primitive {
    /// A primitive to be tested against many, with what is computed from it once.
    type Probe<'t>;

    /// Prepares a primitive for tests against others with this margin.
    fn probe(item: &Self::Item, margin: f64) -> Self::Probe<'_>;

    /// Whether the two meet. Touching counts as meeting.
    fn meets(probe: &Self::Probe<'_>, other: &Other::Item, exact: &mut u64) -> bool;

    /// Bit i: the probe and primitive i are certainly farther apart than the margin of the probe; for margin 0, they do
    /// not meet. An optional filter, with the same bits on every instruction set.
    #[inline(always)]
    fn apart_4<E: Kernel>(_kernel: E, _probe: &Self::Probe<'_>, _others: &[Other::Item; 4]) -> u16 {
        0
    }

    /// Whether the two are at most `margin` apart, which is above 0. Never falsely false.
    fn within(item: &Self::Item, other: &Other::Item, margin: f64, exact: &mut u64) -> bool;

    /// Certain bounds of the distance, or `None` if it is certainly greater than `limit`. The bounds differ by at most
    /// `tolerance` relatively, which is at least 2^-42. The upper one is 0 if and only if the two meet.
    fn nearer(
        item: &Self::Item,
        other: &Other::Item,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation>;

    /// [`PrimitivePair::nearer`], compiled once for each instruction set, not for each caller.
    #[inline(never)]
    fn nearer_on<E: Kernel>(
        kernel: E,
        item: &Self::Item,
        other: &Other::Item,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        kernel.run(
            #[inline(always)]
            || Self::nearer(item, other, limit, tolerance, exact),
        )
    }

    /// Bounds of the length of the shortest translation of the first after which the two do not meet, certain up to the
    /// rounding of positions; zeros for two that are apart. For two triangles, they are 0 and infinite.
    fn depth(_item: &Self::Item, _other: &Other::Item) -> Depth {
        Depth { lower: 0.0, upper: f64::INFINITY, direction: [0.0; 3] }
    }
}

/// Tolerance of a depth.
const TOLERANCE: f64 = power_of_two(-12);

impl PrimitivePair<Self> for Triangles {
    type Probe<'t> = Probe<'t>;

    #[inline(always)]
    fn probe(item: &Triangle, margin: f64) -> Probe<'_> {
        Probe::with_margin(item, margin)
    }

    #[inline(always)]
    fn meets(probe: &Probe<'_>, other: &Triangle, exact: &mut u64) -> bool {
        probe.overlaps(other, exact)
    }

    #[inline(always)]
    fn apart_4<E: Kernel>(kernel: E, probe: &Probe<'_>, others: &[Triangle; 4]) -> u16 {
        kernel.apart_4(probe, others)
    }

    #[inline(always)]
    fn within(item: &Triangle, other: &Triangle, margin: f64, exact: &mut u64) -> bool {
        within(item, other, margin, exact)
    }

    #[inline(always)]
    fn nearer(
        item: &Triangle,
        other: &Triangle,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        nearer(item, other, limit, tolerance, exact)
    }
}

impl PrimitivePair<Self> for Spheres {
    type Probe<'t> = &'t Sphere;

    #[inline(always)]
    fn probe(item: &Sphere, _margin: f64) -> &Sphere {
        item
    }

    #[inline(always)]
    fn meets(probe: &&Sphere, other: &Sphere, exact: &mut u64) -> bool {
        against_sphere::is_within(probe, other, 0.0, exact)
    }

    #[inline(always)]
    fn within(item: &Sphere, other: &Sphere, margin: f64, exact: &mut u64) -> bool {
        against_sphere::is_within(item, other, margin, exact)
    }

    #[inline(always)]
    fn nearer(
        item: &Sphere,
        other: &Sphere,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        against_sphere::nearer(item, other, limit, tolerance, exact)
    }

    fn depth(item: &Sphere, other: &Sphere) -> Depth {
        let apart = difference(&item.centre, &other.centre);
        let (sum, far) = (item.radius + other.radius, length(&apart));
        let direction = if far > 0.0 { apart.map(|x| x / far) } else { [0.0, 0.0, 1.0] };
        let rounding = 8.0 * f64::EPSILON * (sum + far);
        let [lower, upper] =
            [(sum - far) - rounding, (sum - far) + rounding].map(|x| if x > 0.0 { x } else { 0.0 });
        Depth { lower, upper, direction }
    }
}

impl PrimitivePair<Triangles> for Spheres {
    type Probe<'t> = &'t Sphere;

    #[inline(always)]
    fn probe(item: &Sphere, _margin: f64) -> &Sphere {
        item
    }

    #[inline(always)]
    fn meets(probe: &&Sphere, other: &Triangle, exact: &mut u64) -> bool {
        against_triangle::is_within(probe, other, 0.0, exact)
    }

    #[inline(always)]
    fn within(item: &Sphere, other: &Triangle, margin: f64, exact: &mut u64) -> bool {
        against_triangle::is_within(item, other, margin, exact)
    }

    #[inline(always)]
    fn nearer(
        item: &Sphere,
        other: &Triangle,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        against_triangle::nearer(item, other, limit, tolerance, exact)
    }

    fn depth(item: &Sphere, other: &Triangle) -> Depth {
        shape::depth(&Self::shape(item), &Triangles::shape(other), TOLERANCE)
    }
}

impl PrimitivePair<Spheres> for Triangles {
    type Probe<'t> = &'t Triangle;

    #[inline(always)]
    fn probe(item: &Triangle, _margin: f64) -> &Triangle {
        item
    }

    #[inline(always)]
    fn meets(probe: &&Triangle, other: &Sphere, exact: &mut u64) -> bool {
        against_triangle::is_within(other, probe, 0.0, exact)
    }

    #[inline(always)]
    fn within(item: &Triangle, other: &Sphere, margin: f64, exact: &mut u64) -> bool {
        against_triangle::is_within(other, item, margin, exact)
    }

    #[inline(always)]
    fn nearer(
        item: &Triangle,
        other: &Sphere,
        limit: f64,
        tolerance: f64,
        exact: &mut u64,
    ) -> Option<Separation> {
        let found = against_triangle::nearer(other, item, limit, tolerance, exact)?;
        Some(Separation { a: found.b, b: found.a, ..found })
    }

    fn depth(item: &Triangle, other: &Sphere) -> Depth {
        shape::depth(&Self::shape(item), &Spheres::shape(other), TOLERANCE)
    }
}

/// A primitive as a shape.
trait AsShape: Primitive {
    fn shape(item: &Self::Item) -> Shape;
}

impl AsShape for Shapes {
    #[inline(always)]
    fn shape(item: &Shape) -> Shape {
        *item
    }
}

impl AsShape for Triangles {
    #[inline(always)]
    fn shape(item: &Triangle) -> Shape {
        Shape::unchecked(Core::Triangle(*item), 0.0)
    }
}

impl AsShape for Spheres {
    #[inline(always)]
    fn shape(item: &Sphere) -> Shape {
        Shape::unchecked(Core::Point(item.centre), item.radius)
    }
}

macro_rules! pairs_of_shapes {
    ($($a:ident $b:ident),*) => {
        $(impl PrimitivePair<$b> for $a {
            type Probe<'t> = Shape;

            #[inline(always)]
            fn probe(item: &Self::Item, _margin: f64) -> Shape {
                Self::shape(item)
            }

            #[inline(always)]
            fn meets(probe: &Shape, other: &<$b as Primitive>::Item, exact: &mut u64) -> bool {
                shape::is_near(probe, &$b::shape(other), 0.0, exact)
            }

            #[inline(always)]
            fn within(item: &Self::Item, other: &<$b as Primitive>::Item, margin: f64, exact: &mut u64) -> bool {
                shape::is_near(&Self::shape(item), &$b::shape(other), margin, exact)
            }

            #[inline(always)]
            fn nearer(
                item: &Self::Item,
                other: &<$b as Primitive>::Item,
                limit: f64,
                tolerance: f64,
                exact: &mut u64,
            ) -> Option<Separation> {
                shape::nearer(&Self::shape(item), &$b::shape(other), limit, tolerance, exact)
            }

            fn depth(item: &Self::Item, other: &<$b as Primitive>::Item) -> Depth {
                shape::depth(&Self::shape(item), &$b::shape(other), TOLERANCE)
            }
        })*
    };
}

pairs_of_shapes!(Shapes Shapes, Shapes Triangles, Triangles Shapes, Shapes Spheres, Spheres Shapes);
