//! Queries of two bodies that find more than one pair of primitives.

use crate::body::{View, simdop_body};
use crate::boundary::{answered, given};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::query::{Both, query, simdop_completion, simdop_pair, simdop_query_stats, with_both};
use simdop::query::{Pair, Penetration};
use std::ffi::{c_int, c_void};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

/// Called with each pair of primitives that meet. Returns 0 to go on, anything else to stop. It must return, without an
/// exception or a longjmp().
pub type simdop_on_pair = Option<unsafe extern "C" fn(user: *mut c_void, pair: *const simdop_pair) -> c_int>;

/// The answer of simdop_each_pair().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_pairs {
    /// How the query ended: unless it is complete, pairs may be missing.
    pub completion: simdop_completion,
    /// Query statistics.
    pub stats: simdop_query_stats,
}

/// Calls `on_pair` with `user` once for each pair of primitives that meet. A body that is inside a solid and meets none
/// of its triangles has no pair. Otherwise like simdop_collide(). If `a` has a tree and `b` is one shape, pairs that
/// touch up to the rounding of the inverse pose may be missing, or be reported although they do not meet.
///
/// # Safety
/// `user`, which may be NULL, is what `on_pair` expects.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_each_pair(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    on_pair: simdop_on_pair,
    user: *mut c_void,
    pairs: Option<&mut MaybeUninit<simdop_pairs>>,
) -> simdop_error {
    answered(pairs, || {
        let (pose, on_pair) = (given(a_in_b, "a_in_b")?.checked()?, given(on_pair, "on_pair")?);
        let visit = |pair: Pair| {
            // SAFETY: the caller guarantees that `user` is what the function expects; the pair lives during the call.
            match unsafe { on_pair(user, &pair.into()) } {
                0 => ControlFlow::Continue(()),
                _ => ControlFlow::Break(()),
            }
        };
        let (query, pose) = (query(budget), &pose);
        let (completion, stats) =
            with_both!(Both::new(a, b)?, |a, b| a.for_each_pair(&query, &b, pose, visit))?;
        Ok(simdop_pairs { completion: completion.into(), stats: stats.into() })
    })
}

/// The common volume of two bodies of spheres.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_penetration_answer {
    /// Unless complete, pairs are missing: `volume` is a lower bound, and direction and point are computed from the
    /// pairs found.
    pub completion: simdop_completion,
    /// The volume that the two spheres of a pair share, summed over all pairs, in the bodies' unit cubed. Where the
    /// spheres of one body overlap each other, volume that is covered twice counts twice.
    pub volume: f64,
    /// Upper bound on the volume of a complete query, if the spheres of neither body overlap each other.
    pub upper: f64,
    /// Estimate of the volume of a complete query, from `volume` to `upper`.
    pub estimate: f64,
    /// The direction in which A is pushed, in B's frame: the mean, weighted by volume, of the unit vectors from B's
    /// spheres to A's. Its length is at most 1.
    pub direction: [f64; 3],
    /// The centroid of the common volume in B's frame. NaN if there is none.
    pub point: [f64; 3],
    /// Number of pairs of spheres that meet.
    pub pairs: u64,
    /// Query statistics.
    pub stats: simdop_query_stats,
}

impl From<Penetration> for simdop_penetration_answer {
    fn from(found: Penetration) -> Self {
        Self {
            completion: found.completion.into(),
            volume: found.volume,
            upper: found.upper,
            estimate: found.estimate,
            direction: found.direction,
            point: found.point.unwrap_or([f64::NAN; 3]),
            pairs: found.pairs,
            stats: found.stats.into(),
        }
    }
}

/// What volume do two bodies of spheres share? If they are packings, the packed bodies share at least as much: see
/// simdop_pack(). Bodies of other primitives are SIMDOP_ERROR_NOT_SPHERES. With a budget, the pairs that may share the
/// most are visited first. Otherwise like simdop_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_penetration(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_penetration_answer>>,
) -> simdop_error {
    answered(answer, || {
        let pose = given(a_in_b, "a_in_b")?.checked()?;
        let found = match Both::new(a, b)? {
            Both::Fixed(View::Spheres(a), View::Spheres(b)) => query(budget).penetration(&a, &b, &pose),
            Both::Half(View::Spheres(a), View::Spheres(b)) => query(budget).penetration(&a, &b, &pose),
            _ => {
                let message = "the volume of bodies that are not both of spheres: pack them first";
                return Err(Failure::new(simdop_error::NotSpheres, message.into()));
            }
        };
        Ok(found.into())
    })
}
