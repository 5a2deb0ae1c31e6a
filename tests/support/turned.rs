//! [`Kernel::realign_16`] and [`Kernel::realign_4`] by value.

use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::Storage;
use simdop::low_level::realign::Realignment;
use simdop::node::{Node4, Node16};

pub fn turned_16<const K: usize, S: Storage>(
    kernel: impl Kernel,
    map: &Realignment<K, S>,
    node: &Node16<K, S>,
) -> Turned<16, K> {
    let mut query = [[0; 16]; K];
    kernel.realign_16(map, node, &mut query);
    query
}

pub fn turned_4<const K: usize, S: Storage>(
    kernel: impl Kernel,
    map: &Realignment<K, S>,
    node: &Node4<K, S>,
) -> Turned<4, K> {
    let mut query = [[0; 4]; K];
    kernel.realign_4(map, node, &mut query);
    query
}
