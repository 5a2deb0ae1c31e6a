//! Exact collision and distance queries between triangle meshes, on hierarchies of k-DOPs that SIMD kernels test
//! sixteen at a time. The library is `no_std`, queries do not allocate, and trees are byte blocks that are used in
//! place, even from flash.
//!
//! ```
//! use simdop::{Builder, Isa, Mesh, Pose, Query};
//!
//! // A tetrahedron, against a copy of itself.
//! let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let mesh = Mesh { vertices: &vertices, triangles: &triangles };
//! let body = Builder::new().build(&mesh)?; // k = 18, arity 16
//!
//! let query = Query::new(Isa::detect()); // once
//! let apart = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1e-9], [0.0, 0.0, 1.0, 0.0]])?;
//! let touching = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
//! assert!(query.collide(&body, &body, &apart).is_free());
//! assert!(query.collide(&body, &body, &touching).hit().is_some()); // bodies are closed sets: touching is meeting
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A **body** is a mesh with the tree over its triangles, or a set of spheres with theirs ([`construct::SphereSet`]).
//! It is built with a [`construct::Builder`], or read from bytes with [`hierarchy::BvhRef::from_bytes`]. A query
//! takes two bodies, A and B, and a [`pose::Pose`] that places A in the frame of B.
//!
//! **Moving points**, such as those of a lidar, have trees of their own ([`cloud`]). They answer range and
//! nearest-neighbour queries, and collision and distance queries between a robot and the points.
//!
//! **Many bodies**, such as a robot among obstacles and scanned points, form a [`scene`]. With the feature `planning`,
//! the module `planning` holds a robot from its URDF and the objects around it.
//!
//! # Advice
//!
//! **k and arity** are set by the node type. [`node::Node16<18>`](node::Node16), with k = 18 and arity 16, is the
//! fastest in almost all measurements, and a good default. Both bodies of a query must have the same node type, which
//! the type system checks.
//!
//! | node type | bytes per triangle, nodes / total | use it if |
//! |---|---|---|
//! | `Node16<18>` | 43 / 73 | nothing below applies |
//! | `Node16<14>` | 34 / 65 | flash is scarce: nodes a fifth smaller, about a quarter slower, more with flat walls |
//! | `Node16<6>` | 17 / 48 | only flash matters: volumes are boxes, which rotate badly |
//! | `Node16<26>`, `Node16<32>` | 60 / 90, 73 / 103 | k = 26 for machined parts and short tail latencies |
//! | `Node4<K>` | 53 / 86 for k = 18 | rarely: some KiB less stack, 1.1 to 1.9 times the time, nodes a quarter larger |
//!
//! **Storage** is the last parameter of the node type: [`node::Fixed`], the default, or [`node::Half`], as in
//! `Node16<18, Half>`. Both take 16 bits per plane. Fixed point is equally precise everywhere; half floats have 11
//! significant bits, and so are more precise near the centre of the body. Queries with half floats take 1.11 times as
//! long in the median of 24 cases (1.04 to 1.21), and give the same verdicts. The command `simdop report` compares both
//! on a mesh.
//!
//! With k = 26, queries of bodies in contact are 7 % faster, the slowest queries a quarter faster, and queries of
//! bodies 5 % apart are 5 % slower. The sizes are for a mesh of 52,000 triangles whose coordinates are exact in `f32`;
//! other coordinates take 6 bytes more per triangle. [`construct::Builder::without_normal_slabs`] saves 9 bytes per
//! triangle (11 at arity 4), and [`construct::Builder::balanced`], with two triangles per leaf, halves the size of the
//! nodes. Trees of spheres store the enclosing balls of their lanes instead of normal slabs, 20 bytes per lane, which
//! [`construct::Builder::without_balls`] omits.
//!
//! **Units.** The library has no unit. Both meshes, the translations of poses, margins and distances share one unit.
//! Meters and millimeters work equally well, because each tree has its own scale. STL files are often in millimeters:
//! combining one with a robot in meters is a mistake that no check can find. Coordinates range from 2^-250 to 2^300
//! ([`range`]).
//!
//! **A in B from two world poses.** A planner has the world poses of A and B; a query takes the pose of A in the frame
//! of B. A [`scene::Scene`] takes world poses, for two bodies or hundreds. Alternatively, [`pose::Pose::relative`]
//! converts them and bounds the rounding error, about 1e-14 of the coordinates. [`query::Query::within`] with at least
//! that margin is never falsely free at the given poses ([`pose::Relative::margin`]). Poses can be made from types of
//! [`glam`], which is re-exported, from those of mint and nalgebra with features, or by [`pose::Pose::from_rows`].
//!
//! ```
//! use simdop::glam::{DQuat, DVec3};
//! use simdop::pose::Pose;
//!
//! let world_a = Pose::try_from((DQuat::from_rotation_z(0.3), DVec3::new(1.0, 2.0, 0.5)))?;
//! let world_b = Pose::try_from((DQuat::from_rotation_x(-1.1), DVec3::new(0.2, 2.0, 0.0)))?;
//! let a_in_b = Pose::relative(&world_a, &world_b)?;
//!
//! // A corner of A: into B's frame, and from there into the world.
//! let corner = [0.1, 0.0, -0.2];
//! let by_b = world_b.apply(a_in_b.pose().apply(corner));
//! assert!((0..3).all(|i| (by_b[i] - world_a.apply(corner)[i]).abs() < a_in_b.error(0.2)));
//! # Ok::<(), simdop::pose::PoseError>(())
//! ```
//!
//! **The order of A and B** is the caller's choice: verdicts are exact for A's vertices as moved by the pose. A query
//! rotates one body's volumes into the other's frame, which enlarges them, most of all the volumes of flat walls along
//! the body's own axes. `collide`, `within` and `for_each_pair` rotate the body whose volumes grow less, according to
//! its tree ([`hierarchy::Header::rotation_growth`]). Distance queries rotate A, so a room or a table should be B.
//!
//! **Distant pairs.** Bounding balls about the centres of the frames cull a pair that is farther apart than the margin,
//! if any. That takes about fifteen nanoseconds and no visit. To find the nearest of many bodies, use
//! [`query::Query::distance_up_to`].
//!
//! **Surface or solid** is chosen when a body is built. A surface consists of its triangles, closed or not: a body
//! entirely inside it that does not touch it is `Free`. A closed mesh can be [solid](construct::Builder::solid): then a
//! body inside it is a hit at distance 0, even if only one of its parts is inside; parts share no vertices. Use solids
//! if a body could get inside without a detected contact, as between two samples of a motion. A point is inside if the
//! winding number of the surface is not zero there, so overlapping parts form one solid, and a shell of opposite
//! orientation is a cavity. The inside test runs only if no triangles meet, and is exact like everything else. Spheres
//! are solid.
//!
//! **Shapes.** Spheres, capsules, cuboids, cylinders, cones and half-spaces are exact shapes ([`primitive::Shape`]),
//! not meshes. One shape needs no tree: [`query::Query::collide_shape`] tests it against a tree,
//! [`primitive::shape::meets`] against another shape, and a scene takes it as a body. [`construct::ShapeSet`] builds
//! one tree of many. [`primitive::shape`] lists which verdicts are exact, and which are only certain if free. The
//! convex hull of points is a solid of triangles, computed exactly ([`construct::Builder::build_convex_hull`]).
//!
//! **`Unknown`.** A query without a budget always ends with `Hit` or `Free`. With a budget
//! ([`query::Query::with_budget`]), a query may run out of it and return [`query::Verdict::Unknown`]: the bodies may
//! meet. If safety is at stake, test [`query::Answer::is_free`], which is true only if freedom is proven. `Unknown` has
//! bounds of the distance; the lower one is 0, because overlapping volumes were still pending.
//!
//! **Stack.** No query recurses, and its stack use is bounded for all trees. A collision query that goes more than six
//! levels below the roots takes 2.3 KiB more. Measured totals in KiB, including all callees and exact arithmetic:
//!
//! | on | k = 6 | k = 18 | k = 32 |
//! |---|---|---|---|
//! | x86-64: collide / within, pairs / distance | 6 / 9 / 22 | 6.5 / 10 / 26 | 8.5 / 12 / 31 |
//!
//! (Rust 1.95, release, arity 16; arity 4 takes up to 7 KiB less.) On a Cortex-M4F a collision query takes 3 KiB
//! without exact arithmetic, and on an A53 8.2 KiB. `from_bytes` and `verify` take 1.5 KiB. A thread with 32 KiB for
//! collisions and 64 KiB for distances is enough; `tests/queries/stack.rs` checks it. Of this, exact arithmetic takes 1
//! KiB, pending pairs take [`query::STACK_BYTES`] or [`query::DISTANCE_STACK_BYTES`], and most of the rest is rotated
//! planes and triangles. Penetration queries take less than collision queries, plus [`query::PENETRATION_QUEUE_BYTES`]
//! with a budget.
//!
//! **The instruction set** is a value, [`isa::Isa`], which the caller detects once, stores, and may cap. All
//! instruction sets give the same verdicts and the same [query statistics](query::QueryStats).
//!
//! # Guarantees
//!
//! * **No missed hits and no false ones.** Volumes are rounded outwards ([`low_level::key`], [`low_level::realign`]).
//!   Tests of triangles and [spheres](primitive::sphere) are [exact](primitive::triangle), for vertices and centres as
//!   moved by [`pose::Pose::apply`], which are within a relative 2^-50 of their exact positions.
//! * **No allocation in a query.**
//! * **Untrusted trees are safe.** [`hierarchy::BvhRef::from_bytes`] proves that bytes are safe to traverse;
//!   [`hierarchy::BvhRef::verify`] proves, in exact arithmetic, that the volumes contain their triangles.
//! * **Determinism.** No fused multiply-add and no reordering: the same bits on every machine.
//!
//! # Features
//!
//! | feature | default | contents |
//! |---|---|---|
//! | `std` | yes | run-time detection of instruction sets by the standard library; implies `alloc` |
//! | `alloc` | yes | owned trees, builders, sphere packings. Without it: borrowed trees and clouds, and every query |
//! | `rayon` | no | construction and packing on several threads, with the same bytes; implies `std` |
//! | `gpu` | no | construction (`construct::gpu`) and point search (`cloud::gpu`) by wgpu, same bytes; implies `std` |
//! | `all-nodes` | no | node types chosen at run time: k = 6, 14, 26 and arity 4, not only k = 18 at arity 16 |
//! | `mint`, `nalgebra` | no | poses from the types of these crates |
//! | `urdf` | no | robots from URDF and SRDF files; implies `std` |
//! | `mesh-io` | no | readers of mesh files and clouds of points; implies `std` |
//! | `planning` | no | a robot among objects, queried by joint values; implies `urdf` and `mesh-io` |
//!
//! Without `std`, instruction sets are detected by CPUID and XCR0 on x86-64, and by the compilation target on
//! aarch64.
//!
//! # Sources
//!
//! Tan, Weller, Zachmann, *SIMDop: SIMD Optimized Bounding Volume Hierarchies for Collision Detection*, IROS 2019.
//! Weller, Mainzer, Srinivas, Teschner, Zachmann, *Massively Parallel Batch Neural Gas for Bounding Volume Hierarchy
//! Construction*, VRIPHYS 2014. Weller, Zachmann, *Inner Sphere Trees for Proximity and Penetration Queries*, RSS
//! 2009. Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017. Klosowski, Held,
//! Mitchell, Sowizral, Zikan, *Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs*, TVCG 1998.
#![no_std]
// For the library only: tests may unwrap and use std.
#![deny(
    clippy::unwrap_used,
    clippy::std_instead_of_core,
    clippy::std_instead_of_alloc,
    clippy::alloc_instead_of_core
)]

