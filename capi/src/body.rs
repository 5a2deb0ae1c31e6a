//! Bodies: opened from bytes, or built.

use crate::boundary::{answered, checked, given, guarded, items, make};
use crate::error::{Failure, simdop_error};
use crate::shape::simdop_shape;
use simdop::construct::{BuildError, Builder, ConvexHull, Mesh, ShapeSet, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef, CapStats, Header, VerifyError};
use simdop::low_level::key::{Fixed, Half, Storage, StorageKind};
use simdop::node::Node16;
use simdop::primitive::{Kind, Shape, Shapes, Sphere, Spheres, Triangles};
use simdop::scene::BodyTree;
use std::ffi::c_int;
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// The node types of this interface.
pub(crate) type Node<S> = Node16<18, S>;

/// How the planes of a body are stored, in 16 bits. Bodies of different storage cannot be tested against each other.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_storage {
    /// Fixed point: equally precise everywhere in the body.
    Fixed = 0,
    /// Half floats: more precise near the centre of the body, and less precise far from it.
    Half = 1,
}

impl simdop_storage {
    /// The storage with this number.
    pub(crate) fn checked(number: c_int) -> Result<Self, Failure> {
        let known = [Self::Fixed, Self::Half].into_iter().find(|storage| *storage as c_int == number);
        known.ok_or_else(|| {
            Failure::new(simdop_error::BuildNoSuchStorage, format!("no storage has the number {number}"))
        })
    }
}

/// A body: a set of primitives, triangles, spheres or shapes, and the tree over them; or one shape, without a tree.
/// Immutable.
#[derive(Debug)]
pub struct simdop_body(Geometry);

#[derive(Debug)]
enum Geometry {
    Shape(Shape),
    /// Borrows the caller's bytes.
    Lent {
        bytes: &'static [u8],
        view: AnyView<'static>,
    },
    Fixed(Built<Fixed>),
    Half(Built<Half>),
}

/// A body with planes in a storage, from an expression that builds its tree in either.
macro_rules! body_in {
    ($storage:expr, $kind:ident, $tree:expr) => {
        Ok(simdop_body(match simdop_storage::checked($storage)? {
            simdop_storage::Fixed => Geometry::Fixed(Built::$kind($tree)),
            simdop_storage::Half => Geometry::Half(Built::$kind($tree)),
        }))
    };
}

/// An owned tree.
#[derive(Debug)]
enum Built<S: Storage> {
    Mesh(Bvh<Node<S>>),
    Spheres(Bvh<Node<S>, Spheres>),
    Shapes(Bvh<Node<S>, Shapes>),
}

/// A borrowed tree of a kind that a body of this interface can have, or one shape.
#[derive(Copy, Clone, Debug)]
pub(crate) enum View<'t, S: Storage> {
    Mesh(BvhRef<'t, Node<S>, Triangles>),
    Spheres(BvhRef<'t, Node<S>, Spheres>),
    Shapes(BvhRef<'t, Node<S>, Shapes>),
    Shape(&'t Shape),
}

/// [`View`] with planes of either storage. One shape has no storage, and goes with both.
#[derive(Copy, Clone, Debug)]
pub(crate) enum AnyView<'t> {
    Fixed(View<'t, Fixed>),
    Half(View<'t, Half>),
    Shape(&'t Shape),
}

impl<S: Storage> Built<S> {
    fn view(&self) -> View<'_, S> {
        match self {
            Self::Mesh(tree) => View::Mesh(tree.view()),
            Self::Spheres(tree) => View::Spheres(tree.view()),
            Self::Shapes(tree) => View::Shapes(tree.view()),
        }
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Mesh(tree) => tree.as_bytes(),
            Self::Spheres(tree) => tree.as_bytes(),
            Self::Shapes(tree) => tree.as_bytes(),
        }
    }
}

impl<S: Storage> View<'_, S> {
    fn cap_stats(&self) -> CapStats {
        match self {
            Self::Mesh(tree) => tree.cap_stats(),
            Self::Spheres(_) | Self::Shapes(_) | Self::Shape(_) => CapStats::default(),
        }
    }
}

impl<S: Storage> View<'_, S> {
    fn verify(&self) -> Result<(), VerifyError> {
        match self {
            Self::Mesh(tree) => tree.verify(),
            Self::Spheres(tree) => tree.verify(),
            Self::Shapes(tree) => tree.verify(),
            Self::Shape(_) => Ok(()),
        }
    }
}

impl<'t, S: Storage> View<'t, S> {
    fn open(bytes: &'t [u8], header: &Header) -> Result<Self, Failure> {
        Ok(if header.kind == Kind::SPHERES.code() {
            Self::Spheres(BvhRef::from_bytes(bytes)?)
        } else if header.kind == Kind::SHAPES.code() {
            Self::Shapes(BvhRef::from_bytes(bytes)?)
        } else {
            Self::Mesh(BvhRef::from_bytes(bytes)?)
        })
    }
}

impl<'t> AnyView<'t> {
    /// The storage. `None` for one shape.
    pub(crate) const fn storage(&self) -> Option<StorageKind> {
        match self {
            Self::Fixed(_) => Some(StorageKind::Fixed),
            Self::Half(_) => Some(StorageKind::Half),
            Self::Shape(_) => None,
        }
    }

    /// The body, if it goes with bodies of fixed point.
    pub(crate) const fn fixed(self) -> Option<View<'t, Fixed>> {
        match self {
            Self::Fixed(view) => Some(view),
            Self::Shape(shape) => Some(View::Shape(shape)),
            Self::Half(_) => None,
        }
    }

    /// The body, if it goes with bodies of half floats.
    pub(crate) const fn half(self) -> Option<View<'t, Half>> {
        match self {
            Self::Half(view) => Some(view),
            Self::Shape(shape) => Some(View::Shape(shape)),
            Self::Fixed(_) => None,
        }
    }

    fn cap_stats(&self) -> CapStats {
        match self {
            Self::Fixed(view) => view.cap_stats(),
            Self::Half(view) => view.cap_stats(),
            Self::Shape(_) => CapStats::default(),
        }
    }
}

