//! Queries between two hierarchies of one node type, at a pose: no heap, a fixed stack, exact verdicts.
//!
//! [`Query`] holds the settings, above all the instruction set; its methods are the queries.
//!
//! A query allocates nothing, and several poses or pairs have no state to share: a loop is as fast as any batch.
//! [`Query`], [`BvhRef`] and [`Pose`] are `Copy`, `Send` and `Sync`: threads (`std::thread::scope`, rayon) can divide
//! the poses, and the answers are those of a single thread:
//!
//! ```
//! # use simdop::{Builder, Isa, Mesh, Pose, Query};
//! # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
//! # let poses: Vec<Pose> = [0.1, 0.7, 1.5, 9.0].into_iter()
//! #     .map(|x| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap())
//! #     .collect();
//! let (view, query) = (body.view(), Query::new(Isa::detect()));
//! let mut free = vec![false; poses.len()];
//! let share = poses.len().div_ceil(2);
//! std::thread::scope(|scope| {
//!     for (poses, free) in poses.chunks(share).zip(free.chunks_mut(share)) {
//!         scope.spawn(move || {
//!             for (pose, free) in poses.iter().zip(free) {
//!                 *free = query.collide(&view, &view, pose).is_free();
//!             }
//!         });
//!     }
//! });
//! assert_eq!(free, [false, false, true, true]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod any;
mod collide;
mod contacts;
mod containment;
mod depth;
mod distance;
mod entry;
mod lanes;
mod setup;
mod shape;
mod volume;

pub use any::AnyError;
pub use collide::STACK_BYTES;
pub use contacts::{ContactPatch, Contacts, TooManyPatches, TriangleContact, patches};
pub(crate) use depth::{ByQueries, depth_along_by, depth_by, half_space_depth};
pub use depth::{DepthInterval, Packings, SignedDistance};
pub use distance::{DISTANCE_STACK_BYTES, Distance, Witness};
pub(crate) use entry::checked;
pub use entry::{Answer, Completion, Hint, Pair, PrimitivePair, Query, QueryStats, ToleranceError, Verdict};
pub use lanes::{Compare, Lanes};
pub use volume::{PENETRATION_QUEUE_BYTES, Penetration};

#[cfg(doc)]
use crate::{hierarchy::BvhRef, pose::Pose};
