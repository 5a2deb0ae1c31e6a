//! Poses at the distances of the benchmarks.
//!
//! After the benchmarking suite of Trenkel, Weller and Zachmann (WSCG 2007), like `benches/support/suites.rs`: body A
//! is rotated at random and approaches B along a line until it is at a given distance. Every other line goes from a
//! random direction to the centre of B's box. The rest go along a coordinate axis through a random point at which the
//! boxes can overlap, so that A also passes the sides of B. Lines that miss B are dropped, so that each line gives a
//! pose at every distance. Distances are relative to the diagonal of A's box.

use crate::error::Error;
use crate::random::Random;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::mesh_io::MeshData;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;

/// One value for each distance.
pub(super) type PerDistance<T> = [T; DISTANCES.len()];

/// The names of the distances, as in the benchmarks, nearest first.
pub(super) const DISTANCES: [&str; 4] = ["1 % deep", "0 %", "1 %", "5 %"];
/// Gaps between the bodies at all but the first distance. A gap of exactly zero is not attainable.
const GAPS: [f64; 3] = [2e-5, 0.01, 0.05];
/// How far beyond the smallest gap A moves for the first distance.
const DEPTH: f64 = 0.01;

/// Positions along a line are multiples of this fraction of the diagonal: 0.3 % of the smallest gap, and coarse enough
/// that a pose does not depend on the last bits of a distance.
const STEP: f64 = 1.0 / (1 << 24) as f64;
/// Maximum number of steps of an approach. More are needed only if the bodies slide along each other.
const MOST_STEPS: usize = 10_000;
/// Maximum number of lines tried for each that hits.
const MOST_LINES: usize = 1000;

/// `count` poses of A in B's frame at each distance.
///
/// # Errors
/// If a mesh has no size, cannot be built, or no line leads to contact.
pub(super) fn poses(
    [a, b]: [(&str, &MeshData); 2],
    count: usize,
    seed: u64,
) -> Result<PerDistance<Vec<Pose>>, Error> {
    let [a, b] = [Approaching::new(a)?, Approaching::new(b)?];
    let mut random = Random::new(seed);
    let (mut poses, mut lines) = (PerDistance::<Vec<Pose>>::default(), 0);
    while poses[0].len() < count {
        let towards_centre = poses[0].len().is_multiple_of(2);
        let line = Line::random(&a, &b, towards_centre, &mut random);
        lines += 1;
        match line.along() {
            Some(found) => poses.iter_mut().zip(found).for_each(|(poses, pose)| poses.push(pose)),
            None if lines < MOST_LINES * (poses[0].len() + 1) => {}
            None => return Err(Error::NoContact { a: a.name.into(), b: b.name.into(), lines }),
        }
    }
    Ok(poses)
}

/// The low and the high corner of the box around the triangles.
pub(super) fn bounds(mesh: &MeshData) -> [[f64; 3]; 2] {
    let bound = |i: usize, of: fn(f64, f64) -> f64| {
        let corners = mesh.triangles.iter().flatten().map(|&v| mesh.vertices[v as usize][i]);
        corners.reduce(of).unwrap_or_default()
    };
    [f64::min, f64::max].map(|of| core::array::from_fn(|i| bound(i, of)))
}

/// The diagonal of a box of any size, even if its square overflows `f64`.
pub(super) fn diagonal([low, high]: &[[f64; 3]; 2]) -> f64 {
    let sides: [f64; 3] = core::array::from_fn(|i| high[i] - low[i]);
    let longest = sides.into_iter().fold(0.0, f64::max);
    if longest > 0.0 {
        longest * sides.map(|side| (side / longest).powi(2)).iter().sum::<f64>().sqrt()
    } else {
        0.0
    }
}

struct Approaching<'m> {
    name: &'m str,
    tree: Bvh<Node16<18>>,
    low: [f64; 3],
    high: [f64; 3],
}

