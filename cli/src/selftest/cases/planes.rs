//! Faces that are coplanar, or nearly so.

use crate::selftest::draw::{Draw, NO_TURN, Turn, add, power_of_two, product, scaled, turned};
use crate::selftest::figures::{block, matrix, poses, sheet, touching};
use crate::selftest::oracle::Figure;
use crate::selftest::trial::Trial;
use simdop::range::Point;

/// The common rotation of a trial's bodies: any, unless rounding the coordinates would destroy what the case tests.
fn common_turn(draw: &mut Draw) -> Turn {
    if draw.is_single || draw.is_heads() { draw.quarter_turns() } else { draw.turn() }
}

/// Sheets at angles and distances of 1e-9.
pub(super) fn near_parallel(draw: &mut Draw) -> Trial {
    let common = common_turn(draw);
    let cells = draw.int(1, 4);
    let flat = sheet(cells, 1.0 / f64::from(cells));
    let b = Figure::surface(draw.placed(&flat, &common, &[0.0; 3]));
    // A is a sheet whose corners are near the plane; the pose rotates it like B, and tilts it.
    let bumps = if draw.is_heads() { 0.0 } else { 1e-9 };
    let bumpy = flat.iter().map(|t| t.map(|[x, y, z]| [x, y, z + bumps * ((x * 5.0 + y * 3.0) % 1.0)]));
    let a = Figure::surface(draw.placed(&bumpy.collect::<Vec<_>>(), &NO_TURN, &[0.0; 3]));
    let poses = poses(draw, |draw| {
        let [p, q] = [draw.range(-1e-9, 1e-9), draw.range(-1e-9, 1e-9)];
        let tilt = [[1.0, 0.0, p], [0.0, 1.0, q], [-p, -q, 1.0]];
        let lift = match draw.below(4) {
            0 => 0.0,
            1 => draw.signed(-52, -40),
            _ => draw.range(-2e-9, 2e-9),
        };
        let shift = [draw.range(-0.7, 0.7), draw.range(-0.7, 0.7), lift];
        matrix(&product(&common, &tilt), &turned(&common, &shift))
    });
    Trial { a, b, poses }
}

/// Coplanar sheets whose cells lie on one lattice: corner on corner, edge along edge, side by side.
pub(super) fn coplanar_sheets(draw: &mut Draw) -> Trial {
    let common = common_turn(draw);
    let (cells_a, cells_b) = (draw.int(1, 4), draw.int(1, 4));
    let width = power_of_two(draw.int(-4, 4));
    let b = Figure::surface(draw.placed(&sheet(cells_b, width), &common, &[0.0; 3]));
    let a = Figure::surface(draw.placed(&sheet(cells_a, width), &NO_TURN, &[0.0; 3]));
    let poses = poses(draw, |draw| {
        let halves = |draw: &mut Draw| 0.5 * width * f64::from(draw.int(-2 * cells_a - 1, 2 * cells_b + 1));
        let mut shift = [halves(draw), halves(draw), 0.0];
        match draw.below(8) {
            0 => shift[2] = width * draw.signed(-52, -48),
            1 => shift = shift.map(|x| draw.nudged(x)),
            _ => {}
        }
        // Half of them are rotated within their plane, too.
        let turn = if draw.is_heads() { common } else { product(&common, &quarter_in_plane(draw)) };
        matrix(&turn, &turned(&common, &shift))
    });
    Trial { a, b, poses }
}

fn quarter_in_plane(draw: &mut Draw) -> Turn {
    let [c, s] = draw.pick(&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]);
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

/// Cosine and sine of 15, 45 and 90 degrees.
fn angles() -> [[f64; 2]; 3] {
    let (two, six) = (2.0_f64.sqrt(), 6.0_f64.sqrt());
    [[(six + two) / 4.0, (six - two) / 4.0], [two / 2.0, two / 2.0], [0.0, 1.0]]
}

/// Blocks, face on face, after rotations of 15, 45 and 90 degrees about axes, and with each number of the rotation
/// changed by one unit in the last place.
pub(super) fn turns(draw: &mut Draw) -> Trial {
    let any_block = |draw: &mut Draw| {
        let half: Point = core::array::from_fn(|_| f64::from(draw.int(1, 16)) / 8.0);
        let centre: Point = core::array::from_fn(|_| f64::from(draw.int(-8, 8)) / 8.0);
        let triangles = draw.placed(&block(half), &NO_TURN, &centre);
        // The inside of a surface is free.
        if draw.is_heads() { Figure::surface(triangles) } else { Figure::surface(triangles[..10].to_vec()) }
    };
    let (a, b) = (any_block(draw), any_block(draw));
    let poses = poses(draw, |draw| {
        let mut turn = NO_TURN;
        for _ in 0..draw.int(1, 2) {
            let [c, s] = draw.pick(&angles());
            let s = if draw.is_heads() { s } else { -s };
            let about = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
            // About another axis: permutes the coordinates before and after.
            let cycle: Turn = draw.pick(&[
                NO_TURN,
                [NO_TURN[1], NO_TURN[2], NO_TURN[0]],
                [NO_TURN[2], NO_TURN[0], NO_TURN[1]],
            ]);
            let back: Turn = core::array::from_fn(|j| cycle.map(|row| row[j]));
            turn = product(&product(&product(&cycle, &about), &back), &turn);
        }
        if draw.is_heads() {
            turn = turn.map(|row| row.map(|x| if x == 0.0 { x } else { draw.nudged(x) }));
        }
        let gap = if draw.is_heads() { 0.0 } else { draw.signed(-52, -2) };
        let mut rows = touching([&a, &b], &turn, &draw.axis(), gap);
        // Shifted along the face, too, so that edges and corners lie anywhere on it.
        let aside = scaled(&add(&draw.axis(), &draw.axis()), f64::from(draw.int(0, 4)) / 8.0);
        for (row, aside) in rows.iter_mut().zip(aside) {
            row[3] += aside;
        }
        rows
    });
    Trial { a, b, poses }
}
