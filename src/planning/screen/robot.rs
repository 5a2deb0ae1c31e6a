//! What is made once for a robot: its bodies as spheres, grids around some of them, and tables of pairs.

use super::chain::LaneChain;
use super::grid::{ClearanceGrid, GridSize, LinkGrids};
use super::links::LinkSpheres;
use super::standing::{PROBE, Standing};
use super::table::{PairTables, tables};
use crate::exact::power_of_two;
use crate::isa::Isa;
use crate::motion::{Kinematics, LinkBody};
use crate::planning::{LinkGeometry, PlanningNode};
use crate::pose::Pose;
use crate::query::Query;
use crate::scene::{Scene, SceneError};
use crate::vector::length;
use alloc::vec;
use alloc::vec::Vec;

/// Cells along the diagonal of a body in the grid around it.
const ALONG: f64 = 64.0;
/// Most cells of such a grid.
const CELLS: f64 = power_of_two(18);
/// Room for the errors of the lanes, relative to a radius.
const MORE: f64 = 1.125;

/// The bounds of a robot, wherever it stands.
#[derive(Clone, Debug)]
pub(in crate::planning) struct RobotBounds {
    /// Of each body.
    pub(super) spheres: Vec<LinkSpheres>,
    pub(super) tables: PairTables,
    pub(super) grids: LinkGrids,
    /// Upper bound of the distance of any point from the base.
    pub(super) size: f64,
}

impl RobotBounds {
    /// With the base at the origin. `None` if a body cannot be covered, or the joints turn or reach too far.
    pub(in crate::planning) fn of(
        kinematics: &Kinematics<'_>,
        bodies: &[LinkGeometry],
        pairs: &[(usize, usize)],
    ) -> Option<Self> {
        let chain = LaneChain::new(kinematics)?;
        let spheres: Vec<LinkSpheres> = bodies.iter().map(LinkSpheres::of).collect::<Option<_>>()?;
        let reach = |(spheres, body): (&LinkSpheres, &LinkBody)| {
            let away = length(&body.at.translation()) + length(&spheres.whole.centre) + spheres.whole.outer;
            chain.reach_from_base(body.link as usize) + 2.0 * away
        };
        let size = spheres.iter().zip(kinematics.bodies()).map(reach).fold(0.0, f64::max);
        let mut bounds =
            Self { spheres, tables: PairTables::default(), grids: vec![None; bodies.len()], size };
        for body in pairs.iter().flat_map(|&(i, j)| [i, j]) {
            if bounds.grids[body].is_none() {
                let at = chain
                    .body_on_link(kinematics.bodies()[body].link as usize, &kinematics.bodies()[body].at);
                let grid = bounds.grid_around(body, &at, &bodies[body]).ok()?;
                bounds.grids[body] = Some((grid, at));
            }
        }
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
        // A body may be in it through a hole and meet nothing.
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
