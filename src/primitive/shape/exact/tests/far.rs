//! Numbers over the whole range, and shapes that touch up to the last digit of one number.

use super::nearest::square_between;
use super::sections::compare;
use super::*;
use crate::range::{MAX_MOVED, MIN_COORDINATE};
use alloc::format;
use dashu_int::IBig;

/// In units of 2^-302.
fn wide(x: f64) -> IBig {
    // In range, so exact.
    let bits = (x * power_of_two(302)).to_bits();
    let (mantissa, exponent) = (bits & ((1 << 52) - 1) | 1 << 52, (bits >> 52 & 0x7ff) as i32 - 1075);
    if x == 0.0 {
        return IBig::ZERO;
    }
    let magnitude = if exponent < 0 {
        assert!(mantissa.trailing_zeros() as i32 >= -exponent, "{x:e}");
        IBig::from(mantissa >> -exponent)
    } else {
        IBig::from(mantissa) << exponent as usize
    };
    if x < 0.0 { -magnitude } else { magnitude }
}

/// A number as it is, or the next one, or a tiny one for zero.
fn beside(rng: &mut Rng, x: f64) -> f64 {
    match rng.below(8) {
        0 if x == 0.0 => MIN_COORDINATE,
        1 if x == 0.0 => -MIN_COORDINATE,
        0 if x.abs() > MIN_COORDINATE => x.next_down(),
        1 if x.abs() > MIN_COORDINATE => x.next_up(),
        _ => x,
    }
}

/// Shapes on a lattice of any size, with some numbers moved by one ulp, which decides pairs that touched before.
#[test]
#[cfg_attr(simdop_neon, ignore = "minutes under an emulator")]
fn one_digit_decides() {
    let mut rng = Rng::new(77);
    let pairs = (0..6).flat_map(|i| (0..=i.min(3)).map(move |j| (i, j)));
    for (i, j) in pairs {
        let mut tallies = [Tally::default(), Tally::default()];
        for _ in 0..500 {
            let most = rng.int(1, 3);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b) = (draw.core(i), draw.core(j));
            let scale = power_of_two(*rng.pick(&[-248, -200, 0, 200, 298]));
            let reach = if i < 4 { rng.int(-1, 2).max(0) as f64 } else { 0.0 };
            let parts = [reach * scale, 0.0, 0.0].map(|x| beside(&mut rng, x).max(0.0));
            let parts = if i < 4 { parts } else { [0.0; 3] };
            let moved = [&a, &b].map(|core| core.map(|x| beside(&mut rng, x * scale)));
            let (before, after) = if i < 4 {
                let (square, denominator) = square_between(&corners(&a, whole), &corners(&b, whole));
                let before = square.cmp(&(whole(reach * reach) * denominator));
                let (square, denominator) =
                    square_between(&corners(&moved[0], wide), &corners(&moved[1], wide));
                let reach = parts.iter().fold(IBig::ZERO, |sum, x| sum + wide(*x));
                (before, square.cmp(&(&reach * &reach * denominator)))
            } else {
                (compare(&a, &b, whole), compare(&moved[0], &moved[1], wide))
            };
            let expected = tallies[usize::from(before.is_eq())].add(after);
            let [a, b] = [0, 1].map(|k| Shape { core: moved[k], radius: parts[k] });
            assert_eq!(is_within(&a, &b, parts[2]), Some(expected), "{a:?} {b:?} {:e}", parts[2]);
        }
        let [_, touching] = tallies;
        assert!(touching.apart.min(touching.near + touching.touching) > 2, "{i} {j}: {touching:?}");
    }
}

/// Half-spaces whose offset and normal are of other sizes than the polytope, up to one ulp.
#[test]
fn one_digit_of_a_half_space_decides() {
    let mut rng = Rng::new(81);
    for kind in 0..4 {
        let mut tally = Tally::default();
        for _ in 0..4000 {
            let mut draw = Draw { rng: &mut rng, most: 3 };
            let (core, normal, margin) = (draw.core(kind), draw.axis(), draw.rng.int(-1, 2).max(0) as f64);
            let scale = power_of_two(*rng.pick(&[-248, 0, 298]));
            let core = core.map(|x| beside(&mut rng, x * scale));
            let normal = normal.map(|x| beside(&mut rng, 0.5 * x));
            let offset = *rng.pick(&[0.0, MIN_COORDINATE, 2.0, scale, -scale, 1.5 * scale]);
            let margin = beside(&mut rng, margin * scale).max(0.0);
            let n = normal.map(wide);
            let least = corners(&core, wide).iter().map(|p| dot(&n, p)).min().unwrap();
            let height = least - (wide(offset) << 302);
            let order = if height < IBig::ZERO {
                core::cmp::Ordering::Less
            } else {
                (&height * &height).cmp(&(wide(margin) * wide(margin) * dot(&n, &n)))
            };
            let expected = tally.add(order);
            let [a, b] = [core, Core::HalfSpace { normal, offset }].map(|core| Shape { core, radius: 0.0 });
            assert_eq!(is_within(&a, &b, margin), Some(expected), "{a:?} {b:?} {margin:e}");
        }
        tally.check(5, &format!("{kind}"));
    }
}

