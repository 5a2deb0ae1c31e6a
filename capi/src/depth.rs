//! Penetration depth of two bodies, and their contacts.

use crate::body::{View, simdop_body};
use crate::boundary::{answered, given, items, places};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::query::{Both, query, simdop_completion, simdop_pair, simdop_query_stats, with_both};
use simdop::query::{DepthInterval, SignedDistance, TriangleContact};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// The penetration depth of two bodies.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_depth_answer {
    /// Unless complete, the bounds may be loose, but are valid.
    pub completion: simdop_completion,
    /// No shorter translation of A separates the bodies. Zero if they are free, or if their interiors are unknown.
    pub lower: f64,
    /// The length of `translation`, rounded up. Zero if and only if the bodies are free; infinite if the budget was
    /// spent before any translation was found.
    pub upper: f64,
    /// After this translation, in B's frame, A is free. Zeros if none was found.
    pub translation: [f64; 3],
    /// Query statistics.
    pub stats: simdop_query_stats,
}

impl From<DepthInterval> for simdop_depth_answer {
    fn from(found: DepthInterval) -> Self {
        Self {
            completion: found.completion.into(),
            lower: found.lower,
            upper: found.upper,
            translation: found.translation,
            stats: found.stats.into(),
        }
    }
}

/// The distance of two bodies, or minus their penetration depth if they meet.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_signed_distance_answer {
    /// Unless complete, the bounds may be loose, but are valid.
    pub completion: simdop_completion,
    /// Lower bound. If the bodies meet: minus the upper bound of their depth.
    pub lower: f64,
    /// Upper bound. If the bodies meet: minus the lower bound of their depth.
    pub upper: f64,
    /// The unit vector, in B's frame, along which a translation of A increases the distance fastest. Zeros if none is
    /// known.
    pub normal: [f64; 3],
    /// The point of A, in B's frame.
    pub a: [f64; 3],
    /// The point of B.
    pub b: [f64; 3],
    /// The derivative with respect to the pose: three numbers for a translation of A along the axes of B's frame, then
    /// three for a rotation about them, in radians.
    pub gradient: [f64; 6],
    /// Query statistics.
    pub stats: simdop_query_stats,
}

impl From<SignedDistance> for simdop_signed_distance_answer {
    fn from(found: SignedDistance) -> Self {
        Self {
            completion: found.completion.into(),
            lower: found.lower,
            upper: found.upper,
            normal: found.normal,
            a: found.a,
            b: found.b,
            gradient: found.gradient,
            stats: found.stats.into(),
        }
    }
}

/// The intersection of two triangles: a segment, or a convex polygon of triangles in one plane.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_contact {
    /// The triangles.
    pub pair: simdop_pair,
    /// The unit normal of A's triangle in B's frame; zeros if the triangle has no area.
    pub normal_a: [f64; 3],
    /// The unit normal of B's triangle.
    pub normal_b: [f64; 3],
    /// Number of points: 1 for a point, 2 for a segment, 3 to 6 for a polygon.
    pub count: usize,
    /// The points in B's frame; zeros beyond `count`.
    pub points: [[f64; 3]; 6],
}

impl From<TriangleContact> for simdop_contact {
    fn from(contact: TriangleContact) -> Self {
        let mut points = [[0.0; 3]; 6];
        points[..contact.points().len()].copy_from_slice(contact.points());
        Self {
            pair: contact.pair.into(),
            normal_a: contact.normal_a,
            normal_b: contact.normal_b,
            count: contact.points().len(),
            points,
        }
    }
}

/// How many contacts were written, and how the query ended.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_contacts_answer {
    /// Complete if all contacts were written, stopped if there was no room for another.
    pub completion: simdop_completion,
    /// Number of contacts written.
    pub count: usize,
    /// Query statistics.
    pub stats: simdop_query_stats,
}

/// What is the penetration depth of two bodies: the length of the shortest translation that separates them? For two
/// shapes, and for a half-space and any body, the depth is known to rounding. For solids of triangles, spheres and
/// several shapes, the bounds are certain, but not tight. The interior of a cloud is unknown, and so is that of a
/// surface paired with a mesh: then the lower bound is 0, unless the other body is a half-space. Otherwise like
/// simdop_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_depth(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_depth_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, query) = (given(a_in_b, "a_in_b")?.checked()?, query(budget));
        Ok(with_both!(Both::new(a, b)?, |a, b| a.depth(&query, &b, &pose))?.into())
    })
}

/// How far must body `a` be translated along `direction`, three numbers in B's frame, until it no longer meets `b`,
/// however much farther it moves? Writes an upper bound to `depth`, which exceeds the least such length by about 2^-30
/// of it. The depth is zero if the bodies do not meet. It is infinite if they do and the direction is zero or leads
/// into a half-space. Otherwise like simdop_collide().
///
/// # Safety
/// `direction` has three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_depth_along(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    direction: *const f64,
    budget: u64,
    depth: Option<&mut MaybeUninit<f64>>,
) -> simdop_error {
    answered(depth, || {
        let (pose, query) = (given(a_in_b, "a_in_b")?.checked()?, query(budget));
        // SAFETY: the caller guarantees the length; three numbers in a row are aligned as one.
        let direction = unsafe { items(direction.cast::<[f64; 3]>(), 1, "direction") }?[0];
        Ok(with_both!(Both::new(a, b)?, |a, b| a.depth_along(&query, &b, &pose, direction))?)
    })
}

/// What is the signed distance of two bodies, the distance or minus the penetration depth, and its derivative with
/// respect to the pose? `tolerance` is that of simdop_distance(), and the depth is that of simdop_depth().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_signed_distance(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    tolerance: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_signed_distance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, query) = (given(a_in_b, "a_in_b")?.checked()?, query(budget));
        Ok(with_both!(Both::new(a, b)?, |a, b| a.signed_distance(&query, &b, &pose, tolerance))?.into())
    })
}

/// Where do the triangles of two bodies touch? Writes at most `room` contacts. A body of anything else is
/// SIMDOP_ERROR_NOT_MESHES. Otherwise like simdop_collide().
///
/// # Safety
/// `contacts` has room for `room` contacts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_contacts(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    contacts: *mut simdop_contact,
    room: usize,
    answer: Option<&mut MaybeUninit<simdop_contacts_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, query) = (given(a_in_b, "a_in_b")?.checked()?, query(budget));
        // SAFETY: the caller guarantees the length.
        let places = unsafe { places(contacts, room, "contacts") }?;
        let mut count = 0;
        let write = |contact: TriangleContact| {
            let Some(place) = places.get_mut(count) else { return ControlFlow::Break(()) };
            place.write(contact.into());
            count += 1;
            ControlFlow::Continue(())
        };
        let (completion, stats) = match Both::new(a, b)? {
            Both::Fixed(View::Mesh(a), View::Mesh(b)) => query.for_each_contact(&a, &b, &pose, write),
            Both::Half(View::Mesh(a), View::Mesh(b)) => query.for_each_contact(&a, &b, &pose, write),
            _ => {
                let message = "the contacts of bodies that are not both of triangles";
                return Err(Failure::new(simdop_error::NotMeshes, message.into()));
            }
        };
        Ok(simdop_contacts_answer { completion: completion.into(), count, stats: stats.into() })
    })
}
