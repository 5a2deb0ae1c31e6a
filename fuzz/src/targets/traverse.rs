//! Queries between two trees give brute force's answers, and the scalar kernel's query statistics on every instruction
//! set.

use crate::bodies::{Body, with_pair};
use crate::support::exact::meeting_pairs;
use crate::{Input, Mode, NodeChoice, for_node};
use core::ops::ControlFlow;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Distance, Lanes, Pair, Query, Verdict};

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, node) = (input.mode(), NodeChoice::new(&mut input));
    for_node!(node, check(&mut input, mode));
}

fn check<N: Lanes>(input: &mut Input, mode: Mode) {
    with_pair::<N>(input, mode, compare);
}

fn compare<N: Lanes>(a: &Body<N>, b: &Body<N>, pose: &Pose, input: &mut Input) {
    let budget = input.below(32) as u64;
    let distances = input.one_in(8);
    let moved: Vec<_> = a.triangles.iter().map(|t| t.map(|p| pose.apply(p))).collect();
    let met = meeting_pairs(&moved, &b.triangles);
    let want: Vec<_> = met.into_iter().map(|(i, j)| Pair { a: i as u32, b: j as u32 }).collect();

    let scalar = answers(Isa::SCALAR, a, b, pose, budget, distances);
    let (collided, bounded, pairs, distance) = &scalar;
    assert_eq!(*pairs, want, "all pairs: {pose:?}");
    for answer in [collided, bounded] {
        match answer.verdict {
            Verdict::Hit(pair) => assert!(want.contains(&pair), "a false hit: {pair:?} {pose:?}"),
            Verdict::Free => assert!(want.is_empty(), "a miss: {want:?} {pose:?}"),
            Verdict::Unknown { lower, upper } => {
                assert!(answer.stats.visits == budget && lower == 0.0 && upper >= 0.0, "{answer:?}");
            }
        }
    }
    assert!(!matches!(collided.verdict, Verdict::Unknown { .. }), "no budget was set");
    if let Some(distance) = distance {
        assert_eq!(distance.upper == 0.0, !want.is_empty(), "{distance:?} {pose:?}");
        assert!(distance.lower <= distance.upper, "{distance:?}");
        if distance.upper.is_finite() {
            compare_bounds(a, b, pose, (budget, distance), input);
        }
    }
    for isa in Isa::available().filter(|isa| *isa != Isa::SCALAR) {
        assert_eq!(answers(isa, a, b, pose, budget, distances), scalar, "{isa} {pose:?}");
    }
}

/// Checks that margins, and distances with a budget, agree with the distance.
fn compare_bounds<N: Lanes>(
    a: &Body<N>,
    b: &Body<N>,
    pose: &Pose,
    (budget, distance): (u64, &Distance),
    input: &mut Input,
) {
    let (a, b) = (a.tree.view(), b.tree.view());
    let margin = distance.upper * [0.5, 0.98, 1.0, 1.02, 2.0, 1000.0][input.below(6)];
    let ask = |isa: Isa| {
        let query = Query::new(isa);
        let partial = query.with_budget(budget).distance(&a, &b, pose, 0.01).unwrap();
        let within = query.within(&a, &b, pose, margin).unwrap();
        (partial, within, query.with_budget(budget).within(&a, &b, pose, margin).unwrap())
    };
    let (partial, within, short) = ask(Isa::SCALAR);
    let (lower, upper) = (distance.lower * (1.0 - 1e-12), distance.upper * (1.0 + 1e-12));
    assert!(partial.lower <= upper && lower <= partial.upper, "{partial:?} {distance:?} {pose:?}");
    assert!(
        if within.is_free() { margin < upper } else { lower <= margin },
        "{margin:e} {within:?} {distance:?}"
    );
    match short.verdict {
        Verdict::Unknown { lower: least, upper: most } => {
            assert!(least <= upper && lower <= most, "{short:?} {distance:?} {pose:?}");
        }
        verdict => assert_eq!(verdict, within.verdict, "{budget} {pose:?}"),
    }
    for isa in Isa::available() {
        assert_eq!(ask(isa), (partial, within, short), "{isa} {pose:?}");
    }
}

/// Collision, collision with a budget, all pairs in ascending order, and distance.
type Answers = (Answer, Answer, Vec<Pair>, Option<Distance>);

fn answers<N: Lanes>(
    isa: Isa,
    a: &Body<N>,
    b: &Body<N>,
    pose: &Pose,
    budget: u64,
    distances: bool,
) -> Answers {
    let (query, a, b) = (Query::new(isa), a.tree.view(), b.tree.view());
    let mut pairs = Vec::new();
    let (completion, _) = query.for_each_pair(&a, &b, pose, |pair| {
        pairs.push(pair);
        ControlFlow::Continue(())
    });
    assert_eq!(completion, Completion::Complete);
    pairs.sort_unstable();
    let distance = distances.then(|| query.distance(&a, &b, pose, 0.01).unwrap());
    (query.collide(&a, &b, pose), query.with_budget(budget).collide(&a, &b, pose), pairs, distance)
}
