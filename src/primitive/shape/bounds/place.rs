//! Points of cores by coordinates: where they are, and how they move.

use super::support::{Form, each};
use crate::range::Point;
use crate::vector::{difference, dot, sqrt};

/// A way at a bound is blocked up to this squared cosine of its angle with the pull, which may be due to rounding.
const FLAT: f64 = 1e-24;

/// Points of the unit disc whose squared radius is at least one less this are on the rim.
const ON_RIM: f64 = 1e-13;

/// A point of a core.
#[derive(Copy, Clone, Debug)]
pub(super) struct CorePoint {
    /// Multiples of half edges or of the half axis in -1 ..= 1; for a triangle, barycentric coordinates.
    x: [f64; 3],
    /// A point of the unit disc. A cone's disc at height x of the half axis is (1 - x) / 2 as large as its base.
    disc: [f64; 2],
}

/// A direction in which a place can move without leaving its core.
#[derive(Copy, Clone, Debug)]
pub(super) struct Way {
    /// The derivative of the point.
    pub(super) tangent: Point,
    /// The dot products of the pull with the tangent, with the second derivative, and with the mixed derivative by
    /// this way and the way before.
    pub(super) slope: f64,
    pub(super) bend: f64,
    pub(super) mixed: f64,
    slot: FreeCoordinate,
}

/// The coordinates that a way changes.
#[derive(Copy, Clone, Debug)]
enum FreeCoordinate {
    Line(u8),
    /// Weight moves to a corner of a triangle from another corner.
    Corner(u8, u8),
    Disc(u8),
    /// The angle on the rim of a disc.
    Rim,
}

/// At most six ways.
#[derive(Copy, Clone, Debug)]
pub(super) struct Ways {
    pub(super) list: [Way; 6],
    pub(super) len: usize,
}

impl Ways {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let way = Way { tangent: [0.0; 3], slope: 0.0, bend: 0.0, mixed: 0.0, slot: FreeCoordinate::Rim };
        Self { list: [way; 6], len: 0 }
    }

    #[inline(always)]
    fn add(&mut self, tangent: Point, slope: f64, slot: FreeCoordinate) {
        self.list[self.len] = Way { tangent, slope, bend: 0.0, mixed: 0.0, slot };
        self.len += 1;
    }

    /// Adds the way of a coordinate in -1 ..= 1, unless it is at its bound and pulled against it. Returns whether it
    /// was added.
    #[inline(always)]
    fn add_line(&mut self, k: u8, x: f64, tangent: &Point, pull: &Point) -> bool {
        let slope = dot(tangent, pull);
        let is_free = x > -1.0 && x < 1.0
            || slope * slope > FLAT * dot(tangent, tangent)
                && if x < 0.0 { slope < 0.0 } else { slope > 0.0 };
        if is_free {
            self.add(*tangent, slope, FreeCoordinate::Line(k));
        }
        is_free
    }
}

impl Way {
    #[inline(always)]
    pub(super) fn bends(&self) -> bool {
        matches!(self.slot, FreeCoordinate::Rim)
    }
}

impl Form {
    /// The place nearest to a point, up to rounding; only approximately for a cuboid whose edges are not quite
    /// perpendicular.
    #[inline(always)]
    pub(super) fn nearest(&self, p: &Point) -> CorePoint {
        let (mut x, mut disc) = ([0.0; 3], [0.0; 2]);
        match self {
            Self::Point => {}
            Self::Segment(half) => x[0] = share(p, half).clamp(-1.0, 1.0),
            Self::Triangle(corners) => x = nearest_in_triangle(corners, p),
            Self::Cuboid(half) => {
                for k in 0..3 {
                    x[k] = share(p, &half[k]).clamp(-1.0, 1.0);
                }
            }
            Self::Cylinder(half, [u, v]) => {
                x[0] = share(p, half).clamp(-1.0, 1.0);
                disc = in_disc([share(p, u), share(p, v)]);
            }
            Self::Cone(half, [u, v]) => {
                let (height, [y, z]) = (share(p, half), [share(p, u), share(p, v)]);
                let (half, radius) = (sqrt(dot(half, half)), sqrt(dot(u, u)));
                let out = sqrt(y * y + z * z);
                let room = 0.5 * (1.0 - height);
                if height >= -1.0 && out <= room {
                    let inverse = if room > 0.0 { 1.0 / room } else { 0.0 };
                    return CorePoint { x: [height, 0.0, 0.0], disc: [y * inverse, z * inverse] };
                }
                // In the half plane through the axis and the point: the side from the rim to the tip, or the base.
                let (dx, dy) = ((out - 1.0) * radius, (height + 1.0) * half);
                let square = radius * radius + 4.0 * half * half;
                let along = (2.0 * half * dy - radius * dx) / square;
                let along = if along > 0.0 { along.min(1.0) } else { 0.0 };
                let (sx, sy) = (dx + along * radius, dy - 2.0 * along * half);
                let bx = if out > 1.0 { dx } else { 0.0 };
                if bx * bx + dy * dy < sx * sx + sy * sy {
                    return CorePoint { x: [-1.0, 0.0, 0.0], disc: in_disc([y, z]) };
                }
                x[0] = 2.0 * along - 1.0;
                disc = if out > 0.0 { [y / out, z / out] } else { [1.0, 0.0] };
            }
        }
        CorePoint { x, disc }
    }

