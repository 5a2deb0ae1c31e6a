//! Decides without the library whether two bodies meet: tests all pairs of their primitives, in exact arithmetic where
//! floating-point numbers with a proven error bound do not decide.

mod balls;
mod integers;
mod rough;
mod triangles;

use super::draw::power_of_two;
use core::cmp::Ordering;
use rough::Rough;
use simdop::primitive::Sphere;
use simdop::primitive::triangle::Triangle;
use simdop::range::{MIN_COORDINATE, Point};

/// The rows of a pose: a rotation, and a translation in the last column.
pub(super) type Matrix = [[f64; 4]; 3];

/// The primitive of a leaf.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) enum Convex {
    Triangle(Triangle),
    Ball(Sphere),
}

/// A body of a trial.
#[derive(Clone, Debug)]
pub(super) struct Figure {
    /// The primitives, all of one kind.
    pub(super) items: Vec<Convex>,
    /// How many times the body contains each of them.
    pub(super) copies: usize,
    /// Whether the triangles bound a solid, which is convex.
    pub(super) is_solid: bool,
}

/// The exact answer at a pose.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Truth {
    pub(super) meets: bool,
    /// Whether the answer changes one unit in the last place along some axis.
    pub(super) is_knife_edge: bool,
}

impl Figure {
    pub(super) fn surface(triangles: Vec<Triangle>) -> Self {
        let items = triangles.into_iter().map(|t| Convex::Triangle(t.map(flushed))).collect();
        Self { items, copies: 1, is_solid: false }
    }

    pub(super) fn solid(triangles: Vec<Triangle>) -> Self {
        Self { is_solid: true, ..Self::surface(triangles) }
    }

    pub(super) fn spheres(spheres: Vec<Sphere>) -> Self {
        Self { items: spheres.into_iter().map(Convex::Ball).collect(), copies: 1, is_solid: false }
    }

    /// The triangles, each once.
    pub(super) fn triangles(&self) -> impl Iterator<Item = &Triangle> {
        self.items.iter().filter_map(|item| match item {
            Convex::Triangle(t) => Some(t),
            Convex::Ball(_) => None,
        })
    }

    fn moved(&self, rows: &Matrix) -> Vec<Bounded> {
        let place = |item: &Convex| match item {
            Convex::Triangle(t) => Convex::Triangle(t.map(|p| placed(rows, &p))),
            Convex::Ball(ball) => Convex::Ball(Sphere { centre: placed(rows, &ball.centre), ..*ball }),
        };
        self.items.iter().map(|item| Bounded::new(place(item))).collect()
    }
}

/// The moved point, as documented at [`simdop::pose::Pose::apply`]: verdicts are exact for corners rounded in this way.
pub(super) fn placed(rows: &Matrix, p: &Point) -> Point {
    flushed(rows.map(|[x, y, z, t]| ((x * p[0] + y * p[1]) + z * p[2]) + t))
}

fn flushed(p: Point) -> Point {
    p.map(|x| if x.abs() < MIN_COORDINATE { 0.0 } else { x })
}

/// A primitive and its box.
struct Bounded {
    item: Convex,
    low: Point,
    high: Point,
}

impl Bounded {
    fn new(item: Convex) -> Self {
        let (low, high) = match &item {
            Convex::Triangle([p, q, r]) => {
                let fold = |f: fn(f64, f64) -> f64| core::array::from_fn(|i| f(f(p[i], q[i]), r[i]));
                (fold(f64::min), fold(f64::max))
            }
            // One unit in the last place more than the rounding error of the sums.
            Convex::Ball(ball) => (
                ball.centre.map(|x| (x - ball.radius).next_down()),
                ball.centre.map(|x| (x + ball.radius).next_up()),
            ),
        };
        Self { item, low, high }
    }

