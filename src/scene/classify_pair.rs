//! Classifies a pair of bodies over all values of a robot's joints: does it meet never, always, or sometimes?
//!
//! The search tests a box of joint values at its middle. Anywhere in the box, no point of one body is nearer to a point
//! of the other than at the middle by more than the motion bound along the box's diagonal
//! ([`Motion::motion_bound_between`]), which sums each joint's share. So two bodies that are farther apart than this at
//! the middle are free in the whole box, and two whose triangles cross more deeply meet in the whole box. Any other box
//! is halved, along the joint whose share is greatest.

use super::ask::AskedPair;
use super::body::{BodyId, BodyTree};
use super::check_motion::motion_bound_of_pair;
use super::error::SceneError;
use super::placement::Scene;
use crate::motion::{JointMotion, Kinematics, LinkFrame, Motion};
use crate::node::Dop;
use crate::pose::Pose;
use crate::primitive::triangle::deep::cross_after;
use crate::primitive::{Primitive, Triangles};
use crate::query::{Lanes, Query, Verdict};
use alloc::collections::VecDeque;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::ControlFlow;

/// Whether two bodies meet, over all values of the joints within their limits.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub enum PairClass {
    /// At no values: the pair need not be tested.
    Never,
    /// At all values.
    Always,
    /// At some values, and not at others.
    Sometimes,
    /// The limit on the number of boxes was reached before the class was certain.
    Undecided,
}

/// The class of a pair, and the configurations that were found.
#[derive(Clone, PartialEq, Debug)]
pub struct PairReport {
    /// The class.
    pub fate: PairClass,
    /// Values at which the two meet, if any were found.
    pub meeting: Option<Vec<f64>>,
    /// Values at which they do not meet, if any were found.
    pub free: Option<Vec<f64>>,
    /// Number of boxes tested.
    pub boxes: usize,
}

/// Lower and upper values of the variables.
type Values = [Vec<f64>; 2];

impl<N: Lanes> Scene<'_, N> {
    /// Whether two bodies meet within the limits of a robot's joints. `moving` lists the scene's bodies in the order of
    /// the robot's bodies. All others stand still. Tests at most `boxes` boxes of values.
    ///
    /// # Errors
    /// [`SceneError`]: as [`Scene::check_motion`], [`SceneError::NoPair`] of a body and itself, and
    /// [`SceneError::TwoClouds`].
    pub fn classify_pair(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        robot: Kinematics<'_>,
        (a, b): (BodyId, BodyId),
        boxes: usize,
    ) -> Result<PairReport, SceneError> {
        self.search_classes(query, moving, robot, (a, b), |search| search.run(boxes))
    }

    fn search_classes<T>(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        robot: Kinematics<'_>,
        (a, b): (BodyId, BodyId),
        run: impl FnOnce(ClassSearch<'_, '_, '_, N>) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let (i, j) = self.place_to_ask(a, b)?;
        let mut poses = vec![Pose::IDENTITY; 2 * robot.bodies().len()];
        let (poses, before) = self.set_out(moving, robot.bodies().len(), &mut poses)?;
        let leaves = [i, j]
            .map(|i| self.memory.slots[i].body.as_ref().map_or_else(Vec::new, |body| leaves(&body.tree)));
        let links = vec![LinkFrame::EMPTY; robot.links()];
        let search = ClassSearch { scene: self, query, moving, robot, pair: [i, j], poses, links, leaves };
        let found = run(search);
        self.place_all(moving, before)?;
        found
    }

    /// Passes a question: what is certain of two bodies in a box of values? It is also certain if both come nearer to
    /// each other by a length, or go apart.
    #[cfg(feature = "planning")]
    pub(crate) fn ask_boxes<T>(
        &mut self,
        query: &Query,
        moving: &[BodyId],
        robot: Kinematics<'_>,
        pair: (BodyId, BodyId),
        with: impl FnOnce(
            &mut dyn FnMut(&[Vec<f64>; 2], f64) -> Result<BoxClass, SceneError>,
        ) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        self.search_classes(query, moving, robot, pair, |mut search| {
            with(&mut |values, more| {
                search.go_to_middle(values)?;
                let is_meeting = search.is_within(0.0)?;
                Ok(BoxClass {
                    is_meeting,
                    is_everywhere: search.is_everywhere(values, is_meeting, more)?,
                    path: search.motion_bound(values, 0.0)? + more,
                    poses: [pair.0, pair.1].map(|id| search.scene.memory.slots[id.index as usize].world),
                })
            })
        })
    }
}

