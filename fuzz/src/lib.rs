//! Shared by the fuzz targets: the fuzzer's bytes interpreted as numbers, planes and bodies made from them, and every
//! available instruction set.
//!
//! ```text
//! cargo +nightly fuzz run TARGET fuzz/corpus/TARGET fuzz/seeds/TARGET -- -max_len=4096
//! cargo run --manifest-path fuzz/Cargo.toml --example seeds     (writes fuzz/seeds again)
//! ```
//!
//! With `-O --sanitizer none --no-trace-compares` fuzzing is ten times as fast, but does not check for overflow.
//!
//!  target | checks | oracle |
//! ---|---|---|
//!  `kernel_1v16`, `kernel_4v4` | masks of every instruction set | scalar kernel |
//!  `realign` | realigned planes of every instruction set; they bound the moved triangles | scalar kernel; exact |
//!  `primitive_slab` | children that a slab separates, and that they are apart | scalar kernel; exact |
//!  `keys` | rounding up, by the keys and by every instruction set | definition of a key; the crate `half` |
//!  `from_bytes` | bytes rejected with the right error, or safe to traverse and query | second reader; brute force |
//!  `balls` | overlap of balls, and bounds on shared volumes | scalar kernel; lenses in `f64` |
//!  `sphere_bytes` | as `from_bytes`, for trees of spheres; penetration volumes | second reader; brute force |
//!  `points` | which points and boxes are near, and their distances | scalar kernel |
//!  `cloud_bytes` | as `from_bytes`, for clouds; changes of clouds, and all searches | second reader; loop |
//!  `traverse` | verdicts, pairs, budgets, distances; query statistics | brute force; scalar kernel |
//!  `distance` | distances, margins, cutoffs, bounds within a budget, reported pairs | exact distances; scalar kernel |
//!  `shapes` | decisions and bounds for two shapes; exact where rational numbers decide | integers |
//!
//! The sizes of bodies in `traverse` differ by up to 1e12 : 1, at up to 1e9 diagonals from the origin.
//!
//! The first byte of an input selects the [`Mode`], the second k, and it or the third the storage of planes; the
//! rest is values. `from_bytes`, `sphere_bytes` and
//! `cloud_bytes` also accept baked bytes as they are.

pub mod baked;
pub mod bodies;
pub mod clouds;
pub mod planes;
pub mod shapes;
pub mod spheres;
pub mod targets;
pub mod values;

#[path = "../../tests/support/lens.rs"]
mod lens;
#[path = "../../tests/support/shape_oracle/mod.rs"]
mod shape_oracle;
#[path = "../../tests/support/mod.rs"]
mod support;
#[path = "../../tests/support/turned.rs"]
mod turned;

pub use simdop::low_level::key::{Fixed, Half};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{LazyLock, Mutex};
use support::digest::digest;
use support::rng::Rng;

/// How an input is interpreted.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Mode {
    /// Small integers: bodies touch often.
    Grid,
    /// Arbitrary bits: NaN, infinities, -0, subnormal numbers, the mark of unused lanes.
    AnyBits,
    /// Trees of the library's builder, at poses where they meet.
    Real,
}

/// The fuzzer's bytes as numbers. After their end come pseudo-random numbers seeded by the bytes, so that a short input
/// fills a node.
pub struct Input<'a> {
    bytes: &'a [u8],
    after: Rng,
}

impl<'a> Input<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, after: Rng::new(digest(bytes)) }
    }

    /// The next `N` bytes, at most 8.
    fn next<const N: usize>(&mut self) -> [u8; N] {
        if let Some((next, rest)) = self.bytes.split_first_chunk() {
            self.bytes = rest;
            return *next;
        }
        self.bytes = &[];
        let random = self.after.u64().to_le_bytes();
        core::array::from_fn(|i| random[i])
    }

    pub fn u8(&mut self) -> u8 {
        u8::from_le_bytes(self.next())
    }

    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.next())
    }

    pub fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.next())
    }

    pub fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.next())
    }

    /// A number below `n`, which is 1 to 256.
    pub fn below(&mut self, n: usize) -> usize {
        usize::from(self.u8()) % n
    }

    /// True once in `n` times, 1 to 256.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// An integer in `low..=high`, at most 256 of them.
    pub fn int(&mut self, low: i32, high: i32) -> i32 {
        low + self.below((high - low + 1) as usize) as i32
    }

    /// One of up to 65,536 items.
    pub fn pick<'t, T>(&mut self, items: &'t [T]) -> &'t T {
        &items[usize::from(self.u16()) % items.len()]
    }

    pub fn mode(&mut self) -> Mode {
        [Mode::Grid, Mode::AnyBits, Mode::Real][self.below(3)]
    }
}

