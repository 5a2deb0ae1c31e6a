//! Polytopes: points, segments, triangles and parallelepipeds, by their corners, edges and faces.
//!
//! They may be degenerate. A triangle on a line is the union of its edges. A parallelepiped without volume is the union
//! of its faces, since any point of it is the image of a point on the surface of a cube; likewise a parallelogram
//! without area is the union of its edges.

use super::integers::{Degree1, Degree2, Degree3, cross, difference, dot};
use crate::exact::wide::Wide;
use crate::primitive::shape::Core;

#[derive(Debug)]
pub(super) struct ExactPolytope {
    corners: [[Degree1; 3]; 8],
    features: &'static Features,
}

#[derive(Debug)]
struct Features {
    corners: usize,
    /// Corners of the edges. Every edge is parallel to one of the first `directions` edges.
    edges: &'static [[usize; 2]],
    directions: usize,
    /// Corners of the faces, in order around them.
    faces: &'static [&'static [usize]],
}

const NONE: Features = Features { corners: 0, edges: &[], directions: 0, faces: &[] };
const POINT: Features = Features { corners: 1, edges: &[], directions: 0, faces: &[] };
const SEGMENT: Features = Features { corners: 2, edges: &[[0, 1]], directions: 1, faces: &[] };
const TRIANGLE: Features =
    Features { corners: 3, edges: &[[0, 1], [1, 2], [2, 0]], directions: 3, faces: &[&[0, 1, 2]] };
/// Bit k of the number of a corner is the sign of half edge k.
const CUBOID: Features = Features {
    corners: 8,
    edges: &[[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]],
    directions: 3,
    faces: &[&[0, 1, 3, 2], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 3, 7, 6], &[0, 2, 6, 4], &[1, 3, 7, 5]],
};

/// The plane of a face. The normal is zero if the face has no area.
#[derive(Debug)]
pub(super) struct ExactFace<'a> {
    polytope: &'a ExactPolytope,
    corners: &'static [usize],
    pub(super) normal: [Degree2; 3],
}

impl ExactPolytope {
    /// Has no corners if the core is not a polytope.
    #[inline(never)]
    pub(super) fn new(core: &Core, unit: i32) -> Self {
        let number = |x: f64| Degree1::new(x, unit);
        let mut corners = [[Degree1::ZERO; 3]; 8];
        let mut set = |points: &[[f64; 3]]| {
            for (corner, point) in corners.iter_mut().zip(points) {
                *corner = point.map(number);
            }
        };
        let features = match core {
            Core::Point(p) => {
                set(&[*p]);
                &POINT
            }
            Core::Segment(ends) => {
                set(ends);
                &SEGMENT
            }
            Core::Triangle(triangle) => {
                set(triangle);
                &TRIANGLE
            }
            Core::Cuboid { centre, half } => {
                for (i, corner) in corners.iter_mut().enumerate() {
                    for k in 0..3 {
                        corner[k] = (0..3).fold(number(centre[k]), |sum, j| {
                            let half = number(half[j][k]);
                            if i >> j & 1 == 1 { sum.plus(&half) } else { sum.minus(&half) }
                        });
                    }
                }
                &CUBOID
            }
            Core::Cylinder { .. } | Core::Cone { .. } | Core::HalfSpace { .. } => &NONE,
        };
        Self { corners, features }
    }

    pub(super) fn of_point(point: [Degree1; 3]) -> Self {
        let mut corners = [[Degree1::ZERO; 3]; 8];
        corners[0] = point;
        Self { corners, features: &POINT }
    }

    pub(super) fn corners(&self) -> &[[Degree1; 3]] {
        &self.corners[..self.features.corners]
    }

    /// One end of each edge, and the vector to the other end.
    pub(super) fn edges(&self) -> impl Iterator<Item = (&[Degree1; 3], [Degree1; 3])> {
        let edge = |[i, j]: &[usize; 2]| {
            let from = &self.corners[*i];
            (from, difference(&self.corners[*j], from))
        };
        self.features.edges.iter().map(edge)
    }

    /// Vectors parallel to the edges: each edge is parallel to one of them.
    pub(super) fn directions(&self) -> impl Iterator<Item = [Degree1; 3]> {
        self.edges().take(self.features.directions).map(|(_, vector)| vector)
    }

    pub(super) fn faces(&self) -> impl Iterator<Item = ExactFace<'_>> {
        self.features.faces.iter().map(|corners| {
            let [p, q, r] = [0, 1, 2].map(|i| &self.corners[corners[i]]);
            ExactFace { polytope: self, corners, normal: cross(&difference(q, p), &difference(r, p)) }
        })
    }
}

impl ExactFace<'_> {
    pub(super) fn corner(&self) -> &[Degree1; 3] {
        &self.polytope.corners[self.corners[0]]
    }

    /// Whether the point `x / weight` is in the prism of the face along its normal, which must not be zero. `R` must
    /// have room for three degrees more than `L` has.
    #[inline(never)]
    pub(super) fn is_over<const L: usize, const W: usize, const R: usize>(
        &self,
        x: &[Wide<L>; 3],
        weight: &Wide<W>,
    ) -> bool {
        let n = self.corners.len();
        (0..n).all(|i| {
            let [p, q] = [i, (i + 1) % n].map(|i| &self.polytope.corners[self.corners[i]]);
            let inward: [Degree3; 3] = cross(&self.normal, &difference(q, p));
            let from_edge = [0, 1, 2].map(|k| x[k].minus(&weight.times(&p[k])));
            let side: Wide<R> = dot(&from_edge, &inward);
            side.sign() * weight.sign() >= 0
        })
    }
}
