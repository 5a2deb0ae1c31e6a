//! The bodies of a robot that move, as spheres on links.

use super::apart;
use super::blocks::{LaneSphere, Radii16, all_lanes, centres, radii};
use super::chain::LaneChain;
use super::lanes::Point16;
use super::links::Concentric;
use super::robot::RobotBounds;
use crate::exact::power_of_two;
use crate::motion::Kinematics;
use crate::planning::PlanningNode;
use crate::pose::Pose;
use crate::query::Query;
use crate::scene::{BodyId, Scene};
use crate::vector::length;
use alloc::vec::Vec;

/// Farthest distance of the base, in sizes of the robot.
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
    /// Without a budget.
    pub(in crate::planning) query: Query,
}

/// A body that moves.
#[derive(Clone, Debug)]
pub(super) struct LaneBody {
    /// Index among the bodies of the robot.
    pub(super) body: usize,
    pub(super) link: usize,
    pub(super) id: BodyId,
    pub(super) whole: LaneSphere,
    pub(super) coarse: Vec<LaneSphere>,
    pub(super) fine: Vec<LaneSphere>,
    pub(super) coarse_centres: Vec<Point16>,
    pub(super) fine_centres: Vec<Point16>,
    /// Against other bodies that move.
    pub(super) whole_radii: Radii16,
    pub(super) coarse_radii: Vec<Radii16>,
    pub(super) fine_radii: Vec<Radii16>,
}

impl LaneBody {
    pub(super) fn spheres(&self) -> impl Iterator<Item = &LaneSphere> {
        self.coarse.iter().chain(&self.fine).chain([&self.whole])
    }
}

pub(super) fn lane_bodies(
    around: &ScreenedScene<'_>,
    chain: &LaneChain,
    bounds: &RobotBounds,
) -> Option<Vec<LaneBody>> {
    let mut bodies = Vec::new();
    if chain.reach(0) > MOST_AWAY * bounds.size {
        return None;
    }
    let all = around.kinematics.bodies().iter().zip(around.links).zip(&bounds.spheres);
    for (i, ((body, &id), spheres)) in all.enumerate() {
        let link = body.link as usize;
        // What a scene refuses is not screened.
        if body.at.deviation() > 0.5 * Scene::<PlanningNode>::TOLERANCE {
            return None;
        }
        if link == 0 {
            continue;
        }
        let lane = |sphere: &Concentric| lane_sphere(chain, link, &body.at, sphere);
        let whole = lane(&spheres.whole);
        let coarse: Vec<LaneSphere> = spheres.coarse.iter().map(lane).collect();
        let fine: Vec<LaneSphere> = spheres.fine.iter().map(lane).collect();
        bodies.push(LaneBody {
            body: i,
            link,
            id,
            whole_radii: all_lanes(apart::radii(whole.outer, whole.inner)),
            coarse_radii: radii(&coarse, apart::radii),
            fine_radii: radii(&fine, apart::radii),
            coarse_centres: centres(&coarse),
            fine_centres: centres(&fine),
            whole,
            coarse,
            fine,
        });
    }
    Some(bodies)
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
