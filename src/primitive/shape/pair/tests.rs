//! Answers for a shape at a pose against those for the moved shape, bit for bit.

use super::*;
use crate::primitive::shape::core::Core;
use crate::primitive::shape::fast::tests::{distance, pose, shape};
use crate::rng::{CASES_STEP, Rng};

/// Spheres to half-spaces as [`shape`] numbers them, and 7 for a triangle.
fn any_shape(rng: &mut Rng) -> Shape {
    match rng.below(8) {
        7 => {
            let corners = [(); 3].map(|()| [(); 3].map(|()| rng.range(-1.0, 1.0)));
            Shape::new(Core::Triangle(corners), 0.0).unwrap()
        }
        kind => shape(rng, kind),
    }
}

fn bits(found: Option<Separation>) -> Option<[u64; 8]> {
    found.map(|s| [s.lower, s.upper, s.a[0], s.a[1], s.a[2], s.b[0], s.b[1], s.b[2]].map(f64::to_bits))
}

#[test]
fn a_pose_gives_the_bits_of_the_moved_shape() {
    let mut rng = Rng::new(21);
    let (mut hits, mut exact, mut distances) = (0, 0, 0);
    for i in 0..20_000 / CASES_STEP {
        let (a, b, at) = (any_shape(&mut rng), any_shape(&mut rng), pose(&mut rng, 2.0));
        let b = b.moved(&pose(&mut rng, 1.0));
        let moved = a.moved(&at);
        let far = if moved.is_half_space() || b.is_half_space() { 0.5 } else { distance(&moved, &b) };
        for margin in [0.0, far, f64::next_up(far), 0.25] {
            let mut counts = [0, 0];
            let want = is_near(&moved, &b, margin, &mut counts[0]);
            let got = is_near_posed(&a, &at, &b, margin, &mut counts[1]);
            assert_eq!((got, counts[1]), (want, counts[0]), "{i}: {a:?} {at:?} {b:?} {margin:e}");
            hits += u32::from(got);
            exact += counts[0];
        }
        for (limit, tolerance) in [(f64::INFINITY, TIGHT), (f64::INFINITY, 1e-3), (0.5 * far, TIGHT)] {
            let mut counts = [0, 0];
            let want = nearer(&moved, &b, limit, tolerance, &mut counts[0]);
            let got = nearer_posed(&a, &at, &b, limit, tolerance, &mut counts[1]);
            assert_eq!((bits(got), counts[1]), (bits(want), counts[0]), "{i}: {a:?} {at:?} {b:?} {limit:e}");
            distances += u32::from(got.is_some_and(|found| found.lower > 0.0));
        }
    }
    let least = 2000 / CASES_STEP as u32;
    assert!(
        hits > 10 * least && exact > u64::from(least) && distances > 5 * least,
        "{hits} {exact} {distances}"
    );
}
