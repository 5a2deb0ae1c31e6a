//! Points and their search radii.

use super::entrants::Radii;
use crate::rng::Rng;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use std::path::Path;

pub(crate) type Points = Vec<[f32; 3]>;

/// Neighbours of a point in the project's target.
pub(crate) const USUAL: f64 = 30.0;

/// Uniform points in the unit cube.
pub(crate) fn uniform(count: usize, rng: &mut Rng) -> Points {
    (0..count).map(|_| core::array::from_fn(|_| rng.unit() as f32)).collect()
}

/// The radius in which a uniform point away from the cube's faces finds this many neighbours on average, itself
/// excluded.
pub(crate) fn radius(count: usize, neighbours: f64) -> f32 {
    (neighbours / count as f64 * 0.75 / std::f64::consts::PI).cbrt() as f32
}

/// An approximately normal number: the sum of twelve uniform ones.
fn normal(rng: &mut Rng) -> f64 {
    (0..12).map(|_| rng.unit()).sum::<f64>() - 6.0
}

/// 64 clusters of different widths in the unit cube.
pub(crate) fn clustered(count: usize, rng: &mut Rng) -> Points {
    let clusters: Vec<([f64; 3], f64)> =
        (0..64).map(|_| (core::array::from_fn(|_| rng.unit()), 0.002 * 10_f64.powf(rng.unit()))).collect();
    let point = |_| {
        let (centre, width) = *rng.pick(&clusters);
        centre.map(|x| normal(rng).mul_add(width, x) as f32)
    };
    (0..count).map(point).collect()
}

/// On a flat sheet that is parallel to no axis, or to two of them.
pub(crate) fn sheet(count: usize, tilted: bool, rng: &mut Rng) -> Points {
    let point = |_| {
        let [u, v] = [rng.unit(), rng.unit()];
        if tilted { [u, v, 0.4 * u + 0.3 * v].map(|x| x as f32) } else { [u as f32, v as f32, 0.25] }
    };
    (0..count).map(point).collect()
}

/// On a straight line along no axis.
pub(crate) fn line(count: usize, rng: &mut Rng) -> Points {
    (0..count).map(|_| rng.unit()).map(|u| [u as f32, (0.5 * u) as f32, (0.25 * u) as f32]).collect()
}

/// Sorted along a Morton curve: points that are near each other in space are near each other in memory.
pub(crate) fn morton(mut points: Points) -> Points {
    let spread =
        |x: f32| (0..10).fold(0_u32, |key, bit| key | (((x * 1023.0) as u32) >> bit & 1) << (3 * bit));
    points.sort_by_cached_key(|&[x, y, z]| spread(x) | spread(y) << 1 | spread(z) << 2);
    points
}

/// Particles of two densities: nine tenths are in a cube of this share of the scene's size, the others anywhere. The
/// radius of each gives [`USUAL`] neighbours among particles of its own density.
pub(crate) fn particles(count: usize, share: f64, rng: &mut Rng) -> (Points, Radii) {
    let dense = count * 9 / 10;
    let near = share as f32 * radius(dense, USUAL);
    let far = radius(count - dense, USUAL);
    let mut all: Vec<([f32; 3], f32)> = uniform(dense, rng)
        .into_iter()
        .map(|point| (point.map(|x| 0.3 + share as f32 * x), near))
        .chain(uniform(count - dense, rng).into_iter().map(|point| (point, far)))
        .collect();
    shuffle(&mut all, rng);
    let (points, radii) = all.into_iter().unzip();
    (points, Radii::Each(radii))
}

/// Particles around a few centres, ever denser: the distance from a centre is 10 to a power between -4 and 0. The
/// radius of each gives [`USUAL`] neighbours if the density were uniform around it.
pub(crate) fn halos(count: usize, rng: &mut Rng) -> (Points, Radii) {
    let (centres, decades) = (uniform(8, rng), 4.0);
    let (mut points, mut radii) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let centre = *rng.pick(&centres);
        let direction = rng.rotation()[0];
        let distance = 10_f64.powf(-decades * rng.unit());
        points
            .push(core::array::from_fn(|axis| (f64::from(centre[axis]) + distance * direction[axis]) as f32));
        // Particles of a centre between distances a and b: their share is log10(b / a) / decades.
        let density = count as f64
            / centres.len() as f64
            / (decades * std::f64::consts::LN_10 * 4.0 * std::f64::consts::PI * distance.powi(3));
        radii.push((USUAL / density * 0.75 / std::f64::consts::PI).cbrt().min(distance) as f32);
    }
    (points, Radii::Each(radii))
}

fn shuffle<T>(items: &mut [T], rng: &mut Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.below(i as u64 + 1) as usize);
    }
}

/// A PLY file's vertices, shifted to the first one if they are far from the origin: `f32` would round them to
/// centimetres.
pub(crate) fn ply(path: &Path) -> Result<Points, String> {
    let say = |problem: &dyn std::fmt::Display| format!("{}: {problem}", path.display());
    let file = std::fs::File::open(path).map_err(|e| say(&e))?;
    let ply =
        Parser::<DefaultElement>::new().read_ply(&mut std::io::BufReader::new(file)).map_err(|e| say(&e))?;
    let axis = |element: &DefaultElement, axis: &str| match element[axis] {
        Property::Float(x) => Ok(f64::from(x)),
        Property::Double(x) => Ok(x),
        ref other => Err(say(&format!("{axis} is {other:?}"))),
    };
    let read = |element| Ok([axis(element, "x")?, axis(element, "y")?, axis(element, "z")?]);
    let points: Vec<[f64; 3]> = ply.payload["vertex"].iter().map(read).collect::<Result<_, String>>()?;
    let far = points.iter().flatten().any(|x| x.abs() > 1e4);
    let origin = if far { points[0] } else { [0.0; 3] };
    Ok(points.iter().map(|point| core::array::from_fn(|i| (point[i] - origin[i]) as f32)).collect())
}
