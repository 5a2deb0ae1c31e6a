//! Bytes that `from_bytes` accepts as a tree of spheres are safe to traverse and to query, and the tree is what they
//! say; bytes that it rejects have the error that it reports. The shared volume of two verified trees is the sum over
//! all pairs of spheres, and lies between the bounds of a query with a budget.
//!
//! An input that begins like a baked tree is used as one. Any other is a list of changes to a valid tree.

use crate::baked::{self, Buffer, Parts, change, copied, number_at, put_code, put_number, said_node, u32_at};
use crate::bodies::pose;
use crate::spheres::{distance, lens, sphere_bodies};
use crate::{Input, Mode, NodeChoice, for_node};
use core::f64::consts::PI;
use simdop::hierarchy::{Aligned, BvhRef};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Answer, Completion, Lanes, Penetration, Query, Verdict};

type View<'t, N> = BvhRef<'t, N, Spheres>;

/// One run.
pub fn run(data: &[u8]) {
    let mut buffer: Buffer = Aligned([0; _]);
    let mut input = Input::new(data);
    if let Some(node) = said_node(data) {
        for_node!(node, examine(copied(&mut buffer, data), &mut input));
    } else {
        // Trees of arity 4 have no balls.
        let (k, form) = ([6, 14, 18, 26, 32][input.below(5)], input.below(8));
        let node = NodeChoice { k, four: form == 0, half: form % 2 == 1 };
        for_node!(node, changed(&mut buffer, &mut input));
    }
}

/// Makes up to four changes to a valid tree.
fn changed<N: Lanes>(buffer: &mut Buffer, input: &mut Input) {
    let tree = &input.pick(&sphere_bodies::<N>().0).tree;
    // 4 for vertices in single precision, 8 in double precision.
    let number = usize::from(tree.view().header().vertex_size) / 4;
    let bytes = baked::changed(buffer, tree, input, |bytes, parts, input| {
        let (region, size) = match input.u8() {
            0..32 => (0..128, 4),
            32..80 => (128..parts.balls, 2),
            80..160 => (parts.balls..parts.slabs, 4),
            160..176 => (parts.slabs..parts.vertices, 4),
            176..224 => (parts.vertices..parts.records, number),
            224..240 => (parts.records..parts.sources, 4),
            _ => (parts.sources..parts.end, 4),
        };
        change(bytes, &region, input, |bytes, at, input| match size {
            2 => put_code(bytes, at, input),
            _ => put_number(bytes, at, size, input),
        });
    });
    examine::<N>(bytes, input);
}

fn examine<N: Lanes>(bytes: &[u8], input: &mut Input) {
    baked::examine::<N, Spheres>(bytes, |view| {
        are_its_spheres(view, bytes);
        balls_are_of_the_body(view);
        queries_agree(view, input);
    });
}

/// Compares the spheres with an independent reader.
fn are_its_spheres<N: Lanes>(view: &View<'_, N>, bytes: &[u8]) {
    let header = view.header();
    let records = Parts::of::<N, Spheres>(header).records;
    for i in 0..view.len() {
        let Sphere { centre: [x, y, z], radius } = view.primitive(i as u32);
        let vertex = u32_at(bytes, records + 4 * i);
        for (number, value) in [x, y, z, radius].into_iter().enumerate() {
            let stored = number_at::<N, Spheres>(header, bytes, vertex, number);
            assert_eq!(value.to_bits(), stored.to_bits());
        }
        assert!(radius >= 0.0 && [x, y, z].iter().all(|x| x.is_finite()));
    }
}

