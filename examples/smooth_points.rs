//! Moving least squares: removes the noise of a scan by fitting planes to neighbours.
//!
//! ```sh
//! cargo run --release --example smooth_points
//! ```
//!
//! Xing, Wang, Hui, *Coherent Spherical Range-Search for Dynamic Points on GPUs*, CAD 2017, section 5.2, figure 14.
//! Each point is projected onto the plane that best fits its neighbours within h, weighted by distance: the projection
//! onto point-set surfaces (Alexa et al., *Computing and Rendering Point Set Surfaces*, 2003) in its simplest form,
//! with planes only. All points move in every round, so the tree is refitted, not rebuilt.

mod points;

use glam::{Mat3, Vec3};
use points::{Neighbours, Random, torus};
use simdop::cloud::{PointCloud, Queries, RangeSearch};
use simdop::isa::Isa;

/// Search radius of a point, in the unit of the points.
const H: f32 = 0.12;
/// Each round shrinks a curved surface a little: more rounds leave less noise, and less of the torus.
const ROUNDS: usize = 2;
/// Maximum distance of a point of the scan from the surface.
const NOISE: f32 = 0.02;

/// The normal of the best-fitting plane: the eigenvector with the smallest eigenvalue.
fn normal(covariance: Mat3) -> Vec3 {
    let [x, y, z] = [covariance.x_axis, covariance.y_axis, covariance.z_axis];
    // The adjugate has the same eigenvectors; its largest eigenvalue belongs to the smallest one of the matrix. Each
    // squaring suppresses the others.
    let mut m = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    for _ in 0..6 {
        let size = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        if size <= 0.0 {
            return Vec3::ZERO; // The neighbours lie on a line: the plane is not unique.
        }
        m *= 1.0 / size;
        m *= m;
    }
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let longest = |a: Vec3, b: Vec3| if b.length_squared() > a.length_squared() { b } else { a };
    columns.into_iter().fold(Vec3::ZERO, longest).normalize_or_zero()
}

/// The projection of a point, given its neighbours.
fn project(q: Vec3, neighbours: impl Iterator<Item = Vec3> + Clone) -> Vec3 {
    let weight = |p: Vec3| (-p.distance_squared(q) / (H / 3.0).powi(2)).exp();
    let (sum, total) = neighbours.clone().fold((Vec3::ZERO, 0.0), |(sum, total), p| {
        let w = weight(p);
        // Relative to q, so that no precision is lost far from the origin.
        (sum + (p - q) * w, total + w)
    });
    // The point is its own neighbour, so the total weight is not zero.
    let mean = sum / total;
    let outer = |d: Vec3| Mat3::from_cols(d * d.x, d * d.y, d * d.z);
    let covariance = neighbours.fold(Mat3::ZERO, |m, p| m + outer((p - q - mean) / H) * weight(p));
    let n = normal(covariance * (1.0 / total));
    q + n * n.dot(mean)
}

/// Smooths the points in place.
fn smooth(points: &mut [[f32; 3]]) -> Result<(), Box<dyn core::error::Error>> {
    let search = RangeSearch::new(Isa::detect());
    let mut cloud = PointCloud::new(points)?;
    let mut found = Neighbours::default();
    for _ in 0..ROUNDS {
        found.find(&search, &cloud.view(), &Queries::own(), points.len(), H)?;
        let at = |i: usize| Vec3::from(points[i]);
        let moved: Vec<[f32; 3]> =
            (0..points.len()).map(|i| project(at(i), found.of(i).map(at)).into()).collect();
        points.copy_from_slice(&moved);
        cloud.refit(points)?;
    }
    Ok(())
}

/// A torus scanned with noise.
fn scan(count: usize) -> Vec<[f32; 3]> {
    let random = &mut Random(1);
    let one = |_| {
        let (point, normal) = torus::point(random);
        (point + normal * random.between(-NOISE, NOISE)).into()
    };
    (0..count).map(one).collect()
}

/// The root mean square distance from the true surface.
fn noise(points: &[[f32; 3]]) -> f32 {
    let sum: f32 = points.iter().map(|p| torus::distance(Vec3::from(*p)).powi(2)).sum();
    (sum / points.len() as f32).sqrt()
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut points = scan(20_000);
    let before = noise(&points);
    smooth(&mut points)?;
    println!(
        "20000 points, {before:.5} from the surface (root mean square), {:.5} when smoothed",
        noise(&points)
    );
    Ok(())
}

/// The noise falls to less than a third, and the largest distance shrinks.
#[test]
fn the_noise_falls() {
    let mut points = scan(20_000);
    let before = noise(&points);
    // The root mean square of a number that is uniform in -NOISE .. NOISE.
    assert!((before / (NOISE / 3.0_f32.sqrt()) - 1.0).abs() < 0.05, "{before}");
    smooth(&mut points).unwrap();
    assert!(noise(&points) < before / 3.0, "{before} {}", noise(&points));
    let farthest = points.iter().map(|p| torus::distance(Vec3::from(*p)).abs()).fold(0.0, f32::max);
    assert!(farthest < 0.75 * NOISE, "{farthest}");
}

/// Points of a plane stay where they are, and one beside it moves onto it.
#[test]
fn a_plane_stays() {
    let (x, y) = (Vec3::new(0.6, 0.0, 0.8), Vec3::Y);
    let plane: Vec<Vec3> =
        (0..49).map(|i| (x * (i % 7) as f32 + y * (i / 7) as f32) * 0.01 - (x + y) * 0.03).collect();
    let up = x.cross(y);
    let moved = project(up * 0.01, plane.iter().copied());
    assert!(moved.length() < 1e-5, "{moved}");
    let moved = project(plane[10], plane.iter().copied());
    assert!((moved - plane[10]).length() < 1e-6, "{moved}");
}

#[test]
fn it_runs() {
    main().unwrap();
}
