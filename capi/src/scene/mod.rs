//! Scenes: bodies in the world, by id.

mod ask;
mod classify;
mod edge;
mod states;

pub use ask::{
    SIMDOP_NO_BODY, simdop_on_hit, simdop_scene_answer, simdop_scene_clearance,
    simdop_scene_clearance_answer, simdop_scene_collide, simdop_scene_each_hit, simdop_scene_hit,
    simdop_scene_hits, simdop_scene_signed_answer, simdop_scene_signed_clearance, simdop_scene_within,
};
#[cfg(feature = "planning")]
pub(crate) use classify::report_of;
pub use classify::{simdop_pair_class, simdop_pair_report, simdop_scene_classify_pair};
pub use edge::{
    SIMDOP_EDGE_ROOM, simdop_motion_answer, simdop_motion_verdict, simdop_scene_check_joint_motion,
    simdop_scene_check_motion, simdop_scene_check_motion_discrete, simdop_scene_check_screw,
};
pub use states::{simdop_scene_check_joint_states, simdop_scene_check_states, simdop_states_answer};

use crate::body::{Node, simdop_body, simdop_storage};
use crate::boundary::{answered, given, guarded, items, make};
use crate::cloud::simdop_cloud;
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::robot::simdop_robot;
use edge::EdgeRoom;
use simdop::low_level::key::{Fixed, Half, Storage, StorageKind};
use simdop::node::Dop;
use simdop::scene::{Body, BodyId, BodyTree, Groups, Scene};
use std::ffi::c_int;
use std::mem::MaybeUninit;

/// All groups.
pub const SIMDOP_ALL_GROUPS: u32 = u32::MAX;

/// A set of bodies at poses in the world.
#[derive(Debug)]
pub struct simdop_scene {
    pub(crate) scene: AnyScene,
    /// Whether the storage was chosen, or a body was ever inserted. Then the storage is final, since ids outlive their
    /// bodies.
    has_storage: bool,
    room: EdgeRoom,
}

/// A scene of bodies of one storage.
#[derive(Debug)]
pub(crate) enum AnyScene {
    Fixed(Scene<'static, Node<Fixed>>),
    Half(Scene<'static, Node<Half>>),
}

impl AnyScene {
    fn new(storage: StorageKind) -> Self {
        match storage {
            StorageKind::Fixed => Self::Fixed(Scene::new()),
            StorageKind::Half => Self::Half(Scene::new()),
        }
    }

    const fn storage(&self) -> StorageKind {
        match self {
            Self::Fixed(_) => StorageKind::Fixed,
            Self::Half(_) => StorageKind::Half,
        }
    }
}

/// Evaluates an expression with the scene of either storage.
macro_rules! with_scene {
    ($any:expr, |$scene:ident| $with:expr) => {
        match $any {
            $crate::scene::AnyScene::Fixed($scene) => $with,
            $crate::scene::AnyScene::Half($scene) => $with,
        }
    };
}

pub(crate) use with_scene;

// The header promises these properties.
const _: () = {
    const fn shared_among_threads<T: Send + Sync>() {}
    shared_among_threads::<simdop_body>();
    shared_among_threads::<simdop_cloud>();
    shared_among_threads::<simdop_scene>();
    shared_among_threads::<simdop_robot>();
};

/// The id of a body in its scene, and in no other. The id of a removed body is an error until its slot has been reused
/// 2^32 times.
pub type simdop_body_id = u64;

/// The role of a body in a scene. Start from simdop_role_default(): a body whose role is all zeros is tested against
/// nothing.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_role {
    /// The body includes everything within this distance of its primitives. Not negative.
    pub radius: f64,
    /// Nonzero: the body stands still. Pairs of such bodies are not tested. simdop_scene_place() may still move it.
    pub is_fixed: c_int,
    /// The groups that the body is in: bit i is group i.
    pub groups: u32,
    /// The groups that it is tested against. A pair is tested if each body is in a group that the other lists here.
    pub against: u32,
}

/// A moving body of radius 0, in all groups and tested against all.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_role_default() -> simdop_role {
    simdop_role { radius: 0.0, is_fixed: 0, groups: SIMDOP_ALL_GROUPS, against: SIMDOP_ALL_GROUPS }
}

