//! Disjoint spheres: in a ball, and inside a mesh.

use crate::data::MeshData;
use crate::rng::Rng;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;

#[derive(Copy, Clone, Debug)]
pub(crate) struct Sphere {
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
}

impl Sphere {
    /// From the centre.
    pub(crate) fn distance(&self, p: [f64; 3]) -> f64 {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| (self.centre[i] - p[i]) * (self.centre[i] - p[i]));
        ((x + y) + z).sqrt()
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.distance(other.centre) < self.radius + other.radius
    }

    /// Over 4/3 pi.
    pub(crate) fn volume(&self) -> f64 {
        self.radius * self.radius * self.radius
    }
}

/// In the unit ball: large ones first, each at the first random place where it is free. Radii fall from the
/// largest to `least` of it, as many of each size as have the same volume together.
pub(crate) fn in_a_ball(count: usize, least: f64, rng: &mut Rng) -> Vec<Sphere> {
    // Number of spheres smaller than r ~ r^-3.
    let size = |i: usize| {
        let share = (i as f64 + 0.5) / count as f64;
        (1.0 + share * (1.0 / (least * least * least) - 1.0)).cbrt().recip()
    };
    let volume: f64 = (0..count).map(|i| size(i) * size(i) * size(i)).sum();
    // Random places fill a fifth of the ball without a long search.
    let largest = (0.2 / volume).cbrt();
    let mut spheres: Vec<Sphere> = Vec::with_capacity(count);
    while spheres.len() < count {
        let radius = largest * size(spheres.len());
        let centre = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        let sphere = Sphere { centre, radius };
        if sphere.distance([0.0; 3]) + radius < 1.0 && spheres.iter().all(|other| !other.overlaps(&sphere)) {
            spheres.push(sphere);
        }
    }
    spheres
}

/// Grid points along the longest side of the mesh.
const GRID: usize = 80;

/// A place for a sphere, and how large it may be there as far as is known.
struct Place {
    centre: [f64; 3],
    clearance: f64,
    /// Spheres that the clearance respects.
    seen: usize,
}

/// Inside a watertight mesh: again and again the largest sphere with its centre on a grid that touches
/// neither the surface nor another. At most `count`.
pub(crate) fn inside(mesh: &MeshData, count: usize) -> Vec<Sphere> {
    let clearances = clearances(mesh);
    let place = |(centre, clearance)| Place { centre, clearance, seen: 0 };
    let mut places: Vec<Place> = clearances.into_iter().map(place).collect();
    let mut spheres: Vec<Sphere> = Vec::new();
    while spheres.len() < count && !places.is_empty() {
        // Clearances only shrink: the largest that is up to date is the largest.
        let largest = places.iter().enumerate().max_by(|a, b| a.1.clearance.total_cmp(&b.1.clearance));
        let index = largest.expect("there are places").0;
        let place = &mut places[index];
        for sphere in &spheres[place.seen..] {
            place.clearance = place.clearance.min(sphere.distance(place.centre) - sphere.radius);
        }
        let up_to_date = core::mem::replace(&mut place.seen, spheres.len()) == spheres.len();
        if place.clearance <= 0.0 {
            places.swap_remove(index);
        } else if up_to_date {
            spheres.push(Sphere { centre: place.centre, radius: place.clearance });
        }
    }
    spheres
}

/// The grid points inside, and their distances from the surface.
fn clearances(mesh: &MeshData) -> Vec<([f64; 3], f64)> {
    let body: Bvh<Node16<18>> =
        Builder::new().build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let point: Bvh<Node16<18>> =
        Builder::new().build(&Mesh { vertices: &[[0.0; 3]], triangles: &[[0; 3]] }).unwrap();
    let query = Query::new(Isa::detect());
    let clearance = |[x, y, z]: [f64; 3]| {
        let pose = Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]).unwrap();
        query.distance(&point.view(), &body.view(), &pose, 1e-3).unwrap().lower
    };
    inner_points(mesh).into_iter().map(|p| (p, clearance(p))).collect()
}

/// By the parity of what a line along x has crossed.
fn inner_points(mesh: &MeshData) -> Vec<[f64; 3]> {
    let (low, high) = mesh.bounds();
    let step = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max) / GRID as f64;
    // Not on a vertex or an edge: those have shorter decimals.
    let place = |axis: usize, i: usize| low[axis] + step * (i as f64 + 0.428_571_371_9);
    let mut points = Vec::new();
    for (j, k) in (0..GRID).flat_map(|j| (0..GRID).map(move |k| (j, k))) {
        let (y, z) = (place(1, j), place(2, k));
        let mut crossings: Vec<f64> = mesh.corners().iter().filter_map(|t| crossing(t, y, z)).collect();
        crossings.sort_by(f64::total_cmp);
        for [x, end] in crossings.as_chunks().0 {
            points
                .extend((0..GRID).map(|i| place(0, i)).filter(|p| (x..end).contains(&p)).map(|x| [x, y, z]));
        }
    }
    points
}

/// Where the line along x at (y, z) crosses the triangle.
fn crossing(t: &[[f64; 3]; 3], y: f64, z: f64) -> Option<f64> {
    // Twice the areas, seen along x, of the triangles of the point with each edge.
    let side = |p: &[f64; 3], q: &[f64; 3]| (p[1] - y) * (q[2] - z) - (p[2] - z) * (q[1] - y);
    let [a, b, c] = [side(&t[1], &t[2]), side(&t[2], &t[0]), side(&t[0], &t[1])];
    let inside = (a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0);
    inside.then(|| (a * t[0][0] + b * t[1][0] + c * t[2][0]) / (a + b + c))
}
