//! Collision, range and distance queries over many bodies placed in the world.
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use simdop::{Builder, Isa, Mesh, Pose, Query};
//! use simdop::scene::{Body, Scene};
//!
//! let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let tree = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
//! let at = |x: f64| Pose::try_from((DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)));
//!
//! let mut scene = Scene::new();
//! let table = scene.insert(Body::new(tree.view()).fixed(), &at(0.0)?)?;
//! let hand = scene.insert(Body::new(tree.view()), &at(3.0)?)?;
//! let cup = scene.insert(Body::new(tree.view()).with_radius(0.01), &at(4.5)?)?;
//! scene.allow_collision(hand, cup)?; // the hand holds the cup
//! scene.attach(cup, hand)?;          // which moves with it
//!
//! let query = Query::new(Isa::detect());
//! assert!(scene.collide(&query)?.is_free());
//! scene.place(hand, &at(-1.0)?)?;
//! let hit = scene.collide(&query)?.hit().unwrap();
//! assert_eq!((hit.a, hit.b), (cup, table));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Verdicts hold for the given world poses.** Free is certain: no two tested bodies meet, in exact arithmetic on the
//! coordinates and poses of both. A hit is exact up to the rounding of the relative pose, about 1e-14 of the
//! coordinates ([`crate::pose::Relative`]): bodies closer than this count as meeting. A composed pose, such as the pose
//! of an attached body, is rounded first, and the verdict holds for the rounded pose.
//!
//! **Method.** The SIMD kernels of the point search compare the bodies' bounding boxes in the world, sixteen at a time.
//! A bit matrix selects the pairs to test. Overlapping pairs go to [`crate::query`], the deepest first.
//!
//! **Stack.** Scenes need as much as the queries do ([`crate::query`]): on a Cortex-M4F, 10 KB in all for a scene query
//! and 11 KB for a motion query.

mod ask;
mod body;
mod body_size;
mod broad;
mod check_motion;
mod check_states;
#[cfg(feature = "alloc")]
mod classify_pair;
mod error;
mod memory;
mod pairs;
mod placement;
mod signed_clearance;
#[cfg(feature = "planning")]
mod some_pairs;
mod two_bodies;

pub use ask::{SceneAnswer, SceneDistance, SceneHit, SceneVerdict, SceneWitness};
#[cfg(feature = "alloc")]
pub use body::SharedTree;
pub use body::{Body, BodyId, BodyTree, Groups};
#[cfg(feature = "planning")]
pub(crate) use check_motion::{Interval, check_resolution};
pub use check_motion::{MotionAnswer, MotionHit, MotionMemory, MotionVerdict};
pub use check_states::ConfigurationsAnswer;
#[cfg(feature = "planning")]
pub(crate) use classify_pair::BoxClass;
#[cfg(feature = "alloc")]
pub use classify_pair::{PairClass, PairReport};
pub use error::SceneError;
pub use memory::{SceneMemory, Slot, boxes_for, rows_for};
pub use placement::Scene;
#[cfg(feature = "planning")]
pub(crate) use placement::check as check_pose;
pub use signed_clearance::{SceneSignedDistance, SignedWitness};
