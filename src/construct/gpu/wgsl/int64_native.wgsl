// 64-bit integers of the adapter (SHADER_INT64). Same names as in int64_pairs.wgsl.

alias U64 = u64;

fn widened(a: u32) -> U64 {
    return u64(a);
}

fn sum(a: U64, b: U64) -> U64 {
    return a + b;
}

fn difference(a: U64, b: U64) -> U64 {
    return a - b;
}

/// For b < 2^16.
fn product(a: u32, b: u32) -> U64 {
    return u64(a) * u64(b);
}

fn half(a: U64) -> U64 {
    return a >> 1u;
}

/// For 0 < bits < 32.
fn shifted(a: U64, bits: u32) -> U64 {
    return a << bits;
}

fn is_less(a: U64, b: U64) -> bool {
    return a < b;
}

fn is_zero(a: U64) -> bool {
    return a == U64(0);
}