    fn rough(&self, other: &Self, moved: f64) -> Rough {
        // Far more than the rounding errors of the sum.
        let reach = moved + moved;
        for i in 0..3 {
            if self.high[i] + reach < other.low[i] || other.high[i] + reach < self.low[i] {
                return Rough::Apart;
            }
        }
        match (&self.item, &other.item) {
            (Convex::Triangle(a), Convex::Triangle(b)) => triangles::rough(a, b, moved),
            (Convex::Ball(a), Convex::Ball(b)) => balls::rough_balls(a, b, moved),
            (Convex::Ball(ball), Convex::Triangle(t)) | (Convex::Triangle(t), Convex::Ball(ball)) => {
                balls::rough_ball_and_triangle(ball, t, moved)
            }
        }
    }
}

fn meet(a: &Convex, b: &Convex) -> bool {
    match (a, b) {
        (Convex::Triangle(a), Convex::Triangle(b)) => triangles::meet(a, b),
        (Convex::Ball(a), Convex::Ball(b)) => balls::balls_meet(a, b),
        (Convex::Ball(ball), Convex::Triangle(t)) | (Convex::Triangle(t), Convex::Ball(ball)) => {
            balls::ball_meets_triangle(ball, t)
        }
    }
}

/// Two bodies.
pub(super) struct Oracle<'t> {
    a: &'t Figure,
    b: &'t Figure,
    still: Vec<Bounded>,
}

impl<'t> Oracle<'t> {
    pub(super) fn new(a: &'t Figure, b: &'t Figure) -> Self {
        Self { a, b, still: b.items.iter().map(|item| Bounded::new(*item)).collect() }
    }

    /// Whether A, placed by the pose, meets B, or one is inside the other; and whether a neighbouring pose changes
    /// this.
    pub(super) fn truth(&self, rows: &Matrix) -> Truth {
        let moved = self.a.moved(rows);
        let step = step(rows, &moved);
        // The sum of a coordinate and a translation is off by half a unit before and after the step.
        match self.surfaces(&moved, 2.0 * step) {
            Rough::Together => Truth { meets: true, is_knife_edge: false },
            Rough::Apart => Truth { meets: self.is_inside(&moved), is_knife_edge: false },
            Rough::Doubt => {
                let meets = self.is_hit(&moved);
                let is_other = |(axis, step): (usize, f64)| {
                    let mut beside = *rows;
                    beside[axis][3] += step;
                    self.meets(&beside) != meets
                };
                let mut steps = (0..3).flat_map(|axis| [(axis, step), (axis, -step)]);
                Truth { meets, is_knife_edge: steps.any(is_other) }
            }
        }
    }

    pub(super) fn meets(&self, rows: &Matrix) -> bool {
        self.is_hit(&self.a.moved(rows))
    }

    /// Whether a hit may name these two primitives: they meet, or belong to bodies one of which is inside the other.
    pub(super) fn is_witness(&self, rows: &Matrix, a: u32, b: u32) -> bool {
        let is_there = |figure: &Figure, index: u32| (index as usize) < figure.items.len() * figure.copies;
        let is_inside = || {
            let moved = self.a.moved(rows);
            self.is_inside(&moved) && self.pairs(rows).is_empty()
        };
        is_there(self.a, a) && is_there(self.b, b) && (self.pair_meets(rows, a, b) || is_inside())
    }

    /// Whether these two primitives meet, by their indices in the bodies.
    fn pair_meets(&self, rows: &Matrix, a: u32, b: u32) -> bool {
        let item = |figure: &'t Figure, index: u32| &figure.items[index as usize % figure.items.len()];
        let moved = match item(self.a, a) {
            Convex::Triangle(t) => Convex::Triangle(t.map(|p| placed(rows, &p))),
            Convex::Ball(ball) => Convex::Ball(Sphere { centre: placed(rows, &ball.centre), ..*ball }),
        };
        meet(&moved, item(self.b, b))
    }

