//! Does this body touch that one? Exact answers between triangle meshes, from hierarchies of k-DOPs that SIMD kernels test
//! sixteen at a time. `no_std`, no heap in a query, trees baked into bytes.
//!
//! ```
//! use simdop::{construct::{Builder, Mesh}, isa::Isa, node::Node16, pose::Pose, query::Query};
//!
//! // A tetrahedron, against a copy of itself.
//! let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let mesh = Mesh { vertices: &vertices, triangles: &triangles };
//! let body = Builder::new().build::<Node16<18>>(&mesh)?; // k = 18, arity 16
//!
//! let query = Query::new(Isa::detect()); // once
//! let apart = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1e-9], [0.0, 0.0, 1.0, 0.0]])?;
//! let touching = Pose::from_rows([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
//! assert!(query.collide(&body.view(), &body.view(), &apart).is_free());
//! assert!(!query.collide(&body.view(), &body.view(), &touching).is_free()); // closed sets: touching is meeting
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Choices
//!
//! *The node type* is k and arity: [`node::Node16<18>`](node::Node16) or [`node::Node4<14>`](node::Node4), k in 6, 14, 18, 26, 32. Larger k: tighter volumes, fewer
//! visits, more bytes. Both bodies of a query have the same node type; the type system sees to that.
//!
//! *The instruction set* is a value, [`isa::Isa`]: detected once, capped at will, held by the caller. Every one of them gives the same
//! verdicts and the same [counters](query::Counters).
//!
//! # Guarantees
//!
//! * **No miss, no false hit.** Volumes are rounded outwards ([`key`], [`realign`]), triangles are decided [exactly](primitive::triangle). A verdict is exact
//!   for the corners as [`pose::Pose::apply`] moves them: within 2^-50 of the pose asked for.
//! * **No allocation in a query**, and a traversal stack of [`query::STACK_BYTES`] bytes whatever the trees.
//! * **Untrusted trees.** [`hierarchy::BvhRef::from_bytes`] proves that bytes are safe to walk; [`hierarchy::BvhRef::verify`] proves, in exact
//!   arithmetic, that they bound their triangles.
//! * **Determinism.** No fused multiply-add, no reordering: the same bits on every machine.
//!
//! # Features
//!
//! | feature | default | what |
//! |---|---|---|
//! | `std` | yes | run-time detection of instruction sets by the standard library; implies `alloc` |
//! | `alloc` | yes | owned trees and the builders; without it: borrowed trees and every query |
//! | `rayon` | no | construction on several threads, with the same bytes; implies `std` |
//! | `gpu` | no | construction on a device, through wgpu (`construct::gpu`), with the same bytes; implies `std` |
//! | `cli` | no | the command `simdop` |
//!
//! Without `std`, x86-64 is asked by CPUID and XCR0, aarch64 takes what the crate is compiled for.
//!
//! # Sources
//!
//! Tan, Weller, Zachmann, *SIMDop: SIMD Optimized Bounding Volume Hierarchies for Collision Detection*, IROS 2019. Weller, Mainzer, Srinivas,
//! Teschner, Zachmann, *Massively Parallel Batch Neural Gas for Bounding Volume Hierarchy Construction*, VRIPHYS 2014. Klosowski, Held, Mitchell,
//! Sowizral, Zikan, *Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs*, TVCG 1998.
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

mod bytes;
#[cfg(feature = "alloc")]
pub mod construct;
pub mod directions;
mod exact;
pub mod frame;
pub mod hierarchy;
pub mod isa;
pub mod kernel;
pub mod key;
pub mod node;
pub mod pose;
pub mod primitive;
pub mod query;
pub mod range;
pub mod realign;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
