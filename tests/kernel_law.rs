//! The law of the kernels (`simdop::kernel`): every instruction set gives the scalar kernel's bits, for every
//! input.
//!
//! One macro makes the same named tests for each name in `Isa::NAMES`. An instruction set that this machine
//! has not got is reported as `NOT RUN`, and is a failure where `SIMDOP_REQUIRE_ISA` (names, with commas)
//! asks for it. `SIMDOP_PAIRS` sets the number of pairs of nodes per k. At [`RECORDED_PAIRS`] the oracle is
//! the scalar kernel's recorded digest, which spares an emulator the scalar kernel.

#[path = "kernel_law/points.rs"]
mod points;
mod support;
#[path = "support/turned.rs"]
#[expect(unreachable_pub, reason = "public to the fuzz targets, which take it from a library")]
mod turned;

use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::{Isa, IsaError, Scalar, on_isa};
use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::{Key, decode};
use simdop::low_level::realign::{PrimitiveSlab, Realignment, primitive_slabs};
use simdop::node::{Ball16, Child, Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::Triangles;
use simdop::primitive::triangle::Probe;
use simdop::query::Lanes;
use std::cell::LazyCell;
use support::codes::SPECIAL;
use support::data::notice;
use support::rng::Rng;
use turned::{turned_4, turned_16};

// ---- Which instruction set --------------------------------------------------------------------------------

/// The instruction set, if it is here. If not, a notice says so.
fn available(name: &str) -> Option<Isa> {
    match name.parse() {
        Ok(isa) => Some(isa),
        Err(IsaError::Unknown) => panic!("{name} is no instruction set"),
        Err(IsaError::NotAvailable) => {
            let required = std::env::var("SIMDOP_REQUIRE_ISA").unwrap_or_default();
            assert!(!required.split(',').any(|r| r == name), "SIMDOP_REQUIRE_ISA: there is no {name} here");
            notice(&format!("NOT RUN: there is no {name} here"));
            None
        }
    }
}

/// The tests of one instruction set; each runs `law::<K>(kernel, name)` for every k.
macro_rules! laws {
    ($($isa:ident)*) => {
        #[test]
        fn no_instruction_set_is_left_out() {
            assert_eq!([$(stringify!($isa)),*], Isa::NAMES);
        }
        $( mod $isa {
            use super::*;
            laws!(@each $isa:
                overlaps_equal_the_scalar_kernel
                realignments_equal_the_scalar_kernel
                own_slabs_equal_the_scalar_kernel
                any_one_plane_separates
                any_one_lane_overlaps
                roles_swapped_and_bodies_mirrored
                lanes_permuted
            );

            #[test]
            fn balls_equal_the_scalar_kernel() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => super::balls_equal_the_scalar_kernel(kernel, stringify!($isa)));
                }
            }

            #[test]
            fn points_equal_the_scalar_kernel() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => points::points_equal_the_scalar_kernel(kernel, stringify!($isa)));
                }
            }

            #[test]
            fn picks_are_the_slots_of_the_mask() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => points::picks_are_the_slots_of_the_mask(kernel, stringify!($isa)));
                }
            }

            /// Every compare of a plane, of 2^32: minutes in an emulator.
            #[test]
            #[ignore = "exhaustive: cargo test --release --test kernel_law -- --ignored"]
            fn all_key_pairs() {
                if let Some(isa) = available(stringify!($isa)) {
                    on_isa!(isa, kernel => super::all_key_pairs(kernel));
                }
            }
        } )*
    };
    (@each $isa:ident: $($law:ident)*) => { $(
        #[test]
        fn $law() {
            if let Some(isa) = available(stringify!($isa)) {
                on_isa!(isa, kernel => {
                    super::$law::<6>(kernel, stringify!($isa));
                    super::$law::<14>(kernel, stringify!($isa));
                    super::$law::<18>(kernel, stringify!($isa));
                    super::$law::<26>(kernel, stringify!($isa));
                    super::$law::<32>(kernel, stringify!($isa));
                });
            }
        }
    )* };
}

laws!(scalar neon avx2 avx512);

/// Pairs of nodes per k: `SIMDOP_PAIRS`, else as many as are no burden.
fn pairs() -> u64 {
    let small = std::env::var("SIMDOP_SUITE").is_ok_and(|suite| suite == "small");
    match std::env::var("SIMDOP_PAIRS") {
        Ok(pairs) => pairs.parse().expect("SIMDOP_PAIRS is a number"),
        Err(_) if cfg!(miri) => 3,
        Err(_) if small => 4_000,
        Err(_) => 100_000,
    }
}

/// Pairs of nodes per k at which digests are compared with [`RECORDED`] ones, and an eighth as many
/// re-alignments and primitive slabs.
const RECORDED_PAIRS: u64 = 10_000_000;

/// For each k, the scalar kernel's digests of overlaps, re-alignments and primitive slabs. The tests of `scalar`
/// check them:
/// `SIMDOP_PAIRS=10000000 cargo test --release --test kernel_law scalar`.
#[rustfmt::skip]
const RECORDED: [(usize, [u64; 3]); 5] = [
    (6, [0x1b927ef70f9f2080, 0x98944e66286fa4b9, 0x9607f9be1f0cc37e]),
    (14, [0x6483436517b52db2, 0x748b024fb5a7d947, 0x60737f8b1c9c3463]),
    (18, [0xbc917f935da03b46, 0x64706450bcfe9d67, 0x8a518299f267ecad]),
    (26, [0xc64ab0434175868f, 0x2238ba2db8de2469, 0xfe599beb99ceed19]),
    (32, [0x2b3b7a2e90717a17, 0xb9c2333279a47cc8, 0x81da7990e950e85e]),
];