impl simdop_role {
    pub(crate) fn body<S: Storage>(
        &self,
        tree: impl Into<BodyTree<'static, Node<S>>>,
    ) -> Body<'static, Node<S>> {
        let groups = Groups { of: self.groups, against: self.against };
        let body = Body::new(tree).with_radius(self.radius).with_groups(groups);
        if self.is_fixed == 0 { body } else { body.fixed() }
    }
}

/// Applies a change to a scene.
macro_rules! change {
    ($any:expr, |$scene:ident| $change:expr) => {
        guarded(|| Ok(with_scene!(&mut given($any, "scene")?.scene, |$scene| $change)?))
    };
}

/// Creates an empty scene. It grows as bodies are inserted. The first body decides the storage of all bodies of the
/// scene. If it is one shape or a cloud, which have no storage, the scene takes fixed point.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_create(
    scene: Option<&mut MaybeUninit<Option<Box<simdop_scene>>>>,
) -> simdop_error {
    make(scene, "scene", || {
        let scene = AnyScene::new(StorageKind::default());
        Ok(simdop_scene { scene, has_storage: false, room: EdgeRoom::default() })
    })
}

/// Creates an empty scene of bodies in `storage`, a simdop_storage, whatever body is inserted first.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_create_as(
    storage: c_int,
    scene: Option<&mut MaybeUninit<Option<Box<simdop_scene>>>>,
) -> simdop_error {
    make(scene, "scene", || {
        let scene = AnyScene::new(match simdop_storage::checked(storage)? {
            simdop_storage::Fixed => StorageKind::Fixed,
            simdop_storage::Half => StorageKind::Half,
        });
        Ok(simdop_scene { scene, has_storage: true, room: EdgeRoom::default() })
    })
}

/// Destroys a scene, but none of its bodies. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_destroy(scene: Option<Box<simdop_scene>>) {
    drop(scene);
}

/// Inserts a body into a scene at the pose `world`. A body may be inserted into several scenes, and several times into
/// one. It must exist until it is removed or the scene is destroyed.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_insert(
    scene: Option<&mut simdop_scene>,
    body: Option<&'static simdop_body>,
    role: Option<&simdop_role>,
    world: Option<&simdop_pose>,
    id: Option<&mut MaybeUninit<simdop_body_id>>,
) -> simdop_error {
    guarded(|| {
        let simdop_scene { scene, has_storage, .. } = given(scene, "scene")?;
        let (role, view) = (given(role, "role")?, given(body, "body")?.view());
        let (world, id) = (given(world, "world")?.checked()?, given(id, "id")?);
        let storage = view.storage().unwrap_or_else(|| scene.storage());
        if !*has_storage && scene.storage() != storage {
            *scene = AnyScene::new(storage);
        }
        let inserted = if let (AnyScene::Fixed(scene), Some(view)) = (&mut *scene, view.fixed()) {
            scene.insert(role.body(view), &world)?
        } else if let (AnyScene::Half(scene), Some(view)) = (&mut *scene, view.half()) {
            scene.insert(role.body(view), &world)?
        } else {
            let message = format!("a body of {storage} in a scene of {}: build it again", scene.storage());
            return Err(Failure::new(simdop_error::OtherStorage, message));
        };
        *has_storage = true;
        id.write(inserted.to_bits());
        Ok(())
    })
}

/// Inserts a cloud into a scene, as a body whose primitives are its points: they must not change until it is removed.
/// Two clouds are never tested against each other. Otherwise like simdop_scene_insert().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_insert_cloud(
    scene: Option<&mut simdop_scene>,
    cloud: Option<&'static simdop_cloud>,
    role: Option<&simdop_role>,
    world: Option<&simdop_pose>,
    id: Option<&mut MaybeUninit<simdop_body_id>>,
) -> simdop_error {
    answered(id, || {
        let simdop_scene { scene, has_storage, .. } = given(scene, "scene")?;
        let (role, view) = (given(role, "role")?, given(cloud, "cloud")?.view());
        let world = given(world, "world")?.checked()?;
        let inserted = with_scene!(scene, |scene| scene.insert(role.body(view), &world))?;
        *has_storage = true;
        Ok(inserted.to_bits())
    })
}