impl<'t, S: Storage> From<View<'t, S>> for BodyTree<'t, Node<S>> {
    fn from(view: View<'t, S>) -> Self {
        match view {
            View::Mesh(tree) => tree.into(),
            View::Spheres(tree) => tree.into(),
            View::Shapes(tree) => tree.into(),
            View::Shape(shape) => (*shape).into(),
        }
    }
}

impl simdop_body {
    pub(crate) const fn of_shape(shape: Shape) -> Self {
        Self(Geometry::Shape(shape))
    }

    pub(crate) fn view(&self) -> AnyView<'_> {
        match &self.0 {
            Geometry::Lent { view, .. } => *view,
            Geometry::Fixed(built) => AnyView::Fixed(built.view()),
            Geometry::Half(built) => AnyView::Half(built.view()),
            Geometry::Shape(shape) => AnyView::Shape(shape),
        }
    }

    fn bytes(&self) -> Result<&[u8], Failure> {
        match &self.0 {
            Geometry::Lent { bytes, .. } => Ok(bytes),
            Geometry::Fixed(built) => Ok(built.bytes()),
            Geometry::Half(built) => Ok(built.bytes()),
            Geometry::Shape(_) => {
                let message = "the body is one shape, without a tree: build_shapes() builds one".to_owned();
                Err(Failure::new(simdop_error::ShapeNoBytes, message))
            }
        }
    }
}

/// A mesh from arrays.
///
/// # Safety
/// As for [`items`], with three numbers for each vertex and for each triangle.
pub(crate) unsafe fn mesh<'m>(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
) -> Result<Mesh<'m>, Failure> {
    Ok(Mesh {
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        vertices: unsafe { items(vertices.cast(), vertex_count, "vertices") }?,
        // SAFETY: as above.
        triangles: unsafe { items(triangles.cast(), triangle_count, "triangles") }?,
    })
}

const FIXED: c_int = simdop_storage::Fixed as c_int;

/// Opens a body of triangles, spheres or shapes in place from the bytes of a baked tree. First validates the bytes, so
/// that traversal is memory safe, in time linear in their number.
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
        let header = Header::read(bytes)?;
        let view = match StorageKind::from_code(header.storage) {
            Some(StorageKind::Half) => AnyView::Half(View::open(bytes, header)?),
            // Opening refuses an unknown storage.
            _ => AnyView::Fixed(View::open(bytes, header)?),
        };
        Ok(simdop_body(Geometry::Lent { bytes, view }))
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
    // SAFETY: the caller gives the same guarantee.
    unsafe {
        simdop_body_build_triangles_as(vertices, vertex_count, triangles, triangle_count, 0, FIXED, body)
    }
}

