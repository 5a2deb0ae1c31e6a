//! Balls that touch balls and faces, from outside and from inside.

use crate::selftest::draw::{Draw, NO_TURN, add, minus, power_of_two, scaled, turned};
use crate::selftest::figures::{any_turn, blob, block, in_contact, matrix, poses, touching};
use crate::selftest::oracle::{Convex, Figure, Matrix, placed};
use crate::selftest::trial::Trial;
use simdop::primitive::Sphere;
use simdop::range::Point;

/// Spheres scattered in a cube.
fn strewn(draw: &mut Draw) -> Figure {
    let count = draw.int(1, 24);
    let sphere = |_| Sphere { centre: draw_point(draw), radius: f64::from(draw.range(0.05, 0.4) as f32) };
    Figure::spheres((0..count).map(sphere).collect())
}

fn draw_point(draw: &mut Draw) -> Point {
    let p = core::array::from_fn(|_| draw.range(-1.0, 1.0));
    draw.rounded(p)
}

pub(super) fn benign(draw: &mut Draw) -> Trial {
    let (a, b) = (strewn(draw), strewn(draw));
    let poses = poses(draw, |draw| clear(draw, [&a, &b]));
    Trial { a, b, poses }
}

pub(super) fn benign_on_triangles(draw: &mut Draw) -> Trial {
    let triangles = blob(draw);
    let (a, b) = (strewn(draw), Figure::surface(draw.placed(&triangles, &NO_TURN, &[0.0; 3])));
    let poses = poses(draw, |draw| clear(draw, [&a, &b]));
    Trial { a, b, poses }
}

/// A pose at which the bodies are clearly separate, or clearly overlap.
fn clear(draw: &mut Draw, bodies: [&Figure; 2]) -> Matrix {
    let (turn, direction) = (draw.turn(), draw.direction());
    touching(bodies, &turn, &direction, draw.signed(-6, -2))
}

/// An integer vector of integer length.
#[derive(Copy, Clone)]
struct WholeWay {
    way: [i32; 3],
    length: i32,
}

const fn whole(x: i32, y: i32, z: i32, length: i32) -> WholeWay {
    WholeWay { way: [x, y, z], length }
}

const WAYS: [WholeWay; 8] = [
    whole(1, 0, 0, 1),
    whole(3, 4, 0, 5),
    whole(1, 2, 2, 3),
    whole(2, 3, 6, 7),
    whole(1, 4, 8, 9),
    whole(4, 4, 7, 9),
    whole(2, 6, 9, 11),
    whole(6, 6, 7, 11),
];

const UNIT: f64 = power_of_two(-4);

/// Spheres on a lattice whose radii are multiples of a vector's length. Along the vector, with any order and signs of
/// its coordinates, they touch exactly, unless a pose rounds.
fn on_lattice(draw: &mut Draw, way: WholeWay, count: i32, most: i32) -> Figure {
    let sphere = |_| Sphere {
        centre: core::array::from_fn(|_| UNIT * f64::from(draw.int(-16, 16))),
        radius: UNIT * f64::from(way.length * draw.int(0, most)),
    };
    Figure::spheres((0..count).map(sphere).collect())
}

fn ball_of(draw: &mut Draw, figure: &Figure) -> Sphere {
    match figure.items[draw.below(figure.items.len())] {
        Convex::Ball(ball) => ball,
        Convex::Triangle([centre, ..]) => Sphere { centre, radius: 0.0 },
    }
}

/// Places a sphere of A at a distance from one of B that `distance` computes from their radii: at the sum of the radii
/// they touch.
fn tangent_pose(
    draw: &mut Draw,
    bodies @ [a, b]: [&Figure; 2],
    WholeWay { way, length }: WholeWay,
    distance: impl Fn(f64, f64) -> f64,
) -> Matrix {
    let turn = if draw.below(4) == 0 { draw.turn() } else { draw.quarter_turns() };
    let gap = if draw.is_heads() { 0.0 } else { draw.signed(-52, -4) };
    // Beside all of B, so that no other spheres meet.
    if draw.is_heads() {
        let direction = if draw.is_heads() { draw.axis() } else { draw.direction() };
        return touching(bodies, &turn, &direction, gap);
    }
    let (p, q) = (ball_of(draw, a), ball_of(draw, b));
    let signed = way.map(|x| f64::from(if draw.is_heads() { x } else { -x }) / f64::from(length));
    let along = turned(&draw.quarter_turns(), &way.map(f64::from));
    let (apart, length) = (distance(p.radius, q.radius), f64::from(length));
    // Multiply first, since the product is a multiple of the length.
    let apart = along.map(|x| x * apart / length);
    let from = placed(&matrix(&turn, &[0.0; 3]), &p.centre);
    let shift = add(&add(&minus(&q.centre, &from), &apart), &scaled(&signed, gap));
    matrix(&turn, &shift)
}

/// Spheres that touch from outside.
pub(super) fn tangent(draw: &mut Draw) -> Trial {
    let way = draw.pick(&WAYS);
    let counts = [draw.int(1, 3), draw.int(1, 3)];
    let [a, b] = counts.map(|count| on_lattice(draw, way, count, 2));
    let poses = poses(draw, |draw| tangent_pose(draw, [&a, &b], way, |r, s| r + s));
    Trial { a, b, poses }
}

/// Spheres inside each other, touching from inside or not, and similar ones outside.
pub(super) fn nested(draw: &mut Draw) -> Trial {
    let way = draw.pick(&WAYS);
    let counts = [draw.int(1, 2), draw.int(1, 2)];
    let [a, b] = [(counts[0], 1), (counts[1], 4)].map(|(count, most)| on_lattice(draw, way, count, most));
    let poses = poses(draw, |draw| match draw.below(4) {
        0 => tangent_pose(draw, [&a, &b], way, |r, s| (r - s).abs()),
        1 => tangent_pose(draw, [&a, &b], way, |_, s| s),
        _ => tangent_pose(draw, [&a, &b], way, |r, s| r + s),
    });
    Trial { a, b, poses }
}

/// Spheres that touch the faces, edges and corners of blocks.
pub(super) fn on_faces(draw: &mut Draw) -> Trial {
    let half: Point = core::array::from_fn(|_| f64::from(draw.int(1, 16)) / 16.0);
    let b = Figure::surface(draw.placed(&block(half), &NO_TURN, &[0.0; 3]));
    let (way, count) = (draw.pick(&WAYS), draw.int(1, 4));
    let a = on_lattice(draw, way, count, 1);
    let poses = poses(draw, |draw| {
        let turn = any_turn(draw);
        match draw.below(4) {
            0 => in_contact(draw, [&a, &b], &turn, 0.5),
            1 => tangent_pose(draw, [&a, &b], way, |r, _| r),
            _ => {
                let gap = if draw.is_heads() { 0.0 } else { draw.signed(-54, -40) };
                touching([&a, &b], &draw.quarter_turns(), &draw.axis(), gap)
            }
        }
    });
    Trial { a, b, poses }
}
