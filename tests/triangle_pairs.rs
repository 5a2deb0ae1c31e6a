//! The exact triangle test against an independent oracle, on over a million difficult pairs: contacts that are
//! exact in `f64`, the same moved by one unit in the last place, and the same rotated, scaled and shifted.

mod support;

use core::fmt;

use simdop::primitive::triangle::{Probe, Triangle, overlap};
use support::data::suite_step;
use support::exact::{meeting_pairs, meshes_meet, triangles_meet, triangles_meet_in_integers};
use support::rng::Rng;

const PAIRS: u64 = 1_000_000;
const THREADS: usize = 2;

type Pair = [Triangle; 2];
type Vector = [f64; 3];

#[test]
fn verdicts_match_the_oracle() {
    let cells: Vec<(Shape, Treatment)> =
        SHAPES.iter().flat_map(|&s| TREATMENTS.iter().map(move |&t| (s, t))).collect();
    let pairs = PAIRS / suite_step() as u64;
    let each = pairs.div_ceil(cells.len() as u64);
    let tallies: Vec<Tally> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..THREADS)
            .map(|worker| {
                let cells = &cells;
                let mine = move || {
                    let some = cells.iter().enumerate().skip(worker).step_by(THREADS);
                    some.map(|(i, cell)| (i, check_cell(*cell, i as u64, each))).collect::<Vec<_>>()
                };
                scope.spawn(mine)
            })
            .collect();
        let mut all: Vec<_> = workers.into_iter().flat_map(|w| w.join().expect("a worker failed")).collect();
        all.sort_by_key(|(i, _)| *i);
        all.into_iter().map(|(_, tally)| tally).collect()
    });
    println!("{:24} {:10} {:>8} {:>8} {:>8} {:>8}", "shape", "treatment", "pairs", "hits", "misses", "exact");
    for (&(shape, treatment), tally) in cells.iter().zip(&tallies) {
        let Tally { pairs, hits, exact } = tally;
        let misses = pairs - hits;
        println!("{:24} {treatment:10?} {pairs:8} {hits:8} {misses:8} {exact:8}", shape.name);
        assert!(*hits > each / 50, "{} {treatment:?}: hardly any hits", shape.name);
        assert!(
            shape.contact.survives(treatment) || misses > each / 100,
            "{} {treatment:?}: hardly any misses",
            shape.name
        );
    }
    let total: u64 = tallies.iter().map(|t| t.pairs).sum();
    assert!(total >= pairs);
}

/// The results for one shape and one treatment.
struct Tally {
    pairs: u64,
    hits: u64,
    exact: u64,
}

fn check_cell((shape, treatment): (Shape, Treatment), seed: u64, pairs: u64) -> Tally {
    let mut rng = Rng::new(0x51d0 + seed);
    let mut tally = Tally { pairs, hits: 0, exact: 0 };
    for i in 0..pairs {
        let raw = (shape.make)(&mut rng);
        let pair = treatment.apply(raw, &mut rng);
        let expected = triangles_meet(&pair[0], &pair[1]);
        if shape.contact.survives(treatment) {
            assert!(expected, "built to touch:\n{}", Bits(&pair));
        }
        let exact = check_orders(&pair, expected);
        if i % 4 == 0 {
            check_orders(&pair.map(|t| shuffled(&t, &mut rng)), expected);
        }
        if i % 64 == 0 {
            let slow = triangles_meet_in_integers(&pair[0], &pair[1]);
            assert_eq!(expected, slow, "the oracle's short cut is wrong:\n{}", Bits(&pair));
        }
        tally.hits += u64::from(expected);
        tally.exact += u64::from(exact);
    }
    tally
}

/// Checks both argument orders. Returns whether the first needed integers.
fn check_orders(pair @ [a, b]: &Pair, expected: bool) -> bool {
    let (mut forward, mut backward) = (7, 7);
    assert_eq!(overlap(a, b, &mut forward), expected, "first with second:\n{}", Bits(pair));
    assert_eq!(overlap(b, a, &mut backward), expected, "second with first:\n{}", Bits(pair));
    let apart = Probe::new(a).is_apart(b);
    assert!(!(expected && apart), "told apart, but they meet:\n{}", Bits(pair));
    assert!((7..=8).contains(&forward) && (7..=8).contains(&backward), "counted twice:\n{}", Bits(pair));
    forward == 8
}

