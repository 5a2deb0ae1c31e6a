//! The deepest pair of spheres of two packings.

use super::interval::OutOfBudget;
use crate::frame::Frame;
use crate::hierarchy::BvhRef;
use crate::node::{Ball16, Link, Node};
use crate::pose::Pose;
use crate::primitive::{Primitive, Sphere, Spheres, radius_of};
use crate::range::Point;
use crate::vector::{difference, length};

/// Spheres inside two solids, as trees with [balls](BvhRef::balls), in the frames of their bodies. A depth query relies
/// on their being inside, as the spheres of a [packing](crate::packing) certainly are.
#[derive(Copy, Clone, Debug)]
pub struct Packings<'p, N> {
    /// Spheres inside body A.
    pub a: BvhRef<'p, N, Spheres>,
    /// Spheres inside body B.
    pub b: BvhRef<'p, N, Spheres>,
}

/// A tree of spheres that are a body, or are inside one.
pub(super) trait InnerBalls<N> {
    fn nodes(&self) -> &[N];
    fn balls(&self) -> &[Ball16];
    fn frame(&self) -> Frame;
    fn sphere(&self, index: u32) -> Sphere;
}

impl<N: Node, P: Primitive> InnerBalls<N> for BvhRef<'_, N, P> {
    fn nodes(&self) -> &[N] {
        BvhRef::nodes(self)
    }

    fn balls(&self) -> &[Ball16] {
        BvhRef::balls(self)
    }

    fn frame(&self) -> Frame {
        BvhRef::frame(self)
    }

    fn sphere(&self, index: u32) -> Sphere {
        let item = self.primitive(index);
        Sphere { centre: P::point(&item), radius: radius_of::<P>(&item) }
    }
}

/// Two spheres that overlap.
#[derive(Copy, Clone, Debug)]
pub(super) struct DeepestPair {
    /// How much the radii exceed the distance of the centres, up to rounding.
    pub(super) depth: f64,
    /// In A's frame.
    pub(super) a: Sphere,
    pub(super) b: Sphere,
}

/// The ball of a lane, in B's frame.
#[derive(Copy, Clone)]
struct PlacedBall {
    centre: Point,
    radius: f64,
    link: Link,
}

#[derive(Copy, Clone)]
struct PendingPair {
    bound: f64,
    a: PlacedBall,
    b: PlacedBall,
}

const ROOT: PlacedBall = PlacedBall { centre: [0.0; 3], radius: f64::INFINITY, link: Link::Inner(0) };

/// Capacity for pending pairs. If there is no room, those with the least bounds are dropped: the pair found may then be
/// less deep.
const MOST_WAITING: usize = 96;
/// Maximum number of visits; after it, too, the pair found may be less deep.
const MOST_VISITS: u64 = 96;

/// The deepest pair of spheres, with those of A moved by the pose, found best first. `None` if none overlap.
pub(super) fn deepest<N: Node>(
    [a, b]: [&dyn InnerBalls<N>; 2],
    pose: &Pose,
    visits: &mut u64,
    budget: u64,
) -> Result<Option<DeepestPair>, OutOfBudget> {
    if a.balls().is_empty() || b.balls().is_empty() {
        return Ok(None);
    }
    let mut waiting = [PendingPair { bound: f64::INFINITY, a: ROOT, b: ROOT }; MOST_WAITING];
    let (mut len, mut best, mut depth) = (1, None, 0.0);
    for _ in 0..MOST_VISITS {
        let next = waiting[..len].iter().enumerate().fold((0.0, None), |most, (i, pair)| {
            if pair.bound > most.0 { (pair.bound, Some(i)) } else { most }
        });
        let (bound, Some(at)) = next else { break };
        if bound <= depth {
            break;
        }
        if *visits == budget {
            return Err(OutOfBudget);
        }
        *visits += 1;
        let PendingPair { a: of_a, b: of_b, .. } = waiting[at];
        len -= 1;
        waiting[at] = waiting[len];
        let is_a_opened = matches!(of_a.link, Link::Inner(_))
            && (of_a.radius >= of_b.radius || !matches!(of_b.link, Link::Inner(_)));
        let mut add = |a: PlacedBall, b: PlacedBall| {
            let bound = a.radius + b.radius - length(&difference(&a.centre, &b.centre));
            if let (Some(i), Some(j)) = (sphere(&a), sphere(&b)) {
                if bound > depth {
                    (depth, best) = (bound, Some((i, j)));
                }
            } else if bound > depth {
                let least = |i: usize, j: usize| if waiting[j].bound < waiting[i].bound { j } else { i };
                let place = if len < MOST_WAITING { len } else { (1..len).fold(0, least) };
                if place == len {
                    len += 1;
                } else if waiting[place].bound >= bound {
                    return;
                }
                waiting[place] = PendingPair { bound, a, b };
            }
        };
        if is_a_opened {
            children(a, &of_a, Some(pose), &mut |child| add(child, of_b));
        } else {
            children(b, &of_b, None, &mut |child| add(of_a, child));
        }
    }
    Ok(best.map(|(i, j)| DeepestPair { depth, a: a.sphere(i), b: b.sphere(j) }))
}

/// The index of a volume that is one sphere.
const fn sphere(volume: &PlacedBall) -> Option<u32> {
    if let Link::Leaf { first, .. } = volume.link { Some(first) } else { None }
}

/// The children of a node; for leaves, their spheres.
fn children<N: Node>(
    tree: &dyn InnerBalls<N>,
    of: &PlacedBall,
    pose: Option<&Pose>,
    visit: &mut dyn FnMut(PlacedBall),
) {
    let Link::Inner(node) = of.link else { return };
    let place = |p: Point| pose.map_or(p, |pose| pose.unflushed(&p));
    let (frame, balls) = (tree.frame(), &tree.balls()[node as usize]);
    let unscale = 1.0 / frame.scale();
    for (lane, child) in tree.nodes()[node as usize].children().iter().enumerate() {
        match child.link() {
            Link::Empty => {}
            link @ Link::Inner(_) => {
                let ball = balls.lane(lane);
                let centre = core::array::from_fn(|i| frame.centre[i] + f64::from(ball.centre[i]) * unscale);
                visit(PlacedBall { centre: place(centre), radius: f64::from(ball.radius) * unscale, link });
            }
            link @ Link::Leaf { .. } => {
                for index in link.primitives() {
                    let Sphere { centre, radius } = tree.sphere(index);
                    visit(PlacedBall {
                        centre: place(centre),
                        radius,
                        link: Link::Leaf { first: index, count: 1 },
                    });
                }
            }
        }
    }
}
