//! Solids: whether a body that meets no primitive of another is inside the other.
//!
//! Each part of a body is connected. If it meets no triangle of a solid, it is entirely inside or entirely outside, so
//! one moved corner decides. The corner is inside if the winding number of the surface about it is not zero: the sum
//! over the triangles that a ray from the corner crosses, 1 where the ray leaves and -1 where it enters
//! ([`Primitive::crossing`]). The ray runs along the first axis of B's frame, whichever body is the solid, so that the
//! test uses the same numbers as all others: corners of A as [`Pose::apply`] moves them.
//!
//! The sum includes the [caps](BvhRef::caps) of the solid. A part that meets no triangle may meet a cap, and then is
//! neither entirely inside nor entirely outside. It counts as inside: [`Query::collide`] and [`Query::distance`] test
//! the tree of the caps as well.
//!
//! For the volumes of the solid's tree the ray is a k-DOP ([`Ray`]), with which the kernels traverse the tree. None of
//! this runs in a traversal: it is called only if a body is solid and no primitives met.

use super::entry::{Found, Query, QueryStats};
use super::lanes::Lanes;
use super::setup::PlacedTree;
use crate::frame::BodyBounds;
use crate::hierarchy::{BvhRef, MAX_DEPTH};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::Link;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::range::Point;
use crate::realign::Ray;

/// The relation of bodies whose primitives do not meet.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) enum Containment {
    /// Neither has a part inside the other.
    Outside,
    /// A part of one is inside the other, which is solid. `found` holds the part's primitive and, among the primitives
    /// that the ray crosses, the one with the lowest source index. The point is in both bodies.
    Inside { found: Found, point: Point },
    /// The budget was spent before the relation was known. The distance of the bodies is at most `upper`.
    OutOfBudget { upper: f64 },
}

/// A part that is inside a solid: the primitive that represents it, the solid's primitive to report with it (one that
/// the ray crosses, or one beside a cap that it crosses), and a point of the part.
struct Inner {
    part: u32,
    crossed: u32,
    point: Point,
}

/// A node on the path, and its children that are still to be visited.
#[derive(Copy, Clone)]
struct Descended {
    node: u32,
    lanes: u16,
}

impl Query {
    /// Whether a part of either body is inside the other, given that no primitives meet. Adds its work to the query
    /// statistics, whose visits the budget bounds.
    // Not inlined: programs whose bodies are surfaces do not need it.
    #[cold]
    #[inline(never)]
    pub(in crate::query) fn place<N: Lanes, P: Primitive, Q: Primitive>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        stats: &mut QueryStats,
    ) -> Containment {
        let mut find = || {
            if b.is_solid()
                && let Some(Inner { part, crossed, point }) =
                    self.first_inner(a, Some(pose), &PlacedTree { tree: b, pose: None }, stats)?
            {
                return Ok(Some((Found { a: part, b: crossed }, point)));
            }
            if a.is_solid()
                && let Some(Inner { part, crossed, point }) =
                    self.first_inner(b, None, &PlacedTree { tree: a, pose: Some(pose) }, stats)?
            {
                return Ok(Some((Found { a: crossed, b: part }, point)));
            }
            Ok(None)
        };
        match find() {
            Ok(None) => Containment::Outside,
            Ok(Some((found, point))) => Containment::Inside { found, point },
            Err(upper) => Containment::OutOfBudget { upper },
        }
    }

    /// The first part of a body that is inside a solid; a pose, if given, places the body. If the budget was spent, the
    /// error is an upper bound of the distance of the bodies.
    fn first_inner<N: Lanes, P: Primitive, Q: Primitive>(
        &self,
        body: &BvhRef<'_, N, Q>,
        pose: Option<&Pose>,
        solid: &PlacedTree<'_, N, P>,
        stats: &mut QueryStats,
    ) -> Result<Option<Inner>, f64> {
        for part in body.parts() {
            let point = Q::point(&body.primitive(part));
            let point = pose.map_or(point, |pose| pose.apply(point));
            let extent = body.extent();
            let beside = solid.pose.map(|pose| (pose, &extent));
            let Some(ray) = Ray::new(&point, solid.tree.header(), beside) else { continue };
            if let Some(crossed) = self.around(solid, &point, &ray, stats)? {
                return Ok(Some(Inner { part, crossed, point }));
            }
        }
        Ok(None)
    }

    /// If a solid, placed by a pose, winds around a point, the crossed primitive with the lowest source index. `of`
    /// bounds the body of the point. An error if the budget was spent.
    pub(crate) fn winds_around<N: Lanes, P: Primitive>(
        &self,
        solid: &BvhRef<'_, N, P>,
        pose: &Pose,
        point: &Point,
        of: &BodyBounds,
        stats: &mut QueryStats,
    ) -> Result<Option<u32>, f64> {
        let Some(ray) = Ray::new(point, solid.header(), Some((pose, of))) else { return Ok(None) };
        self.around(&PlacedTree { tree: solid, pose: Some(pose) }, point, &ray, stats)
    }

    /// If a solid winds around a point of its own frame, the crossed primitive with the lowest source index. An error
    /// if the budget was spent.
    pub(in crate::query) fn inside_of_solid<N: Lanes, P: Primitive>(
        &self,
        solid: &BvhRef<'_, N, P>,
        point: &Point,
        stats: &mut QueryStats,
    ) -> Result<Option<u32>, f64> {
        let Some(ray) = Ray::new(point, solid.header(), None) else { return Ok(None) };
        self.around(&PlacedTree { tree: solid, pose: None }, point, &ray, stats)
    }

    /// If the solid winds around the point, the crossed primitive with the lowest source index. If the budget was
    /// spent, the error is an upper bound of the distance of the point from the solid.
    fn around<N: Lanes, P: Primitive>(
        &self,
        solid: &PlacedTree<'_, N, P>,
        point: &Point,
        ray: &Ray,
        stats: &mut QueryStats,
    ) -> Result<Option<u32>, f64> {
        on_isa!(self.isa(), token => around_on(token.narrow(), solid, point, ray, self.budget(), stats))
    }
}

