//! Rounding up to a key, compared with its definition: in the library's scalar code, and in the realignment of every
//! instruction set, whose planes equal the offsets, rounded to the nearest key, when all weights are zero.
#![no_main]

#[path = "../../tests/support/mod.rs"]
mod support;

use libfuzzer_sys::fuzz_target;
use simdop::low_level::key::{Key, NotANumber, decode};
use simdop::low_level::realign::Realignment;
use simdop::node::Node16;
use simdop_fuzz::planes::{code, turned_16, wide};
use simdop_fuzz::{Input, Mode, on_every_isa};
use support::dyadic::key_value;

fuzz_target!(|data: &[u8]| {
    let mut input = Input::new(data);
    let mode = input.mode();
    let (x, y) = (number(&mut input, mode), number(&mut input, mode));
    rounds_up(x);
    // Rounding is monotone.
    if let (Ok(p), Ok(q)) = (Key::round_up_f64(x), Key::round_up_f64(y)) {
        assert!(p.cmp(&q) == x.total_cmp(&y) || p == q, "{x:e} {p:?}, {y:e} {q:?}");
    }
    for _ in 0..4 {
        any_code(code(&mut input));
    }
    let offsets = core::array::from_fn(|_| number(&mut input, mode) as f32);
    every_isa_rounds_up(&offsets);
});

/// A number of any size, or one near a bound of a key or near the midpoint of two.
fn number(input: &mut Input, mode: Mode) -> f64 {
    match mode {
        Mode::Grid => f64::from(input.int(-128, 127)) / 16.0,
        Mode::AnyBits if input.one_in(2) => f64::from_bits(input.u64()),
        Mode::AnyBits => f32::from_bits(input.u32()).into(),
        Mode::Real => {
            let code = code(input);
            let bound = key_value(code);
            let base = if input.one_in(2) { bound } else { bound + 0.5 };
            let step = base.abs() * f64::EPSILON * if input.one_in(2) { 1.0 } else { 536_870_912.0 };
            base + step * f64::from(input.int(-2, 2))
        }
    }
}

/// Whether the key is the lowest that is not below the number.
fn is_rounded_up(code: i16, x: f64) -> bool {
    let lowest = code == Key::LOWEST.code() && x <= key_value(code);
    let least_infinite = code == Key::INFINITY.code() && x > key_value(Key::GREATEST.code());
    lowest || least_infinite || key_value(code) >= x && key_value(code - 1) < x
}

fn rounds_up(x: f64) {
    let single = x as f32;
    match Key::round_up_f64(x) {
        Ok(key) => assert!(is_rounded_up(key.code(), x), "{x:e} {key:?}"),
        Err(NotANumber) => assert!(x.is_nan()),
    }
    match Key::round_up_f32(single) {
        Ok(key) => assert!(is_rounded_up(key.code(), single.into()), "{single:e} {key:?}"),
        Err(NotANumber) => assert!(single.is_nan()),
    }
    let unbounded = Key::round_up_or_unbounded(x);
    assert_eq!(unbounded, Key::round_up_f64(x).unwrap_or(Key::INFINITY));
}

fn any_code(code: i16) {
    let value = key_value(code);
    assert_eq!(Key::from_code(code).is_some(), value.is_finite(), "{code}");
    if let Some(key) = Key::from_code(code) {
        assert!(f64::from(decode(code)) == value && f64::from(decode(!code)) == -value, "{code}");
        assert_eq!(Key::round_up_f64(value), Ok(key));
    }
}

fn every_isa_rounds_up(offsets: &[f32; 6]) {
    let map = Realignment::<6> { sources: [[0; 4]; 6], weights: [[0.0; 6]; 3], offset: *offsets };
    let node: Node16<6> = wide([[0; 16]; 6]);
    on_every_isa!(kernel => {
        let query = turned_16(kernel, &map, &node);
        for (j, x) in offsets.iter().enumerate() {
            let code = !query[j ^ 1][3];
            // One step higher if the number is itself a bound and the key of the bound below is odd.
            let x64 = f64::from(*x);
            let is_even_above = code % 2 == 0 && key_value(code - 1) == x64;
            let right = if x.is_nan() {
                code == Key::INFINITY.code()
            } else {
                is_even_above || is_rounded_up(code, x64)
            };
            assert!(right, "{kernel:?} {x:e}: {code:x}");
        }
    });
}
