//! RRT-Connect on certified motions (Kuffner and `LaValle`, ICRA 2000).
//!
//! Two trees of configurations grow from the start and from the goals. They take turns: one grows towards a random
//! configuration, and the other towards the new one, until they meet. Every motion is certified at all times. Straight
//! motions between two configurations of the path then shorten it.

use super::angles::shorter_way;
use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::random::SplitMix64;
use alloc::vec::Vec;

/// How to plan.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct PlanSettings {
    /// Longest motion that extends a tree, as a distance in joint space. Positive.
    pub step: f64,
    /// Maximum number of random configurations.
    pub configurations: u32,
    /// Number of straight motions that are tried to shorten the path.
    pub shortcuts: u32,
    /// Seed of the random numbers. The same seed gives the same path on every machine.
    pub seed: u64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { step: 1.0, configurations: 100_000, shortcuts: 100, seed: 1 }
    }
}

/// A path, and its cost.
#[derive(Clone, PartialEq, Debug)]
pub struct PlannedPath {
    /// The configurations from the start to a goal. The straight motions between them are certified. Empty if no path
    /// was found.
    pub path: Vec<Vec<f64>>,
    /// Length of the path in joint space.
    pub length: f64,
    /// Number of motions that were checked.
    pub motions: u32,
    /// Number of configurations in both trees.
    pub nodes: usize,
}

impl PlannedPath {
    /// Whether a path was found.
    #[must_use]
    pub fn is_found(&self) -> bool {
        !self.path.is_empty()
    }
}

/// A tree of configurations, each with its parent. Roots are their own parents.
struct Tree {
    values: Vec<f64>,
    parents: Vec<usize>,
}

impl Tree {
    const fn new() -> Self {
        Self { values: Vec::new(), parents: Vec::new() }
    }

    fn add(&mut self, values: &[f64], parent: Option<usize>) -> usize {
        let index = self.parents.len();
        self.values.extend_from_slice(values);
        self.parents.push(parent.unwrap_or(index));
        index
    }

    fn node(&self, index: usize) -> &[f64] {
        let variables = self.values.len() / self.parents.len();
        &self.values[variables * index..][..variables]
    }

    /// The configurations from a node to its root.
    fn to_root(&self, mut index: usize) -> Vec<Vec<f64>> {
        let mut path = alloc::vec![self.node(index).to_vec()];
        while self.parents[index] != index {
            index = self.parents[index];
            path.push(self.node(index).to_vec());
        }
        path
    }
}

/// A search for a path.
struct PathSearch<'s> {
    scene: &'s PlanningScene,
    workspace: &'s mut Workspace,
    settings: &'s PlanSettings,
    random: SplitMix64,
    motions: u32,
    /// Whether each variable belongs to a continuous joint.
    is_continuous: Vec<bool>,
}

impl PlanningScene {
    /// A path of certified motions from the start to one of the goals. Goals that are not free are ignored. If no path
    /// was found, the plan is empty: none exists, or [`PlanSettings::configurations`] is too small.
    ///
    /// # Errors
    /// [`PlanningError::Step`] if the step is not positive; as [`PlanningScene::is_free`], for the start and the goals.
    pub fn plan(
        &self,
        workspace: &mut Workspace,
        start: &[f64],
        goals: &[&[f64]],
        settings: &PlanSettings,
    ) -> Result<PlannedPath, PlanningError> {
        if settings.step.is_nan() || settings.step <= 0.0 {
            return Err(PlanningError::Step { given: settings.step });
        }
        let random = SplitMix64(settings.seed);
        let is_continuous = (0..self.variables()).map(|variable| self.is_continuous(variable)).collect();
        let mut search = PathSearch { scene: self, workspace, settings, random, motions: 0, is_continuous };
        let (mut from, mut to) = (Tree::new(), Tree::new());
        if self.is_free(search.workspace, start)? {
            from.add(start, None);
        }
        for goal in goals {
            if self.is_free(search.workspace, goal)? {
                to.add(goal, None);
            }
        }
        let mut path = Vec::new();
        if !from.parents.is_empty() && !to.parents.is_empty() {
            path = search.connect(&mut from, &mut to)?;
            search.shorten(&mut path)?;
        }
        let length = path.windows(2).map(|ends| self.distance(&ends[0], &ends[1])).sum::<Result<f64, _>>()?;
        Ok(PlannedPath {
            path,
            length,
            motions: search.motions,
            nodes: from.parents.len() + to.parents.len(),
        })
    }
}

