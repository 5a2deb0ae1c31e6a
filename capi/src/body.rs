//! Bodies: opened from bytes, or built.

use crate::boundary::{given, guarded, items, make};
use crate::error::simdop_error;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef, Header};
use simdop::node::Node16;
use simdop::primitive::{Kind, Sphere, Spheres, Triangles};
use simdop::scene::BodyTree;
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// The one node type of this interface.
pub(crate) type Node = Node16<18>;

/// A body: a set of primitives, triangles or spheres, and the tree over them. It never changes.
#[derive(Debug)]
pub struct simdop_body(Tree);

#[derive(Debug)]
enum Tree {
    /// Over bytes of the caller's.
    Lent {
        bytes: &'static [u8],
        view: View<'static>,
    },
    Mesh(Bvh<Node>),
    Spheres(Bvh<Node, Spheres>),
}

/// A tree to ask: of a scene's kinds, those that a body of this interface can be.
#[derive(Copy, Clone, Debug)]
pub(crate) enum View<'t> {
    Mesh(BvhRef<'t, Node, Triangles>),
    Spheres(BvhRef<'t, Node, Spheres>),
}

impl<'t> From<View<'t>> for BodyTree<'t, Node> {
    fn from(view: View<'t>) -> Self {
        match view {
            View::Mesh(tree) => tree.into(),
            View::Spheres(tree) => tree.into(),
        }
    }
}

impl simdop_body {
    pub(crate) fn view(&self) -> View<'_> {
        match &self.0 {
            Tree::Lent { view, .. } => *view,
            Tree::Mesh(tree) => View::Mesh(tree.view()),
            Tree::Spheres(tree) => View::Spheres(tree.view()),
        }
    }

    fn bytes(&self) -> &[u8] {
        match &self.0 {
            Tree::Lent { bytes, .. } => bytes,
            Tree::Mesh(tree) => tree.as_bytes(),
            Tree::Spheres(tree) => tree.as_bytes(),
        }
    }
}

/// Opens a body of triangles or spheres from the bytes of a baked tree, in place, after a check that they are safe to walk,
/// which takes time in proportion to them.
///
/// # Safety
/// There are `count` bytes, which must stay unchanged until the body is destroyed. They must start at a multiple of 64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_open(
    bytes: *const u8,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: they are there, and stay as long as the body, by the caller's promise.
        let bytes: &'static [u8] = unsafe { items(bytes, count, "bytes") }?;
        let is_of_spheres = Header::read(bytes)?.kind == Kind::SPHERES.code();
        let view = if is_of_spheres {
            View::Spheres(BvhRef::from_bytes(bytes)?)
        } else {
            View::Mesh(BvhRef::from_bytes(bytes)?)
        };
        Ok(simdop_body(Tree::Lent { bytes, view }))
    })
}

/// Builds the body that is the surface of triangles, closed or not: what is inside of it without touching it is free.
/// `vertices` are `vertex_count` times x, y, z; `triangles` are `triangle_count` times three indices of vertices. Both are
/// copied. Without triangles the body is empty, and meets nothing.
///
/// # Safety
/// The arrays have so many items.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_surface(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the same is promised here.
    unsafe { build(Builder::new(), vertices, vertex_count, triangles, triangle_count, body) }
}

/// Builds the solid that closed triangles bound: what is wholly inside of it is a hit, too. Otherwise as
/// simdop_body_build_surface().
///
/// # Safety
/// The arrays have so many items.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_solid(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the same is promised here.
    unsafe { build(Builder::new().solid(), vertices, vertex_count, triangles, triangle_count, body) }
}

/// Builds a body of spheres, which are solid: `count` times x, y, z and a radius.
///
/// # Safety
/// The array has so many items.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_spheres(
    spheres: *const f64,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: there are so many, by the caller's promise.
        let spheres: &[[f64; 4]] = unsafe { items(spheres.cast(), count, "spheres") }?;
        let sphere = |&[x, y, z, radius]: &[f64; 4]| Sphere { centre: [x, y, z], radius };
        let spheres: Vec<_> = spheres.iter().map(sphere).collect();
        let set = SphereSet { spheres: &spheres };
        let tree = Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(()))?;
        Ok(simdop_body(Tree::Spheres(tree)))
    })
}

/// Builds a body of triangles.
///
/// # Safety
/// The arrays have so many items.
unsafe fn build(
    builder: Builder,
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        let mesh = Mesh {
            // SAFETY: there are so many, by the caller's promise; three numbers in a row are aligned as one.
            vertices: unsafe { items(vertices.cast(), vertex_count, "vertices") }?,
            // SAFETY: the same.
            triangles: unsafe { items(triangles.cast(), triangle_count, "triangles") }?,
        };
        Ok(simdop_body(Tree::Mesh(builder.build_as(&mesh)?)))
    })
}

/// The bytes of a body's tree: write them to a file or to flash, and open them there. They belong to the body, or to who
/// opened it, and are there as long.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_bytes(
    body: Option<&simdop_body>,
    bytes: Option<&mut MaybeUninit<*const u8>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    guarded(|| {
        let tree = given(body, "body")?.bytes();
        let (bytes, count) = (given(bytes, "bytes")?, given(count, "count")?);
        bytes.write(tree.as_ptr());
        count.write(tree.len());
        Ok(())
    })
}

/// Destroys a body, and the bytes that were built for it. Of NULL, nothing.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_destroy(body: Option<Box<simdop_body>>) {
    drop(body);
}
