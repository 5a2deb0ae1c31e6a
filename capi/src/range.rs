//! Range search in clouds, into the caller's buffers.

use crate::boundary::{answered, filled, given, guarded, items, places};
use crate::cloud::simdop_cloud;
use crate::error::{Failure, simdop_error};
use crate::query::isa;
use simdop::cloud::{List, Neighbour, Queries, Radii, RangeSearch, RangeStats, SearchError, Seat};
use std::ffi::{c_int, c_void};
use std::mem::{MaybeUninit, offset_of};
use std::ops::ControlFlow;

/// Statistics of a range search: the same on every machine.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_range_stats {
    /// Calls of the kernel that tests sixteen boxes.
    pub boxes: u64,
    /// Calls of the kernel that tests the points of a bucket.
    pub buckets: u64,
    /// Neighbours found.
    pub neighbours: u64,
}

/// The position of one query's neighbours in the buffer of indices.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_list {
    /// Index of the first.
    pub start: u32,
    /// Their number.
    pub count: u32,
}

/// A point of a cloud, and its distance from the query.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_neighbour {
    /// Index of the point. UINT32_MAX if the cloud has no more points.
    pub index: u32,
    /// The squared distance, computed in `float`. Infinite if there is no point.
    pub square: f32,
}

// Arrays of these C types are passed on as arrays of the library's types.
const _: () = {
    assert!(size_of::<simdop_list>() == size_of::<List>() && align_of::<simdop_list>() == align_of::<List>());
    assert!(offset_of!(simdop_list, start) == offset_of!(List, start));
    assert!(size_of::<simdop_neighbour>() == size_of::<Neighbour>());
    assert!(align_of::<simdop_neighbour>() == align_of::<Neighbour>());
    assert!(offset_of!(simdop_neighbour, index) == offset_of!(Neighbour, index));
    assert!(size_of::<Seat>() <= size_of::<u64>() && align_of::<Seat>() <= align_of::<u64>());
};

impl From<RangeStats> for simdop_range_stats {
    fn from(RangeStats { boxes, buckets, neighbours }: RangeStats) -> Self {
        Self { boxes, buckets, neighbours }
    }
}

/// Called with the index of each point found. Returns 0 to go on, anything else to stop. It must return, without an
/// exception or a longjmp().
pub type simdop_on_point = Option<unsafe extern "C" fn(user: *mut c_void, index: u32) -> c_int>;

fn search() -> RangeSearch {
    RangeSearch::new(isa())
}

/// The radii of queries: one for all, or one for each.
///
/// # Safety
/// As for [`items`].
unsafe fn radii<'a>(radii: *const f32, count: usize) -> Result<Radii<'a>, Failure> {
    // SAFETY: the caller guarantees the length.
    let radii = unsafe { items(radii, count, "radii") }?;
    Ok(match radii {
        [one] => Radii::Same(*one),
        each => Radii::Each(each),
    })
}

/// Writes 1 to `is_any` if any point of the cloud is within `radius` of `centre`, and otherwise 0. A point counts if
/// `(x * x + y * y) + z * z <= radius * radius` for the differences of the coordinates, with every operation rounded to
/// `float`, as in all searches: they find what a loop over all points would find.
///
/// # Safety
/// `centre` has three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_any_within(
    cloud: Option<&simdop_cloud>,
    centre: *const f32,
    radius: f32,
    is_any: Option<&mut MaybeUninit<c_int>>,
) -> simdop_error {
    answered(is_any, || {
        let cloud = given(cloud, "cloud")?.view();
        // SAFETY: the caller guarantees three numbers.
        let centre = unsafe { items(centre, 3, "centre") }?;
        Ok(search().any_within(&cloud, [centre[0], centre[1], centre[2]], radius)?.into())
    })
}

/// Calls `on_point` with `user` for each point within `radius` of `centre`. Many queries are faster together: see
/// simdop_cloud_neighbours_of().
///
/// # Safety
/// `centre` has three numbers. `user`, which may be NULL, is what `on_point` expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_each_within(
    cloud: Option<&simdop_cloud>,
    centre: *const f32,
    radius: f32,
    on_point: simdop_on_point,
    user: *mut c_void,
    stats: Option<&mut MaybeUninit<simdop_range_stats>>,
) -> simdop_error {
    answered(stats, || {
        let (cloud, on_point) = (given(cloud, "cloud")?.view(), given(on_point, "on_point")?);
        // SAFETY: the caller guarantees three numbers.
        let centre = unsafe { items(centre, 3, "centre") }?;
        let visit = |index| {
            // SAFETY: the caller guarantees that `user` is what the function expects.
            match unsafe { on_point(user, index) } {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let found = search().each_within(&cloud, [centre[0], centre[1], centre[2]], radius, visit)?;
        Ok(found.into())
    })
}

/// Finds the `k` nearest points of each of `count` query points, given as x, y, z. `neighbours` has room for `k` for
/// each, sorted by distance and then by index.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_nearest(
    cloud: Option<&simdop_cloud>,
    points: *const f32,
    count: usize,
    k: usize,
    neighbours: *mut simdop_neighbour,
) -> simdop_error {
    guarded(|| {
        let cloud = given(cloud, "cloud")?.view();
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let points: &[[f32; 3]] = unsafe { items(points.cast(), count, "points") }?;
        let room = count.checked_mul(k);
        let room = room.ok_or_else(|| Failure::new(simdop_error::TooLarge, format!("{count} times {k}")))?;
        // SAFETY: the caller guarantees room for these; the two types have one layout.
        let found = filled(unsafe { places(neighbours.cast(), room, "neighbours") }?, Neighbour::NONE);
        if k == 0 {
            return Ok(());
        }
        for (query, (point, found)) in (0..).zip(points.iter().zip(found.chunks_mut(k))) {
            search().k_nearest(&cloud, *point, found).map_err(|error| match error {
                SearchError::Query { .. } => SearchError::Query { query },
                other => other,
            })?;
        }
        Ok(())
    })
}

/// Counts the points within a radius of each point of the cloud, the point itself included. `radii` has a radius for
/// each index below the capacity, or one for all; `counts` has room for `count` numbers, at least the capacity. Unused
/// indices have the count 0.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_count(
    cloud: Option<&simdop_cloud>,
    radii: *const f32,
    radius_count: usize,
    counts: *mut u32,
    count: usize,
    stats: Option<&mut MaybeUninit<simdop_range_stats>>,
) -> simdop_error {
    answered(stats, || {
        let cloud = given(cloud, "cloud")?.view();
        // SAFETY: the caller guarantees the length.
        let radii = unsafe { self::radii(radii, radius_count) }?;
        // SAFETY: as above.
        let counts = filled(unsafe { places(counts, count, "counts") }?, 0);
        Ok(search().count(&cloud, &Queries::own(), radii, counts)?.into())
    })
}

