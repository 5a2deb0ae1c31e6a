//! The depth of two convex sets: a polytope inside A - B grows towards the boundary at its nearest face (van den
//! Bergen 2001, "Proximity queries and penetration depth computation on 3D game objects").
//!
//! **The lower bound.** Let d be the least distance of the faces from the origin. The faces form a closed surface
//! around the origin: at first a tetrahedron or octahedron, all of whose faces are counterclockwise as seen from
//! outside, so that their solid angles add up. Each step then adds the boundaries of tetrahedra, each spanned by a
//! face and the new corner. They lie in the half-space `n . x > 0` of the face's normal n, so the surface still winds
//! around the origin. So it winds around the ball of radius d, and the convex hull of the corners, which is inside A -
//! B, contains that ball. Nothing depends on the surface being convex, nor on normals being accurate: the distance of
//! a face is at least the least product of its corners with any unit vector.

use super::support::{Operands, each};
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

/// The difference A - B of two convex sets.
pub(super) trait ConvexDifference {
    /// The point of A - B that is farthest along -d.
    fn support(&self, d: &Point) -> Point;

    /// Bounds the error of such a point's dot product with d, from computing and from choosing the point, relative to
    /// the length of d.
    fn slack(&self) -> f64;
}

impl ConvexDifference for Operands {
    #[inline(always)]
    fn support(&self, d: &Point) -> Point {
        self.support(d).0
    }

    #[inline(always)]
    fn slack(&self) -> f64 {
        self.slack
    }
}

#[derive(Copy, Clone)]
struct GrownFace {
    corners: [u8; 3],
    /// Of unit length, up to rounding.
    normal: Point,
    /// The least and the greatest product of a corner with the normal.
    low: f64,
    high: f64,
}

/// At most 256 corners.
struct GrownPolytope<const CORNERS: usize, const FACES: usize> {
    corners: [Point; CORNERS],
    faces: [GrownFace; FACES],
    corner_count: usize,
    face_count: usize,
}

/// A lower bound of the depth, an upper one, and the direction in which it separates A from B. Starts from the support
/// points along the axes, or from the corners of a tetrahedron in A - B that contains the origin; `None` if neither
/// does.
#[cold]
#[inline(never)]
pub(super) fn depth<const CORNERS: usize, const FACES: usize>(
    pair: &impl ConvexDifference,
    corners: Option<[Point; 4]>,
    tolerance: f64,
) -> Option<(f64, f64, Point)> {
    let mut octahedron = [[0.0; 3]; 6];
    for (i, corner) in octahedron.iter_mut().enumerate() {
        let mut d = [0.0; 3];
        d[i / 2] = if i % 2 == 0 { -1.0 } else { 1.0 };
        *corner = pair.support(&d);
    }
    let mut polytope = GrownPolytope::<CORNERS, FACES>::octahedron(&octahedron);
    if polytope.nearest().low <= pair.slack() {
        polytope = GrownPolytope::tetrahedron(&corners?);
    }
    Some(polytope.depth(pair, tolerance))
}

/// As [`depth`], from the corners of an octahedron in A - B. Opposite corners follow each other, and the first, third
/// and fifth are a right-handed frame. `None` if it does not contain the origin.
#[cold]
#[inline(never)]
pub(super) fn depth_of_octahedron<const CORNERS: usize, const FACES: usize>(
    pair: &impl ConvexDifference,
    corners: &[Point; 6],
    tolerance: f64,
) -> Option<(f64, f64, Point)> {
    let polytope = GrownPolytope::<CORNERS, FACES>::octahedron(corners);
    (polytope.nearest().low > pair.slack()).then(|| polytope.depth(pair, tolerance))
}

/// As [`depth`], from a tetrahedron only. It is convex and stays convex while it grows; the octahedron of a difference
/// with few corners need not be.
#[cold]
#[inline(never)]
pub(super) fn depth_around<const CORNERS: usize, const FACES: usize>(
    pair: &impl ConvexDifference,
    corners: &[Point; 4],
    tolerance: f64,
) -> (f64, f64, Point) {
    GrownPolytope::<CORNERS, FACES>::tetrahedron(corners).depth(pair, tolerance)
}