impl<'m> Approaching<'m> {
    fn new((name, mesh): (&'m str, &MeshData)) -> Result<Self, Error> {
        let [low, high] = bounds(mesh);
        let triangles = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        let tree = Builder::fast()
            .build_as(&triangles)
            .map_err(|error| Error::Build { name: name.into(), error })?;
        let found = Self { name, tree, low, high };
        if found.diagonal() > 0.0 { Ok(found) } else { Err(Error::NoSize { name: name.into() }) }
    }

    fn centre(&self) -> [f64; 3] {
        core::array::from_fn(|i| 0.5 * self.low[i] + 0.5 * self.high[i])
    }

    fn diagonal(&self) -> f64 {
        diagonal(&[self.low, self.high])
    }
}

/// A line along which A, rotated, approaches B.
struct Line<'t> {
    a: &'t Approaching<'t>,
    b: &'t Approaching<'t>,
    rotation: [[f64; 3]; 3],
    /// The centre of A at position 0.
    target: [f64; 3],
    /// The direction from there to where A comes from.
    back: [f64; 3],
}

impl<'t> Line<'t> {
    fn random(
        a: &'t Approaching<'t>,
        b: &'t Approaching<'t>,
        towards_centre: bool,
        random: &mut Random,
    ) -> Self {
        let rotation = rotation(random);
        let (mut target, mut back) = (b.centre(), self::rotation(random)[0]);
        if !towards_centre {
            let which = ((6.0 * random.unit()) as usize).min(5);
            let reach = 0.5 * a.diagonal();
            let within = |i: usize| [b.low[i] - reach, b.high[i] + reach];
            for i in [(which + 1) % 3, (which + 2) % 3] {
                target[i] = random.between(within(i));
            }
            back = [0.0; 3];
            back[which % 3] = if which < 3 { 1.0 } else { -1.0 };
        }
        Self { a, b, rotation, target, back }
    }

    /// The position at a distance, in steps.
    fn place(&self, distance: f64) -> i64 {
        (distance / (STEP * self.a.diagonal())) as i64
    }

    fn pose(&self, place: i64) -> Option<Pose> {
        let centre = self.a.centre();
        let way = place as f64 * STEP * self.a.diagonal();
        let row = |i: usize| {
            let [x, y, z] = self.rotation[i];
            let turned = x * centre[0] + y * centre[1] + z * centre[2];
            [x, y, z, self.target[i] + way * self.back[i] - turned]
        };
        Pose::from_rows(core::array::from_fn(row)).ok()
    }

    /// A pose at each distance, or `None` if the line misses.
    fn along(&self) -> Option<PerDistance<Pose>> {
        let mut place = self.place(2.0 * (self.a.diagonal() + self.b.diagonal()));
        let mut places = [0; DISTANCES.len()];
        // From the largest gap to contact: each search continues where the last one ended.
        for (i, gap) in GAPS.into_iter().enumerate().rev() {
            place = self.reach(place, gap * self.a.diagonal())?;
            places[i + 1] = place;
        }
        places[0] = place - self.place(DEPTH * self.a.diagonal());
        let [deep, touching, near, far] = places.map(|place| self.pose(place));
        Some([deep?, touching?, near?, far?])
    }

    /// The first position, coming from `start`, at which the bodies are `gap` apart, or up to a hundredth of it more.
    ///
    /// No point moves farther than A's centre does, so a stride as long as the spare distance is safe.
    fn reach(&self, start: i64, gap: f64) -> Option<i64> {
        let query = Query::new(Isa::detect());
        let short = (self.place(gap) / 128).max(1);
        let mut place = start;
        for _ in 0..MOST_STEPS {
            let spare = |tolerance| {
                let found = query.distance(&self.a.tree, &self.b.tree, &self.pose(place)?, tolerance).ok()?;
                Some(self.place(found.lower - gap))
            };
            // A rough distance is cheap, and sufficient while it is large.
            let mut stride = spare(0.5)?;
            if stride < 16 * short {
                stride = spare(1.0 / 512.0)?;
            }
            if stride <= short {
                return Some(place);
            }
            place -= stride;
            if place < -start.abs() {
                break;
            }
        }
        None
    }
}