impl PathSearch<'_> {
    fn connect(&mut self, from: &mut Tree, to: &mut Tree) -> Result<Vec<Vec<f64>>, PlanningError> {
        // Try the straight motion first.
        let mut target = to.node(0).to_vec();
        let mut is_from_start = true;
        for _ in 0..=self.settings.configurations {
            let (tree, other) = if is_from_start { (&mut *from, &mut *to) } else { (&mut *to, &mut *from) };
            if let Some((new, _)) = self.extend(tree, &target)? {
                let goal = tree.node(new).to_vec();
                while let Some((met, is_reached)) = self.extend(other, &goal)? {
                    if is_reached {
                        let (near, far) = (tree.to_root(new), other.to_root(met));
                        let (mut path, rest) = if is_from_start { (near, far) } else { (far, near) };
                        path.reverse();
                        // Both end with the configuration at which the trees met.
                        path.extend(rest.into_iter().skip(1));
                        return Ok(path);
                    }
                }
            }
            is_from_start = !is_from_start;
            // In 0 .. 1.
            let unit = || (self.random.bits() >> 11) as f64 / (1_u64 << 53) as f64;
            target = self.scene.random(unit);
        }
        Ok(Vec::new())
    }

    /// Grows a tree by one motion towards a target, at most a step long. Returns the new node, and whether it is the
    /// target; `None` if the motion is not free.
    fn extend(&mut self, tree: &mut Tree, target: &[f64]) -> Result<Option<(usize, bool)>, PlanningError> {
        let index = self.nearest(tree, target);
        let distance = self.scene.distance(tree.node(index), target)?;
        let is_reached = distance <= self.settings.step;
        let next = if is_reached {
            target.to_vec()
        } else {
            self.scene.between(tree.node(index), target, self.settings.step / distance)?
        };
        // A step below the rounding of the values gets nowhere.
        let is_moved = is_reached || next != tree.node(index);
        Ok(if is_moved && self.is_free(tree.node(index), &next)? {
            Some((tree.add(&next, Some(index)), is_reached))
        } else {
            None
        })
    }

    fn nearest(&self, tree: &Tree, target: &[f64]) -> usize {
        let mut nearest = (f64::INFINITY, 0);
        for (index, node) in tree.values.chunks_exact(target.len().max(1)).enumerate() {
            let mut square = 0.0;
            for (i, (from, to)) in node.iter().zip(target).enumerate() {
                let (from, to) = if self.is_continuous[i] { shorter_way(*from, *to) } else { (*from, *to) };
                square += (to - from) * (to - from);
            }
            if square < nearest.0 {
                nearest = (square, index);
            }
        }
        nearest.1
    }

    fn is_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool, PlanningError> {
        self.motions += 1;
        self.scene.is_motion_free(self.workspace, [from, to])
    }

    /// Replaces parts of the path by straight motions.
    fn shorten(&mut self, path: &mut Vec<Vec<f64>>) -> Result<(), PlanningError> {
        for _ in 0..self.settings.shortcuts {
            if path.len() < 3 {
                return Ok(());
            }
            let first = self.random.below(path.len() - 2);
            let last = first + 2 + self.random.below(path.len() - first - 2);
            if self.is_free(&path[first], &path[last])? {
                path.drain(first + 1..last);
            }
        }
        Ok(())
    }
}
