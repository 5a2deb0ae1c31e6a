//! Resampling: spreads a few samples evenly over the surface that many noisy points represent.
//!
//! ```sh
//! cargo run --release --example resample_points
//! ```
//!
//! Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017, section 5.2, figure 15: the
//! weighted locally optimal projection of Huang et al., *Consolidation of Unorganized Point Clouds for Surface
//! Reconstruction*, SIGGRAPH Asia 2009. In every round each sample searches two clouds: the points, which pull it onto
//! their local median, and the samples, which push it away from where they are dense. The points are fixed; the samples
//! move, and their tree is refitted.

mod points;

use glam::Vec3;
use points::{Neighbours, Random, torus};
use simdop::cloud::{PointCloud, Queries, RangeSearch, Seat};
use simdop::isa::Isa;

const POINTS: usize = 20_000;
const SAMPLES: usize = 500;
const ROUNDS: usize = 40;
/// Search radius of a sample, in the unit of the points.
const H: f32 = 0.5;
/// Strength of the repulsion between samples, from 0 to 0.5.
const PUSH: f32 = 0.45;
/// Maximum distance of a point from the surface.
const NOISE: f32 = 0.02;

/// The weight of a point at a distance.
fn weight(distance: f32) -> f32 {
    (-(distance / (H / 4.0)).powi(2)).exp()
}

/// The weight for a median instead of a mean: also inversely proportional to the distance.
fn median_weight(distance: f32) -> f32 {
    weight(distance) / distance.max(1e-6)
}

/// The density around each point of a cloud: 1 for an isolated point.
fn densities(at: &[Vec3], found: &Neighbours) -> Vec<f32> {
    // Each is its own neighbour, which gives the 1.
    (0..at.len()).map(|i| found.of(i).map(|j| weight(at[i].distance(at[j]))).sum()).collect()
}

fn vectors(points: &[[f32; 3]]) -> Vec<Vec3> {
    points.iter().copied().map(Vec3::from).collect()
}

/// Moves the samples.
fn resample(points: &[[f32; 3]], samples: &mut [[f32; 3]]) -> Result<(), Box<dyn core::error::Error>> {
    let search = RangeSearch::new(Isa::detect());
    let (still, mut moving) = (PointCloud::new(points)?, PointCloud::new(samples)?);
    let (mut near_points, mut near_samples) = (Neighbours::default(), Neighbours::default());
    let mut seats = vec![Seat::default(); samples.len()];
    let p = vectors(points);
    // Prevents samples from being drawn to where the scanner saw more points.
    near_points.find(&search, &still.view(), &Queries::own(), p.len(), H)?;
    let of_points = densities(&p, &near_points);
    for round in 0..ROUNDS {
        let x = vectors(samples);
        let queries = search.seat(&still.view(), samples, &mut seats)?;
        near_points.find(&search, &still.view(), &queries, x.len(), H)?;
        near_samples.find(&search, &moving.view(), &Queries::own(), x.len(), H)?;
        let of_samples = densities(&x, &near_samples);
        let moved = (0..x.len()).map(|i| {
            let pull = near_points.of(i).map(|j| {
                let distance = x[i].distance(p[j]);
                // Samples start at points, where the median's weights are unbounded: in the first round they move to
                // the mean.
                let w = if round == 0 { weight(distance) } else { median_weight(distance) };
                (p[j] - x[i], w / of_points[j])
            });
            let push = near_samples.of(i).filter(|&j| j != i).map(|j| {
                let apart = x[i] - x[j];
                (apart, of_samples[j] * median_weight(apart.length()))
            });
            let push = if round == 0 { Vec3::ZERO } else { mean(push) };
            (x[i] + mean(pull) + push * PUSH).to_array()
        });
        let moved: Vec<_> = moved.collect();
        samples.copy_from_slice(&moved);
        moving.refit(samples)?;
    }
    Ok(())
}

/// The weighted mean of vectors; zero if there are none.
fn mean(weighted: impl Iterator<Item = (Vec3, f32)>) -> Vec3 {
    let (sum, total) = weighted.fold((Vec3::ZERO, 0.0), |(sum, total), (v, w)| (sum + v * w, total + w));
    if total > 0.0 { sum / total } else { Vec3::ZERO }
}

/// A noisy torus with more points on one side, and samples that are some of its points.
fn scan() -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let random = &mut Random(3);
    let mut points = Vec::new();
    while points.len() < POINTS {
        let (point, normal) = torus::point(random);
        if random.unit() < 0.2 + 0.4 * (point.x + 1.0).max(0.0) {
            points.push((point + normal * random.between(-NOISE, NOISE)).to_array());
        }
    }
    let samples = points[..SAMPLES].to_vec();
    (points, samples)
}

/// The distance of each sample to the nearest other one.
fn gaps(samples: &[[f32; 3]]) -> Vec<f32> {
    let x = vectors(samples);
    let gap = |i: usize| {
        (0..x.len()).filter(|&j| j != i).map(|j| x[i].distance(x[j])).fold(f32::INFINITY, f32::min)
    };
    (0..x.len()).map(gap).collect()
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let (points, mut samples) = scan();
    let least = |samples: &[[f32; 3]]| gaps(samples).into_iter().fold(f32::INFINITY, f32::min);
    let before = least(&samples);
    resample(&points, &mut samples)?;
    println!(
        "{SAMPLES} samples of {POINTS} points: {before:.4} apart at least, {:.4} afterwards",
        least(&samples)
    );
    let off: f32 = samples.iter().map(|x| torus::distance(Vec3::from(*x)).abs()).sum();
    println!("{:.4} from the surface in the mean; the points are up to {NOISE} off", off / SAMPLES as f32);
    Ok(())
}

/// Samples are on the surface and evenly spread: the smallest gap grows many times, and gaps become much more uniform.
#[test]
fn samples_spread_over_the_surface() {
    let (points, mut samples) = scan();
    let before = gaps(&samples);
    resample(&points, &mut samples).unwrap();
    let after = gaps(&samples);
    let least = |gaps: &[f32]| gaps.iter().copied().fold(f32::INFINITY, f32::min);
    assert!(least(&after) > 5.0 * least(&before), "{} {}", least(&before), least(&after));
    // The standard deviation of the gaps relative to their mean: 0 if all are equal.
    let unevenness = |gaps: &[f32]| {
        let n = gaps.len() as f32;
        let mean = gaps.iter().sum::<f32>() / n;
        (gaps.iter().map(|gap| (gap - mean).powi(2)).sum::<f32>() / n).sqrt() / mean
    };
    assert!(
        unevenness(&after) < 0.25 * unevenness(&before),
        "{} {}",
        unevenness(&before),
        unevenness(&after)
    );
    // Where the scanner saw less, gaps are hardly wider, thanks to the densities.
    let on_side = |sign: f32| {
        let of_side = samples.iter().zip(&after).filter(|(x, _)| sign * x[0] > 0.3).map(|(_, gap)| *gap);
        of_side.clone().sum::<f32>() / of_side.count() as f32
    };
    assert!(on_side(-1.0) < 1.2 * on_side(1.0), "{} {}", on_side(-1.0), on_side(1.0));
    let off: Vec<f32> = samples.iter().map(|x| torus::distance(Vec3::from(*x)).abs()).collect();
    let farthest = off.iter().copied().fold(0.0, f32::max);
    assert!(farthest < 2.0 * NOISE, "{farthest}");
    let mean = off.iter().sum::<f32>() / off.len() as f32;
    assert!(mean < 0.5 * NOISE, "{mean}");
}

#[test]
fn it_runs() {
    main().unwrap();
}