fn shuffled(t: &Triangle, rng: &mut Rng) -> Triangle {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    rng.pick(&ORDERS).map(|i| t[i])
}

/// A pair as Rust source that reproduces its bits.
struct Bits<'a>(&'a Pair);

impl fmt::Display for Bits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for t in self.0 {
            for p in t {
                writeln!(f, "  {:#018x?}.map(f64::from_bits), // {p:?}", p.map(f64::to_bits))?;
            }
        }
        Ok(())
    }
}

// ---- treatments -------------------------------------------------------------------------------------------

/// The treatment of a pair that was built on a dyadic grid.
#[derive(Clone, Copy, Debug)]
enum Treatment {
    /// Scaled by a power of two and shifted by an integer: nothing is rounded, and contacts stay exact.
    Exact,
    /// The same, and then one vertex, or all vertices, moved by one unit in the last place.
    Nudged,
    /// Rotated by any angle, scaled and shifted, all with rounding.
    Turned,
    /// Rotated likewise, after one triangle is moved by 1e-12 to 1e-3 of its size.
    Moved,
}

const TREATMENTS: [Treatment; 4] = [Treatment::Exact, Treatment::Nudged, Treatment::Turned, Treatment::Moved];

const OFFSETS: [f64; 3] = [0.0, 100.0, 1e4];

impl Treatment {
    fn apply(self, pair: Pair, rng: &mut Rng) -> Pair {
        let offset: Vector = core::array::from_fn(|_| *rng.pick(&OFFSETS));
        match self {
            Self::Exact => dyadic(pair, &offset, rng),
            Self::Nudged => {
                let mut pair = dyadic(pair, &offset, rng);
                let whole = rng.below(2) == 0;
                let (t, v) = (rng.below(2) as usize, rng.below(3) as usize);
                for p in pair[t].iter_mut().enumerate().filter(|(i, _)| whole || *i == v).map(|(_, p)| p) {
                    *p = p.map(|x| nudge(x, rng));
                }
                pair
            }
            Self::Turned => turned(pair, &offset, &[0.0; 3], rng),
            Self::Moved => {
                let gap = 10.0_f64.powf(rng.range(-12.0, -3.0));
                // In any direction, or along an edge, which is in the plane if the pair shares one.
                let way = if rng.below(2) == 0 { rng.rotation()[0] } else { sub(&pair[0][1], &pair[0][0]) };
                turned(pair, &offset, &scaled(&way, gap), rng)
            }
        }
    }
}

fn dyadic(pair: Pair, offset: &Vector, rng: &mut Rng) -> Pair {
    let scale = 2.0_f64.powi(rng.int(-10, 13) as i32);
    map_points(pair, |p| core::array::from_fn(|k| p[k] * scale + offset[k]))
}

fn nudge(x: f64, rng: &mut Rng) -> f64 {
    match rng.below(3) {
        // At zero, a step that the range of coordinates allows.
        0 if x == 0.0 => 1e-17,
        1 if x == 0.0 => -1e-17,
        0 => x.next_up(),
        1 => x.next_down(),
        _ => x,
    }
}

fn turned(pair: Pair, offset: &Vector, shift: &Vector, rng: &mut Rng) -> Pair {
    let rotation = rng.rotation();
    let scale = 10.0_f64.powf(rng.range(-3.0, 4.0));
    let [a, b] = pair;
    let b = b.map(|p| core::array::from_fn(|k| p[k] + shift[k]));
    map_points([a, b], |p| core::array::from_fn(|k| dot(&rotation[k], &p) * scale + offset[k]))
}

fn map_points(pair: Pair, mut f: impl FnMut(Vector) -> Vector) -> Pair {
    pair.map(|t| t.map(&mut f))
}

// ---- shapes: coordinates are small multiples of 1/64, so that sums and products of a few are exact
// ---------------

#[derive(Clone, Copy)]
struct Shape {
    name: &'static str,
    make: fn(&mut Rng) -> Pair,
    contact: Contact,
}

/// The answer that is known without an oracle.
#[derive(Clone, Copy, PartialEq)]
enum Contact {
    Unknown,
    /// The triangles touch if nothing is rounded.
    UntilRounded,
    /// They share a vertex, which is rounded equally for both.
    UntilMoved,
}

