//! Bodies of the hard cases, and poses that bring them into contact.

use super::draw::{Draw, NO_TURN, Turn, add, dot, minus, scaled};
use super::oracle::{Convex, Figure, Matrix, placed};
use super::trial::POSES;
use simdop::primitive::triangle::Triangle;
use simdop::range::Point;

/// A triangulated unit ball: an octahedron whose faces are split into four `levels` times. For `levels` of 0 and 1 it
/// is strictly convex: all other corners lie strictly on one side of the plane of each face.
fn ball(levels: u32) -> Vec<Triangle> {
    let mut faces: Vec<Triangle> = Vec::new();
    for (x, y, z) in [(1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (-1.0, 1.0, -1.0), (1.0, -1.0, -1.0)] {
        // Each face, and its reflection through the origin with reversed orientation.
        let face = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        let [p, q, r] = face.map(|p| p.map(|c: f64| if c == 0.0 { c } else { -c }));
        faces.extend([face, [q, p, r]]);
    }
    for _ in 0..levels {
        let halves = |[p, q, r]: Triangle| {
            let middle = |p: &Point, q: &Point| {
                let sum = add(p, q);
                scaled(&sum, 1.0 / dot(&sum, &sum).sqrt())
            };
            let (pq, qr, rp) = (middle(&p, &q), middle(&q, &r), middle(&r, &p));
            [[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]]
        };
        faces = faces.into_iter().flat_map(halves).collect();
    }
    faces
}

/// A closed body about the origin with hills, of radius about 1: its corners move along the lines to the origin.
pub(super) fn blob(draw: &mut Draw) -> Vec<Triangle> {
    let levels = draw.pick(&[0, 1, 1, 1, 2]);
    let waves: [(Point, f64); 3] =
        core::array::from_fn(|_| (scaled(&draw.direction(), 3.0), draw.range(-0.2, 0.2)));
    // Summed in one order, so that all copies of a corner get the same height.
    let height = |p: &Point| {
        waves.iter().fold(1.0, |sum, (way, size)| {
            let at = dot(way, p);
            sum + size * (1.0 - at * at * (1.0 / 4.5))
        })
    };
    ball(levels).into_iter().map(|t| t.map(|p| scaled(&p, height(&p)))).collect()
}

/// A closed convex body around the origin. No two faces are coplanar, or nearly so.
pub(super) fn polytope(draw: &mut Draw) -> Vec<Triangle> {
    let stretch: Point = core::array::from_fn(|_| draw.range(0.5, 1.5));
    let levels = draw.below(2) as u32;
    ball(levels).into_iter().map(|t| t.map(|p| core::array::from_fn(|i| p[i] * stretch[i]))).collect()
}

/// A box about the origin, given by its half widths, two triangles per face.
pub(super) fn block([x, y, z]: Point) -> Vec<Triangle> {
    let corner = |i: usize| {
        let side = |bit: usize, w: f64| if i >> bit & 1 == 0 { -w } else { w };
        [side(0, x), side(1, y), side(2, z)]
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.iter().flat_map(|[p, q, r, s]| [[*p, *q, *r], [*p, *r, *s]]).map(|t| t.map(corner)).collect()
}

/// A square in the plane z = 0 with a corner at the origin, in cells of this width.
pub(super) fn sheet(cells: i32, width: f64) -> Vec<Triangle> {
    let at = |i: i32, j: i32| [f64::from(i) * width, f64::from(j) * width, 0.0];
    let cell = |(i, j): (i32, i32)| {
        let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[p, q, r], [p, r, s]]
    };
    (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))).flat_map(cell).collect()
}

/// Triangles about 1 long and this wide that share a corner, the origin.
pub(super) fn fan(draw: &mut Draw, count: usize, width: f64) -> Vec<Triangle> {
    let needle = |_| {
        let (tip, across) = (draw.direction(), scaled(&draw.direction(), width));
        [[0.0; 3], tip, add(&tip, &across)]
    };
    (0..count).map(needle).collect()
}

/// The pose of a rotation and a translation.
pub(super) fn matrix(turn: &Turn, shift: &Point) -> Matrix {
    core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], shift[i]])
}

