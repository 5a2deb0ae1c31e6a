//! Signed clearances of configurations, and their gradients, against finite differences.

use super::{at, scene};
use crate::support::data;
use crate::support::rng::Rng;
use simdop::planning::PlanningError;
use simdop::primitive::Shape;
use simdop::scene::{Body, SceneSignedDistance};

/// Where the witness does not change, the gradient equals finite differences of distances and depths.
#[test]
fn gradients_are_those_of_differences() {
    let mut scene = scene();
    for (name, shape, place) in [
        ("post", Shape::capsule(0.1, 0.8).unwrap(), at(0.4, 0.1, 0.5)),
        ("shelf", Shape::cuboid([0.5, 0.3, 0.1]).unwrap(), at(-0.3, 0.3, 0.7)),
        ("ball", Shape::sphere(0.2).unwrap(), at(0.1, -0.5, 0.8)),
        ("floor", Shape::half_space([0.0, 0.0, 1.0], -0.05).unwrap(), at(0.0, 0.0, 0.0)),
    ] {
        let _ = scene.insert(name, Body::new(shape).fixed().with_radius(0.01), &place).unwrap();
    }
    let base = scene.link("base").unwrap();
    let floor = scene.objects()[3].0;
    scene.allow_collision(base, floor).unwrap();
    let (mut workspace, mut rng) = (scene.workspace(), Rng::new(17));
    let (mut gradient, mut unused) = ([0.0; 4], [0.0; 4]);
    let (mut apart, mut meeting, mut all) = (0, 0, 0);
    let step = 1e-6;
    for _ in 0..400 / data::suite_step() {
        let values = scene.random(|| rng.range(0.05, 0.95));
        let found = scene.signed_clearance(&mut workspace, &values, 0.0, 10.0, &mut gradient).unwrap();
        let plain = scene.clearance(&mut workspace, &values, 0.0, 10.0).unwrap();
        if plain.upper > 0.0 {
            assert_eq!((found.lower, found.upper), (plain.lower, plain.upper));
        } else {
            assert!(found.upper <= 0.0 && found.lower < 0.0 && found.lower > -2.0, "{found:?}");
            // Depths of shapes are known, for round ones up to the error of the search.
            assert!(found.upper < 0.9 * found.lower, "{found:?}");
        }
        let Some(witness) = found.witness else { continue };
        let value = |found: &SceneSignedDistance| if found.upper > 0.0 { found.upper } else { found.lower };
        for variable in 0..4 {
            let mut moved = |step: f64| {
                let mut moved = values.clone();
                moved[variable] += step;
                scene.signed_clearance(&mut workspace, &moved, 0.0, 10.0, &mut unused).unwrap()
            };
            let (before, after) = (moved(-step), moved(step));
            let is_smooth = |other: &SceneSignedDistance| {
                other.witness.is_some_and(|near| {
                    let is_close = |p: [f64; 3], q: [f64; 3]| (0..3).all(|i| (p[i] - q[i]).abs() < 1e-4);
                    (near.hit.a, near.hit.b) == (witness.hit.a, witness.hit.b)
                        && is_close(near.normal, witness.normal)
                        && is_close(near.a, witness.a)
                })
            };
            if is_smooth(&before) && is_smooth(&after) {
                let slope = (value(&after) - value(&before)) / (2.0 * step);
                // The depth of round shapes is known to about 1e-9.
                let allowed = if found.upper > 0.0 { 1e-4 } else { 1e-2 };
                all += 1;
                let is_near = (slope - gradient[variable]).abs() < allowed;
                assert!(found.upper <= 0.0 || is_near, "{slope} {gradient:?} {variable} {values:?}");
                apart += usize::from(is_near && found.upper > 0.0);
                meeting += usize::from(is_near && found.upper <= 0.0);
            }
        }
    }
    let few = 100 / data::suite_step();
    assert!(apart > few && meeting > few && 20 * (apart + meeting) > 19 * all, "{apart} {meeting} of {all}");
}

#[test]
fn a_gradient_has_one_number_for_each_variable() {
    let scene = scene();
    let mut workspace = scene.workspace();
    let found = scene.signed_clearance(&mut workspace, &[0.0; 4], 0.0, 1.0, &mut [0.0; 3]);
    assert!(matches!(found, Err(PlanningError::Scene(_))));
    assert!(scene.signed_clearance(&mut workspace, &[0.0; 3], 0.0, 1.0, &mut [0.0; 4]).is_err());
    assert!(scene.signed_clearance(&mut workspace, &[0.0; 4], -1.0, 1.0, &mut [0.0; 4]).is_err());
}
