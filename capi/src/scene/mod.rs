//! Scenes: bodies in the world, by id.

mod ask;
mod edge;

pub use ask::{
    SIMDOP_NO_BODY, simdop_on_hit, simdop_scene_answer, simdop_scene_clearance,
    simdop_scene_clearance_answer, simdop_scene_collide, simdop_scene_each_hit, simdop_scene_hit,
    simdop_scene_hits, simdop_scene_within,
};
pub use edge::{
    SIMDOP_EDGE_ROOM, simdop_motion_answer, simdop_motion_verdict, simdop_scene_check_joint_motion,
    simdop_scene_check_motion, simdop_scene_check_motion_discrete, simdop_scene_check_screw,
};

use crate::body::{Node, simdop_body};
use crate::boundary::{given, guarded, make};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::robot::simdop_robot;
use edge::EdgeRoom;
use simdop::scene::{Body, BodyId, Groups, Scene};
use std::ffi::c_int;
use std::mem::MaybeUninit;

/// In every group, or against every group.
pub const SIMDOP_ALL_GROUPS: u32 = u32::MAX;

/// Bodies, placed in the world.
#[derive(Debug)]
pub struct simdop_scene {
    scene: Scene<'static, Node>,
    room: EdgeRoom,
}

// What the header says of threads.
const _: () = {
    const fn shared_among_threads<T: Send + Sync>() {}
    shared_among_threads::<simdop_body>();
    shared_among_threads::<simdop_scene>();
    shared_among_threads::<simdop_robot>();
};

/// A body in its scene, and in no other one. That of a body which was removed is an error, until its place was taken 2^32 times.
pub type simdop_body_id = u64;

/// What a body is in a scene. Begin with simdop_role_default(): of all zeros it is in no group, and asked against none.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_role {
    /// Everything within this of the body's primitives belongs to it, too. Not negative.
    pub radius: f64,
    /// Not 0: the body stands still. No two of these are asked against each other. It may be placed anew all the same.
    pub is_fixed: c_int,
    /// The groups that the body is in: bit i is group i.
    pub groups: u32,
    /// The groups that it is asked against. Two bodies are, if each is in a group that the other names here.
    pub against: u32,
}

/// A body that moves, of radius 0, in all groups and asked against all.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_role_default() -> simdop_role {
    simdop_role { radius: 0.0, is_fixed: 0, groups: SIMDOP_ALL_GROUPS, against: SIMDOP_ALL_GROUPS }
}

impl simdop_role {
    fn body(&self, body: &'static simdop_body) -> Body<'static, Node> {
        let groups = Groups { of: self.groups, against: self.against };
        let body = Body::new(body.view()).with_radius(self.radius).with_groups(groups);
        if self.is_fixed == 0 { body } else { body.fixed() }
    }
}

/// Does something to a scene.
fn change(
    scene: Option<&mut simdop_scene>,
    change: impl FnOnce(&mut Scene<'static, Node>) -> Result<(), Failure>,
) -> simdop_error {
    guarded(|| change(&mut given(scene, "scene")?.scene))
}

/// Makes a scene without bodies, which grows as they come.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_create(
    scene: Option<&mut MaybeUninit<Option<Box<simdop_scene>>>>,
) -> simdop_error {
    make(scene, "scene", || Ok(simdop_scene { scene: Scene::new(), room: EdgeRoom::default() }))
}

/// Destroys a scene, and none of its bodies. Of NULL, nothing.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_destroy(scene: Option<Box<simdop_scene>>) {
    drop(scene);
}

/// Puts a body into a scene, where it stands at `world`. One body may be put into several scenes, and into one several times.
/// It must stay until it is removed, or the scene is destroyed.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_insert(
    scene: Option<&mut simdop_scene>,
    body: Option<&'static simdop_body>,
    role: Option<&simdop_role>,
    world: Option<&simdop_pose>,
    id: Option<&mut MaybeUninit<simdop_body_id>>,
) -> simdop_error {
    change(scene, |scene| {
        let body = given(role, "role")?.body(given(body, "body")?);
        let world = given(world, "world")?.checked()?;
        given(id, "id")?.write(scene.insert(body, &world)?.to_bits());
        Ok(())
    })
}

/// Takes a body out of a scene. Those that are attached to it stay where they are, and are attached no more.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_remove(scene: Option<&mut simdop_scene>, id: simdop_body_id) -> simdop_error {
    change(scene, |scene| Ok(scene.remove(BodyId::from_bits(id)).map(drop)?))
}

/// Places a body, and those that are attached to it. One that is attached is placed with the other only.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_place(
    scene: Option<&mut simdop_scene>,
    id: simdop_body_id,
    world: Option<&simdop_pose>,
) -> simdop_error {
    change(scene, |scene| {
        let world = given(world, "world")?.checked()?;
        Ok(scene.place(BodyId::from_bits(id), &world)?)
    })
}

/// Attaches a body to another, which it is then placed with: it stays where it is as seen from there.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_attach(
    scene: Option<&mut simdop_scene>,
    id: simdop_body_id,
    to: simdop_body_id,
) -> simdop_error {
    change(scene, |scene| Ok(scene.attach(BodyId::from_bits(id), BodyId::from_bits(to))?))
}

/// Attaches a body no more. It stays where it is. Of a body that is not attached, nothing.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_detach(scene: Option<&mut simdop_scene>, id: simdop_body_id) -> simdop_error {
    change(scene, |scene| Ok(scene.detach(BodyId::from_bits(id))?))
}

/// Allows two bodies to meet, whatever their groups: no question of the scene asks the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_allow_collision(
    scene: Option<&mut simdop_scene>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    change(scene, |scene| Ok(scene.allow_collision(BodyId::from_bits(a), BodyId::from_bits(b))?))
}

/// Forbids two bodies to meet, whatever their groups: all questions of the scene ask the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_forbid_collision(
    scene: Option<&mut simdop_scene>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    change(scene, |scene| Ok(scene.forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b))?))
}
