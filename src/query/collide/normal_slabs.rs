//! A long query also culls pending pairs by their normal slabs ([`super::normal_gap`]).

use super::bodies::Bodies;
use super::normal_gap::{NormalChild, NormalTest};
use super::stack::{Stack, Visited};
use crate::kernel::Kernel;
use crate::node::{Link, NormalSlab};
use crate::primitive::Primitive;
use crate::query::lanes::{AT_ONCE, Descent, Lanes, bits_of};
use crate::query::setup::{Margin, Side};
use crate::realign::shrinkage;

/// The test of normal slabs, with the numbers of pairs tested and culled.
#[derive(Default, Debug)]
pub(super) struct NormalSlabs<'t> {
    test: Option<NormalTest<'t>>,
    tested: u32,
    apart: u32,
}

/// Normal slabs are tested from this visit on: most queries are shorter, and most pending pairs of a hit are never
/// visited.
pub(super) const LONG: u64 = 32;
/// Tests of normal slabs stop if, after this many pairs, they separated fewer than one in [`SHARE`].
const TRIAL: u32 = 32;
const SHARE: u32 = 4;

impl<'t> NormalSlabs<'t> {
    /// Clears the bits of the last entry of the stack whose children are separated by their normal slabs. An entry is
    /// tested once, just before it is visited: most entries of a hit never are.
    #[inline(always)]
    pub(super) fn cull<N: Lanes, P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'t, N, P, Q>,
        margin: impl Margin,
        stack: &mut Stack<'_>,
    ) {
        if let Some(top) = stack.top()
            && top.opened == Descent::Both
            && !top.looked_at
        {
            self.cull_entries(kernel, bodies, margin, stack);
        }
    }

    #[inline(never)]
    fn cull_entries<N: Lanes, P: Primitive, Q: Primitive, E: Kernel>(
        &mut self,
        kernel: E,
        bodies: &Bodies<'t, N, P, Q>,
        margin: impl Margin,
        stack: &mut Stack<'_>,
    ) {
        let Bodies { a, b, placing, .. } = *bodies;
        let is_a_turned = placing.turned == Side::A;
        while let Some(top) = stack.top() {
            if top.opened != Descent::Both || top.looked_at {
                return;
            }
            top.looked_at = true;
            if let (Link::Inner(node_a), Link::Inner(node_b)) = (top.volumes.a.link(), top.volumes.b.link())
                && let (Some(slabs_a), Some(slabs_b)) = (a.normal_slabs_of(node_a), b.normal_slabs_of(node_b))
                // Tests stop if they rarely separate.
                && !(self.tested >= TRIAL && self.apart * SHARE < self.tested)
            {
                let test = self.test.get_or_insert_with(|| {
                    let (pose, extent_a, extent_b) = (placing.pose, a.extent(), b.extent());
                    // Slabs of the query's A and B.
                    let (of_a, of_b, shrinkage) = if is_a_turned {
                        (extent_a, extent_b, shrinkage::<P>(pose, &extent_a))
                    } else {
                        (extent_b, extent_a, shrinkage::<Q>(pose, &extent_b))
                    };
                    NormalTest::new(pose, &of_a, &of_b, margin.value() + shrinkage)
                });
                let nodes = (&a.nodes()[node_a as usize], &b.nodes()[node_b as usize]);
                let (tested, apart) = clear_apart(kernel, test, is_a_turned, nodes, (slabs_a, slabs_b), top);
                self.tested += tested;
                self.apart += apart;
            }
            if top.rows.pending != 0 {
                return;
            }
            stack.pop();
        }
    }
}

/// Clears the bits of pairs that are apart. Returns how many were tested, and how many of them are apart.
// Not inlined: compiled once for each node type and instruction set.
#[cfg_attr(simdop_small, inline(always))]
#[cfg_attr(not(simdop_small), inline(never))]
fn clear_apart<N: Lanes, E: Kernel>(
    kernel: E,
    test: &NormalTest<'_>,
    is_a_turned: bool,
    (node_a, node_b): (&N, &N),
    (slabs_a, slabs_b): (&[NormalSlab], &[NormalSlab]),
    Visited { rows, .. }: &mut Visited,
) -> (u32, u32) {
    let (mut tested, mut found) = (0, 0);
    kernel.run(
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
                tested += count as u32;
                found += apart.count_ones();
            }
            drop(pairs);
            *rows = left;
        },
    );
    (tested, found)
}