/// Builds the solid that a closed mesh bounds: a body wholly inside it is a hit, too. Otherwise like
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
    // SAFETY: the caller gives the same guarantee.
    unsafe {
        simdop_body_build_triangles_as(vertices, vertex_count, triangles, triangle_count, 1, FIXED, body)
    }
}

/// Builds a body like simdop_body_build_solid() if `is_solid` is not zero, and otherwise like
/// simdop_body_build_surface(), with planes in `storage`, a simdop_storage.
///
/// # Safety
/// The arrays have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_triangles_as(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    is_solid: c_int,
    storage: c_int,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the lengths.
        let mesh = unsafe { mesh(vertices, vertex_count, triangles, triangle_count) }?;
        let builder = if is_solid == 0 { Builder::new() } else { Builder::new().solid() };
        body_in!(storage, Mesh, builder.build_as(&mesh)?)
    })
}

/// Builds a solid like simdop_body_build_solid(), with planes in `storage`, a simdop_storage, from triangles that need
/// not be closed: holes of at most this width are capped. The width of a hole is the greatest distance of two corners
/// of its border. Caps only close the surface that bounds the inside: no distance is measured from a cap, and no pair
/// names one. A body that meets a cap is partly inside, and a hit. simdop_body_caps() reports what was capped.
///
/// # Safety
/// The arrays have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_solid_with_caps(
    vertices: *const f64,
    vertex_count: usize,
    triangles: *const u32,
    triangle_count: usize,
    width: f64,
    storage: c_int,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the lengths.
        let mesh = unsafe { mesh(vertices, vertex_count, triangles, triangle_count) }?;
        body_in!(storage, Mesh, Builder::new().solid_with_caps(width).build_as(&mesh)?)
    })
}

/// Builds the convex hull of points as a solid of triangles. `points` holds x, y, z for each of `count` points, in any
/// order; they may coincide. The hull is exact: its corners are points, and no point is outside. The hull of points in
/// one plane is a surface, and the hull of no points is empty.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_hull(
    points: *const f64,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the caller gives the same guarantee.
    unsafe { simdop_body_build_hull_as(points, count, FIXED, body) }
}

/// Builds a body like simdop_body_build_hull(), with planes in `storage`, a simdop_storage.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_hull_as(
    points: *const f64,
    count: usize,
    storage: c_int,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let points = unsafe { items(points.cast(), count, "points") }?;
        let hull = ConvexHull::of(points)?;
        let builder = if hull.is_solid { Builder::new().solid() } else { Builder::new() };
        body_in!(storage, Mesh, builder.build_as(&hull.mesh.as_mesh())?)
    })
}

/// The capped holes of a body.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_caps {
    /// Number of holes.
    pub holes: usize,
    /// Number of triangles in their caps.
    pub triangles: usize,
    /// The width of the widest hole, rounded up.
    pub width: f64,
}

/// Writes how many holes of a body are capped. All fields are 0 for a body without caps.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_caps(
    body: Option<&simdop_body>,
    caps: Option<&mut MaybeUninit<simdop_caps>>,
) -> simdop_error {
    answered(caps, || {
        let CapStats { holes, triangles, width } = given(body, "body")?.view().cap_stats();
        Ok(simdop_caps { holes, triangles, width })
    })
}

/// Spheres from an array of x, y, z and the radius of each.
///
/// # Safety
/// As for [`items`], with four numbers for each sphere.
unsafe fn read_spheres(spheres: *const f64, count: usize) -> Result<Vec<Sphere>, Failure> {
    // SAFETY: the caller guarantees the length; four numbers in a row are aligned as one.
    let spheres: &[[f64; 4]] = unsafe { items(spheres.cast(), count, "spheres") }?;
    Ok(spheres.iter().map(|&[x, y, z, radius]| Sphere { centre: [x, y, z], radius }).collect())
}

