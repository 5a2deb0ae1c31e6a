//! The search for the largest sphere that fits.
//!
//! Cubes that fill the mesh wait in a queue, those first in which the largest sphere may have its centre. The
//! clearance changes by no more than one moves, so that of any point of a cube is at most that of its centre
//! and half of the cube's diagonal. Spheres only ever take room away: a bound that is out of date is one still,
//! and is brought up to date when the cube's turn comes.
//!
//! A round takes cubes from the head of the queue whose bound is close to the greatest. Where the centre's
//! clearance is close to it as well, a sphere climbs from there to where it is largest; other cubes are cut
//! into eight. The number of cubes does not depend on the number of threads, and what is found is put in its
//! place in one order, so that the packing does not depend on it either.

use super::ascent::{Room, Spot};
use super::grid::{Ball, Placed};
use super::surface::Surface;
use crate::construct::parallel;
use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::ops::ControlFlow;
use glam::DVec3;

/// A cube whose points may be centres.
#[derive(Copy, Clone, Debug)]
struct Cube {
    /// No clearance in the cube is greater.
    bound: f64,
    centre: DVec3,
    /// Half of the edge.
    half: f64,
    /// Of the centre, as of when `seen` spheres were there. Negative in spheres and outside.
    clearance: f64,
    /// Of the centre below the surface; negative outside.
    depth: f64,
    /// The triangle nearest to the centre.
    triangle: u32,
    seen: u32,
}

impl PartialEq for Cube {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Cube {}
impl PartialOrd for Cube {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cube {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// What becomes of a cube in a round.
#[derive(Copy, Clone, Debug)]
enum Fate {
    /// It waits for another round.
    Waits,
    /// A sphere climbs from its centre.
    Climbs,
    /// It is cut into eight.
    Cut([Option<Cube>; 8]),
    /// It led to this sphere.
    Found(Ball),
    /// Nothing can be proved of its centre, and it is too small to be cut.
    Dropped,
}

/// A cube in its round.
#[derive(Copy, Clone, Debug)]
struct Task {
    cube: Cube,
    fate: Fate,
}

/// Cubes of a round, at most.
const ROUND: usize = 256;
/// Cubes that a thread takes at once.
const CHUNK: usize = 4;
/// What a bound must be of the greatest to be looked at in the same round, and a clearance to be climbed from.
const CLOSE: f64 = 0.9;
/// Spheres smaller than this are not looked for, where the mesh's greatest coordinate is 1 to 2: 2^-20.
const LEAST: f64 = 1.0 / (1 << 20) as f64;
/// What of the clearance a proven radius must be: 1 - 2^-7.
const PROVEN: f64 = 1.0 - 1.0 / 128.0;

const SQRT_3: f64 = 1.732_050_807_568_877_3;

/// Spheres in the order in which they were placed: `count` of them, or as many as there is room for. `None` if
/// the observer, who is shown them all after every round that placed some, said so.
pub(super) fn fill(
    surface: &Surface,
    count: usize,
    observer: &mut dyn FnMut(&[Ball]) -> ControlFlow<()>,
) -> Option<Vec<Ball>> {
    let mut placed = Placed::new(count);
    let mut queue = BinaryHeap::from([Cube::around(surface)]);
    let mut tasks: Vec<Task> = Vec::with_capacity(ROUND);
    while placed.balls().len() < count {
        let Some(first) = queue.peek() else { break };
        let close = CLOSE * first.bound;
        tasks.clear();
        while tasks.len() < ROUND
            && let Some(cube) = queue.peek().filter(|cube| cube.bound >= close)
        {
            tasks.push(Task { cube: *cube, fate: Fate::Waits });
            queue.pop();
        }
        let room = Room { surface, placed: &placed };
        parallel::for_each_chunk(&mut tasks, 2 * CHUNK, |_, chunk| {
            chunk.iter_mut().for_each(|task| task.cube.refresh(&placed));
        });
        decide(&mut tasks, queue.peek().map_or(0.0, |cube| cube.bound));
        parallel::for_each_chunk(&mut tasks, CHUNK, |_, chunk| {
            chunk.iter_mut().for_each(|task| task.work(&room));
        });
        let before = placed.balls().len();
        place(&tasks, &mut placed, count);
        for task in &tasks {
            match task.fate {
                Fate::Cut(parts) => queue.extend(parts.into_iter().flatten()),
                Fate::Dropped => {}
                _ if task.cube.bound > LEAST => queue.push(task.cube),
                _ => {}
            }
        }
        if placed.balls().len() > before && observer(placed.balls()).is_break() {
            return None;
        }
    }
    Some(placed.into_balls())
}

/// Says which cubes wait, which are cut, and from which a sphere climbs, where `rest` is the greatest bound of
/// all others.
fn decide(tasks: &mut [Task], rest: f64) {
    let greatest = tasks.iter().map(|task| task.cube.bound).fold(rest, f64::max);
    let close = CLOSE * greatest;
    // The largest spheres first; of those that climb, none inside of another: both would end at one place.
    tasks.sort_by(|a, b| b.cube.clearance.total_cmp(&a.cube.clearance));
    for index in 0..tasks.len() {
        let cube = tasks[index].cube;
        let is_beside = |other: &Task| {
            !matches!(other.fate, Fate::Climbs)
                || other.cube.centre.distance_squared(cube.centre) > other.cube.clearance * other.cube.clearance
        };
        tasks[index].fate = if cube.bound < close || cube.bound <= LEAST {
            Fate::Waits
        } else if cube.clearance < close {
            Fate::Cut([None; 8])
        } else if tasks[..index].iter().all(is_beside) {
            Fate::Climbs
        } else {
            Fate::Waits
        };
    }
}

/// Places what was found, the largest first, as far as it fits beside what came before.
fn place(tasks: &[Task], placed: &mut Placed, count: usize) {
    let found = |task: &Task| if let Fate::Found(ball) = task.fate { Some(ball) } else { None };
    let mut found: Vec<Ball> = tasks.iter().filter_map(found).collect();
    found.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    for ball in found {
        if placed.balls().len() == count {
            return;
        }
        let radius = placed.certain_clearance(&ball);
        if radius >= PROVEN * ball.radius {
            placed.add(Ball { radius: round_down(radius), ..ball });
        }
    }
}

impl Cube {
    /// The cube around a surface.
    fn around(surface: &Surface) -> Self {
        let centre = surface.middle();
        let corners = surface.triangles().iter().flatten();
        let half = corners.fold(0.0, |half: f64, p| half.max((*p - centre).abs().max_element()));
        let (depth, triangle) = surface.nearest(centre, 0);
        let depth = if surface.is_inside(centre) { depth } else { -depth };
        Self { bound: f64::INFINITY, centre, half, clearance: depth, depth, triangle, seen: 0 }.bounded()
    }