/// The scalar kernel's digests, where the number of pairs is the recorded one.
fn recorded<const K: usize>() -> Option<[u64; 3]> {
    (pairs() == RECORDED_PAIRS).then(|| RECORDED.iter().find(|row| row.0 == K).expect("a row for each k").1)
}

/// Prints a digest, and compares it if there is a recorded one.
fn conclude(what: &str, digest: &Digest, recorded: Option<u64>) {
    println!("{what}, digest {:016x}", digest.0);
    let all = pairs();
    assert!(
        recorded.is_none_or(|want| digest.0 == want),
        "{what}: digest {:#018x}, the scalar kernel's is {:#018x}; SIMDOP_PAIRS={} compares the same pairs one by one",
        digest.0,
        recorded.unwrap_or_default(),
        all - 1
    );
}

// ---- Inputs -----------------------------------------------------------------------------------------------

/// Planes of `W` bodies, by plane.
type Planes<const W: usize, const K: usize> = [[i16; W]; K];

/// How a pair is generated. In all but the last, a compare separates with a chance of about 1 / K, so that
/// masks have bits of both kinds.
#[derive(Copy, Clone, Debug)]
enum Mode {
    /// Small integers: bodies touch often.
    Grid,
    /// Codes that are equal or next to each other.
    Near,
    /// All codes: those that are no planes, and the mark of unused lanes.
    AnyBits,
    /// Planes of a tree, turned into another's frame at poses where they meet.
    Real,
}

/// Miri is too slow to build trees.
const MODES: &[Mode] = if cfg!(miri) {
    &[Mode::Grid, Mode::Near, Mode::AnyBits]
} else {
    &[Mode::Grid, Mode::Near, Mode::AnyBits, Mode::Real]
};

fn code(rng: &mut Rng) -> i16 {
    if rng.below(4) == 0 { *rng.pick(&SPECIAL) } else { rng.u64() as i16 }
}

/// Planes below `middles` (side -1, for queries) or above them (1, for nodes), except one in 2 K.
fn planes<const W: usize, const K: usize>(
    rng: &mut Rng,
    mode: Mode,
    middles: &[i16; K],
    side: i64,
) -> Planes<W, K> {
    let grid = |x: i64| Key::round_up_f64(x as f64).unwrap().code();
    let mut draw = |middle: i16| {
        let side = if rng.below(2 * K as u64) == 0 { -side } else { side };
        match mode {
            Mode::Grid => grid(if side < 0 { rng.int(-2, 1) } else { rng.int(1, 3) }),
            Mode::Near => middle.saturating_add((side * rng.int(0, 1)) as i16),
            Mode::AnyBits | Mode::Real => {
                let any = code(rng);
                if side < 0 { any.min(middle) } else { any.max(middle) }
            }
        }
    };
    core::array::from_fn(|j| core::array::from_fn(|_| draw(middles[j])))
}

fn middles<const K: usize>(rng: &mut Rng) -> [i16; K] {
    core::array::from_fn(|_| code(rng))
}

/// A query and a node's planes.
fn pair<const W: usize, const K: usize>(rng: &mut Rng, mode: Mode) -> (Planes<W, K>, Planes<W, K>) {
    let middles = middles(rng);
    (planes(rng, mode, &middles, -1), planes(rng, mode, &middles, 1))
}

/// A body of sixteen and one of four.
type Both<const K: usize> = (Planes<16, K>, Planes<4, K>);

/// `n` queries and `n` nodes, every two of which are a pair.
fn pool<const K: usize>(
    rng: &mut Rng,
    mode: Mode,
    trees: &LazyCell<Trees<K>, impl FnOnce() -> Trees<K>>,
    n: usize,
) -> (Vec<Both<K>>, Vec<Both<K>>)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    if let Mode::Real = mode {
        return (
            (0..n).map(|_| (trees.query_16(rng), trees.query_4(rng))).collect(),
            (0..n).map(|_| (trees.node_16(rng).planes, trees.node_4(rng).planes)).collect(),
        );
    }
    let (wide, narrow) = (middles(rng), middles(rng));
    let mut draw =
        |side| (0..n).map(|_| (planes(rng, mode, &wide, side), planes(rng, mode, &narrow, side))).collect();
    (draw(-1), draw(1))
}