    /// The point at a place, relative to the centre.
    #[inline(always)]
    pub(super) fn at(&self, place: &CorePoint) -> Point {
        let (x, disc) = (&place.x, &place.disc);
        match self {
            Self::Point => [0.0; 3],
            Self::Segment(half) => each(|k| x[0] * half[k]),
            Self::Triangle([p, q, r]) | Self::Cuboid([p, q, r]) => {
                each(|k| (x[0] * p[k] + x[1] * q[k]) + x[2] * r[k])
            }
            Self::Cylinder(half, [u, v]) => each(|k| x[0] * half[k] + (disc[0] * u[k] + disc[1] * v[k])),
            Self::Cone(half, [u, v]) => {
                let (y, z) = (0.5 * (1.0 - x[0]) * disc[0], 0.5 * (1.0 - x[0]) * disc[1]);
                each(|k| x[0] * half[k] + (y * u[k] + z * v[k]))
            }
        }
    }

    /// The radius of a ball about a place that is certainly inside the core, up to the slack of a pair. The half edges
    /// of a cuboid are perpendicular within 1e-4, so the distance of a face is at least 1 - 4e-4 times the length of
    /// its half edge.
    pub(super) fn room(&self, place: &CorePoint) -> f64 {
        let along = |k: usize, half: &Point| (1.0 - place.x[k].abs()) * sqrt(dot(half, half));
        let across = |u: &Point| {
            let out = sqrt(place.disc[0] * place.disc[0] + place.disc[1] * place.disc[1]);
            (1.0 - out) * sqrt(dot(u, u))
        };
        match self {
            Self::Point | Self::Segment(_) | Self::Triangle(_) => 0.0,
            Self::Cuboid([x, y, z]) => 0.999 * along(0, x).min(along(1, y)).min(along(2, z)),
            Self::Cylinder(half, [u, _]) => 0.999 * along(0, half).min(across(u)),
            Self::Cone(half, [u, _]) => {
                let (height, radius) = (2.0 * sqrt(dot(half, half)), sqrt(dot(u, u)));
                let up = 0.5 * (1.0 + place.x[0]) * height;
                let out = 0.5 * (1.0 - place.x[0]) * across(u);
                0.999 * up.min(out * (height / sqrt(height * height + radius * radius)))
            }
        }
    }

    /// [`Form::room`] for the centre.
    #[inline(always)]
    pub(super) fn inner(&self) -> f64 {
        let length = |v: &Point| sqrt(dot(v, v));
        match self {
            Self::Point | Self::Segment(_) | Self::Triangle(_) => 0.0,
            Self::Cuboid([x, y, z]) => 0.999 * length(x).min(length(y)).min(length(z)),
            Self::Cylinder(half, [u, _]) => 0.999 * length(half).min(length(u)),
            Self::Cone(half, [u, _]) => {
                // By similar triangles, the distance of the side from the middle of the axis.
                let (half, radius) = (length(half), length(u));
                0.999 * half * (radius / sqrt(4.0 * half * half + radius * radius)).min(1.0)
            }
        }
    }

