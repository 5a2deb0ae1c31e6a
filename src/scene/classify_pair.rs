//! Classifies a pair of bodies over all values of a robot's joints: do they meet never, always, or sometimes?
//!
//! Random values find most pairs that sometimes meet long before boxes of values do, and testing one costs a small part
//! of testing a box. So some are tested first, and some more with each box. They are the same in every run.
//!
//! The search tests a box of joint values at its middle. Relative to the middle, no two points of the bodies approach
//! each other anywhere in the box by more than the motion bound along the box's diagonal
//! ([`Motion::motion_bound_between`]), which sums each joint's share. So two bodies that are farther apart than this at
//! the middle are free in the whole box, and two whose triangles cross more deeply meet in the whole box. The search
//! halves any other box along the joint with the largest share.

use super::ask::AskedPair;
use super::body::{BodyId, BodyTree};
use super::check_motion::finite_or_infinite;
use super::error::SceneError;
use super::placement::Scene;
use crate::exact::power_of_two;
use crate::motion::{CarriedBall, JointMotion, Kinematics, LinkFrame, Motion};
use crate::node::Dop;
use crate::pose::Pose;
use crate::primitive::triangle::deep::cross_after;
use crate::primitive::{Primitive, Triangles};
use crate::query::{Lanes, Query, Verdict};
use crate::random::SplitMix64;
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

/// The class of a pair, and example configurations.
#[derive(Clone, PartialEq, Debug)]
pub struct PairReport {
    /// The class.
    pub class: PairClass,
    /// Values at which the two meet, if any were found.
    pub meeting: Option<Vec<f64>>,
    /// Values at which they do not meet, if any were found.
    pub free: Option<Vec<f64>>,
    /// Number of boxes tested.
    pub boxes: usize,
    /// Number of random configurations tested.
    pub samples: usize,
}

/// Number of random configurations before the first box, with each box, and at most in all.
const SAMPLES_FIRST: usize = 64;
const SAMPLES_OF_A_BOX: usize = 8;
const MOST_SAMPLES: usize = 1 << 16;

impl PairReport {
    /// Whether the two meet at some values, and not at others.
    const fn is_both(&self) -> bool {
        self.meeting.is_some() && self.free.is_some()
    }

    fn saw(&mut self, is_meeting: bool, values: impl FnOnce() -> Vec<f64>) {
        let seen = if is_meeting { &mut self.meeting } else { &mut self.free };
        if seen.is_none() {
            *seen = Some(values());
        }
    }
}

/// Lower and upper values of the variables.
type Values = [Vec<f64>; 2];

