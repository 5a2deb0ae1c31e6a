//! Tests many configurations at once.
//!
//! The search compares the boxes of sixteen configurations at a time, one in each lane. It then tests near pairs one by
//! one, the deepest of each configuration first, until two bodies of the configuration meet.

use super::body::BodyId;
use super::broad::{NearPair, depth, insert_by_depth};
use super::error::SceneError;
use super::placement::{self, Scene};
use crate::isa::on_isa;
use crate::kernel::Kernel;
use crate::node::{Aabb16, Box3};
use crate::pose::Pose;
use crate::query::{Completion, Lanes, Query, QueryStats, Verdict};

/// How a check of many configurations ended, and its cost.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct ConfigurationsAnswer {
    /// [`Completion::Complete`], or [`Completion::OutOfBudget`]: then free configurations may be left unmarked.
    pub completion: Completion,
    /// Number of pairs of bodies tested, counted once for each configuration.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: QueryStats,
}

impl ConfigurationsAnswer {
    fn new() -> Self {
        Self { completion: Completion::Complete, pairs: 0, stats: QueryStats::default() }
    }
}

impl<'t, N: Lanes> Scene<'t, N> {
    /// Which configurations of the `moving` bodies are free? `poses` holds one pose of each moving body for the first
    /// configuration, then for the second, and so on. Bit i % 16 of `free[i / 16]` is set if configuration i is
    /// certainly free. Attached bodies move along with the moving ones; all others stay where they are. The current
    /// poses of the moving bodies are ignored. `boxes` must hold [`Scene::room`] entries.
    ///
    /// The budget covers all configurations together.
    ///
    /// # Errors
    /// [`SceneError`]: a body is missing or attached to another; the number of poses is not a multiple of the number of
    /// moving bodies ([`SceneError::Motion`]); there are too few boxes or words ([`SceneError::Configurations`]); a
    /// pose is invalid in a scene.
    pub fn check_states(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        poses: &[Pose],
        boxes: &mut [Aabb16],
        free: &mut [u16],
    ) -> Result<ConfigurationsAnswer, SceneError> {
        let words = self.prepare(moving, poses, free.len())?;
        if boxes.len() < self.room() {
            return Err(SceneError::Configurations { boxes: self.room(), words });
        }
        self.fill(query, moving.len(), poses, boxes, &mut free[..words])
    }

    /// As [`Scene::check_states`], but allocates its memory, and runs on several threads with the feature `rayon`. The
    /// budget applies to each run of 64 configurations.
    ///
    /// # Errors
    /// As [`Scene::check_states`].
    #[cfg(feature = "alloc")]
    pub fn free_configurations_on_threads(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        poses: &[Pose],
        free: &mut [u16],
    ) -> Result<ConfigurationsAnswer, SceneError> {
        /// Words per job.
        const RUN: usize = 4;
        let words = self.prepare(moving, poses, free.len())?;
        let scene = &*self;
        let runs = free[..words].chunks_mut(RUN).zip(poses.chunks(16 * RUN * moving.len()));
        let mut answers = alloc::vec![Ok(ConfigurationsAnswer::new()); words.div_ceil(RUN)];
        let jobs = runs.zip(&mut answers).collect();
        crate::parallel::for_each(jobs, |boxes: &mut alloc::vec::Vec<Aabb16>, ((free, poses), answer)| {
            boxes.resize(scene.room(), Aabb16::EMPTY);
            *answer = scene.fill(query, moving.len(), poses, boxes, free);
        });
        answers.into_iter().try_fold(ConfigurationsAnswer::new(), |all, answer| {
            let answer = answer?;
            let is_complete = answer.completion == Completion::Complete;
            Ok(ConfigurationsAnswer {
                completion: if is_complete { all.completion } else { answer.completion },
                pairs: all.pairs + answer.pairs,
                stats: all.stats.and(&answer.stats),
            })
        })
    }

