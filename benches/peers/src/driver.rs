//! Peers in C++, through the functions of `drivers/peer.h`.

use crate::data::MeshData;
use crate::suites::Rows;
use core::ffi::{CStr, c_char, c_void};
use libloading::{Library, Symbol};
use simdop::primitive::triangle::{self, Triangle};
use std::path::Path;
use std::rc::Rc;

type Handle = *mut c_void;
type TriangleTest = extern "C" fn(&Triangle, &Triangle) -> bool;

/// A loaded driver. Its functions are copied out of the library, which lives as long.
pub(crate) struct Driver {
    version: unsafe extern "C" fn() -> *const c_char,
    build: unsafe extern "C" fn(*const [f64; 3], usize, *const [u32; 3], usize) -> Handle,
    free: unsafe extern "C" fn(Handle),
    bytes: unsafe extern "C" fn(Handle) -> usize,
    collide: unsafe extern "C" fn(Handle, Handle, *const Rows) -> bool,
    distance: Option<unsafe extern "C" fn(Handle, Handle, *const Rows) -> f64>,
    managers: Option<Managers>,
    solids: Option<Solids>,
    _library: Library,
}

/// The functions of a peer with analytic shapes.
#[derive(Copy, Clone)]
struct Solids {
    pair: unsafe extern "C" fn(*const Solid, *const Solid) -> Handle,
    free: unsafe extern "C" fn(Handle),
    collide: unsafe extern "C" fn(Handle, *const Rows) -> bool,
    distance: unsafe extern "C" fn(Handle, *const Rows, *mut [[f64; 3]; 2]) -> f64,
}

/// A shape, as declared in `peer.h`.
#[derive(Copy, Clone, PartialEq, Debug)]
#[repr(C)]
pub(crate) struct Solid {
    pub(crate) kind: Kind,
    /// The side lengths of a cuboid; otherwise the radius and the height, for a capsule that of its middle part.
    pub(crate) size: [f64; 3],
}

/// The shapes of `peer.h`, about the origin, with axes along z. A half-space is below z = 0.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[repr(C)]
pub(crate) enum Kind {
    Sphere,
    Capsule,
    Cuboid,
    Cylinder,
    Cone,
    HalfSpace,
}

/// A moving and a fixed solid of a peer.
pub(crate) struct Pair {
    solids: Solids,
    handle: Handle,
    _driver: Rc<Driver>,
}

/// The functions of a peer with managers of many bodies.
#[derive(Copy, Clone)]
struct Managers {
    cuboid: unsafe extern "C" fn(*const [f64; 3]) -> Handle,
    convex: unsafe extern "C" fn(*const [f64; 3], usize, *const [u32; 3], usize) -> Handle,
    scene: unsafe extern "C" fn(*const Placed, usize, *const bool, *const Placed, usize) -> Handle,
    free: unsafe extern "C" fn(Handle),
    collide: unsafe extern "C" fn(Handle, *const Rows) -> bool,
}

/// A body and its pose, as declared in `peer.h`.
#[repr(C)]
struct Placed {
    handle: Handle,
    place: Rows,
}

/// A body built by a peer.
pub(crate) struct Body {
    driver: Rc<Driver>,
    handle: Handle,
}

/// A robot's links among fixed bodies, built by a peer.
pub(crate) struct Scene {
    managers: Managers,
    handle: Handle,
    links: Rc<Vec<Body>>,
    _obstacles: Vec<Body>,
}

extern "C" fn meet(a: &Triangle, b: &Triangle) -> bool {
    triangle::overlap(a, b, &mut 0)
}

impl Driver {
    pub(crate) fn load(path: &Path) -> Result<Self, libloading::Error> {
        // SAFETY: the drivers are this crate's own; loading one starts only what the peer's package starts. The types
        // are those of `peer.h`, and of `embree.cpp`, the only one with a triangle test. Symbols of one driver are not
        // visible to the others (RTLD_LOCAL).
        unsafe {
            let library = Library::new(path)?;
            let take: Result<Symbol<'_, unsafe extern "C" fn(TriangleTest)>, _> =
                library.get(b"peer_triangle_test");
            if let Ok(take) = take {
                take(meet);
            }
            let managers = match library.get(b"peer_scene") {
                Err(_) => None,
                Ok(scene) => Some(Managers {
                    cuboid: *library.get(b"peer_box")?,
                    convex: *library.get(b"peer_convex")?,
                    scene: *scene,
                    free: *library.get(b"peer_scene_free")?,
                    collide: *library.get(b"peer_scene_collide")?,
                }),
            };
            let solids = match library.get(b"peer_pair") {
                Err(_) => None,
                Ok(pair) => Some(Solids {
                    pair: *pair,
                    free: *library.get(b"peer_pair_free")?,
                    collide: *library.get(b"peer_pair_collide")?,
                    distance: *library.get(b"peer_pair_distance")?,
                }),
            };
            Ok(Self {
                managers,
                solids,
                version: *library.get(b"peer_version")?,
                build: *library.get(b"peer_build")?,
                free: *library.get(b"peer_free")?,
                bytes: *library.get(b"peer_bytes")?,
                collide: *library.get(b"peer_collide")?,
                distance: library.get(b"peer_distance").ok().map(|symbol| *symbol),
                _library: library,
            })
        }
    }

    pub(crate) const fn measures_distances(&self) -> bool {
        self.distance.is_some()
    }

