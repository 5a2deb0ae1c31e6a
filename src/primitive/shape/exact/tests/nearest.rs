//! Polytopes: the point of their Minkowski difference that is nearest to the origin.

use super::*;
use crate::rng::CASES_STEP;
use alloc::format;
use alloc::vec;
use alloc::vec::Vec;

/// The squared distance between two polytopes, as a ratio. Gilbert's, Johnson's and Keerthi's method with all subsets
/// of a simplex tried. It ends, since the distance decreases from simplex to simplex.
pub(super) fn square_between<T: Number>(a: &[[T; 3]], b: &[[T; 3]]) -> (T, T) {
    let mut simplex = vec![minus(&a[0], &b[0])];
    loop {
        let (nearest, denominator, square) = nearest_of(&mut simplex);
        if square == T::from(0) {
            return (square, denominator);
        }
        let along = |p: &&[T; 3]| dot(p, &nearest);
        let (p, q) = (a.iter().min_by_key(along).unwrap(), b.iter().max_by_key(along).unwrap());
        let vertex = minus(p, q);
        if dot(&vertex, &nearest) >= square {
            return (square, denominator);
        }
        simplex.push(vertex);
    }
}

/// The point x of a simplex that is nearest to the origin, as a vector and its denominator d, and `x^2 d`. The simplex
/// is reduced to the corners of which it is a positive combination.
fn nearest_of<T: Number>(simplex: &mut Vec<[T; 3]>) -> ([T; 3], T, T) {
    let zero = T::from(0);
    let mut best: Option<(_, T, T, Vec<_>)> = None;
    for subset in 1_usize..1 << simplex.len() {
        let corners: Vec<_> =
            (0..simplex.len()).filter(|i| subset >> i & 1 == 1).map(|i| &simplex[i]).collect();
        let edges: Vec<_> = corners[1..].iter().map(|p| minus(p, corners[0])).collect();
        // The normal equations, solved by Cramer's rule.
        let gram = |i: usize, j: usize| dot(&edges[i], &edges[j]);
        let right = |i: usize| zero.clone() - dot(&edges[i], corners[0]);
        let denominator = determinant(edges.len(), &gram);
        if denominator == zero {
            continue;
        }
        let shares: Vec<T> = (0..edges.len())
            .map(|k| determinant(edges.len(), &|i, j| if j == k { right(i) } else { gram(i, j) }))
            .collect();
        let first = shares.iter().fold(denominator.clone(), |rest, share| rest - share.clone());
        if first <= zero || shares.iter().any(|share| *share <= zero) {
            continue;
        }
        let start = combined(&denominator, corners[0], &zero, corners[0]);
        let point =
            edges.iter().zip(&shares).fold(start, |p, (edge, share)| combined(&T::from(1), &p, share, edge));
        let square = dot(&point, corners[0]);
        if best
            .as_ref()
            .is_none_or(|best| square.clone() * best.1.clone() < best.2.clone() * denominator.clone())
        {
            best = Some((point, denominator, square, corners.into_iter().cloned().collect()));
        }
    }
    let (point, denominator, square, corners) = best.unwrap();
    *simplex = corners;
    (point, denominator, square)
}

fn determinant<T: Number>(size: usize, m: &dyn Fn(usize, usize) -> T) -> T {
    match size {
        0 => T::from(1),
        1 => m(0, 0),
        2 => m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0),
        _ => {
            let row = |i: usize| [m(i, 0), m(i, 1), m(i, 2)];
            dot(&row(0), &cross(&row(1), &row(2)))
        }
    }
}

/// All pairs of polytopes, on small lattices, so that most are degenerate, parallel, coplanar, nested or touching in
/// some cases.
#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn polytopes_are_as_near_as_their_nearest_points() {
    let mut rng = Rng::new(71);
    for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let count = match i + j {
            0 => 10_000,
            1..5 => 10_000 / CASES_STEP,
            _ => 2_500 / CASES_STEP,
        };
        let mut tallies = [Tally::default(), Tally::default()];
        for _ in 0..count {
            let most = rng.int(1, 5);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b) = (draw.core(i), draw.core(j));
            let reach = rng.int(-2, 4).max(0) as f64;
            let (square, denominator) = square_between(&corners(&a, whole), &corners(&b, whole));
            let limit = whole(reach * reach) * denominator;
            let expected = tallies[usize::from(reach > 0.0)].add(square.cmp(&limit));
            assert_eq!(verdict(&mut rng, &a, &b, reach), Some(expected), "{a:?} {b:?} {reach}");
        }
        let [meeting, near] = tallies;
        near.check(count / 400, &format!("near {i} {j}"));
        // A distance of zero counts as touching.
        assert!(meeting.apart.min(meeting.touching) > count / 400, "{i} {j}: {meeting:?}");
    }
}
