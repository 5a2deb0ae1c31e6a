//! A clearance grid: for each cell, bounds of the distance from its centre to everything that stands still.
//!
//! A cell has one byte k. In units of an eighth of the cell, the distance from its centre is at least k. It is at most
//! `k + 1` plus [`ClearanceGrid::above`], if that is less than the greatest radius of an inner sphere. The distance is
//! 1-Lipschitz: at a point that is x from the centre, it differs by at most x. So a sphere of radius r about that point
//! is free if `k / 8 - r > x`, and meets something if `r - (k + 1) / 8 - above > x`, in units of the cell.
//!
//! The grid is computed by halving boxes of cells, with a distance query at the centre of each box. If the distance is
//! at least four times half the diagonal of the box, or exceeds the largest sphere, the cells of the box need no
//! queries of their own. A query skips the bodies that are not the nearest anywhere in the box. If few are left and all
//! are simple shapes, closed forms give the distances of all cells ([`super::rows`]).
//!
//! **Rounding.** A point in units of cells is off by less than 3 u of at most 512 cells, with u = 2^-24, and so is its
//! offset from the centre; products and comparisons add a few u. The total is below 2^-11 cells, and every radius is
//! changed by twice that ([`ROUNDING`]).

use super::lanes::{Flags, LANES, Lane16, Point16, flag};
use super::standing::{CandidateRange, Standing};
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::range::Point;
use crate::scene::SceneError;
use crate::vector::{difference, length, sqrt};
use alloc::vec;
use alloc::vec::Vec;

/// Allowance for roundings, in cells.
const ROUNDING: f64 = power_of_two(-10);
/// Parts of a cell in which distances are stored.
const PARTS: f64 = 8.0;
/// Largest number of cells along an axis.
const MOST_ALONG: usize = 511;
/// Largest number of cells.
pub(super) const MOST_CELLS: f64 = power_of_two(22);
/// Distance from which a box of cells is not divided, relative to half of its diagonal.
const FAR: f64 = 4.0;
/// Cells times bodies of a box that is not divided.
const FEW: usize = 4096;
/// Distances at a time.
const ROW: usize = 64;
/// Adding it rounds a number below 2^22 to an integer, in the lowest bits.
const ROUND: f32 = 8_388_608.0;

/// The parameters of a grid.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct GridSize {
    /// Minimum width of a cell.
    pub(super) cell: f64,
    /// Radius of the largest outer sphere.
    pub(super) outer: f64,
    /// Radius of the largest inner sphere.
    pub(super) inner: f64,
}

/// For each body of a robot: a grid around it in the frame of its link, and the body's pose in that frame. None for a
/// body in no tested pair.
pub(super) type LinkGrids = Vec<Option<(ClearanceGrid, Pose)>>;

/// Bounds of distances, for all cells of a box.
#[derive(Clone, Debug)]
pub(super) struct ClearanceGrid {
    /// The centre of the first cell.
    first: [f32; 3],
    cell: f64,
    per_cell: f32,
    count: [usize; 3],
    cells: Vec<u8>,
    size: GridSize,
    /// How much a distance may exceed the byte's upper bound, in the unit of length.
    above: f64,
}

impl ClearanceGrid {
    /// A grid over the box between two corners. Outside the box, no sphere meets anything.
    pub(super) fn new(
        standing: &mut Standing,
        [low, high]: [Point; 2],
        size: GridSize,
    ) -> Result<Self, SceneError> {
        let sides = difference(&high, &low).map(|x| x.max(size.cell));
        let volume = sides[0] * sides[1] * sides[2];
        let least =
            libm::cbrt(volume / MOST_CELLS).max(sides.iter().fold(0.0, |most: f64, x| most.max(*x)) / 500.0);
        let per_cell = (1.0 / size.cell.max(1.01 * least)) as f32;
        let cell = 1.0 / f64::from(per_cell);
        let count = sides.map(|x| (libm::ceil(x / cell) as usize + 1).min(MOST_ALONG));
        let mut grid = Self {
            first: low.map(|x| x as f32),
            cell,
            per_cell,
            count,
            cells: vec![0; count[0] * count[1] * count[2]],
            size,
            above: 0.0,
        };
        let all = standing.all();
        grid.refine(standing, all, [[0; 3], count])?;
        Ok(grid)
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.len()
    }

