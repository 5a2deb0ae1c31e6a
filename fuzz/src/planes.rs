//! Planes of queries and nodes that separate some of the lanes, in any mode: kernels that return only empty masks would
//! agree trivially.

use crate::bodies::{bodies, pose};
use crate::{Input, Mode, cached};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Turned;
use simdop::low_level::key::{Fixed, Key, Storage};
use simdop::low_level::realign::Realignment;
use simdop::node::{Child, Node4, Node16};
use simdop::query::Lanes;

pub use crate::turned::{turned_4, turned_16};

use crate::support::codes::SPECIAL;

/// Planes of `W` bodies, plane by plane.
pub type Planes<const W: usize, const K: usize> = [[i16; W]; K];

/// Extreme codes of half floats: infinity, the greatest number, the least normal one and the greatest below it, and the
/// negations of all; then -0, the number below it, and one.
const SPECIAL_HALVES: [i16; 11] =
    [0x7c00, 0x7bff, 0x400, 0x3ff, !0x7c00, !0x7bff, !0x400, !0x3ff, -1, -2, 0x3c00];

/// Any key; half of the time one of [`SPECIAL`] or [`SPECIAL_HALVES`].
pub fn code(input: &mut Input) -> i16 {
    match input.u8() {
        choice @ 192.. => SPECIAL_HALVES[usize::from(choice) % SPECIAL_HALVES.len()],
        choice @ 128.. => SPECIAL[usize::from(choice) % SPECIAL.len()],
        _ => input.u16() as i16,
    }
}

/// Any number; a small integer with [`Mode::Grid`].
pub fn float(input: &mut Input, mode: Mode) -> f32 {
    match (mode, input.u8()) {
        (Mode::Grid, choice) => f32::from(choice as i8 >> 4),
        (_, choice @ 0..8) => {
            [0.0, -0.0, 1.0, f32::MIN_POSITIVE, 1e-45, f32::MAX, f32::INFINITY, f32::NAN][usize::from(choice)]
        }
        (_, 8..32) => f32::from_bits(input.u32()),
        _ => f32::from(input.u16() as i16) / 8192.0,
    }
}

/// The key of a small integer.
fn grid_code<S: Storage>(value: i32) -> i16 {
    Key::<S>::round_up_f64(value.into()).unwrap().code()
}

/// A query, and planes of which each separates about one body in sixty-four from it.
pub fn pair<const W: usize, const K: usize, S: Storage>(
    input: &mut Input,
    mode: Mode,
) -> (Planes<W, K>, Planes<W, K>) {
    let (mut query, mut planes) = ([[0; W]; K], [[0; W]; K]);
    for j in 0..K {
        let middle = if mode == Mode::Grid { grid_code::<S>(input.int(-3, 3)) } else { code(input) };
        let mut draw = |query: bool| {
            let choice = input.u8();
            let below = query != (choice.is_multiple_of(64));
            match (choice >> 6, mode) {
                (0, Mode::AnyBits) if below => code(input).min(middle),
                (0, Mode::AnyBits) => code(input).max(middle),
                (1.., _) if choice.is_multiple_of(2) => middle,
                _ => middle.saturating_add(if below { -1 } else { 1 }),
            }
        };
        query[j] = core::array::from_fn(|_| draw(true));
        planes[j] = core::array::from_fn(|_| draw(false));
    }
    (query, with_unused_lanes(planes, input))
}

/// Marks some lanes as unused, half of the time.
pub fn with_unused_lanes<const W: usize, const K: usize>(
    mut planes: Planes<W, K>,
    input: &mut Input,
) -> Planes<W, K> {
    if input.one_in(2) {
        let unused = input.u16();
        for plane in &mut planes {
            for (lane, code) in plane.iter_mut().enumerate().filter(|(lane, _)| unused >> lane & 1 != 0) {
                debug_assert!(lane < W);
                *code = Key::<Fixed>::EMPTY.code();
            }
        }
    }
    planes
}

pub const fn wide<const K: usize, S: Storage>(planes: Planes<16, K>) -> Node16<K, S> {
    Node16::new(planes, [Child::EMPTY; 16])
}

pub const fn narrow<const K: usize, S: Storage>(planes: Planes<4, K>) -> Node4<K, S> {
    Node4::new(planes, [Child::EMPTY; 4])
}

/// Nodes of real trees, and some of them realigned by the scalar kernel at poses where the trees meet.
struct Recorded<Q, N> {
    queries: Vec<Q>,
    nodes: Vec<N>,
}

impl<Q: Copy, N: Lanes> Recorded<Q, N> {
    fn new(turn: impl Fn(&N::Map, &N) -> Q) -> Self {
        let mut input = Input::new(&[]);
        let trees: Vec<_> =
            bodies::<N>().0.iter().map(|body| body.tree.view()).filter(|tree| !tree.is_empty()).collect();
        let queries = (0..512).map(|_| {
            let (a, b) = (input.pick(&trees), input.pick(&trees).frame());
            let mut map = N::UNMAPPED;
            N::map(&mut map, &pose(&mut input, Mode::Real), &a.extent(), &b);
            turn(&map, input.pick(a.nodes()))
        });
        Self {
            queries: queries.collect(),
            nodes: trees.iter().flat_map(|tree| tree.nodes()).copied().collect(),
        }
    }

    fn pick(&self, input: &mut Input) -> (Q, N) {
        (*input.pick(&self.queries), *input.pick(&self.nodes))
    }
}

/// A query and a node of real trees.
pub fn real_16<const K: usize, S: Storage>(input: &mut Input) -> (Turned<16, K>, Node16<K, S>)
where
    Node16<K, S>: Lanes<Map = Realignment<K, S>>,
{
    cached(|| Recorded::<_, Node16<K, S>>::new(|map, node| turned_16(Scalar::new(), map, node))).pick(input)
}

/// [`real_16`] for four children.
pub fn real_4<const K: usize, S: Storage>(input: &mut Input) -> (Turned<4, K>, Node4<K, S>)
where
    Node4<K, S>: Lanes<Map = Realignment<K, S>>,
{
    cached(|| Recorded::<_, Node4<K, S>>::new(|map, node| turned_4(Scalar::new(), map, node))).pick(input)
}
