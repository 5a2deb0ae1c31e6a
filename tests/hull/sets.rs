//! Random sets of points, most of them degenerate.

use crate::Point;
use crate::rng::Rng;

pub(crate) const KINDS: u32 = 11;

fn float(p: [i64; 3]) -> Point {
    p.map(|x| x as f64)
}

fn lattice(rng: &mut Rng, most: i64) -> Point {
    float([(); 3].map(|()| rng.int(-most, most)))
}

/// Points `origin + i u + j v` for small integers i and j.
fn in_plane(rng: &mut Rng, count: u64, is_line: bool) -> Vec<Point> {
    let [origin, u, v] = [(); 3].map(|()| lattice(rng, 5));
    let mut one = || {
        let (i, j) = (rng.int(-3, 3) as f64, if is_line { 0.0 } else { rng.int(-3, 3) as f64 });
        [0, 1, 2].map(|k| origin[k] + i * u[k] + j * v[k])
    };
    (0..count).map(|_| one()).collect()
}

/// 1 to 14 points.
pub(crate) fn random_set(kind: u32, rng: &mut Rng) -> Vec<Point> {
    let count = 1 + rng.below(14);
    let power = |rng: &mut Rng, least, most| 2.0_f64.powi(rng.int(least, most) as i32);
    match kind {
        0 => (0..count).map(|_| lattice(rng, 2)).collect(),
        1 => (0..count).map(|_| lattice(rng, 1)).collect(),
        // In a plane, with a few points off it.
        2 => {
            let mut points = in_plane(rng, count, false);
            points.extend((0..rng.below(3)).map(|_| lattice(rng, 5)));
            points
        }
        3 => in_plane(rng, count, true),
        4 => (0..count).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0))).collect(),
        // On a sphere, up to rounding.
        5 => {
            let mut one = || {
                let p: Point = rng.rotation()[0];
                p.map(|x| 3.0 * x)
            };
            (0..count).map(|_| one()).collect()
        }
        // Far from the origin: steps of one unit in the last place.
        6 => {
            let step = 2.0_f64.powi(-33);
            (0..count).map(|_| lattice(rng, 2).map(|x| 1e6 + x * step)).collect()
        }
        // Thin.
        7 => {
            let thickness = power(rng, -240, -30);
            let thin = |[x, y, z]: Point| [x, y, z * thickness];
            (0..count).map(|_| thin(lattice(rng, 3))).collect()
        }
        // Scaled along each axis.
        8 => {
            let scale = [(); 3].map(|()| power(rng, -240, 280));
            let scaled = |p: Point| [0, 1, 2].map(|k| p[k] * scale[k]);
            (0..count).map(|_| scaled(lattice(rng, 2))).collect()
        }
        // Almost in a plane: off it by one unit in the last place.
        9 => {
            let mut points = in_plane(rng, count, false);
            for p in &mut points {
                if rng.below(3) == 0 {
                    let k = rng.below(3) as usize;
                    p[k] = if p[k] == 0.0 { 2.0_f64.powi(-250) } else { p[k].next_up() };
                }
            }
            points
        }
        // Of any size.
        _ => (0..count).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0) * power(rng, -240, 299))).collect(),
    }
}
