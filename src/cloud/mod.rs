//! Bounding box hierarchies over moving points, with exact neighbour queries within a radius.
//!
//! After Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017. Points are stored
//! in [buckets](crate::node::Bucket) of up to sixteen, below [nodes](crate::node::Aabb16) of sixteen boxes each.
//! Points stay in their buckets when they move: [`CloudMut::refit`] recomputes the boxes in one bottom-up pass, and
//! [`Upkeep`] decides when the boxes have grown so much that a rebuild pays. [`RangeSearch`] answers queries; the
//! queries of one bucket traverse the tree together (coherent search). With the feature `gpu`, `gpu::DeviceCloud`
//! answers them on a GPU, in the same order.
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
//! # Definition of a neighbour
//!
//! Point p is a neighbour of query q with radius r if `(x * x + y * y) + z * z <= r * r`, where x, y, z are the
//! differences of their coordinates. Every operation is rounded to `f32` and none is fused, as in a plain loop over
//! all points. The search returns exactly these points, on every machine (rule 7 of the [kernel
//! law](crate::low_level::kernel)).
//!
//! Coordinates may be any finite `f32`, in any unit. The square of a difference below 1e-23 is 0 in
//! `f32`, so points that close count as coincident. The square of a difference above 1.8e19 is infinite: such points
//! are neighbours only if `r * r` is infinite too.
//!
//! # Memory
//!
//! Searches, refits, insertions and removals never allocate. Only the build recurses, as deep as its halvings. 32 KiB
//! of stack is enough for all operations on any cloud; `tests/cloud/memory.rs` checks it.

mod body;
mod bytes;
#[cfg(feature = "alloc")]
mod depth_image;
mod distance;
mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
mod insert;
mod list;
mod median;
#[cfg(feature = "alloc")]
mod owned;
mod packet;
mod search;
mod shape;
mod single;
mod sink;
#[cfg(feature = "alloc")]
mod split;
mod store;
mod upkeep;
mod view;

pub use body::Contact;
pub(crate) use body::points_of;
pub use bytes::{CLOUD_MAGIC, CLOUD_VERSION};
#[cfg(feature = "alloc")]
pub use depth_image::{DepthImage, DepthImageError, Pinhole};
pub use error::{CloudError, SearchError};
pub use list::List;
#[cfg(feature = "alloc")]
pub use owned::PointCloud;
pub use packet::{Queries, Radii, Seat};
pub use search::{RangeSearch, RangeStats};
pub use single::Neighbour;
pub use store::{CloudMut, Memory, buckets_for, nodes_for};
pub use upkeep::{Policy, Upkeep};
pub use view::CloudRef;

/// The maximum number of points in a cloud. A link can address as many buckets.
pub const MAX_POINTS: usize = crate::node::Child::MAX_PRIMITIVES as usize;

/// The maximum number of points in a bucket.
pub const BUCKET_SIZE: u32 = 16;