/// A point that is farthest along a direction.
fn farthest(points: impl Iterator<Item = Point>, direction: &Point) -> Point {
    points.max_by(|p, q| dot(p, direction).total_cmp(&dot(q, direction))).unwrap_or_default()
}

/// The points that determine a body's extent along a direction.
fn ends<'t>(figure: &'t Figure, direction: &Point) -> impl Iterator<Item = Point> + use<'t> {
    let direction = *direction;
    figure.items.iter().flat_map(move |item| match *item {
        Convex::Triangle(t) => t,
        Convex::Ball(ball) => [add(&ball.centre, &scaled(&direction, ball.radius)); 3],
    })
}

/// Places A beyond B along a unit direction, so that their ends touch up to rounding, or are this far apart.
pub(super) fn touching([a, b]: [&Figure; 2], turn: &Turn, direction: &Point, gap: f64) -> Matrix {
    let upright = matrix(turn, &[0.0; 3]);
    // The opposite direction, in A's frame.
    let back: Point = core::array::from_fn(|j| {
        -((turn[0][j] * direction[0] + turn[1][j] * direction[1]) + turn[2][j] * direction[2])
    });
    let end = placed(&upright, &farthest(ends(a, &back), &back));
    let to = farthest(ends(b, direction), direction);
    matrix(turn, &add(&minus(&to, &end), &scaled(direction, gap)))
}

/// Places a corner of A, or the end of a ball, on a point of B: a corner, or a point of an edge or a face.
pub(super) fn corner_on_point(draw: &mut Draw, [a, b]: [&Figure; 2], turn: &Turn, gap: f64) -> Matrix {
    let direction = draw.direction();
    let corner = match a.items[draw.below(a.items.len())] {
        Convex::Triangle(t) => t[draw.below(3)],
        Convex::Ball(ball) => add(&ball.centre, &scaled(&draw.direction(), ball.radius)),
    };
    let point = match b.items[draw.below(b.items.len())] {
        Convex::Triangle(t) => {
            // Eighths, so that corners and midpoints of edges are frequent.
            let i = draw.int(0, 8);
            let j = draw.int(0, 8 - i);
            let weights = [i, j, 8 - i - j].map(|w| f64::from(w) / 8.0);
            core::array::from_fn(|k| (t[0][k] * weights[0] + t[1][k] * weights[1]) + t[2][k] * weights[2])
        }
        Convex::Ball(ball) => add(&ball.centre, &scaled(&draw.direction(), ball.radius)),
    };
    let end = placed(&matrix(turn, &[0.0; 3]), &corner);
    matrix(turn, &add(&minus(&point, &end), &scaled(&direction, gap)))
}

/// A pose in or near contact: the bodies touch up to rounding, are slightly apart, or slightly overlap. `size` is
/// approximately the size of the smaller body.
pub(super) fn in_contact(draw: &mut Draw, [a, b]: [&Figure; 2], turn: &Turn, size: f64) -> Matrix {
    let gap = match draw.below(4) {
        0 => 0.0,
        1 => size * draw.signed(-52, -20),
        _ => size * draw.signed(-20, -2),
    };
    match draw.below(4) {
        0 => corner_on_point(draw, [a, b], turn, gap),
        _ => {
            let direction = if draw.is_heads() { draw.axis() } else { draw.direction() };
            touching([a, b], turn, &direction, gap)
        }
    }
}

/// Any rotation, or one that does not round.
pub(super) fn any_turn(draw: &mut Draw) -> Turn {
    match draw.below(8) {
        0 => NO_TURN,
        1 => draw.quarter_turns(),
        _ => draw.turn(),
    }
}

/// As many poses as a trial has.
pub(super) fn poses(draw: &mut Draw, mut pose: impl FnMut(&mut Draw) -> Matrix) -> Vec<Matrix> {
    (0..POSES).map(|_| pose(draw)).collect()
}

/// Scales the triangles of a body.
pub(super) fn resized(triangles: Vec<Triangle>, by: f64) -> Vec<Triangle> {
    triangles.into_iter().map(|t| t.map(|p| scaled(&p, by))).collect()
}