impl Contact {
    fn survives(self, treatment: Treatment) -> bool {
        match treatment {
            Treatment::Exact => self != Self::Unknown,
            Treatment::Turned => self == Self::UntilMoved,
            Treatment::Nudged | Treatment::Moved => false,
        }
    }
}

const SHAPES: [Shape; 17] = [
    Shape { name: "random", make: random, contact: Contact::Unknown },
    Shape { name: "small grid", make: small_grid, contact: Contact::Unknown },
    Shape { name: "vertex on face", make: vertex_on_face, contact: Contact::UntilRounded },
    Shape { name: "vertex on vertex", make: vertex_on_vertex, contact: Contact::UntilMoved },
    Shape { name: "edge on edge", make: edge_on_edge, contact: Contact::UntilRounded },
    Shape { name: "edge in face", make: edge_in_face, contact: Contact::UntilRounded },
    Shape { name: "coplanar", make: coplanar, contact: Contact::Unknown },
    Shape { name: "coplanar contained", make: coplanar_contained, contact: Contact::UntilRounded },
    Shape { name: "parallel planes", make: parallel_planes, contact: Contact::Unknown },
    Shape { name: "shared edge", make: shared_edge, contact: Contact::UntilMoved },
    Shape { name: "identical", make: identical, contact: Contact::UntilMoved },
    Shape { name: "needle and triangle", make: needle_and_triangle, contact: Contact::Unknown },
    Shape { name: "needle and needle", make: needle_and_needle, contact: Contact::Unknown },
    Shape { name: "needles on one line", make: needles_on_one_line, contact: Contact::Unknown },
    Shape { name: "point and triangle", make: point_and_triangle, contact: Contact::Unknown },
    Shape { name: "points and needles", make: points_and_needles, contact: Contact::Unknown },
    Shape { name: "sliver and sliver", make: sliver_and_sliver, contact: Contact::Unknown },
];

fn random(rng: &mut Rng) -> Pair {
    let mut t = || core::array::from_fn(|_| core::array::from_fn(|_| rng.int(-4096, 4096) as f64 / 1024.0));
    [t(), t()]
}

fn small_grid(rng: &mut Rng) -> Pair {
    let reach = rng.int(1, 3);
    let mut t = || core::array::from_fn(|_| grid(rng, reach));
    [t(), t()]
}

fn vertex_on_face(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    let n = cross(&sub(&a[1], &a[0]), &sub(&a[2], &a[0]));
    let above = |p: Vector| if dot(&n, &sub(&p, &a[0])) < 0.0 { sub(&scaled(&a[0], 2.0), &p) } else { p };
    [a, [inside(&a, rng), above(grid(rng, 8)), above(grid(rng, 8))]]
}

fn vertex_on_vertex(rng: &mut Rng) -> Pair {
    let (a, mut b) = (proper(rng), proper(rng));
    b[0] = a[0];
    [a, b]
}

fn edge_on_edge(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    let t = rng.int(0, 8) as f64 / 8.0;
    let contact = add(&a[0], &scaled(&sub(&a[1], &a[0]), t));
    let direction = grid(rng, 8);
    [a, [add(&contact, &direction), sub(&contact, &direction), grid(rng, 8)]]
}

fn edge_in_face(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    [a, [inside(&a, rng), inside(&a, rng), grid(rng, 8)]]
}

fn coplanar(rng: &mut Rng) -> Pair {
    let lattice = Lattice::new(rng);
    [lattice.triangle(rng, 4), lattice.triangle(rng, 4)]
}

fn coplanar_contained(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    [a, [inside(&a, rng), inside(&a, rng), inside(&a, rng)]]
}

fn parallel_planes(rng: &mut Rng) -> Pair {
    let lattice = Lattice::new(rng);
    let [a, b] = [lattice.triangle(rng, 2), lattice.triangle(rng, 2)];
    let lift = scaled(&grid(rng, 1), rng.int(0, 1) as f64 / 64.0);
    [a, b.map(|p| add(&p, &lift))]
}

fn shared_edge(rng: &mut Rng) -> Pair {
    let (a, mut b) = (proper(rng), proper(rng));
    (b[0], b[1]) = (a[1], a[0]);
    [a, b]
}

fn identical(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    [a, shuffled(&a, rng)]
}

fn needle_and_triangle(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    let through = if rng.below(3) == 0 { grid(rng, 8) } else { inside(&a, rng) };
    [needle(&through, rng), a]
}