/// `count` pairs: each item of a list with each of another, from lists that `draw` makes of a given length.
/// To draw an item for every pair would take an emulator a hundred times as long as the kernels.
fn each_pair<A, B>(
    count: u64,
    mut draw: impl FnMut(usize) -> (Vec<A>, Vec<B>),
    mut visit: impl FnMut(u64, &A, &B),
) {
    // Many lists even where pairs are few.
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

/// Nodes of two trees of one mesh, A's in query form at poses where the trees meet, and slabs of triangles
/// beside them.
struct Trees<const K: usize> {
    wide: Bvh<Node16<K>>,
    narrow: Bvh<Node4<K>>,
    maps: Vec<Realignment<K>>,
    slabs: Vec<PrimitiveSlab>,
}

/// A torus with a wave: curved both ways, and not symmetric.
fn shape(n: u32) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // A rational parametrisation of the circle: sines differ between machines.
    let circle = |i: u32| {
        let t = f64::from(i % n) / f64::from(n) * 4.0 - 2.0;
        let (t, turn) = if t.abs() <= 1.0 { (t, 1.0) } else { (t - 2.0_f64.copysign(t), -1.0) };
        [turn * (1.0 - t * t) / (1.0 + t * t), turn * 2.0 * t / (1.0 + t * t)]
    };
    let grid = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let vertices = grid().map(|(i, j)| {
        let ([c, s], [u, v]) = (circle(i), circle(j));
        let r = 2.0 + (0.7 + 0.2 * c) * u;
        [r * c, r * s, (0.7 + 0.2 * c) * v + 0.3 * s * c]
    });
    let at = |i: u32, j: u32| i % n * n + j % n;
    let triangles = grid().flat_map(|(i, j)| {
        [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    (vertices.collect(), triangles.collect())
}

impl<const K: usize> Trees<K>
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    fn new(rng: &mut Rng) -> Self {
        let (vertices, triangles) = shape(24);
        let mesh = Mesh { vertices: &vertices, triangles: &triangles };
        let (wide, narrow) =
            (Builder::new().build_as(&mesh).unwrap(), Builder::new().build_as(&mesh).unwrap());
        let extent = Bvh::<Node16<K>>::view(&wide).extent();
        let mut pose = || {
            let rotation = rng.rotation();
            let shift = rng.rotation()[0].map(|x| x * 2.0);
            let rows = core::array::from_fn(|i| [rotation[i][0], rotation[i][1], rotation[i][2], shift[i]]);
            Pose::from_rows(rows).unwrap()
        };
        let poses: Vec<_> = (0..64).map(|_| pose()).collect();
        let maps = poses.iter().map(|pose| Realignment::new(pose, &extent, &extent.frame)).collect();
        let mut corner = || [(); 3].map(|()| rng.range(-2.0, 2.0));
        let mut triangle = || [corner(), corner(), corner()];
        let slabs = poses.iter().flat_map(|pose| {
            let posed = primitive_slabs::<Triangles, K>(&triangle(), 0.0, &extent, Some(pose));
            let still = primitive_slabs::<Triangles, K>(&triangle(), 0.01, &extent, None);
            posed.into_iter().chain(still)
        });
        let slabs = slabs.collect();
        Self { wide, narrow, maps, slabs }
    }

    fn node_16(&self, rng: &mut Rng) -> &Node16<K> {
        upper(rng, self.wide.view().nodes())
    }

    fn node_4(&self, rng: &mut Rng) -> &Node4<K> {
        upper(rng, self.narrow.view().nodes())
    }

    fn query_16(&self, rng: &mut Rng) -> Turned<16, K> {
        turned_16(Scalar::new(), rng.pick(&self.maps), self.node_16(rng))
    }

    fn query_4(&self, rng: &mut Rng) -> Turned<4, K> {
        turned_4(Scalar::new(), rng.pick(&self.maps), self.node_4(rng))
    }
}

/// A node, more often one of the upper and larger: they come first, and overlap more.
fn upper<'a, N>(rng: &mut Rng, nodes: &'a [N]) -> &'a N {
    let end = 1 + rng.below(nodes.len() as u64) as usize;
    let end = 1 + rng.below(end as u64) as usize;
    rng.pick(&nodes[..end])
}

const fn wide<const K: usize>(planes: Planes<16, K>) -> Node16<K> {
    Node16::new(planes, [Child::EMPTY; 16])
}

const fn narrow<const K: usize>(planes: Planes<4, K>) -> Node4<K> {
    Node4::new(planes, [Child::EMPTY; 4])
}

/// A digest of words. Each step is a bijection of the state and of the word, so that one word that differs
/// always shows.
struct Digest(u64);

impl Digest {
    const EMPTY: Self = Self(0);

    #[inline]
    fn add(&mut self, word: u64) {
        // An odd factor: SplitMix64's.
        self.0 = (self.0 ^ word).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29);
    }

    fn add_query<const W: usize, const K: usize>(&mut self, query: &Turned<W, K>) {
        query.iter().for_each(|plane| words(&plane.map(|code| code as u16)).for_each(|word| self.add(word)));
    }
}

/// Four values a word.
#[inline]
fn words(values: &[u16]) -> impl Iterator<Item = u64> {
    values.chunks(4).map(|four| four.iter().rev().fold(0, |word, &value| word << 16 | u64::from(value)))
}

// ---- The laws ---------------------------------------------------------------------------------------------

/// The overlap kernels in one list of masks: 16 lanes 1vs16, one lane 16vs1, 4vs4, and 16 against the hull.
type Masks = [u16; 19];

