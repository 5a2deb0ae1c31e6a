//! The library's answers for hard pairs of shapes, of all combinations of kinds, against the oracle.
//!
//! The ignored test takes hours. `SIMDOP_SHAPE_PAIRS` sets its number of pairs per combination of kinds (by default ten
//! million); with `SIMDOP_SHAPE_SKIP`, it goes on after this many combinations.

use crate::shape_cases::{Kind, hard_margin, hard_pair, kind_pairs};
use crate::shape_oracle::Judgement::{self, Apart, Meets, TooCloseToCall};
use crate::shape_oracle::{Interval, distance_interval, is_rational, meets as judge, meets_finely};
use crate::support::data::suite_step;
use crate::support::rng::Rng;
use simdop::primitive::Separation;
use simdop::primitive::shape::{Core, Shape, is_within, meets, separation};
use std::sync::Mutex;

/// Pairs per combination of kinds.
const PAIRS: u64 = 4000;
const THREADS: usize = 2;

/// Pairs that rational numbers cannot decide may count as meeting at a distance of at most this share of the size.
const RESOLVED: f64 = 1.0 / (1_u64 << 40) as f64;

/// The distance is checked for one pair in this many.
const DISTANCES: u64 = 16;

#[test]
fn answers_match_the_oracle() {
    check_all(PAIRS / suite_step() as u64, 0, 0);
}

#[test]
#[ignore = "hours: ten million pairs of each two kinds"]
fn answers_match_the_oracle_on_many() {
    let number = |name, default| std::env::var(name).map_or(default, |n| n.parse().expect("a number"));
    check_all(number("SIMDOP_SHAPE_PAIRS", 10_000_000), number("SIMDOP_SHAPE_SKIP", 0) as usize, 1);
}

/// Prints the tally of two kinds when it is known: many pairs take hours.
fn check_all(pairs: u64, skip: usize, seed: u64) {
    assert!(skip < kind_pairs().count(), "no combination is left");
    let kinds = Mutex::new(kind_pairs().skip(skip));
    println!("{:10} {:10} {:>9} {:>9} {:>9}", "", "", "apart", "meet", "too close");
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                let next = || kinds.lock().expect("no panic while it is locked").next();
                while let Some((p, q)) = next() {
                    let [apart, meet, close] = check_kinds((p, q), pairs, seed);
                    println!("{:10} {:10} {apart:9} {meet:9} {close:9}", format!("{p:?}"), format!("{q:?}"));
                    assert!(apart * 20 > pairs && meet * 20 > pairs, "both answers are frequent");
                }
            });
        }
    });
}

/// How many pairs are apart, meet, and are too close to call.
fn check_kinds(kinds: (Kind, Kind), pairs: u64, seed: u64) -> [u64; 3] {
    let mut rng = Rng::new(0x5ade + seed);
    let mut count = [0; 3];
    for i in 0..pairs {
        let (a, b) = hard_pair(kinds, &mut rng);
        let margin = hard_margin(&a, &b, &mut rng);
        let judged = judge(&a, &b, margin);
        count[judged as usize] += 1;
        check_decision(&a, &b, margin, judged);
        if i % DISTANCES == 0 {
            check_distance(&a, &b, &mut rng);
        }
    }
    count
}

fn check_decision(a: &Shape, b: &Shape, margin: f64, judged: Judgement) {
    for (a, b) in [(a, b), (b, a)] {
        let what = || format!("{a:?} {b:?} margin {margin:e}: {judged:?}");
        let got = is_within(a, b, margin);
        match judged {
            Meets => assert!(got, "a miss: {}", what()),
            TooCloseToCall => assert!(got || meets_finely(a, b, margin) == Apart, "a miss: {}", what()),
            Apart if !got => {}
            Apart => {
                assert!(!is_rational(a, b, margin), "a false hit: {}", what());
                let found = distance_interval(a, b);
                let excess = found.to_f64().0 - margin;
                assert!(excess <= RESOLVED * found.size().max(margin), "a false hit: {}", what());
            }
        }
        if margin == 0.0 {
            assert_eq!(meets(a, b), got, "{}", what());
        }
    }
}

/// Bounds enclose the distance, are as tight as requested, and belong to the points.
fn check_distance(a: &Shape, b: &Shape, rng: &mut Rng) {
    let found = distance_interval(a, b);
    let (least, most) = found.to_f64();
    let tolerance = *rng.pick(&[0.0, 1e-9, 1e-3, 0.5]);
    let limit = *rng.pick(&[f64::INFINITY, 2.0 * most, 0.5 * least, 0.0]);
    let what = || format!("{a:?} {b:?} limit {limit:e} tolerance {tolerance:e}: {found:?}");
    let Some(got) = separation(a, b, limit, tolerance) else {
        assert!(most > limit, "a miss: {}", what());
        return;
    };
    let Separation { lower, upper, .. } = got;
    // Pairs that are not certainly apart count as meeting.
    let unresolved = if upper == 0.0 && !is_rational(a, b, 0.0) { RESOLVED * found.size() } else { 0.0 };
    assert!(lower <= most && least <= upper + unresolved && lower <= upper, "{got:?} {}", what());
    assert!(lower <= limit, "{got:?} {}", what());
    assert_eq!(upper == 0.0, meets(a, b), "{got:?} {}", what());
    if upper <= limit {
        // The height above a plane far from the origin has the rounding errors of the coordinates.
        let is_flat = [a, b].iter().any(|shape| matches!(shape.core(), Core::HalfSpace { .. }));
        let far = [got.a, got.b].as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let slack = RESOLVED * found.size().max(if is_flat { far } else { 0.0 });
        assert!(upper - lower <= tolerance * upper + slack, "{got:?} {}", what());
        check_points(a, b, &got, &found);
    }
}

/// The two points are in their shapes, and `upper` apart, up to rounding.
fn check_points(a: &Shape, b: &Shape, got: &Separation, found: &Interval) {
    let largest = [got.a, got.b].as_flattened().iter().fold(found.size(), |most, x| most.max(x.abs()));
    // If the shapes meet, the points coincide to 2^-26.
    let share = if got.upper == 0.0 { 2e-8 } else { 1e-9 };
    let slack = share * largest + 4.0 * simdop::range::MIN_COORDINATE;
    let point = |p: [f64; 3]| {
        let flushed = p.map(|x| if x.abs() < simdop::range::MIN_COORDINATE { 0.0 } else { x });
        Shape::new(Core::Point(flushed), 0.0).expect("a point in range")
    };
    let (p, q) = (point(got.a), point(got.b));
    for (shape, point) in [(a, &p), (b, &q)] {
        assert!(distance_interval(shape, point).to_f64().0 <= slack, "{got:?} {shape:?}");
    }
    let apart = distance_interval(&p, &q).to_f64().0;
    assert!((apart - got.upper).abs() <= slack, "{got:?} {a:?} {b:?}");
}
