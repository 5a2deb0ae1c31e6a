//! What a query does besides once it has become long: it looks at pairs that wait once more, by their thin
//! slabs ([`super::thin`]).

use super::frontier::Side;
use super::normal_gap::{AT_ONCE, NormalChild, NormalTest};
use super::placing::Margin;
use super::stack::{Descent, Stack, Visited};
use super::traverse::{Traversal, bits_of};
use super::{Lanes, PrimitivePair};
use crate::kernel::Kernel;
use crate::node::{Link, NormalSlab};
use crate::realign::shrinkage;

/// What normal slabs are tested with, and how that went.
#[derive(Default, Debug)]
pub(super) struct NormalSlabs<'t> {
    pub(super) test: Option<NormalTest<'t>>,
    asked: u32,
    apart: u32,
}

/// Normal slabs are asked from this visit on: most queries are shorter, and of hits most pairs that wait are
/// never visited.
pub(super) const LONG: u64 = 32;
/// Normal slabs are given up when, after so many pairs, fewer than one in [`SHARE`] was apart.
const TRIAL: u32 = 32;
const SHARE: u32 = 4;

impl<N, P, Q, E, M> Traversal<'_, N, P, Q, E, M>
where
    N: Lanes,
    P: PrimitivePair<Q>,
    Q: PrimitivePair<P>,
    E: Kernel,
    M: Margin,
{
    /// Clears the bits of the last entry of the stack whose children are apart by their normal slabs. Each entry
    /// is looked at once, when it is its turn: of a hit most never are.
    #[inline(never)]
    pub(super) fn look_again(&mut self, stack: &mut Stack<'_>) {
        while let Some(top) = stack.top() {
            if top.opened != Descent::Both || top.looked_at {
                return;
            }
            top.looked_at = true;
            self.clear_apart(top);
            if top.rows.pending != 0 {
                return;
            }
            stack.pop();
        }
    }

    #[inline(always)]
    fn clear_apart(&mut self, Visited { rows, volumes, .. }: &mut Visited) {
        let (Link::Inner(node_a), Link::Inner(node_b)) = (volumes.a.link(), volumes.b.link()) else { return };
        let (a, b, pose, margin) = (self.a, self.b, self.placing.pose, self.margin.value());
        let is_a_turned = self.placing.turned == Side::A;
        let (Some(slabs_a), Some(slabs_b)) = (a.normal_slabs_of(node_a), b.normal_slabs_of(node_b)) else {
            return;
        };
        // Where it hardly ever separates, it is not asked any more.
        if self.thin.asked >= TRIAL && self.thin.apart * SHARE < self.thin.asked {
            return;
        }
        let (extent_a, extent_b) = (a.extent(), b.extent());
        let test = self.thin.test.get_or_insert_with(|| {
            // Of the query's A and B.
            let (of_a, of_b, shrinkage) = if is_a_turned {
                (extent_a, extent_b, shrinkage::<P>(pose, &extent_a))
            } else {
                (extent_b, extent_a, shrinkage::<Q>(pose, &extent_b))
            };
            NormalTest::new(pose, &of_a, &of_b, margin + shrinkage)
        });
        let (node_a, node_b) = (&a.nodes()[node_a as usize], &b.nodes()[node_b as usize]);
        let (mut asked, mut found) = (0, 0);
        self.kernel.run(
            #[inline(always)]
            || {
                let mut pairs = bits_of(rows.pending as u16)
                    .flat_map(|row| bits_of(rows.rows[row]).map(move |bit| (row, bit)));
                let mut left = *rows;
                loop {
                    let none = NormalSlab::EVERYWHERE;
                    let mut of_a = [NormalChild { node: node_a, lane: 0, slab: none }; AT_ONCE];
                    let mut of_b = [NormalChild { node: node_b, lane: 0, slab: none }; AT_ONCE];
                    let mut count = 0;
                    while count < AT_ONCE {
                        let Some((row, bit)) = pairs.next() else { break };
                        (of_a[count].lane, of_a[count].slab) = (row, slabs_a[row]);
                        (of_b[count].lane, of_b[count].slab) = (bit, slabs_b[bit]);
                        count += 1;
                    }
                    if count == 0 {
                        break;
                    }
                    let (first, second) = if is_a_turned { (&of_a, &of_b) } else { (&of_b, &of_a) };
                    let apart = test.apart(first, second) & ((1 << count) - 1);
                    for j in bits_of(apart) {
                        let row = of_a[j].lane;
                        left.set(row, left.rows[row & 15] & !(1 << of_b[j].lane));
                    }
                    asked += count as u32;
                    found += apart.count_ones();
                }
                drop(pairs);
                *rows = left;
            },
        );
        self.thin.asked += asked;
        self.thin.apart += found;
    }
}
