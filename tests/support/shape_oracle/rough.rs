//! The distance of two cores in `f64`: certain where it is far from the reach, otherwise a start for the exact search.
//!
//! In units of the pair's size all coordinates are at most 1, so points of the difference of the two cores are at most
//! 8 from the origin, and everything computed from them is off by less than 2^-44. Bounds are widened by [`MARGIN`].

use super::body::{Body, Pair};
use super::numbers::{Vector, bits, to_f64};
use dashu_int::IBig;
use dashu_int::ops::BitTest;

type Point = [f64; 3];

/// A core in units of the pair's size.
enum Flat {
    Hull(Vec<Point>),
    Round { is_cone: bool, middle: Point, axis: Point, unit: Point, radius: f64 },
}

/// A point of the difference of the two cores.
#[derive(Clone, Copy)]
struct Found {
    point: Point,
    /// The corners, of polytopes.
    corners: [usize; 2],
    /// From the first core to the second.
    direction: Point,
}

/// The rough result.
pub(crate) struct Rough {
    /// In units of the pair's size, and certain.
    pub(crate) lower: f64,
    pub(crate) upper: f64,
    /// The distance up to rounding.
    pub(crate) estimate: f64,
    /// The last simplex: corners of the two cores, for polytopes.
    pub(crate) corners: Vec<[usize; 2]>,
    /// Directions from the first core to the second in which its points are farthest, in units of 2^-60.
    pub(crate) directions: Vec<Vector>,
}

const MARGIN: f64 = 1.0 / (1_u64 << 36) as f64;

/// A length of a unit vector's part across an axis below which that part may be a rounding error.
const LEAST_ACROSS: f64 = 1.0 / (1_u64 << 45) as f64;

/// A volume of a simplex that no rounding changes to zero.
const LEAST_VOLUME: f64 = 1.0 / (1_u64 << 33) as f64;

impl Rough {
    pub(crate) fn new(pair: &Pair) -> Self {
        let bodies = [Flat::new(&pair.a, pair.bits), Flat::new(&pair.b, pair.bits)];
        let mut found = vec![lowest(&bodies, &[1.0, 0.0, 0.0])];
        let (mut lower, mut upper, mut is_inside) = (0.0, f64::INFINITY, false);
        for _ in 0..60 {
            let Some((kept, nearest)) = nearest(&found) else {
                is_inside = true;
                break;
            };
            let length = dot(&nearest, &nearest).sqrt();
            let progress = length < upper;
            upper = length.min(upper);
            let mut corner = 0..;
            found.retain(|_| corner.next().is_some_and(|i: usize| kept & 1 << i != 0));
            if length < 1e-14 || !progress {
                break;
            }
            let direction = nearest.map(|x| x / length);
            let next = lowest(&bodies, &direction);
            let reached = dot(&direction, &next.point);
            lower = reached.max(lower);
            if length - reached < 1e-15 {
                break;
            }
            found.push(next);
        }
        let scaled = |d: &Point| d.map(|x| IBig::from((x * (1_u64 << 60) as f64) as i64));
        Self {
            lower: lower - MARGIN,
            estimate: if is_inside { 0.0 } else { upper },
            upper: if is_inside { 0.0 } else { upper + MARGIN },
            corners: found.iter().map(|f| f.corners).collect(),
            directions: found.iter().map(|f| scaled(&f.direction)).collect(),
        }
    }

    /// Whether the distance is at most `reach`, if that is certain.
    pub(crate) fn is_within(&self, reach: &IBig, size: usize) -> Option<bool> {
        if reach.bit_len() > size + 5 {
            return Some(true);
        }
        // Rounded, but much less than the margin.
        let reach = to_f64(reach, size);
        if self.lower > reach + MARGIN {
            Some(false)
        } else if self.upper == 0.0 || self.upper + MARGIN < reach {
            Some(true)
        } else {
            None
        }
    }
}

impl Flat {
    fn new(body: &Body, size: usize) -> Self {
        let point = |p: &Vector| p.each_ref().map(|x| to_f64(x, size));
        match body {
            Body::Hull(hull) => Self::Hull(hull.corners.iter().map(point).collect()),
            Body::Round(round) => {
                let own = bits(&round.axis);
                let direction = round.axis.each_ref().map(|x| to_f64(x, own));
                let length = dot(&direction, &direction).sqrt();
                Self::Round {
                    is_cone: round.is_cone,
                    middle: point(&round.middle),
                    axis: point(&round.axis),
                    unit: direction.map(|x| x / length),
                    radius: to_f64(&round.radius, size),
                }
            }
            Body::HalfSpace(_) => unreachable!("half-spaces have a closed form"),
        }
    }

