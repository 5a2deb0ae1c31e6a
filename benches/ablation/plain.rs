//! Binary DOP trees in plain Rust: one pair of DOPs after the other, in floats, the planes of each DOP contiguous.

use super::traverse::{Rows, System, Work};
use super::tree::{Dop, K, round_up};
use core::array::from_fn;
use simdop::low_level::kernel::Kernel;
use simdop::low_level::realign::Realignment;
use simdop::node::Child;

/// Two children.
#[derive(Copy, Clone)]
#[repr(C, align(32))]
pub(crate) struct Pair {
    dops: [Dop; 2],
    child: [Child; 2],
}

/// Slab by slab, up to the first that separates. Planes of A are realigned on demand: realigning all planes of a node
/// and caching them for the next visit takes 20 to 40 % longer (touching, cow and armadillo).
#[derive(Copy, Clone)]
pub(crate) struct EarlyExit<E>(pub(crate) E);

/// All slabs, in branchless loops that the compiler vectorises for the instruction set.
#[derive(Copy, Clone)]
pub(crate) struct Vectorised<E>(pub(crate) E);

#[inline(always)]
fn turned(map: &ByPlanes, dop: &Dop, j: usize) -> f32 {
    let ([p, q, r], [u, v, w]) = (map.sources[j], map.weights[j]);
    let plane = |source: u8| dop[usize::from(source) % K];
    ((u * plane(p) + v * plane(q)) + w * plane(r)) + map.offset[j]
}

/// Realignment by planes, where the library does it by slabs, so that nothing is left to compute when a plane is
/// realigned.
#[derive(Copy, Clone)]
pub(crate) struct ByPlanes {
    pub(crate) sources: [[u8; 3]; K],
    pub(crate) weights: [[f32; 3]; K],
    pub(crate) offset: [f32; K],
}

impl ByPlanes {
    #[inline(always)]
    pub(crate) fn new(turn: &Realignment<K>) -> Self {
        let turn = for_values(turn);
        let mut map = Self { sources: [[0; 3]; K], weights: [[0.0; 3]; K], offset: turn.offset };
        for s in 0..K / 2 {
            let [p, q, r, _] = turn.sources[s];
            (map.sources[2 * s], map.sources[2 * s + 1]) = ([p, q, r], [p ^ 1, q ^ 1, r ^ 1]);
            let weights = [turn.weights[0][s], turn.weights[1][s], turn.weights[2][s]];
            (map.weights[2 * s], map.weights[2 * s + 1]) = (weights, weights);
        }
        map
    }
}

/// For planes that are numbers: the library's are keys, which include half a step more.
#[inline(always)]
pub(crate) fn for_values(turn: &Realignment<K>) -> Realignment<K> {
    let mut turn = *turn;
    let [u, v, w] = &turn.weights;
    let mut halves = [0.0; K];
    for s in 0..K {
        halves[s] = 0.5 * ((u[s] + v[s]) + w[s]);
    }
    for (slab, half) in turn.offset.chunks_exact_mut(2).zip(halves) {
        slab[0] -= half;
        slab[1] -= half;
    }
    turn
}

/// The part that both systems share: everything except the tests.
macro_rules! two_children {
    () => {
        type Node = Pair;
        type Map = ByPlanes;
        type Leaf = Dop;
        type Isa = E;
        const COLUMN_FIRST: bool = false;

        fn node(dops: &[Dop; 2], child: &[Child; 2]) -> Pair {
            Pair { dops: *dops, child: *child }
        }
        #[inline(always)]
        fn child(node: &Pair, lane: usize) -> Child {
            node.child[lane % 2]
        }
        #[inline(always)]
        fn isa(self) -> E {
            self.0
        }
        #[inline(always)]
        fn map(self, turn: &Realignment<K>) -> ByPlanes {
            ByPlanes::new(turn)
        }
    };
}

