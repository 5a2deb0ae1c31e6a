//! What is made once for a robot: its bodies as spheres, and tables of pairs.

use super::chain::LaneChain;
use super::links::LinkSpheres;
use super::table::{PairTables, tables};
use crate::motion::Kinematics;
use crate::planning::LinkGeometry;
use crate::vector::length;
use alloc::vec::Vec;

/// The bounds of a robot, wherever it stands.
#[derive(Clone, Debug)]
pub(in crate::planning) struct RobotBounds {
    /// Of each body.
    pub(super) spheres: Vec<LinkSpheres>,
    pub(super) tables: PairTables,
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
        let reach = |(spheres, body): (&LinkSpheres, &crate::motion::LinkBody)| {
            let away = length(&body.at.translation()) + length(&spheres.whole.centre) + spheres.whole.outer;
            chain.reach_from_base(body.link as usize) + 2.0 * away
        };
        let size = spheres.iter().zip(kinematics.bodies()).map(reach).fold(0.0, f64::max);
        let tables = tables(kinematics, (bodies, &spheres), pairs, size).ok()?;
        Some(Self { spheres, tables, size })
    }
}