#[inline(always)]
fn masks<E: Kernel, const K: usize>(
    kernel: E,
    (query, query_4): &(Turned<16, K>, Turned<4, K>),
    (node, node_4): &(Node16<K>, Node4<K>),
    column: usize,
) -> Masks {
    kernel.run(
        #[inline(always)]
        || {
            let mut masks = [0; 19];
            for (lane, mask) in masks[..16].iter_mut().enumerate().step_by(if cfg!(miri) { 5 } else { 1 }) {
                *mask = kernel.overlap_1v16(query, lane, node);
            }
            masks[16] = kernel.overlap_16v1(query, node, column);
            masks[17] = kernel.overlap_4v4(query_4, node_4);
            masks[18] = kernel.overlap_16v_hull(query, node);
            masks
        },
    )
}

/// Sixteen balls: near each other, of any bits, or such as trees have, with unused lanes.
fn balls(rng: &mut Rng, mode: u64) -> Ball16 {
    const SPECIAL: [f32; 8] =
        [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MIN_POSITIVE, f32::MAX, 1e-40];
    let mut balls = Ball16::EMPTY;
    for lane in 0..16 {
        let mut ball = balls.lane(lane);
        match mode {
            // On a lattice: many touch.
            0 => {
                ball.centre = [(); 3].map(|()| rng.int(-3, 3) as f32);
                (ball.radius, ball.volume) = (rng.int(0, 2) as f32, rng.int(0, 9) as f32);
            }
            1 if rng.below(5) == 0 => {}
            1 => {
                ball.centre = [(); 3].map(|()| rng.range(-90.0, 90.0) as f32);
                ball.radius = rng.range(0.0, 1.0).powi(3) as f32 * 60.0;
                ball.volume = ball.radius.powi(3) * rng.range(0.0, 4.0) as f32;
            }
            _ => {
                let mut any =
                    || if rng.below(3) == 0 { *rng.pick(&SPECIAL) } else { f32::from_bits(rng.u64() as u32) };
                (ball.centre, ball.radius, ball.volume) = ([any(), any(), any()], any(), any());
            }
        }
        balls.set(lane, &ball);
    }
    balls
}

/// Masks and bounds, by their bits; rows that are not wanted stay as they are.
fn balls_equal_the_scalar_kernel<E: Kernel>(kernel: E, name: &str) {
    let mut rng = Rng::new(5);
    let count = (pairs() / 4).max(1);
    let (mut ones, mut digest) = (0_u64, Digest::EMPTY);
    for i in 0..count {
        let (mode_a, mode_b) = if i % 3 == 2 { (2, rng.below(3)) } else { (i % 3, i % 3) };
        let (a, b) = (balls(&mut rng, mode_a), balls(&mut rng, mode_b));
        let (wanted, lane) = (rng.u64() as u16, rng.below(16) as usize);
        let run = |rows: &mut [u16; 16], shared: &mut [f32; 16]| {
            kernel.run(
                #[inline(always)]
                || {
                    kernel.balls_meet(&a, wanted, &b, rows);
                    kernel.balls_share(&a.lane(lane), &b, shared);
                },
            );
        };
        let (mut got, mut want) = (([0x5a5a; 16], [0.5; 16]), ([0x5a5a; 16], [0.5; 16]));
        run(&mut got.0, &mut got.1);
        Scalar::new().balls_meet(&a, wanted, &b, &mut want.0);
        if cfg!(miri) {
            // libm's roots are inline assembly, which Miri does not know: the kernel is run, and not compared.
            want.1 = got.1;
        } else {
            Scalar::new().balls_share(&a.lane(lane), &b, &mut want.1);
        }
        // A NaN is a NaN, whatever else its bits say.
        let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
        assert_eq!((got.0, got.1.map(bits)), (want.0, want.1.map(bits)), "{name} pair {i}: {a:?} {b:?}");
        for row in (0..16).filter(|row| wanted >> row & 1 != 0) {
            ones += u64::from(got.0[row].count_ones());
            if row == lane {
                let met = (0..16).fold(0, |mask, i| mask | u16::from(got.1[i] > 0.0) << i);
                assert_eq!(met, got.0[row], "{name} pair {i}: a volume is shared where balls meet");
            }
        }
        words(&got.0).for_each(|word| digest.add(word));
    }
    let share = ones as f64 / (count * 8 * 16) as f64;
    assert!(cfg!(miri) || (0.02..0.6).contains(&share), "{share} of the bits are 1");
    println!("{name}: {count} pairs of sixteen balls, digest {:016x}", digest.0);
}

fn overlaps_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    let mut rng = Rng::new(K as u64);
    let trees = LazyCell::new(|| Trees::<K>::new(&mut Rng::new(K as u64)));
    let recorded = recorded::<K>().map(|[overlaps, ..]| overlaps);
    let mut digest = Digest::EMPTY;
    let count = pairs() / MODES.len() as u64;
    for &mode in MODES {
        let mut ones = 0_u64;
        let draw = |n| {
            let (queries, nodes) = pool(&mut rng, mode, &trees, n);
            (queries, nodes.into_iter().map(|(planes, four)| (wide(planes), narrow(four))).collect())
        };
        each_pair(count, draw, |i, queries, nodes| {
            let column = (i % 16) as usize;
            let got = masks(kernel, queries, nodes, column);
            if recorded.is_none() {
                let want = masks(Scalar::new(), queries, nodes, column);
                assert_eq!(got, want, "{name} k {K} {mode:?} pair {i}: {queries:x?} {nodes:x?}");
            }
            for word in words(&got) {
                digest.add(word);
                ones += u64::from(word.count_ones());
            }
        });
        let share = ones as f64 / (count * 19 * 16) as f64;
        assert!(cfg!(miri) || (0.005..0.9).contains(&share), "{mode:?} k {K}: {share} of the bits are 1");
    }
    conclude(&format!("{name} k {K}: {} pairs of nodes", pairs()), &digest, recorded);
}

