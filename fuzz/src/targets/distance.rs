//! Distances, margins and cutoffs between two trees agree with the exact distance of all their triangles, the reported
//! pairs are as near as reported, and every instruction set gives the same answers.

use crate::bodies::{Body, with_pair};
use crate::support::exact_distance::{exact_distance, mesh_distance};
use crate::{Input, Mode, NodeChoice, for_node};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Distance, Lanes, Query, Verdict};

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, node) = (input.mode(), NodeChoice::new(&mut input));
    for_node!(node, check(&mut input, mode));
}

fn check<N: Lanes>(input: &mut Input, mode: Mode) {
    with_pair::<N>(input, mode, compare);
}

/// Relative rounding error of the oracle and of the library's sums of squares.
const ROUNDING: f64 = 1e-14;

/// The exact distance of two bodies, and the pair of triangles at that distance.
struct Oracle<'a> {
    a: Vec<[[f64; 3]; 3]>,
    b: &'a [[[f64; 3]; 3]],
    distance: f64,
    /// Maximum distance of a corner from the origin: the rounding of points, and of the bounds of needles, is relative
    /// to it.
    size: f64,
}

fn compare<N: Lanes>(a: &Body<N>, b: &Body<N>, pose: &Pose, input: &mut Input) {
    let budget = input.below(32) as u64;
    let tolerance = [0.0, 0.01, 3.0][input.below(3)];
    let ask = |isa: Isa| Query::new(isa).distance(&a.tree, &b.tree, pose, tolerance).unwrap();
    let got = ask(Isa::SCALAR);
    let moved: Vec<_> = a.triangles.iter().map(|t| t.map(|p| pose.apply(p))).collect();
    // The search finds a nearer pair if the answer is too large, and none if it is too small.
    let distance = mesh_distance(&moved, &b.triangles, got.upper * (1.0 + 1e-9));
    let corners = moved.iter().chain(&b.triangles).flatten().flatten();
    let size = corners.fold(0.0, |size: f64, x| size.max(x.abs()));
    let oracle = Oracle { a: moved, b: &b.triangles, distance, size };
    oracle.bound(&got, pose);
    assert_eq!(got.completion, Completion::Complete);
    let tight = got.lower * (1.0 + tolerance) * (1.0 + 1e-12) + 1e-14 * size;
    assert!(got.upper <= tight || oracle.is_empty(), "{tolerance} {got:?} {pose:?}");

    let factor = [0.0, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 2.0, 1000.0][input.below(7)];
    let limit = if oracle.is_empty() { factor } else { distance * factor };
    let ask_more = |isa: Isa| {
        let (query, a, b) = (Query::new(isa), &a.tree, &b.tree);
        let few = query.with_budget(budget);
        let distances =
            [few.distance(a, b, pose, tolerance), query.distance_up_to(a, b, pose, tolerance, limit)];
        (distances.map(Result::unwrap), [query, few].map(|query| query.within(a, b, pose, limit).unwrap()))
    };
    let (distances, answers) = ask_more(Isa::SCALAR);
    let [partial, limited] = &distances;
    oracle.bound(partial, pose);
    oracle.bound(limited, pose);
    assert!(
        limited.witness.is_some() || limited.lower >= limit || oracle.is_empty(),
        "{limit:e} {limited:?}"
    );
    for answer in &answers {
        oracle.decide(answer, limit, pose);
    }
    assert!(!matches!(answers[0].verdict, Verdict::Unknown { .. }), "no budget was set");
    for isa in Isa::available().filter(|isa| *isa != Isa::SCALAR) {
        assert_eq!(ask(isa), got, "{isa} {pose:?}");
        assert_eq!(ask_more(isa), (distances, answers), "{isa} {limit:e} {pose:?}");
    }
}

impl Oracle<'_> {
    fn is_empty(&self) -> bool {
        self.a.is_empty() || self.b.is_empty()
    }

    /// Checks that the bounds contain the distance, that the reported pair is within the upper one, and that this is 0
    /// exactly if the pair meets.
    fn bound(&self, got: &Distance, pose: &Pose) {
        let want = self.distance;
        let what = || format!("{want:e} {got:?} {pose:?}");
        assert!(got.lower <= want * (1.0 + ROUNDING), "{}", what());
        if let Some(witness) = got.witness {
            assert!(want <= got.upper * (1.0 + ROUNDING), "{}", what());
            let of_pair = exact_distance(&self.a[witness.pair.a as usize], &self.b[witness.pair.b as usize]);
            assert!(of_pair <= got.upper * (1.0 + ROUNDING), "{of_pair:e} {}", what());
            assert_eq!(got.upper == 0.0, of_pair == 0.0, "{}", what());
        } else {
            assert!(got.upper == f64::INFINITY, "{}", what());
        }
    }

    /// Checks that a free verdict implies a distance above the margin, and a hit one within it.
    fn decide(&self, answer: &Answer, margin: f64, pose: &Pose) {
        let want = self.distance;
        let what = || format!("{margin:e} {want:e} {answer:?} {pose:?}");
        match answer.verdict {
            Verdict::Free => assert!(want * (1.0 + ROUNDING) > margin || self.is_empty(), "{}", what()),
            Verdict::Hit(pair) => {
                let of_pair = exact_distance(&self.a[pair.a as usize], &self.b[pair.b as usize]);
                assert!(of_pair <= margin * (1.0 + 1e-13) + 1e-14 * self.size, "{of_pair:e} {}", what());
                assert!(margin > 0.0 || of_pair == 0.0, "{}", what());
            }
            Verdict::Unknown { lower, upper } => {
                assert!(lower <= want * (1.0 + ROUNDING) && want <= upper * (1.0 + ROUNDING), "{}", what());
            }
        }
    }
}