/// Removes a body from a scene. The bodies attached to it stay where they are, and are no longer attached.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_remove(scene: Option<&mut simdop_scene>, id: simdop_body_id) -> simdop_error {
    change!(scene, |scene| scene.remove(BodyId::from_bits(id)).map(drop))
}

/// Sets the pose of a body, and moves the bodies attached to it along. An attached body cannot be placed itself.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_place(
    scene: Option<&mut simdop_scene>,
    id: simdop_body_id,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| {
        let (scene, world) = (given(scene, "scene")?, given(world, "world")?.checked()?);
        Ok(with_scene!(&mut scene.scene, |scene| scene.place(BodyId::from_bits(id), &world))?)
    })
}

/// Places `count` bodies, like as many calls of simdop_scene_place(). After a failure, the bodies before the one at
/// fault are placed.
///
/// # Safety
/// The arrays have this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_place_all(
    scene: Option<&mut simdop_scene>,
    ids: *const simdop_body_id,
    worlds: *const simdop_pose,
    count: usize,
) -> simdop_error {
    guarded(|| {
        let scene = &mut given(scene, "scene")?.scene;
        // SAFETY: the caller guarantees the length.
        let ids = unsafe { items(ids, count, "ids") }?;
        // SAFETY: as above.
        let worlds = unsafe { items(worlds, count, "worlds") }?;
        with_scene!(scene, |scene| place_all(scene, ids, worlds))
    })
}

fn place_all<N: Dop>(
    scene: &mut Scene<'static, N>,
    ids: &[simdop_body_id],
    worlds: &[simdop_pose],
) -> Result<(), Failure> {
    for (i, (id, world)) in ids.iter().zip(worlds).enumerate() {
        let placed = match world.checked() {
            Ok(world) => scene.place(BodyId::from_bits(*id), &world).map_err(Failure::from),
            Err(error) => Err(error.into()),
        };
        placed.map_err(|failure| failure.of(&format!("body {i}")))?;
    }
    Ok(())
}

/// Writes the pose of a body in the world. The pose of an attached body includes the moves of the body that it is
/// attached to.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_world_pose(
    scene: Option<&simdop_scene>,
    id: simdop_body_id,
    world: Option<&mut MaybeUninit<simdop_pose>>,
) -> simdop_error {
    answered(world, || {
        let scene = &given(scene, "scene")?.scene;
        Ok(with_scene!(scene, |scene| scene.world_pose(BodyId::from_bits(id)))?.into())
    })
}

/// Attaches a body to another, at its current pose relative to it. Placing the other then moves it along.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_attach(
    scene: Option<&mut simdop_scene>,
    id: simdop_body_id,
    to: simdop_body_id,
) -> simdop_error {
    change!(scene, |scene| scene.attach(BodyId::from_bits(id), BodyId::from_bits(to)))
}

/// Detaches a body. It stays where it is. Does nothing for a body that is not attached.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_detach(scene: Option<&mut simdop_scene>, id: simdop_body_id) -> simdop_error {
    change!(scene, |scene| scene.detach(BodyId::from_bits(id)))
}

/// Allows two bodies to meet, whatever their groups: no query of the scene tests the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_allow_collision(
    scene: Option<&mut simdop_scene>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    change!(scene, |scene| scene.allow_collision(BodyId::from_bits(a), BodyId::from_bits(b)))
}

/// Forbids two bodies to meet, whatever their groups: all queries of the scene test the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_forbid_collision(
    scene: Option<&mut simdop_scene>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    change!(scene, |scene| scene.forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b)))
}

/// Writes 1 to `is_asked` if the queries of the scene test a pair of bodies, and otherwise 0.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_is_asked(
    scene: Option<&simdop_scene>,
    a: simdop_body_id,
    b: simdop_body_id,
    is_asked: Option<&mut MaybeUninit<c_int>>,
) -> simdop_error {
    answered(is_asked, || {
        let scene = &given(scene, "scene")?.scene;
        let is_asked =
            with_scene!(scene, |scene| scene.is_asked(BodyId::from_bits(a), BodyId::from_bits(b)))?;
        Ok(is_asked.into())
    })
}
