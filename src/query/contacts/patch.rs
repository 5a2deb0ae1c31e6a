//! Patches: connected contacts.

use super::TriangleContact;
use crate::exact::power_of_two;
use crate::range::Point;
use crate::vector::{cross, difference, dot, length};

/// Ends nearer to each other than this fraction of the greatest coordinate are the same: twice the error of either, if
/// edges are no longer than twice the greatest coordinate.
const SAME: f64 = power_of_two(-41);

/// Connected contacts.
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub struct ContactPatch {
    /// Index of its first contact.
    pub first: usize,
    /// Number of its contacts.
    pub count: usize,
    /// The mean of the contacts' points, in B's frame.
    pub centre: Point,
    /// The unit vector along which A moves out of B: the mean normal of what the patch encloses. The triangles of both
    /// bodies are assumed to face outwards. Zeros if no direction is better than another.
    ///
    /// For triangles in one plane, it is the normal of B's triangles. For segments that form a loop, it is the mean
    /// normal of the part of either surface that the loop bounds. For other contacts, it is the mean of the differences
    /// of the triangles' normals.
    pub normal: Point,
    /// The total length of its segments.
    pub length: f64,
    /// The area of its polygons; without polygons, the area that its segments enclose in the plane of the normal.
    pub area: f64,
}

/// The room given for patches is too small.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct TooManyPatches {
    /// Number of patches.
    pub count: usize,
}

impl core::fmt::Display for TooManyPatches {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "no room for {} patches", self.count)
    }
}

impl core::error::Error for TooManyPatches {}

/// Orders contacts by patch, and describes the patches, those with the most contacts first. Returns their number.
///
/// Two contacts are connected if they have a common end, to 2^-41 of the greatest coordinate. The time is proportional
/// to the number of contacts times the average number of contacts that overlap one along the longest axis of all.
///
/// # Errors
/// [`TooManyPatches`] if `into` has no room for all.
pub fn patches(contacts: &mut [TriangleContact], into: &mut [ContactPatch]) -> Result<usize, TooManyPatches> {
    join(contacts);
    contacts.sort_unstable_by_key(|contact| (contact.patch, contact.pair));
    let mut count = 0;
    let mut first = 0;
    for group in contacts.chunk_by(|x, y| x.patch == y.patch) {
        if let Some(patch) = into.get_mut(count) {
            *patch = ContactPatch::of(first, group);
        }
        (count, first) = (count + 1, first + group.len());
    }
    let Some(found) = into.get_mut(..count) else { return Err(TooManyPatches { count }) };
    found.sort_unstable_by_key(|patch| (core::cmp::Reverse(patch.count), patch.first));
    Ok(count)
}

/// Sets the patch of each contact: the index of one contact of the same patch.
fn join(contacts: &mut [TriangleContact]) {
    let (mut low, mut high, mut size) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0);
    for p in contacts.iter().flat_map(TriangleContact::points) {
        for i in 0..3 {
            low[i] = f64::min(low[i], p[i]);
            high[i] = f64::max(high[i], p[i]);
            size = f64::max(size, p[i].abs());
        }
    }
    let wider = |i: usize, j: usize| if high[j] - low[j] > high[i] - low[i] { j } else { i };
    let axis = wider(wider(0, 1), 2);
    let same = SAME * size;
    let start = |contact: &TriangleContact| {
        contact.points().iter().fold(f64::INFINITY, |low, p| f64::min(low, p[axis]))
    };
    let end = |contact: &TriangleContact| {
        contact.points().iter().fold(f64::NEG_INFINITY, |high, p| f64::max(high, p[axis]))
    };
    contacts.sort_unstable_by(|x, y| start(x).total_cmp(&start(y)).then(x.pair.cmp(&y.pair)));
    for (index, contact) in contacts.iter_mut().enumerate() {
        contact.patch = index as u32;
    }
    for i in 0..contacts.len() {
        let reach = end(&contacts[i]) + same;
        for j in i + 1..contacts.len() {
            if start(&contacts[j]) > reach {
                break;
            }
            if have_common_end(&contacts[i], &contacts[j], same) {
                let (p, q) = (root(contacts, i as u32), root(contacts, j as u32));
                // The root is the least index.
                contacts[p.max(q) as usize].patch = p.min(q);
            }
        }
    }
    for i in 0..contacts.len() {
        contacts[i].patch = root(contacts, i as u32);
    }
}

/// The contact that represents the patch of contact `i`. Halves the path to it.
fn root(contacts: &mut [TriangleContact], mut i: u32) -> u32 {
    loop {
        let above = contacts[i as usize].patch;
        if above == i {
            return i;
        }
        let next = contacts[above as usize].patch;
        contacts[i as usize].patch = next;
        i = next;
    }
}

