//! Intersections of triangles against the oracle, and contact queries against all pairs.

use crate::oracle::{self, Rational};
use crate::support::data::suite_step;
use crate::support::exact::{Tri, meeting_pairs};
use crate::support::rng::Rng;
use crate::support::shapes::wavy_torus;
use crate::support::turns::pose;
use crate::{Tree, solid};
use simdop::isa::Isa;
use simdop::primitive::triangle::{intersection, is_degenerate, overlap};
use simdop::query::{Completion, Query, TriangleContact};

fn size(a: &Tri, b: &Tri) -> f64 {
    let edge = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
    let edges = [a, b].into_iter().flat_map(|t| [edge(&t[0], &t[1]), edge(&t[1], &t[2]), edge(&t[2], &t[0])]);
    let coordinates = a.as_flattened().iter().chain(b.as_flattened());
    2_f64.powi(-44) * edges.fold(0.0, f64::max)
        + 2_f64.powi(-50) * coordinates.fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Whether the points are the corners: one point for each corner, or for several corners within the bound of it.
fn is_of(points: &[[f64; 3]], corners: &[Rational], bound: f64) -> bool {
    let near = |p: &[f64; 3]| corners.iter().filter(|corner| corner.is_near(p, bound)).count();
    corners.iter().all(|corner| points.iter().any(|p| corner.is_near(p, bound)))
        && points.iter().all(|p| near(p) > 0)
        && (points.len() == corners.len() || points.iter().any(|p| near(p) > 1))
}

/// Returns the number of corners.
fn check(a: &Tri, b: &Tri) -> usize {
    let found = intersection(a, b);
    assert_eq!(found.is_some(), overlap(a, b, &mut 0), "{a:?} {b:?}");
    let points = found.as_ref().map_or(&[][..], |found| found.points());
    let want = oracle::intersection(a, b);
    assert!(is_of(points, &want, size(a, b)), "{a:?} {b:?} {points:?} {want:?}");
    points.len()
}

fn any(rng: &mut Rng, size: f64) -> Tri {
    [(); 3].map(|()| [(); 3].map(|()| rng.range(-size, size)))
}

fn on_grid(rng: &mut Rng, width: i64) -> Tri {
    [(); 3].map(|()| [(); 3].map(|()| rng.int(-width, width) as f64))
}

/// Triangles in the plane through small integer vectors.
fn in_plane(rng: &mut Rng, axes: &[[f64; 3]; 2]) -> Tri {
    [(); 3].map(|()| {
        let (x, y) = (rng.int(-4, 4) as f64, rng.int(-4, 4) as f64);
        [0, 1, 2].map(|i| x * axes[0][i] + y * axes[1][i])
    })
}

fn beside(rng: &mut Rng, t: &Tri) -> Tri {
    let mut t = *t;
    let x = &mut t[rng.below(3) as usize][rng.below(3) as usize];
    *x = if rng.below(2) == 0 { x.next_up() } else { *x + rng.range(-1e-12, 1e-12) };
    // Within the oracle's unit.
    t.map(|p| p.map(|x| if x.abs() < 1e-18 { 0.0 } else { x }))
}

#[test]
fn intersections_are_the_exact_ones() {
    let mut rng = Rng::new(43);
    let mut counts = [[0; 7]; 5];
    for i in 0..20_000 / suite_step() {
        let axes = [on_grid(&mut rng, 3)[0], on_grid(&mut rng, 3)[0]];
        let kind = i % counts.len();
        let (a, b) = match kind {
            0 => (any(&mut rng, 1.0), any(&mut rng, 1.0)),
            1 => (on_grid(&mut rng, 2), on_grid(&mut rng, 2)),
            2 => (in_plane(&mut rng, &axes), in_plane(&mut rng, &axes)),
            // Nearly in one plane: the ends are ill-conditioned in plain f64.
            3 => {
                let (a, b) = (in_plane(&mut rng, &axes), in_plane(&mut rng, &axes));
                (beside(&mut rng, &a), b)
            }
            _ => (on_grid(&mut rng, 30).map(|p| p.map(|x| x * 0.1)), any(&mut rng, 3.0)),
        };
        if !is_degenerate(&a) && !is_degenerate(&b) {
            counts[kind][check(&a, &b)] += 1;
        }
    }
    if suite_step() == 1 {
        assert!(counts[0][2] > 200 && counts[1][1] > 50 && counts[1][2] > 200, "{counts:?}");
        assert!(counts[2][3..].iter().all(|count| *count > 5), "{counts:?}");
        assert!(counts[3][2] > 100 && counts[4][2] > 200, "{counts:?}");
    }
}

/// Triangles that are a segment or a point.
#[test]
fn needles_pierce_and_lie_in_triangles() {
    let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let needle = |p: [f64; 3], q: [f64; 3]| [p, q, p];
    let cases: [(Tri, &[[f64; 3]]); 6] = [
        (needle([1.0, 1.0, -1.0], [1.0, 1.0, 3.0]), &[[1.0, 1.0, 0.0]]),
        (needle([1.0, 1.0, 0.0], [1.0, 1.0, 3.0]), &[[1.0, 1.0, 0.0]]),
        (needle([-1.0, 1.0, 0.0], [2.0, 1.0, 0.0]), &[[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]]),
        (needle([1.0, 0.0, 0.0], [9.0, 0.0, 0.0]), &[[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]),
        (needle([4.0, 0.0, 0.0], [9.0, 0.0, 0.0]), &[[4.0, 0.0, 0.0]]),
        (needle([1.0, 1.0, 0.0], [1.0, 1.0, 0.0]), &[[1.0, 1.0, 0.0]]),
    ];
    for (needle, want) in cases {
        for (a, b) in [(&floor, &needle), (&needle, &floor)] {
            let found = intersection(a, b).unwrap();
            let mut points = found.points().to_vec();
            points.sort_by(|p, q| p.partial_cmp(q).unwrap());
            assert_eq!(points, want, "{needle:?}");
        }
    }
    let lines = [needle([0.0; 3], [2.0; 3]), needle([1.0; 3], [3.0; 3])];
    assert_eq!(intersection(&lines[0], &lines[1]).unwrap().points().len(), 2);
    assert_eq!(intersection(&lines[0], &lines[1].map(|p| [p[0], p[1], p[2] + 1.0])), None);
}

fn contacts(a: &Tree, b: &Tree, at: &simdop::Pose, room: usize) -> (Vec<TriangleContact>, Completion) {
    let mut all = Isa::available().map(|isa| {
        let mut into = vec![TriangleContact::default(); room];
        let found = Query::new(isa).contacts(a, b, at, &mut into);
        into.truncate(found.count);
        (into, found.completion, found.stats)
    });
    let first = all.next().unwrap();
    assert!(all.all(|other| other == first));
    (first.0, first.1)
}

#[test]
fn contacts_are_of_all_pairs_that_meet() {
    let mut rng = Rng::new(1);
    let mesh = wavy_torus(400);
    let tree = solid(&mesh);
    for _ in 0..6 {
        let at = pose(&rng.rotation(), [(); 3].map(|()| rng.range(-1.5, 1.5)));
        let moved: Vec<Tri> = mesh.corners().iter().map(|t| t.map(|p| at.apply(p))).collect();
        let want = meeting_pairs(&moved, &mesh.corners());
        let (found, completion) = contacts(&tree, &tree, &at, want.len());
        let mut pairs: Vec<_> = found.iter().map(|c| (c.pair.a as usize, c.pair.b as usize)).collect();
        pairs.sort_unstable();
        assert_eq!((pairs, completion), (want.clone(), Completion::Complete));
        for contact in &found {
            let (a, b) = (&moved[contact.pair.a as usize], &mesh.corners()[contact.pair.b as usize]);
            let corners = oracle::intersection(a, b);
            assert!(is_of(contact.points(), &corners, size(a, b)), "{contact:?} {corners:?}");
        }
        if want.len() > 1 {
            let (fewer, completion) = contacts(&tree, &tree, &at, want.len() - 1);
            assert_eq!((fewer.len(), completion), (want.len() - 1, Completion::Stopped));
            assert_eq!(fewer, found[..fewer.len()]);
        }
        let none = Query::new(Isa::detect()).with_budget(0).contacts(&tree, &tree, &at, &mut []);
        assert_eq!((none.count, none.completion), (0, Completion::OutOfBudget));
    }
}