    /// Three vectors along all faces and edges at a place.
    pub(super) fn edges(&self, place: &CorePoint) -> [Point; 3] {
        let [y, z] = place.disc;
        let on_disc = |[u, v]: &[Point; 2], y: f64, z: f64| each(|k| y * u[k] + z * v[k]);
        match self {
            Self::Point => [[0.0; 3]; 3],
            Self::Segment(half) => [*half; 3],
            Self::Triangle([p, q, r]) => [difference(q, p), difference(r, q), difference(p, r)],
            Self::Cuboid(half) => *half,
            Self::Cylinder(half, disc) => [*half, on_disc(disc, y, z), on_disc(disc, -z, y)],
            Self::Cone(half, disc) => {
                let out = on_disc(disc, y, z);
                [each(|k| 2.0 * half[k] - out[k]), out, on_disc(disc, -z, y)]
            }
        }
    }

    /// A direction near d that is perpendicular to the side line of a cone at which d points outwards. It has d's
    /// azimuth, so the line is exact.
    pub(super) fn across_side(&self, place: &CorePoint, d: &Point) -> Point {
        let Self::Cone(half, [u, v]) = self else { return *d };
        let (y, z) = (dot(d, u), dot(d, v));
        let out = sqrt(y * y + z * z);
        if place.x[0] <= -1.0 || place.x[0] >= 1.0 || out == 0.0 {
            return *d;
        }
        let side: Point = each(|k| half[k] - (y * u[k] + z * v[k]) / (2.0 * out));
        let rest = dot(&side, d) / dot(&side, &side);
        each(|k| d[k] - rest * side[k])
    }

    /// The ways of a place that is pulled along -`pull`: those that the boundary of the core does not block.
    #[inline(always)]
    pub(super) fn ways(&self, place: &CorePoint, pull: &Point, ways: &mut Ways) {
        let x = &place.x;
        match self {
            Self::Point => {}
            Self::Segment(half) => {
                ways.add_line(0, x[0], half, pull);
            }
            Self::Triangle(corners) => {
                let most = if x[0] >= x[1] && x[0] >= x[2] { 0 } else { 1 + usize::from(x[2] > x[1]) };
                for k in 0..3 {
                    let way = difference(&corners[k], &corners[most]);
                    let slope = dot(&way, pull);
                    if k != most && (x[k] > 0.0 || slope < 0.0) {
                        ways.add(way, slope, FreeCoordinate::Corner(k as u8, most as u8));
                    }
                }
            }
            Self::Cuboid(half) => {
                ways.add_line(0, x[0], &half[0], pull);
                ways.add_line(1, x[1], &half[1], pull);
                ways.add_line(2, x[2], &half[2], pull);
            }
            Self::Cylinder(half, disc) => {
                ways.add_line(0, x[0], half, pull);
                disc_ways(disc, &place.disc, 1.0, pull, ways);
            }
            Self::Cone(half, disc) => {
                let [u, v] = disc;
                let (y, z) = (place.disc[0], place.disc[1]);
                let side: Point = each(|k| half[k] - 0.5 * (y * u[k] + z * v[k]));
                let slides = ways.add_line(0, x[0], &side, pull);
                let before = ways.len;
                disc_ways(disc, &place.disc, 0.5 * (1.0 - x[0]), pull, ways);
                if slides && ways.len == before + 1 {
                    ways.list[before].mixed = 0.5 * (z * dot(u, pull) - y * dot(v, pull));
                }
            }
        }
    }
}

/// How a step moves a place.
#[derive(Copy, Clone, Debug)]
pub(super) struct Displacement {
    x: [f64; 3],
    disc: [f64; 2],
    rim: f64,
    /// Whether the coordinates are barycentric.
    is_barycentric: bool,
}

impl Displacement {
    pub(super) const NONE: Self = Self { x: [0.0; 3], disc: [0.0; 2], rim: 0.0, is_barycentric: false };

    /// Adds a step along a way.
    #[inline(always)]
    pub(super) fn add(&mut self, way: &Way, by: f64) {
        match way.slot {
            FreeCoordinate::Line(k) => self.x[usize::from(k)] = by,
            FreeCoordinate::Corner(k, from) => {
                self.x[usize::from(k)] += by;
                self.x[usize::from(from)] -= by;
                self.is_barycentric = true;
            }
            FreeCoordinate::Disc(k) => self.disc[usize::from(k)] = by,
            FreeCoordinate::Rim => self.rim = by,
        }
    }
}

