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
mod cloud;
mod depth;
#[cfg(feature = "urdf")]
mod description;
mod error;
mod motion;
mod packing;
mod pairs;
#[cfg(feature = "planning")]
mod planner;
mod pose;
mod query;
mod range;
mod robot;
mod scene;
mod shape;
mod version;

pub use body::{
    simdop_body, simdop_body_build_hull, simdop_body_build_hull_as, simdop_body_build_packed,
    simdop_body_build_shape, simdop_body_build_shapes, simdop_body_build_shapes_as, simdop_body_build_solid,
    simdop_body_build_solid_with_caps, simdop_body_build_spheres, simdop_body_build_spheres_as,
    simdop_body_build_surface, simdop_body_build_triangles_as, simdop_body_bytes, simdop_body_caps,
    simdop_body_destroy, simdop_body_open, simdop_body_verify, simdop_caps, simdop_storage,
};
pub use cloud::{
    simdop_cloud, simdop_cloud_build, simdop_cloud_build_with_room, simdop_cloud_destroy,
    simdop_cloud_get_size, simdop_cloud_insert, simdop_cloud_rebuild, simdop_cloud_refit,
    simdop_cloud_remove, simdop_cloud_size,
};
pub use depth::{
    simdop_contact, simdop_contacts, simdop_contacts_answer, simdop_depth, simdop_depth_along,
    simdop_depth_answer, simdop_signed_distance, simdop_signed_distance_answer,
};
#[cfg(feature = "urdf")]
pub use description::{
    simdop_described_body, simdop_description, simdop_description_build_body, simdop_description_build_robot,
    simdop_description_destroy, simdop_description_get_body, simdop_description_get_size,
    simdop_description_get_variable, simdop_description_read, simdop_description_select_pairs,
    simdop_description_size, simdop_variable,
};
pub use error::{simdop_error, simdop_error_text, simdop_last_error};
pub use motion::simdop_motion;
pub use packing::{simdop_cover, simdop_on_filling, simdop_pack, simdop_packing};
pub use pairs::{
    simdop_each_pair, simdop_on_pair, simdop_pairs, simdop_penetration, simdop_penetration_answer,
};
#[cfg(feature = "planning")]
pub use planner::{
    simdop_plan_settings, simdop_plan_settings_default, simdop_planned_path, simdop_planner,
    simdop_planner_allow_collision, simdop_planner_attach, simdop_planner_bound_bytes,
    simdop_planner_check_motion, simdop_planner_check_motion_discrete, simdop_planner_check_motions,
    simdop_planner_check_states, simdop_planner_classify_pair, simdop_planner_clearance,
    simdop_planner_clearance_gradient, simdop_planner_copy, simdop_planner_destroy, simdop_planner_detach,
    simdop_planner_each_hit, simdop_planner_forbid_collision, simdop_planner_free_share,
    simdop_planner_get_group, simdop_planner_get_variable, simdop_planner_groups, simdop_planner_insert,
    simdop_planner_limits, simdop_planner_link, simdop_planner_load, simdop_planner_near_robot,
    simdop_planner_place, simdop_planner_place_base, simdop_planner_plan, simdop_planner_random_free,
    simdop_planner_remove, simdop_planner_select_group, simdop_planner_set_budget,
    simdop_planner_set_resolution, simdop_planner_signed_clearance, simdop_planner_to_world,
    simdop_planner_use_bounds, simdop_planner_variables, simdop_planner_within, simdop_random,
    simdop_workspace, simdop_workspace_create, simdop_workspace_destroy,
};
pub use pose::{simdop_pose, simdop_pose_from_quaternion};
pub use query::{
    SIMDOP_NO_BUDGET, SIMDOP_NO_HINT, SIMDOP_NO_PRIMITIVE, simdop_answer, simdop_collide,
    simdop_collide_at_poses, simdop_collide_with_hint, simdop_completion, simdop_distance,
    simdop_distance_answer, simdop_distance_up_to, simdop_distance_with_hint, simdop_hint, simdop_pair,
    simdop_query_stats, simdop_verdict, simdop_within, simdop_within_with_hint,
};
pub use range::{
    simdop_cloud_any_within, simdop_cloud_count, simdop_cloud_each_within, simdop_cloud_nearest,
    simdop_cloud_neighbours, simdop_cloud_neighbours_of, simdop_list, simdop_neighbour,
    simdop_neighbour_lists, simdop_on_point, simdop_range_stats,
};
pub use robot::{
    simdop_joint, simdop_joint_kind, simdop_link_body, simdop_robot, simdop_robot_free, simdop_robot_new,
    simdop_robot_poses,
};
pub use scene::{
    SIMDOP_ALL_GROUPS, SIMDOP_EDGE_ROOM, SIMDOP_NO_BODY, simdop_body_id, simdop_motion_answer,
    simdop_motion_verdict, simdop_on_hit, simdop_pair_class, simdop_pair_report, simdop_role,
    simdop_role_default, simdop_scene, simdop_scene_allow_collision, simdop_scene_answer,
    simdop_scene_attach, simdop_scene_check_joint_motion, simdop_scene_check_joint_states,
    simdop_scene_check_motion, simdop_scene_check_motion_discrete, simdop_scene_check_screw,
    simdop_scene_check_states, simdop_scene_classify_pair, simdop_scene_clearance,
    simdop_scene_clearance_answer, simdop_scene_collide, simdop_scene_create, simdop_scene_create_as,
    simdop_scene_destroy, simdop_scene_detach, simdop_scene_each_hit, simdop_scene_forbid_collision,
    simdop_scene_hit, simdop_scene_hits, simdop_scene_insert, simdop_scene_insert_cloud,
    simdop_scene_is_asked, simdop_scene_place, simdop_scene_place_all, simdop_scene_remove,
    simdop_scene_signed_answer, simdop_scene_signed_clearance, simdop_scene_within, simdop_scene_world_pose,
    simdop_states_answer,
};
pub use shape::{simdop_shape, simdop_shape_kind};
pub use version::{SIMDOP_VERSION, simdop_version};
