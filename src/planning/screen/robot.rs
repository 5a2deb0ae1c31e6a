//! Data computed once per robot: its bodies as spheres, grids around some of them, and tables of pairs.

use super::chain::LaneChain;
use super::grid::{ClearanceGrid, GridSize, LinkGrids};
use super::links::LinkSpheres;
use super::standing::{PROBE, Standing};
use super::table::{PairTables, tables};
use crate::exact::power_of_two;
use crate::isa::Isa;
use crate::motion::{Kinematics, LinkBody};
use crate::parallel;
use crate::planning::{LinkGeometry, PlanningNode};
use crate::pose::Pose;
use crate::query::Query;
use crate::scene::{Scene, SceneError};
use crate::vector::length;
use alloc::vec;
use alloc::vec::Vec;

/// Number of cells along the diagonal of a body, in the grid around it.
const ALONG: f64 = 64.0;
/// Maximum number of cells of such a grid.
const CELLS: f64 = power_of_two(18);
/// Allowance for the errors of the lanes, relative to a radius.
const MORE: f64 = 1.125;

/// The bounds of a robot that do not depend on its surroundings.
#[derive(Clone, Debug)]
pub(in crate::planning) struct RobotBounds {
    /// The spheres of each body.
    pub(super) spheres: Vec<LinkSpheres>,
    pub(super) tables: PairTables,
    pub(super) grids: LinkGrids,
    /// Upper bound of the distance of any point from the base.
    pub(super) size: f64,
}

impl RobotBounds {
    /// The bounds of a robot, with its base at the origin. `None` if a body cannot be covered, or the joints rotate or
    /// reach too far.
    pub(in crate::planning) fn of(
        kinematics: &Kinematics<'_>,
        bodies: &[LinkGeometry],
        pairs: &[(usize, usize)],
    ) -> Option<Self> {
        let chain = LaneChain::new(kinematics)?;
        let mut spheres = vec![None; bodies.len()];
        let jobs = spheres.iter_mut().zip(bodies).collect();
        parallel::for_each(jobs, |(): &mut (), (spheres, body)| *spheres = LinkSpheres::of(body));
        let spheres: Vec<LinkSpheres> = spheres.into_iter().collect::<Option<_>>()?;
        let reach = |(spheres, body): (&LinkSpheres, &LinkBody)| {
            let away = length(&body.at.translation()) + length(&spheres.whole.centre) + spheres.whole.outer;
            chain.reach_from_base(body.link as usize) + 2.0 * away
        };
        let size = spheres.iter().zip(kinematics.bodies()).map(reach).fold(0.0, f64::max);
        let mut bounds =
            Self { spheres, tables: PairTables::default(), grids: vec![None; bodies.len()], size };
        let mut grids = bounds.grids.clone();
        let is_of_a_pair = |body: usize| pairs.iter().any(|&(i, j)| i == body || j == body);
        let jobs = grids.iter_mut().enumerate().filter(|(body, _)| is_of_a_pair(*body)).collect();
        parallel::for_each(jobs, |(): &mut (), (body, grid)| {
            let on_link = &kinematics.bodies()[body];
            let at = chain.body_on_link(on_link.link as usize, &on_link.at);
            *grid = bounds.grid_around(body, &at, &bodies[body]).ok().map(|grid| (grid, at));
        });
        if (0..bodies.len()).any(|body| is_of_a_pair(body) && grids[body].is_none()) {
            return None;
        }
        bounds.grids = grids;
        let of = (bodies, &bounds.spheres[..], &bounds.grids);
        bounds.tables = tables(kinematics, of, pairs, size).ok()?;
        Some(bounds)
    }

    /// Bytes of its tables and grids.
    pub(super) fn bytes(&self) -> usize {
        self.tables.bytes() + self.grids.iter().flatten().map(|(grid, _)| grid.bytes()).sum::<usize>()
    }

    /// A grid around a body, for the spheres of all others.
    fn grid_around(
        &self,
        index: usize,
        at: &Pose,
        geometry: &LinkGeometry,
    ) -> Result<ClearanceGrid, SceneError> {
        let others = self.spheres.iter().enumerate().filter(|(other, _)| *other != index);
        let spheres = || others.clone().flat_map(|(_, of)| of.coarse.iter().chain(&of.fine));
        let outer = spheres().map(|sphere| sphere.outer).fold(0.0, f64::max) * MORE;
        let mut scene: Scene<'static, PlanningNode> = Scene::new();
        let id = scene.insert(geometry.body(), at)?;
        // A body may reach in through a hole and meet nothing.
        let has_caps = scene.has_caps(id)?;
        let inner = if has_caps { 0.0 } else { spheres().map(|sphere| sphere.inner).fold(0.0, f64::max) };
        let bounds = scene.bounds_of(id)?;
        let sides = [0, 1, 2].map(|i| f64::from(bounds.upper[i]) - f64::from(bounds.lower[i]));
        let volume = sides.iter().map(|side| side + 2.0 * outer).product::<f64>();
        let cell = (length(&sides) / ALONG).max(libm::cbrt(volume / CELLS));
        let room = outer + 3.0 * cell;
        let low = bounds.lower.map(|x| f64::from(x) - room);
        let high = bounds.upper.map(|x| f64::from(x) + room);
        let mut still = Standing::new(&scene, &[id], PROBE * cell, &Query::new(Isa::detect()))?;
        ClearanceGrid::new(&mut still, [low, high], GridSize { cell, outer: outer + 2.0 * cell, inner })
    }
}
