//! The answers about two bodies are those of the library.

use simdop::query::{Answer, Completion, Distance, QueryStats, Verdict};
use simdop_capi::*;

fn assert_counters(c: &simdop_query_stats, rust: &QueryStats) {
    let stats = [c.visits, c.kernels, c.realignments, c.primitive_pairs, c.exact_pairs];
    assert_eq!(stats, [rust.visits, rust.kernels, rust.realignments, rust.primitive_pairs, rust.exact_pairs]);
}

pub(crate) fn assert_answers(c: &simdop_answer, rust: &Answer) {
    let none = SIMDOP_NO_PRIMITIVE;
    let (verdict, pair, bounds) = match rust.verdict {
        Verdict::Free => (simdop_verdict::Free, [none; 2], [0.0, f64::INFINITY]),
        Verdict::Hit(pair) => (simdop_verdict::Hit, [pair.a, pair.b], [0.0, f64::INFINITY]),
        Verdict::Unknown { lower, upper } => (simdop_verdict::Unknown, [none; 2], [lower, upper]),
    };
    assert_eq!((c.verdict, [c.pair.a, c.pair.b], [c.lower, c.upper]), (verdict, pair, bounds));
    assert_counters(&c.stats, &rust.stats);
}

pub(crate) fn assert_distances(c: &simdop_distance_answer, rust: &Distance) {
    let verdict = match rust.verdict() {
        Verdict::Free => simdop_verdict::Free,
        Verdict::Hit(_) => simdop_verdict::Hit,
        Verdict::Unknown { .. } => simdop_verdict::Unknown,
    };
    let completion = match rust.completion {
        Completion::Complete => simdop_completion::Complete,
        Completion::Stopped => simdop_completion::Stopped,
        Completion::OutOfBudget => simdop_completion::OutOfBudget,
    };
    assert_eq!((c.verdict, c.completion), (verdict, completion));
    assert_eq!([c.lower, c.upper], [rust.lower, rust.upper]);
    match rust.witness {
        Some(witness) => {
            assert_eq!([c.pair.a, c.pair.b], [witness.pair.a, witness.pair.b]);
            assert_eq!([c.point_a, c.point_b], [witness.a, witness.b]);
        }
        None => {
            assert_eq!([c.pair.a, c.pair.b], [SIMDOP_NO_PRIMITIVE; 2]);
            assert!(c.point_a.iter().chain(&c.point_b).all(|x| x.is_nan()));
        }
    }
    assert_counters(&c.stats, &rust.stats);
}

/// As in `mod.rs`, for items that not all tests use.
const _: () = {
    let _ = (assert_answers, assert_distances);
};
