//! Rounding up to a key, compared with its definition and with the crate `half`: in the library's scalar code, and in
//! the realignment of every instruction set, whose planes equal the rounded offsets when all weights are zero.

use crate::planes::{code, turned_16, wide};
use crate::values::{half_of, is_around, is_plane, is_rounded_up, value};
use crate::{Fixed, Half, Input, Mode, on_every_isa};
use simdop::low_level::key::{Key, NotANumber, Storage};
use simdop::low_level::realign::Realignment;
use simdop::node::Node16;

/// One run.
pub fn run(data: &[u8]) {
    check::<Fixed>(&mut Input::new(data));
    check::<Half>(&mut Input::new(data));
}

fn check<S: Storage>(input: &mut Input) {
    let mode = input.mode();
    let (x, y) = (number::<S>(input, mode), number::<S>(input, mode));
    rounds_up::<S>(x);
    // Rounding is monotone.
    if let (Ok(p), Ok(q)) = (Key::<S>::round_up_f64(x), Key::<S>::round_up_f64(y)) {
        assert!(p.cmp(&q) == x.total_cmp(&y) || p == q, "{x:e} {p:?}, {y:e} {q:?}");
    }
    for _ in 0..4 {
        any_code::<S>(code(input));
    }
    let offsets = core::array::from_fn(|_| number::<S>(input, mode) as f32);
    every_isa_rounds_up::<S>(&offsets);
}

/// A number of any size, or one near a bound of a key or near the midpoint of two.
fn number<S: Storage>(input: &mut Input, mode: Mode) -> f64 {
    match mode {
        Mode::Grid => f64::from(input.int(-128, 127)) / 16.0,
        Mode::AnyBits if input.one_in(2) => f64::from_bits(input.u64()),
        Mode::AnyBits => f32::from_bits(input.u32()).into(),
        Mode::Real => {
            let code = code(input);
            let bound = value::<S>(code);
            let next = value::<S>(code.saturating_add(1));
            let base = if input.one_in(2) { bound } else { 0.5 * (bound + next) };
            let step = base.abs() * f64::EPSILON * if input.one_in(2) { 1.0 } else { 536_870_912.0 };
            base + step * f64::from(input.int(-2, 2))
        }
    }
}

fn rounds_up<S: Storage>(x: f64) {
    let single = x as f32;
    match Key::<S>::round_up_f64(x) {
        Ok(key) => assert!(is_rounded_up::<S>(key.code(), x), "{x:e} {key:?}"),
        Err(NotANumber) => assert!(x.is_nan()),
    }
    match Key::<S>::round_up_f32(single) {
        Ok(key) => assert!(is_rounded_up::<S>(key.code(), single.into()), "{single:e} {key:?}"),
        Err(NotANumber) => assert!(single.is_nan()),
    }
    let unbounded = Key::<S>::round_up_or_unbounded(x);
    assert_eq!(unbounded, Key::round_up_f64(x).unwrap_or(Key::INFINITY));
    assert_eq!(unbounded.code(), S::round_up(x));
    let around = S::around(single);
    assert!(is_around::<S>(around, single), "{single:e}: {around:x}");
}

fn any_code<S: Storage>(code: i16) {
    let exact = value::<S>(code);
    assert_eq!(Key::<S>::from_code(code).is_some(), is_plane::<S>(code), "{code}");
    if S::IS_HALF {
        let (number, half) = (S::number(code), half_of(code).to_f32());
        assert!(number.to_bits() == half.to_bits() || number.is_nan() && half.is_nan(), "{code}");
    }
    if let Some(key) = Key::<S>::from_code(code) {
        assert!(f64::from(S::value(code)) == exact && f64::from(S::value(!code)) == -exact, "{code}");
        assert_eq!(Key::round_up_f64(exact), Ok(key));
    }
}

fn every_isa_rounds_up<S: Storage>(offsets: &[f32; 6]) {
    let map = Realignment::<6, S>::from_parts([[0; 4]; 6], [[0.0; 6]; 3], *offsets);
    let node: Node16<6, S> = wide([[0; 16]; 6]);
    on_every_isa!(kernel => {
        let query = turned_16(kernel, &map, &node);
        for (j, x) in offsets.iter().enumerate() {
            let code = !query[j ^ 1][3];
            assert!(is_around::<S>(code, *x), "{kernel:?} {x:e}: {code:x}");
        }
    });
}