    pub(crate) fn version(&self) -> String {
        // SAFETY: `peer_version` takes nothing and returns a string that lives forever.
        unsafe { CStr::from_ptr((self.version)()) }.to_string_lossy().into_owned()
    }

    pub(crate) fn build(this: &Rc<Self>, mesh: &MeshData) -> Body {
        let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
        // SAFETY: the pointers and counts are those of the arrays, and every index is below the vertex count: simdop's
        // builder has validated the mesh.
        let handle =
            unsafe { (this.build)(vertices.as_ptr(), vertices.len(), triangles.as_ptr(), triangles.len()) };
        Body { driver: Rc::clone(this), handle }
    }

    fn managers(&self) -> Managers {
        self.managers.expect("asked of drivers with managers")
    }

    /// A box about the origin, as a native solid of the peer.
    pub(crate) fn cuboid(this: &Rc<Self>, sides: &[f64; 3]) -> Body {
        // SAFETY: three numbers.
        Body { driver: Rc::clone(this), handle: unsafe { (this.managers().cuboid)(sides) } }
    }

    /// The hull of the mesh, which is convex, as a solid.
    pub(crate) fn convex(this: &Rc<Self>, mesh: &MeshData) -> Body {
        let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
        // SAFETY: as in `build`.
        let handle = unsafe {
            (this.managers().convex)(vertices.as_ptr(), vertices.len(), triangles.as_ptr(), triangles.len())
        };
        Body { driver: Rc::clone(this), handle }
    }

    /// The first solid, to be moved, and the second.
    pub(crate) fn pair(this: &Rc<Self>, a: &Solid, b: &Solid) -> Pair {
        let solids = this.solids.expect("asked of drivers with solids");
        // SAFETY: two solids as declared in `peer.h`, which need not outlive the call.
        Pair { solids, handle: unsafe { (solids.pair)(a, b) }, _driver: Rc::clone(this) }
    }

    /// Builds a scene from links, initially at these poses, the pairs of links that are tested, row by row, and
    /// obstacles.
    pub(crate) fn scene(
        this: &Rc<Self>,
        links: &Rc<Vec<Body>>,
        places: &[Rows],
        asked: &[bool],
        obstacles: Vec<(Body, Rows)>,
    ) -> Scene {
        assert!(places.len() == links.len() && asked.len() == links.len() * links.len());
        let placed = |(body, place): (&Body, &Rows)| {
            assert!(Rc::ptr_eq(this, &body.driver));
            Placed { handle: body.handle, place: *place }
        };
        let moving: Vec<Placed> = links.iter().zip(places).map(placed).collect();
        let still: Vec<Placed> = obstacles.iter().map(|(body, place)| placed((body, place))).collect();
        let managers = this.managers();
        // SAFETY: pointers and counts are those of the arrays, and all handles are of this driver. The scene keeps the
        // bodies alive, which keep the driver.
        let handle = unsafe {
            (managers.scene)(moving.as_ptr(), moving.len(), asked.as_ptr(), still.as_ptr(), still.len())
        };
        let obstacles = obstacles.into_iter().map(|(body, _)| body).collect();
        Scene { managers, handle, links: Rc::clone(links), _obstacles: obstacles }
    }
}

impl Scene {
    /// Whether the links, at these poses, meet an obstacle or each other.
    pub(crate) fn collides(&mut self, places: &[Rows]) -> bool {
        assert_eq!(places.len(), self.links.len());
        // SAFETY: the handle is alive, nothing else uses it meanwhile, and there is a pose for each link.
        unsafe { (self.managers.collide)(self.handle, places.as_ptr()) }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the handle is this driver's and is not used again. The bodies are dropped after this.
        unsafe { (self.managers.free)(self.handle) }
    }
}

impl Body {
    pub(crate) fn bytes(&self) -> usize {
        // SAFETY: the handle is this driver's, and not freed before `drop`.
        unsafe { (self.driver.bytes)(self.handle) }
    }

    /// Whether this body, placed by the pose, meets the other.
    pub(crate) fn collides(&self, other: &Self, rows: &Rows) -> bool {
        // SAFETY: both handles are of one driver (its bodies are built together) and alive; a pose has 12 contiguous
        // numbers.
        unsafe { (self.driver.collide)(self.handle, other.handle, rows) }
    }
}

impl Body {
    /// The distance of this body, placed by the pose, from the other, if the peer measures distances.
    pub(crate) fn distance(&self, other: &Self, rows: &Rows) -> Option<f64> {
        // SAFETY: as for `collides`.
        self.driver.distance.map(|distance| unsafe { distance(self.handle, other.handle, rows) })
    }
}

impl Drop for Body {
    fn drop(&mut self) {
        // SAFETY: the handle is this driver's and is not used again.
        unsafe { (self.driver.free)(self.handle) }
    }
}

impl Pair {
    pub(crate) fn collides(&self, rows: &Rows) -> bool {
        // SAFETY: the handle is alive; a pose has 12 contiguous numbers.
        unsafe { (self.solids.collide)(self.handle, rows) }
    }

    /// The result of `peer_pair_distance`.
    pub(crate) fn distance(&self, rows: &Rows, points: &mut [[f64; 3]; 2]) -> f64 {
        // SAFETY: as for `collides`; there is room for six numbers.
        unsafe { (self.solids.distance)(self.handle, rows, points) }
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        // SAFETY: the handle is this driver's and is not used again.
        unsafe { (self.solids.free)(self.handle) }
    }
}
