//! Trees of balls around spheres, and the query that they are for.

use super::packing::Sphere;
use simdop::construct::{Builder, Mesh, Splitter};
use simdop::hierarchy::{Bvh, BvhRef};
use simdop::node::{Child, Link, Node as _, Node4};

/// A ball around the spheres below it; a sphere, if there is nothing below.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) ball: Sphere,
    children: Vec<Self>,
}

/// `x` goes to `rotation x + shift`.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Pose {
    pub(crate) rotation: [[f64; 3]; 3],
    pub(crate) shift: [f64; 3],
}

/// A tree, placed.
pub(crate) struct Moved<'t> {
    pub(crate) tree: &'t Node,
    pub(crate) pose: &'t Pose,
}

/// What a query does and finds.
#[derive(Copy, Clone, Default, PartialEq, Eq, Debug)]
pub(crate) struct Count {
    /// Of two nodes: up to four by four tests at once, for SIMD code.
    pub(crate) visits: u64,
    /// Of two balls.
    pub(crate) tests: u64,
    /// Of spheres that overlap.
    pub(crate) pairs: u64,
}

impl Pose {
    fn apply(&self, sphere: &Sphere) -> Sphere {
        let p = sphere.centre;
        let row = |i: usize| {
            let r = self.rotation[i];
            ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2]) + self.shift[i]
        };
        Sphere { centre: core::array::from_fn(row), radius: sphere.radius }
    }
}

impl Node {
    fn around(spheres: &[Sphere], items: &[u32], children: Vec<Self>) -> Self {
        let below: Vec<Sphere> = items.iter().map(|&i| spheres[i as usize]).collect();
        Self { ball: enclosing(&below), children }
    }

    /// Those that a visit tests: its children, or itself.
    fn parts(&self) -> &[Self] {
        if self.children.is_empty() { core::slice::from_ref(self) } else { &self.children }
    }

    /// The volume of a node's children together over its own, mean over the inner nodes.
    pub(crate) fn volume_ratio(&self) -> f64 {
        let (mut sum, mut count, mut open) = (0.0, 0.0, vec![self]);
        while let Some(node) = open.pop() {
            if !node.children.is_empty() {
                sum += node.children.iter().map(|c| c.ball.volume()).sum::<f64>() / node.ball.volume();
                count += 1.0;
                open.extend(&node.children);
            }
        }
        sum / count
    }

    /// Levels.
    pub(crate) fn depth(&self) -> usize {
        1 + self.children.iter().map(Self::depth).max().unwrap_or(0)
    }

    fn moved(&self, pose: &Pose) -> Self {
        let children = self.children.iter().map(|child| child.moved(pose)).collect();
        Self { ball: pose.apply(&self.ball), children }
    }
}

/// The ball around some balls, by Badoiu & Clarkson's walk towards the farthest: the radius is 1 % too large
/// at most, and encloses.
fn enclosing(balls: &[Sphere]) -> Sphere {
    let [.., first] = balls else { unreachable!("a node has spheres") };
    if balls.len() == 1 {
        return *first;
    }
    let mut centre = first.centre;
    let reach = |ball: &Sphere, centre| ball.distance(centre) + ball.radius;
    let farthest = |centre: [f64; 3]| {
        balls.iter().max_by(|a, b| reach(a, centre).total_cmp(&reach(b, centre))).expect("there is a first")
    };
    for step in 2..202 {
        let ball = farthest(centre);
        let distance = ball.distance(centre);
        // The far point of the ball is beyond its centre.
        let stretch = if distance > 0.0 { 1.0 + ball.radius / distance } else { 0.0 };
        let share = stretch / f64::from(step);
        centre = core::array::from_fn(|i| centre[i] + share * (ball.centre[i] - centre[i]));
    }
    // Some ulps for the rounding of distances.
    Sphere { centre, radius: reach(farthest(centre), centre) * (1.0 + 1e-12) }
}

/// The tree of a heuristic: `split` gives the parts of a node of several spheres, none of them empty and more
/// than one.
pub(crate) fn by_heuristic(spheres: &[Sphere], split: fn(&[Sphere], &[u32]) -> Vec<Vec<u32>>) -> Node {
    fn node(spheres: &[Sphere], items: &[u32], split: fn(&[Sphere], &[u32]) -> Vec<Vec<u32>>) -> Node {
        let parts = if items.len() > 1 { split(spheres, items) } else { Vec::new() };
        let children = parts.iter().map(|part| node(spheres, part, split)).collect();
        Node::around(spheres, items, children)
    }
    node(spheres, &(0..spheres.len() as u32).collect::<Vec<_>>(), split)
}

/// The tree that the library makes of triangles that stand for the spheres: a triangle has the sphere's
/// place, and an area in proportion to its volume; or the sphere's box, for what splits by boxes.
pub(crate) fn by_splitter(spheres: &[Sphere], splitter: Splitter) -> Node {
    let in_box = matches!(splitter, Splitter::MeanWidth | Splitter::SurfaceArea);
    let corners = |sphere: &Sphere| {
        let [x, y, z] = sphere.centre;
        let r = if in_box { sphere.radius } else { 1e-3 * sphere.volume().sqrt() };
        let flat = if in_box { r } else { 0.0 };
        [[x - r, y - r, z - flat], [x + r, y - r, z + flat], [x - r, y + r, z + flat]]
    };
    let vertices: Vec<[f64; 3]> = spheres.iter().flat_map(corners).collect();
    let triangles: Vec<[u32; 3]> = (0..spheres.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let tree: Bvh<Node4<6>> = Builder::new()
        .splitter(splitter)
        .build(&Mesh { vertices: &vertices, triangles: &triangles })
        .expect("spheres are finite");
    node_of(spheres, tree.view(), Child::ROOT).0
}

/// The node that a link leads to, and the spheres below it.
fn node_of(spheres: &[Sphere], tree: BvhRef<'_, Node4<6>>, child: Child) -> (Node, Vec<u32>) {
    match child.link() {
        Link::Empty => unreachable!("unused lanes are passed over"),
        Link::Leaf { first, .. } => {
            let items = vec![tree.source(first)];
            (Node::around(spheres, &items, Vec::new()), items)
        }
        Link::Inner(node) => {
            let used = tree.nodes()[node as usize].children().iter().filter(|c| c.link() != Link::Empty);
            let (children, items): (Vec<_>, Vec<_>) = used.map(|&c| node_of(spheres, tree, c)).unzip();
            let items = items.concat();
            (Node::around(spheres, &items, children), items)
        }
    }
}

/// Every pair of spheres that overlap.
pub(crate) fn overlaps(a: &Moved<'_>, b: &Node) -> Count {
    let moved = a.tree.moved(a.pose);
    let mut count = Count { visits: 0, tests: 1, pairs: 0 };
    let mut open = if moved.ball.overlaps(&b.ball) { vec![(&moved, b)] } else { Vec::new() };
    while let Some((a, b)) = open.pop() {
        if a.children.is_empty() && b.children.is_empty() {
            count.pairs += 1;
            continue;
        }
        count.visits += 1;
        for a in a.parts() {
            for b in b.parts() {
                count.tests += 1;
                if a.ball.overlaps(&b.ball) {
                    open.push((a, b));
                }
            }
        }
    }
    count
}

/// What [`overlaps`] must find.
pub(crate) fn pairs_by_brute_force(spheres: &[Sphere], pose: &Pose) -> u64 {
    let moved = spheres.iter().map(|sphere| pose.apply(sphere));
    moved.map(|a| spheres.iter().filter(|b| a.overlaps(b)).count() as u64).sum()
}