    /// All pairs of primitives that meet, in ascending order, without copies.
    pub(super) fn pairs(&self, rows: &Matrix) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (a, i) in self.a.moved(rows).iter().zip(0..) {
            for (b, j) in self.still.iter().zip(0..) {
                let is_hit = match a.rough(b, 0.0) {
                    Rough::Together => true,
                    Rough::Apart => false,
                    Rough::Doubt => meet(&a.item, &b.item),
                };
                if is_hit {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    }

    /// Whether any primitives meet, for all positions of A's primitives within `moved` of the given ones.
    fn surfaces(&self, placed: &[Bounded], moved: f64) -> Rough {
        let mut all = Rough::Apart;
        for (a, b) in placed.iter().flat_map(|a| self.still.iter().map(move |b| (a, b))) {
            match a.rough(b, moved) {
                Rough::Together => return Rough::Together,
                Rough::Apart => {}
                Rough::Doubt => all = Rough::Doubt,
            }
        }
        all
    }

    fn is_hit(&self, moved: &[Bounded]) -> bool {
        let mut doubts = Vec::new();
        for (a, b) in moved.iter().flat_map(|a| self.still.iter().map(move |b| (a, b))) {
            match a.rough(b, 0.0) {
                Rough::Together => return true,
                Rough::Apart => {}
                Rough::Doubt => doubts.push((a, b)),
            }
        }
        doubts.into_iter().any(|(a, b)| meet(&a.item, &b.item)) || self.is_inside(moved)
    }

    /// Whether one of two bodies whose surfaces do not meet is inside the other: then all of its corners are on one
    /// side of all faces.
    fn is_inside(&self, moved: &[Bounded]) -> bool {
        self.b.is_solid && contains(&self.still, moved) || self.a.is_solid && contains(moved, &self.still)
    }
}

fn contains(solid: &[Bounded], other: &[Bounded]) -> bool {
    let Some(Bounded { item: Convex::Triangle([corner, ..]), .. }) = other.first() else { return false };
    let mut sides = solid.iter().filter_map(|face| match &face.item {
        Convex::Triangle(t) => Some(triangles::side(t, corner)),
        Convex::Ball(_) => None,
    });
    let first = sides.next();
    first.is_some() && first != Some(Ordering::Equal) && sides.all(|side| Some(side) == first)
}

/// One unit in the last place of the largest coordinate among the summands and sums: the translation and the placed
/// points.
fn step(rows: &Matrix, moved: &[Bounded]) -> f64 {
    let ends = moved.iter().flat_map(|item| item.low.iter().chain(&item.high));
    let greatest = rows.iter().map(|row| &row[3]).chain(ends).fold(0.0, |m: f64, x| m.max(x.abs()));
    (greatest.next_up() - greatest).max(power_of_two(-1000))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::draw::{Draw, NO_TURN, dot, minus, scaled};
    use crate::selftest::figures::{matrix, polytope};

    const AT_ORIGIN: Point = [0.0; 3];

    fn tetrahedron(size: f64) -> Vec<Triangle> {
        let [o, x, y, z] = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
        vec![[o, y, x], [o, x, z], [x, y, z], [y, o, z]]
    }

    #[test]
    fn a_solid_holds_what_is_inside() {
        let large = tetrahedron(1.0);
        let small = Figure::surface(tetrahedron(0.125));
        let at = |x: f64| matrix(&NO_TURN, &[x, 0.25, 0.25]);
        let truth = |large: &Figure, x| Oracle::new(&small, large).truth(&at(x));
        let (solid, surface) = (Figure::solid(large.clone()), Figure::surface(large));
        let certain = |meets| Truth { meets, is_knife_edge: false };
        assert_eq!(truth(&solid, 0.0625), certain(true));
        assert_eq!(truth(&surface, 0.0625), certain(false));
        assert_eq!(truth(&solid, 3.0), certain(false));
        assert_eq!(truth(&solid, 0.45), certain(true));
        assert_eq!(truth(&surface, 0.45), certain(true), "through the slanted face");
        // B inside A.
        assert_eq!(Oracle::new(&solid, &small).truth(&matrix(&NO_TURN, &[-0.0625; 3])), certain(true));
        assert_eq!(Oracle::new(&surface, &small).truth(&matrix(&NO_TURN, &[-0.0625; 3])), certain(false));
    }

    #[test]
    fn a_pose_on_the_edge_is_told_from_its_neighbours() {
        let body = Figure::surface(tetrahedron(1.0));
        let oracle = Oracle::new(&body, &body);
        let at = |x| oracle.truth(&matrix(&NO_TURN, &[x, 0.0, 0.0]));
        let truth = |meets, is_knife_edge| Truth { meets, is_knife_edge };
        assert_eq!(at(1.0), truth(true, true));
        assert_eq!(at(1.0_f64.next_up()), truth(false, true));
        assert_eq!(at(1.0 + 4.0 * f64::EPSILON), truth(false, false));
        // For neighbouring poses there is still a common point, along the edges.
        assert_eq!(at(0.5), truth(true, false));
    }

    #[test]
    fn pairs_are_all_that_meet() {
        let body = Figure::surface(tetrahedron(1.0));
        let oracle = Oracle::new(&body, &body);
        assert_eq!(oracle.pairs(&matrix(&NO_TURN, &AT_ORIGIN)).len(), 16);
        let rows = matrix(&NO_TURN, &[1.0, 0.0, 0.0]);
        let pairs = oracle.pairs(&rows);
        // The corner x of B, in three triangles, and the origin of A, in three.
        assert_eq!(pairs.len(), 9);
        assert!(pairs.iter().all(|&(i, j)| oracle.pair_meets(&rows, i, j)));
        assert!(!oracle.pair_meets(&rows, 2, 2));
        let many = Figure { copies: 5, ..body.clone() };
        assert!(Oracle::new(&many, &body).pair_meets(&rows, 4, 0), "a copy of triangle 0");
    }

    /// The polytopes are convex and consistently oriented, as [`contains`] assumes: their centre is inside, and each
    /// corner is on or within each face, also after rounding.
    #[test]
    fn polytopes_are_convex() {
        for i in 0..200 {
            let mut draw = Draw::new(8, "", i, i % 2 == 0);
            let faces = polytope(&mut draw);
            let faces = draw.placed(&faces, &draw_turn(i), &[0.5; 3]);
            let corners: Vec<Point> = faces.iter().flatten().copied().collect();
            for t in &faces {
                assert_eq!(triangles::side(t, &[0.5; 3]), Ordering::Less);
                for p in corners.iter().filter(|p| !t.contains(p)) {
                    assert_eq!(triangles::side(t, p), Ordering::Less, "{t:?} {p:?}");
                }
            }
        }
    }

    fn draw_turn(i: u64) -> super::super::draw::Turn {
        Draw::new(9, "", i, false).turn()
    }

    /// Compares bodies of balls with sums in `f64` where these are conclusive.
    #[test]
    fn balls_meet_where_their_distance_says() {
        let mut draw = Draw::new(10, "", 0, false);
        for _ in 0..500 {
            let mut ball = || Sphere { centre: draw.direction(), radius: draw.range(0.0, 0.5) };
            let (a, b) = (ball(), ball());
            let shift = scaled(&draw.direction(), 0.5);
            let way = minus(&placed(&matrix(&NO_TURN, &shift), &a.centre), &b.centre);
            let gap = dot(&way, &way).sqrt() - a.radius - b.radius;
            let (a, b) = (Figure::spheres(vec![a]), Figure::spheres(vec![b]));
            let truth = Oracle::new(&a, &b).truth(&matrix(&NO_TURN, &shift));
            assert!(truth.meets == (gap < 0.0) && !truth.is_knife_edge || gap.abs() < 1e-12);
        }
    }
}
