//! Random planes of nodes and queries, in several modes.

use crate::support::codes::{SPECIAL, SPECIAL_HALVES};
use crate::support::rng::Rng;
use crate::trees::Trees;
use simdop::low_level::key::{Fixed, Key, Storage};
use simdop::node::{Child, Node4, Node16};
use simdop::query::Lanes;
use std::cell::LazyCell;

/// Plane `j` of `W` bodies is row `j`.
pub(crate) type Planes<const W: usize, const K: usize> = [[i16; W]; K];

/// How a pair is generated. In all modes but the last, a compare separates with a probability of about 1 / K,
/// so that masks have bits of both values.
#[derive(Copy, Clone, Debug)]
pub(crate) enum Mode {
    /// Small integers: bodies touch often.
    Grid,
    /// Codes that are equal or next to each other.
    Near,
    /// All codes, with those that are not planes, and the mark of unused lanes.
    AnyBits,
    /// Planes of a tree, rotated into the other tree's frame at poses where the trees meet.
    Real,
}

/// Miri is too slow to build trees.
pub(crate) const MODES: &[Mode] = if cfg!(miri) {
    &[Mode::Grid, Mode::Near, Mode::AnyBits]
} else {
    &[Mode::Grid, Mode::Near, Mode::AnyBits, Mode::Real]
};

pub(crate) fn code<S: Storage>(rng: &mut Rng) -> i16 {
    if rng.below(4) != 0 {
        return rng.u64() as i16;
    }
    if S::IS_HALF && rng.below(2) == 0 { *rng.pick(&SPECIAL_HALVES) } else { *rng.pick(&SPECIAL) }
}

/// Planes below `middles` (side -1, for queries) or above them (side 1, for nodes), except one in 2 K.
fn planes<const W: usize, const K: usize, S: Storage>(
    rng: &mut Rng,
    mode: Mode,
    middles: &[i16; K],
    side: i64,
) -> Planes<W, K> {
    let grid = |x: i64| Key::<Fixed>::round_up_f64(x as f64).unwrap().code();
    let mut draw = |middle: i16| {
        let side = if rng.below(2 * K as u64) == 0 { -side } else { side };
        match mode {
            Mode::Grid => grid(if side < 0 { rng.int(-2, 1) } else { rng.int(1, 3) }),
            Mode::Near => middle.saturating_add((side * rng.int(0, 1)) as i16),
            Mode::AnyBits | Mode::Real => {
                let any = code::<S>(rng);
                if side < 0 { any.min(middle) } else { any.max(middle) }
            }
        }
    };
    core::array::from_fn(|j| core::array::from_fn(|_| draw(middles[j])))
}

fn middles<const K: usize, S: Storage>(rng: &mut Rng) -> [i16; K] {
    core::array::from_fn(|_| code::<S>(rng))
}

/// The planes of a query and of a node.
pub(crate) fn pair<const W: usize, const K: usize>(
    rng: &mut Rng,
    mode: Mode,
) -> (Planes<W, K>, Planes<W, K>) {
    let middles = middles::<K, Fixed>(rng);
    let mut planes = |side| planes::<W, K, Fixed>(rng, mode, &middles, side);
    (planes(-1), planes(1))
}

/// Planes of sixteen bodies, and of four.
type Both<const K: usize> = (Planes<16, K>, Planes<4, K>);

/// `n` queries and `n` nodes, for all n^2 pairs.
pub(crate) fn pool<const K: usize, S: Storage>(
    rng: &mut Rng,
    mode: Mode,
    trees: &LazyCell<Trees<K, S>, impl FnOnce() -> Trees<K, S>>,
    n: usize,
) -> (Vec<Both<K>>, Vec<Both<K>>)
where
    Node16<K, S>: Lanes,
    Node4<K, S>: Lanes,
{
    if let Mode::Real = mode {
        return (
            (0..n).map(|_| (trees.query_16(rng), trees.query_4(rng))).collect(),
            (0..n).map(|_| (trees.node_16(rng).planes, trees.node_4(rng).planes)).collect(),
        );
    }
    let (wide, narrow) = (middles::<K, S>(rng), middles::<K, S>(rng));
    let mut draw = |side| {
        let both =
            |_| (planes::<_, _, S>(rng, mode, &wide, side), planes::<_, _, S>(rng, mode, &narrow, side));
        (0..n).map(both).collect()
    };
    (draw(-1), draw(1))
}

/// Visits `count` pairs, each item of one list with each item of another; `draw` makes lists of a given length.
/// Generating an item for every pair would take an emulator a hundred times as long as the kernels.
pub(crate) fn each_pair<A, B>(
    count: u64,
    mut draw: impl FnMut(usize) -> (Vec<A>, Vec<B>),
    mut visit: impl FnMut(u64, &A, &B),
) {
    // Many lists, even for few pairs.
    let side = (count.isqrt() / 10).clamp(1, 64) as usize;
    let mut i = 0;
    while i < count {
        let (left, right) = draw(side);
        let pairs = left.iter().flat_map(|a| right.iter().map(move |b| (a, b)));
        for (a, b) in pairs.take((count - i) as usize) {
            visit(i, a, b);
            i += 1;
        }
    }
}

pub(crate) const fn wide<const K: usize>(planes: Planes<16, K>) -> Node16<K> {
    wide_as(planes)
}

pub(crate) const fn wide_as<const K: usize, S: Storage>(planes: Planes<16, K>) -> Node16<K, S> {
    Node16::new(planes, [Child::EMPTY; 16])
}

pub(crate) const fn narrow_as<const K: usize, S: Storage>(planes: Planes<4, K>) -> Node4<K, S> {
    Node4::new(planes, [Child::EMPTY; 4])
}

pub(crate) const fn narrow<const K: usize>(planes: Planes<4, K>) -> Node4<K> {
    narrow_as(planes)
}

/// Any number, often a special or a small one.
pub(crate) fn float(rng: &mut Rng) -> f32 {
    match rng.below(8) {
        0 => *rng.pick(&[
            0.0,
            -0.0,
            1.0,
            f32::MIN_POSITIVE,
            f32::from_bits(1),
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
        ]),
        1 => f32::from_bits(rng.u64() as u32),
        2 => rng.int(-4, 4) as f32,
        _ => rng.range(0.0, 2.0) as f32,
    }
}
