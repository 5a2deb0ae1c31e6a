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
    _library: Library,
}

/// A body in a peer's hands.
pub(crate) struct Body {
    driver: Rc<Driver>,
    handle: Handle,
}

extern "C" fn meet(a: &Triangle, b: &Triangle) -> bool {
    triangle::overlap(a, b, &mut 0)
}

impl Driver {
    pub(crate) fn load(path: &Path) -> Result<Self, libloading::Error> {
        // SAFETY: the drivers are this crate's own; loading one starts nothing but what the peer's package
        // starts. The types are those of `peer.h`, and of `embree.cpp`, which alone takes a triangle
        // test. Symbols of one driver are not seen by the others (RTLD_LOCAL).
        unsafe {
            let library = Library::new(path)?;
            let take: Result<Symbol<'_, unsafe extern "C" fn(TriangleTest)>, _> =
                library.get(b"peer_triangle_test");
            if let Ok(take) = take {
                take(meet);
            }
            Ok(Self {
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
        // SAFETY: `peer_version` takes nothing and returns a string that stays.
        unsafe { CStr::from_ptr((self.version)()) }.to_string_lossy().into_owned()
    }

    pub(crate) fn build(this: &Rc<Self>, mesh: &MeshData) -> Body {
        let (vertices, triangles) = (&mesh.vertices, &mesh.triangles);
        // SAFETY: the pointers and counts are those of the arrays, and every index is below the vertex count:
        // simdop's builder has checked the mesh.
        let handle =
            unsafe { (this.build)(vertices.as_ptr(), vertices.len(), triangles.as_ptr(), triangles.len()) };
        Body { driver: Rc::clone(this), handle }
    }
}

impl Body {
    pub(crate) fn bytes(&self) -> usize {
        // SAFETY: the handle is this driver's, and not freed before `drop`.
        unsafe { (self.driver.bytes)(self.handle) }
    }

    /// Whether this, placed by the pose, meets the other.
    pub(crate) fn collides(&self, other: &Self, rows: &Rows) -> bool {
        // SAFETY: both handles are of one driver (its bodies are made together) and alive; 12 numbers are in
        // a row.
        unsafe { (self.driver.collide)(self.handle, other.handle, rows) }
    }
}

impl Body {
    /// How far this, placed by the pose, is from the other, if the peer measures distances.
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