    /// Sets the carriers of all bodies, and returns the number of words needed.
    fn prepare(&mut self, moving: &[BodyId], poses: &[Pose], words: usize) -> Result<usize, SceneError> {
        if moving.is_empty() || !poses.len().is_multiple_of(moving.len()) {
            return Err(SceneError::Motion { bodies: moving.len(), given: moving.len(), poses: poses.len() });
        }
        self.set_carriers(moving)?;
        let needed = (poses.len() / moving.len()).div_ceil(16);
        if words < needed {
            return Err(SceneError::Configurations { boxes: self.room(), words: needed });
        }
        Ok(needed)
    }

    fn fill(
        &self,
        query: &Query,
        moving: usize,
        poses: &[Pose],
        boxes: &mut [Aabb16],
        free: &mut [u16],
    ) -> Result<ConfigurationsAnswer, SceneError> {
        let mut answer = ConfigurationsAnswer::new();
        free.fill(0);
        for (word, poses) in free.iter_mut().zip(poses.chunks(16 * moving)) {
            let mut lanes = Sixteen { scene: self, poses, moving, boxes };
            *word = lanes.ask(query, &mut answer)?;
            if answer.completion != Completion::Complete {
                break;
            }
        }
        Ok(answer)
    }
}

/// Up to sixteen configurations, one for each lane.
struct Sixteen<'s, 't, 'c, N> {
    scene: &'s Scene<'t, N>,
    poses: &'c [Pose],
    moving: usize,
    /// For each slot with a moving body, its boxes, one lane for each configuration.
    boxes: &'c mut [Aabb16],
}

/// Capacity of each configuration's list of pairs.
const WAITING: usize = 16;

/// Near pairs, the deepest of each configuration first, and the position at which the search continues.
struct NearLanes {
    pairs: [[NearPair; WAITING]; 16],
    len: [usize; 16],
    row: usize,
    /// The group of sixteen bodies in the row, and the bits of those left in it.
    sixteen: usize,
    rest: u16,
    /// Lanes left of the first of these bodies.
    lanes: u16,
}

impl NearLanes {
    fn new() -> Self {
        let none = NearPair { a: 0, b: 0, depth: 0.0 };
        Self {
            pairs: [[none; WAITING]; 16],
            len: [0; 16],
            row: 0,
            sixteen: 0,
            rest: u16::MAX,
            lanes: u16::MAX,
        }
    }
}

