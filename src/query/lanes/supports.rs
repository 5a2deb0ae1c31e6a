//! Supports of children along arbitrary directions, several at once.

use crate::directions::Directions;
use crate::key::Storage;

/// Number of pairs tested at once. Where `f64` is emulated, loops over more would be unrolled into twice the code.
pub(in crate::query) const AT_ONCE: usize = if cfg!(simdop_small) { 1 } else { 4 };

/// The least and the greatest support of some children, each along a direction of its own, by column.
#[inline(always)]
pub(in crate::query) fn supports<const W: usize, const K: usize, S: Storage>(
    children: [(&[[i16; W]; K], usize); AT_ONCE],
    directions: &[[f64; AT_ONCE]; 3],
) -> [[f64; AT_ONCE]; 2] {
    let mut w = *directions;
    let sources = Directions::<K>::decompose_columns(&mut w, AT_ONCE, AT_ONCE);
    let mut codes = [[[0_i16; AT_ONCE]; 3]; 2];
    for (j, (planes, lane)) in children.into_iter().enumerate() {
        for (l, &source) in sources[j][..3].iter().enumerate() {
            for side in 0..2 {
                codes[side][l][j] = planes[usize::from(source) ^ side][lane % W];
            }
        }
    }
    let mut supports = [[0.0; AT_ONCE]; 2];
    for side in 0..2 {
        for j in 0..AT_ONCE {
            let plane = |l: usize| f64::from(S::value(codes[side][l][j]));
            supports[side][j] = (w[0][j] * plane(0) + w[1][j] * plane(1)) + w[2][j] * plane(2);
        }
    }
    let [greatest, opposite] = supports;
    [opposite.map(|x| -x), greatest]
}