impl<N: Lanes> Scene<'_, N> {
    /// Do two bodies meet never, always, or sometimes, within the limits of a robot's joints? `moving` lists the
    /// scene's bodies in the order of the robot's bodies. All others stand still. Tests at most `boxes` boxes of
    /// values, and eight times as many random configurations, but at least 64 and at most 65,536.
    ///
    /// # Errors
    /// [`SceneError`]: as [`Scene::check_motion`], [`SceneError::NoPair`] for a body and itself, and
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

    /// Passes `with` a function that classifies the bodies in a box of values. The class stays certain if the bodies
    /// approach or recede by another length, the function's second argument.
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
    /// Whether the same certainly holds in the whole box.
    pub(crate) is_everywhere: bool,
    /// Upper bound of how far any point of one moves relative to the other, compared with the middle.
    pub(crate) path: f64,
    /// Their poses at the middle.
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
        let mut report =
            PairReport { class: PairClass::Undecided, meeting: None, free: None, boxes: 0, samples: 0 };
        let (mut random, roots) = (SplitMix64(1), self.roots());
        while let Some(values) = waiting.pop_front() {
            let samples = (SAMPLES_FIRST + SAMPLES_OF_A_BOX * report.boxes).min(MOST_SAMPLES);
            while !report.is_both() && report.samples < samples {
                report.samples += 1;
                let values = self.go_to_random(&roots, &mut random)?;
                report.saw(self.is_within(0.0)?, || values);
            }
            if report.is_both() || report.boxes == most {
                break;
            }
            report.boxes += 1;
            self.go_to_middle(&values)?;
            let is_meeting = self.is_within(0.0)?;
            report.saw(is_meeting, || middle(&values));
            if report.is_both() {
                break;
            }
            let widest = self.widest(&values)?;
            let is_everywhere =
                is_meeting && widest.is_none() || self.is_everywhere(&values, is_meeting, 0.0)?;
            match widest {
                _ if is_everywhere => {}
                Some(variable) => waiting.extend(halves(&values, variable)),
                None => return Ok(report),
            }
            report.class = match (waiting.is_empty(), &report.meeting) {
                (false, _) => PairClass::Undecided,
                (true, Some(_)) => PairClass::Always,
                (true, None) => PairClass::Never,
            };
        }
        let class = if report.is_both() { PairClass::Sometimes } else { report.class };
        Ok(PairReport { class, ..report })
    }

    /// The moving bodies that move the pair, by index.
    fn roots(&self) -> Vec<usize> {
        let carrier = |i: &usize| self.scene.memory.slots[*i].carrier.map(|carrier| carrier as usize);
        self.pair.iter().filter_map(carrier).collect()
    }

    /// Places the pair at random values, and returns these.
    fn go_to_random(&mut self, roots: &[usize], random: &mut SplitMix64) -> Result<Vec<f64>, SceneError> {
        let mut value = |[low, high]: &[f64; 2]| {
            // Rounding may push the sum beyond the ends.
            (low + (high - low) * (random.bits() as f64 * power_of_two(-64))).clamp(*low, *high)
        };
        let values: Vec<f64> = self.robot.limits().iter().map(&mut value).collect();
        self.robot.go_to(&values, &mut self.links, self.poses)?;
        for &root in roots {
            self.scene.place(self.moving[root], &self.poses[root])?;
        }
        Ok(values)
    }

    /// Whether the verdict at the middle of a box of values, where the bodies stand, certainly holds in the whole box,
    /// even if they approach or recede by another `more`.
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
    /// each other anywhere in a box, compared with its middle, where the bodies stand.
    fn motion_bound(&mut self, values: &Values, beyond: f64) -> Result<f64, SceneError> {
        let mut now = vec![0.0; values[0].len()];
        let ends = [&*values[0], &*values[1]];
        let mut motion = JointMotion::new(self.robot, ends, &mut now, &mut self.links)?;
        motion.go_to(0.5, self.poses)?;
        let [a, b] = self.pair.map(|i| {
            let slot = &self.scene.memory.slots[i];
            let ball = slot.size.ball(&slot.world);
            let carrier = slot.carrier.map(|carrier| carrier as usize);
            (carrier, CarriedBall { radius: ball.radius + beyond, ..ball })
        });
        let path = motion.least_bound_between((a.0, &a.1), (b.0, &b.1), 0.5);
        Ok(finite_or_infinite(path))
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

    /// Whether two bodies that meet at the middle of a box certainly meet in the whole box.
    fn meets_after(&mut self, values: &Values, more: f64) -> Result<bool, SceneError> {
        let [a, b] = self.pair.map(|i| &self.scene.memory.slots[i]);
        // A primitive of one that meets the other may reach beyond the other's ball.
        let moved = self.motion_bound(values, 2.0 * (a.size.whole_reach() + b.size.whole_reach()))? + more;
        let [a, b] = self.pair.map(|i| &self.scene.memory.slots[i]);
        let asked = AskedPair::new([a, b], [&a.world, &b.world]);
        if asked.radii > 0.0 {
            // 1e-3 of the radii covers the effect of a matrix that is not quite a rotation.
            let deep = -(moved + 1e-3 * asked.radii);
            // A body inside a solid may get out through a cap.
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

    /// As `is_within`, for the bodies and their caps.
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