/// A uniformly distributed rotation, from a quaternion that is uniform in the unit ball. Avoids sines, whose last bits
/// differ between math libraries.
fn rotation(random: &mut Random) -> [[f64; 3]; 3] {
    let ([w, x, y, z], square) = loop {
        let q: [f64; 4] = core::array::from_fn(|_| 2.0 * random.unit() - 1.0);
        let square = q.iter().map(|c| c * c).sum::<f64>();
        if (0.01..1.0).contains(&square) {
            break (q, square);
        }
    };
    let entry = |diagonal: f64, rest: f64| (diagonal + 2.0 * rest) / square;
    let product = |p: f64, q: f64| entry(0.0, p * q);
    [
        [entry(square, -y * y - z * z), product(x, y) - product(w, z), product(x, z) + product(w, y)],
        [product(x, y) + product(w, z), entry(square, -x * x - z * z), product(y, z) - product(w, x)],
        [product(x, z) - product(w, y), product(y, z) + product(w, x), entry(square, -x * x - y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;

    /// Checked with the library's distances, which are tested against brute force.
    #[test]
    fn poses_are_at_their_distances() {
        let (knot, gear) = (demo::knot(), demo::gear());
        let meshes = [("knot", &knot), ("gear", &gear)];
        let found = poses(meshes, 8, 1).unwrap();
        let [a, b] = meshes.map(|mesh| Approaching::new(mesh).unwrap());
        let query = Query::new(Isa::detect());
        let mut deep_hits = 0;
        for line in 0..8 {
            deep_hits += usize::from(!query.collide(&a.tree, &b.tree, &found[0][line]).is_free());
            for (poses, gap) in found[1..].iter().zip([2e-5, 0.01, 0.05]) {
                let distance =
                    query.distance(&a.tree, &b.tree, &poses[line], 0.0).unwrap().lower / a.diagonal();
                assert!((gap..1.02 * gap).contains(&distance), "{distance} for {gap}");
            }
        }
        assert!(deep_hits >= 6, "{deep_hits}: a thin part may be passed through");
        assert_eq!(poses(meshes, 8, 1).unwrap(), found);
        assert_ne!(poses(meshes, 8, 2).unwrap(), found);
    }

    #[test]
    fn rotations_are_rotations() {
        let mut random = Random::new(1);
        let mut mean = [0.0; 3];
        for _ in 0..1000 {
            let [a, b, c] = rotation(&mut random);
            let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            assert!((dot(cross, c) - 1.0).abs() < 1e-12 && dot(a, b).abs() < 1e-12);
            mean = core::array::from_fn(|i| mean[i] + a[i] / 1000.0);
        }
        assert!(mean.iter().all(|x| x.abs() < 0.1), "{mean:?}");
    }

    #[test]
    fn a_diagonal_is_one_in_any_unit() {
        for unit in [1e-200, 1.0, 1e200] {
            let box_of = [[unit; 3], [3.0 * unit, 4.0 * unit, 7.0 * unit]];
            assert!((diagonal(&box_of) / unit - 7.0).abs() < 1e-12);
        }
    }

    /// Two tiny triangles at the ends of a box, far from its centre.
    #[test]
    fn bodies_that_always_miss_are_an_error() {
        let corner = |at: f64| [[at; 3], [at + 1e-9, at, at], [at, at + 1e-9, at]];
        let mesh =
            MeshData { vertices: [corner(0.0), corner(1.0)].concat(), triangles: vec![[0, 1, 2], [3, 4, 5]] };
        let error = poses([("a", &mesh), ("b", &mesh)], 1, 1).unwrap_err();
        assert!(matches!(error, Error::NoContact { a, b, lines: MOST_LINES } if a == "a" && b == "b"));
    }

    #[test]
    fn bodies_without_size_are_refused() {
        let point = MeshData { vertices: vec![[1.0; 3]; 3], triangles: vec![[0, 1, 2]] };
        let error = poses([("point", &point), ("point", &point)], 1, 1).unwrap_err();
        assert!(matches!(error, Error::NoSize { name } if name == "point"));
    }
}
