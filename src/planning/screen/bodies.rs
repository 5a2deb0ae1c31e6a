//! The bodies of a robot, as spheres on its links.

use super::apart;
use super::blocks::{LaneSphere, block};
use super::chain::LaneChain;
use super::lanes::{LANES, Lane16, Point16};
use super::links::{Concentric, LinkSpheres};
use super::robot::RobotBounds;
use crate::exact::power_of_two;
use crate::motion::Kinematics;
use crate::planning::PlanningNode;
use crate::pose::Pose;
use crate::query::Query;
use crate::scene::{BodyId, Scene, SceneError};
use crate::vector::length;
use alloc::vec::Vec;

/// Maximum distance of the base from the world's origin, in sizes of the robot.
const MOST_AWAY: f64 = power_of_two(8);
/// Allowance for the rounding of the scene's poses, relative to the coordinates.
const SCENE: f64 = power_of_two(-36);

/// The scene that a screen is made for.
#[derive(Copy, Clone, Debug)]
pub(in crate::planning) struct ScreenedScene<'s> {
    pub(in crate::planning) scene: &'s Scene<'static, PlanningNode>,
    pub(in crate::planning) kinematics: Kinematics<'s>,
    pub(in crate::planning) links: &'s [BodyId],
    pub(in crate::planning) objects: &'s [BodyId],
    /// Has no budget.
    pub(in crate::planning) query: Query,
}

/// A body of the robot, or one that is attached to it.
#[derive(Clone, Debug)]
pub(super) struct LaneBody {
    pub(super) link: usize,
    pub(super) id: BodyId,
    /// Index of the robot's body that it is, or that it is attached to.
    pub(super) carrier: usize,
    pub(super) whole: LaneSphere,
    pub(super) coarse: Vec<LaneSphere>,
    pub(super) fine: Vec<LaneSphere>,
    pub(super) coarse_centres: Point16,
    pub(super) fine_centres: Vec<Point16>,
    /// For each coarse sphere, the fine ones that it meets, which cover the part of the body in it.
    pub(super) below: [u64; LANES],
    /// Radius of the sphere around it, for comparison with those of other bodies of the robot.
    pub(super) whole_radius: Lane16,
}

impl LaneBody {
    /// Whether a joint moves it.
    pub(super) const fn is_moving(&self) -> bool {
        self.link > 0
    }

    pub(super) fn spheres(&self) -> impl Iterator<Item = &LaneSphere> {
        self.coarse.iter().chain(&self.fine).chain([&self.whole])
    }
}

/// The bodies of the robot, and then the objects that are attached to them. `None` if one cannot be covered.
pub(super) fn lane_bodies(
    around: &ScreenedScene<'_>,
    chain: &LaneChain,
    bounds: &RobotBounds,
) -> Result<Option<Vec<LaneBody>>, SceneError> {
    if chain.reach(0) > MOST_AWAY * bounds.size {
        return Ok(None);
    }
    let of_robot = around.kinematics.bodies().iter().zip(around.links).zip(&bounds.spheres).enumerate();
    let mut bodies: Vec<Option<LaneBody>> = of_robot
        .map(|(carrier, ((body, &id), spheres))| {
            LaneBody::new(chain, (body.link as usize, &body.at), (id, carrier), spheres)
        })
        .collect();
    for &id in around.objects {
        let Some((to, at)) = around.scene.attachment(id)? else { continue };
        let spheres = LinkSpheres::of_body(around.scene.tree(id)?, around.scene.radius(id)?);
        let carrier = around.links.iter().position(|link| *link == to);
        bodies.push(carrier.zip(spheres).and_then(|(carrier, spheres)| {
            let body = &around.kinematics.bodies()[carrier];
            LaneBody::new(chain, (body.link as usize, &body.at.after(&at)), (id, carrier), &spheres)
        }));
    }
    Ok(bodies.into_iter().collect())
}

impl LaneBody {
    /// `None` if the scene would refuse the body's pose.
    fn new(
        chain: &LaneChain,
        (link, at): (usize, &Pose),
        (id, carrier): (BodyId, usize),
        spheres: &LinkSpheres,
    ) -> Option<Self> {
        if at.deviation() > 0.5 * Scene::<PlanningNode>::TOLERANCE {
            return None;
        }
        let lane = |sphere: &Concentric| lane_sphere(chain, link, at, sphere);
        let whole = lane(&spheres.whole);
        let coarse: Vec<LaneSphere> = spheres.coarse.iter().map(lane).collect();
        let fine: Vec<LaneSphere> = spheres.fine.iter().map(lane).collect();
        Some(Self {
            link,
            id,
            carrier,
            whole_radius: [apart::radius(whole.outer); LANES],
            coarse_centres: block(&coarse),
            fine_centres: fine.chunks(LANES).map(block).collect(),
            below: below(&coarse, &fine),
            whole,
            coarse,
            fine,
        })
    }
}

/// For each coarse sphere, the fine ones that it meets.
fn below(coarse: &[LaneSphere], fine: &[LaneSphere]) -> [u64; LANES] {
    let do_meet = |a: &LaneSphere, b: &LaneSphere| {
        let apart = [0, 1, 2].map(|i| f64::from(a.centre[i]) - f64::from(b.centre[i]));
        // Centres are off by less than the radii exceed those of the covers.
        length(&apart) <= (a.outer + b.outer) * (1.0 + power_of_two(-20))
    };
    let mut below = [0; LANES];
    for (below, coarse) in below.iter_mut().zip(coarse) {
        for (i, fine) in fine.iter().enumerate() {
            *below |= u64::from(do_meet(coarse, fine)) << i;
        }
    }
    below
}

fn lane_sphere(chain: &LaneChain, link: usize, at: &Pose, sphere: &Concentric) -> LaneSphere {
    let on_link = at.unflushed(&sphere.centre);
    let centre = chain.on_link(link, &on_link);
    let scene = SCENE * (chain.reach(link) + length(&on_link) + sphere.outer);
    let off = chain.error(link, &centre) + scene;
    let skew = at.skew();
    LaneSphere {
        centre: centre.map(|x| x as f32),
        outer: sphere.outer * (1.0 + skew) + off,
        inner: sphere.inner * (1.0 - skew) - off,
    }
}
