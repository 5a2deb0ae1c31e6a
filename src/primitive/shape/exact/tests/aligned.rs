//! Shapes along the axes, against the tests of any shapes and certain bounds.

use super::super::aligned::decide;
use super::*;
use crate::primitive::shape::bounds::bounds;

/// Small numbers, so that many pairs touch.
fn random(rng: &mut Rng, kind: u64, unit: f64) -> Shape {
    let mut length = || rng.int(1, 4) as f64 * unit;
    let lengths = [length(), length(), length()];
    let at = [0, 1, 2].map(|_| rng.int(-5, 5) as f64 * unit);
    let (axis, sign) = (rng.below(3) as usize, *rng.pick(&[1.0, -1.0]));
    let along = |k: usize, length: f64| {
        let mut v = [0.0; 3];
        v[k] = sign * length;
        v
    };
    let core = match kind {
        0 => Core::Point(at),
        1 => Core::Segment([at, [0, 1, 2].map(|k| at[k] + along(axis, lengths[0])[k])]),
        2 => Core::Cuboid { centre: at, half: [0, 1, 2].map(|j| along((axis + j) % 3, lengths[j])) },
        3 => Core::Cylinder { centre: at, half_axis: along(axis, lengths[0]), radius: lengths[1] },
        4 => Core::Cone { base: at, axis: along(axis, lengths[0]), radius: lengths[1] },
        _ => {
            let [x, y, z] = along(axis, *rng.pick(&[1.0, 1.0, 2.0, 1.5]));
            return Shape::half_space([x, y, z], at[0]).unwrap();
        }
    };
    let radius = if rng.below(2) == 0 { 0.0 } else { rng.int(0, 3) as f64 * unit };
    Shape::new(core, radius).unwrap()
}

/// Binary and decimal fractions of any size, and a tenth of the numbers one digit off.
fn pair(rng: &mut Rng, kinds: [u64; 2]) -> [Shape; 2] {
    let unit = *rng.pick(&[1.0, 0.125, 0.05, 0.1, 1e-6, 3e9, power_of_two(-240), power_of_two(296)]);
    let is_off = rng.below(4) == 0;
    kinds.map(|kind| {
        let shape = random(rng, kind, unit);
        let mut beside = |x: f64| {
            let is_moved = is_off && x != 0.0 && rng.below(10) == 0;
            if is_moved { *rng.pick(&[x.next_up(), x.next_down()]) } else { x }
        };
        Shape::unchecked(shape.core.map(&mut beside), beside(shape.radius))
    })
}

#[test]
fn verdicts_are_those_of_any_shapes() {
    let mut rng = Rng::new(11);
    // Two half-spaces are left to the test of any.
    for kinds in (0..6).flat_map(|i| (0..=i.min(4)).map(move |j| [i, j])) {
        let (mut certain, mut hits) = (0, 0);
        for i in 0..1000 {
            let [a, b] = pair(&mut rng, kinds);
            let margin = *rng.pick(&[0.0, 0.0, a.radius, 0.5]);
            let got = decide(&a, &b, margin);
            assert_eq!(got, decide(&b, &a, margin), "{a:?} {b:?} {margin:e}");
            let Some(got) = got else { continue };
            certain += 1;
            hits += usize::from(got);
            match is_within(&a, &b, margin) {
                Some(exact) => assert_eq!(got, exact, "{i}: {a:?} {b:?} {margin:e}"),
                None => {
                    let found = bounds(&a, &b, margin, 0.0);
                    assert!(got && found.lower <= margin, "{i}: {a:?} {b:?} {margin:e}: {found:?}");
                }
            }
        }
        // Only hits are decided for two round solids, and for round solids with segments or cuboids at a reach.
        let least = match kinds.iter().filter(|kind| (3..5).contains(*kind)).count() {
            0 => 500,
            1 => 150,
            _ => 50,
        };
        assert!(certain > least && hits > 50, "{kinds:?}: {certain} {hits}");
    }
}

/// Round solids that touch in one point, a line or a disc are hits; a unit farther apart they are not.
#[test]
fn round_solids_touch() {
    let cylinder =
        |centre, half_axis, radius| Shape::new(Core::Cylinder { centre, half_axis, radius }, 0.0).unwrap();
    let cone = |base, axis, radius| Shape::new(Core::Cone { base, axis, radius }, 0.0).unwrap();
    let can = cylinder([0.0; 3], [0.0, 0.0, 2.0], 1.0);
    let hat = cone([0.0, 0.0, 0.0], [0.0, 0.0, 2.0], 1.0);
    let cases = [
        (can, cylinder([1.0, 0.5, 3.0], [0.0, 0.0, 1.0], 0.5), 2),
        (can, cylinder([0.75, 1.0, 0.0], [0.0, 0.0, 1.0], 0.25), 1),
        (can, cylinder([0.25, 1.5, 1.0], [0.5, 0.0, 0.0], 0.5), 1),
        (can, cylinder([0.0, 0.5, 3.5], [0.0, 1.0, 0.0], 1.5), 2),
        (can, cone([0.5, 0.25, 2.0], [0.0, 0.0, 1.0], 0.25), 2),
        (can, cone([0.5, 0.0, 4.0], [0.0, 0.0, -2.0], 0.25), 2),
        (hat, cone([0.0, 0.0, 3.0], [0.0, 0.0, -1.0], 0.5), 2),
        (hat, cone([2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.5), 0),
        (hat, cone([1.5, 0.0, 0.0], [0.0, 0.0, -1.0], 0.5), 0),
    ];
    for (a, b, axis) in cases {
        for by in [1.0, 3e9, power_of_two(-100)] {
            let [a, b] = [&a, &b].map(|s| Shape { core: s.core.map(|x| by * x), radius: 0.0 });
            assert_eq!(decide(&a, &b, 0.0), Some(true), "{a:?} {b:?}");
            let step = by * power_of_two(-30);
            let away = |p: &Point| {
                let mut p = *p;
                p[axis] += step;
                p
            };
            let core = match &b.core {
                Core::Cylinder { centre, half_axis, radius } => {
                    Core::Cylinder { centre: away(centre), half_axis: *half_axis, radius: *radius }
                }
                Core::Cone { base, axis, radius } => {
                    Core::Cone { base: away(base), axis: *axis, radius: *radius }
                }
                other => *other,
            };
            assert_ne!(decide(&a, &Shape { core, radius: 0.0 }, 0.0), Some(true), "{a:?} {b:?}");
        }
    }
}