    pub(super) const fn size(&self) -> &GridSize {
        &self.size
    }

    /// Whether the grid contains the box between two corners.
    pub(super) fn holds(&self, [low, high]: &[Point; 2]) -> bool {
        (0..3).all(|i| {
            let first = f64::from(self.first[i]);
            let last = first + self.cell * (self.count[i] - 1) as f64;
            first - 0.5 * self.cell <= low[i] && high[i] <= last + 0.5 * self.cell
        })
    }

    /// Recomputes the cells between two corners, and those from which a sphere reaches there.
    pub(super) fn update(
        &mut self,
        standing: &mut Standing,
        [low, high]: &[Point; 2],
    ) -> Result<(), SceneError> {
        let reach = self.size.outer + 2.0 * self.cell;
        let index = |x: f64, i: usize| {
            let at = (x - f64::from(self.first[i])) / self.cell;
            at.clamp(0.0, self.count[i] as f64) as usize
        };
        let from = [0, 1, 2].map(|i| index(low[i] - reach, i));
        let to = [0, 1, 2].map(|i| (index(high[i] + reach, i) + 1).min(self.count[i]));
        if (0..3).all(|i| from[i] < to[i]) {
            let all = standing.all();
            self.refine(standing, all, [from, to])?;
        }
        Ok(())
    }

    /// The centre of a cell, or the middle of several.
    fn centre(&self, doubled: [usize; 3]) -> Point {
        [0, 1, 2].map(|i| f64::from(self.first[i]) + self.cell * (0.5 * doubled[i] as f64))
    }

    /// Computes the cells of a box. `among`: the bodies that may be nearest to the centre of a cell of it.
    fn refine(
        &mut self,
        standing: &mut Standing,
        among: CandidateRange,
        [from, to]: [[usize; 3]; 2],
    ) -> Result<(), SceneError> {
        let width = [0, 1, 2].map(|i| to[i] - from[i]);
        let centre = self.centre([0, 1, 2].map(|i| from[i] + to[i] - 1));
        // Half of the diagonal of the box of cell centres.
        let half = 0.5 * self.cell * length(&width.map(|x| (x - 1) as f64));
        let widest = (1..3).fold(0, |most, i| if width[i] > width[most] { i } else { most });
        let cutoff = self.size.outer + half + self.cell;
        let ([lower, upper], near) = standing.distance(&centre, cutoff, among, half)?;
        let is_far = lower - half >= self.size.inner + self.cell && lower >= FAR * half;
        if width[widest] == 1 || is_far || lower - half >= self.size.outer {
            self.fill([from, to], &centre, [lower, upper]);
            return Ok(());
        }
        if width[0] * width[1] * width[2] * near.count() <= FEW
            && let Some(error) = standing.simple(near, &centre, half)
        {
            self.fill_rows([from, to], standing, near, error);
            return Ok(());
        }
        let (mut middle, mut next) = (to, from);
        middle[widest] = from[widest] + width[widest] / 2;
        next[widest] = middle[widest];
        self.refine(standing, near, [from, middle])?;
        self.refine(standing, near, [next, to])
    }

    /// The length that a byte counts, and the greatest byte.
    fn levels(&self) -> (f64, f64) {
        let unit = self.cell / PARTS;
        (unit, (self.size.outer / unit).min(255.0))
    }

    /// Sets a cell whose distance has these bounds.
    #[inline(always)]
    fn set(&mut self, index: usize, [lower, upper]: [f64; 2], (unit, most): (f64, f64)) {
        let k = (lower / unit - ROUNDING).clamp(0.0, most) as u8;
        self.cells[index] = k;
        // Also if the distance is beyond the greatest byte.
        if f64::from(k) * unit <= self.size.inner {
            self.above = self.above.max(upper - (f64::from(k) + 1.0) * unit);
        }
    }

