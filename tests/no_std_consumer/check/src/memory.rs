//! The scene's memory: statics, as in firmware, and no heap.

use crate::RING;
use crate::scene::{Arm, BODIES, Failed, WAITING};
use simdop::node::{Aabb16, Node16};
use simdop::scene::{MotionHit, Scene, SceneMemory, Slot, boxes_for, rows_for};
use static_cell::ConstStaticCell;

static SLOTS: ConstStaticCell<[Slot<'static, Node16<18>>; BODIES]> =
    ConstStaticCell::new([const { Slot::EMPTY }; BODIES]);
static BOXES: ConstStaticCell<[Aabb16; boxes_for(BODIES)]> =
    ConstStaticCell::new([Aabb16::EMPTY; boxes_for(BODIES)]);
static ROWS: ConstStaticCell<[u16; rows_for(BODIES)]> = ConstStaticCell::new([0; rows_for(BODIES)]);
static PAIRS: ConstStaticCell<[MotionHit; WAITING]> = ConstStaticCell::new([MotionHit::EMPTY; WAITING]);

/// The arm in its scene, and memory for its motions; `None` the second time.
///
/// # Errors
/// If the scene rejects its bodies.
// Inlined for the same reason as [`crate::crosses`].
#[inline]
pub fn arm() -> Result<Option<(Arm<'static>, &'static mut [MotionHit])>, Failed> {
    let (Some(slots), Some(boxes), Some(rows), Some(waiting)) =
        (SLOTS.try_take(), BOXES.try_take(), ROWS.try_take(), PAIRS.try_take())
    else {
        return Ok(None);
    };
    let scene = Scene::in_memory(SceneMemory { slots, boxes, rows })?;
    let ring = RING.view().map_err(|_| Failed)?;
    Ok(Some((Arm::new(scene, ring)?, waiting)))
}
