//! Spheres as primitives: verdicts, pairs, margins and distances among themselves and with triangles, against
//! brute force in exact arithmetic; their planes, decided by squares; and what is rejected.

use crate::support::data::suite_step;
use crate::support::dyadic::{Dyadic, dot, is_rounded_up};
use crate::support::rng::Rng;
use crate::support::turns::pose;
use crate::{HalfNode, Pairs, pairs_that_meet, splitters};
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Mesh, SphereSet};
use simdop::hierarchy::{AnyBvh, Bvh, BvhRef, FormatError, NodeType};
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Storage};
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::triangle::Triangle;
use simdop::primitive::{Kind, Sphere, Spheres, Triangles};
use simdop::query::{Hint, Lanes, PrimitivePair, Query, QueryStats};
use simdop::range::{MAX_COORDINATE, MIN_COORDINATE, Point};

type Exact = [Dyadic; 3];

fn exact(p: &Point) -> Exact {
    p.map(Dyadic::from)
}

fn minus(p: &Exact, q: &Exact) -> Exact {
    core::array::from_fn(|i| p[i].clone() - q[i].clone())
}

fn square(p: &Exact) -> Dyadic {
    dot(p.clone(), p.clone())
}

fn cross(p: &Exact, q: &Exact) -> Exact {
    let minor = |i: usize, j: usize| p[i].clone() * q[j].clone() - p[j].clone() * q[i].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

/// A primitive for the oracle: the hull of corners, and a radius.
trait Shape: Copy {
    /// Squared distances of points of the hull from a point, as fractions. The least one is that of the nearest
    /// point.
    fn squares(&self, from: &Point) -> Vec<[Dyadic; 2]>;
    /// The sphere around a corner.
    fn ball(&self) -> Sphere;
    fn corners(&self) -> Vec<Point>;
    fn placed(&self, pose: &Pose) -> Self;
}

impl Shape for Sphere {
    fn squares(&self, from: &Point) -> Vec<[Dyadic; 2]> {
        vec![[square(&minus(&exact(&self.centre), &exact(from))), Dyadic::from(1.0)]]
    }

    fn ball(&self) -> Sphere {
        *self
    }

    fn corners(&self) -> Vec<Point> {
        vec![self.centre]
    }

    fn placed(&self, pose: &Pose) -> Self {
        Self { centre: pose.apply(self.centre), ..*self }
    }
}

impl Shape for Triangle {
    fn squares(&self, from: &Point) -> Vec<[Dyadic; 2]> {
        let corners = self.map(|p| minus(&exact(&p), &exact(from)));
        let mut found: Vec<_> = corners.iter().map(|p| [square(p), Dyadic::from(1.0)]).collect();
        let edges = [0, 1, 2].map(|i| minus(&corners[(i + 1) % 3], &corners[i]));
        for (p, edge) in corners.iter().zip(&edges) {
            let (length, along) = (square(edge), Dyadic::zero() - dot(edge.clone(), p.clone()));
            if along > Dyadic::zero() && along < length {
                found.push([square(p) * length.clone() - along.clone() * along, length]);
            }
        }
        let normal = cross(&edges[0], &edges[1]);
        let is_over = |i: usize| {
            let inwards = cross(&normal, &edges[i]);
            dot(inwards, corners[i].clone()) <= Dyadic::zero()
        };
        if square(&normal) > Dyadic::zero() && (0..3).all(is_over) {
            let height = dot(normal.clone(), corners[0].clone());
            found.push([height.clone() * height, square(&normal)]);
        }
        found
    }

    fn ball(&self) -> Sphere {
        Sphere { centre: self[0], radius: 0.0 }
    }

    fn corners(&self) -> Vec<Point> {
        self.to_vec()
    }

    fn placed(&self, pose: &Pose) -> Self {
        self.map(|p| pose.apply(p))
    }
}

/// Compares a shape's distance from a sphere with `margin`. At most one of the two is not a sphere.
fn compare<A: Shape, B: Shape>(a: &A, b: &B, margin: f64) -> core::cmp::Ordering {
    let reach = Dyadic::from(a.ball().radius) + Dyadic::from(b.ball().radius) + Dyadic::from(margin);
    let squares =
        if a.corners().len() > 1 { a.squares(&b.ball().centre) } else { b.squares(&a.ball().centre) };
    squares.iter().map(|[x, y]| x.cmp(&(reach.clone() * reach.clone() * y.clone()))).min().unwrap()
}

/// Whether the boxes are farther apart than `margin`, by far more than rounding: such pairs are not compared
/// exactly.
fn are_far<A: Shape, B: Shape>(a: &A, b: &B, margin: f64) -> bool {
    let bounds = |corners: Vec<Point>, i: usize| {
        let x = || corners.iter().map(|p| p[i]);
        (x().fold(f64::INFINITY, f64::min), x().fold(f64::NEG_INFINITY, f64::max))
    };
    let reach = (a.ball().radius + b.ball().radius + margin) * 1.001;
    (0..3).any(|i| {
        let ((p, q), (r, s)) = (bounds(a.corners(), i), bounds(b.corners(), i));
        (r - q).max(p - s) > reach + 1e-9 * (p.abs() + q.abs() + r.abs() + s.abs())
    })
}

/// The pairs at most `margin` apart, and how many are exactly at `margin`.
fn brute<A: Shape, B: Shape>(a: &[A], b: &[B], pose: &Pose, margin: f64) -> (Pairs, usize) {
    let (mut pairs, mut ties) = (Pairs::new(), 0);
    for (i, a) in a.iter().map(|a| a.placed(pose)).enumerate() {
        for (j, b) in b.iter().enumerate() {
            if !are_far(&a, b, margin) {
                let order = compare(&a, b, margin);
                ties += usize::from(order.is_eq());
                if order.is_le() {
                    pairs.insert((i as u32, j as u32));
                }
            }
        }
    }
    (pairs, ties)
}

fn build_with<N: Lanes>(spheres: &[Sphere], builder: Builder) -> Bvh<N, Spheres> {
    let tree = builder.build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap();
    tree.view().verify().unwrap();
    tree
}

fn build<N: Lanes>(spheres: &[Sphere]) -> Bvh<N, Spheres> {
    build_with(spheres, Builder::new())
}

fn mesh<N: Lanes>(triangles: &[Triangle]) -> Bvh<N> {
    let vertices: Vec<Point> = triangles.as_flattened().to_vec();
    let triangles: Vec<[u32; 3]> =
        (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Builder::new().build_as(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap()
}

const STRAIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const QUARTER: [[f64; 3]; 3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

/// The side of a lattice in which so many spheres are dense.
fn side(count: usize) -> i64 {
    if count < 100 { 6 } else { 16 }
}

/// Centres on a lattice and radii in halves, so that many spheres touch, for example at distances of (3, 4, 0)
/// and (1, 2, 2). Some are points, some are equal, some contain others.
fn lattice(rng: &mut Rng, count: usize, unit: f64, offset: f64) -> Vec<Sphere> {
    let mut spheres: Vec<Sphere> = Vec::new();
    for _ in 0..count {
        let centre = [(); 3].map(|()| offset + unit * rng.int(0, side(count)) as f64);
        let radius = unit * *rng.pick(&[0.0, 0.5, 1.0, 1.5, 2.5]);
        spheres.push(Sphere { centre, radius });
        if rng.below(16) == 0 {
            spheres.push(Sphere { centre, radius: *rng.pick(&[radius, 0.0, unit]) });
        }
    }
    spheres
}

/// Triangles between points of the same lattice, some of them flat.
fn lattice_triangles(rng: &mut Rng, count: usize, unit: f64, offset: f64) -> Vec<Triangle> {
    let corner = |rng: &mut Rng| [(); 3].map(|()| rng.int(0, side(count)) as f64);
    let mut triangles = Vec::new();
    for _ in 0..count {
        let p = corner(rng);
        let mut near = || p.map(|x| x + rng.int(-4, 4) as f64);
        let (q, r) = (near(), near());
        let r = if triangles.len() % 10 == 0 { q } else { r };
        triangles.push([p, q, r].map(|p| p.map(|x| offset + unit * x)));
    }
    triangles
}

/// Random spheres with radii in ratios from 1 to 10^6, few of them large.
fn unlike(rng: &mut Rng, count: usize, offset: f64) -> Vec<Sphere> {
    let mut sphere = || {
        let radius = 1e-6 / (rng.unit() + 1e-6);
        Sphere { centre: [(); 3].map(|()| offset + rng.range(-1.0, 1.0)), radius }
    };
    (0..count).map(|_| sphere()).collect()
}

/// All queries of one pair of bodies at one pose, on all instruction sets.
fn check<N, P, Q, A, B>(
    (tree_a, a): (&Bvh<N, P>, &[A]),
    (tree_b, b): (&Bvh<N, Q>, &[B]),
    pose: &Pose,
    what: &str,
) -> (usize, usize)
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    A: Shape,
    B: Shape,
{
    let (want, ties) = brute(a, b, pose, 0.0);
    let mut stats = None;
    for isa in Isa::available() {
        let query = Query::new(isa);
        assert_eq!(pairs_that_meet(query, tree_a, tree_b, pose).0, want, "{what}, {isa}");
        let answer = query.collide(tree_a, tree_b, pose);
        assert_eq!(answer.is_free(), want.is_empty(), "{what}, {isa}");
        assert!(answer.hit().is_none_or(|pair| want.contains(&(pair.a, pair.b))), "{what}, {isa}");
        let found = query.distance(tree_a, tree_b, pose, 0.0).unwrap();
        let work = (answer.stats, found.stats);
        assert_eq!(*stats.get_or_insert(work), work, "{what}, {isa}");
    }
    let query = Query::new(Isa::detect());
    check_distance(query, (tree_a, a), (tree_b, b), pose, !want.is_empty(), what);
    (want.len(), ties)
}

/// The bounds of the distance contain the exact distance, and `within` agrees with them.
fn check_distance<N, P, Q, A, B>(
    query: Query,
    (tree_a, a): (&Bvh<N, P>, &[A]),
    (tree_b, b): (&Bvh<N, Q>, &[B]),
    pose: &Pose,
    meet: bool,
    what: &str,
) where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    A: Shape,
    B: Shape,
{
    for tolerance in [0.0, 0.1] {
        let found = query.distance(tree_a, tree_b, pose, tolerance).unwrap();
        let witness = found.witness.unwrap();
        let (p, q) = (a[witness.pair.a as usize].placed(pose), b[witness.pair.b as usize]);
        let apart = (0..3).map(|i| (witness.a[i] - witness.b[i]).powi(2)).sum::<f64>().sqrt();
        let size = p.corners().iter().chain(&q.corners()).flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        let size = size + p.ball().radius + q.ball().radius;
        assert!((apart - found.upper).abs() <= 1e-11 * size, "{what}: witness {apart} {found:?}");
        if meet {
            assert_eq!((found.lower, found.upper), (0.0, 0.0), "{what}");
            assert!(compare(&p, &q, 0.0).is_le(), "{what}: the witness does not meet");
            continue;
        }
        assert!(
            found.lower > 0.0 && found.upper <= found.lower * (1.0 + tolerance + 1e-12),
            "{what}: {found:?}"
        );
        // The exact distance of the witness, and of all pairs.
        assert!(compare(&p, &q, found.upper).is_le(), "{what}: {found:?}");
        for a in a.iter().map(|a| a.placed(pose)) {
            let is_farther = |b: &B| are_far(&a, b, found.lower) || compare(&a, b, found.lower).is_ge();
            assert!(b.iter().all(is_farther), "{what}: {found:?}");
        }
        let within = |margin: f64| query.within(tree_a, tree_b, pose, margin).unwrap();
        assert!(within(found.lower * (1.0 - 1e-15)).is_free(), "{what}: {found:?}");
        assert!(within(found.upper).hit().is_some(), "{what}: {found:?}");
    }
}

/// Along a motion, each query has the hint of the one before: answers equal exact arithmetic, and cost one pair
/// as long as the last pair is still within the margin. Returns how many are hits, and how many cost no more
/// than that pair.
fn check_motion<N, P, Q, A, B>(
    (tree_a, a): (&Bvh<N, P>, &[A]),
    (tree_b, b): (&Bvh<N, Q>, &[B]),
    poses: &[Pose],
    margin: f64,
    what: &str,
) -> [usize; 2]
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    A: Shape,
    B: Shape,
{
    let (mut hint, mut last) = (Hint::NONE, None);
    let [mut hits, mut free_of_charge] = [0; 2];
    for (step, pose) in poses.iter().enumerate() {
        let what = format!("{what}, step {step}, margin {margin}");
        let (want, _) = brute(a, b, pose, margin);
        let ask = |query: Query| query.within(tree_a, tree_b, pose, margin).unwrap();
        let (plain, answer) = (ask(Query::new(Isa::SCALAR)), ask(Query::new(Isa::SCALAR).with_hint(hint)));
        assert!(Isa::available().all(|isa| ask(Query::new(isa).with_hint(hint)) == answer), "{what}");
        assert_eq!(answer.is_free(), want.is_empty(), "{what}");
        let found = answer.hit().map(|pair| (pair.a, pair.b));
        assert!(found.is_none_or(|pair| want.contains(&pair)), "{what}");
        let work = (answer.stats.visits, answer.stats.primitive_pairs);
        if last.is_some_and(|pair| want.contains(&pair)) {
            assert_eq!((found, work), (last, (0, 1)), "{what}");
            free_of_charge += 1;
        } else {
            // Far pairs are culled before the hint is tested.
            let is_told = plain.stats == QueryStats::default();
            let in_vain = u64::from(last.is_some() && !is_told);
            let plain = (plain.stats.visits, plain.stats.primitive_pairs + in_vain);
            assert_eq!(work, plain, "{what}");
        }
        let hinted = Query::new(Isa::detect()).with_hint(hint);
        if margin == 0.0 {
            assert_eq!(hinted.collide(tree_a, tree_b, pose), answer, "{what}");
            check_distance(hinted, (tree_a, a), (tree_b, b), pose, !want.is_empty(), &what);
        }
        hits += usize::from(found.is_some());
        last = found.or(last);
        hint = answer.hint;
    }
    [hits, free_of_charge]
}

/// Spheres and spheres, spheres and triangles, in both orders.
fn check_bodies<N: Lanes>(
    a: &[Sphere],
    b: &[Sphere],
    patches: &[Triangle],
    pose: &Pose,
    what: &str,
) -> [usize; 2] {
    let (tree_a, tree_b, tree_m) = (build::<N>(a), build::<N>(b), mesh::<N>(patches));
    let [x, y, z] = [
        check((&tree_a, a), (&tree_b, b), pose, &format!("{what}, spheres and spheres")),
        check((&tree_a, a), (&tree_m, patches), pose, &format!("{what}, spheres and triangles")),
        check((&tree_m, patches), (&tree_a, a), pose, &format!("{what}, triangles and spheres")),
    ];
    [x.0.min(y.0).min(z.0), x.1]
}

fn lattices<N: Lanes>(count: usize) {
    for (unit, offset) in [(1.0, 0.0), (2_f64.powi(-240), 0.0), (2_f64.powi(280), 0.0), (0.25, 1_048_576.0)] {
        let mut rng = Rng::new(21);
        let (a, b) = (lattice(&mut rng, count, unit, offset), lattice(&mut rng, count, unit, offset));
        let patches = lattice_triangles(&mut rng, count, unit, offset);
        let width = side(count) as f64;
        let poses = [
            pose(&STRAIGHT, [0.0; 3]),
            pose(&QUARTER, [2.0 * offset + width * unit, 0.0, unit]),
            pose(&[[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]], [unit, 0.0, 0.0]),
        ];
        for (i, pose) in poses.iter().enumerate() {
            let [meet, touch] =
                check_bodies::<N>(&a, &b, &patches, pose, &format!("unit {unit:e}, pose {i}"));
            let says_much = i == 2 || meet > count / 4 && touch > count / 20;
            assert!(says_much, "the test would say little: {meet} {touch}");
        }
        // Beside each other, with faces that touch, and one step of the translation apart.
        for x in [3.0, 4.0, 40.0, 1000.0].map(|x| (width + x) * unit) {
            let beside = pose(&STRAIGHT, [x, 0.0, 0.0]);
            check_bodies::<N>(&a, &b, &patches, &beside, &format!("unit {unit:e}, {:e} aside", x / unit));
        }
    }
}

#[test]
fn spheres_on_a_lattice_are_decided_as_exact_arithmetic_decides_them() {
    let count = 160 / suite_step();
    lattices::<Node16<18>>(count);
    if suite_step() == 1 {
        lattices::<Node4<14>>(60);
    }
}

#[test]
fn other_node_types_decide_alike() {
    fn one<N: Lanes>() {
        let mut rng = Rng::new(22);
        let (a, b) = (lattice(&mut rng, 70, 1.0, 0.0), lattice(&mut rng, 70, 1.0, 0.0));
        let (tree_a, tree_b) = (build::<N>(&a), build::<N>(&b));
        for pose in [pose(&rng.rotation(), [3.0, -2.0, 1.0]), pose(&QUARTER, [38.0, 0.0, 1.0])] {
            check((&tree_a, &a), (&tree_b, &b), &pose, core::any::type_name::<N>());
        }
    }
    // Tests without spheres cover the other differences between node types.
    one::<HalfNode>();
    one::<Node4<14>>();
    #[cfg(simdop_all_nodes)]
    {
        one::<Node16<6>>();
        one::<Node16<32>>();
        one::<Node4<18>>();
    }
}

#[test]
fn spheres_of_unlike_sizes_far_from_the_origin() {
    for offset in [0.0, 1e6] {
        let mut rng = Rng::new(23);
        let count = 300 / suite_step();
        let (a, b) = (unlike(&mut rng, count, offset), unlike(&mut rng, count, offset));
        let patches: Vec<Triangle> = (0..count / 4)
            .map(|_| [(); 3].map(|()| [(); 3].map(|()| offset + rng.range(-1.0, 1.0))))
            .collect();
        for far in [0.0, 2.5, 60.0] {
            let turn = rng.rotation();
            // The rotated centre of A is `far` from B's.
            let t = core::array::from_fn(|i| {
                offset - (turn[i][0] + turn[i][1] + turn[i][2]) * offset + if i == 0 { far } else { 0.0 }
            });
            check_bodies::<Node16<18>>(
                &a,
                &b,
                &patches,
                &pose(&turn, t),
                &format!("offset {offset:e}, {far}"),
            );
        }
    }
}

/// A matrix that is as far from a rotation as a pose may be shrinks volumes, but no sphere. If bounds shrank
/// with it, they would hide that the second pair is the nearest.
#[test]
fn spheres_keep_their_size_at_poses_that_shrink() {
    for share in [1.0 - 4.9e-5, 1.0 + 4.9e-5] {
        let pose = pose(&STRAIGHT.map(|row| row.map(|x| x * share)), [0.0; 3]);
        // In steps of 2^-12, at keys, so that the planes bound the spheres without slack.
        let a = [0.0, 4.0].map(|y| Sphere { centre: [0.0, y, 0.0], radius: 2.0 + 0.5_f64.powi(13) });
        for nearest in 0..2 {
            let beside = |i: usize| {
                let [x, y, z] = pose.apply(a[i].centre);
                let gap = if i == nearest { 3.0 } else { 3.00003 };
                Sphere { centre: [x + gap, y, z], radius: 0.0 }
            };
            let b = [beside(0), beside(1)];
            let (tree_a, tree_b) = (build::<Node16<18>>(&a), build::<Node16<18>>(&b));
            check((&tree_a, &a), (&tree_b, &b), &pose, &format!("{share}, {nearest}"));
            check((&tree_b, &b), (&tree_a, &a), &pose, &format!("{share}, {nearest}, the other way round"));
        }
    }
}

#[test]
fn margins_end_where_they_should() {
    // The distances 5 - 2.5 - 1 and 3 - 2.5, also in a unit without small integers.
    for unit in [1.0, 2_f64.powi(-200), 3e-7] {
        let sphere =
            |x: f64, y: f64, radius: f64| Sphere { centre: [x * unit, y * unit, 0.0], radius: radius * unit };
        let (a, b) = ([sphere(0.0, 0.0, 2.5)], [sphere(3.0, 4.0, 1.0)]);
        let triangle = [[-1.0, 5.5, -1.0], [1.0, 5.5, -1.0], [0.0, 5.5, 3.0]].map(|p| p.map(|x| x * unit));
        let (tree_a, tree_b, tree_m) =
            (build::<Node16<18>>(&a), build::<Node16<18>>(&b), mesh::<Node16<18>>(&[triangle]));
        for steps in [-3_i64, -1, 0, 1, 3, 1 << 40] {
            let step = |x: f64| f64::from_bits((x.to_bits() as i64 + steps) as u64);
            let query = Query::new(Isa::detect());
            let margin = step(1.5 * unit);
            let want = compare(&a[0], &b[0], margin).is_le();
            assert_eq!(
                query.within(&tree_a, &tree_b, &Pose::IDENTITY, margin).unwrap().hit().is_some(),
                want
            );
            let margin = step(3.0 * unit);
            let want = compare(&triangle, &a[0], margin).is_le();
            assert_eq!(
                query.within(&tree_a, &tree_m, &Pose::IDENTITY, margin).unwrap().hit().is_some(),
                want
            );
            assert_eq!(
                query.within(&tree_m, &tree_a, &Pose::IDENTITY, margin).unwrap().hit().is_some(),
                want
            );
        }
    }
}

/// Each plane is the exact support rounded up, and `verify` finds one that is a step too low.
#[test]
fn planes_are_rounded_up_by_squares() {
    fn one<const K: usize>(step: f64, radii: &[f64])
    where
        Node16<K>: Lanes,
    {
        use simdop::low_level::directions::Directions;
        let spheres: Vec<Sphere> = (0..radii.len())
            .map(|i| Sphere { centre: [(); 3].map(|()| 1.0 + step * i as f64), radius: radii[i] })
            .collect();
        let tree = build::<Node16<K>>(&spheres);
        let view = tree.view();
        let frame = view.frame();
        for lane in 0..spheres.len() {
            let Sphere { centre, radius } = view.primitive(lane as u32);
            for (j, n) in Directions::<K>::VECTORS.iter().enumerate() {
                let code = view.nodes()[0].planes[j][lane];
                // What is left for the length of n times the radius, in the body's unit, for this plane and the
                // next.
                let room = |code: i16| {
                    let height = dot(exact(n), minus(&exact(&centre), &exact(&frame.centre)));
                    Dyadic::from(f64::from(Fixed::value(code))) * Dyadic::power_of_two(-frame.exponent)
                        - height
                };
                let reach = square(&exact(n)) * Dyadic::from(radius) * Dyadic::from(radius);
                let holds = |room: Dyadic| room >= Dyadic::zero() && room.clone() * room >= reach;
                assert!(holds(room(code)), "k {K}, plane {j} of {lane}: too low");
                let below = code - 1;
                assert!(!holds(room(below)), "k {K}, plane {j} of {lane}: too high");
                let mut bytes = tree.as_bytes().to_vec();
                let at = 128 + 32 * j + 2 * lane;
                bytes[at..at + 2].copy_from_slice(&below.to_le_bytes());
                let error =
                    Bvh::<Node16<K>, Spheres>::from_bytes(&bytes).unwrap().view().verify().unwrap_err();
                assert_eq!((error.node, error.lane, error.plane), (0, lane as u32, j as u32));
            }
        }
    }
    // Exact keys along axes, half a step of 2^-13 from one. Then numbers without a pattern, and radii that are
    // tiny beside the body.
    let half = 0.5_f64.powi(14);
    one::<6>(0.25, &[1.0 + half, 2.0 + half, 0.5 + half]);
    one::<18>(0.25, &[1.0, 2.0, 0.5, 1.0 / 3.0, 1e-9]);
    one::<32>(0.25, &[0.0, 1e-12, 0.7, 0.1]);
    // Radii whose product with the length of a direction, a square root, is a key up to a rounding, above or
    // below. The step is 2^-13 or 2^-12.
    for half in [half, 2.0 * half] {
        let roots = [2.0_f64, 3.0, 6.0, 14.0].map(|square| (0.5 + half) / square.sqrt());
        let near: Vec<f64> =
            roots.iter().flat_map(|x| [x.next_down(), *x, x.next_up()]).chain([1.0]).collect();
        one::<18>(0.0, &near);
        one::<26>(0.0, &near);
        one::<32>(0.0, &near);
    }
    assert!(is_rounded_up(0, &Dyadic::zero()));
}

#[test]
fn all_splitters_and_leaf_sizes() {
    let mut rng = Rng::new(25);
    let (a, b) = (unlike(&mut rng, 200, 0.0), lattice(&mut rng, 120, 0.1, -0.8));
    let tree_b = build::<Node16<18>>(&b);
    let all @ [.., even, by_volume] = splitters(5);
    let want = brute(&a, &b, &Pose::IDENTITY, 0.0).0;
    for (i, splitter) in all.into_iter().enumerate() {
        for leaf_size in [1, 3, 16] {
            let builder = Builder::new().splitter(splitter).leaf_size(leaf_size);
            let tree = build_with::<Node16<18>>(
                &a,
                if i % 2 == 0 { builder } else { builder.without_normal_slabs() },
            );
            let query = Query::new(Isa::detect());
            assert_eq!(
                pairs_that_meet(query, &tree, &tree_b, &Pose::IDENTITY).0,
                want,
                "{splitter:?} {leaf_size}"
            );
            assert_eq!(
                pairs_that_meet(query, &tree_b, &tree, &Pose::IDENTITY).0.len(),
                want.len(),
                "{splitter:?}"
            );
        }
    }
    let heavy = build_with::<Node16<18>>(&a, Builder::new().splitter(by_volume));
    assert_ne!(heavy.as_bytes(), build_with::<Node16<18>>(&a, Builder::new().splitter(even)).as_bytes());
}

#[test]
fn bytes_are_read_back_whatever_their_node_type() {
    let mut rng = Rng::new(26);
    let spheres = lattice(&mut rng, 90, 1.0, 0.0);
    let tree = build::<Node16<18>>(&spheres);
    assert_eq!(tree.view().header().kind, Kind::SPHERES.code());
    assert_eq!(tree.view().header().vertex_size, 16, "f32 holds these numbers");
    assert_eq!(
        tree.view().header().degenerate_count,
        spheres.iter().filter(|s| s.radius == 0.0).count() as u32
    );
    let ours = |index: u32| tree.view().primitive(index) == spheres[tree.view().source(index) as usize];
    assert!((0..spheres.len() as u32).all(ours));
    let thirds: Vec<Sphere> = spheres.iter().map(|s| Sphere { radius: s.radius / 3.0, ..*s }).collect();
    assert_eq!(build::<Node16<18>>(&thirds).view().header().vertex_size, 32);

    let any = AnyBvh::<Spheres>::from_bytes(tree.as_bytes()).unwrap();
    assert_eq!(any.as_bytes(), tree.as_bytes());
    let again = |k, arity| {
        let node = NodeType { k, arity, ..NodeType::default() };
        Builder::new().build_any(&SphereSet { spheres: &spheres }, node, &mut |_| ControlFlow::Continue(()))
    };
    let built = again(18, 16).unwrap();
    assert_eq!(built.as_bytes(), tree.as_bytes());
    let query = Query::new(Isa::detect());
    let answer = query.collide_any(&any.view(), &built.view(), &Pose::IDENTITY).unwrap();
    assert_eq!(answer, query.collide(&tree, &tree, &Pose::IDENTITY));
    assert_eq!(
        again(17, 16).unwrap_err(),
        BuildError::NodeType { node: NodeType { k: 17, ..NodeType::default() } }
    );

    let error = BvhRef::<Node16<18>, Triangles>::from_bytes(tree.as_bytes()).unwrap_err();
    assert_eq!(error, FormatError::OtherPrimitive { kind: 2 });
    // A radius that is negative or not a number, or takes the sphere out of the header's box. It is stored
    // after the header, the nodes and the balls: there are no normal slabs.
    assert_eq!(tree.view().header().has_normal_slabs, 0);
    let at = 128 + tree.view().nodes().len() * (640 + 320) + 12;
    for radius in [-1.0_f32, f32::NAN, f32::INFINITY, 20.0, -f32::MIN_POSITIVE] {
        let mut bytes = tree.as_bytes().to_vec();
        bytes[at..at + 4].copy_from_slice(&radius.to_le_bytes());
        let error = Bvh::<Node16<18>, Spheres>::from_bytes(&bytes).unwrap_err();
        assert_eq!(error, FormatError::Vertex { index: 0 }, "{radius}");
    }
}

#[test]
fn spheres_that_cannot_be_are_refused() {
    let build = |centre: Point, radius: f64| {
        let good = Sphere { centre: [1.0; 3], radius: 1.0 };
        let spheres = [good, Sphere { centre, radius }];
        let built: Result<Bvh<Node16<18>, Spheres>, _> = Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()));
        built.map(|tree| tree.view().verify().unwrap())
    };
    for radius in [-1.0, -f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, MAX_COORDINATE.next_up()] {
        assert_eq!(build([0.0; 3], radius), Err(BuildError::Radius { index: 1 }), "{radius}");
    }
    assert_eq!(build([MAX_COORDINATE, 0.0, 0.0], 2_f64.powi(249)), Err(BuildError::Radius { index: 1 }));
    assert_eq!(build([0.0, f64::NAN, 0.0], 1.0), Err(BuildError::Vertex { index: 1 }));
    assert_eq!(build([0.0, 2.0 * MAX_COORDINATE, 0.0], 1.0), Err(BuildError::Vertex { index: 1 }));
    for radius in [0.0, -0.0, 1e-320, MIN_COORDINATE, MAX_COORDINATE] {
        assert_eq!(build([0.0; 3], radius), Ok(()), "{radius}");
    }
    assert!(BuildError::Radius { index: 7 }.to_string().contains("sphere 7"));
}

/// The whole range of numbers in one pair; exact arithmetic has no limit.
#[test]
fn spheres_at_the_ends_of_the_range() {
    let tiny = MIN_COORDINATE;
    let large = Sphere { centre: [0.0; 3], radius: 0.5 * MAX_COORDINATE };
    let point = |x: f64, y: f64| Sphere { centre: [x, y, 0.0], radius: 0.0 };
    let (tree, query) = (build::<Node16<18>>(&[large]), Query::new(Isa::detect()));
    let at = large.radius;
    for (other, meets) in [
        (point(at, 0.0), true),
        (point(at, tiny), false),
        (point(at, -tiny), false),
        (point(at.next_down(), tiny), true),
        (Sphere { radius: tiny, ..point(at, tiny) }, true),
        (Sphere { radius: tiny, ..point(at.next_up(), tiny) }, false),
    ] {
        assert_eq!(compare(&large, &other, 0.0).is_le(), meets, "the oracle, {other:?}");
        let one = build::<Node16<18>>(&[other]);
        for (a, b) in [(&tree, &one), (&one, &tree)] {
            assert_eq!(query.collide(a, b, &Pose::IDENTITY).hit().is_some(), meets, "{other:?}");
            let found = query.distance(a, b, &Pose::IDENTITY, 0.0).unwrap();
            assert_eq!(found.upper == 0.0, meets, "{other:?}: {found:?}");
            assert!(found.lower <= found.upper);
        }
        // A triangle with an edge through the point, and one with a face through it.
        let Sphere { centre: [x, y, _], radius } = other;
        let edge = [[x, y, -tiny], [x, y, at], [1.5 * x, y, tiny]];
        let face = [[x, -at, -at], [x, at, -at], [x, 0.0, at + tiny]];
        for t in [edge, face] {
            let meets = compare(&t, &large, 0.0).is_le();
            assert!(radius > 0.0 || t == face || meets == compare(&large, &other, 0.0).is_le());
            let tree_t = mesh::<Node16<18>>(&[t]);
            assert_eq!(query.collide(&tree_t, &tree, &Pose::IDENTITY).hit().is_some(), meets, "{t:?}");
            assert_eq!(query.collide(&tree, &tree_t, &Pose::IDENTITY).hit().is_some(), meets, "{t:?}");
            let found = query.distance(&tree, &tree_t, &Pose::IDENTITY, 0.0).unwrap();
            assert_eq!(found.upper == 0.0, meets, "{t:?}: {found:?}");
        }
    }
}

/// Two bodies that pass each other in steps of 1/8, in and out of contact.
#[test]
fn hints_are_tried_and_change_no_answer() {
    let mut rng = Rng::new(26);
    let (a, b) = (lattice(&mut rng, 40, 1.0, 0.0), lattice(&mut rng, 40, 1.0, 0.0));
    let patches = lattice_triangles(&mut rng, 40, 1.0, 0.0);
    let (tree_a, tree_b) = (build::<Node16<18>>(&a), build::<Node16<18>>(&b));
    let tree_m = mesh::<Node16<18>>(&patches);
    let width = side(40) as f64;
    let poses: Vec<Pose> = (0..64)
        .step_by(suite_step())
        .flat_map(|i| {
            let along = (width + 6.0) * (f64::from(i) / 32.0 - 1.0);
            [pose(&STRAIGHT, [along, 2.0, 5.0]), pose(&QUARTER, [width + 0.01 * along, 7.5 - along, 0.125])]
        })
        .collect();
    let (straight, turned): (Vec<Pose>, Vec<Pose>) = poses.as_chunks().0.iter().map(|&[p, q]| (p, q)).unzip();
    for path in [straight, turned] {
        for margin in [0.0, 0.5] {
            for [hits, free_of_charge] in [
                check_motion((&tree_a, &a), (&tree_b, &b), &path, margin, "spheres and spheres"),
                check_motion((&tree_a, &a), (&tree_m, &patches), &path, margin, "spheres and triangles"),
                check_motion((&tree_m, &patches), (&tree_a, &a), &path, margin, "triangles and spheres"),
            ] {
                let says_much = hits > path.len() / 4 && hits < path.len() && 2 * free_of_charge > hits;
                assert!(says_much || suite_step() > 1, "{hits} of {}, {free_of_charge}", path.len());
            }
        }
    }
}
