//! The specification. Every other kernel is tested against these few lines.

use super::{Kernel, Query, SEPARATED};
use crate::isa::Scalar;
use crate::key::Key;
use crate::node::{Node4, Node16};
use crate::realign::Realignment;

/// Whether some plane separates body `a` of the query from child `b`.
fn separated<const W: usize, const K: usize>(
    query: &Query<W, K>,
    a: usize,
    planes: &[[i16; W]; K],
    b: usize,
) -> bool {
    query.iter().zip(planes).any(|(q, p)| q[a] > p[b])
}

fn realign<const W: usize, const K: usize>(
    map: &Realignment<K>,
    planes: &[[i16; W]; K],
    query: &mut Query<W, K>,
) {
    for j in 0..K {
        for lane in 0..W {
            query[j ^ 1][lane] = !map.plane(j, |source| planes[source][lane]).code();
        }
    }
    for lane in 0..W {
        if planes[0][lane] == Key::EMPTY.code() {
            query[0][lane] = SEPARATED;
        }
    }
}

impl Kernel for Scalar {
    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }

    fn overlap_1v16<const K: usize>(self, query: &Query<16, K>, lane: usize, node: &Node16<K>) -> u16 {
        (0..16).filter(|&i| !separated(query, lane, &node.planes, i)).fold(0, |mask, i| mask | 1 << i)
    }

    fn overlap_16v1<const K: usize>(self, query: &Query<16, K>, node: &Node16<K>, lane: usize) -> u16 {
        (0..16).filter(|&i| !separated(query, i, &node.planes, lane)).fold(0, |mask, i| mask | 1 << i)
    }

    fn overlap_16v_hull<const K: usize>(self, query: &Query<16, K>, node: &Node16<K>) -> u16 {
        let hull = node.planes.map(|plane| plane.into_iter().fold(i16::MIN, i16::max));
        let separated = |i: usize| query.iter().zip(&hull).any(|(q, p)| q[i] > *p);
        (0..16).filter(|&i| !separated(i)).fold(0, |mask, i| mask | 1 << i)
    }

    fn overlap_4v4<const K: usize>(self, query: &Query<4, K>, node: &Node4<K>) -> u16 {
        (0..16).filter(|&i| !separated(query, i / 4, &node.planes, i % 4)).fold(0, |mask, i| mask | 1 << i)
    }

    fn realign_16<const K: usize>(self, map: &Realignment<K>, node: &Node16<K>, query: &mut Query<16, K>) {
        realign(map, &node.planes, query);
    }

    fn realign_4<const K: usize>(self, map: &Realignment<K>, node: &Node4<K>, query: &mut Query<4, K>) {
        realign(map, &node.planes, query);
    }
}