    /// The cells of a box, near to simple shapes only.
    fn fill_rows(
        &mut self,
        [from, to]: [[usize; 3]; 2],
        standing: &Standing,
        near: CandidateRange,
        error: f64,
    ) {
        let levels = self.levels();
        let mut distances = [0.0; ROW];
        for x in from[0]..to[0] {
            for y in from[1]..to[1] {
                let row = (x * self.count[1] + y) * self.count[2];
                for first in (from[2]..to[2]).step_by(ROW) {
                    let distances = &mut distances[..(to[2] - first).min(ROW)];
                    standing.row(near, &self.centre([x, y, first].map(|i| 2 * i)), self.cell, distances);
                    for (z, distance) in distances.iter().enumerate() {
                        self.set(row + first + z, [distance - error, distance + error], levels);
                    }
                }
            }
        }
    }

    /// The cells of a box whose centre has these bounds.
    fn fill(&mut self, [from, to]: [[usize; 3]; 2], centre: &Point, [lower, upper]: [f64; 2]) {
        let levels = self.levels();
        let (start, width) = (self.first, self.cell);
        let square = |i: usize, cell: usize| {
            let off = f64::from(start[i]) + width * cell as f64 - centre[i];
            off * off
        };
        for x in from[0]..to[0] {
            for y in from[1]..to[1] {
                let beside = square(0, x) + square(1, y);
                let row = (x * self.count[1] + y) * self.count[2];
                for z in from[2]..to[2] {
                    let away = sqrt(beside + square(2, z));
                    self.set(row + z, [lower - away, upper + away], levels);
                }
            }
        }
    }

    /// The radii in cells of an outer and an inner sphere, rounded so that look-ups are certain. The inner one is
    /// negative if it is too small for a certain hit.
    pub(super) fn radii(&self, outer: f64, inner: f64) -> [f32; 2] {
        // The upper bounds hold up to the largest inner sphere that the grid supports.
        let inner = (inner.min(self.size.inner) - self.above) / self.cell - (1.0 / PARTS + ROUNDING);
        let outer = (outer / self.cell + ROUNDING) * (1.0 + power_of_two(-22));
        [outer as f32, if inner > 0.0 { (inner * (1.0 - power_of_two(-22))) as f32 } else { -1.0 }]
    }

    /// How much an outer sphere may be enlarged.
    pub(super) fn room(&self, outer: f64) -> f32 {
        ((self.size.outer - outer) * (1.0 - power_of_two(-22))) as f32
    }

    /// A length in cells.
    #[inline(always)]
    pub(super) fn in_cells(&self, length: f32) -> f32 {
        length * self.per_cell * (1.0 + power_of_two(-20) as f32)
    }

    /// Which of sixteen spheres are certainly free, and which certainly meet something.
    #[inline(always)]
    pub(super) fn look_up(&self, p: &Point16, [outer, inner]: &[Lane16; 2]) -> [Flags; 2] {
        let (mut index, mut square, mut outside) = ([0_u32; LANES], [0.0_f32; LANES], [0_u32; LANES]);
        for (axis, p) in p.iter().enumerate() {
            let (first, count) = (self.first[axis], self.count[axis]);
            let (last, stride) = ((count - 1) as f32, count as u32);
            for lane in 0..LANES {
                let h = (p[lane] - first) * self.per_cell;
                // False for NaN.
                let is_inside = (h >= -0.5) & (h <= last + 0.5);
                outside[lane] |= flag(lane, !is_inside);
                let held = if h > 0.0 { h } else { 0.0 };
                let held = if held < last { held } else { last };
                let rounded = held + ROUND;
                let off = h - (rounded - ROUND);
                square[lane] += off * off;
                index[lane] = index[lane] * stride + (rounded.to_bits() & 0x7f_ffff);
            }
        }
        let mut level: Lane16 = [0.0; LANES];
        for lane in 0..LANES {
            level[lane] = f32::from(self.cells.get(index[lane] as usize).copied().unwrap_or(0));
        }
        let [mut free, mut hit] = [[0_u32; LANES]; 2];
        for lane in 0..LANES {
            let level = level[lane] * (1.0 / PARTS as f32);
            let (apart, inside) = (level - outer[lane], inner[lane] - level);
            let is_free = (apart > 0.0) & (apart * apart > square[lane]);
            let is_hit = (inside > 0.0) & (inside * inside > square[lane]);
            free[lane] = flag(lane, is_free) | outside[lane];
            hit[lane] = flag(lane, is_hit) & !outside[lane];
        }
        [free, hit]
    }
}