fn needle_and_needle(rng: &mut Rng) -> Pair {
    let through = grid(rng, 8);
    let other = if rng.below(8) == 0 { grid(rng, 8) } else { through };
    [needle(&through, rng), needle(&other, rng)]
}

fn needles_on_one_line(rng: &mut Rng) -> Pair {
    let (origin, direction) = (grid(rng, 8), grid(rng, 4));
    let mut t = || core::array::from_fn(|_| add(&origin, &scaled(&direction, rng.int(-4, 4) as f64)));
    [t(), t()]
}

fn point_and_triangle(rng: &mut Rng) -> Pair {
    let a = proper(rng);
    let p =
        if rng.below(3) == 0 { Lattice::of(&a).at(rng.int(0, 1), rng.int(0, 1)) } else { inside(&a, rng) };
    [[p; 3], a]
}

fn points_and_needles(rng: &mut Rng) -> Pair {
    let p = grid(rng, 2);
    let q = if rng.below(2) == 0 { p } else { grid(rng, 2) };
    let other = if rng.below(2) == 0 { [q; 3] } else { needle(&q, rng) };
    [[p; 3], other]
}

/// Triangles about 2^20 times longer than wide, through nearly the same place.
fn sliver_and_sliver(rng: &mut Rng) -> Pair {
    let through = grid(rng, 4);
    let mut t = || needle(&through, rng).map(|p| add(&p, &scaled(&grid(rng, 2), 2.0_f64.powi(-18))));
    [t(), t()]
}

/// The points with integer coordinates in a plane.
struct Lattice {
    origin: Vector,
    u: Vector,
    v: Vector,
}

impl Lattice {
    fn new(rng: &mut Rng) -> Self {
        Self { origin: grid(rng, 8), u: grid(rng, 3), v: grid(rng, 3) }
    }

    fn of(t: &Triangle) -> Self {
        Self { origin: t[0], u: sub(&t[1], &t[0]), v: sub(&t[2], &t[0]) }
    }

    fn at(&self, i: i64, j: i64) -> Vector {
        add(&self.origin, &add(&scaled(&self.u, i as f64), &scaled(&self.v, j as f64)))
    }

    fn triangle(&self, rng: &mut Rng, reach: i64) -> Triangle {
        core::array::from_fn(|_| self.at(rng.int(-reach, reach), rng.int(-reach, reach)))
    }
}

fn grid(rng: &mut Rng, reach: i64) -> Vector {
    core::array::from_fn(|_| rng.int(-reach, reach) as f64)
}

/// A triangle with an area.
fn proper(rng: &mut Rng) -> Triangle {
    loop {
        let t: Triangle = core::array::from_fn(|_| grid(rng, 8));
        if cross(&sub(&t[1], &t[0]), &sub(&t[2], &t[0])) != [0.0; 3] {
            return t;
        }
    }
}

/// A point of the closed triangle, with barycentric coordinates that are multiples of 1/8: often on an edge.
fn inside(t: &Triangle, rng: &mut Rng) -> Vector {
    let i = rng.int(0, 8);
    let j = rng.int(0, 8 - i);
    let weight = [i, j, 8 - i - j].map(|w| w as f64 / 8.0);
    core::array::from_fn(|k| t[0][k] * weight[0] + t[1][k] * weight[1] + t[2][k] * weight[2])
}

/// Three points on a line through `p`, which is often, but not always, between them.
fn needle(p: &Vector, rng: &mut Rng) -> Triangle {
    let direction = grid(rng, 4);
    core::array::from_fn(|_| add(p, &scaled(&direction, rng.int(-3, 3) as f64 / 2.0)))
}

fn add(p: &Vector, q: &Vector) -> Vector {
    core::array::from_fn(|k| p[k] + q[k])
}

fn sub(p: &Vector, q: &Vector) -> Vector {
    core::array::from_fn(|k| p[k] - q[k])
}

fn scaled(p: &Vector, s: f64) -> Vector {
    p.map(|x| x * s)
}

