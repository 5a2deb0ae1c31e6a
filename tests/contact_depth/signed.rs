//! The signed distance, and its derivative by the pose, against finite differences.

use crate::support::data::suite_step;
use crate::support::rng::Rng;
use crate::support::shapes::torus;
use crate::support::turns::pose;
use crate::{grid_box, solid};
use glam::{DMat3, DQuat, DVec3};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

/// The pose, followed by a small motion along one of the six directions of the derivative.
fn nudged(at: &Pose, direction: usize, by: f64) -> Pose {
    let r = at.rows();
    let rows = DMat3::from_cols_array_2d(&[r[0], r[1], r[2]]).transpose();
    let t = DVec3::from_array(at.translation());
    let axis = DVec3::AXES[direction % 3];
    if direction < 3 {
        return Pose::new(rows, t + axis * by).unwrap();
    }
    let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, by));
    Pose::new(turn * rows, turn * t).unwrap()
}

#[test]
fn gradients_are_those_of_differences() {
    let mut rng = Rng::new(19);
    let (a, b) = (solid(&torus(20, 10)), solid(&grid_box([-1.0; 3], [1.0; 3], 2)));
    let query = Query::new(Isa::detect());
    let distance = |at: &Pose| query.signed_distance(&a, &b, at, 0.0, None).unwrap();
    let (mut smooth, mut all) = (0_usize, 0);
    for _ in 0..80 / suite_step() {
        let along = rng.rotation()[0];
        let far = rng.range(2.5, 5.0);
        let at = pose(&rng.rotation(), along.map(|x| x * far));
        let found = distance(&at);
        if found.lower <= 1e-3 {
            continue;
        }
        assert!((found.upper - query.distance(&a, &b, &at, 0.0).unwrap().upper).abs() == 0.0);
        for direction in 0..6 {
            let step = 1e-5;
            let ahead = distance(&nudged(&at, direction, step)).upper;
            let back = distance(&nudged(&at, direction, -step)).upper;
            let slope = (ahead - back) / (2.0 * step);
            all += 1;
            // Where the nearest features change between the two, there is no derivative.
            smooth += usize::from((slope - found.gradient[direction]).abs() < 1e-4);
        }
    }
    assert!(all > 100 / suite_step() && 20 * smooth > 19 * all, "{smooth} of {all}");
}

/// For boxes that overlap along one axis, the depth is smooth: it grows only with the translation along that axis.
#[test]
fn gradients_of_depths_point_outwards() {
    let query = Query::new(Isa::detect());
    let [a, b] = [[2.0; 3], [2.0, 3.0, 3.0]].map(|half| solid(&grid_box(half.map(|x: f64| -x), half, 2)));
    let at =
        |x: f64| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 0.5]]).unwrap();
    let found = query.signed_distance(&a, &b, &at(3.5), 0.0, None).unwrap();
    assert!((found.lower + 0.5).abs() < 1e-9 && (-0.5 - 1e-12..-0.49).contains(&found.upper), "{found:?}");
    assert!(found.gradient[..3].iter().zip([1.0, 0.0, 0.0]).all(|(x, y)| (x - y).abs() < 1e-6), "{found:?}");
    // The point of A on its face, before the translation, and that of B on its own.
    assert!((found.a[0] - 1.5).abs() < 1e-8 && (found.b[0] - 2.0).abs() < 1e-8, "{found:?}");
    let [_, y, z] = found.a;
    for (direction, want) in [(3, 0.0), (4, z), (5, -y)] {
        assert!((found.gradient[direction] - want).abs() < 1e-5, "{found:?}");
    }
    assert!(query.signed_distance(&a, &b, &at(0.0), -1.0, None).is_err());
    let free = query.signed_distance(&a, &b, &at(5.0), 0.0, None).unwrap();
    assert!((free.upper - 1.0).abs() < 1e-12 && free.normal == [1.0, 0.0, 0.0], "{free:?}");
}
