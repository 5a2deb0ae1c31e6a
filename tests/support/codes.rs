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

/// The same for half floats: their infinity, NaN, greatest, least normal and least values, 1, -0, and the complements.
pub(crate) const SPECIAL_HALVES: [i16; 14] = [
    0x7c00, !0x7c00, 0x7c01, !0x7c01, 0x7e00, !0x7e00, 0x7bff, !0x7bff, 0x0400, !0x0400, 0x03ff, !0x03ff,
    0x3c00, !0x3c00,
];

/// Uses the constants once, so that tests that do not need them compile without a warning.
const _: () = {
    let _ = (SPECIAL, SPECIAL_HALVES);
};
