//! The intervals that two triangles cut out of the line common to their planes.

use super::sides::Signs;

/// A triangle that another plane cuts or touches, viewed with its own normal towards the viewer and the other plane's
/// normal upwards.
///
/// The line common to both planes is then horizontal, and the triangle cuts an interval out of it. The edges from the
/// apex to `left` and to `right` meet the line in one point each: the ends of the interval.
pub(super) struct Wedge<C> {
    /// The vertex that is alone on its side of the line.
    pub(super) apex: [C; 3],
    pub(super) left: [C; 3],
    pub(super) right: [C; 3],
    /// 1 if the apex is on or above the line and the others on or below it; -1 the other way round.
    pub(super) up: i8,
}

impl<C: Copy> Wedge<C> {
    /// `sides` are those of the vertices of `t`: neither all zero nor all strictly on one side.
    pub(super) fn new(t: &[[C; 3]; 3], sides: [i8; 3]) -> Self {
        let [p, q, r] = sides.map(|side| (side + 1) as usize);
        let (apex, left, right, up) = APEX[(9 * p + 3 * q + r) % 27];
        Self { apex: t[apex as usize % 3], left: t[left as usize % 3], right: t[right as usize % 3], up }
    }
}

/// Apex, left and right vertex, and `up`. The index has the three vertices' sides, each plus 1, as digits of base 3. A
/// table, since the branches would be unpredictable. Sides without an apex do not occur; their entries are arbitrary.
const APEX: [(u8, u8, u8, i8); 27] = {
    let mut table = [(0, 1, 2, 1); 27];
    let mut code = 0;
    while code < 27 {
        let sides = [code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1];
        let mut i = 3;
        while i > 0 {
            i -= 1;
            let (next, last) = ((i + 1) % 3, (i + 2) % 3);
            let (s, p, q) = (sides[i], sides[next], sides[last]);
            if s >= 0 && s > p && s > q {
                table[code as usize] = (i as u8, next as u8, last as u8, 1);
            } else if s <= 0 && s < p && s < q {
                table[code as usize] = (i as u8, last as u8, next as u8, -1);
            }
        }
        code += 1;
    }
    table
};

/// Whether the intervals that two triangles cut out of their planes' common line meet.
///
/// For an edge `pq` of one triangle and `rs` of the other, the side of the plane `pqr` on which `s` lies says which of
/// the two edges meets the line further to the right. `up` corrects for edges that go upwards. The two wedges have
/// opposite views of the line: the left end of one is a right end for the other.
pub(super) fn meet(a: &Wedge<f64>, b: &Wedge<f64>, signs: &mut Signs) -> bool {
    let up = a.up * b.up;
    up * signs.side(&[a.apex, a.left, b.apex], &b.left) <= 0
        && up * signs.side(&[a.apex, a.right, b.apex], &b.right) >= 0
}