/// Pairs at a whole distance, with the least change of it.
#[test]
fn the_last_digit_of_a_radius_decides() {
    let mut rng = Rng::new(78);
    for (i, j) in [(4, 0), (5, 0), (6, 0), (6, 1), (6, 2), (6, 3), (6, 4), (6, 5), (6, 6)] {
        let mut count = 0;
        while count < 100 {
            let most = rng.int(1, 5);
            let mut draw = Draw { rng: &mut rng, most };
            let (a, b, reach) = (draw.core(i), draw.core(j), draw.length());
            let scale = power_of_two(*rng.pick(&[-240, 0, 296]));
            let [a, b] = [a, b].map(|core| core.map(|x| x * scale));
            let reach = reach * scale;
            let verdict = |p: f64, q: f64, margin: f64| {
                let (a, b) = (Shape { core: a, radius: p }, Shape { core: b, radius: q });
                is_within(&a, &b, margin).unwrap()
            };
            if !verdict(0.0, 0.0, reach) || verdict(reach.next_down(), 0.0, 0.0) {
                continue;
            }
            count += 1;
            assert!(verdict(0.0, reach, 0.0) && verdict(0.5 * reach, 0.25 * reach, 0.25 * reach));
            assert!(!verdict(reach.next_down(), 0.0, if scale < 1.0 { 0.0 } else { MIN_COORDINATE }));
            assert!(verdict(reach.next_down(), reach, 0.0) && verdict(0.0, 0.0, f64::MAX));
        }
    }
}

/// A margin counts as at least the least coordinate.
#[test]
fn tiny_margins_count() {
    let at = |x: f64| Shape { core: Core::Point([x, 0.0, 0.0]), radius: 0.0 };
    let tiny = f64::MIN_POSITIVE;
    assert_eq!(is_within(&at(0.0), &at(MIN_COORDINATE), tiny), Some(true));
    assert_eq!(is_within(&at(0.0), &at(MIN_COORDINATE), 0.0), Some(false));
    assert_eq!(is_within(&at(0.0), &at(MIN_COORDINATE.next_up()), tiny), Some(false));
}

/// The longest and the shortest numbers fit in the integers.
#[test]
fn no_number_in_range_is_too_long() {
    let mut rng = Rng::new(79);
    let greatest = MAX_MOVED * (1.0 - 0.5 * f64::EPSILON);
    let least = MIN_COORDINATE * (1.0 + f64::EPSILON);
    for (i, j) in (0..7).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        for _ in 0..60 {
            let mut number = |_: f64| {
                let magnitude = *rng.pick(&[greatest, greatest, greatest, least]);
                if rng.below(2) == 0 { magnitude } else { -magnitude }
            };
            let mut draw = Draw { rng: &mut Rng::new(1), most: 3 };
            let mut draw = |kind: usize| {
                let core = draw.core(kind).map(&mut number);
                match core {
                    Core::HalfSpace { offset, .. } => {
                        let mut component = |_| if number(0.0) > 0.0 { 2.0 } else { least };
                        Core::HalfSpace { normal: [0; 3].map(&mut component), offset }
                    }
                    Core::Cylinder { centre, half_axis, radius } => {
                        Core::Cylinder { centre, half_axis, radius: radius.abs() }
                    }
                    Core::Cone { base, axis, radius } => Core::Cone { base, axis, radius: radius.abs() },
                    core => core,
                }
            };
            let [a, b] = [draw(i), draw(j)].map(|core| Shape { core, radius: 0.0 });
            let wide = |shape: Shape| Shape { radius: greatest, ..shape };
            let is_algebraic = (4..6).contains(&i) && j > 0;
            assert_eq!(is_within(&a, &b, 0.0).is_some(), !(is_algebraic && j > 3));
            assert_eq!(is_within(&wide(a), &wide(b), f64::MAX).is_some(), !is_algebraic);
            assert_eq!(is_within(&wide(a), &b, least).is_some(), !is_algebraic);
        }
    }
}

/// Without an axis there are no planes perpendicular to it.
#[test]
fn pairs_without_an_exact_test_have_no_verdict() {
    let mut rng = Rng::new(80);
    let mut draw = Draw { rng: &mut rng, most: 3 };
    for kind in 0..7 {
        let other = Shape { core: draw.core(kind), radius: 0.0 };
        for round in [4, 5] {
            let shape = Shape { core: draw.core(round), radius: 0.0 };
            let expected = kind == 0 || kind == 6;
            assert_eq!(is_within(&shape, &other, 1.0).is_some(), expected);
            assert_eq!(is_within(&shape, &other, 0.0).is_some(), !(4..6).contains(&kind));
            let flat = match shape.core {
                Core::Cylinder { centre, radius, .. } => {
                    Core::Cylinder { centre, half_axis: [0.0; 3], radius }
                }
                Core::Cone { base, radius, .. } => Core::Cone { base, axis: [0.0; 3], radius },
                core => core,
            };
            assert_eq!(is_within(&Shape { core: flat, radius: 0.0 }, &other, 0.0), None);
        }
    }
}
