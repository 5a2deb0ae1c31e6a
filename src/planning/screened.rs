//! Many configurations, decided by bounds where these suffice.

use super::error::PlanningError;
use super::scene::{PlanningScene, stamp};
use super::screen::{Doubts, LANES, LaneVerdicts, OpenPair, Screen, ScreenedScene};
use super::workspace::Workspace;
use crate::node::Box3;
use crate::query::Query;
use crate::scene::BodyId;
use alloc::sync::Arc;
use alloc::vec::Vec;

impl PlanningScene {
    /// Makes [`PlanningScene::free`] faster, with the same verdicts: most configurations are decided by bounds that are
    /// certain, sixteen at a time, and the rest by the scene. The bounds are of the distance to all bodies that stand
    /// still, in cells of this width, such as 0.02 m, one byte each and 4 million at most, and of spheres around and
    /// inside of the links. Every change of the objects computes the cells near them again.
    ///
    /// Tables of pairs of links are made once a robot, which takes 7 s for the Panda and 15 s for a UR5 with a gripper. A
    /// link that is a shape has one sphere around it, which decides less than those of a mesh.
    ///
    /// Where the bounds do not apply, all configurations are decided by the scene: while an object is attached, with a
    /// budget, and for robots whose links cannot be covered by spheres.
    ///
    /// # Errors
    /// [`PlanningError::Cell`] if the width is not positive and finite.
    pub fn use_bounds(&mut self, cell: f64) -> Result<(), PlanningError> {
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(PlanningError::Cell { given: cell });
        }
        self.cell = Some(cell);
        self.stamp = stamp();
        self.set_screen();
        Ok(())
    }

    /// Bytes of the cells of [`PlanningScene::use_bounds`]. `None` where the bounds do not apply.
    #[must_use]
    pub fn bound_bytes(&self) -> Option<usize> {
        self.screen.as_ref().map(|screen| screen.bytes())
    }

    /// Which configurations the bounds of [`PlanningScene::use_bounds`] decide, and how: `None` for one that
    /// [`PlanningScene::free`] decides by the scene.
    ///
    /// # Errors
    /// As [`PlanningScene::free`].
    pub fn free_by_bounds(&self, configurations: &[f64]) -> Result<Vec<Option<bool>>, PlanningError> {
        let count = configurations.len().checked_div(self.variables()).unwrap_or(0);
        Self::check_count(configurations, self.variables(), count)?;
        let (mut workspace, mut verdicts) = (self.workspace(), Vec::new());
        for values in configurations.chunks(LANES * self.variables()) {
            let lanes = values.len() / self.variables();
            let decided = match self.screen.as_ref().zip(workspace.doubts.take()) {
                None => LaneVerdicts { free: 0, hit: 0 },
                Some((screen, mut doubts)) => {
                    let lanes = self.fill_lanes(&mut workspace, values, &mut doubts)?;
                    let decided = screen.decide(self.query.isa(), lanes, &mut doubts);
                    workspace.doubts = Some(doubts);
                    decided
                }
            };
            verdicts.extend((0..lanes).map(|lane| {
                match (decided.free >> lane & 1, decided.hit >> lane & 1) {
                    (0, 0) => None,
                    (free, _) => Some(free == 1),
                }
            }));
        }
        Ok(verdicts)
    }

    /// Makes the bounds, if they are wanted, for the scene as it is now. None where they do not apply, or where what
    /// they ask of the scene is an error: a change of the scene does not fail because of its bounds.
    pub(super) fn set_screen(&mut self) {
        self.screen = self.new_screen().map(Arc::new);
    }

    fn new_screen(&self) -> Option<Screen> {
        // First, since those of a robot are made on request.
        let cell = self.cell?;
        let bounds = self.robot.bounds()?;
        let (objects, placed) = (self.object_ids(), self.workspace_at_rest()?);
        Screen::new(&self.around(&placed, &objects), bounds, cell).ok()?
    }

    /// As [`PlanningScene::set_screen`], after one object was inserted, moved or removed that was in the box `before`.
    pub(super) fn update_screen(&mut self, id: BodyId, before: Option<Box3>) {
        match self.screen.take() {
            None => self.set_screen(),
            Some(screen) => self.screen = self.updated_screen(screen, id, before),
        }
    }

    fn updated_screen(
        &self,
        mut screen: Arc<Screen>,
        id: BodyId,
        before: Option<Box3>,
    ) -> Option<Arc<Screen>> {
        let boxes: Vec<Box3> = [before, self.scene.bounds_of(id).ok()].into_iter().flatten().collect();
        let (objects, placed) = (self.object_ids(), self.workspace_at_rest()?);
        let around = self.around(&placed, &objects);
        let is_made = Arc::make_mut(&mut screen).update(&around, id, &boxes).ok()?;
        is_made.then_some(screen)
    }

    fn object_ids(&self) -> Vec<BodyId> {
        self.objects.iter().map(|(id, _)| *id).collect()
    }

    /// The scene with the robot where it is at the values of variables that are not planned for. `None` if the scene
    /// refuses its poses.
    fn workspace_at_rest(&self) -> Option<Workspace> {
        let values: Vec<f64> = self.variables.iter().map(|&variable| self.rest[variable]).collect();
        let mut workspace = self.workspace();
        self.go_to(&mut workspace, &values).ok()?;
        Some(workspace)
    }

    fn around<'s>(&'s self, placed: &'s Workspace, objects: &'s [BodyId]) -> ScreenedScene<'s> {
        let kinematics = self.kinematics();
        ScreenedScene {
            scene: &placed.scene,
            kinematics,
            links: &self.links,
            objects,
            query: Query::new(self.query.isa()),
        }
    }

    /// Which configurations of a run are free?
    pub(super) fn free_of_job(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        free: &mut [bool],
    ) -> Result<(), PlanningError> {
        let length = self.variables();
        let has_budget = self.query.budget() != u64::MAX;
        // Before its memory is used, which may be that of other bounds.
        self.serve(workspace);
        let screen = self.screen.as_ref().filter(|_| !has_budget);
        let Some((screen, mut doubts)) = screen.zip(workspace.doubts.take()) else {
            for (free, values) in free.iter_mut().zip(values.chunks(length)) {
                *free = self.is_free(workspace, values)?;
            }
            return Ok(());
        };
        let mut sixteen = free.chunks_mut(LANES).zip(values.chunks(LANES * length));
        let found = sixteen
            .try_for_each(|(free, values)| self.free_of_lanes(workspace, values, free, screen, &mut doubts));
        workspace.doubts = Some(doubts);
        found
    }

    /// As [`PlanningScene::free_of_job`], of up to sixteen.
    fn free_of_lanes(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        free: &mut [bool],
        screen: &Screen,
        doubts: &mut Doubts,
    ) -> Result<(), PlanningError> {
        let lanes = self.fill_lanes(workspace, values, doubts)?;
        let decided = screen.decide(self.query.isa(), lanes, doubts);
        for (lane, (free, values)) in free.iter_mut().zip(values.chunks(self.variables())).enumerate() {
            *free = if (decided.free | decided.hit) >> lane & 1 == 1 {
                decided.free >> lane & 1 == 1
            } else {
                self.are_open_pairs_free(workspace, values, screen.open_pairs(lane, doubts))?
            };
        }
        Ok(())
    }

    /// Checks the values of up to sixteen configurations, and writes them to lanes. Returns these.
    fn fill_lanes(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        doubts: &mut Doubts,
    ) -> Result<u16, PlanningError> {
        let (kinematics, mut lanes) = (self.kinematics(), 0);
        let [all, ..] = &mut workspace.values;
        for (lane, values) in values.chunks(self.variables()).enumerate() {
            self.complete(values, all)?;
            kinematics.check(all)?;
            for (of, value) in doubts.values.iter_mut().zip(&*all) {
                of[lane] = *value;
            }
            lanes |= 1 << lane;
        }
        Ok(lanes)
    }

    /// Whether no pair of bodies meets, of those that bounds left open in a configuration. Places these bodies only.
    fn are_open_pairs_free<'s>(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        pairs: impl Iterator<Item = OpenPair<'s>>,
    ) -> Result<bool, PlanningError> {
        self.serve(workspace);
        if !workspace.is_placed {
            self.go_to(workspace, values)?;
        }
        let Workspace { scene, links, poses, values: [all, ..], .. } = workspace;
        self.complete(values, all)?;
        self.kinematics().go_to(all, links, poses)?;
        for pair in pairs {
            let (a, others) = match pair {
                OpenPair::Standing(a, others) => (a, others),
                OpenPair::Own([a, b]) => {
                    scene.place(self.links[b], &poses[b])?;
                    (a, core::slice::from_ref(&self.links[b]))
                }
            };
            scene.place(self.links[a], &poses[a])?;
            for &other in others {
                if scene.do_meet(&self.query, self.links[a], other)? {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use crate::planning::{PlanningScene, RobotFiles};
    use crate::pose::Pose;
    use crate::primitive::Shape;
    use crate::scene::Body;

    /// They take seconds of some robots, which a scene that is not asked for them must not cost.
    #[test]
    fn bounds_of_a_robot_are_made_on_request() {
        let arm = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/arm/arm.urdf");
        let mut scene = PlanningScene::new(RobotFiles::new(arm).load().unwrap()).unwrap();
        let cup = Body::new(Shape::cuboid([0.1; 3]).unwrap());
        let cup = scene.insert("cup", cup, &Pose::IDENTITY.shifted(&[1.0, 0.0, 0.0])).unwrap();
        scene.place(cup, &Pose::IDENTITY.shifted(&[2.0, 0.0, 0.0])).unwrap();
        scene.place_base(&Pose::IDENTITY).unwrap();
        assert!(scene.robot.bounds.get().is_none());
        scene.use_bounds(0.05).unwrap();
        assert!(scene.robot.bounds.get().is_some());
    }
}