impl CorePoint {
    /// The place after a share of a displacement, or the point of the core near it.
    #[inline(always)]
    pub(super) fn moved(&self, by: &Displacement, share: f64) -> Self {
        let mut x = each(|k| self.x[k] + share * by.x[k]);
        if by.is_barycentric {
            let [p, q, r] = x.map(|x| if x > 0.0 { x } else { 0.0 });
            let inverse = 1.0 / ((p + q) + r);
            x = [p * inverse, q * inverse, r * inverse];
        } else {
            x = x.map(|x| x.clamp(-1.0, 1.0));
        }
        let [mut y, mut z] = self.disc;
        if by.rim != 0.0 {
            let turn = share * by.rim;
            let (u, v) = (y - z * turn, z + y * turn);
            let inverse = 1.0 / sqrt(u * u + v * v);
            (y, z) = (u * inverse, v * inverse);
        }
        Self { x, disc: in_disc([y + share * by.disc[0], z + share * by.disc[1]]) }
    }

    /// The share of a displacement, at most 1, after which a coordinate reaches its bound.
    #[inline(always)]
    pub(super) fn share_to_bound(&self, by: &Displacement) -> f64 {
        let mut share = 1.0;
        let low = if by.is_barycentric { 0.0 } else { -1.0 };
        for k in 0..3 {
            let (x, step) = (self.x[k], by.x[k]);
            if x + step > 1.0 {
                share = ((1.0 - x) / step).min(share);
            } else if x + step < low {
                share = ((low - x) / step).min(share);
            }
        }
        let ([y, z], [u, v]) = (self.disc, by.disc);
        let (square, product) = (u * u + v * v, y * u + z * v);
        let rest = 1.0 - (y * y + z * z);
        if square > 0.0 && square + 2.0 * product > rest {
            // The greater root of `square t^2 + 2 product t = rest`.
            share = ((sqrt(product * product + square * rest.max(0.0)) - product) / square).min(share);
        }
        share
    }
}

#[inline(always)]
fn disc_ways([u, v]: &[Point; 2], [y, z]: &[f64; 2], share: f64, pull: &Point, ways: &mut Ways) {
    let (du, dv) = (share * dot(u, pull), share * dot(v, pull));
    let out = y * du + z * dv;
    let is_on_rim = y * y + z * z > 1.0 - ON_RIM;
    if is_on_rim && (out <= 0.0 || out * out <= FLAT * (share * share * dot(u, u))) {
        let tangent = each(|k| share * (y * v[k] - z * u[k]));
        ways.add(tangent, y * dv - z * du, FreeCoordinate::Rim);
        ways.list[ways.len - 1].bend = if out < 0.0 { -out } else { 0.0 };
    } else {
        ways.add(each(|k| share * u[k]), du, FreeCoordinate::Disc(0));
        ways.add(each(|k| share * v[k]), dv, FreeCoordinate::Disc(1));
    }
}

/// The multiple of a vector nearest to a point.
#[inline(always)]
fn share(p: &Point, of: &Point) -> f64 {
    let square = dot(of, of);
    if square > 0.0 { dot(p, of) / square } else { 0.0 }
}

/// The point of the unit disc nearest to a point.
#[inline(always)]
fn in_disc([y, z]: [f64; 2]) -> [f64; 2] {
    let square = y * y + z * z;
    if square <= 1.0 {
        return [y, z];
    }
    let inverse = 1.0 / sqrt(square);
    [y * inverse, z * inverse]
}

/// Barycentric coordinates.
#[inline(always)]
fn nearest_in_triangle(corners: &[Point; 3], at: &Point) -> [f64; 3] {
    use crate::vector::cross;
    let [p, q, r] = corners;
    let (a, b, c) = (difference(p, at), difference(q, at), difference(r, at));
    let normal = cross(&difference(&b, &a), &difference(&c, &a));
    let (x, y, z) =
        (dot(&normal, &cross(&b, &c)), dot(&normal, &cross(&c, &a)), dot(&normal, &cross(&a, &b)));
    if x > 0.0 && y > 0.0 && z > 0.0 {
        let inverse = 1.0 / ((x + y) + z);
        return [x * inverse, y * inverse, z * inverse];
    }
    let (mut best, mut least) = ([1.0, 0.0, 0.0], f64::INFINITY);
    let places = [&a, &b, &c];
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let edge = difference(places[j], places[i]);
        let t = (-share(places[i], &edge)).clamp(0.0, 1.0);
        let v = each(|n| places[i][n] + t * edge[n]);
        let square = dot(&v, &v);
        if square < least {
            least = square;
            best = [0.0; 3];
            best[i] = 1.0 - t;
            best[j] = t;
        }
    }
    best
}
