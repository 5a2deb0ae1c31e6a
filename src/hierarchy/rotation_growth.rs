//! How much wider the volumes of a tree become when they are rotated.

use crate::directions::table;
use crate::exact::round_up_f32;
use crate::node::{Dop, Link};
use crate::vector::sqrt;

/// Number of levels of nodes that are measured.
const LEVELS: usize = 3;

/// How much wider the volumes of a tree become when they are rotated into another frame, in the unit of the tree's
/// frame: about the mean width of a child's slabs minus the least width. (A flat wall along an axis has one slab that
/// is far thinner than the others; after a rotation all have the same width.) The result is the geometric mean over
/// the first three levels of the arithmetic mean over a level's used lanes.
///
/// In `f32` and in a fixed order, so that every machine computes the same number.
pub(crate) fn rotation_growth<N: Dop>(nodes: &[N]) -> f32 {
    let (mut product, mut levels) = (1.0, 0);
    let (mut begin, mut end) = (0, 1);
    while levels < LEVELS && begin < end {
        let Some(level) = nodes.get(begin..end) else { break };
        let (mut sum, mut lanes, mut below) = (0.0, 0_u32, 0);
        for node in level {
            for (lane, child) in node.children().iter().enumerate() {
                match child.link() {
                    Link::Empty => continue,
                    Link::Inner(_) => below += 1,
                    Link::Leaf { .. } => {}
                }
                sum += excess(node, lane);
                lanes += 1;
            }
        }
        product *= f64::from(sum / lanes as f32);
        levels += 1;
        (begin, end) = (end, end + below);
    }
    round_up_f32(match levels {
        0 => 0.0,
        1 => product,
        2 => sqrt(product),
        _ => libm::cbrt(product),
    })
}

/// The mean width of a child's slabs minus the least width.
fn excess<N: Dop>(node: &N, lane: usize) -> f32 {
    let lengths = table(N::K).lengths;
    let (mut sum, mut least) = (0.0, f32::INFINITY);
    for (s, length) in lengths.iter().step_by(2).enumerate() {
        let width = (node.value(2 * s, lane) + node.value(2 * s + 1, lane)) / *length as f32;
        least = if width < least { width } else { least };
        sum += width;
    }
    sum / (N::K / 2) as f32 - least
}
