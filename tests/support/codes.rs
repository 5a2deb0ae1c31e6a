//! Codes of planes that kernels are most likely to get wrong.

/// Codes at the ends of their kinds: the lowest (an unused lane), NaN, -infinity and about, lowest finite,
/// about -1, about zero (-0 is -1, the largest negative subnormal -2), subnormal ends, 1, the largest finite,
/// infinity, NaN.
pub(crate) const SPECIAL: [i16; 20] = [
    i16::MIN,
    -0x7fff,
    -0x7c02,
    -0x7c01,
    -0x7c00,
    -0x3c01,
    -0x401,
    -0x400,
    -3,
    -2,
    -1,
    0,
    1,
    0x3ff,
    0x400,
    0x3c00,
    0x7bff,
    0x7c00,
    0x7c01,
    i16::MAX,
];

/// Names it once, so that a test which has no use for it compiles without a warning.
const _: () = {
    let _ = SPECIAL;
};
