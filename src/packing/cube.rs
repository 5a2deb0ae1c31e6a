//! Cubes of candidate centres, and their priority queue.

use super::ascent::{Clearance, Spot};
use super::grid::{Ball, Placed};
use super::surface::Surface;
use alloc::vec::Vec;
use glam::DVec3;

/// A cube of candidate centres.
#[derive(Copy, Clone, Debug)]
pub(super) struct Cube {
    /// Upper bound of the clearance in the cube.
    pub(super) bound: f64,
    pub(super) centre: DVec3,
    /// Half the edge length.
    pub(super) half: f64,
    /// Clearance of the centre when `seen` spheres were placed. Negative inside spheres and outside the mesh.
    pub(super) clearance: f64,
    /// Depth of the centre below the surface; negative outside.
    depth: f64,
    /// The triangle nearest to the centre.
    triangle: u32,
    seen: u32,
}

/// Pending cubes by bound, in bins with a width of a sixteenth of a power of two. The order within a bin does not
/// matter, and a heap would take a third of the run time.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// The code of bounds that are too small.
    least: usize,
    /// The bins above that. The last one is never empty.
    bins: Vec<Vec<Cube>>,
}

impl Queue {
    /// A queue with the cube around a mesh.
    pub(super) fn of(whole: Cube) -> Self {
        let mut queue = Self { least: Self::code((LEAST * whole.half).max(ROUGH)), bins: Vec::new() };
        queue.push(whole);
        queue
    }

    /// Adds a cube, unless its bound is too small.
    pub(super) fn push(&mut self, cube: Cube) {
        // The sign bit would give a negative number a large code.
        if cube.bound > 0.0
            && let Some(bin) = Self::code(cube.bound).checked_sub(self.least)
        {
            if bin >= self.bins.len() {
                self.bins.resize_with(bin + 1, Vec::new);
            }
            self.bins[bin].push(cube);
        }
    }

    /// An upper bound of all bounds, by less than a sixteenth; 0 if the queue is empty.
    pub(super) fn bound(&self) -> f64 {
        if self.bins.is_empty() { 0.0 } else { self.least_of(self.bins.len()) }
    }

    /// Removes a cube of the last bin, if all bounds in that bin are at least `least`.
    pub(super) fn pop(&mut self, least: f64) -> Option<Cube> {
        let last = self.bins.len().checked_sub(1)?;
        if self.least_of(last) < least {
            return None;
        }
        let cube = self.bins[last].pop();
        while self.bins.last().is_some_and(Vec::is_empty) {
            self.bins.pop();
        }
        cube
    }

    /// The least bound of a bin.
    fn least_of(&self, bin: usize) -> f64 {
        f64::from_bits(((bin + self.least) as u64) << 48)
    }

    /// The exponent and the top four mantissa bits of a positive number.
    const fn code(x: f64) -> usize {
        (x.to_bits() >> 48) as usize
    }
}

/// Spheres smaller than this fraction of half the mesh's width are ignored: 2^-20.
const LEAST: f64 = 1.0 / (1 << 20) as f64;
/// So are those whose position double precision resolves to less than 10 bits: 2^-42, with coordinates up to 2.
const ROUGH: f64 = 1.0 / (1_u64 << 42) as f64;
/// The least ratio of a proven radius to the clearance: 1 - 2^-7.
pub(super) const PROVEN: f64 = 1.0 - 1.0 / 128.0;

const SQRT_3: f64 = 1.732_050_807_568_877_3;

impl Cube {
    /// The cube around a surface.
    pub(super) fn around(surface: &Surface) -> Self {
        let centre = surface.middle();
        let (depth, triangle) = surface.nearest(centre, 0);
        let depth = if surface.is_inside(centre) { depth } else { -depth };
        let corners = surface.triangles().iter().flatten();
        let extent = corners.fold(DVec3::ZERO, |extent: DVec3, p| extent.max((*p - centre).abs()));
        // No inscribed sphere is wider than the narrowest side of the mesh's box.
        let bound = extent.min_element() * (1.0 + 1.0 / 1024.0);
        let half = extent.max_element();
        Self { bound, centre, half, clearance: depth, depth, triangle, seen: 0 }.bounded()
    }

    fn bounded(self) -> Self {
        Self { bound: self.bound.min(self.clearance + SQRT_3 * self.half), ..self }
    }

    /// Updates the bound for spheres placed since.
    pub(super) fn refresh(&mut self, placed: &Placed) {
        let count = placed.balls().len() as u32;
        // If the centre is inside a sphere, no later sphere can be nearer.
        if core::mem::replace(&mut self.seen, count) < count
            && self.clearance > 0.0
            && let Some((gap, _)) = placed.nearest(self.centre, self.clearance)
        {
            self.clearance = gap;
            *self = self.bounded();
        }
    }

    /// The octants that may contain a centre.
    pub(super) fn parts(&self, room: &Clearance<'_>) -> impl Iterator<Item = Self> {
        let half = 0.5 * self.half;
        let way = SQRT_3 * half;
        (0..8).filter_map(move |octant| {
            let side = |axis: usize| if octant >> axis & 1 == 0 { -half } else { half };
            let centre = self.centre + DVec3::new(side(0), side(1), side(2));
            let (distance, triangle) = room.surface.nearest(centre, self.triangle);
            // A step shorter than one of the two distances to the surface cannot cross it.
            let is_inside = if self.depth.abs().max(distance) > 1.0001 * way {
                self.depth > 0.0
            } else {
                room.surface.is_inside(centre)
            };
            let depth = if is_inside { distance } else { -distance };
            // The cube's clearance bounds that of the octant.
            let mut clearance = depth.min(self.clearance + way);
            if clearance > 0.0
                && let Some((gap, _)) = room.placed.nearest(centre, clearance)
            {
                clearance = gap;
            }
            let part = Self { centre, half, clearance, depth, triangle, ..*self }.bounded();
            (part.bound > 0.0).then_some(part)
        })
    }

    /// The sphere found by ascending from the centre.
    pub(super) fn climbed(&self, room: &Clearance<'_>) -> Option<Ball> {
        let start = room.spot(self.centre, self.triangle);
        let end = room.climb(start, (SQRT_3 * self.half).max(0.25 * start.clearance));
        proven(room.surface, &end)
    }
}

/// The sphere at a spot, with a rounded centre and a radius that is certainly clear of the surface, if that is nearly
/// the whole clearance.
fn proven(surface: &Surface, spot: &Spot) -> Option<Ball> {
    let centre = rounded(spot.at, spot.clearance);
    let limit = spot.clearance * (1.0 + 1.0 / 1024.0);
    let radius = surface.certain_clearance(centre.to_array(), limit);
    (radius >= PROVEN * spot.clearance && surface.is_inside(centre)).then_some(Ball { centre, radius })
}

/// Rounds a centre to single precision if that moves it by less than 2^-10 of the radius. Flushes coordinates so
/// small that a product could underflow.
fn rounded(p: DVec3, radius: f64) -> DVec3 {
    const TINY: f64 = 1.0 / (1_u64 << 60) as f64;
    let p = DVec3::from_array(p.to_array().map(|x| if x.abs() < TINY { 0.0 } else { x }));
    let single = p.as_vec3().as_dvec3();
    if single.distance(p) * 1024.0 <= radius { single } else { p }
}