/// Any number, more often one that is special or small.
fn float(rng: &mut Rng) -> f32 {
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

/// A map with anything in it.
fn any_map<const K: usize>(rng: &mut Rng) -> Realignment<K> {
    Realignment {
        sources: core::array::from_fn(|_| core::array::from_fn(|_| rng.below(K as u64) as u8)),
        weights: core::array::from_fn(|_| core::array::from_fn(|_| float(rng).abs())),
        offset: core::array::from_fn(|_| float(rng)),
    }
}

fn realignments_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    let mut rng = Rng::new(100 + K as u64);
    let trees = LazyCell::new(|| Trees::<K>::new(&mut Rng::new(K as u64)));
    let scalar = Scalar::new();
    let recorded = recorded::<K>().map(|[_, realignments, _]| realignments);
    let mut digest = Digest::EMPTY;
    // How many nodes meet no body of theirs turned, and some.
    let mut met = [0; 2];
    // A scalar re-alignment costs as much as a hundred overlaps.
    let count = pairs() / 8 / MODES.len() as u64 + 1;
    for &mode in MODES {
        let draw = |n| {
            let maps: Vec<_> = match mode {
                Mode::Real => (0..n).map(|_| *rng.pick(&trees.maps)).collect(),
                _ => (0..n).map(|_| any_map(&mut rng)).collect(),
            };
            let (_, nodes) = pool(&mut rng, mode, &trees, n);
            (maps, nodes.into_iter().map(|(planes, four)| (wide(planes), narrow(four))).collect())
        };
        each_pair(count, draw, |i, map, (node, node_4): &(Node16<K>, Node4<K>)| {
            let (got, got_4) = (turned_16(kernel, map, node), turned_4(kernel, map, node_4));
            if recorded.is_none() {
                assert_eq!(
                    got,
                    turned_16(scalar, map, node),
                    "{name} k {K} {mode:?} map {i}: {map:?} {node:x?}"
                );
                let want = turned_4(scalar, map, node_4);
                assert_eq!(got_4, want, "{name} k {K} {mode:?} map {i}: {map:?} {node_4:x?}");
            }
            digest.add_query(&got);
            digest.add_query(&got_4);
            if i % 4 == 0 {
                let mut early = got.map(|plane| plane.map(|code| !code));
                let mut whole = 0;
                // First all of the other body, then each child of its node: what was turned before is not turned again.
                for lane in [None].into_iter().chain((0..16).map(Some)) {
                    let mask = kernel.realign_16_over(map, node, &mut early, &mut whole, node, lane);
                    let want = match lane {
                        None => scalar.overlap_16v_hull(&got, node),
                        Some(lane) => scalar.overlap_16v1(&got, node, lane),
                    };
                    assert_eq!(mask, want, "{name} k {K} {mode:?} map {i} {lane:?}: {map:?} {node:x?}");
                    assert_eq!(mask & !whole, 0, "{name} k {K} {mode:?} map {i}: they are whole");
                    for (early, got) in early.iter().zip(&got) {
                        let is_equal = |lane: usize| whole >> lane & 1 == 0 || early[lane] == got[lane];
                        assert!((0..16).all(is_equal), "{name} k {K} {mode:?} map {i}: {map:?} {node:x?}");
                    }
                    met[usize::from(mask != 0)] += 1;
                }
            }
        });
    }
    // A sixth at k 32, but a tenth of the few nodes that mutants are tried with.
    let share = if pairs() < 4_000 { 16 } else { 8 };
    assert!(cfg!(miri) || met.into_iter().all(|count| share * count > met[0] + met[1]), "k {K}: {met:?}");
    let all = count * MODES.len() as u64;
    conclude(&format!("{name} k {K}: {all} re-alignments of 16 and of 4"), &digest, recorded);
}

/// A slab with anything in it. As often as not a limit is the sum that some child has, so that the compare
/// of equal numbers and the last place of the sum count.
fn any_slab<const W: usize, const K: usize>(
    rng: &mut Rng,
    mode: Mode,
    nodes: &[Planes<W, K>],
) -> PrimitiveSlab {
    let number = |rng: &mut Rng| match mode {
        Mode::Grid => rng.int(-1, 3) as f32,
        _ => float(rng),
    };
    let sources: [u8; 3] = core::array::from_fn(|_| rng.below(K as u64) as u8);
    let weights: [f32; 3] = core::array::from_fn(|_| number(rng));
    let limits = [0, 1].map(|side| {
        if rng.below(2) == 0 {
            return number(rng);
        }
        let (planes, lane) = (rng.pick(nodes), rng.below(W as u64) as usize);
        let term = |l: usize| weights[l] * f32::from(planes[usize::from(sources[l]) ^ side][lane]);
        (term(0) + term(1)) + term(2)
    });
    PrimitiveSlab { sources, weights, limits }
}

