//! Shapes in integers.

use super::numbers::{Vector, add, bits, dot, integer, least_exponent, sub};
use dashu_int::IBig;
use dashu_int::ops::BitTest;
use simdop::primitive::shape::{Core, Shape};

/// A core in units of the pair.
pub(crate) enum Body {
    Hull(Hull),
    Round(Round),
    HalfSpace(Plane),
}

/// The image of a cube or a simplex under an affine map: all `corner + sum x_i edges[i]` with `x_i` in 0 ..= 1, for a
/// triangle also with a sum of at most 1.
pub(crate) struct Hull {
    pub(crate) corner: Vector,
    pub(crate) edges: Vec<Vector>,
    pub(crate) is_triangle: bool,
    /// All its corners; several may be equal.
    pub(crate) corners: Vec<Vector>,
}

/// A cylinder or a cone.
pub(crate) struct Round {
    pub(crate) is_cone: bool,
    /// The centre of a cylinder, or of a cone's disc.
    pub(crate) middle: Vector,
    /// From the middle to the centre of the upper disc, or to the tip.
    pub(crate) axis: Vector,
    pub(crate) radius: IBig,
}

/// All points p with `normal . p <= offset`.
pub(crate) struct Plane {
    pub(crate) normal: Vector,
    pub(crate) offset: IBig,
}

/// Two cores, translated such that the second is near the origin, and the greatest distance at which they count as
/// meeting.
pub(crate) struct Pair {
    pub(crate) a: Body,
    pub(crate) b: Body,
    pub(crate) reach: IBig,
    /// Lengths are in units of 2^exponent.
    pub(crate) exponent: i32,
    /// All coordinates of points, and all radii of cores, are below 2^bits.
    pub(crate) bits: usize,
}

impl Pair {
    /// The unit is so small that all numbers are integers, and below 2^-`precision` of the size.
    pub(crate) fn new(a: &Shape, b: &Shape, margin: f64, precision: usize) -> Self {
        let radii = [a.radius(), b.radius(), margin];
        let normals: Vec<f64> = [a, b].iter().flat_map(|shape| normal(shape.core())).collect();
        let scale = least_exponent(normals).unwrap_or(0);
        let offsets = [a, b].map(|shape| match shape.core() {
            Core::HalfSpace { offset, .. } if *offset != 0.0 => least_exponent([*offset]),
            _ => None,
        });
        let lengths = lengths(a.core()).into_iter().chain(lengths(b.core())).chain(radii);
        let of_offsets = offsets.into_iter().flatten().map(|e| e - scale);
        let mut exponent = least_exponent(lengths).into_iter().chain(of_offsets).min().unwrap_or(0);
        let read = |exponent| [a, b].map(|shape| Body::new(shape.core(), exponent, scale));
        let mut bodies = read(exponent);
        centre(&mut bodies);
        let mut bits = bodies.iter().map(Body::bits).max().unwrap_or(0);
        if bits < precision {
            exponent -= (precision - bits) as i32;
            bodies = read(exponent);
            centre(&mut bodies);
            bits = precision;
        }
        let reach = radii.iter().map(|&r| integer(r, exponent)).sum();
        let [a, b] = bodies;
        Self { a, b, reach, exponent, bits }
    }
}

fn normal(core: &Core) -> Vec<f64> {
    if let Core::HalfSpace { normal, .. } = core { normal.to_vec() } else { Vec::new() }
}

fn lengths(core: &Core) -> Vec<f64> {
    match core {
        Core::Point(p) => p.to_vec(),
        Core::Segment(ends) => ends.concat(),
        Core::Triangle(corners) => corners.concat(),
        Core::Cuboid { centre, half: [x, y, z] } => [*centre, *x, *y, *z].concat(),
        Core::Cylinder { centre, half_axis: axis, radius } | Core::Cone { base: centre, axis, radius } => {
            [*centre, *axis, [*radius, 0.0, 0.0]].concat()
        }
        Core::HalfSpace { .. } => Vec::new(),
    }
}

/// Translates both so that a bounded one, preferably the second, is near the origin.
fn centre(bodies: &mut [Body; 2]) {
    let middle = |body: &Body| match body {
        Body::Hull(hull) => Some(hull.corner.clone()),
        Body::Round(round) => Some(round.middle.clone()),
        Body::HalfSpace(_) => None,
    };
    let Some(by) = middle(&bodies[1]).or_else(|| middle(&bodies[0])) else { return };
    for body in bodies {
        match body {
            Body::Hull(hull) => {
                hull.corner = sub(&hull.corner, &by);
                for corner in &mut hull.corners {
                    *corner = sub(corner, &by);
                }
            }
            Body::Round(round) => round.middle = sub(&round.middle, &by),
            Body::HalfSpace(plane) => plane.offset -= dot(&plane.normal, &by),
        }
    }
}

impl Body {
    fn new(core: &Core, exponent: i32, scale: i32) -> Self {
        let vector = |p: &[f64; 3]| p.map(|x| integer(x, exponent));
        match core {
            Core::Point(p) => Self::Hull(Hull::new(vector(p), Vec::new(), false)),
            Core::Segment([p, q]) => {
                let (p, q) = (vector(p), vector(q));
                let edge = sub(&q, &p);
                Self::Hull(Hull::new(p, vec![edge], false))
            }
            Core::Triangle(corners) => {
                let [p, q, r] = corners.each_ref().map(vector);
                let edges = vec![sub(&q, &p), sub(&r, &p)];
                Self::Hull(Hull::new(p, edges, true))
            }
            Core::Cuboid { centre, half } => {
                let half = half.each_ref().map(vector);
                let corner = half.iter().fold(vector(centre), |corner, h| sub(&corner, h));
                Self::Hull(Hull::new(corner, half.iter().map(|h| add(h, h)).collect(), false))
            }
            Core::Cylinder { centre: middle, half_axis: axis, radius }
            | Core::Cone { base: middle, axis, radius } => Self::Round(Round {
                is_cone: matches!(core, Core::Cone { .. }),
                middle: vector(middle),
                axis: vector(axis),
                radius: integer(*radius, exponent),
            }),
            Core::HalfSpace { normal, offset } => Self::HalfSpace(Plane {
                normal: normal.map(|x| integer(x, scale)),
                offset: integer(*offset, exponent + scale),
            }),
        }
    }

    /// All coordinates of its points and its radius are below 2^bits.
    fn bits(&self) -> usize {
        match self {
            Self::Hull(hull) => hull.corners.iter().map(bits).max().unwrap_or(0),
            Self::Round(Round { middle, axis, radius, .. }) => {
                bits(middle).max(bits(axis)).max(radius.bit_len()) + 2
            }
            Self::HalfSpace(_) => 0,
        }
    }
}

impl Hull {
    fn new(corner: Vector, edges: Vec<Vector>, is_triangle: bool) -> Self {
        let mut corners = vec![corner.clone()];
        for edge in &edges {
            let more: Vec<Vector> = corners.iter().map(|p| add(p, edge)).collect();
            corners.extend(more);
        }
        if is_triangle {
            corners.truncate(3);
        }
        Self { corner, edges, is_triangle, corners }
    }

    /// The hull of one point.
    pub(crate) fn point(p: Vector) -> Self {
        Self::new(p, Vec::new(), false)
    }

    /// The index of the corner that is farthest in a direction.
    pub(crate) fn farthest(&self, direction: &Vector) -> usize {
        let heights: Vec<IBig> = self.corners.iter().map(|p| dot(direction, p)).collect();
        (1..heights.len()).fold(0, |best, i| if heights[i] > heights[best] { i } else { best })
    }
}
