//! Bodies that stand still, and the bodies of the robot that are tested against them.

use super::blocks::{Radii16, all_lanes, radii};
use super::bodies::{LaneBody, ScreenedScene};
use super::grid::ClearanceGrid;
use super::lanes::LANES;
use super::table::PairTable;
use crate::scene::{BodyId, SceneError};
use alloc::vec::Vec;

/// Bodies that stand still, and the moving bodies that are tested against all of them.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// The moving bodies, in ascending order.
    pub(super) key: Vec<usize>,
    pub(super) grid: ClearanceGrid,
    pub(super) standing: Vec<BodyId>,
    pub(super) asked: Vec<AskedBody>,
}

#[derive(Clone, Debug)]
pub(super) struct AskedBody {
    pub(super) body: usize,
    /// Used instead of the spheres, for a body that one variable moves.
    pub(super) table: Option<PairTable>,
    pub(super) whole: Radii16,
    pub(super) coarse: Radii16,
    pub(super) fine: Vec<Radii16>,
    /// How much the sphere around it, and the spheres of its covers, may be enlarged.
    pub(super) room: [f32; 2],
}

impl Field {
    /// The field of the moving bodies with the indices `key`. `more` is the allowance of tables.
    pub(super) fn new(
        around: &ScreenedScene<'_>,
        bodies: &[LaneBody],
        (key, standing): (Vec<usize>, Vec<BodyId>),
        grid: ClearanceGrid,
        more: f64,
    ) -> Result<Self, SceneError> {
        let of = |outer: f64, inner: f64| grid.radii(outer, inner);
        let ask = |&body: &usize| {
            let LaneBody { whole, coarse, fine, .. } = &bodies[body];
            let pairs = (around.links, &standing[..]);
            let table = match bodies[body].carrier == body {
                true => PairTable::of_body(&around.kinematics, around.scene, body, pairs, more)?,
                // An attached object has no table.
                false => None,
            };
            let largest = coarse.iter().chain(fine).map(|sphere| sphere.outer).fold(0.0, f64::max);
            Ok(AskedBody {
                body,
                room: [whole.outer, largest].map(|outer| grid.room(outer)),
                table,
                whole: all_lanes(of(whole.outer, whole.inner)),
                coarse: radii(coarse, of),
                fine: fine.chunks(LANES).map(|block| radii(block, of)).collect(),
            })
        };
        let mut asked = key.iter().map(ask).collect::<Result<Vec<AskedBody>, SceneError>>()?;
        asked.retain(|asked| !asked.table.as_ref().is_some_and(PairTable::is_free));
        // The last links of an arm meet something most often, so they come first.
        asked.reverse();
        Ok(Self { key, grid, standing, asked })
    }
}
