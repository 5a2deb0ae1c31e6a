//! Winding numbers in exact arithmetic.

use crate::support::dyadic::sign_of_determinant;
use crate::support::exact::meshes_meet;
use crate::support::rng::Rng;
use alloc::collections::BTreeMap;
use simdop::range::Point;

pub(super) type Triangle = [Point; 3];

pub(super) const Z: [&Point; 2] = [&[0.0, 0.0, 1.0], &[0.0; 3]];

/// The side of the line through p and q, seen along z, that r is on.
pub(super) fn turn(p: &Point, q: &Point, r: &Point) -> i32 {
    let product = |i: usize, j: usize| (p[i] - r[i]) * (q[j] - r[j]);
    let (one, other) = (product(0, 1), product(1, 0));
    if (one - other).abs() > 8.0 * f64::EPSILON * (one.abs() + other.abs()) && one - other != 0.0 {
        return if one > other { 1 } else { -1 };
    }
    sign_of_determinant(r, p, q, Z)
}

/// The side of a triangle's plane that a point is on: 1 where its normal points away from the point.
pub(super) fn side([a, b, c]: &Triangle, p: &Point) -> i32 {
    let [u, v, w] = [a, b, c].map(|q| [q[0] - p[0], q[1] - p[1], q[2] - p[2]]);
    let mut size = 0.0;
    let minor = |i: usize, j: usize| {
        let (one, other) = (v[i] * w[j], v[j] * w[i]);
        (one - other, one.abs() + other.abs())
    };
    let mut sum = 0.0;
    for (x, (value, magnitude)) in [(u[0], minor(1, 2)), (u[1], minor(2, 0)), (u[2], minor(0, 1))] {
        sum += x * value;
        size += x.abs() * magnitude;
    }
    if sum.abs() > 64.0 * f64::EPSILON * size && sum != 0.0 {
        return if sum > 0.0 { 1 } else { -1 };
    }
    sign_of_determinant(p, a, b, [c, p])
}

/// The position of a point relative to a body.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Place {
    OnSurface,
    Around(i32),
}

impl Place {
    /// A point on a triangle or a cap is in the body, like one inside.
    pub(super) fn is_in(self) -> bool {
        self != Self::Around(0)
    }
}

/// A closed mesh: its triangles, by the grid cells that they cover in the projection along z.
pub(super) struct Oracle {
    pub(super) triangles: Vec<Triangle>,
    low: [f64; 2],
    cell: [f64; 2],
    cells: Vec<Vec<u32>>,
}

pub(super) const CELLS: usize = 64;

impl Oracle {
    pub(super) fn new(triangles: Vec<Triangle>) -> Self {
        let all = || triangles.iter().flatten();
        let low = [0, 1].map(|i| all().fold(f64::INFINITY, |low, p| low.min(p[i])));
        let high = [0, 1].map(|i| all().fold(f64::NEG_INFINITY, |high, p| high.max(p[i])));
        let cell = [0, 1].map(|i| (high[i] - low[i]) / CELLS as f64);
        let mut oracle = Self { triangles: Vec::new(), low, cell, cells: vec![Vec::new(); CELLS * CELLS] };
        for (index, t) in (0..).zip(&triangles) {
            let ends = [0, 1].map(|i| {
                let ends = [t[0][i], t[1][i], t[2][i]];
                [f64::min, f64::max].map(|f| oracle.column(i, ends.into_iter().reduce(f).unwrap()))
            });
            for x in ends[0][0]..=ends[0][1] {
                for y in ends[1][0]..=ends[1][1] {
                    oracle.cells[x * CELLS + y].push(index);
                }
            }
        }
        oracle.triangles = triangles;
        oracle
    }

    /// The column of a point. Monotone, so that a point below or above a triangle is in a column that the triangle
    /// covers.
    pub(super) fn column(&self, i: usize, x: f64) -> usize {
        (((x - self.low[i]) / self.cell[i]) as usize).min(CELLS - 1)
    }

    pub(super) fn place(&self, p: &Point, rng: &mut Rng) -> Place {
        let mut winding = 0;
        for &index in &self.cells[self.column(0, p[0]) * CELLS + self.column(1, p[1])] {
            let t = &self.triangles[index as usize];
            let turns = [0, 1, 2].map(|i| turn(&t[i], &t[(i + 1) % 3], p));
            match turns {
                [1, 1, 1] | [-1, -1, -1] => match side(t, p) {
                    0 => return Place::OnSurface,
                    side => winding += if side == turns[0] { side } else { 0 },
                },
                _ if turns.contains(&1) && turns.contains(&-1) => {}
                _ => return self.place_by_others(p, rng),
            }
        }
        Place::Around(winding)
    }

    /// The winding number along rays in random directions, for points whose ray along z passes an edge.
    pub(super) fn place_by_others(&self, p: &Point, rng: &mut Rng) -> Place {
        let is_on = |t: &Triangle| meshes_meet(&[[*p; 3]], &[*t]);
        if self.triangles.iter().any(is_on) {
            return Place::OnSurface;
        }
        let crossed = |t: &Triangle, d: &Point| -> Option<i32> {
            let [a, b, c] = t;
            let sides = [[a, b], [b, c], [c, a]].map(|[q, r]| sign_of_determinant(p, q, r, [d, &[0.0; 3]]));
            match sides {
                [1, 1, 1] | [-1, -1, -1] => {
                    let ahead = sign_of_determinant(a, b, c, [a, p]);
                    Some(if ahead == sides[0] { ahead } else { 0 })
                }
                _ if sides.contains(&1) && sides.contains(&-1) => Some(0),
                _ => Some(0).filter(|_| has_no_area(t)),
            }
        };
        for _ in 0..100 {
            let d = [(); 3].map(|()| rng.int(-1_000_000, 1_000_000) as f64);
            if let Some(sum) = self.triangles.iter().map(|t| crossed(t, &d)).sum::<Option<i32>>() {
                return Place::Around(sum);
            }
        }
        panic!("no ray misses all edges");
    }
}

pub(super) fn has_no_area([a, b, c]: &Triangle) -> bool {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    axes.iter().all(|axis| sign_of_determinant(a, b, c, [axis, &[0.0; 3]]) == 0)
}

/// Whether as many triangles run along each edge in one direction as in the other.
pub(super) fn is_closed(triangles: &[Triangle]) -> bool {
    let key = |p: &Point| p.map(|x| (x + 0.0).to_bits());
    let mut edges = BTreeMap::<_, i32>::new();
    for t in triangles {
        for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (key(&t[i]), key(&t[j]))) {
            *edges.entry([p.min(q), p.max(q)]).or_default() += i32::from(p < q) - i32::from(q < p);
        }
    }
    edges.values().all(|sum| *sum == 0)
}
