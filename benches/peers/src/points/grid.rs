//! A uniform grid, hand-written and tuned for neighbours within one radius: points are sorted by cell, so that adjacent
//! cells in x are contiguous in memory; a run of them is tested sixteen points at a time, which the compiler
//! vectorises.

use super::entrants::{List, Lists, Radii};
use super::milliseconds;
use core::ops::Range;

/// Maximum number of cells of a dense grid: those of the paper's finest, 256 along each axis.
const DENSE: u64 = 1 << 24;

/// Points tested at a time.
const WIDTH: usize = 16;

/// How cells are looked up.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// In an array of all cells.
    Dense,
    /// In a hash table of the nonempty cells.
    Hashed,
}

enum Cells {
    /// The first point of each cell, and after the last the number of points.
    Dense(Vec<u32>),
    Hashed {
        /// Number of a cell plus one, or 0 if empty; the length is a power of two.
        table: Vec<u32>,
        keys: Vec<[u32; 3]>,
        starts: Vec<u32>,
    },
}

pub(crate) struct Grid {
    lower: [f32; 3],
    inverse: f32,
    /// Number of cells along each axis.
    count: [u32; 3],
    /// Widens the radius, so that rounding a cell's coordinates loses no point.
    slack: f32,
    cells: Cells,
    /// Coordinates and indices, cell by cell, padded for reads beyond the last.
    at: [Vec<f32>; 3],
    indices: Vec<u32>,
    points: usize,
}

fn hash([x, y, z]: [u32; 3]) -> usize {
    // Teschner et al., Optimized Spatial Hashing for Collision Detection of Deformable Objects, 2003.
    (x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791)) as usize
}

impl Grid {
    /// `None` if there would be too many cells.
    pub(crate) fn new(points: &[[f32; 3]], side: f32, kind: Kind) -> Option<Self> {
        let (mut lower, mut upper) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in points {
            for axis in 0..3 {
                lower[axis] = lower[axis].min(point[axis]);
                upper[axis] = upper[axis].max(point[axis]);
            }
        }
        let inverse = 1.0 / side;
        let counts: [f64; 3] = core::array::from_fn(|axis| {
            (f64::from(upper[axis]) - f64::from(lower[axis])) * f64::from(inverse) + 2.0
        });
        let most = if kind == Kind::Dense { DENSE as f64 } else { f64::INFINITY };
        if !inverse.is_finite() || counts.iter().any(|&c| c > 2e9) || counts.iter().product::<f64>() > most {
            return None;
        }
        let count = counts.map(|c| c as u32);
        let largest = lower.iter().chain(&upper).fold(0.0_f32, |m, x| m.max(x.abs()));
        let mut grid = Self {
            lower,
            inverse,
            count,
            slack: largest * 1e-6 + side * 1e-5,
            cells: Cells::Dense(Vec::new()),
            at: [const { Vec::new() }; 3],
            indices: Vec::new(),
            points: points.len(),
        };
        let (numbers, starts) = if kind == Kind::Dense {
            let numbers: Vec<u32> =
                points.iter().map(|&point| grid.number(grid.cell(point)) as u32).collect();
            let starts = starts(&numbers, count.iter().map(|&c| c as usize).product());
            (numbers, starts)
        } else {
            grid.hashed(points)
        };
        // Counting sort: `next` is the place of the next point of each cell.
        let mut next = starts.clone();
        for axis in &mut grid.at {
            axis.resize(points.len() + WIDTH, f32::NAN);
        }
        grid.indices.resize(points.len() + WIDTH, 0);
        for ((point, &cell), index) in points.iter().zip(&numbers).zip(0..) {
            let place = next[cell as usize] as usize;
            next[cell as usize] += 1;
            for (axis, &x) in grid.at.iter_mut().zip(point) {
                axis[place] = x;
            }
            grid.indices[place] = index;
        }
        match &mut grid.cells {
            Cells::Dense(of) => *of = starts,
            Cells::Hashed { starts: of, .. } => *of = starts,
        }
        Some(grid)
    }

