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

use super::ascent::Clearance;
use super::cube::{Cube, PROVEN, Queue};
use super::grid::{Ball, Placed};
use super::surface::Surface;
use crate::parallel;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// What becomes of a cube in a round.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
enum Fate {
    /// It waits for another round.
    Waits,
    /// A sphere climbs from its centre.
    Climbs,
    /// It is cut into eight.
    Cut,
    /// It is cut again and again, where there is most room, until a sphere can climb.
    Dives,
    /// It is cut up, or of no use.
    Gone,
}

/// A cube in its round.
#[derive(Clone, Debug)]
struct Task {
    cube: Cube,
    fate: Fate,
    /// What it was cut into.
    parts: Vec<Cube>,
    /// What it led to.
    found: Option<Ball>,
}

/// Cubes of a round, at most.
const ROUND: usize = 256;
/// Cubes that a thread takes at once.
const CHUNK: usize = 4;
/// What a bound must be of the greatest to be looked at in the same round, and a clearance to be climbed from.
const CLOSE: f64 = 0.7;
/// Cuts of a dive, at most, times 8: more lead into a corner.
const DIVE: usize = 24 * 8;
/// Cubes that may be cut, in all and for each sphere placed. Beyond that, spheres are placed that are the
/// largest of those that a round finds: in a plate that is not along the axes, proving that no sphere is larger
/// takes as many cubes as cover it. Most meshes need 20 to 40 for each sphere.
const PATIENCE: (usize, usize) = (1 << 14, 128);

/// Spheres in the order in which they were placed: `count` of them, or as many as there is room for. `None` if
/// the observer, who is shown them all after every round that placed some, said so.
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
            tasks.push(Task { cube, fate: Fate::Waits, parts: Vec::new(), found: None });
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
            if task.fate != Fate::Gone {
                queue.push(task.cube);
            }
        }
        if placed.balls().len() > before && observer(placed.balls()).is_break() {
            return None;
        }
    }
    Some(placed.into_balls())
}

/// Says which cubes wait, which are cut, and from which a sphere climbs, where `rest` is a bound of all others.
fn decide(tasks: &mut [Task], rest: f64, is_overdue: bool) {
    let greatest = tasks.iter().map(|task| task.cube.bound).fold(rest, f64::max);
    let close = CLOSE * greatest;
    // The largest spheres first; of those that climb, none inside of another: both would end at one place.
    tasks.sort_by(|a, b| b.cube.clearance.total_cmp(&a.cube.clearance));
    for index in 0..tasks.len() {
        let cube = tasks[index].cube;
        let is_beside = |other: &Task| {
            let reach = other.cube.clearance;
            other.fate != Fate::Climbs || other.cube.centre.distance_squared(cube.centre) > reach * reach
        };
        tasks[index].fate = if cube.bound < close {
            Fate::Waits
        } else if cube.clearance < close {
            if is_overdue { Fate::Dives } else { Fate::Cut }
        } else if tasks[..index].iter().all(is_beside) {
            Fate::Climbs
        } else {
            Fate::Waits
        };
    }
}

/// Places what was found, the largest first, as far as it fits beside what came before and is not much smaller.
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
        match self.fate {
            Fate::Waits | Fate::Gone => {}
            Fate::Climbs => self.climb(room),
            Fate::Cut => {
                self.fate = Fate::Gone;
                self.parts.extend(self.cube.parts(room));
            }
            Fate::Dives => {
                self.fate = Fate::Gone;
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

    /// Finds a sphere. Where nothing can be proved of it, parts of the cube may lead to another, but not for
    /// ever.
    fn climb(&mut self, room: &Clearance<'_>) {
        self.found = self.cube.climbed(room);
        self.fate = if self.found.is_some() { Fate::Climbs } else { Fate::Gone };
        if self.found.is_none() && self.cube.half > (1.0 - PROVEN) * self.cube.clearance {
            self.parts.extend(self.cube.parts(room));
        }
    }
}

/// The largest number in single precision that is not above a radius.
fn round_down(radius: f64) -> f64 {
    let nearest = radius as f32;
    f64::from(if f64::from(nearest) > radius { nearest.next_down() } else { nearest })
}
