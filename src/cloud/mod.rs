//! Points that move: trees of boxes over them, and all neighbours within a radius, exactly.
//!
//! Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017. Points lie in [buckets](crate::node::Bucket) of
//! up to sixteen, under [nodes](crate::node::Aabb16) of sixteen boxes each. Points that move keep their buckets: [`CloudMut::refit`] makes the
//! boxes anew, in one pass from below, until the boxes have grown so much that another tree pays ([`Upkeep`]).
//! [`RangeSearch`] answers queries; those of one bucket go down the tree together (coherent search).
//! With the feature `gpu`, `gpu::DeviceCloud` answers them on a device, in the same order.
//!
//! ```
//! use simdop::cloud::{PointCloud, Queries, Radii, RangeSearch};
//! use simdop::isa::Isa;
//!
//! let mut points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]];
//! let mut cloud = PointCloud::new(&points)?;
//! let search = RangeSearch::new(Isa::detect());
//! let mut counts = [0; 4];
//! search.count(&cloud.view(), &Queries::own(), Radii::Same(1.0), &mut counts)?;
//! assert_eq!(counts, [3, 2, 2, 1], "each point is its own neighbour, and what touches the sphere is in it");
//!
//! points[3] = [1.0, 1.0, 0.0];
//! cloud.refit(&points)?;
//! search.count(&cloud.view(), &Queries::own(), Radii::Same(1.0), &mut counts)?;
//! assert_eq!(counts, [3, 3, 3, 3]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What near means
//!
//! Point p is a neighbour of query q with radius r where `(x * x + y * y) + z * z <= r * r`, with x, y, z the differences
//! of their coordinates, every operation rounded to `f32` and none of them fused: what a loop over all points would
//! compute. The tree finds neither more nor less, on every machine (the [law](crate::low_level::kernel), 7).
//!
//! Coordinates are any finite `f32`, in any unit. Squares of differences below 1e-23 are nothing in `f32`, so points that
//! near to each other count as one; and those above 1.8e19 are infinite, which is no neighbour unless `r * r` is infinite as well.
//!
//! # Memory
//!
//! Searches, refits, insertions and removals never allocate, and nothing here recurses but the build, whose depth is that of the
//! tree's halvings: a thread with 32 KiB of stack is enough for all of it, whatever the cloud, as `tests/cloud/memory.rs` checks.

mod body;
mod bytes;
mod distance;
mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
mod insert;
mod median;
#[cfg(feature = "alloc")]
mod owned;
mod packet;
mod search;
mod single;
mod sink;
#[cfg(feature = "alloc")]
mod split;
mod store;
mod upkeep;

mod view;

pub use body::Contact;
pub use bytes::{CLOUD_MAGIC, CLOUD_VERSION};
pub use error::{CloudError, SearchError};
#[cfg(feature = "alloc")]
pub use owned::PointCloud;
pub use packet::{Queries, Radii, Seat};
pub use search::{List, RangeSearch, RangeStats};
pub use single::Neighbour;
pub use store::{CloudMut, Memory, buckets_for, nodes_for};

pub use upkeep::{Policy, Upkeep};
pub use view::CloudRef;

/// A cloud has at most this many points, since a link counts as many buckets.
pub const MAX_POINTS: usize = crate::node::Child::MAX_PRIMITIVES as usize;

/// Points in a bucket, at most.
pub const BUCKET_SIZE: u32 = 16;
