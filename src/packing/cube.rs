//! Cubes that may hold centres, and the queue that they wait in.

use super::ascent::{Clearance, Spot};
use super::grid::{Ball, Placed};
use super::surface::Surface;
use alloc::vec::Vec;
use glam::DVec3;

/// A cube whose points may be centres.
#[derive(Copy, Clone, Debug)]
pub(super) struct Cube {
    /// No clearance in the cube is greater.
    pub(super) bound: f64,
    pub(super) centre: DVec3,
    /// Half of the edge.
    pub(super) half: f64,
    /// Of the centre, as of when `seen` spheres were there. Negative in spheres and outside.
    pub(super) clearance: f64,
    /// Of the centre below the surface; negative outside.
    depth: f64,
    /// The triangle nearest to the centre.
    triangle: u32,
    seen: u32,
}

/// Cubes that wait, by bound, in bins a sixteenth of a power of two wide: the order within one is of no
/// consequence, and a heap would take a third of all time.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    /// The code of the bounds that are not waited for.
    least: usize,
    /// Of each bin above that. None beyond the last that has a cube.
    bins: Vec<Vec<Cube>>,
}

impl Queue {
    /// Of the cube around a mesh.
    pub(super) fn of(whole: Cube) -> Self {
        let mut queue = Self { least: Self::code((LEAST * whole.half).max(ROUGH)), bins: Vec::new() };
        queue.push(whole);
        queue
    }

    /// Takes a cube, unless it is too small for any sphere.
    pub(super) fn push(&mut self, cube: Cube) {
        // The code of a negative number is a large one.
        if cube.bound > 0.0
            && let Some(bin) = Self::code(cube.bound).checked_sub(self.least)
        {
            if bin >= self.bins.len() {
                self.bins.resize_with(bin + 1, Vec::new);
            }
            self.bins[bin].push(cube);
        }
    }

    /// A bound of all bounds, less than a sixteenth above the greatest; 0 if no cube waits.
    pub(super) fn bound(&self) -> f64 {
        if self.bins.is_empty() { 0.0 } else { self.least_of(self.bins.len()) }
    }

    /// A cube of the last bin, if no bound in there is below `least`.
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

    /// The least bound that belongs into a bin.
    fn least_of(&self, bin: usize) -> f64 {
        f64::from_bits(((bin + self.least) as u64) << 48)
    }

    /// The exponent of a positive number and four bits of what follows.
    const fn code(x: f64) -> usize {
        (x.to_bits() >> 48) as usize
    }
}

/// Spheres smaller than this share of half the width of the mesh are not looked for: 2^-20.
const LEAST: f64 = 1.0 / (1 << 20) as f64;
/// Nor are those whose place is not known to 10 bits in double precision: 2^-42, where coordinates are up to 2.
const ROUGH: f64 = 1.0 / (1_u64 << 42) as f64;
/// What of the clearance a proven radius must be: 1 - 2^-7.
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
        // No sphere is wider than the box of the mesh where that is least wide.
        let bound = extent.min_element() * (1.0 + 1.0 / 1024.0);
        let half = extent.max_element();
        Self { bound, centre, half, clearance: depth, depth, triangle, seen: 0 }.bounded()
    }

    fn bounded(self) -> Self {
        Self { bound: self.bound.min(self.clearance + SQRT_3 * self.half), ..self }
    }

    /// Takes account of the spheres that came since.
    pub(super) fn refresh(&mut self, placed: &Placed) {
        let count = placed.balls().len() as u32;
        // A sphere around the centre is the nearest for good.
        if core::mem::replace(&mut self.seen, count) < count
            && self.clearance > 0.0
            && let Some((gap, _)) = placed.nearest(self.centre, self.clearance)
        {
            self.clearance = gap;
            *self = self.bounded();
        }
    }

    /// The eight parts, as far as a sphere may have its centre there.
    pub(super) fn parts(&self, room: &Clearance<'_>) -> impl Iterator<Item = Self> {
        let half = 0.5 * self.half;
        let way = SQRT_3 * half;
        (0..8).filter_map(move |octant| {
            let side = |axis: usize| if octant >> axis & 1 == 0 { -half } else { half };
            let centre = self.centre + DVec3::new(side(0), side(1), side(2));
            let (distance, triangle) = room.surface.nearest(centre, self.triangle);
            // What is farther from the surface than from here is on the same side of it.
            let is_inside = if self.depth.abs().max(distance) > 1.0001 * way {
                self.depth > 0.0
            } else {
                room.surface.is_inside(centre)
            };
            let depth = if is_inside { distance } else { -distance };
            // What is nearest to this centre bounds the part's.
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

    /// The sphere that climbs from the centre.
    pub(super) fn climbed(&self, room: &Clearance<'_>) -> Option<Ball> {
        let start = room.spot(self.centre, self.triangle);
        let end = room.climb(start, (SQRT_3 * self.half).max(0.25 * start.clearance));
        proven(room.surface, &end)
    }
}

/// The sphere at a spot, its centre rounded, its radius certainly clear of the surface: if that is nearly all
/// of the clearance.
fn proven(surface: &Surface, spot: &Spot) -> Option<Ball> {
    let centre = rounded(spot.at, spot.clearance);
    let limit = spot.clearance * (1.0 + 1.0 / 1024.0);
    let radius = surface.certain_clearance(centre.to_array(), limit);
    (radius >= PROVEN * spot.clearance && surface.is_inside(centre)).then_some(Ball { centre, radius })
}

/// The place in single precision, if that is less than a 2^10th of the radius away, and without numbers so
/// small that a product could underflow.
fn rounded(p: DVec3, radius: f64) -> DVec3 {
    const TINY: f64 = 1.0 / (1_u64 << 60) as f64;
    let p = DVec3::from_array(p.to_array().map(|x| if x.abs() < TINY { 0.0 } else { x }));
    let single = p.as_vec3().as_dvec3();
    if single.distance(p) * 1024.0 <= radius { single } else { p }
}
