//! How deeply two triangles cross: do they still cross after one has moved a little?
//!
//! Let an edge pq pass through a triangle at x, with p at height h above its plane, q at depth g below it, and x at
//! least m inside the triangle's edges. Let every point of the edge move by at most d, less than h and g. Then p and q
//! stay above and below. The fraction `h / (h + g)` of the edge at which it passes through the plane changes by at most
//! `d / (h + g - 2 d)`. So x moves by at most d plus this fraction of the edge's length. If that is less than m, the
//! edge still passes through the triangle.

use super::sides::Triangle;
use crate::range::Point;
use crate::vector::{cross, difference, dot, length};

/// Covers all roundings in this file, relative to the coordinates.
const ROUNDING: f64 = 1e-9;

/// Whether two triangles certainly cross, and still do after every point of one of them has moved by at most `moved`.
pub(crate) fn cross_after(a: &Triangle, b: &Triangle, moved: f64) -> bool {
    let edges = |t: &Triangle| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(a).iter().any(|edge| passes_after(edge, b, moved))
        || edges(b).iter().any(|edge| passes_after(edge, a, moved))
}

fn passes_after(&[p, q]: &[Point; 2], t: &Triangle, moved: f64) -> bool {
    let greatest = t.iter().chain([&p, &q]).flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let moved = moved + ROUNDING * greatest;
    let Some(normal) = unit(&cross(&difference(&t[1], &t[0]), &difference(&t[2], &t[0]))) else {
        return false;
    };
    let above = |p: &Point| dot(&normal, &difference(p, &t[0]));
    let (h, g) = (above(&p), -above(&q));
    let (h, g) = if h < 0.0 { (-h, -g) } else { (h, g) };
    if h.min(g).partial_cmp(&moved) != Some(core::cmp::Ordering::Greater) {
        return false;
    }
    let way = difference(&q, &p);
    let share = h / (h + g);
    let x = [0, 1, 2].map(|i| p[i] + share * way[i]);
    let shift = moved * (1.0 + length(&way) / (h + g - 2.0 * moved));
    (0..3).all(|i| {
        let (u, v) = (&t[i], &t[(i + 1) % 3]);
        unit(&cross(&normal, &difference(v, u)))
            .is_some_and(|inwards| dot(&inwards, &difference(&x, u)) > shift)
    })
}

fn unit(a: &Point) -> Option<Point> {
    let length = length(a);
    (length > 0.0).then(|| a.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::triangle::overlap;
    use crate::rng::Rng;

    #[test]
    fn what_crosses_deep_still_does_after_it_moved() {
        let mut rng = Rng::new(191);
        let point = |rng: &mut Rng, size: f64| -> Point { core::array::from_fn(|_| rng.range(-size, size)) };
        let (mut deep, mut shallow) = (0, 0);
        for _ in 0..4000 {
            let [a, b]: [Triangle; 2] =
                core::array::from_fn(|_| core::array::from_fn(|_| point(&mut rng, 1.0)));
            let moved = rng.range(0.0, 0.2);
            if !cross_after(&a, &b, moved) {
                shallow += usize::from(overlap(&a, &b, &mut 0));
                continue;
            }
            deep += 1;
            assert!(overlap(&a, &b, &mut 0));
            for _ in 0..20 {
                let after = a.map(|p| {
                    let way = point(&mut rng, 1.0);
                    let share = moved / length(&way);
                    [0, 1, 2].map(|i| p[i] + share * way[i])
                });
                assert!(overlap(&after, &b, &mut 0), "{a:?} {b:?} {moved}");
            }
        }
        assert!(deep > 100 && shallow > deep / 2, "{deep} {shallow}");
    }
}