impl<E: Kernel> EarlyExit<E> {
    /// Which of the children of B in `row` overlap a body with these planes.
    #[inline(always)]
    fn test(plane: impl Fn(usize) -> f32, node: &Pair, mut row: u16, work: &mut Work) -> u16 {
        work.tests += u64::from(row.count_ones());
        for slab in 0..K / 2 {
            let (high, low) = (plane(2 * slab), -plane(2 * slab + 1));
            for lane in 0..2 {
                let dop = &node.dops[lane];
                if row >> lane & 1 != 0 {
                    work.slabs += 1;
                    let separated = low > dop[2 * slab] || -high > dop[2 * slab + 1];
                    row &= !(u16::from(separated) << lane);
                }
            }
            if row == 0 {
                break;
            }
        }
        row
    }
}

impl<E: Kernel> System<2> for EarlyExit<E> {
    type Turned<'n> = &'n Pair;
    two_children!();

    #[inline(always)]
    fn turn<'n>(self, _: &ByPlanes, node: &'n Pair) -> &'n Pair {
        node
    }
    #[inline(always)]
    fn leaf(self, planes: &[f64; K]) -> Dop {
        planes.map(round_up)
    }
    #[inline(always)]
    fn rows(self, map: &ByPlanes, a: &&Pair, node: &Pair, _: u16, work: &mut Work) -> Rows<2> {
        let mut rows = Rows::NONE;
        for (lane, dop) in a.dops.iter().enumerate() {
            rows.set(lane, Self::test(|j| turned(map, dop, j), node, 0b11, work));
        }
        rows
    }
    #[inline(always)]
    fn column(self, map: &ByPlanes, a: &&Pair, node: &Pair, lane: usize, work: &mut Work) -> u16 {
        let lane = lane % 2;
        let one = |dop: &Dop, work: &mut Work| Self::test(|j| turned(map, dop, j), node, 1 << lane, work);
        one(&a.dops[0], work) >> lane | one(&a.dops[1], work) >> lane << 1
    }
    #[inline(always)]
    fn row(self, a: &Dop, node: &Pair, work: &mut Work) -> u16 {
        Self::test(|j| a[j], node, 0b11, work)
    }
}

/// `query` has the complements of realigned planes, as the library's query form: plane j of B is compared with entry j.
#[inline(always)]
fn overlap(query: &Dop, dop: &Dop) -> bool {
    let mut separated = false;
    for j in 0..K {
        separated |= query[j] > dop[j];
    }
    !separated
}

impl<E: Kernel> System<2> for Vectorised<E> {
    type Turned<'n> = [Dop; 2];
    two_children!();

    #[inline(always)]
    fn turn(self, map: &ByPlanes, node: &Pair) -> [Dop; 2] {
        let mut query = [[0.0; K]; 2];
        for (query, dop) in query.iter_mut().zip(&node.dops) {
            for j in 0..K {
                query[j ^ 1] = -turned(map, dop, j);
            }
        }
        query
    }
    #[inline(always)]
    fn leaf(self, planes: &[f64; K]) -> Dop {
        from_fn(|j| -round_up(planes[j ^ 1]))
    }
    #[inline(always)]
    fn rows(self, _: &ByPlanes, a: &[Dop; 2], node: &Pair, _: u16, work: &mut Work) -> Rows<2> {
        let mut rows = Rows::NONE;
        rows.set(0, self.row(&a[0], node, work));
        rows.set(1, self.row(&a[1], node, work));
        rows
    }
    #[inline(always)]
    fn column(self, _: &ByPlanes, a: &[Dop; 2], node: &Pair, lane: usize, work: &mut Work) -> u16 {
        work.in_all_slabs(2);
        let dop = &node.dops[lane % 2];
        u16::from(overlap(&a[0], dop)) | u16::from(overlap(&a[1], dop)) << 1
    }
    #[inline(always)]
    fn row(self, a: &Dop, node: &Pair, work: &mut Work) -> u16 {
        work.in_all_slabs(2);
        u16::from(overlap(a, &node.dops[0])) | u16::from(overlap(a, &node.dops[1])) << 1
    }
}
