//! 1vs16 and 16vs1 give the scalar kernel's masks on every instruction set.

use crate::planes::{pair, real_16, wide};
use crate::{Input, Mode, for_k, on_every_isa};
use simdop::isa::Scalar;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::key::Storage;
use simdop::low_level::realign::Realignment;
use simdop::node::Node16;
use simdop::query::Lanes;

/// One run.
pub fn run(data: &[u8]) {
    let mut input = Input::new(data);
    let (mode, k) = (input.mode(), input.u8());
    for_k!(k, check(&mut input, mode));
}

fn check<const K: usize, S: Storage>(input: &mut Input, mode: Mode)
where
    Node16<K, S>: Lanes<Map = Realignment<K, S>>,
{
    let (lane, column) = (input.below(16), input.below(16));
    let (query, node) = if mode == Mode::Real {
        real_16::<K, S>(input)
    } else {
        let (query, planes) = pair::<16, K, S>(input, mode);
        (query, wide(planes))
    };
    let (row, col) = masks(Scalar::new(), &query, lane, &node, column);
    on_every_isa!(kernel => {
        assert_eq!(masks(kernel, &query, lane, &node, column), (row, col), "{kernel:?} k {K} {mode:?}");
    });
}

fn masks<E: Kernel, const K: usize, S: Storage>(
    kernel: E,
    query: &[[i16; 16]; K],
    lane: usize,
    node: &Node16<K, S>,
    column: usize,
) -> (u16, u16) {
    (kernel.overlap_1v16(query, lane, node), kernel.overlap_16v1(query, node, column))
}
