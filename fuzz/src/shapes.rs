//! Shapes from the fuzzer's bytes, and the oracle of their distance.

use crate::shape_oracle::{Judgement, distance_interval, is_rational, meets, meets_finely};
use crate::{Input, Mode};
use simdop::primitive::shape::{Core, Shape, ShapeError};

/// A shape of any kind. Invalid numbers are rejected: a point is returned then.
pub fn shape(input: &mut Input, mode: Mode) -> Shape {
    let core = core(input, mode);
    let radius = if input.one_in(2) { 0.0 } else { number(input, mode).abs() };
    match Shape::new(core, radius) {
        Ok(shape) => shape,
        Err(error) => {
            assert!(mode == Mode::AnyBits || is_degenerate(&error), "{core:?} {radius:e}: {error}");
            Shape::default()
        }
    }
}

/// Small integers may be zero, and may give an axis without direction.
fn is_degenerate(error: &ShapeError) -> bool {
    matches!(error, ShapeError::Length { given: 0.0 } | ShapeError::NoDirection)
}

fn core(input: &mut Input, mode: Mode) -> Core {
    let kind = input.below(7);
    let mut point = || [(); 3].map(|()| number(input, mode));
    match kind {
        0 => Core::Point(point()),
        1 => Core::Segment([point(), point()]),
        2 => Core::Triangle([point(), point(), point()]),
        3 => {
            let (centre, [x, y, z]) = (point(), point());
            Core::Cuboid { centre, half: [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]] }
        }
        4 => Core::Cylinder { centre: point(), half_axis: point(), radius: point()[0].abs() },
        5 => Core::Cone { base: point(), axis: point(), radius: point()[0].abs() },
        _ => {
            let ([offset, ..], normal) = (point(), point());
            Shape::half_space(normal, offset).map_or(Core::Point([0.0; 3]), |shape| *shape.core())
        }
    }
}

/// Whether a pose has set a tiny axis to zero: then the shape has no direction, and the oracle does not judge it.
pub fn has_lost_its_axis(shape: &Shape) -> bool {
    let (Core::Cylinder { half_axis: axis, .. } | Core::Cone { axis, .. }) = shape.core() else {
        return false;
    };
    *axis == [0.0; 3]
}

/// A coordinate: an integer, any bits, or 16 bits in -2 .. 2.
fn number(input: &mut Input, mode: Mode) -> f64 {
    match mode {
        Mode::Grid => input.int(-4, 4).into(),
        Mode::AnyBits if input.one_in(4) => f64::from_bits(input.u64()),
        Mode::AnyBits => f64::from(input.int(-4, 4)) * 2_f64.powi(8 * input.int(-24, 30)),
        Mode::Real => f64::from(input.u16() as i16) / 16384.0,
    }
}

/// A margin: none, an integer, the distance up to rounding, or a share of it.
pub fn margin(input: &mut Input, a: &Shape, b: &Shape) -> f64 {
    let distance = distance_interval(a, b).to_f64().0;
    let margin = match input.below(8) {
        0 => f64::from(input.int(1, 6)),
        1 => distance,
        2 => distance.next_up(),
        3 => distance.next_down(),
        4 => distance * f64::from(input.u8()) / 128.0,
        _ => 0.0,
    };
    let range = simdop::range::MIN_COORDINATE..=simdop::range::MAX_COORDINATE;
    if range.contains(&margin) { margin } else { 0.0 }
}

/// Checks whether two shapes are within a margin: exactly where rational numbers decide; otherwise free must be
/// certain, and hits may be 2^-40 of the size apart.
pub fn check_decision(a: &Shape, b: &Shape, margin: f64, is_within: bool) {
    match meets(a, b, margin) {
        Judgement::Meets => assert!(is_within, "a miss: {a:?} {b:?} {margin:e}"),
        Judgement::TooCloseToCall => {
            let is_right = is_within || meets_finely(a, b, margin) == Judgement::Apart;
            assert!(is_right, "a miss: {a:?} {b:?} {margin:e}");
        }
        Judgement::Apart if !is_within => {}
        Judgement::Apart => {
            assert!(!is_rational(a, b, margin), "a false hit: {a:?} {b:?} {margin:e}");
            let found = distance_interval(a, b);
            let excess = found.to_f64().0 - margin;
            let resolved = 2_f64.powi(-40) * found.size().max(margin);
            assert!(excess <= resolved, "a false hit: {a:?} {b:?} {margin:e}");
        }
    }
}

/// Checks that bounds enclose the distance.
pub fn check_bounds(a: &Shape, b: &Shape, limit: f64, bounds: Option<(f64, f64)>) {
    let found = distance_interval(a, b);
    let (least, most) = found.to_f64();
    match bounds {
        None => assert!(most > limit, "a miss: {a:?} {b:?} {limit:e}"),
        Some((lower, upper)) => {
            // Pairs that are not certainly apart count as meeting.
            let is_unresolved = upper == 0.0 && !is_rational(a, b, 0.0);
            let slack = if is_unresolved { 2_f64.powi(-40) * found.size() } else { 0.0 };
            assert!(
                lower <= most && least <= upper + slack && lower <= upper,
                "{lower:e} {upper:e} {a:?} {b:?}"
            );
        }
    }
}
