//! The two splitters by sorting: longest axis and extended longest axis (SIMDop paper, section IV-A, 1 and
//! 2), by [`Halving`].

use super::assignment::Assignment;
use super::levels;
use super::progress::Observer;
use crate::construct::error::BuildError;
use crate::halving::{Halving, Located};
use crate::range::Point;
use alloc::vec::Vec;

/// The data of a primitive that these splitters use. Items are moved as a whole: looking them up by index would miss
/// the cache at every step.
#[derive(Copy, Clone, Debug)]
pub(super) struct Item {
    pub(super) centroid: Point,
    pub(super) index: u32,
}

impl Located for Item {
    type Number = f64;

    #[inline(always)]
    fn place(&self) -> [f64; 3] {
        self.centroid
    }

    #[inline(always)]
    fn index(&self) -> u32 {
        self.index
    }
}

pub(super) fn assign(
    centroids: &[Point],
    halving: &Halving,
    observer: &mut Observer<'_>,
) -> Result<Assignment, BuildError> {
    let mut items: Vec<Item> =
        centroids.iter().zip(0..).map(|(&centroid, index)| Item { centroid, index }).collect();
    let cut = |(): &mut (), _, items: &mut [Item], ends: &mut [u32]| halving.cut_node(items, ends);
    let ends = levels::split(&mut items, halving.arity, halving.leaf_size, observer, cut)?;
    Ok(Assignment { order: items.iter().map(|item| item.index).collect(), ends })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::ControlFlow;

    fn cut(centroids: &[Point], halving: &Halving) -> Assignment {
        assign(centroids, halving, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    /// Along a line, every cut uses the same order: by place, and by index at equal places.
    #[test]
    fn ties_go_by_index() {
        let place = |i: usize| (i * 7919 % 3001 % 20) as f64;
        let centroids: Vec<Point> = (0..3001).map(|i| [place(i), 0.0, 0.0]).collect();
        let mut want: Vec<u32> = (0..3001).collect();
        want.sort_by_key(|&i| (place(i as usize) as u32, i));
        for (arity, extended) in [(4, false), (4, true), (16, true)] {
            let got = cut(&centroids, &Halving { arity, leaf_size: 1, extended });
            assert_eq!(got.order, want, "arity {arity}, extended {extended}");
        }
    }

    #[test]
    fn leaves_are_in_the_order_of_their_indices() {
        let centroids: Vec<Point> = (0..3001).map(|i| [-f64::from(i), 0.0, 0.0]).collect();
        for (arity, leaf_size) in [(4, 3), (16, 5)] {
            let Assignment { order, ends } = cut(&centroids, &Halving { arity, leaf_size, extended: true });
            let mut nodes = alloc::vec![0];
            let mut leaves = 0;
            for (node, ends) in ends.chunks_exact(arity).enumerate() {
                let mut start = nodes[node];
                for end in ends.iter().map(|&end| end as usize) {
                    if end - start > leaf_size {
                        nodes.push(start);
                    } else {
                        assert!(order[start..end].is_sorted(), "{:?}", &order[start..end]);
                        leaves += usize::from(end > start + 1);
                    }
                    start = end;
                }
            }
            assert!(leaves > 500, "{leaves} leaves of more than one");
        }
    }
}
