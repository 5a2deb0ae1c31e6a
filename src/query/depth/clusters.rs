//! Clusters of contact points: the bodies are likely to overlap near them.

use crate::range::Point;
use crate::vector::{cross, difference, dot, length, unit};

const MOST: usize = 4;

/// Points near each other, on both surfaces.
#[derive(Copy, Clone)]
struct ContactCluster {
    first: Point,
    sum: Point,
    count: f64,
    /// Sums of the normals of A and of B.
    normals: [Point; 2],
}

const NOTHING: ContactCluster =
    ContactCluster { first: [0.0; 3], sum: [0.0; 3], count: 0.0, normals: [[0.0; 3]; 2] };

/// Groups of points, whose first points are far from each other.
pub(super) struct Clusters {
    clusters: [ContactCluster; MOST],
    len: usize,
}

impl Clusters {
    pub(super) const fn new() -> Self {
        Self { clusters: [NOTHING; MOST], len: 0 }
    }

    /// Adds a point with the normals there.
    pub(super) fn add(&mut self, [point, of_a, of_b]: [Point; 3]) {
        let new = ContactCluster { first: point, sum: point, count: 1.0, normals: [of_a, of_b] };
        if self.len < MOST {
            self.clusters[self.len] = new;
            self.len += 1;
            return;
        }
        let apart = |p: &Point, q: &Point| length(&difference(p, q));
        let mut nearest = (0, f64::INFINITY);
        let mut closest = ((0, 1), f64::INFINITY);
        for (j, cluster) in self.clusters.iter().enumerate() {
            let far = apart(&cluster.first, &point);
            if far < nearest.1 {
                nearest = (j, far);
            }
            for (i, other) in self.clusters[..j].iter().enumerate() {
                let far = apart(&other.first, &cluster.first);
                if far < closest.1 {
                    closest = ((i, j), far);
                }
            }
        }
        if nearest.1 > closest.1 {
            let (i, j) = closest.0;
            let joined = self.clusters[j];
            self.clusters[i].join(&joined);
            self.clusters[j] = new;
        } else {
            self.clusters[nearest.0].join(&new);
        }
    }

    fn all(&self) -> ContactCluster {
        self.clusters[..self.len].iter().fold(NOTHING, |mut all, cluster| {
            all.join(cluster);
            all
        })
    }

    /// The middle of all points, and of each cluster.
    pub(super) fn middles(&self) -> [Option<Point>; MOST + 1] {
        let mut middles = [None; MOST + 1];
        middles[0] = self.all().middle();
        for (cluster, middle) in self.clusters[..self.len].iter().zip(&mut middles[1..]) {
            *middle = cluster.middle();
        }
        middles
    }

    /// Points inwards of the middle of all points, against the normals of B, of A, and of both, by fractions of the
    /// distance to the farthest first point.
    pub(super) fn inner(&self) -> [Option<Point>; 6] {
        let all = self.all();
        let Some(middle) = all.middle() else { return [None; 6] };
        let wide = self.clusters[..self.len]
            .iter()
            .fold(0.0, |wide, cluster| f64::max(wide, length(&difference(&cluster.first, &middle))));
        let [of_a, of_b] = all.normals;
        let both = core::array::from_fn(|i| of_a[i] + of_b[i]);
        let mut inner = [None; 6];
        for (i, point) in inner.iter_mut().enumerate() {
            let share = if i < 3 { 0.5 } else { 0.125 };
            *point = unit(&[of_b, of_a, both][i % 3])
                .map(|outwards| core::array::from_fn(|i| middle[i] - share * wide * outwards[i]));
        }
        inner
    }
}

impl ContactCluster {
    fn join(&mut self, other: &Self) {
        let sum = |p: &Point, q: &Point| core::array::from_fn(|i| p[i] + q[i]);
        self.sum = sum(&self.sum, &other.sum);
        self.count += other.count;
        for (normal, other) in self.normals.iter_mut().zip(&other.normals) {
            *normal = sum(normal, other);
        }
    }

    fn middle(&self) -> Option<Point> {
        (self.count > 0.0).then(|| self.sum.map(|x| x / self.count))
    }
}

/// The corners, if there are three.
pub(super) fn triangle(mut corners: impl Iterator<Item = Point>) -> Option<[Point; 3]> {
    let triangle = [corners.next()?, corners.next()?, corners.next()?];
    corners.next().is_none().then_some(triangle)
}

/// A point near the intersection of two triangles that meet, with both normals.
pub(super) fn crossing(a: &[Point; 3], b: &[Point; 3]) -> [Point; 3] {
    let normal = |[p, q, r]: &[Point; 3]| cross(&difference(q, p), &difference(r, p));
    let normals = [normal(a), normal(b)];
    let along = cross(&normals[0], &normals[1]);
    let of_a = chord(a, &b[0], &normals[1], &along);
    let of_b = chord(b, &a[0], &normals[0], &along);
    let point = match (of_a, of_b) {
        (Some(of_a), Some(of_b)) => {
            let from = if of_a[0].0 > of_b[0].0 { of_a[0].1 } else { of_b[0].1 };
            let to = if of_a[1].0 < of_b[1].0 { of_a[1].1 } else { of_b[1].1 };
            core::array::from_fn(|i| 0.5 * (from[i] + to[i]))
        }
        _ => core::array::from_fn(|i| (a.iter().chain(b).map(|p| p[i]).sum::<f64>()) / 6.0),
    };
    [point, unit(&normals[0]).unwrap_or_default(), unit(&normals[1]).unwrap_or_default()]
}

/// The points where the edges of a triangle cross a plane: the first and the last along a direction.
fn chord(corners: &[Point; 3], on: &Point, normal: &Point, along: &Point) -> Option<[(f64, Point); 2]> {
    let height = corners.each_ref().map(|p| dot(normal, &difference(p, on)));
    let mut ends: Option<[(f64, Point); 2]> = None;
    for i in 0..3 {
        let j = (i + 1) % 3;
        if (height[i] > 0.0) == (height[j] > 0.0) {
            continue;
        }
        let share = height[i] / (height[i] - height[j]);
        let p: Point = core::array::from_fn(|k| corners[i][k] + share * (corners[j][k] - corners[i][k]));
        let end = (dot(along, &p), p);
        ends = Some(match ends {
            None => [end; 2],
            Some([first, last]) => {
                [if end.0 < first.0 { end } else { first }, if end.0 > last.0 { end } else { last }]
            }
        });
    }
    ends
}