/// Builds a copy of a body, a solid mesh, with `count` spheres inside it, such as those of simdop_pack(), in its bytes.
/// With them the lower bounds of simdop_depth() are higher; no other query reads them. `spheres` is as for
/// simdop_body_build_spheres(). Proves that each sphere is inside, in time proportional to the number of spheres times
/// that of triangles.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_packed(
    body: Option<&simdop_body>,
    spheres: *const f64,
    count: usize,
    packed: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    fn add<S: Storage>(tree: &[u8], spheres: &[Sphere]) -> Result<Built<S>, Failure> {
        Ok(Built::Mesh(Builder::new().add_packing(&Bvh::from_bytes(tree)?, spheres)?))
    }

    make(packed, "packed", || {
        // SAFETY: the caller guarantees the length.
        let spheres = unsafe { read_spheres(spheres, count) }?;
        let body = given(body, "body")?;
        Ok(simdop_body(match body.view() {
            AnyView::Fixed(View::Mesh(_)) => Geometry::Fixed(add(body.bytes()?, &spheres)?),
            AnyView::Half(View::Mesh(_)) => Geometry::Half(add(body.bytes()?, &spheres)?),
            _ => return Err(BuildError::Packing { problem: "the body is not a mesh" }.into()),
        }))
    })
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
    // SAFETY: the caller gives the same guarantee.
    unsafe { simdop_body_build_spheres_as(spheres, count, FIXED, body) }
}

/// Builds a body like simdop_body_build_spheres(), with planes in `storage`, a simdop_storage.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_spheres_as(
    spheres: *const f64,
    count: usize,
    storage: c_int,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the length.
        let spheres = unsafe { read_spheres(spheres, count) }?;
        let set = SphereSet { spheres: &spheres };
        let (builder, mut go_on) = (Builder::new(), |_| ControlFlow::Continue(()));
        body_in!(storage, Spheres, builder.build_geometry(&set, &mut go_on)?)
    })
}

/// Builds a body of one shape, which is copied. It has no tree, and goes with bodies of either storage. As a primitive
/// it has the index 0. In a scene, a half-space should be fixed: nothing bounds how far a rotation carries its points,
/// so a motion that rotates it is never free.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_build_shape(
    shape: Option<&simdop_shape>,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || Ok(simdop_body::of_shape(given(shape, "shape")?.checked()?)))
}

/// Builds a body of `count` shapes, which may overlap, with a tree over them, such as a link of several capsules or a
/// shelf of cuboids. They are copied. A half-space among them is SIMDOP_ERROR_SHAPE_UNBOUNDED. Without shapes the body
/// is empty, and meets nothing.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_shapes(
    shapes: *const simdop_shape,
    count: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    // SAFETY: the caller gives the same guarantee.
    unsafe { simdop_body_build_shapes_as(shapes, count, FIXED, body) }
}

/// Builds a body like simdop_body_build_shapes(), with planes in `storage`, a simdop_storage.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_body_build_shapes_as(
    shapes: *const simdop_shape,
    count: usize,
    storage: c_int,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || {
        // SAFETY: the caller guarantees the length.
        let shapes = checked(unsafe { items(shapes, count, "shapes") }?, "shape", simdop_shape::checked)?;
        let set = ShapeSet::new(&shapes)?;
        let (builder, mut go_on) = (Builder::new(), |_| ControlFlow::Continue(()));
        body_in!(storage, Shapes, builder.build_geometry(&set, &mut go_on)?)
    })
}

/// Returns the bytes of a body's tree, to be stored in a file or in flash and opened there. They belong to the body and
/// live as long as it does; the bytes of an opened body belong to the caller. A body of one shape has none.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_bytes(
    body: Option<&simdop_body>,
    bytes: Option<&mut MaybeUninit<*const u8>>,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    guarded(|| {
        let tree = given(body, "body")?.bytes()?;
        let (bytes, count) = (given(bytes, "bytes")?, given(count, "count")?);
        bytes.write(tree.as_ptr());
        count.write(tree.len());
        Ok(())
    })
}

/// Proves, in exact arithmetic, that the volumes of a body's tree contain its primitives, and that its caps close the
/// surface. SIMDOP_ERROR_BYTES_VOLUME if not: then a query could miss a hit. Opening bytes proves only that they are
/// safe to traverse, so verify a file from an unknown source once. A body of one shape has no tree, and passes. The
/// time is proportional to the number of primitives times the depth of the tree.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_verify(body: Option<&simdop_body>) -> simdop_error {
    guarded(|| {
        match given(body, "body")?.view() {
            AnyView::Fixed(view) => view.verify(),
            AnyView::Half(view) => view.verify(),
            AnyView::Shape(_) => Ok(()),
        }?;
        Ok(())
    })
}

/// Destroys a body, and the bytes that were built for it. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_body_destroy(body: Option<Box<simdop_body>>) {
    drop(body);
}
