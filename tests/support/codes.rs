//! Codes of planes that kernels are most likely to get wrong.

/// The extreme codes of each kind: an unused lane, the complement of infinity, the lowest planes, codes near
/// zero, powers of two, the greatest planes, infinity, and the complement of an unused lane.
pub(crate) const SPECIAL: [i16; 20] = [
    i16::MIN,
    -32_767,
    -32_766,
    -32_765,
    -16_384,
    -1024,
    -3,
    -2,
    -1,
    0,
    1,
    2,
    255,
    256,
    1023,
    16_384,
    32_764,
    32_765,
    32_766,
    i16::MAX,
];

/// Uses the constant once, so that tests that do not need it compile without a warning.
const _: () = {
    let _ = SPECIAL;
};