fn have_common_end(x: &TriangleContact, y: &TriangleContact, same: f64) -> bool {
    let is_same = |p: &Point, q: &Point| (0..3).all(|i| (p[i] - q[i]).abs() <= same);
    x.points().iter().any(|p| y.points().iter().any(|q| is_same(p, q)))
}

impl ContactPatch {
    fn of(first: usize, contacts: &[TriangleContact]) -> Self {
        let points = || contacts.iter().flat_map(TriangleContact::points);
        let share = 1.0 / points().count() as f64;
        let centre = points().fold([0.0; 3], |sum, p| core::array::from_fn(|i| sum[i] + p[i] * share));
        let plus = |sum: Point, more: Point| -> Point { core::array::from_fn(|i| sum[i] + more[i]) };
        let total = |keep: &dyn Fn(&TriangleContact) -> bool| {
            let kept = contacts.iter().filter(|contact| keep(contact));
            kept.fold([0.0; 3], |sum, contact| plus(sum, contact.vector_area(&centre)))
        };
        let long = contacts.iter().fold(0.0, |sum, contact| sum + contact.segment());
        let of_polygons = total(&TriangleContact::is_polygon);
        let loops = total(&|contact| !contact.is_polygon()).map(|x| -x);
        let has_polygons = contacts.iter().any(TriangleContact::is_polygon);
        let along = if has_polygons {
            of_polygons
        } else if length(&loops) > FLAT * (long * long) {
            loops
        } else {
            contacts.iter().fold([0.0; 3], |sum, contact| {
                let weight = if long > 0.0 { contact.segment() / long } else { 1.0 };
                plus(sum, difference(&contact.normal_b, &contact.normal_a).map(|x| weight * x))
            })
        };
        let area = if has_polygons {
            let areas = contacts.iter().filter(|contact| contact.is_polygon());
            areas.fold(0.0, |sum, contact| sum + length(&contact.vector_area(&contact.points()[0])))
        } else {
            length(&loops)
        };
        let size = length(&along);
        let normal = if size > 0.0 { along.map(|x| x / size) } else { [0.0; 3] };
        Self { first, count: contacts.len(), centre, normal, length: long, area }
    }

    /// The patch's contacts, from those that [`patches`] ordered.
    #[must_use]
    pub fn contacts<'c>(&self, contacts: &'c [TriangleContact]) -> &'c [TriangleContact] {
        contacts.get(self.first..self.first + self.count).unwrap_or(&[])
    }

    /// Chooses up to `into.len()` points of the patch that span it, seen along its normal, and returns their number:
    /// the point farthest from the centre, the point farthest from that, the farthest on either side of the line
    /// through both, and then repeatedly the point farthest outside the polygon so far. For a box on a box, the first
    /// four are the corners of the contact.
    pub fn span(&self, contacts: &[TriangleContact], into: &mut [Point]) -> usize {
        let points = || self.contacts(contacts).iter().flat_map(TriangleContact::points);
        let flat = |from: &Point, to: &Point| {
            let d = difference(to, from);
            let off = dot(&d, &self.normal);
            let in_plane: Point = core::array::from_fn(|i| d[i] - off * self.normal[i]);
            in_plane
        };
        let area = |p: &Point, q: &Point, r: &Point| dot(&cross(&flat(p, q), &flat(p, r)), &self.normal);
        let farthest = |far: &dyn Fn(&Point) -> f64| {
            points().fold((0.0, None), |best: (f64, Option<Point>), p| {
                let x = far(p);
                if x > best.0 { (x, Some(*p)) } else { best }
            })
        };
        let from = |origin: Point| move |p: &Point| length(&flat(&origin, p));
        let first = farthest(&from(self.centre)).1.or_else(|| points().next().copied());
        let (Some(first), false) = (first, into.is_empty()) else { return 0 };
        into[0] = first;
        let Some(second) = farthest(&from(first)).1.filter(|_| into.len() > 1) else { return 1 };
        into[1] = second;
        // Counterclockwise about the normal. A point whose triangle with an edge has an area below `least` does not
        // widen the polygon.
        let (mut count, least) = (2, SAME * dot(&flat(&first, &second), &flat(&first, &second)));
        while count < into.len() {
            let outside = (0..count).fold((least, None), |best: (f64, Option<(usize, Point)>), i| {
                let (p, q) = (into[i], into[(i + 1) % count]);
                let (x, r) = farthest(&|r| -area(&p, &q, r));
                match r {
                    Some(r) if x > best.0 => (x, Some((i + 1, r))),
                    _ => best,
                }
            });
            let Some((at, point)) = outside.1 else { break };
            into[at..=count].rotate_right(1);
            into[at] = point;
            count += 1;
        }
        count
    }
}

/// A loop that encloses less than this fraction of the square of its length is too flat for a normal. A circle encloses
/// 0.08 of it.
const FLAT: f64 = power_of_two(-7);
