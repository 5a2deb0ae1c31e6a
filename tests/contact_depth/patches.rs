//! Patches: of cubes on cubes, and of bodies that touch in several places.

use crate::support::data::suite_step;
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, torus};
use crate::support::turns::pose;
use crate::{Tree, grid_box, solid};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::{Completion, ContactPatch, Query, TooManyPatches, TriangleContact, patches};

fn found(a: &Tree, b: &Tree, at: &Pose) -> (Vec<TriangleContact>, Vec<ContactPatch>) {
    let mut contacts = vec![TriangleContact::default(); 4096];
    let answer = Query::new(Isa::detect()).contacts(a, b, at, &mut contacts);
    assert_eq!(answer.completion, Completion::Complete);
    contacts.truncate(answer.count);
    let mut all = vec![ContactPatch::default(); 16];
    let count = patches(&mut contacts, &mut all).unwrap();
    all.truncate(count);
    (contacts, all)
}

fn is_one_of(p: &[f64; 3], corners: &[[f64; 3]]) -> bool {
    corners.iter().any(|q| (0..3).all(|i| (p[i] - q[i]).abs() <= 1e-12))
}

/// A cube that stands on a larger one, rotated about the common normal: the points that span the patch are its corners.
#[test]
fn a_cube_on_a_cube_touches_in_four_corners() {
    let mut rng = Rng::new(7);
    for (n, m) in [(1, 1), (3, 2)] {
        let (a, b) = (solid(&grid_box([-0.5; 3], [0.5; 3], n)), solid(&grid_box([-2.0; 3], [2.0; 3], m)));
        for _ in 0..500 / suite_step() {
            let (u, v) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
            let long = u.hypot(v).max(1e-3);
            let (cosine, sine) = (u / long, v / long);
            let turn = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
            let at = pose(&turn, [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), 2.5]);
            let corners =
                [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| at.apply([x, y, -0.5]));
            let (contacts, all) = found(&a, &b, &at);
            assert_eq!(all.len(), 1);
            let patch = all[0];
            assert!((patch.normal[2] - 1.0).abs() < 1e-12, "{patch:?}");
            assert!((patch.area - 1.0).abs() < 1e-9, "{patch:?}");
            let mut points = [[0.0; 3]; 4];
            assert_eq!(patch.span(&contacts, &mut points), 4);
            assert!(points.iter().all(|p| is_one_of(p, &corners)), "{points:?} {corners:?}");
            assert!(corners.iter().all(|p| is_one_of(p, &points)), "{points:?} {corners:?}");
        }
    }
}

/// A cube that is sunk into a larger one, slightly tilted: the patch is spanned by the points where its upright edges
/// pierce the face.
#[test]
fn a_sunk_cube_touches_where_its_edges_pierce() {
    let mut rng = Rng::new(8);
    let (a, b) = (solid(&grid_box([-0.5; 3], [0.5; 3], 1)), solid(&grid_box([-2.0; 3], [2.0; 3], 1)));
    for _ in 0..500 / suite_step() {
        let tilt = *rng.pick(&[1e-3, 1e-6, 1e-9]);
        let (x, y) = (rng.range(-tilt, tilt), rng.range(-tilt, tilt));
        // Turned about x, then about y, up to terms that are squared away in both rows.
        let (cx, cy) = ((1.0 - x * x).sqrt(), (1.0 - y * y).sqrt());
        let turn = [[cy, x * y, cx * y], [0.0, cx, -x], [-y, x * cy, cx * cy]];
        let sunk = *rng.pick(&[0.2, 1e-2]);
        let at = pose(&turn, [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), 2.5 - sunk]);
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|[x, y]| {
            let [low, high] = [-0.5, 0.5].map(|z| at.apply([x, y, z]));
            let share = (2.0 - low[2]) / (high[2] - low[2]);
            [0, 1, 2].map(|i| low[i] + (high[i] - low[i]) * share)
        });
        let (contacts, all) = found(&a, &b, &at);
        assert_eq!(all.len(), 1);
        assert!(all[0].normal[2] > 0.999 && (all[0].area - 1.0).abs() < 0.01, "{:?}", all[0]);
        let mut points = [[0.0; 3]; 4];
        assert_eq!(all[0].span(&contacts, &mut points), 4);
        assert!(points.iter().all(|p| is_one_of(p, &corners)), "{points:?} {corners:?}");
        // No point is off the loop, so more points are useless.
        assert_eq!(all[0].span(&contacts, &mut [[0.0; 3]; 9]), 4);
        let (depth, _) = Query::new(Isa::detect()).depth_along(&a, &b, &at, [0.0, 0.0, 1.0]);
        let lowest = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
            .map(|[x, y]| at.apply([x, y, -0.5])[2])
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        assert!((depth - (2.0 - lowest)).abs() < 1e-8, "{depth} {}", 2.0 - lowest);
    }
}

/// Three feet of a table, and a torus around a post, which do not touch.
#[test]
fn each_foot_is_a_patch() {
    let mut table = cuboid([-3.0, -3.0, 1.0], [3.0, 3.0, 1.5], false);
    for [x, y] in [[-2.0, -2.0], [2.0, -2.0], [0.0, 2.0]] {
        append(&mut table, &cuboid([x - 0.25, y - 0.25, 0.0], [x + 0.25, y + 0.25, 1.0], false));
    }
    let (table, floor) = (solid(&table), solid(&grid_box([-5.0, -5.0, -1.0], [5.0, 5.0, 0.0], 4)));
    let at = Pose::from_rows([[1.0, 0.0, 0.0, 0.1], [0.0, 1.0, 0.0, 0.2], [0.0, 0.0, 1.0, -0.125]]).unwrap();
    let (contacts, all) = found(&table, &floor, &at);
    assert_eq!(all.len(), 3);
    assert_eq!(all.iter().map(|patch| patch.count).sum::<usize>(), contacts.len());
    for patch in &all {
        assert!((patch.length - 2.0).abs() < 1e-12 && (patch.area - 0.25).abs() < 1e-12, "{patch:?}");
        assert!((patch.normal[2] - 1.0).abs() < 1e-12, "{patch:?}");
    }
    let mut contacts = contacts;
    assert_eq!(patches(&mut contacts, &mut [ContactPatch::default(); 2]), Err(TooManyPatches { count: 3 }));
    assert_eq!(patches(&mut [], &mut []), Ok(0));
    let ring = solid(&torus(24, 12));
    let (none, no_patches) =
        found(&ring, &solid(&cuboid([-0.3, -0.3, -3.0], [0.3, 0.3, 3.0], false)), &Pose::IDENTITY);
    assert!(none.is_empty() && no_patches.is_empty());
}
