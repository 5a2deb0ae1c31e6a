//! Exact collision and distance queries between triangle meshes, on hierarchies of k-DOPs that SIMD kernels
//! test sixteen volumes at a time. The library is `no_std`, a query allocates nothing, and trees are runs of
//! bytes that are read in place, from flash if need be.
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
//! A **body** is a mesh and the tree over its triangles, or a set of spheres and theirs
//! ([`construct::SphereSet`]): built with a [`construct::Builder`], or read from
//! bytes with [`hierarchy::BvhRef::from_bytes`]. A query asks about two bodies, A and B, and a [`pose::Pose`]
//! that places A in the frame of B.
//!
//! **Points that move**, such as a lidar's, have trees of their own ([`cloud`]): all neighbours within a radius, the nearest,
//! and whether, or how near, a robot is to any.
//!
//! **Many bodies**, as a robot among others and among the points of a scan, are a [`scene`].
//!
//! # Advice
//!
//! **k and arity** are the node type. [`node::Node16<18>`](node::Node16), k = 18 and arity 16, is the fastest
//! choice in almost all measurements and the one to begin with. Both bodies of a query have the same node
//! type, which the type system checks.
//!
//! | node type | bytes a triangle, nodes / in all | when |
//! |---|---|---|
//! | `Node16<18>` | 43 / 73 | unless something below applies |
//! | `Node16<14>` | 34 / 65 | flash is scarce: a fifth less of nodes for about a quarter more time in the mean; robots in rooms with flat walls lose more |
//! | `Node16<6>` | 17 / 48 | flash is all that counts: volumes are boxes, which turn badly |
//! | `Node16<26>`, `Node16<32>` | 60 / 90, 73 / 103 | k = 26 for machined parts and short tails: 7 % faster in contact, the slowest queries a quarter, 5 % slower 5 % apart |
//! | `Node4<K>` | 53 / 86 for k = 18 | hardly ever: 1.1 to 1.9 times the time and a quarter more bytes of nodes; a query needs some KiB less stack |
//!
//! The bytes are those of a mesh of 52,000 triangles whose coordinates `f32` holds exactly; others take 6
//! more a triangle. [`construct::Builder::without_normal_slabs`] saves 9 of them (11 at arity 4), and
//! [`construct::Builder::balanced`], two triangles a leaf, halves the bytes of nodes. Trees of spheres have the enclosing
//! balls of their lanes instead of normal slabs, 20 bytes a lane, which [`construct::Builder::without_balls`] leaves out.
//!
//! **Units.** The library knows no unit. Both meshes, the translations of poses, margins and distances use
//! the same one; meters and millimeters work alike, because each tree has a scale of its own. STL files are
//! often in millimeters: a robot in meters beside one is a mistake that no check can find. Coordinates reach
//! from 2^-250 to 2^300 ([`range`]).
//!
//! **A in B from two poses in the world.** A planner knows where A and B stand in the world; a query asks
//! where A stands, seen from B. A [`scene::Scene`] takes poses in the world, for two bodies or hundreds. Or
//! [`pose::Pose::relative`], which says what it rounds, some 1e-14 of the coordinates: [`query::Query::within`] with a margin of
//! as much is never falsely free for the poses given ([`pose::Relative::margin`]). Poses are made from the types of
//! [`glam`], which is re-exported, with features from those of mint and nalgebra, else by [`pose::Pose::from_rows`].
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
//! **Which body is A** is for the caller to choose: verdicts hold for A's corners as the pose moves them. One body's
//! volumes are turned into the other's frame and widen by it, those of flat walls along its own axes the most.
//! `collide`, `within` and `for_each_pair` turn the body that loses less, as its tree says
//! ([`hierarchy::Header::rotation_growth`]). Distances turn A: there a room or a table is best given as B.
//!
//! **Many pairs, most of them far apart.** A pair whose balls about the centres of the frames are apart, by more than the
//! margin if there is one, costs some fifteen nanoseconds and no visit. For the nearest of many bodies there is
//! [`query::Query::distance_up_to`].
//!
//! **Surface or solid** is said when a body is built. A surface is its triangles, whether or not they close: a body that is
//! wholly inside of it without touching it is `Free`. A mesh that closes may be [solid](construct::Builder::solid): then that
//! body is a hit, its distance is 0, and so it is for each part of a body of several, parts being what does not hang together
//! at vertices. Where something could get inside without having been seen to touch, as between two samples of a motion, bodies
//! should be solid. Inside is where the surface winds around a point, so that parts that overlap are one solid, and a
//! shell of the other orientation is a cavity. It is asked only where no triangles meet, and by exact signs as all else is.
//! Spheres are solid.
//!
//! **What `Unknown` means.** A query without a budget always ends with `Hit` or `Free`. One with a budget
//! ([`query::Query::with_budget`]) may end with [`query::Verdict::Unknown`]: it stopped before it knew, and
//! the bodies may meet. It is neither a hit nor free: ask [`query::Answer::is_free`] where safety is at
//! stake, which is true of proven freedom only. It comes with bounds of
//! the distance; their lower one is 0, because volumes were still waiting that overlap.
//!
//! **Stack.** No query recurses, and what one takes is bounded for all trees: 2.3 KiB more for a collision that gets more than six
//! levels below the roots. Measured, in KiB in all, with everything that a query calls, exact arithmetic included:
//!
//! | on | k = 6 | k = 18 | k = 32 |
//! |---|---|---|---|
//! | x86-64: collide / within, pairs / distance | 6 / 9 / 22 | 6.5 / 10 / 26 | 8.5 / 12 / 31 |
//!
//! (Rust 1.95, release, arity 16; arity 4 takes up to 7 KiB less.) On a Cortex-M4F a collision takes 3 KiB without
//! exact arithmetic, on an A53 8.2. `from_bytes` and `verify` take 1.5 KiB. A thread with 32 KiB for collisions and 64 KiB for distances is enough, which
//! `tests/queries/stack.rs` checks. Exact arithmetic takes a KiB of this, the pairs that wait [`query::STACK_BYTES`]
//! or [`query::DISTANCE_STACK_BYTES`], and most of the rest is turned planes and triangles. Penetration volumes take less
//! than collisions, and [`query::PENETRATION_QUEUE_BYTES`] more where there is a budget.
//!
//! **The instruction set** is a value, [`isa::Isa`]: detected once, capped at will, held by the caller. All
//! of them give the same verdicts and the same [counters](query::QueryStats).
//!
//! # Guarantees
//!
//! * **No missed hit and no invented one.** Volumes are rounded outwards ([`low_level::key`], [`low_level::realign`]), and triangles
//!   and [spheres](primitive::sphere) are decided [exactly](primitive::triangle), for corners and centres as [`pose::Pose::apply`] moves them: within
//!   2^-50, relatively, of where the pose puts them.
//! * **No allocation in a query.**
//! * **Trees from outside are safe.** [`hierarchy::BvhRef::from_bytes`] proves that bytes are safe to walk;
//!   [`hierarchy::BvhRef::verify`] proves, in exact arithmetic, that the volumes hold their triangles.
//! * **Determinism.** No fused multiply-add and no reordering: the same bits on every machine.
//!
//! # Features
//!
//! | feature | default | what |
//! |---|---|---|
//! | `std` | yes | run-time detection of instruction sets by the standard library; implies `alloc` |
//! | `alloc` | yes | owned trees, the builders and sphere packings; without it: borrowed trees, clouds in lent memory and every query |
//! | `rayon` | no | construction and packing on several threads, with the same bytes; implies `std` |
//! | `gpu` | no | construction (`construct::gpu`) and search of moving points (`cloud::gpu`) on a device, through wgpu, with the same bytes; implies `std` |
//! | `mint`, `nalgebra` | no | poses from the types of these crates |
//! | `urdf` | no | robots from URDF and SRDF files; implies `std` |
//!
//! Without `std`, x86-64 is asked by CPUID and XCR0, aarch64 takes what the crate is compiled for.
//!
//! # Sources
//!
//! Tan, Weller, Zachmann, *SIMDop: SIMD Optimized Bounding Volume Hierarchies for Collision Detection*, IROS
//! 2019. Weller, Mainzer, Srinivas, Teschner, Zachmann, *Massively Parallel Batch Neural Gas for Bounding
//! Volume Hierarchy Construction*, VRIPHYS 2014. Weller, Zachmann, *Inner Sphere Trees for Proximity and
//! Penetration Queries*, RSS 2009. Xing, Wang, Hui, *Coherent Spherical
//! Range-Search for Dynamic Points on GPUs*, CAD 2017. Klosowski, Held, Mitchell, Sowizral, Zikan, *Efficient
//! Collision Detection Using Bounding Volume Hierarchies of k-DOPs*, TVCG 1998.
#![no_std]
// Of the library alone: a test may unwrap, and has std.
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
pub mod motion;
pub mod node;
#[cfg(feature = "alloc")]
pub mod packing;
mod parallel;
pub mod pose;
pub mod primitive;
pub mod query;
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

// What all tests draw their random numbers from.
#[cfg(test)]
#[path = "../tests/support/rng.rs"]
mod rng;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
