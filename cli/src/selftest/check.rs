//! Compares the library's answers with the truth.

use super::oracle::Truth;
use super::trees::AllPairs;
use serde::Serialize;
use simdop::isa::Isa;
use simdop::query::{Answer, Verdict};
use std::collections::BTreeSet;

/// How an answer is wrong.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Wrong {
    /// A collision was not found.
    Missed,
    /// A collision was reported where there is none.
    Invented,
    /// Instruction sets differ, in verdict, witness or query statistics.
    Unequal,
}

/// The kinds of errors in the answers of all instruction sets to one query, each once, with the first instruction set
/// that shows it. `is_pair` says whether two primitives may be the witness of a hit.
pub(super) fn verdicts(
    truth: Truth,
    answers: &[(Isa, Answer)],
    is_pair: impl Fn(u32, u32) -> bool,
) -> Vec<(Wrong, Isa)> {
    let of_one = |answer: &Answer| match answer.verdict {
        Verdict::Hit(pair) if !truth.meets || !is_pair(pair.a, pair.b) => Some(Wrong::Invented),
        Verdict::Free | Verdict::Unknown { .. } if truth.meets => Some(Wrong::Missed),
        // Without a budget no answer may be unknown.
        Verdict::Unknown { .. } => Some(Wrong::Invented),
        Verdict::Hit(_) | Verdict::Free => None,
    };
    let wrong = answers.iter().filter_map(|(isa, answer)| Some((of_one(answer)?, *isa)));
    first_of_each(wrong.chain(unequal(answers)))
}

/// The errors in the lists of all pairs that meet.
pub(super) fn all_pairs(truth: &BTreeSet<(u32, u32)>, answers: &[(Isa, AllPairs)]) -> Vec<(Wrong, Isa)> {
    let of_one = |isa: Isa, found: &BTreeSet<(u32, u32)>| {
        let missed = (!truth.is_subset(found)).then_some((Wrong::Missed, isa));
        let invented = (!found.is_subset(truth)).then_some((Wrong::Invented, isa));
        missed.into_iter().chain(invented)
    };
    let wrong = answers.iter().flat_map(|(isa, (pairs, _))| of_one(*isa, pairs));
    first_of_each(wrong.chain(unequal(answers)))
}

/// The first instruction set whose answer differs from the weakest one's.
pub(super) fn unequal<A: PartialEq>(answers: &[(Isa, A)]) -> Option<(Wrong, Isa)> {
    let (_, first) = answers.first()?;
    answers.iter().find(|(_, answer)| answer != first).map(|(isa, _)| (Wrong::Unequal, *isa))
}

/// The first of each kind.
pub(super) fn first_of_each(wrong: impl Iterator<Item = (Wrong, Isa)>) -> Vec<(Wrong, Isa)> {
    let mut first: Vec<(Wrong, Isa)> = Vec::new();
    for (kind, isa) in wrong {
        if first.iter().all(|(seen, _)| *seen != kind) {
            first.push((kind, isa));
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use simdop::query::{Hint, Pair, QueryStats};

    fn answer(verdict: Verdict) -> Answer {
        Answer { verdict, stats: QueryStats::default(), hint: Hint::NONE }
    }

    fn truth(meets: bool) -> Truth {
        Truth { meets, is_knife_edge: false }
    }

    const HIT: Verdict = Verdict::Hit(Pair { a: 1, b: 2 });
    const UNKNOWN: Verdict = Verdict::Unknown { lower: 0.0, upper: 1.0 };

    /// The errors for one instruction set; the correct witness is 1 and 2.
    fn kinds(meets: bool, verdict: Verdict) -> Vec<Wrong> {
        let wrong = verdicts(truth(meets), &[(Isa::SCALAR, answer(verdict))], |a, b| (a, b) == (1, 2));
        wrong.into_iter().map(|(wrong, _)| wrong).collect()
    }

    #[test]
    fn a_wrong_verdict_is_reported() {
        assert_eq!(kinds(true, HIT), []);
        assert_eq!(kinds(false, Verdict::Free), []);
        assert_eq!(kinds(true, Verdict::Free), [Wrong::Missed]);
        assert_eq!(kinds(false, HIT), [Wrong::Invented]);
        assert_eq!(kinds(true, Verdict::Hit(Pair { a: 1, b: 3 })), [Wrong::Invented], "another pair");
        assert_eq!(kinds(true, UNKNOWN), [Wrong::Missed]);
        assert_eq!(kinds(false, UNKNOWN), [Wrong::Invented]);
    }

    #[test]
    fn instruction_sets_that_differ_are_reported() {
        let slow = Answer { stats: QueryStats { visits: 1, ..QueryStats::default() }, ..answer(HIT) };
        let isa = Isa::detect();
        let of =
            |second: Answer| verdicts(truth(true), &[(Isa::SCALAR, answer(HIT)), (isa, second)], |_, _| true);
        assert_eq!(of(answer(HIT)), []);
        assert_eq!(of(slow), [(Wrong::Unequal, isa)], "another count");
        assert_eq!(of(answer(Verdict::Free)), [(Wrong::Missed, isa), (Wrong::Unequal, isa)]);
    }

    #[test]
    fn pairs_too_few_and_too_many_are_reported() {
        let want: BTreeSet<_> = [(0, 1), (2, 3)].into();
        let of = |pairs: &[(u32, u32)]| {
            let found = (pairs.iter().copied().collect(), QueryStats::default());
            let wrong = all_pairs(&want, &[(Isa::SCALAR, found)]);
            wrong.into_iter().map(|(wrong, _)| wrong).collect::<Vec<_>>()
        };
        assert_eq!(of(&[(2, 3), (0, 1)]), []);
        assert_eq!(of(&[(0, 1)]), [Wrong::Missed]);
        assert_eq!(of(&[(0, 1), (2, 3), (4, 4)]), [Wrong::Invented]);
        assert_eq!(of(&[(0, 2)]), [Wrong::Missed, Wrong::Invented]);
    }
}
