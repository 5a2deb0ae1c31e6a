//! The kernels of primitive slabs.

use crate::digest::{Digest, conclude, recorded, words};
use crate::inputs::{MODES, Mode, Planes, each_pair, float, narrow_as, pool, wide_as};
use crate::pairs;
use crate::support::rng::Rng;
use crate::trees::Trees;
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::low_level::realign::PrimitiveSlab;
use simdop::node::{Node4, Node16};
use simdop::query::Lanes;
use std::cell::LazyCell;

/// A random slab. Half of the limits are the sum that some child has, so that the compare of equal numbers and
/// the last bit of the sum matter.
fn any_slab<const W: usize, const K: usize, S: Storage>(
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
        let term = |l: usize| weights[l] * S::number(planes[usize::from(sources[l]) ^ side][lane]);
        (term(0) + term(1)) + term(2)
    });
    PrimitiveSlab { sources, weights, limits }
}

/// The masks of the children beyond a slab, of sixteen and of four.
fn beyond<const K: usize, S: Storage>(
    kernel: impl Kernel,
    (slab, slab_4): &(PrimitiveSlab, PrimitiveSlab),
    (node, node_4): &(Node16<K, S>, Node4<K, S>),
) -> [u16; 2] {
    [kernel.beyond_16(slab, node), kernel.beyond_4(slab_4, node_4)]
}

pub(crate) fn primitive_slabs_equal_the_scalar_kernel<const K: usize>(kernel: impl Kernel, name: &str)
where
    Node16<K>: Lanes,
    Node4<K>: Lanes,
    Node16<K, Half>: Lanes,
    Node4<K, Half>: Lanes,
{
    primitive_slabs::<K, Fixed>(kernel, name);
    primitive_slabs::<K, Half>(kernel, &format!("{name}, half floats,"));
}

fn primitive_slabs<const K: usize, S: Storage>(kernel: impl Kernel, name: &str)
where
    Node16<K, S>: Lanes,
    Node4<K, S>: Lanes,
{
    let mut rng = Rng::new(600 + K as u64);
    let trees = LazyCell::new(|| Trees::<K, S>::new(&mut Rng::new(K as u64)));
    let recorded = recorded::<K, S>().map(|[_, _, slabs]| slabs);
    let mut digest = Digest::EMPTY;
    let count = pairs() / 8 / MODES.len() as u64 + 1;
    for &mode in MODES {
        let mut ones = 0_u64;
        let draw = |n| {
            let (_, nodes) = pool(&mut rng, mode, &trees, n);
            let (wides, narrows): (Vec<_>, Vec<_>) = nodes.into_iter().unzip();
            let slab = |_| match mode {
                Mode::Real => (*rng.pick(&trees.slabs), *rng.pick(&trees.slabs)),
                _ => (
                    any_slab::<_, _, S>(&mut rng, mode, &wides),
                    any_slab::<_, _, S>(&mut rng, mode, &narrows),
                ),
            };
            let slabs: Vec<_> = (0..n).map(slab).collect();
            (slabs, wides.into_iter().map(wide_as).zip(narrows.into_iter().map(narrow_as)).collect())
        };
        each_pair(count, draw, |i, slabs, nodes: &(Node16<K, S>, Node4<K, S>)| {
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