    /// The cell of each point, and the first point of each cell. Nonempty cells are numbered in spatial order, for the
    /// caches.
    fn hashed(&mut self, points: &[[f32; 3]]) -> (Vec<u32>, Vec<u32>) {
        let mut table = vec![0_u32; (2 * points.len()).next_power_of_two()];
        let mask = table.len() - 1;
        let mut keys: Vec<[u32; 3]> = Vec::new();
        let mut numbers: Vec<u32> = Vec::with_capacity(points.len());
        for &point in points {
            let key = self.cell(point);
            let mut slot = hash(key) & mask;
            let number = loop {
                match table[slot] {
                    0 => {
                        keys.push(key);
                        table[slot] = keys.len() as u32;
                        break keys.len() as u32 - 1;
                    }
                    found if keys[found as usize - 1] == key => break found - 1,
                    _ => slot = (slot + 1) & mask,
                }
            };
            numbers.push(number);
        }
        let mut order: Vec<u32> = (0..keys.len() as u32).collect();
        order.sort_unstable_by_key(|&cell| {
            let [x, y, z] = keys[cell as usize];
            [z, y, x]
        });
        let mut rank = vec![0_u32; keys.len()];
        for (place, &cell) in order.iter().enumerate() {
            rank[cell as usize] = place as u32;
        }
        for slot in &mut table {
            if *slot != 0 {
                *slot = rank[*slot as usize - 1] + 1;
            }
        }
        for number in &mut numbers {
            *number = rank[*number as usize];
        }
        let keys: Vec<[u32; 3]> = order.iter().map(|&cell| keys[cell as usize]).collect();
        let starts = starts(&numbers, keys.len());
        self.cells = Cells::Hashed { table, keys, starts: Vec::new() };
        (numbers, starts)
    }

    /// The cell of a point. Monotone along each axis despite rounding; points beyond the grid are in its outermost
    /// cells.
    #[inline]
    fn cell(&self, point: [f32; 3]) -> [u32; 3] {
        core::array::from_fn(|axis| {
            let cell = ((point[axis] - self.lower[axis]) * self.inverse) as u32;
            cell.min(self.count[axis] - 1)
        })
    }

    #[inline]
    fn number(&self, [x, y, z]: [u32; 3]) -> usize {
        (z as usize * self.count[1] as usize + y as usize) * self.count[0] as usize + x as usize
    }

    /// Runs that together contain all points within the radius. `run` returns whether to go on.
    #[inline]
    fn near(&self, query: [f32; 3], radius: f32, mut run: impl FnMut(Range<usize>) -> bool) {
        let reach = radius * 1.000_01 + self.slack;
        let (first, last) = (self.cell(query.map(|x| x - reach)), self.cell(query.map(|x| x + reach)));
        match &self.cells {
            Cells::Dense(starts) => {
                for z in first[2]..=last[2] {
                    for y in first[1]..=last[1] {
                        let row = self.number([0, y, z]);
                        let from = starts[row + first[0] as usize] as usize;
                        let to = starts[row + last[0] as usize + 1] as usize;
                        if from < to && !run(from..to) {
                            return;
                        }
                    }
                }
            }
            Cells::Hashed { table, keys, starts } => {
                let wanted =
                    (0..3).map(|axis| u64::from(last[axis] - first[axis]) + 1).fold(1, u64::saturating_mul);
                let cell = |number: usize| starts[number] as usize..starts[number + 1] as usize;
                // If these are more cells than the grid has, visit every cell.
                if wanted > keys.len() as u64 {
                    for (number, key) in keys.iter().enumerate() {
                        if (0..3).all(|axis| first[axis] <= key[axis] && key[axis] <= last[axis])
                            && !run(cell(number))
                        {
                            return;
                        }
                    }
                    return;
                }
                let mask = table.len() - 1;
                for z in first[2]..=last[2] {
                    for y in first[1]..=last[1] {
                        for x in first[0]..=last[0] {
                            let mut slot = hash([x, y, z]) & mask;
                            while table[slot] != 0 {
                                let number = table[slot] as usize - 1;
                                if keys[number] == [x, y, z] {
                                    if !run(cell(number)) {
                                        return;
                                    }
                                    break;
                                }
                                slot = (slot + 1) & mask;
                            }
                        }
                    }
                }
            }
        }
    }