/// Children beyond a slab, of sixteen and of four.
fn beyond<const K: usize>(
    kernel: impl Kernel,
    (slab, slab_4): &(PrimitiveSlab, PrimitiveSlab),
    (node, node_4): &(Node16<K>, Node4<K>),
) -> [u16; 2] {
    [kernel.beyond_16(slab, node), kernel.beyond_4(slab_4, node_4)]
}

fn own_slabs_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    let mut rng = Rng::new(600 + K as u64);
    let trees = LazyCell::new(|| Trees::<K>::new(&mut Rng::new(K as u64)));
    let recorded = recorded::<K>().map(|[_, _, slabs]| slabs);
    let mut digest = Digest::EMPTY;
    let count = pairs() / 8 / MODES.len() as u64 + 1;
    for &mode in MODES {
        let mut ones = 0_u64;
        let draw = |n| {
            let (_, nodes) = pool(&mut rng, mode, &trees, n);
            let (wides, narrows): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
            let slab = |_| match mode {
                Mode::Real => (*rng.pick(&trees.slabs), *rng.pick(&trees.slabs)),
                _ => (any_slab(&mut rng, mode, &wides), any_slab(&mut rng, mode, &narrows)),
            };
            let slabs: Vec<_> = (0..n).map(slab).collect();
            (slabs, wides.into_iter().map(wide).zip(narrows.into_iter().map(narrow)).collect())
        };
        each_pair(count, draw, |i, slabs, nodes: &(Node16<K>, Node4<K>)| {
            let got = beyond(kernel, slabs, nodes);
            if recorded.is_none() {
                let want = beyond(Scalar::new(), slabs, nodes);
                assert_eq!(got, want, "{name} k {K} {mode:?} pair {i}: {slabs:?} {nodes:x?}");
            }
            words(&got).for_each(|word| digest.add(word));
            ones += got.iter().map(|mask| u64::from(mask.count_ones())).sum::<u64>();
        });
        let share = ones as f64 / (count * 20) as f64;
        assert!(cfg!(miri) || (0.05..0.95).contains(&share), "{mode:?} k {K}: {share} of the bits are 1");
    }
    let all = count * MODES.len() as u64;
    conclude(&format!("{name} k {K}: {all} primitive slabs against 16 and against 4"), &digest, recorded);
}

/// Planes that overlap in every lane, by touching.
const fn touching<const W: usize, const K: usize>() -> Planes<W, K> {
    [[5; W]; K]
}

/// Raising one plane of one query lane above one lane of the node clears just that bit, wherever it is.
fn any_one_plane_separates<const K: usize>(kernel: impl Kernel, name: &str) {
    for j in (0..K).step_by(if cfg!(miri) { 5 } else { 1 }) {
        for lane in (0..16).step_by(if cfg!(miri) { 7 } else { 1 }) {
            let (a, b) = ((lane + j) % 16, lane);
            let (mut query, mut node) = (touching(), wide::<K>(touching()));
            query[j][a] = 6;
            assert_eq!(kernel.overlap_1v16(&query, a, &node), 0, "{name} k {K} plane {j}: all separated");
            assert_eq!(kernel.overlap_16v1(&query, &node, b), !(1 << a), "{name} k {K} plane {j} lane {a}");
            query[j][a] = 5;
            node.planes[j][b] = 4;
            assert_eq!(kernel.overlap_1v16(&query, a, &node), !(1 << b), "{name} k {K} plane {j} lane {b}");
            assert_eq!(kernel.overlap_16v1(&query, &node, b), 0, "{name} k {K} plane {j}: all separated");

            let (a, b) = (lane / 4, lane % 4);
            let (mut query, mut node) = (touching(), narrow::<K>(touching()));
            query[j][a] = 6;
            assert_eq!(
                kernel.overlap_4v4(&query, &node),
                !(0xf << (4 * a)),
                "{name} k {K} plane {j} row {a}"
            );
            query[j][a] = 5;
            node.planes[j][b] = 4;
            assert_eq!(
                kernel.overlap_4v4(&query, &node),
                !(0x1111 << b),
                "{name} k {K} plane {j} column {b}"
            );
        }
    }
}

/// One lane is not separated, each other one by one plane only.
fn any_one_lane_overlaps<const K: usize>(kernel: impl Kernel, name: &str) {
    for last in (0..K).step_by(if cfg!(miri) { 7 } else { 1 }) {
        for hit in (0..16).step_by(if cfg!(miri) { 7 } else { 1 }) {
            let (query, mut node) = (touching::<16, K>(), wide::<K>(touching()));
            for lane in (0..16).filter(|&lane| lane != hit) {
                node.planes[(last + lane) % K][lane] = 4;
            }
            assert_eq!(kernel.overlap_1v16(&query, hit, &node), 1 << hit, "{name} k {K} lane {hit}");

            let (mut query, mut node) = (touching(), narrow::<K>(touching()));
            for lane in (0..4).filter(|&lane| lane != hit / 4) {
                query[last][lane] = 6;
            }
            for lane in (0..4).filter(|&lane| lane != hit % 4) {
                node.planes[K - 1 - last][lane] = 4;
            }
            assert_eq!(kernel.overlap_4v4(&query, &node), 1 << hit, "{name} k {K} lane {hit}");
        }
    }
}