    /// A point that is farthest in the direction, a unit vector, and its index if it is a corner.
    fn farthest(&self, n: &Point) -> (Point, usize) {
        match self {
            Self::Hull(corners) => {
                let mut best = (f64::NEG_INFINITY, 0);
                for (i, corner) in corners.iter().enumerate() {
                    let height = dot(n, corner);
                    if height > best.0 {
                        best = (height, i);
                    }
                }
                (corners[best.1], best.1)
            }
            Self::Round { is_cone, middle, axis, unit, radius } => {
                let across = without(n, unit);
                let length = dot(&across, &across).sqrt();
                let across = if length < LEAST_ACROSS {
                    // Mostly rounding errors, perhaps along the axis. The middle of the disc is as far as its rim, up
                    // to `LEAST_ACROSS` radii.
                    [0.0; 3]
                } else {
                    // Twice, so that it is perpendicular to the axis up to rounding even if it was short.
                    let again = without(&across.map(|x| x / length), unit);
                    let length = dot(&again, &again).sqrt();
                    again.map(|x| x / length)
                };
                let along = dot(n, axis);
                let rim = |from: &Point| core::array::from_fn(|k| from[k] + radius * across[k]);
                let end = core::array::from_fn(|k| middle[k] + axis[k]);
                let start = core::array::from_fn(|k| middle[k] - axis[k]);
                let point = match (is_cone, along >= 0.0) {
                    (false, up) => rim(if up { &end } else { &start }),
                    (true, _) if along >= radius * length => end,
                    (true, _) => rim(middle),
                };
                (point, 0)
            }
        }
    }
}

/// The point of the difference that is lowest in a direction.
fn lowest(bodies: &[Flat; 2], direction: &Point) -> Found {
    let towards = direction.map(|x| -x);
    let ((p, i), (q, j)) = (bodies[0].farthest(&towards), bodies[1].farthest(direction));
    Found { point: sub(&p, &q), corners: [i, j], direction: towards }
}

/// Which points, at most four, span the point nearest to the origin, and that point; none if the origin is certainly
/// inside. There are at most five.
fn nearest(found: &[Found]) -> Option<(usize, Point)> {
    let mut best = (f64::INFINITY, 0, [0.0; 3]);
    // Four are kept if the origin is near a face of their tetrahedron; then a new point is the fifth.
    for subset in (1..1_usize << found.len()).filter(|subset| subset.count_ones() <= 4) {
        let (mut points, mut count) = ([[0.0; 3]; 4], 0);
        for (_, f) in found.iter().enumerate().filter(|(i, _)| subset & 1 << i != 0) {
            points[count] = f.point;
            count += 1;
        }
        let [p, q, r, s] = &points;
        let weights = match count {
            1 => [1.0, 0.0, 0.0, 0.0],
            2 => {
                let edge = sub(q, p);
                [dot(&edge, q), -dot(&edge, p), 0.0, 0.0]
            }
            3 => {
                let normal = cross(&sub(q, p), &sub(r, p));
                let part = |u: &Point, v: &Point| dot(&normal, &cross(u, v));
                [part(q, r), part(r, p), part(p, q), 0.0]
            }
            _ => {
                let (pq, rs) = (cross(p, q), cross(r, s));
                let volumes = [dot(q, &rs), -dot(p, &rs), dot(s, &pq), -dot(r, &pq)];
                let same = |sign: f64| volumes.iter().all(|v| v * sign > LEAST_VOLUME);
                if same(1.0) || same(-1.0) {
                    return None;
                }
                volumes
            }
        };
        let sum: f64 = weights[..count].iter().sum();
        let weights = weights.map(|w| w / sum);
        if !weights[..count].iter().all(|w| *w >= 0.0) {
            continue;
        }
        let point = core::array::from_fn(|k| (0..count).map(|i| points[i][k] * weights[i]).sum());
        let square = dot(&point, &point);
        if square < best.0 {
            best = (square, subset, point);
        }
    }
    Some((best.1, best.2))
}

fn sub(u: &Point, v: &Point) -> Point {
    core::array::from_fn(|k| u[k] - v[k])
}

fn dot(u: &Point, v: &Point) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn cross(u: &Point, v: &Point) -> Point {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// The part of a vector that is perpendicular to a unit vector.
fn without(v: &Point, unit: &Point) -> Point {
    let along = dot(v, unit);
    core::array::from_fn(|k| v[k] - along * unit[k])
}
