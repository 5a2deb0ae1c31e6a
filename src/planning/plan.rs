//! RRT-Connect on certified motions (Kuffner and `LaValle`, ICRA 2000).
//!
//! Two trees of configurations grow from the start and from the goals, in turn: one towards a random configuration, the
//! other towards the new one, until they meet. Every motion is certified at all times. The path is then shortened by
//! straight motions between two of its configurations.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::random::SplitMix64;
use alloc::vec::Vec;

/// How to plan.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct PlanSettings {
    /// Longest motion by which a tree grows, in the joints. Positive.
    pub step: f64,
    /// Greatest number of random configurations.
    pub configurations: u32,
    /// Number of straight motions that are tried to shorten the path.
    pub shortcuts: u32,
    /// Start of the random numbers. The same seed gives the same path on every machine.
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
    /// Length of the path in the joints.
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

    /// The configurations from one to its root.
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
}

impl PlanningScene {
    /// A path of certified motions from the start to one of the goals. Goals that are not free are ignored. Without a
    /// path, the plan is empty: there is none, or [`PlanSettings::configurations`] are too few.
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
        let mut search = PathSearch { scene: self, workspace, settings, random, motions: 0 };
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
        // The straight way first.
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
                        // Both end with the configuration where the trees met.
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
        let mut nearest = (f64::INFINITY, 0);
        for index in 0..tree.parents.len() {
            let distance = self.scene.distance(tree.node(index), target)?;
            if distance < nearest.0 {
                nearest = (distance, index);
            }
        }
        let (distance, index) = nearest;
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

    fn is_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool, PlanningError> {
        self.motions += 1;
        Ok(self.scene.check_motion(self.workspace, [from, to])?.is_free())
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
