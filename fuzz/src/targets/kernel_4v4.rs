//! 4vs4 gives the scalar kernel's mask on every instruction set.

use crate::planes::{narrow, pair, real_4};
use crate::{Input, Mode, for_k, on_every_isa};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::Storage;
use simdop::low_level::realign::Realignment;
use simdop::node::Node4;
use simdop::query::Lanes;

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, k) = (input.mode(), input.u8());
    for_k!(k, check(&mut input, mode));
}

fn check<const K: usize, S: Storage>(input: &mut Input, mode: Mode)
where
    Node4<K, S>: Lanes<Map = Realignment<K, S>>,
{
    let (query, node) = if mode == Mode::Real {
        real_4::<K, S>(input)
    } else {
        let (query, planes) = pair::<4, K, S>(input, mode);
        (query, narrow::<K, S>(planes))
    };
    let want = Scalar::new().overlap_4v4(&query, &node);
    on_every_isa!(kernel => {
        assert_eq!(kernel.overlap_4v4(&query, &node), want, "{kernel:?} k {K} {mode:?}");
    });
}
