//! Clouds of moving points, which searches and scenes use.

use crate::boundary::{answered, given, guarded, items, make};
use crate::error::simdop_error;
use simdop::cloud::{BUCKET_SIZE, CloudRef, PointCloud};
use std::mem::MaybeUninit;

/// Points with a tree over them, such as a scan of a robot's surroundings. A point keeps its index while it moves.
/// While a cloud is in a scene, it must not be changed: remove it, and insert it again.
#[derive(Debug)]
pub struct simdop_cloud(PointCloud);

/// The size of a cloud.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_cloud_size {
    /// Number of points.
    pub points: usize,
    /// Indices of points are below this: the number of points at construction, unless room for more was asked for.
    pub capacity: usize,
}

impl simdop_cloud {
    pub(crate) fn view(&self) -> CloudRef<'_> {
        self.0.view()
    }
}

/// Builds a cloud. `points` holds x, y, z for each of `count` points: any finite numbers. They are copied.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_build(
    points: *const f32,
    count: usize,
    cloud: Option<&mut MaybeUninit<Option<Box<simdop_cloud>>>>,
) -> simdop_error {
    // SAFETY: the caller gives the same guarantee.
    unsafe { simdop_cloud_build_with_room(points, count, BUCKET_SIZE, count, cloud) }
}

/// Builds a cloud like simdop_cloud_build(), with room for points that are inserted later: at most `bucket_size`, from
/// 1 to 16, points in each bucket of the tree, and indices below `capacity`.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_build_with_room(
    points: *const f32,
    count: usize,
    bucket_size: u32,
    capacity: usize,
    cloud: Option<&mut MaybeUninit<Option<Box<simdop_cloud>>>>,
) -> simdop_error {
    make(cloud, "cloud", || {
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let points = unsafe { items(points.cast(), count, "points") }?;
        Ok(simdop_cloud(PointCloud::with_room(points, bucket_size, capacity)?))
    })
}

/// Moves all points. `points` holds x, y, z for each of `count` indices, at least the capacity; those of an index
/// without a point are ignored. Writes to `ratio` the largest growth factor of a box's volume since the tree was built:
/// rebuild when searches become slow, or at a ratio of about 10.
///
/// # Safety
/// The array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_refit(
    cloud: Option<&mut simdop_cloud>,
    points: *const f32,
    count: usize,
    ratio: Option<&mut MaybeUninit<f64>>,
) -> simdop_error {
    answered(ratio, || {
        let cloud = given(cloud, "cloud")?;
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let points = unsafe { items(points.cast(), count, "points") }?;
        Ok(cloud.0.refit(points)?)
    })
}

/// Rebuilds the tree of a cloud from the current positions of its points.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_cloud_rebuild(cloud: Option<&mut simdop_cloud>) -> simdop_error {
    guarded(|| Ok(given(cloud, "cloud")?.0.rebuild()?))
}

/// Inserts a point under an unused index below the capacity. `point` holds x, y, z. If no bucket near it has room, the
/// error is SIMDOP_ERROR_CLOUD_FULL: rebuild.
///
/// # Safety
/// There are three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_insert(
    cloud: Option<&mut simdop_cloud>,
    index: u32,
    point: *const f32,
) -> simdop_error {
    guarded(|| {
        let cloud = given(cloud, "cloud")?;
        // SAFETY: the caller guarantees three numbers.
        let point = unsafe { items(point, 3, "point") }?;
        Ok(cloud.0.insert(index, [point[0], point[1], point[2]])?)
    })
}

/// Removes the point of an index.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_cloud_remove(cloud: Option<&mut simdop_cloud>, index: u32) -> simdop_error {
    guarded(|| Ok(given(cloud, "cloud")?.0.remove(index)?))
}

/// Writes the size of a cloud.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_cloud_get_size(
    cloud: Option<&simdop_cloud>,
    size: Option<&mut MaybeUninit<simdop_cloud_size>>,
) -> simdop_error {
    answered(size, || {
        let view = given(cloud, "cloud")?.view();
        Ok(simdop_cloud_size { points: view.len(), capacity: view.capacity() })
    })
}

/// Destroys a cloud. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_cloud_destroy(cloud: Option<Box<simdop_cloud>>) {
    drop(cloud);
}
