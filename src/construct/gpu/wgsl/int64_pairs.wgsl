// 64-bit integers as two words, the low one first, with explicit carries, for adapters without SHADER_INT64. They have
// the bytes of u64.

alias U64 = vec2<u32>;

fn widened(a: u32) -> U64 {
    return vec2(a, 0u);
}

fn sum(a: U64, b: U64) -> U64 {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + u32(low < a.x));
}

fn difference(a: U64, b: U64) -> U64 {
    return vec2(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

/// For b < 2^16.
fn product(a: u32, b: u32) -> U64 {
    let low = (a & 0xffffu) * b;
    let high = (a >> 16u) * b;
    return sum(vec2(low, 0u), vec2(high << 16u, high >> 16u));
}

fn half(a: U64) -> U64 {
    return vec2(a.x >> 1u | a.y << 31u, a.y >> 1u);
}

/// For 0 < bits < 32.
fn shifted(a: U64, bits: u32) -> U64 {
    return vec2(a.x << bits, a.y << bits | a.x >> (32u - bits));
}

fn is_less(a: U64, b: U64) -> bool {
    return a.y < b.y || a.y == b.y && a.x < b.x;
}

fn is_zero(a: U64) -> bool {
    return (a.x | a.y) == 0u;
}