/// Two bodies in a box of joint values.
#[cfg(feature = "planning")]
#[derive(Copy, Clone, Debug)]
pub(crate) struct BoxClass {
    /// Whether they meet at its middle.
    pub(crate) is_meeting: bool,
    /// Whether they certainly do, or do not, in all of it.
    pub(crate) is_everywhere: bool,
    /// Upper bound of how much any point of one moves relative to the other, compared with the middle.
    pub(crate) path: f64,
    /// Where they are at the middle.
    pub(crate) poses: [Pose; 2],
}

struct ClassSearch<'s, 't, 'm, N> {
    scene: &'s mut Scene<'t, N>,
    query: &'m Query,
    moving: &'m [BodyId],
    robot: Kinematics<'m>,
    pair: [usize; 2],
    poses: &'m mut [Pose],
    links: Vec<LinkFrame>,
    leaves: [Vec<u32>; 2],
}

impl<N: Lanes> ClassSearch<'_, '_, '_, N> {
    fn run(mut self, most: usize) -> Result<PairReport, SceneError> {
        let limits = self.robot.limits();
        let whole = [0, 1].map(|end| limits.iter().map(|limits| limits[end]).collect::<Vec<f64>>());
        let mut waiting = VecDeque::from([whole]);
        let mut report = PairReport { fate: PairClass::Undecided, meeting: None, free: None, boxes: 0 };
        while let Some(values) = waiting.pop_front() {
            if report.boxes == most {
                return Ok(report);
            }
            report.boxes += 1;
            self.go_to_middle(&values)?;
            let is_meeting = self.is_within(0.0)?;
            let seen = if is_meeting { &mut report.meeting } else { &mut report.free };
            if seen.is_none() {
                *seen = Some(middle(&values));
            }
            if report.meeting.is_some() && report.free.is_some() {
                return Ok(PairReport { fate: PairClass::Sometimes, ..report });
            }
            let widest = self.widest(&values)?;
            let is_everywhere =
                is_meeting && widest.is_none() || self.is_everywhere(&values, is_meeting, 0.0)?;
            match widest {
                _ if is_everywhere => {}
                Some(variable) => waiting.extend(halves(&values, variable)),
                None => return Ok(report),
            }
        }
        let fate = if report.meeting.is_some() { PairClass::Always } else { PairClass::Never };
        Ok(PairReport { fate, ..report })
    }

    /// Whether bodies that meet, or do not meet, at the middle of a box of values, where they stand, certainly do so in
    /// all of it, also if they come nearer to each other by another `more`, or go apart.
    fn is_everywhere(&mut self, values: &Values, is_meeting: bool, more: f64) -> Result<bool, SceneError> {
        if is_meeting {
            return self.meets_after(values, more);
        }
        let path = self.motion_bound(values, 0.0)? + more;
        Ok(path.is_finite() && !self.is_within_reach(path)?)
    }

    /// Places the bodies at the middle of a box of values.
    fn go_to_middle(&mut self, values: &Values) -> Result<(), SceneError> {
        let mut now = vec![0.0; values[0].len()];
        let ends = [&*values[0], &*values[1]];
        JointMotion::new(self.robot, ends, &mut now, &mut self.links)?.go_to(0.5, self.poses)?;
        self.scene.place_all(self.moving, self.poses)
    }

    /// Upper bound of how much the bodies, and all points at most `beyond` away from the balls around them, approach
    /// each other anywhere in a box, compared with its middle, where they stand.
    fn motion_bound(&mut self, values: &Values, beyond: f64) -> Result<f64, SceneError> {
        let mut now = vec![0.0; values[0].len()];
        let ends = [&*values[0], &*values[1]];
        let mut motion = JointMotion::new(self.robot, ends, &mut now, &mut self.links)?;
        motion.go_to(0.5, self.poses)?;
        let slots = self.pair.map(|i| &self.scene.memory.slots[i]);
        Ok(motion_bound_of_pair(&motion, slots, beyond, 0.5))
    }

    /// The variable with the greatest relative motion of the two bodies. `None` if none moves them.
    fn widest(&mut self, values: &Values) -> Result<Option<usize>, SceneError> {
        let middle = middle(values);
        let mut line = [middle.clone(), middle.clone()];
        let (mut most, mut widest) = (self.motion_bound(&line, 0.0)?, None);
        for variable in 0..middle.len() {
            for (end, values) in line.iter_mut().zip(values) {
                end[variable] = values[variable];
            }
            let path = self.motion_bound(&line, 0.0)?;
            for end in &mut line {
                end[variable] = middle[variable];
            }
            if path > most {
                (most, widest) = (path, Some(variable));
            }
        }
        Ok(widest)
    }

    /// Whether two bodies that meet at the middle of a box certainly meet in all of it.
    fn meets_after(&mut self, values: &Values, more: f64) -> Result<bool, SceneError> {
        let [a, b] = self.pair.map(|i| &self.scene.memory.slots[i]);
        // Where they meet, a primitive of one may reach beyond the ball of the other.
        let moved = self.motion_bound(values, 2.0 * (a.size.whole_reach() + b.size.whole_reach()))? + more;
        let [a, b] = self.pair.map(|i| &self.scene.memory.slots[i]);
        let asked = AskedPair::new([a, b], [&a.world, &b.world]);
        if asked.radii > 0.0 {
            // 1e-3 of the radii covers the effect of a matrix that is not quite a rotation.
            let deep = -(moved + 1e-3 * asked.radii);
            // A body inside of a solid may get out through a cap.
            let has_caps = asked.trees.0.caps().is_some() || asked.trees.1.caps().is_some();
            return Ok(deep + asked.radii > 0.0 && !has_caps && self.is_within(deep)?);
        }
        let (BodyTree::Mesh(tree_a), BodyTree::Mesh(tree_b)) = &asked.trees else { return Ok(false) };
        let (pose, mut is_deep) = (asked.relative.pose(), false);
        let _ = self.query.for_each_pair(tree_a, tree_b, pose, |pair| {
            let of = |sources: &[u32], source: u32| sources[source as usize];
            let a = tree_a.primitive(of(&self.leaves[0], pair.a));
            let b = tree_b.primitive(of(&self.leaves[1], pair.b));
            is_deep = cross_after(&Triangles::moved(&a, pose), &b, moved);
            if is_deep { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        Ok(is_deep)
    }

    fn is_within(&self, margin: f64) -> Result<bool, SceneError> {
        let [a, b] = self.pair.map(|i| i as u32);
        let answer = self.scene.ask_within(self.query, &self.scene.pair_now(a, b), margin)?;
        Ok(matches!(answer.verdict, Verdict::Hit(_)))
    }

    /// As `is_within`, of the bodies and their caps.
    fn is_within_reach(&self, margin: f64) -> Result<bool, SceneError> {
        let [a, b] = self.pair.map(|i| i as u32);
        let answer = self.scene.ask_within_reach(self.query, &self.scene.pair_now(a, b), margin)?;
        Ok(matches!(answer.verdict, Verdict::Hit(_)))
    }
}

/// Maps the index of a primitive in the builder's input to its position in leaf order.
fn leaves<N: Dop>(tree: &BodyTree<'_, N>) -> Vec<u32> {
    let BodyTree::Mesh(tree) = tree.view() else { return Vec::new() };
    let mut leaves = vec![0; tree.len()];
    for i in 0..tree.len() as u32 {
        leaves[tree.source(i) as usize] = i;
    }
    leaves
}

fn middle([low, high]: &Values) -> Vec<f64> {
    low.iter().zip(high).map(|(low, high)| low + 0.5 * (high - low)).collect()
}

fn halves(values: &Values, variable: usize) -> [Values; 2] {
    let middle = middle(values)[variable];
    [1, 0].map(|end| {
        let mut half = values.clone();
        half[end][variable] = middle;
        half
    })
}
