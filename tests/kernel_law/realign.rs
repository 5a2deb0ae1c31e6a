//! The kernels that rotate planes into another frame.

use crate::digest::{Digest, conclude, recorded};
use crate::inputs::{MODES, Mode, each_pair, float, narrow, narrow_as, pair, pool, wide, wide_as};
use crate::pairs;
use crate::support::rng::Rng;
use crate::trees::Trees;
use crate::turned::{turned_4, turned_16};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::{Fixed, Half, Key, Storage};
use simdop::low_level::realign::Realignment;
use simdop::node::{Node4, Node16};
use simdop::query::Lanes;
use std::cell::LazyCell;

/// A random map.
pub(crate) fn any_map<const K: usize, S: Storage>(rng: &mut Rng) -> Realignment<K, S> {
    Realignment::from_parts(
        core::array::from_fn(|_| core::array::from_fn(|_| rng.below(K as u64) as u8)),
        core::array::from_fn(|_| core::array::from_fn(|_| float(rng).abs())),
        core::array::from_fn(|_| float(rng)),
    )
}

pub(crate) fn realignments_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
    Node16<K, Half>: Lanes,
    Node4<K, Half>: Lanes,
{
    realignments::<K, Fixed>(kernel, name);
    realignments::<K, Half>(kernel, &format!("{name}, half floats,"));
}

fn realignments<const K: usize, S: Storage>(kernel: impl Kernel, name: &str)
where
    Node16<K, S>: Lanes,
    Node4<K, S>: Lanes,
{
    let mut rng = Rng::new(100 + K as u64);
    let trees = LazyCell::new(|| Trees::<K, S>::new(&mut Rng::new(K as u64)));
    let scalar = Scalar::new();
    let recorded = recorded::<K, S>().map(|[_, realignments, _]| realignments);
    let mut digest = Digest::EMPTY;
    // How often no rotated body of the node meets the other body, and how often some do.
    let mut met = [0; 2];
    // A scalar realignment takes as long as a hundred overlaps.
    let count = pairs() / 8 / MODES.len() as u64 + 1;
    for &mode in MODES {
        let draw = |n| {
            let maps: Vec<_> = match mode {
                Mode::Real => (0..n).map(|_| *rng.pick(&trees.maps)).collect(),
                _ => (0..n).map(|_| any_map(&mut rng)).collect(),
            };
            let (_, nodes) = pool(&mut rng, mode, &trees, n);
            let lanes = nodes.into_iter().map(|(mut planes, four)| {
                // The few nodes in Miri would have no unused lane.
                if cfg!(miri) {
                    planes.iter_mut().for_each(|plane| plane[15] = Key::<S>::EMPTY.code());
                }
                (wide_as(planes), narrow_as(four))
            });
            (maps, lanes.collect())
        };
        each_pair(count, draw, |i, map, (node, node_4): &(Node16<K, S>, Node4<K, S>)| {
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
                // First against the hull of the other node, then against each of its children. Planes that are
                // already rotated are not rotated again.
                let lanes = (0..16).step_by(if cfg!(miri) { 7 } else { 1 });
                for lane in [None].into_iter().chain(lanes.map(Some)) {
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
    // At k = 32 a sixth meet, but only a tenth of the few nodes that the mutation tests use.
    let share = if pairs() < 4_000 { 16 } else { 8 };
    assert!(cfg!(miri) || met.into_iter().all(|count| share * count > met[0] + met[1]), "k {K}: {met:?}");
    let all = count * MODES.len() as u64;
    conclude(&format!("{name} k {K}: {all} re-alignments of 16 and of 4"), &digest, recorded);
}

/// Rotated planes at every address that their type may have, relative to a register's alignment.
pub(crate) fn any_alignment<const K: usize>(kernel: impl Kernel, name: &str) {
    let (mut rng, scalar) = (Rng::new(400 + K as u64), Scalar::new());
    let map = any_map::<K, Fixed>(&mut rng);
    for (offset, mode) in (0..8).step_by(if cfg!(miri) { 3 } else { 1 }).zip(MODES.iter().cycle()) {
        let (query, planes) = pair::<16, K>(&mut rng, *mode);
        let (node, mut memory) = (wide(planes), vec![0; 16 * K + 8]);
        let place: &mut [[i16; 16]; K] = memory[offset..][..16 * K].as_chunks_mut().0.try_into().unwrap();
        kernel.realign_16(&map, &node, place);
        assert_eq!(*place, turned_16(scalar, &map, &node), "{name} k {K}, 16 lanes at {offset}");
        *place = query;
        let column = rng.below(16) as usize;
        let want = scalar.overlap_16v1(&query, &node, column);
        assert_eq!(kernel.overlap_16v1(place, &node, column), want, "{name} k {K} at {offset}");
        let want = scalar.overlap_16v_hull(&query, &node);
        assert_eq!(kernel.overlap_16v_hull(place, &node), want, "{name} k {K}, hull, at {offset}");

        let (_, planes) = pair::<4, K>(&mut rng, *mode);
        let (node, mut memory) = (narrow(planes), vec![0; 4 * K + 8]);
        let place: &mut [[i16; 4]; K] = memory[offset..][..4 * K].as_chunks_mut().0.try_into().unwrap();
        kernel.realign_4(&map, &node, place);
        assert_eq!(*place, turned_4(scalar, &map, &node), "{name} k {K}, 4 lanes at {offset}");
    }
}