#[cfg(any(test, feature = "alloc"))]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub use glam;

mod bytes;
pub mod cloud;
#[cfg(feature = "alloc")]
pub mod construct;
#[cfg(feature = "gpu")]
pub mod device;
mod directions;
mod exact;
mod frame;
mod halving;
pub mod hierarchy;
pub mod isa;
mod kernel;
mod key;
pub mod low_level;
#[cfg(feature = "mesh-io")]
pub mod mesh_io;
pub mod motion;
pub mod node;
#[cfg(feature = "alloc")]
pub mod packing;
mod parallel;
#[cfg(feature = "planning")]
pub mod planning;
pub mod pose;
pub mod primitive;
pub mod query;
#[cfg(feature = "alloc")]
mod random;
pub mod range;
mod realign;
#[cfg(feature = "urdf")]
pub mod robot;
pub mod scene;
mod vector;

#[cfg(feature = "alloc")]
pub use construct::{Builder, Mesh};
#[cfg(feature = "alloc")]
pub use hierarchy::Bvh;
pub use hierarchy::{BvhRef, StaticBvh};
pub use isa::Isa;
pub use node::{Node4, Node16};
pub use pose::Pose;
pub use query::{Answer, Query, Verdict};
pub use scene::Scene;

// The random numbers of all tests.
#[cfg(test)]
#[path = "../tests/support/rng.rs"]
mod rng;

// The README's second program needs the feature.
#[cfg(all(doctest, feature = "planning"))]
#[doc = include_str!("../README.md")]
struct Readme;
