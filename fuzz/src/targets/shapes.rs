//! Whether two shapes at a pose meet or are within a margin, in both orders, and the bounds of their distance.

use crate::Input;
use crate::bodies::pose;
use crate::shapes::{check_bounds, check_decision, has_lost_its_axis, margin, shape};
use simdop::primitive::shape::{is_within, meets, separation};

/// One run.
pub fn run(data: &[u8]) {
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
}
