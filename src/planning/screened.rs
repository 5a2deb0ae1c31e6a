//! Decides many configurations by bounds where these suffice.

use super::error::PlanningError;
use super::scene::{PlanningScene, stamp};
use super::screen::{Doubts, LANES, LaneVerdicts, OpenPair, Screen, ScreenedScene};
use super::workspace::Workspace;
use crate::motion::MotionError;
use crate::node::Box3;
use crate::query::Query;
use crate::scene::BodyId;
use alloc::sync::Arc;
use alloc::vec::Vec;

impl PlanningScene {
    /// Speeds up [`PlanningScene::free`] and motion queries without changing a verdict: conservative bounds decide most
    /// configurations, and most spans of motions, sixteen at a time; the scene decides the rest. The bounds use a grid
    /// of distances to all bodies that stand still, with cells of this width, such as 0.02 m, one byte each and 4
    /// million at most, and spheres around and inside the links. Every change of the objects recomputes the cells near
    /// them.
    ///
    /// Spheres, grids and tables of the links are computed once per robot, on all threads with the feature `rayon`.
    /// That takes seconds for links that are meshes: the bench `lanes` measures it. A link that is a shape has one
    /// sphere around it, which decides less than the spheres of a mesh; so has an attached object.
    ///
    /// The scene decides everything if the bounds do not apply: with a budget, for robots whose links cannot be covered
    /// by spheres, and while an object is attached that is neither a shape nor a mesh.
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

    /// Bytes of the cells of [`PlanningScene::use_bounds`]. `None` if the bounds do not apply.
    #[must_use]
    pub fn bound_bytes(&self) -> Option<usize> {
        self.screen.as_ref().map(|screen| screen.bytes())
    }

    /// The verdicts of the bounds of [`PlanningScene::use_bounds`]: `None` for a configuration that
    /// [`PlanningScene::free`] leaves to the scene.
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

    /// Makes the bounds for the current scene, if they are wanted. Makes none if they do not apply, or if a query of
    /// the scene fails: a change of the scene does not fail because of its bounds.
    pub(super) fn set_screen(&mut self) {
        self.screen = self.new_screen().map(Arc::new);
    }

    fn new_screen(&self) -> Option<Screen> {
        // Checked first, since a robot's bounds are made on request.
        let cell = self.cell?;
        let bounds = self.robot.bounds()?;
        let (objects, placed) = (self.object_ids(), self.workspace_at_rest()?);
        Screen::new(&self.around(&placed, &objects), bounds, cell).ok()?
    }

    /// As [`PlanningScene::set_screen`], after one object, previously in the box `before`, was inserted, moved or
    /// removed.
    pub(super) fn update_screen(&mut self, id: BodyId, before: Option<Box3>) {
        match self.screen.take() {
            // An update does not change the bodies that move.
            Some(screen) if !screen.moves(id) => self.screen = self.updated_screen(screen, id, before),
            _ => self.set_screen(),
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

    /// The scene with the robot at the values of the variables that are not planned for. `None` if the scene refuses a
    /// pose.
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

    /// Which configurations of a job are free?
    pub(super) fn free_of_job(
        &self,
        workspace: &mut Workspace,
        values: &[f64],
        free: &mut [bool],
    ) -> Result<(), PlanningError> {
        let length = self.variables();
        let has_budget = self.query.budget() != u64::MAX;
        // Called before the workspace's memory is used, which may belong to other bounds.
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

    /// As [`PlanningScene::free_of_job`], for up to sixteen configurations.
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

    /// Checks the values of up to sixteen configurations, and writes them to lanes. Returns the mask of these lanes.
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

    /// Whether no pair of bodies that the bounds left open in a configuration meets. Places only these bodies.
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
        self.complete(values, &mut workspace.values[0])?;
        self.are_pairs_free(workspace, pairs)
    }

    /// As [`PlanningScene::are_open_pairs_free`], at the values of all variables in the workspace, which may be those
    /// of a motion.
    pub(super) fn are_pairs_free<'s>(
        &self,
        workspace: &mut Workspace,
        pairs: impl Iterator<Item = OpenPair<'s>>,
    ) -> Result<bool, PlanningError> {
        let Workspace { scene, links, poses, values: [all, ..], .. } = workspace;
        self.kinematics().place(all, links, poses).map_err(MotionError::from)?;
        for pair in pairs {
            let ((id, carrier), others) = match pair {
                OpenPair::Standing(moved, others) => (moved, others),
                OpenPair::Own([moved, (ref other, carrier)]) => {
                    scene.place(self.links[carrier], &poses[carrier])?;
                    (moved, core::slice::from_ref(other))
                }
            };
            scene.place(self.links[carrier], &poses[carrier])?;
            for &other in others {
                if scene.do_meet(&self.query, id, other)? {
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

    /// They take seconds for some robots, which a scene that does not use them must not cost.
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