/// Overlap is symmetric: with the roles swapped, A's planes in the node and B's in the query, rows are
/// columns. And a reflection of space, which swaps the two planes of each slab, changes nothing. Nor does how many bodies'
/// turned planes lie side by side.
fn roles_swapped_and_bodies_mirrored<const K: usize>(kernel: impl Kernel, name: &str) {
    let mut rng = Rng::new(200 + K as u64);
    let swapped = |planes: &Planes<16, K>| -> Planes<16, K> {
        core::array::from_fn(|j| planes[j ^ 1].map(|code| !code))
    };
    let mirrored = |planes: &Planes<16, K>| -> Planes<16, K> { core::array::from_fn(|j| planes[j ^ 1]) };
    for i in 0..pairs() / 64 + 1 {
        let (query, planes) = pair::<16, K>(&mut rng, MODES[i as usize % 3]);
        let node = wide(planes);
        let rows: [u16; 16] = core::array::from_fn(|a| kernel.overlap_1v16(&query, a, &node));
        let column = |b: usize| (0..16).fold(0, |column, a| column | (rows[a] >> b & 1) << a);
        let mirrored = (mirrored(&query), wide(mirrored(&planes)));
        let swapped = (swapped(&planes), wide(swapped(&query)));
        for (lane, row) in rows.iter().enumerate().step_by(if cfg!(miri) { 5 } else { 1 }) {
            // Turned planes of this lane alone, and of four.
            let one: Turned<1, K> = query.map(|plane| [plane[lane]]);
            assert_eq!(kernel.overlap_1v16(&one, 0, &node), *row, "{name} k {K}");
            let four: Turned<4, K> = query.map(|plane| core::array::from_fn(|i| plane[(lane + i) % 16]));
            assert_eq!(kernel.overlap_1v16(&four, 0, &node), *row, "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&four, 3, &node), rows[(lane + 3) % 16], "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&mirrored.0, lane, &mirrored.1), *row, "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&swapped.0, lane, &swapped.1), column(lane), "{name} k {K}");
            assert_eq!(kernel.overlap_16v1(&query, &node, lane), column(lane), "{name} k {K}");
        }
        // The hull is the child with the greatest of the planes.
        let hull = wide(planes.map(|plane| [*plane.iter().max().unwrap(); 16]));
        let against_hull = kernel.overlap_16v_hull(&query, &node);
        assert_eq!(against_hull, kernel.overlap_16v1(&query, &hull, 5), "{name} k {K}");
    }
}

/// Permuting the children permutes the bits.
fn lanes_permuted<const K: usize>(kernel: impl Kernel, name: &str) {
    let mut rng = Rng::new(300 + K as u64);
    for i in 0..pairs() / 64 + 1 {
        let (query, planes) = pair::<16, K>(&mut rng, MODES[i as usize % 3]);
        let mut order: [usize; 16] = core::array::from_fn(|lane| lane);
        for lane in (1..16).rev() {
            order.swap(lane, rng.below(lane as u64 + 1) as usize);
        }
        let permuted: Planes<16, K> = core::array::from_fn(|j| order.map(|lane| planes[j][lane]));
        let lane = rng.below(16) as usize;
        let straight = kernel.overlap_1v16(&query, lane, &wide(planes));
        let want = (0..16).fold(0, |mask, i| mask | (straight >> order[i] & 1) << i);
        assert_eq!(kernel.overlap_1v16(&query, lane, &wide(permuted)), want, "{name} k {K} {order:?}");
    }
}

/// All 2^32 pairs of codes in one compare, sixteen at a time: ascending codes in the lanes, so that the lanes
/// below the query are counted by a subtraction. The compare does not depend on the plane, the lane or k:
/// [`any_one_plane_separates`] tries those.
fn all_key_pairs<E: Kernel>(kernel: E) {
    const CLEAR: i16 = i16::MIN;
    let mut nodes = vec![wide::<6>([[CLEAR; 16]; 6]); 4096];
    let mut queries = vec![[[CLEAR; 16]; 6]; 4096];
    for (i, first) in (i16::MIN..=i16::MAX).step_by(16).enumerate() {
        let ascending = core::array::from_fn(|lane| first + lane as i16);
        nodes[i].planes[i % 6] = ascending;
        queries[i][i % 6] = ascending;
    }
    for q in i16::MIN..=i16::MAX {
        kernel.run(
            #[inline(always)]
            || {
                for (i, (node, lanes)) in nodes.iter().zip(&queries).enumerate() {
                    let first = i32::from(i16::MIN) + 16 * i as i32;
                    let mut query = [[CLEAR; 16]; 6];
                    query[i % 6][3] = q;
                    let below = (i32::from(q) - first).clamp(0, 16);
                    let want = (0xffff_0000_u32 >> (16 - below)) as u16 | (0xffff_u32 << below) as u16;
                    assert_eq!(kernel.overlap_1v16(&query, 3, node), want, "query {q} against {first}..");
                    // The other way round: sixteen queries against one plane.
                    let mut single = wide::<6>([[i16::MAX; 16]; 6]);
                    single.planes[i % 6][3] = q;
                    let up_to = (i32::from(q) - first + 1).clamp(0, 16);
                    let want = !(0xffff_u32 << up_to) as u16;
                    assert_eq!(kernel.overlap_16v1(lanes, &single, 3), want, "queries {first}.. against {q}");
                    // 4vs4: the rows are the same query, the columns four codes.
                    let four = node.planes.map(|p| [p[0], p[5], p[10], p[15]]);
                    let rows = query.map(|q| [q[3]; 4]);
                    let row = [0, 5, 10, 15]
                        .iter()
                        .enumerate()
                        .fold(0, |row, (b, step)| row | u16::from(i32::from(q) <= first + step) << b);
                    assert_eq!(
                        kernel.overlap_4v4(&rows, &narrow(four)),
                        row * 0x1111,
                        "4vs4: {q}, {first}.."
                    );
                }
            },
        );
    }
}