/// Not inlined: the stack frame of the scalar code would add to that of the selected instruction set.
#[inline(never)]
fn around_on<N: Lanes, P: Primitive, E: Kernel>(
    kernel: E,
    solid: &PlacedTree<'_, N, P>,
    point: &Point,
    ray: &Ray,
    budget: u64,
    stats: &mut QueryStats,
) -> Result<Option<u32>, f64> {
    kernel.run(
        #[inline(always)]
        || {
            let mut aimed = N::NO_AIMED;
            N::aim_ray(&mut aimed, &solid.tree.frame(), ray);
            let mut winding = 0_i64;
            let mut lowest: Option<u32> = None;
            let mut path = [Descended { node: 0, lanes: 0 }; MAX_DEPTH];
            let mut level = 0;
            let mut next = (!solid.tree.is_empty()).then_some(0);
            // The primitives, then the caps: their tree has the same frame, so that the ray's planes are the same.
            let caps = solid.tree.caps();
            let mut tree = solid.tree;
            let mut of_caps = caps.as_ref();
            loop {
                // A loop with a single call of the kernel, so that it is inlined.
                if let Some(node) = next.take() {
                    if stats.visits == budget {
                        return Err(distance_bound(solid, point));
                    }
                    stats.visits += 1;
                    let lanes = tree.nodes()[node as usize].overlap_aimed(kernel, &aimed);
                    stats.kernels += 1;
                    path[level] = Descended { node, lanes };
                    level += 1;
                }
                let Some(above) = level.checked_sub(1) else {
                    let Some(caps) = of_caps.take() else { break };
                    (tree, next) = (caps, Some(0));
                    continue;
                };
                let Descended { node, lanes } = &mut path[above];
                if *lanes == 0 {
                    level = above;
                    continue;
                }
                let lane = lanes.trailing_zeros() as usize;
                *lanes &= lanes.wrapping_sub(1);
                let link = tree.nodes()[*node as usize].children()[lane].link();
                if let Link::Inner(below) = link {
                    next = Some(below);
                }
                for index in link.primitives() {
                    stats.primitive_pairs += 1;
                    let item = PlacedTree { tree, pose: solid.pose }.item(index);
                    let crossed = P::crossing(&item, point, &mut stats.exact_pairs);
                    let named = if core::ptr::eq(tree, solid.tree) { index } else { tree.source(index) };
                    let is_lower = |lowest| solid.tree.source(named) < solid.tree.source(lowest);
                    if crossed != 0 && lowest.is_none_or(is_lower) {
                        lowest = Some(named);
                    }
                    winding += i64::from(crossed);
                }
            }
            Ok(lowest.filter(|_| winding != 0))
        },
    )
}

/// The distance of a point from some corner of a body, rounded up.
#[cold]
fn distance_bound<N: Lanes, P: Primitive>(body: &PlacedTree<'_, N, P>, point: &Point) -> f64 {
    let corner = glam::DVec3::from_array(P::point(&body.item(0)));
    glam::DVec3::from_array(*point).distance(corner) * (1.0 + 8.0 * f64::EPSILON)
}