    /// Squared distances of [`WIDTH`] points, rounded as in simdop.
    #[inline]
    fn squares(&self, query: [f32; 3], from: usize) -> [f32; WIDTH] {
        let mut squares = [0.0; WIDTH];
        let [x, y, z] = self.at.each_ref().map(|axis| &axis[from..from + WIDTH]);
        for lane in 0..WIDTH {
            let d = [x[lane] - query[0], y[lane] - query[1], z[lane] - query[2]];
            squares[lane] = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2];
        }
        squares
    }

    /// The grid's own points as queries, in the order of the cells.
    fn own(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        (0..self.points).map(|place| (self.indices[place], self.at.each_ref().map(|axis| axis[place])))
    }

    pub(crate) fn count_one(&self, query: [f32; 3], radius: f32) -> u32 {
        let (square, mut found) = (radius * radius, 0);
        self.near(query, radius, |run| {
            let mut from = run.start;
            while from < run.end {
                let (squares, left) = (self.squares(query, from), run.end - from);
                for (lane, d) in squares.into_iter().enumerate() {
                    found += u32::from((d <= square) & (lane < left));
                }
                from += WIDTH;
            }
            true
        });
        found
    }

    pub(crate) fn count(&self, radii: &Radii, counts: &mut [u32]) {
        for (index, query) in self.own() {
            counts[index as usize] = self.count_one(query, radii.of(index));
        }
    }

    pub(crate) fn fill(&self, radii: &Radii, lists: &mut Lists) {
        let mut end = 0;
        for (index, query) in self.own() {
            let (start, radius) = (end, radii.of(index));
            let square = radius * radius;
            self.near(query, radius, |run| {
                let mut from = run.start;
                while from < run.end {
                    let (squares, left) = (self.squares(query, from), run.end - from);
                    let indices = &self.indices[from..from + WIDTH];
                    // Writes every point; the next one overwrites it unless it is a neighbour.
                    if let Some(room) = lists.indices.get_mut(end..end + WIDTH) {
                        let mut taken = 0;
                        for lane in 0..WIDTH {
                            room[taken & (WIDTH - 1)] = indices[lane];
                            taken += usize::from((squares[lane] <= square) & (lane < left));
                        }
                        end += taken;
                    } else {
                        for lane in 0..WIDTH.min(left) {
                            if squares[lane] <= square {
                                lists.indices[end] = indices[lane];
                                end += 1;
                            }
                        }
                    }
                    from += WIDTH;
                }
                true
            });
            lists.lists[index as usize] = List { start: start as u32, count: (end - start) as u32 };
        }
    }

    pub(crate) fn any_within(&self, query: [f32; 3], radius: f32) -> bool {
        let (square, mut found) = (radius * radius, false);
        self.near(query, radius, |run| {
            let mut from = run.start;
            while from < run.end && !found {
                let (squares, left) = (self.squares(query, from), run.end - from);
                for (lane, d) in squares.into_iter().enumerate() {
                    found |= (d <= square) & (lane < left);
                }
                from += WIDTH;
            }
            !found
        });
        found
    }
}

/// The first item of each number, and after the last the number of items.
fn starts(numbers: &[u32], count: usize) -> Vec<u32> {
    let mut starts = vec![0_u32; count + 1];
    for &number in numbers {
        starts[number as usize + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    starts
}

/// The fastest cell side for these radii, found by trials: multiples of the largest radius, of the median and of the
/// smallest, and of the side of a cube with two points on average, each on some of the queries. `None` if no grid of
/// the kind fits.
pub(crate) fn best_side(points: &[[f32; 3]], radii: &Radii, kind: Kind) -> Option<f32> {
    let mut sorted: Vec<f32> = (0..points.len() as u32).map(|i| radii.of(i)).collect();
    sorted.sort_by(f32::total_cmp);
    let mut sides = Vec::new();
    for radius in [sorted[sorted.len() - 1], sorted[sorted.len() / 2], sorted[0]] {
        sides.extend([1.0, 0.5, 0.34, 2.0, 4.0, 8.0, 32.0].map(|share| share * radius));
    }
    let extent = |axis: usize| {
        let x = || points.iter().map(|point| point[axis]);
        x().fold(f32::NEG_INFINITY, f32::max) - x().fold(f32::INFINITY, f32::min)
    };
    let volume: f32 = (0..3).map(|axis| extent(axis).max(1e-6)).product();
    sides.extend([1.0, 2.0, 8.0].map(|share: f32| (share * volume / points.len() as f32).cbrt()));
    // 256 along the longest axis, as in the paper.
    sides.push((0..3).map(extent).fold(0.0, f32::max) / 250.0);
    sides.retain(|&side| side > 0.0 && side.is_finite());
    sides.sort_by(f32::total_cmp);
    sides.dedup();
    let time = |&side: &f32| {
        let grid = Grid::new(points, side, kind)?;
        // Runs of neighbouring queries, as in a whole pass.
        let runs = 16_usize;
        let (each, step) = ((points.len() / runs).clamp(1, 64), (points.len() / runs).max(1));
        let mut least = f64::INFINITY;
        for _ in 0..2 {
            let ms = milliseconds(|| {
                for place in
                    (0..points.len()).step_by(step).flat_map(|from| from..(from + each).min(points.len()))
                {
                    let query = grid.at.each_ref().map(|axis| axis[place]);
                    std::hint::black_box(grid.count_one(query, radii.of(grid.indices[place])));
                }
            });
            least = least.min(ms);
            if least > 500.0 {
                break;
            }
        }
        Some((side, least))
    };
    let timed = sides.iter().filter_map(time);
    Some(timed.min_by(|a, b| a.1.total_cmp(&b.1))?.0)
}
