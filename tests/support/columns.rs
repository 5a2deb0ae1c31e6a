//! The volume of solids and of their intersection, independent of the library: a sum over the lines of a grid,
//! each of which stands for a column around it. It is a voxel grid that is continuous in one direction.

use simdop::primitive::Sphere;

/// Lines parallel to the z axis through the centres of a rectangle's cells.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Columns {
    low: [f64; 2],
    cell: [f64; 2],
    side: usize,
}

/// For each line its intervals inside the solid, in order.
pub(crate) struct Spans(Vec<Vec<[f64; 2]>>);

type Triangle = [[f64; 3]; 3];

impl Columns {
    /// `side` by `side` lines through the intersection of two boxes, each given by its lowest and highest
    /// corners. `None` if the intersection is empty.
    pub(crate) fn through([a, b]: [([f64; 3], [f64; 3]); 2], side: usize) -> Option<Self> {
        let low: [f64; 3] = core::array::from_fn(|i| a.0[i].max(b.0[i]));
        let high: [f64; 3] = core::array::from_fn(|i| a.1[i].min(b.1[i]));
        let cell = [0, 1].map(|i| (high[i] - low[i]) / side as f64);
        (0..3).all(|i| low[i] < high[i]).then_some(Self { low: [low[0], low[1]], cell, side })
    }

    fn at(&self, axis: usize, i: usize) -> f64 {
        self.low[axis] + (i as f64 + 0.5) * self.cell[axis]
    }

    /// A range with all lines between two coordinates, and perhaps one more on either side.
    fn around(&self, axis: usize, from: f64, to: f64) -> core::ops::Range<usize> {
        let place = |x: f64| (x - self.low[axis]) / self.cell[axis];
        // The cast changes negative numbers to zero.
        let first = (place(from) - 1.0) as usize;
        first..((place(to) + 1.0) as usize).min(self.side)
    }

    /// A point of a line is inside a closed surface if the line has crossed the surface an odd number of times
    /// before.
    ///
    /// The total number of crossings of a line is even, whatever rounding does. A line of constant y meets two
    /// edges of a triangle or none. The intersection with an edge is computed from the edge alone, with its
    /// ends in a fixed order, and so is the same for both triangles of the edge: the left end of one triangle's
    /// interval is the right end of the other's.
    pub(crate) fn of_surface(&self, triangles: &[Triangle]) -> Spans {
        let mut crossings = vec![Vec::new(); self.side * self.side];
        for t in triangles {
            let y = t.map(|p| p[1]);
            for j in self.around(1, y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2])) {
                let y = self.at(1, j);
                let met: Vec<[f64; 2]> =
                    (0..3).filter_map(|i| place_on_edge(t[i], t[(i + 1) % 3], y)).collect();
                let [p, q] = met[..] else { continue };
                for i in self.around(0, p[0].min(q[0]), p[0].max(q[0])) {
                    let x = self.at(0, i);
                    if (p[0] > x) != (q[0] > x) {
                        let share = (x - p[0]) / (q[0] - p[0]);
                        crossings[j * self.side + i].push(p[1] + share * (q[1] - p[1]));
                    }
                }
            }
        }
        Spans(crossings.into_iter().map(pairs).collect())
    }

    /// The columns of spheres that do not overlap.
    pub(crate) fn of_spheres(&self, spheres: &[Sphere]) -> Spans {
        let mut spans = vec![Vec::new(); self.side * self.side];
        for Sphere { centre: [x, y, z], radius } in spheres {
            for j in self.around(1, y - radius, y + radius) {
                for i in self.around(0, x - radius, x + radius) {
                    let (u, v) = (self.at(0, i) - x, self.at(1, j) - y);
                    let square = radius * radius - (u * u + v * v);
                    if square > 0.0 {
                        spans[j * self.side + i].extend([z - square.sqrt(), z + square.sqrt()]);
                    }
                }
            }
        }
        Spans(spans.into_iter().map(pairs).collect())
    }

    /// The volume of the intersection.
    pub(crate) fn common(&self, a: &Spans, b: &Spans) -> f64 {
        let line = |(a, b): (&Vec<[f64; 2]>, &Vec<[f64; 2]>)| {
            let (mut i, mut j, mut length) = (0, 0, 0.0);
            while i < a.len() && j < b.len() {
                length += (a[i][1].min(b[j][1]) - a[i][0].max(b[j][0])).max(0.0);
                // The interval that ends first meets nothing more.
                if a[i][1] < b[j][1] { i += 1 } else { j += 1 }
            }
            length
        };
        a.0.iter().zip(&b.0).map(line).sum::<f64>() * (self.cell[0] * self.cell[1])
    }
}

/// x and z where an edge crosses this y, if it does.
fn place_on_edge(p: [f64; 3], q: [f64; 3], y: f64) -> Option<[f64; 2]> {
    let [p, q] = if p < q { [p, q] } else { [q, p] };
    ((p[1] > y) != (q[1] > y)).then(|| {
        let share = (y - p[1]) / (q[1] - p[1]);
        [0, 2].map(|i| p[i] + share * (q[i] - p[i]))
    })
}

fn pairs(mut places: Vec<f64>) -> Vec<[f64; 2]> {
    places.sort_by(f64::total_cmp);
    let (pairs, rest) = places.as_chunks();
    assert!(rest.is_empty(), "a line leaves what it enters: {places:?}");
    pairs.to_vec()
}
