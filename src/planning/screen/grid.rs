//! A clearance grid: for each cell, bounds of the distance from its centre to everything that stands still.
//!
//! A cell has one byte k. In units of an eighth of the cell, the distance from its centre is at least k. It is at most
//! `k + 1` plus what [`ClearanceGrid::above`] says, where that is less than the greatest radius of an inner sphere. The
//! distance is 1-Lipschitz: at a point that is x from the centre, it differs by at most x. So a sphere of radius r about
//! that point is free if `k / 8 - r > x`, and meets something if `r - (k + 1) / 8 - above > x`, in units of the cell.
//!
//! Cells are made by halving: a box of cells is asked at its centre. Where the distance is four times half the diagonal
//! of the box, or beyond the largest sphere, the cells of the box need no question of their own.
//!
//! **Rounding.** A point in units of cells is off by less than 3 u of at most 512 cells, u being 2^-24, and so is its
//! offset from the centre; products and comparisons add a few u. All of it is below 2^-11 cells, which every radius is
//! changed by ([`ROUNDING`]).

use super::lanes::{Flags, LANES, Lane16, Point16, flag};
use super::standing::Standing;
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::range::Point;
use crate::scene::SceneError;
use crate::vector::{difference, length};
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
/// Distance at which a box of cells is not divided, relative to half of its diagonal.
const FAR: f64 = 4.0;
/// Adding it rounds a number below 2^22 to an integer, in the lowest bits.
const ROUND: f32 = 8_388_608.0;

/// What a grid is made for.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct GridSize {
    /// Width of a cell, at least.
    pub(super) cell: f64,
    /// Radius of the largest outer sphere.
    pub(super) outer: f64,
    /// Radius of the largest inner sphere.
    pub(super) inner: f64,
}

/// For each body of a robot: a grid around it in the frame of its link, and where the body is in that; none around a body
/// that no other may meet.
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
    /// How much a distance may exceed that of the byte, in the unit of length.
    above: f64,
}

impl ClearanceGrid {
    /// Around everything between two corners. Outside of them, no sphere meets anything.
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
        grid.refine(standing, [0; 3], count)?;
        Ok(grid)
    }

    pub(super) fn bytes(&self) -> usize {
        self.cells.len()
    }

    pub(super) const fn size(&self) -> &GridSize {
        &self.size
    }

    /// Whether it has all cells between two corners.
    pub(super) fn holds(&self, [low, high]: &[Point; 2]) -> bool {
        (0..3).all(|i| {
            let first = f64::from(self.first[i]);
            let last = first + self.cell * (self.count[i] - 1) as f64;
            first - 0.5 * self.cell <= low[i] && high[i] <= last + 0.5 * self.cell
        })
    }

    /// Computes the cells between two corners again, and those near enough for a sphere to reach there.
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
        if (0..3).all(|i| from[i] < to[i]) { self.refine(standing, from, to) } else { Ok(()) }
    }

    /// The centre of a cell, or the middle of several.
    fn centre(&self, doubled: [usize; 3]) -> Point {
        [0, 1, 2].map(|i| f64::from(self.first[i]) + self.cell * (0.5 * doubled[i] as f64))
    }

    fn refine(
        &mut self,
        standing: &mut Standing,
        from: [usize; 3],
        to: [usize; 3],
    ) -> Result<(), SceneError> {
        let width = [0, 1, 2].map(|i| to[i] - from[i]);
        let centre = self.centre([0, 1, 2].map(|i| from[i] + to[i] - 1));
        // Of the centres of the cells.
        let half = 0.5 * self.cell * length(&width.map(|x| (x - 1) as f64));
        let widest = (1..3).fold(0, |most, i| if width[i] > width[most] { i } else { most });
        let [lower, upper] = standing.distance(&centre, self.size.outer + half + self.cell)?;
        let is_far = lower - half >= self.size.inner + self.cell && lower >= FAR * half;
        if width[widest] == 1 || is_far || lower - half >= self.size.outer {
            self.fill(from, to, &centre, [lower, upper]);
            return Ok(());
        }
        let (mut middle, mut next) = (to, from);
        middle[widest] = from[widest] + width[widest] / 2;
        next[widest] = middle[widest];
        self.refine(standing, from, middle)?;
        self.refine(standing, next, to)
    }

    fn fill(&mut self, from: [usize; 3], to: [usize; 3], centre: &Point, [lower, upper]: [f64; 2]) {
        let unit = self.cell / PARTS;
        let most = (self.size.outer / unit).min(255.0);
        for x in from[0]..to[0] {
            for y in from[1]..to[1] {
                for z in from[2]..to[2] {
                    let away = length(&difference(&self.centre([x, y, z].map(|i| 2 * i)), centre));
                    let k = ((lower - away) / unit - ROUNDING).clamp(0.0, most) as u8;
                    self.cells[(x * self.count[1] + y) * self.count[2] + z] = k;
                    if f64::from(k) * unit <= self.size.inner {
                        self.above = self.above.max(upper + away - f64::from(k + 1) * unit);
                    }
                }
            }
        }
    }

    /// The radii of a sphere in cells: of the outer one, which holds all, and of the inner one, negative if nothing meets
    /// it for certain.
    pub(super) fn radii(&self, outer: f64, inner: f64) -> [f32; 2] {
        // Upper bounds hold up to the largest inner sphere that the grid is made for.
        let inner = (inner.min(self.size.inner) - self.above) / self.cell - (1.0 / PARTS + ROUNDING);
        let outer = (outer / self.cell + ROUNDING) * (1.0 + power_of_two(-22));
        [outer as f32, if inner > 0.0 { (inner * (1.0 - power_of_two(-22))) as f32 } else { -1.0 }]
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
