//! Whether two shapes at a pose meet or are within a margin, in both orders, and the bounds of their distance.
#![no_main]

use libfuzzer_sys::fuzz_target;
use simdop::primitive::shape::{is_within, meets, separation};
use simdop_fuzz::Input;
use simdop_fuzz::bodies::pose;
use simdop_fuzz::shapes::{check_bounds, check_decision, has_lost_its_axis, margin, shape};

fuzz_target!(|data: &[u8]| {
    let mut input = Input::new(data);
    let mode = input.mode();
    let (a, b) = (shape(&mut input, mode), shape(&mut input, mode));
    let a = a.moved(&pose(&mut input, mode));
    if has_lost_its_axis(&a) {
        return;
    }
    let margin = margin(&mut input, &a, &b);
    for (a, b) in [(&a, &b), (&b, &a)] {
        check_decision(a, b, margin, is_within(a, b, margin));
        check_decision(a, b, 0.0, meets(a, b));
        let found = separation(a, b, margin, 1e-9);
        check_bounds(a, b, margin, found.map(|found| (found.lower, found.upper)));
    }
});
