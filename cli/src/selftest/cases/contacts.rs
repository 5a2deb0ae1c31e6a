//! Bodies of similar size in contact: ordinary ones, nested ones, needles, and at the pose where the answer flips.

use crate::selftest::draw::{Draw, NO_TURN, power_of_two, scaled};
use crate::selftest::figures::{
    any_turn, blob, corner_on_point, fan, in_contact, matrix, polytope, poses, resized, touching,
};
use crate::selftest::oracle::{Figure, Matrix, Oracle};
use crate::selftest::trial::{POSES, Trial};
use simdop::primitive::triangle::Triangle;

/// The surface of these triangles, about the origin.
fn surface(draw: &Draw, triangles: &[Triangle]) -> Figure {
    Figure::surface(draw.placed(triangles, &NO_TURN, &[0.0; 3]))
}

/// Blobs that are clearly separate or clearly overlap.
pub(super) fn benign(draw: &mut Draw) -> Trial {
    let [a, b] = [blob(draw), blob(draw)].map(|triangles| surface(draw, &triangles));
    let poses = poses(draw, |draw| {
        let (turn, direction) = (draw.turn(), draw.direction());
        touching([&a, &b], &turn, &direction, draw.signed(-6, -2))
    });
    Trial { a, b, poses }
}

/// A body and a concentric copy of it, slightly smaller, slightly larger, or of the same size; solid or not.
pub(super) fn nested_copies(draw: &mut Draw) -> Trial {
    let is_solid = draw.is_heads();
    let body = if is_solid { polytope(draw) } else { blob(draw) };
    let by = 1.0 + draw.pick(&[0.0, draw_part(-3), draw_part(-10), draw_part(-30), -0.5, 0.5]);
    let figure = |triangles: &[Triangle]| {
        let triangles = draw.placed(triangles, &NO_TURN, &[0.0; 3]);
        if is_solid { Figure::solid(triangles) } else { Figure::surface(triangles) }
    };
    let (a, b) = (figure(&resized(body.clone(), by)), figure(&body));
    let poses = poses(draw, |draw| {
        let turn = if draw.is_heads() { NO_TURN } else { any_turn(draw) };
        let shift = match draw.below(4) {
            0 => [0.0; 3],
            1 => scaled(&draw.direction(), draw.signed(-52, -20)),
            2 => scaled(&draw.direction(), draw.signed(-20, -3)),
            // Side by side.
            _ => return in_contact(draw, [&a, &b], &turn, 1.0),
        };
        matrix(&turn, &shift)
    });
    Trial { a, b, poses }
}

/// 1 minus a power of two.
fn draw_part(exponent: i32) -> f64 {
    -power_of_two(exponent)
}

/// Triangles a million times as long as wide that share a corner.
pub(super) fn needle_fans(draw: &mut Draw) -> Trial {
    let any_fan = |draw: &mut Draw| {
        let (count, width) = (draw.int(2, 12) as usize, draw.size(-24, -16));
        let triangles = fan(draw, count, width);
        surface(draw, &triangles)
    };
    let (a, b) = (any_fan(draw), any_fan(draw));
    let poses = poses(draw, |draw| {
        let turn = any_turn(draw);
        match draw.below(3) {
            0 => in_contact(draw, [&a, &b], &turn, 1.0),
            // Intersecting, by less than their width.
            1 => corner_on_point(draw, [&a, &b], &turn, 0.0),
            _ => {
                let gap = draw.signed(-52, -16);
                corner_on_point(draw, [&a, &b], &turn, gap)
            }
        }
    });
    Trial { a, b, poses }
}

/// A hundred thousand copies of one triangle, and a few others.
pub(super) fn coincident(draw: &mut Draw) -> Trial {
    let one = fan(draw, 1, 1.0);
    let others = fan(draw, 4, 0.5);
    let (one, b) = (surface(draw, &one), surface(draw, &others));
    let a = Figure { copies: 100_000, ..one };
    // Only four poses, since they are slow: then several formats are covered.
    let poses = (0..4).map(|_| {
        let turn = any_turn(draw);
        in_contact(draw, [&a, &b], &turn, 1.0)
    });
    Trial { poses: poses.collect(), a, b }
}

/// The last pose along an axis where two bodies meet, the first where they do not, and neighbouring ones.
pub(super) fn knife_edge(draw: &mut Draw) -> Trial {
    let [a, b] = [polytope(draw), polytope(draw)].map(|triangles| surface(draw, &triangles));
    let oracle = Oracle::new(&a, &b);
    let mut poses = Vec::with_capacity(POSES);
    while poses.len() < POSES {
        let (turn, axis) = (any_turn(draw), draw.below(3));
        let direction = core::array::from_fn(|i| if i == axis { 1.0 } else { 0.0 });
        let mut apart = touching([&a, &b], &turn, &direction, 0.5);
        // Anywhere above B within its extent, so that A does not pass it.
        for row in &mut apart {
            row[3] += draw.range(-0.3, 0.3);
        }
        let mut within = apart;
        within[axis][3] -= 1.5;
        if oracle.meets(&apart) || !oracle.meets(&within) {
            continue;
        }
        halve(&oracle, axis, &mut within, &mut apart);
        for flip in [within, apart] {
            poses.push(flip);
            for _ in 0..3 {
                let mut beside = flip;
                for row in &mut beside {
                    row[3] = draw.nudged(row[3]);
                }
                poses.push(beside);
            }
        }
    }
    poses.truncate(POSES);
    Trial { a, b, poses }
}

/// Bisects the interval between two poses until there is no number in between.
fn halve(oracle: &Oracle<'_>, axis: usize, within: &mut Matrix, apart: &mut Matrix) {
    loop {
        let (low, high) = (within[axis][3], apart[axis][3]);
        let between = low + (high - low) * 0.5;
        if between <= low || between >= high {
            return;
        }
        let mut pose = *within;
        pose[axis][3] = between;
        if oracle.meets(&pose) {
            *within = pose;
        } else {
            *apart = pose;
        }
    }
}