fn dot(p: &Vector, q: &Vector) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: &Vector, q: &Vector) -> Vector {
    let minor = |i: usize, j: usize| p[i] * q[j] - p[j] * q[i];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

// ---- the ends of the range, the counter, and the oracle itself --------------------------------------------

/// Coordinates from 2^-250 to 2^302, mixed, so that an intermediate result that underflows or overflows changes
/// a verdict. With debug assertions a coordinate out of range panics.
#[test]
fn verdicts_match_at_the_ends_of_the_range() {
    let mut rng = Rng::new(2);
    let (mut hits, pairs) = (0, 20_000);
    for i in 0..pairs {
        let raw = (SHAPES[i % SHAPES.len()].make)(&mut rng);
        // The shapes' coordinates are multiples of 2^-21 (slivers) below 2^7.
        let exponent = *rng.pick(&[-229, -200, 250, 295]);
        let pair = match rng.below(3) {
            0 => map_points(raw, |p| scaled(&p, 2.0_f64.powi(exponent))),
            1 => map_points(raw, |p| [p[0] * 2.0_f64.powi(295), p[1] * 2.0_f64.powi(-229), p[2]]),
            _ => map_points(raw, |p| p.map(|x| nudge_in_range(x * 2.0_f64.powi(exponent), &mut rng))),
        };
        let expected = triangles_meet_in_integers(&pair[0], &pair[1]);
        check_orders(&pair, expected);
        hits += usize::from(expected);
    }
    assert!(hits > pairs / 5 && hits < pairs * 4 / 5, "one-sided: {hits} hits of {pairs}");
}

fn nudge_in_range(x: f64, rng: &mut Rng) -> f64 {
    match rng.below(4) {
        0 | 1 if x == 0.0 => 2.0_f64.powi(-250),
        0 => x.next_up(),
        _ => x,
    }
}

/// Random pairs must not need integers, which are for contacts.
#[test]
fn random_pairs_do_not_need_integers() {
    let mut rng = Rng::new(3);
    let mut exact_calls = 0;
    let mut hits = 0;
    for _ in 0..100_000 {
        let mut t = || core::array::from_fn(|_| core::array::from_fn(|_| rng.range(99.0, 101.0)));
        hits += usize::from(overlap(&t(), &t(), &mut exact_calls));
    }
    assert!(hits > 1000);
    assert_eq!(exact_calls, 0);
}

#[test]
fn the_oracle_knows_the_obvious() {
    let t = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let meets = |u: Triangle| {
        let fast = triangles_meet(&t, &u);
        assert_eq!(fast, triangles_meet_in_integers(&u, &t));
        fast
    };
    let tiny = 5e-324;
    assert!(meets(t));
    assert!(meets([[1.0, 1.0, 0.0]; 3]));
    assert!(meets([[2.0, 2.0, 0.0], [2.0, 2.0, 1.0], [9.0, 9.0, 1.0]]));
    assert!(meets([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]]));
    assert!(!meets([[1.0, 1.0, tiny]; 3]));
    assert!(!meets([[2.0, 2.0_f64.next_up(), 0.0]; 3]));
    assert!(!meets([[2.0, 2.0_f64.next_up(), -1.0], [2.0, 2.0_f64.next_up(), 1.0], [9.0, 9.0, 1.0]]));
    assert!(!meets([[5.0, 0.0, 0.0], [9.0, 0.0, 0.0], [6.0, 0.0, 0.0]]));
    assert!(!meets(t.map(|[x, y, z]| [x, y, z + tiny])));
    // The boxes overlap, the triangles share a plane, and are disjoint.
    assert!(!meets([[3.0, 3.0, 0.0], [1.5, 3.0, 0.0], [3.0, 1.5, 0.0]]));
}

#[test]
fn the_oracle_finds_the_pairs_of_meshes() {
    let mut rng = Rng::new(4);
    for n in [0, 1, 40] {
        let mut mesh =
            || -> Vec<Triangle> { (0..n).map(|_| random(&mut rng)[0].map(|p| scaled(&p, 0.5))).collect() };
        let (a, b) = (mesh(), mesh());
        let all = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let expected: Vec<_> = all.filter(|&(i, j)| triangles_meet_in_integers(&a[i], &b[j])).collect();
        assert_eq!(meeting_pairs(&a, &b), expected);
        assert_eq!(meshes_meet(&a, &b), !expected.is_empty());
        let far: Vec<Triangle> = b.iter().map(|t| t.map(|[x, y, z]| [x, y, z + 100.0])).collect();
        assert!(!meshes_meet(&a, &far) && meeting_pairs(&a, &far).is_empty());
    }
}