/// Checks that balls of used lanes can be rotated without overflow, and that those of unused lanes meet nothing.
fn balls_are_of_the_body<N: Lanes>(view: &View<'_, N>) {
    let half_width = view.header().half_width;
    let width = half_width.iter().map(|x| f64::from(*x)).sum::<f64>();
    for (node, balls) in view.nodes().iter().zip(view.balls()) {
        for (lane, child) in node.children().iter().enumerate() {
            let ball = balls.lane(lane);
            if *child == simdop::node::Child::EMPTY {
                assert!(ball.centre.iter().all(|x| x.is_nan()) && (ball.radius, ball.volume) == (0.0, 0.0));
            } else {
                assert!(ball.centre.iter().zip(half_width).all(|(x, most)| x.abs() <= most), "{ball:?}");
                let most = width * 1.001 + 1e-9;
                assert!(ball.radius >= 0.0 && f64::from(ball.radius) <= most, "{ball:?}");
                assert!(ball.volume >= 0.0 && ball.volume.is_finite(), "{ball:?}");
            }
        }
    }
}

/// The answers of all queries of two trees.
#[derive(PartialEq, Debug)]
struct Answers {
    collided: Answer,
    within: Answer,
    whole: Penetration,
    part: Penetration,
}

/// Queries terminate with the same answers on every instruction set; if the tree is verified, with those of brute
/// force.
fn queries_agree<N: Lanes>(view: &View<'_, N>, input: &mut Input) {
    let other = input.pick(&sphere_bodies::<N>().0).tree.view();
    let pose = pose(input, Mode::Real);
    let (a, b) = [(view, &other), (&other, view), (view, view)][input.below(3)];
    let margin = [0.0, 1e-3, 0.1, 2.0][input.below(4)];
    let (visits, budget) = (300, input.below(64) as u64);
    let ask = |isa| {
        let query = Query::new(isa);
        // Infinite planes can make a query test all pairs.
        let bounded = query.with_budget(visits);
        Answers {
            collided: bounded.collide(a, b, &pose),
            within: bounded.within(a, b, &pose, margin).unwrap(),
            whole: query.penetration(a, b, &pose),
            part: query.with_budget(budget).penetration(a, b, &pose),
        }
    };
    let answers = ask(Isa::SCALAR);
    for isa in Isa::available().filter(|isa| *isa != Isa::SCALAR) {
        let other = ask(isa);
        // Bit by bit if a volume is NaN.
        assert!(
            other == answers || format!("{other:?}") == format!("{answers:?}"),
            "{isa} {other:?} {answers:?}"
        );
    }
    let Answers { collided, within, whole, part } = &answers;
    for answer in [collided, within] {
        let is_unknown = matches!(answer.verdict, Verdict::Unknown { .. });
        assert!(!is_unknown || answer.stats.visits == visits, "{answer:?}");
    }
    assert!(whole.completion == Completion::Complete && part.pairs <= whole.pairs, "{part:?} {whole:?}");
    match part.completion {
        Completion::Complete => assert_eq!(part.pairs, whole.pairs),
        _ => assert_eq!(part.stats.visits, budget),
    }
    let proven = input.one_in(4) && view.verify().is_ok();
    let placed = Placed { pose: &pose, a, b, moved: spheres(a, |p| pose.apply(p)), still: spheres(b, |p| p) };
    placed.verdict_is_true(collided, 0.0, proven);
    placed.verdict_is_true(within, margin, proven);
    if proven {
        placed.volumes_are_true(whole, part);
    }
}

fn spheres<N: Lanes>(view: &View<'_, N>, place: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Sphere> {
    let item = |index| view.primitive(index as u32);
    (0..view.len()).map(item).map(|s| Sphere { centre: place(s.centre), ..s }).collect()
}

/// Two bodies, and their spheres in the frame of the second.
struct Placed<'t, N> {
    pose: &'t Pose,
    a: &'t View<'t, N>,
    b: &'t View<'t, N>,
    moved: Vec<Sphere>,
    still: Vec<Sphere>,
}

