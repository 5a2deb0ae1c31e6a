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

/// The only node type of this interface.
pub(crate) type Node = Node16<18>;

/// A body: a set of primitives, triangles or spheres, and the tree over them. Immutable.
#[derive(Debug)]
pub struct simdop_body(Tree);

#[derive(Debug)]
enum Tree {
    /// Borrows the caller's bytes.
    Lent {
        bytes: &'static [u8],
        view: View<'static>,
    },
    Mesh(Bvh<Node>),
    Spheres(Bvh<Node, Spheres>),
}

/// A borrowed tree of a kind that a body of this interface can have.
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

/// Opens a body of triangles or spheres in place from the bytes of a baked tree. First validates the bytes, so that
/// traversal is memory safe, in time linear in their number.
///
/// # Safety
/// `bytes` points to `count` bytes, aligned to 64, which stay unchanged until the body is destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_open(
    bytes: *const u8,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees that the bytes exist, and that they outlive the body.
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

/// Builds a body that is the surface of triangles, closed or not: a body inside it that does not touch it is free.
/// `vertices` holds x, y, z for each of `vertex_count` vertices, `triangles` three vertex indices for each of
/// `triangle_count` triangles. Both are copied. Without triangles the body is empty, and meets nothing.
///
/// # Safety
/// The arrays have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_surface(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the caller gives the guarantee that `build` requires.
    unsafe { build(Builder::new(), vertices, vertex_count, triangles, triangle_count, body) }
}

/// Builds the solid that closed triangles bound: a body wholly inside it is a hit, too. Otherwise like
/// simdop_body_build_surface().
///
/// # Safety
/// The arrays have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_solid(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the caller gives the guarantee that `build` requires.
    unsafe { build(Builder::new().solid(), vertices, vertex_count, triangles, triangle_count, body) }
}

/// Builds a body of solid spheres. `spheres` holds x, y, z and the radius of each of `count` spheres.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_spheres(
    spheres: *const f64,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the length; four numbers in a row are aligned as one.
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
/// The arrays have the stated lengths.
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
            // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
            vertices: unsafe { items(vertices.cast(), vertex_count, "vertices") }?,
            // SAFETY: as above.
            triangles: unsafe { items(triangles.cast(), triangle_count, "triangles") }?,
        };
        Ok(simdop_body(Tree::Mesh(builder.build_as(&mesh)?)))
    })
}

/// Returns the bytes of a body's tree, to be stored in a file or in flash and opened there. They belong to the body, or
/// to the caller that opened it, and have the same lifetime.
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

/// Destroys a body, and the bytes that were built for it. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_destroy(body: Option<Box<simdop_body>>) {
    drop(body);
}
