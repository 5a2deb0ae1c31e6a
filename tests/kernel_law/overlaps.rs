//! The overlap kernels.

use crate::digest::{Digest, conclude, recorded, words};
use crate::inputs::{MODES, Planes, code, each_pair, narrow, pair, pool, wide, wide_as};
use crate::pairs;
use crate::realign::any_map;
use crate::support::rng::Rng;
use crate::trees::Trees;
use crate::turned::turned_16;
use simdop::isa::{Isa, Scalar, on_isa};
use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::{Fixed, Half, Key, Storage};
use simdop::node::{Node4, Node16};
use simdop::query::Lanes;
use std::cell::LazyCell;

/// The masks of all overlap kernels: 1vs16 of 16 lanes, 16vs1 of one lane, 4vs4, and 16 against the hull.
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

pub(crate) fn overlaps_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
{
    let mut rng = Rng::new(K as u64);
    let trees = LazyCell::new(|| Trees::<K>::new(&mut Rng::new(K as u64)));
    let recorded = recorded::<K, Fixed>().map(|[overlaps, ..]| overlaps);
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

/// Planes that touch in every lane, and so overlap.
const fn touching<const W: usize, const K: usize>() -> Planes<W, K> {
    [[5; W]; K]
}

/// Raising one plane of one query lane above one lane of the node clears just that bit, for every plane and
/// lane.
pub(crate) fn any_one_plane_separates<const K: usize>(kernel: impl Kernel, name: &str) {
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

/// One lane overlaps; each other lane is separated by one plane only.
pub(crate) fn any_one_lane_overlaps<const K: usize>(kernel: impl Kernel, name: &str) {
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

/// Overlap is symmetric: exchanging the roles, A's planes in the node and B's in the query, transposes the
/// mask. A reflection of space, which exchanges the two planes of each slab, does not change it. Nor does the
/// number of bodies whose rotated planes are stored side by side.
pub(crate) fn roles_swapped_and_bodies_mirrored<const K: usize>(kernel: impl Kernel, name: &str) {
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
            // Rotated planes of this lane alone, and of four lanes.
            let one: Turned<1, K> = query.map(|plane| [plane[lane]]);
            assert_eq!(kernel.overlap_1v16(&one, 0, &node), *row, "{name} k {K}");
            let four: Turned<4, K> = query.map(|plane| core::array::from_fn(|i| plane[(lane + i) % 16]));
            assert_eq!(kernel.overlap_1v16(&four, 0, &node), *row, "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&four, 3, &node), rows[(lane + 3) % 16], "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&mirrored.0, lane, &mirrored.1), *row, "{name} k {K}");
            assert_eq!(kernel.overlap_1v16(&swapped.0, lane, &swapped.1), column(lane), "{name} k {K}");
            assert_eq!(kernel.overlap_16v1(&query, &node, lane), column(lane), "{name} k {K}");
        }
        // The hull of the children has the greatest of each of their planes.
        let hull = wide(planes.map(|plane| [*plane.iter().max().unwrap(); 16]));
        let against_hull = kernel.overlap_16v_hull(&query, &node);
        assert_eq!(against_hull, kernel.overlap_16v1(&query, &hull, 5), "{name} k {K}");
    }
}

/// A permutation of the children permutes the bits.
pub(crate) fn lanes_permuted<const K: usize>(kernel: impl Kernel, name: &str) {
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

/// All 2^32 pairs of codes in one compare, sixteen at a time. Codes ascend with the lanes, so a subtraction
/// counts the lanes below the query. The compare does not depend on the plane, the lane or k:
/// [`any_one_plane_separates`] tests those.
pub(crate) fn all_key_pairs<E: Kernel>(kernel: E) {
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
                    // The converse: sixteen queries against one plane.
                    let mut single = wide::<6>([[i16::MAX; 16]; 6]);
                    single.planes[i % 6][3] = q;
                    let up_to = (i32::from(q) - first + 1).clamp(0, 16);
                    let want = !(0xffff_u32 << up_to) as u16;
                    assert_eq!(kernel.overlap_16v1(lanes, &single, 3), want, "queries {first}.. against {q}");
                    // 4vs4: all rows are the same query, and the columns are four codes.
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

/// The scalar kernel against the inequality itself in `f64`, for codes that are finite planes.
#[test]
fn scalar_kernel_is_the_inequality() {
    inequality::<Fixed>();
    inequality::<Half>();
}

fn inequality<S: Storage>() {
    let mut rng = Rng::new(400);
    for _ in 0..pairs() / 64 + 1 {
        let value = |rng: &mut Rng| loop {
            let code = if rng.below(2) == 0 { code::<S>(rng) } else { rng.int(0x3c00, 0x3c04) as i16 };
            if S::is_plane(code) {
                return code;
            }
        };
        let a: Planes<16, 18> = core::array::from_fn(|_| core::array::from_fn(|_| value(&mut rng)));
        let b: Planes<16, 18> = core::array::from_fn(|_| core::array::from_fn(|_| value(&mut rng)));
        let query = core::array::from_fn(|j| a[j ^ 1].map(|code| !code));
        let bodies: [[i16; 18]; 16] = core::array::from_fn(|lane| a.map(|plane| plane[lane]));
        for (lane, body) in bodies.iter().enumerate() {
            let separated = |i: usize| (0..18).any(|j| -S::value(body[j ^ 1]) > S::value(b[j][i]));
            let want = (0..16).fold(0, |mask, i| mask | u16::from(!separated(i)) << i);
            assert_eq!(Scalar::new().overlap_1v16(&query, lane, &wide(b)), want);
        }
    }
}

/// An unused lane is separated from everything, even from an unbounded query.
#[test]
fn unused_lanes_are_separated_from_unbounded_bodies() {
    unused_lanes::<Fixed>();
    unused_lanes::<Half>();
}

fn unused_lanes<S: Storage>() {
    let wide = wide_as::<18, S>;
    let unbounded = [[S::INFINITY; 16]; 18];
    let query = unbounded.map(|plane| plane.map(|code| !code));
    let mut planes = unbounded;
    for plane in &mut planes {
        plane[7] = Key::<S>::EMPTY.code();
    }
    for isa in Isa::available() {
        on_isa!(isa, kernel => {
            assert_eq!(kernel.overlap_1v16(&query, 0, &wide(planes)), !(1 << 7), "{isa}");
            let mut map = any_map::<18, S>(&mut Rng::new(1));
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