impl<N: Lanes> Sixteen<'_, '_, '_, N> {
    fn ask(&mut self, query: &Query, answer: &mut ConfigurationsAnswer) -> Result<u16, SceneError> {
        self.place()?;
        let lanes = self.poses.len() / self.moving;
        let mut free = u16::MAX >> (16 - lanes);
        let mut near = NearLanes::new();
        loop {
            near.len = [0; 16];
            on_isa!(query.isa(), kernel => kernel.run(
                #[inline(always)]
                || self.gather(kernel, &mut near, free),
            ));
            if near.len == [0; 16] {
                return Ok(free);
            }
            for lane in 0..lanes {
                for pair in &near.pairs[lane][..near.len[lane]] {
                    let [mut a, mut b] = [Pose::IDENTITY; 2];
                    let a = self.world(pair.a as usize, lane, &mut a)?;
                    let b = self.world(pair.b as usize, lane, &mut b)?;
                    let found = self.scene.ask_within_at(&query.after(&answer.stats), pair, [a, b], 0.0)?;
                    answer.pairs += 1;
                    answer.stats = answer.stats.and(&found.stats);
                    match found.verdict {
                        Verdict::Free => {}
                        Verdict::Hit(_) => {
                            free &= !(1 << lane);
                            break;
                        }
                        Verdict::Unknown { .. } => {
                            answer.completion = Completion::OutOfBudget;
                            return Ok(0);
                        }
                    }
                }
            }
        }
    }

    /// The world pose of a slot's body in a configuration. The pose of an attached body is written to `composed`.
    #[inline]
    fn world<'p>(&'p self, i: usize, lane: usize, composed: &'p mut Pose) -> Result<&'p Pose, SceneError> {
        let slot = &self.scene.memory.slots[i];
        let Some(carrier) = slot.carrier else { return Ok(&slot.world) };
        let world = &self.poses[lane * self.moving + carrier as usize];
        if slot.parent.is_none() {
            return Ok(world);
        }
        *composed = self.scene.carried(i, world)?;
        Ok(composed)
    }

    /// Computes the boxes of all moving bodies.
    fn place(&mut self) -> Result<(), SceneError> {
        for i in 0..self.scene.room() {
            let slot = &self.scene.memory.slots[i];
            if slot.carrier.is_none() || slot.body.is_none() {
                continue;
            }
            self.boxes[i] = Aabb16::EMPTY;
            for lane in 0..self.poses.len() / self.moving {
                let mut composed = Pose::IDENTITY;
                let world = self.world(i, lane, &mut composed)?;
                placement::check(world)?;
                let bounds = slot.size.bounds(world);
                self.boxes[i].set_lane(lane, &bounds);
            }
        }
        Ok(())
    }

    /// Collects near pairs in the lanes that are free so far, until one lane's list is full.
    #[inline(always)]
    fn gather(&self, kernel: impl Kernel, near: &mut NearLanes, free: u16) {
        let memory = &self.scene.memory;
        while near.row < memory.slots.len() {
            while near.sixteen < memory.stride() {
                let mut asked = memory.row(near.row, near.sixteen) & near.rest;
                while asked != 0 {
                    let (a, b) = (near.row, 16 * near.sixteen + asked.trailing_zeros() as usize);
                    let mut lanes = near.lanes & free & self.overlapping(kernel, a, b);
                    while lanes != 0 {
                        let lane = lanes.trailing_zeros() as usize;
                        if near.len[lane] == WAITING {
                            (near.rest, near.lanes) = (asked, lanes);
                            return;
                        }
                        lanes &= lanes - 1;
                        let [p, q] = [a, b].map(|i| self.bounds(i, lane));
                        let candidate = NearPair { a: a as u32, b: b as u32, depth: depth(&p, &q) };
                        insert_by_depth(&mut near.pairs[lane], &mut near.len[lane], candidate);
                    }
                    near.lanes = u16::MAX;
                    asked &= asked - 1;
                }
                near.rest = u16::MAX;
                near.sixteen += 1;
            }
            near.sixteen = 0;
            near.row += 1;
        }
    }

    #[inline(always)]
    fn overlapping(&self, kernel: impl Kernel, a: usize, b: usize) -> u16 {
        let memory = &self.scene.memory;
        match (memory.slots[a].carrier, memory.slots[b].carrier) {
            (Some(_), Some(_)) => lanes_overlapping(&self.boxes[a], &self.boxes[b]),
            (Some(_), None) => kernel.boxes_near(&memory.bounds(b), 0.0, &self.boxes[a]),
            (None, Some(_)) => kernel.boxes_near(&memory.bounds(a), 0.0, &self.boxes[b]),
            (None, None) => {
                if depth(&memory.bounds(a), &memory.bounds(b)) >= 0.0 {
                    u16::MAX
                } else {
                    0
                }
            }
        }
    }

    #[inline(always)]
    fn bounds(&self, i: usize, lane: usize) -> Box3 {
        match self.scene.memory.slots[i].carrier {
            Some(_) => self.boxes[i].lane(lane),
            None => self.scene.memory.bounds(i),
        }
    }
}

/// Lanes in which two boxes overlap. An empty box is NaN and overlaps none. Written for autovectorization.
#[inline(always)]
fn lanes_overlapping(a: &Aabb16, b: &Aabb16) -> u16 {
    let mut near: [u32; 16] = core::array::from_fn(|lane| 1 << lane);
    for i in 0..3 {
        for (lane, near) in near.iter_mut().enumerate() {
            let overlap = (a.lower[i][lane] <= b.upper[i][lane]) & (b.lower[i][lane] <= a.upper[i][lane]);
            *near &= u32::from(overlap).wrapping_neg();
        }
    }
    near.iter().fold(0, |mask, near| mask | near) as u16
}
