//! The search for the largest sphere that fits.
//!
//! Cubes that fill the mesh are queued by an upper bound of the radius of a sphere centred in them. The clearance is
//! 1-Lipschitz, so in a cube it is at most that of its centre plus half the cube's diagonal. Placing spheres only
//! reduces the clearance: an outdated bound remains valid, and is updated when its cube is removed from the queue.
//!
//! A round takes the cubes from the queue whose bound is close to the greatest. If the clearance of a cube's centre
//! is close to that as well, an ascent from there finds the local maximum; otherwise the cube is split into eight.
//! The number of cubes per round does not depend on the number of threads, and results are placed in a fixed order,
//! so the packing does not depend on the number of threads either.

use super::ascent::Clearance;
use super::cube::{Cube, PROVEN, Queue};
use super::grid::{Ball, Placed};
use super::surface::Surface;
use crate::parallel;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// What a round does with a cube.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Phase {
    /// Returns to the queue.
    Waits,
    /// An ascent starts from its centre.
    Climbs,
    /// Is split into eight.
    Cut,
    /// Is split repeatedly, following the largest clearance, until an ascent can start.
    Dives,
    /// Has been split, or is of no use.
    Gone,
}

/// A cube and its result in a round.
#[derive(Clone, Debug)]
struct Task {
    cube: Cube,
    phase: Phase,
    /// Cubes to queue.
    parts: Vec<Cube>,
    /// The sphere found.
    found: Option<Ball>,
}

/// Maximum number of cubes per round.
const ROUND: usize = 256;
/// Cubes per task of a thread.
const CHUNK: usize = 4;
/// The least ratio of a bound, to be processed, or of a clearance, to start an ascent, to the greatest bound.
const CLOSE: f64 = 0.7;
/// Maximum number of cubes that a dive makes, eight per split. Longer dives lead into a corner.
const DIVE: usize = 24 * 8;
/// Number of splits allowed: a constant, and per sphere placed. Beyond that, the largest spheres that a round finds
/// are placed without proof: in a plate that is not along the axes, proving that no sphere is larger takes as many
/// cubes as cover the plate. Most meshes need 20 to 40 splits per sphere.
const PATIENCE: (usize, usize) = (1 << 14, 128);

/// Spheres in order of placement: `count`, or as many as fit. The observer gets all of them after every round that
/// placed some. `None` if it breaks.
pub(super) fn fill(
    surface: &Surface,
    count: usize,
    observer: &mut dyn FnMut(&[Ball]) -> ControlFlow<()>,
) -> Option<Vec<Ball>> {
    let mut placed = Placed::new(count);
    let mut queue = Queue::of(Cube::around(surface));
    let mut tasks: Vec<Task> = Vec::with_capacity(ROUND);
    let mut cuts = 0;
    while placed.balls().len() < count && queue.bound() > 0.0 {
        let close = CLOSE * queue.bound();
        tasks.clear();
        while tasks.len() < ROUND
            && let Some(cube) = queue.pop(close)
        {
            tasks.push(Task { cube, phase: Phase::Waits, parts: Vec::new(), found: None });
        }
        let room = Clearance { surface, placed: &placed };
        parallel::for_each_chunk(&mut tasks, 2 * CHUNK, |_, chunk| {
            chunk.iter_mut().for_each(|task| task.cube.refresh(&placed));
        });
        let is_overdue = cuts > PATIENCE.0 + PATIENCE.1 * placed.balls().len();
        decide(&mut tasks, queue.bound(), is_overdue);
        parallel::for_each_chunk(&mut tasks, CHUNK, |_, chunk| {
            chunk.iter_mut().for_each(|task| task.work(&room));
        });
        let before = placed.balls().len();
        place(&tasks, &mut placed, count);
        for task in &tasks {
            cuts += task.parts.len().div_ceil(8);
            task.parts.iter().for_each(|part| queue.push(*part));
            if task.phase != Phase::Gone {
                queue.push(task.cube);
            }
        }
        if placed.balls().len() > before && observer(placed.balls()).is_break() {
            return None;
        }
    }
    Some(placed.into_balls())
}

/// Decides the phase of each cube. `rest` bounds all cubes that are still queued.
fn decide(tasks: &mut [Task], rest: f64, is_overdue: bool) {
    let greatest = tasks.iter().map(|task| task.cube.bound).fold(rest, f64::max);
    let close = CLOSE * greatest;
    // Largest clearance first. An ascent does not start inside another's sphere: both would end at the same place.
    tasks.sort_by(|a, b| b.cube.clearance.total_cmp(&a.cube.clearance));
    for index in 0..tasks.len() {
        let cube = tasks[index].cube;
        let is_beside = |other: &Task| {
            let reach = other.cube.clearance;
            other.phase != Phase::Climbs || other.cube.centre.distance_squared(cube.centre) > reach * reach
        };
        tasks[index].phase = if cube.bound < close {
            Phase::Waits
        } else if cube.clearance < close {
            if is_overdue { Phase::Dives } else { Phase::Cut }
        } else if tasks[..index].iter().all(is_beside) {
            Phase::Climbs
        } else {
            Phase::Waits
        };
    }
}

/// Places the spheres found, largest first, except those that overlap earlier ones or are much smaller than the
/// largest.
fn place(tasks: &[Task], placed: &mut Placed, count: usize) {
    let mut found: Vec<Ball> = tasks.iter().filter_map(|task| task.found).collect();
    found.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let least = found.first().map_or(0.0, |largest| CLOSE * largest.radius);
    for ball in found {
        if placed.balls().len() == count || ball.radius < least {
            return;
        }
        let radius = placed.certain_clearance(&ball);
        if radius >= PROVEN * ball.radius {
            placed.add(Ball { radius: round_down(radius), ..ball });
        }
    }
}

impl Task {
    fn work(&mut self, room: &Clearance<'_>) {
        match self.phase {
            Phase::Waits | Phase::Gone => {}
            Phase::Climbs => self.climb(room),
            Phase::Cut => {
                self.phase = Phase::Gone;
                self.parts.extend(self.cube.parts(room));
            }
            Phase::Dives => {
                self.phase = Phase::Gone;
                let mut cube = self.cube;
                while cube.clearance < cube.half && self.parts.len() < DIVE {
                    let start = self.parts.len();
                    self.parts.extend(cube.parts(room));
                    let roomiest = (start..self.parts.len())
                        .max_by(|&i, &j| self.parts[i].clearance.total_cmp(&self.parts[j].clearance));
                    let Some(roomiest) = roomiest else { return };
                    cube = self.parts.swap_remove(roomiest);
                }
                if cube.clearance < cube.half {
                    self.parts.push(cube);
                } else {
                    self.cube = cube;
                    self.climb(room);
                }
            }
        }
    }

    /// Ascends to a sphere. If it cannot be proven, parts of the cube are queued, down to a minimum size.
    fn climb(&mut self, room: &Clearance<'_>) {
        self.found = self.cube.climbed(room);
        self.phase = if self.found.is_some() { Phase::Climbs } else { Phase::Gone };
        if self.found.is_none() && self.cube.half > (1.0 - PROVEN) * self.cube.clearance {
            self.parts.extend(self.cube.parts(room));
        }
    }
}

/// The largest single-precision number not above a radius.
fn round_down(radius: f64) -> f64 {
    let nearest = radius as f32;
    f64::from(if f64::from(nearest) > radius { nearest.next_down() } else { nearest })
}