/// The planes' filter on four triangles is that on one, on every instruction set: corners on a small grid, on
/// few planes, and of any size.
#[test]
fn filters_of_four_triangles_are_those_of_one() {
    for isa in Isa::available() {
        let mut rng = Rng::new(500);
        let mut apart = [0_u64; 2];
        for i in 0..pairs() / 8 + 4 {
            let size =
                if i % 3 == 0 { f64::from_bits(((1023 + rng.int(-190, 290)) as u64) << 52) } else { 1.0 };
            let mut point = |shift: f64| match i % 4 {
                0 => core::array::from_fn(|_| rng.int(-2, 2) as f64 * size),
                1 => {
                    // An oblique plane, as far as rounding lets it be one.
                    let (x, y) = (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
                    [x, y, 0.7 - 0.3 * x - 1.1 * y + shift]
                }
                _ => core::array::from_fn(|_| (rng.range(-1.0, 1.0) + shift) * size),
            };
            let one = [point(0.0), point(0.0), point(0.0)];
            let four = [0.0, 0.1, 0.5, 1.0].map(|shift| [point(shift), point(shift), point(shift)]);
            let margin = if i % 2 == 0 { 0.0 } else { rng.range(0.0, 0.5) * size };
            let probe = Probe::with_margin(&one, margin);
            let want = (0..4).fold(0, |mask, k| mask | u16::from(probe.is_apart(&four[k])) << k);
            let got = on_isa!(isa, kernel => kernel.run(#[inline(always)] || kernel.apart_4(&probe, &four)));
            assert_eq!(got, want, "{isa}: {one:?} {four:?}");
            apart[0] += u64::from(want.count_ones());
            apart[1] += 4;
        }
        let share = apart[0] as f64 / apart[1] as f64;
        assert!(cfg!(miri) || (0.3..0.95).contains(&share), "{share} of the pairs are told apart");
    }
}

/// The scalar kernel against the inequality itself, in `f64`, for planes that are values.
#[test]
fn scalar_kernel_is_the_inequality() {
    let mut rng = Rng::new(400);
    for _ in 0..pairs() / 64 + 1 {
        let value = |rng: &mut Rng| loop {
            let code = if rng.below(2) == 0 { code(rng) } else { rng.int(0x3c00, 0x3c04) as i16 };
            if Key::from_code(code).is_some() {
                return code;
            }
        };
        let a: Planes<16, 18> = core::array::from_fn(|_| core::array::from_fn(|_| value(&mut rng)));
        let b: Planes<16, 18> = core::array::from_fn(|_| core::array::from_fn(|_| value(&mut rng)));
        let query = core::array::from_fn(|j| a[j ^ 1].map(|code| !code));
        let bodies: [[i16; 18]; 16] = core::array::from_fn(|lane| a.map(|plane| plane[lane]));
        for (lane, body) in bodies.iter().enumerate() {
            let separated = |i: usize| (0..18).any(|j| -decode(body[j ^ 1]) > decode(b[j][i]));
            let want = (0..16).fold(0, |mask, i| mask | u16::from(!separated(i)) << i);
            assert_eq!(Scalar::new().overlap_1v16(&query, lane, &wide(b)), want);
        }
    }
}

/// The mark of an unused lane stays separate from everything, even from a query without bounds.
#[test]
fn unused_lanes_are_separated_from_unbounded_bodies() {
    let unbounded = [[Key::INFINITY.code(); 16]; 18];
    let query = unbounded.map(|plane| plane.map(|code| !code));
    let mut planes = unbounded;
    for plane in &mut planes {
        plane[7] = Key::EMPTY.code();
    }
    for isa in Isa::available() {
        on_isa!(isa, kernel => {
            assert_eq!(kernel.overlap_1v16(&query, 0, &wide(planes)), !(1 << 7), "{isa}");
            let mut map = any_map::<18>(&mut Rng::new(1));
            map.offset = [f32::INFINITY; 18];
            let turned = turned_16(kernel, &map, &wide(planes));
            assert_eq!(kernel.overlap_1v16(&turned, 7, &wide(unbounded)), 0, "{isa}");
            assert_eq!(kernel.overlap_1v16(&turned, 6, &wide(unbounded)), u16::MAX, "{isa}");
            let mut turned = [[0; 16]; 18];
            let (a, b) = (wide(planes), wide(unbounded));
            assert_eq!(kernel.realign_16_over(&map, &a, &mut turned, &mut 0, &b, None), !(1 << 7), "{isa}");
        });
    }
}
