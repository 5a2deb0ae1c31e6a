//! Searches of two clouds of points: one in read-only memory, and one built in the program's own memory.

use crate::points::{COUNT, RADII, point};
use core::cell::UnsafeCell;
use core::fmt::Write;
use core::sync::atomic::{AtomicBool, Ordering};
use simdop::cloud::{
    CloudMut, CloudRef, Memory, Neighbour, Queries, Radii, RangeSearch, RangeStats, buckets_for, nodes_for,
};
use simdop::hierarchy::Aligned;
use simdop::isa::Isa;
use simdop::node::{Aabb16, Bucket};

const SIZE: usize = include_bytes!(concat!(env!("OUT_DIR"), "/points.simdop")).len();

/// The baked cloud, read in place.
static CLOUD: Aligned<[u8; SIZE]> = Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/points.simdop")));

include!(concat!(env!("OUT_DIR"), "/expected_work.rs"));

/// Points per bucket of the cloud that changes: less than its capacity, to leave room.
const SPARSE: u32 = 12;
const BUCKETS: usize = buckets_for(COUNT, SPARSE);

/// Static memory for one cloud: there is no heap.
struct Room {
    is_taken: AtomicBool,
    nodes: UnsafeCell<[Aabb16; nodes_for(BUCKETS)]>,
    buckets: UnsafeCell<[Bucket; BUCKETS]>,
    places: UnsafeCell<[u32; COUNT]>,
}

// SAFETY: the flag ensures that the contents of the cells are borrowed only once.
unsafe impl Sync for Room {}

static ROOM: Room = Room {
    is_taken: AtomicBool::new(false),
    nodes: UnsafeCell::new([Aabb16::EMPTY; nodes_for(BUCKETS)]),
    buckets: UnsafeCell::new([Bucket::EMPTY; BUCKETS]),
    places: UnsafeCell::new([0; COUNT]),
};

impl Room {
    fn take(&'static self) -> Option<Memory<'static>> {
        // A load and a store: the smallest cores have no atomic swap, and this program has one thread.
        if self.is_taken.load(Ordering::Relaxed) {
            return None;
        }
        self.is_taken.store(true, Ordering::Relaxed);
        // SAFETY: it was not borrowed before, and cannot be borrowed again.
        let (nodes, buckets, places) =
            unsafe { (&mut *self.nodes.get(), &mut *self.buckets.get(), &mut *self.places.get()) };
        Some(Memory { nodes, buckets, places })
    }
}

/// Whether two points are within a radius of each other, by the library's definition.
fn is_near(p: [f32; 3], q: [f32; 3], radius: f32) -> bool {
    square(p, q) <= radius * radius
}

fn square(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y) + z * z
}

/// Whether searches find the same as a loop over all points. `None` if the library returns an error.
fn agrees(search: RangeSearch, view: &CloudRef<'_>, steps: usize, radius: f32) -> Option<(RangeStats, bool)> {
    let mut counts = [u32::MAX; COUNT];
    let work = search.count(view, &Queries::own(), Radii::Same(radius), &mut counts).ok()?;
    let mut agrees = true;
    for (i, count) in counts.iter().enumerate() {
        let q = point(i, steps);
        let near = (0..COUNT).filter(|&j| is_near(q, point(j, steps), radius)).count();
        agrees &= near == *count as usize;
    }
    for i in 0..40 {
        let q = point(i, steps + 3);
        let all = (0..COUNT).map(|j| Neighbour { index: j as u32, square: square(q, point(j, steps)) });
        // The first of the nearest points.
        let nearest = all.reduce(|best, next| if next.square < best.square { next } else { best });
        agrees &= search.nearest(view, q).ok()? == nearest;
        let is_any = nearest.is_some_and(|best| best.square <= radius * radius);
        agrees &= search.any_within(view, q, radius).ok()? == is_any;
    }
    Some((work, agrees))
}

/// Searches both clouds and prints the results. True if each answer is as expected.
pub fn run(out: &mut impl Write, isa: Isa) -> Result<bool, &'static str> {
    let search = RangeSearch::new(isa);
    let mut good = true;
    let mut say = |what: &str, radius: f32, (work, agrees): (RangeStats, bool)| {
        let verdict = if agrees { "as expected" } else { "WRONG" };
        good &= agrees;
        writeln!(out, "{} {what}, radius {radius}: {work:?}: {verdict}", isa.name()).map_err(|_| "no output")
    };
    let baked = CloudRef::from_bytes(&CLOUD.0).map_err(|_| "the cloud is not one")?;
    for (radius, expected) in RADII.into_iter().zip(EXPECTED_WORK) {
        let (work, agrees) = agrees(search, &baked, 0, radius).ok_or("a search was refused")?;
        say("baked cloud", radius, (work, agrees && work == expected))?;
    }
    let memory = ROOM.take().ok_or("the memory is taken")?;
    let mut points = [[0.0; 3]; COUNT];
    points.iter_mut().enumerate().for_each(|(i, p)| *p = point(i, 0));
    let mut cloud = CloudMut::build(memory, &points, SPARSE).map_err(|_| "the cloud cannot be built")?;
    for (steps, radius) in [(0, 0.5), (1, 0.5), (4, 1.25), (20, 1.25)] {
        points.iter_mut().enumerate().for_each(|(i, p)| *p = point(i, steps));
        cloud.refit(&points).map_err(|_| "the cloud cannot be refitted")?;
        if steps == 4 {
            cloud.rebuild().map_err(|_| "the cloud cannot be rebuilt")?;
        }
        // Remove, and insert again in free slots.
        for index in [7_u32, 250] {
            cloud.remove(index).map_err(|_| "a point cannot be removed")?;
            cloud.insert(index, point(index as usize, steps)).map_err(|_| "a point cannot be inserted")?;
        }
        let found = agrees(search, &cloud.view(), steps, radius).ok_or("a search was refused")?;
        say("cloud in static memory", radius, found)?;
    }
    Ok(good)
}
