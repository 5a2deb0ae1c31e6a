//! The C interface of simdop. The rules for callers (pointers, lifetimes, threads, errors) stand at the head of
//! `include/simdop.h`, which cbindgen generates from this crate: all names and comments here are written for C.
//!
//! A pointer that may be NULL is an `Option` of a reference or of a `Box`, which has the layout of a C pointer. The
//! type system then covers its target; only arrays and callbacks need `unsafe`.
//!
//! Nothing unwinds into C: code that can panic runs in `boundary::guarded`.
#![expect(non_camel_case_types, reason = "the names are those of C")]

mod body;
mod boundary;
mod error;
mod motion;
mod pose;
mod query;
mod reversed;
mod robot;
mod scene;
mod shape;

pub use body::{
    simdop_body, simdop_body_build_hull, simdop_body_build_hull_as, simdop_body_build_shape,
    simdop_body_build_shapes, simdop_body_build_shapes_as, simdop_body_build_solid,
    simdop_body_build_solid_with_caps, simdop_body_build_spheres, simdop_body_build_spheres_as,
    simdop_body_build_surface, simdop_body_build_triangles_as, simdop_body_bytes, simdop_body_caps,
    simdop_body_destroy, simdop_body_open, simdop_caps, simdop_storage,
};
pub use error::{simdop_error, simdop_error_text, simdop_last_error};
pub use motion::simdop_motion;
pub use pose::{simdop_pose, simdop_pose_from_quaternion};
pub use query::{
    SIMDOP_NO_BUDGET, SIMDOP_NO_PRIMITIVE, simdop_answer, simdop_collide, simdop_completion, simdop_distance,
    simdop_distance_answer, simdop_pair, simdop_query_stats, simdop_verdict, simdop_within,
};
pub use robot::{
    simdop_joint, simdop_joint_kind, simdop_link_body, simdop_robot, simdop_robot_free, simdop_robot_new,
    simdop_robot_poses,
};
pub use scene::{
    SIMDOP_ALL_GROUPS, SIMDOP_EDGE_ROOM, SIMDOP_NO_BODY, simdop_body_id, simdop_motion_answer,
    simdop_motion_verdict, simdop_on_hit, simdop_role, simdop_role_default, simdop_scene,
    simdop_scene_allow_collision, simdop_scene_answer, simdop_scene_attach, simdop_scene_check_joint_motion,
    simdop_scene_check_motion, simdop_scene_check_motion_discrete, simdop_scene_check_screw,
    simdop_scene_clearance, simdop_scene_clearance_answer, simdop_scene_collide, simdop_scene_create,
    simdop_scene_create_as, simdop_scene_destroy, simdop_scene_detach, simdop_scene_each_hit,
    simdop_scene_forbid_collision, simdop_scene_hit, simdop_scene_hits, simdop_scene_insert,
    simdop_scene_place, simdop_scene_remove, simdop_scene_within,
};
pub use shape::{simdop_shape, simdop_shape_kind};