/// Memory and results of a search for neighbours: buffers of the caller.
#[repr(C)]
#[derive(Copy, Clone, Debug)]
pub struct simdop_neighbour_lists {
    /// A list for each query.
    pub lists: *mut simdop_list,
    /// Number of lists: at least the number of queries.
    pub list_count: usize,
    /// The neighbours of query i are `indices[lists[i].start]` and the following `lists[i].count - 1`.
    pub indices: *mut u32,
    /// Number of indices that fit. If it is too small, the error is SIMDOP_ERROR_BUFFER, `needed` holds the number
    /// needed, and the counts of the lists are correct.
    pub room: usize,
    /// Written on success and on SIMDOP_ERROR_BUFFER: the number of neighbours of all queries.
    pub needed: u64,
}

/// Fills the lists, and writes `needed`.
///
/// # Safety
/// The buffers have the stated lengths.
unsafe fn fill(
    cloud: &simdop_cloud,
    queries: &Queries<'_>,
    radii: Radii<'_>,
    into: &mut simdop_neighbour_lists,
) -> Result<simdop_range_stats, Failure> {
    let nothing = List { start: 0, count: 0 };
    // SAFETY: the caller guarantees the length; the two types have one layout.
    let lists = filled(unsafe { places(into.lists.cast(), into.list_count, "lists") }?, nothing);
    // SAFETY: as above.
    let indices = filled(unsafe { places(into.indices, into.room, "indices") }?, 0);
    let found = search().fill(&cloud.view(), queries, radii, lists, indices);
    match &found {
        Ok(stats) => into.needed = stats.neighbours,
        Err(SearchError::Buffer { need, .. }) => into.needed = *need,
        Err(_) => {}
    }
    Ok(found?.into())
}

/// Finds the points within a radius of each point of the cloud: a query for each index below the capacity. `radii` has
/// a radius for each index, or one for all. Unused indices have empty lists.
///
/// # Safety
/// The arrays have these lengths, and those of `into` the stated ones.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_neighbours(
    cloud: Option<&simdop_cloud>,
    radii: *const f32,
    radius_count: usize,
    into: Option<&mut simdop_neighbour_lists>,
    stats: Option<&mut MaybeUninit<simdop_range_stats>>,
) -> simdop_error {
    answered(stats, || {
        let (cloud, into) = (given(cloud, "cloud")?, given(into, "into")?);
        // SAFETY: the caller guarantees the length.
        let radii = unsafe { self::radii(radii, radius_count) }?;
        // SAFETY: the caller guarantees the lengths.
        unsafe { fill(cloud, &Queries::own(), radii, into) }
    })
}

/// Finds the points of the cloud within a radius of each of `count` query points, given as x, y, z. `radii` has a
/// radius for each, or one for all. `memory` has 8 bytes for each query point, which are overwritten.
///
/// # Safety
/// The arrays have these lengths, and those of `into` the stated ones.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_cloud_neighbours_of(
    cloud: Option<&simdop_cloud>,
    points: *const f32,
    count: usize,
    radii: *const f32,
    radius_count: usize,
    memory: *mut u64,
    into: Option<&mut simdop_neighbour_lists>,
    stats: Option<&mut MaybeUninit<simdop_range_stats>>,
) -> simdop_error {
    answered(stats, || {
        let (cloud, into) = (given(cloud, "cloud")?, given(into, "into")?);
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let points: &[[f32; 3]] = unsafe { items(points.cast(), count, "points") }?;
        // SAFETY: as above.
        let radii = unsafe { self::radii(radii, radius_count) }?;
        // SAFETY: as above; a seat is no larger than 8 bytes.
        let seats = filled(unsafe { places(memory.cast(), count, "memory") }?, Seat::default());
        let queries = search().seat(&cloud.view(), points, seats)?;
        // SAFETY: the caller guarantees the lengths.
        unsafe { fill(cloud, &queries, radii, into) }
    })
}