    fn bounded(self) -> Self {
        Self { bound: self.bound.min(self.clearance + SQRT_3 * self.half), ..self }
    }

    /// Takes account of the spheres that came since.
    fn refresh(&mut self, placed: &Placed) {
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
    fn parts(&self, room: &Room<'_>) -> [Option<Self>; 8] {
        let half = 0.5 * self.half;
        let way = SQRT_3 * half;
        core::array::from_fn(|octant| {
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
            (part.bound > LEAST).then_some(part)
        })
    }
}

impl Task {
    fn work(&mut self, room: &Room<'_>) {
        let Self { cube, fate } = self;
        if matches!(fate, Fate::Climbs) {
            let start = room.spot(cube.centre, cube.triangle);
            let reach = (SQRT_3 * cube.half).max(0.25 * start.clearance);
            let end = room.climb(start, reach);
            *fate = if let Some(ball) = proven(room.surface, &end) {
                Fate::Found(ball)
            } else if cube.half < (1.0 - PROVEN) * cube.clearance {
                Fate::Dropped
            } else {
                Fate::Cut([None; 8])
            };
        }
        if matches!(fate, Fate::Cut(_)) {
            *fate = Fate::Cut(cube.parts(room));
        }
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

/// The largest number in single precision that is not above a radius.
fn round_down(radius: f64) -> f64 {
    let nearest = radius as f32;
    f64::from(if f64::from(nearest) > radius { nearest.next_down() } else { nearest })
}