/// A node type.
#[derive(Copy, Clone, Debug)]
pub struct NodeChoice {
    pub k: u8,
    /// Four children instead of sixteen.
    pub four: bool,
    /// Half floats instead of fixed point.
    pub half: bool,
}

impl NodeChoice {
    pub fn new(input: &mut Input) -> Self {
        let k = [6, 14, 18, 26, 32][input.below(5)];
        let form = input.below(4);
        Self { k, four: form % 2 == 0, half: form >= 2 }
    }
}

/// A value that is created once for each type, and cached.
pub fn cached<T: Send + Sync>(make: impl FnOnce() -> T) -> &'static T {
    static ALL: LazyLock<Mutex<HashMap<TypeId, &'static (dyn Any + Send + Sync)>>> =
        LazyLock::new(Mutex::default);
    let found = ALL.lock().unwrap().get(&TypeId::of::<T>()).copied();
    // Created outside the lock: its creation may need other cached values.
    let value = found.unwrap_or_else(|| {
        let made: &'static T = Box::leak(Box::new(make()));
        ALL.lock().unwrap().insert(TypeId::of::<T>(), made);
        made
    });
    value.downcast_ref().unwrap()
}

/// Calls a generic function for one k and storage, chosen by a number.
#[macro_export]
macro_rules! for_k {
    ($choice:expr, $function:ident($($argument:expr),*)) => {
        match $choice % 10 {
            0 => $function::<6, $crate::Fixed>($($argument),*),
            1 => $function::<14, $crate::Fixed>($($argument),*),
            2 => $function::<18, $crate::Fixed>($($argument),*),
            3 => $function::<26, $crate::Fixed>($($argument),*),
            4 => $function::<32, $crate::Fixed>($($argument),*),
            5 => $function::<6, $crate::Half>($($argument),*),
            6 => $function::<14, $crate::Half>($($argument),*),
            7 => $function::<18, $crate::Half>($($argument),*),
            8 => $function::<26, $crate::Half>($($argument),*),
            _ => $function::<32, $crate::Half>($($argument),*),
        }
    };
}

/// Calls a generic function for a node type. Few types have half floats, so that the targets are compiled in time.
/// Without the feature `all-nodes` it is one of three, as in tests/queries: compiling the queries of a node type takes
/// longer than a short run.
#[cfg(not(feature = "all-nodes"))]
#[macro_export]
macro_rules! for_node {
    ($choice:expr, $function:ident($($argument:expr),*)) => {{
        use simdop::node::{Node4, Node16};
        let $crate::NodeChoice { four, half, .. } = $choice;
        match (half, four) {
            (true, _) => $function::<Node16<26, $crate::Half>>($($argument),*),
            (_, true) => $function::<Node4<14>>($($argument),*),
            _ => $function::<Node16<18>>($($argument),*),
        }
    }};
}

/// Calls a generic function for a node type. Few types have half floats, so that the targets are compiled in time.
#[cfg(feature = "all-nodes")]
#[macro_export]
macro_rules! for_node {
    ($choice:expr, $function:ident($($argument:expr),*)) => {{
        use simdop::node::{Node4, Node16};
        let $crate::NodeChoice { k, four, half } = $choice;
        if half {
            match (k, four) {
                (_, true) => return $function::<Node4<18, $crate::Half>>($($argument),*),
                (6 | 14, false) => return $function::<Node16<14, $crate::Half>>($($argument),*),
                (18, false) => return $function::<Node16<18, $crate::Half>>($($argument),*),
                (_, false) => return $function::<Node16<26, $crate::Half>>($($argument),*),
            }
        }
        match (k, four) {
            (6, true) => $function::<Node4<6>>($($argument),*),
            (14, true) => $function::<Node4<14>>($($argument),*),
            (18, true) => $function::<Node4<18>>($($argument),*),
            (26, true) => $function::<Node4<26>>($($argument),*),
            (_, true) => $function::<Node4<32>>($($argument),*),
            (6, false) => $function::<Node16<6>>($($argument),*),
            (14, false) => $function::<Node16<14>>($($argument),*),
            (18, false) => $function::<Node16<18>>($($argument),*),
            (26, false) => $function::<Node16<26>>($($argument),*),
            (_, false) => $function::<Node16<32>>($($argument),*),
        }
    }};
}

/// Evaluates an expression with the kernel of every available instruction set except the scalar one.
#[macro_export]
macro_rules! on_every_isa {
    ($kernel:ident => $body:expr) => {
        for isa in simdop::isa::Isa::available().filter(|isa| *isa != simdop::isa::Isa::SCALAR) {
            simdop::isa::on_isa!(isa, $kernel => $body);
        }
    };
}