impl<N: Lanes> Placed<'_, N> {
    /// Checks, up to rounding, that a hit is within the margin, and that if none is found in verified trees no two
    /// spheres are.
    fn verdict_is_true(&self, answer: &Answer, margin: f64, proven: bool) {
        let all = || {
            let of = |i| self.still.iter().zip(0..).map(move |(q, j)| (i, j, q));
            self.moved.iter().zip(0..).flat_map(move |(p, i)| of(i).map(move |(i, j, q)| (i, j, gap(p, q))))
        };
        match answer.verdict {
            Verdict::Hit(pair) => {
                // Damaged trees may use an index twice.
                let is_it = |i, j| (self.a.source(i), self.b.source(j)) == (pair.a, pair.b);
                let is_near =
                    |(i, j, (gap, slack)): (u32, u32, (f64, f64))| is_it(i, j) && gap <= margin + slack;
                assert!(all().any(is_near), "a false hit: {pair:?} {:?}", self.pose);
            }
            Verdict::Free if proven => {
                let is_apart = |(_, _, (gap, slack)): (u32, u32, (f64, f64))| gap >= margin - slack;
                assert!(all().all(is_apart), "a miss in a proven tree: {:?}", self.pose);
            }
            _ => {}
        }
    }

    /// Checks that the volume and the pairs are the sums over all pairs, and that the bounds of a budget enclose the
    /// volume.
    fn volumes_are_true(&self, whole: &Penetration, part: &Penetration) {
        // In the unit of the smaller body's frame, where nothing overflows or underflows.
        let frames = [self.a, self.b].map(|tree| tree.frame().scale());
        let scale = f64::max(frames[0], frames[1]);
        let smaller = if frames[0] == scale { self.a } else { self.b };
        // Only sums for bodies in a frame that the builder would choose have limited size.
        if smaller.header().half_width.iter().any(|x| *x > 1024.0) {
            return;
        }
        let (mut volume, mut slack) = (0.0, 0.0);
        let (mut certain, mut possible) = (0, 0);
        for p in &self.moved {
            for q in &self.still {
                let (gap, rounding) = gap(p, q);
                certain += u64::from(gap < -rounding);
                possible += u64::from(gap <= rounding);
                let (r, s) = (p.radius * scale, q.radius * scale);
                let way: [f64; 3] = core::array::from_fn(|i| (p.centre[i] - q.centre[i]) * scale);
                let shared = lens(r, s, distance(&way, &[0.0; 3]));
                volume += shared;
                if gap <= rounding {
                    // The error of a lens is a few last places of the smaller sphere's volume, times the ratio of the
                    // radii.
                    slack +=
                        1e-13 * (4.0 / 3.0 * PI) * (r.min(s) * r.min(s)) * r.max(s) + (-120.0_f64).exp2();
                }
            }
        }
        let found = ((whole.volume * scale) * scale) * scale;
        assert!(
            (found - volume).abs() <= 1e-9 * volume + slack,
            "{found:e} is not {volume:e}: {whole:?} {:?}",
            self.pose
        );
        assert!((certain..=possible).contains(&whole.pairs), "{certain} {possible} {whole:?}");
        assert!(whole.upper == whole.volume && part.volume <= whole.volume, "{part:?} {whole:?}");
        assert!(part.estimate >= part.volume || part.estimate.is_nan(), "{part:?}");
        if is_disjoint(&self.moved) && is_disjoint(&self.still) {
            assert!(whole.volume <= part.upper, "{part:?} {whole:?} {:?}", self.pose);
        }
    }
}

/// The gap between two spheres, negative if they overlap, and a bound on its rounding error.
fn gap(p: &Sphere, q: &Sphere) -> (f64, f64) {
    let d = distance(&p.centre, &q.centre);
    let reach = p.radius + q.radius;
    // The squares of such small numbers underflow to zero.
    (d - reach, 1e-14 * (d + reach) + 1e-150)
}

/// Whether no two of the spheres overlap by more than rounding.
fn is_disjoint(spheres: &[Sphere]) -> bool {
    let overlap = |p: &Sphere, q: &Sphere| gap(p, q).0 < -1e-12 * p.radius.min(q.radius);
    spheres.iter().enumerate().all(|(i, p)| !spheres[..i].iter().any(|q| overlap(p, q)))
}