impl<const CORNERS: usize, const FACES: usize> GrownPolytope<CORNERS, FACES> {
    fn empty(corner_count: usize) -> Self {
        let none = GrownFace { corners: [0; 3], normal: [0.0; 3], low: 0.0, high: 0.0 };
        Self { corners: [[0.0; 3]; CORNERS], faces: [none; FACES], corner_count, face_count: 0 }
    }

    fn octahedron(corners: &[Point; 6]) -> Self {
        let mut polytope = Self::empty(6);
        polytope.corners[..6].copy_from_slice(corners);
        for corners in
            [[0, 2, 4], [0, 5, 2], [0, 3, 5], [0, 4, 3], [1, 4, 2], [1, 2, 5], [1, 5, 3], [1, 3, 4]]
        {
            polytope.add_face(corners);
        }
        polytope
    }

    fn tetrahedron(corners: &[Point; 4]) -> Self {
        let mut polytope = Self::empty(4);
        polytope.corners[..4].copy_from_slice(corners);
        // About the origin.
        let volume = dot(&corners[1], &cross(&corners[2], &corners[3]));
        for [i, j, k] in [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]] {
            polytope.add_face(if volume > 0.0 { [i, j, k] } else { [i, k, j] });
        }
        polytope
    }

    fn depth(mut self, pair: &impl ConvexDifference, tolerance: f64) -> (f64, f64, Point) {
        let slack = pair.slack();
        let (mut lower, mut upper, mut along) = (0.0_f64, f64::INFINITY, [0.0; 3]);
        loop {
            let nearest = self.nearest();
            // Otherwise all products of corners and normals are certainly positive.
            if nearest.low <= slack {
                break;
            }
            lower = lower.max(nearest.low);
            let d = each(|k| -nearest.normal[k]);
            let corner = pair.support(&d);
            let height = -dot(&d, &corner);
            if height < upper {
                (upper, along) = (height, d);
            }
            if upper - lower <= (tolerance * upper).max(slack) || !self.grow(corner, slack) {
                break;
            }
        }
        (lower - slack, upper + slack, along)
    }

    fn nearest(&self) -> GrownFace {
        let mut best = self.faces[0];
        for face in &self.faces[1..self.face_count] {
            if face.low < best.low {
                best = *face;
            }
        }
        best
    }

    fn add_face(&mut self, corners: [u8; 3]) {
        let [p, q, r] = corners.map(|i| self.corners[usize::from(i)]);
        let normal = cross(&difference(&q, &p), &difference(&r, &p));
        let length = sqrt(dot(&normal, &normal));
        let products = [dot(&normal, &p), dot(&normal, &q), dot(&normal, &r)];
        let (low, high) =
            (products[0].min(products[1]).min(products[2]), products[0].max(products[1]).max(products[2]));
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        let normal = each(|k| inverse * normal[k]);
        self.faces[self.face_count] = GrownFace { corners, normal, low: inverse * low, high: inverse * high };
        self.face_count += 1;
    }

    /// Replaces the faces below a new corner. Returns false if there are none, or if there is no room.
    fn grow(&mut self, corner: Point, slack: f64) -> bool {
        if self.corner_count == CORNERS {
            return false;
        }
        let mut edges = [[0_u8; 2]; FACES];
        let (mut count, mut kept) = (0, 0);
        for i in 0..self.face_count {
            let face = self.faces[i];
            // A corner in the plane of a face, as in the base of a cylinder, leaves the face unchanged.
            if dot(&face.normal, &corner) > face.high + 0.25 * slack {
                for k in 0..3 {
                    let edge = [face.corners[k], face.corners[(k + 1) % 3]];
                    // An edge between two of these faces is listed in both directions.
                    if let Some(at) = edges[..count].iter().position(|e| *e == [edge[1], edge[0]]) {
                        count -= 1;
                        edges[at] = edges[count];
                    } else if count < FACES {
                        edges[count] = edge;
                        count += 1;
                    } else {
                        return false;
                    }
                }
            } else {
                self.faces[kept] = face;
                kept += 1;
            }
        }
        if kept == self.face_count || kept + count > FACES {
            return false;
        }
        self.face_count = kept;
        self.corners[self.corner_count] = corner;
        for [i, j] in &edges[..count] {
            self.add_face([*i, *j, self.corner_count as u8]);
        }
        self.corner_count += 1;
        true
    }
}
