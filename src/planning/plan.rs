//! RRT-Connect on certified motions (Kuffner and `LaValle`, ICRA 2000), with balanced trees and dynamic domains
//! (Yershova, Jaillet, Siméon and `LaValle`, ICRA 2005).
//!
//! Two trees of configurations grow from the start and from the goals. The smaller one grows towards a random
//! configuration, and the other towards the new one, until they meet. Every motion is certified at all times. Straight
//! motions between two configurations of the path then shorten it.
//!
//! A node from which a motion failed is beside an obstacle. It is then extended only towards configurations in its
//! domain, a ball whose radius is [`DOMAIN`] steps at first. Each configuration outside enlarges the domain, so that
//! no node is left for good.

use super::error::PlanningError;
use super::scene::PlanningScene;
use super::workspace::Workspace;
use crate::random::SplitMix64;
use crate::vector::sqrt;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;

/// Radius, in steps, of the domain of a node from which a motion failed.
const DOMAIN: f64 = 3.0;
/// Growth of a domain for each configuration outside.
const GROWTH: f64 = 1.01;

/// How to plan.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct PlanSettings {
    /// Longest motion that extends a tree, as a distance in joint space. Positive.
    pub step: f64,
    /// Maximum number of random configurations, including those that extend no tree.
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
    /// The radius of each configuration's domain.
    domains: Vec<f64>,
}

impl Tree {
    const fn new() -> Self {
        Self { values: Vec::new(), parents: Vec::new(), domains: Vec::new() }
    }

    fn add(&mut self, values: &[f64], parent: Option<usize>) -> usize {
        let index = self.parents.len();
        self.values.extend_from_slice(values);
        self.parents.push(parent.unwrap_or(index));
        self.domains.push(f64::INFINITY);
        index
    }

    const fn len(&self) -> usize {
        self.parents.len()
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
        if from.len() > 0 && to.len() > 0 {
            path = search.connect(&mut from, &mut to)?;
            search.shorten(&mut path)?;
        }
        let length = path.windows(2).map(|ends| self.distance(&ends[0], &ends[1])).sum::<Result<f64, _>>()?;
        Ok(PlannedPath { path, length, motions: search.motions, nodes: from.len() + to.len() })
    }
}

impl PathSearch<'_> {
    fn connect(&mut self, from: &mut Tree, to: &mut Tree) -> Result<Vec<Vec<f64>>, PlanningError> {
        // The straight motion first.
        let mut target = to.node(0).to_vec();
        for _ in 0..=self.settings.configurations {
            let is_from_start = from.len() <= to.len();
            let (tree, other) = if is_from_start { (&mut *from, &mut *to) } else { (&mut *to, &mut *from) };
            if let Some((new, _)) = self.extend(tree, &target, true)? {
                let goal = tree.node(new).to_vec();
                while let Some((met, is_reached)) = self.extend(other, &goal, false)? {
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
            // In 0 .. 1.
            let unit = || (self.random.bits() >> 11) as f64 / (1_u64 << 53) as f64;
            target = self.scene.random(unit);
        }
        Ok(Vec::new())
    }

    /// Grows a tree by one motion towards a target, at most a step long. Returns the new node, and whether it is the
    /// target; `None` if the motion is not free, or if a random target is outside the nearest node's domain.
    fn extend(
        &mut self,
        tree: &mut Tree,
        target: &[f64],
        is_random: bool,
    ) -> Result<Option<(usize, bool)>, PlanningError> {
        let (index, distance) = self.nearest(tree, target);
        if is_random && distance > tree.domains[index] {
            tree.domains[index] *= GROWTH;
            return Ok(None);
        }
        let is_reached = distance <= self.settings.step;
        let next = if is_reached {
            target.to_vec()
        } else {
            self.scene.between(tree.node(index), target, self.settings.step / distance)?
        };
        // A step below the rounding of the values gets nowhere.
        let is_moved = is_reached || next != tree.node(index);
        if is_moved && self.is_free(tree.node(index), &next)? {
            return Ok(Some((tree.add(&next, Some(index)), is_reached)));
        }
        tree.domains[index] = DOMAIN * self.settings.step;
        Ok(None)
    }

    /// The node nearest to a target, and its distance.
    fn nearest(&self, tree: &Tree, target: &[f64]) -> (usize, f64) {
        let mut nearest = (0, f64::INFINITY);
        for index in 0..tree.len() {
            let square = self.scene.squared_distance(tree.node(index), target);
            if square < nearest.1 {
                nearest = (index, square);
            }
        }
        (nearest.0, sqrt(nearest.1))
    }

    fn is_free(&mut self, from: &[f64], to: &[f64]) -> Result<bool, PlanningError> {
        self.motions += 1;
        self.scene.is_motion_free(self.workspace, [from, to])
    }

    /// Replaces parts of the path by straight motions.
    fn shorten(&mut self, path: &mut Vec<Vec<f64>>) -> Result<(), PlanningError> {
        let (mut kept, mut tried) = (Vec::from_iter(0..path.len()), BTreeSet::new());
        for _ in 0..self.settings.shortcuts {
            if kept.len() < 3 {
                break;
            }
            let first = self.random.below(kept.len() - 2);
            let last = first + 2 + self.random.below(kept.len() - first - 2);
            let (from, to) = (kept[first], kept[last]);
            if tried.insert((from, to)) && self.is_free(&path[from], &path[to])? {
                kept.drain(first + 1..last);
            }
        }
        *path = kept.into_iter().map(|index| core::mem::take(&mut path[index])).collect();
        Ok(())
    }
}
