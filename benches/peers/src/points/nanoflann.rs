//! nanoflann, through `drivers/nanoflann.cpp`.

use super::entrants::{List, Lists, Radii};
use core::ffi::{CStr, c_char, c_void};
use libloading::Library;
use std::path::Path;
use std::rc::Rc;

type Handle = *mut c_void;

/// The loaded driver. Its functions are copied out of the library, which lives as long.
pub(crate) struct Nanoflann {
    version: unsafe extern "C" fn() -> *const c_char,
    cloud: unsafe extern "C" fn(*const [f32; 3], usize, usize) -> Handle,
    free: unsafe extern "C" fn(Handle),
    order: unsafe extern "C" fn(Handle, *mut u32),
    count: unsafe extern "C" fn(Handle, *const [f32; 3], *const u32, usize, *const f32, usize, *mut u32),
    fill: unsafe extern "C" fn(
        Handle,
        *const [f32; 3],
        *const u32,
        usize,
        *const f32,
        usize,
        *mut List,
        *mut u32,
        usize,
    ),
    nearest: unsafe extern "C" fn(Handle, *const [f32; 3], *const u32, usize, usize, *mut u32, *mut f32),
    _library: Library,
}

/// Points in a nanoflann tree.
pub(crate) struct PointCloud {
    driver: Rc<Nanoflann>,
    handle: Handle,
    points: usize,
}

impl Nanoflann {
    pub(crate) fn load(path: &Path) -> Result<Self, libloading::Error> {
        // SAFETY: the driver is this crate's own; loading it starts nothing. The types are those of `nanoflann.cpp`.
        unsafe {
            let library = Library::new(path)?;
            Ok(Self {
                version: *library.get(b"peer_version")?,
                cloud: *library.get(b"peer_cloud")?,
                free: *library.get(b"peer_cloud_free")?,
                order: *library.get(b"peer_cloud_order")?,
                count: *library.get(b"peer_cloud_count")?,
                fill: *library.get(b"peer_cloud_fill")?,
                nearest: *library.get(b"peer_cloud_nearest")?,
                _library: library,
            })
        }
    }
}

/// Queries in a given order.
#[derive(Copy, Clone)]
pub(crate) struct Queries<'a> {
    pub(crate) points: &'a [[f32; 3]],
    pub(crate) order: &'a [u32],
}

impl Queries<'_> {
    fn check(&self) {
        assert!(self.order.iter().all(|&query| (query as usize) < self.points.len()), "a query that is none");
    }
}

impl Nanoflann {
    pub(crate) fn version(&self) -> String {
        // SAFETY: `peer_version` takes nothing and returns a string that lives forever.
        unsafe { CStr::from_ptr((self.version)()) }.to_string_lossy().into_owned()
    }

    /// A tree with this many points per leaf.
    pub(crate) fn build(this: &Rc<Self>, points: &[[f32; 3]], leaf: usize) -> PointCloud {
        // SAFETY: the pointer and the count are those of the array, which the driver copies.
        let handle = unsafe { (this.cloud)(points.as_ptr(), points.len(), leaf) };
        PointCloud { driver: Rc::clone(this), handle, points: points.len() }
    }
}

impl PointCloud {
    /// The points in the order of the tree's leaves.
    pub(crate) fn order(&self) -> Vec<u32> {
        let mut order = vec![0; self.points];
        // SAFETY: the driver writes one index per point.
        unsafe { (self.driver.order)(self.handle, order.as_mut_ptr()) };
        order
    }

    pub(crate) fn count(&self, queries: Queries<'_>, radii: &Radii, counts: &mut [u32]) {
        queries.check();
        let (radii, stride) = radii.strided(queries.points.len());
        assert!(counts.len() >= queries.points.len(), "a count for each query");
        // SAFETY: the order refers to queries, each of which has a radius and a count: checked above.
        unsafe {
            (self.driver.count)(
                self.handle,
                queries.points.as_ptr(),
                queries.order.as_ptr(),
                queries.order.len(),
                radii.as_ptr(),
                stride,
                counts.as_mut_ptr(),
            );
        }
    }

    pub(crate) fn fill(&self, queries: Queries<'_>, radii: &Radii, lists: &mut Lists) {
        queries.check();
        let (radii, stride) = radii.strided(queries.points.len());
        assert!(lists.lists.len() >= queries.points.len(), "a list for each query");
        // SAFETY: as for `count`; no more indices are written than there is room for.
        unsafe {
            (self.driver.fill)(
                self.handle,
                queries.points.as_ptr(),
                queries.order.as_ptr(),
                queries.order.len(),
                radii.as_ptr(),
                stride,
                lists.lists.as_mut_ptr(),
                lists.indices.as_mut_ptr(),
                lists.indices.len(),
            );
        }
    }

    /// The `k` nearest points of each query, and their squared distances.
    pub(crate) fn nearest(&self, queries: Queries<'_>, k: usize, indices: &mut [u32], squares: &mut [f32]) {
        queries.check();
        let need = k * queries.points.len();
        assert!(
            k <= self.points && indices.len() >= need && squares.len() >= need,
            "k places for each query"
        );
        // SAFETY: the order refers to queries, each of which has k places in both arrays: checked above.
        unsafe {
            (self.driver.nearest)(
                self.handle,
                queries.points.as_ptr(),
                queries.order.as_ptr(),
                queries.order.len(),
                k,
                indices.as_mut_ptr(),
                squares.as_mut_ptr(),
            );
        }
    }
}

impl Drop for PointCloud {
    fn drop(&mut self) {
        // SAFETY: the handle is this driver's and is not used again.
        unsafe { (self.driver.free)(self.handle) }
    }
}
