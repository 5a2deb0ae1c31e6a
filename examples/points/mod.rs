//! Shared by the examples about clouds: generated points, so that no files are needed, and lists of neighbours.

use glam::Vec3;
use simdop::cloud::{CloudRef, List, Queries, Radii, RangeSearch, SearchError};

/// A generator of numbers in [0, 1), the same on every machine: a 64-bit linear congruential generator (Knuth's MMIX).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u32 << 24) as f32
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A uniformly distributed unit vector.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let p = Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}

/// The surface that points are sampled from: a torus around the z axis.
pub(crate) mod torus {
    use super::{Random, Vec3};
    use core::f32::consts::TAU;

    /// Distance from the axis to the centre of the tube.
    const MAJOR: f32 = 1.0;
    /// Radius of the tube.
    const MINOR: f32 = 0.4;

    /// A point of the surface and its normal.
    pub(crate) fn point(random: &mut Random) -> (Vec3, Vec3) {
        let (u, v) = (TAU * random.unit(), TAU * random.unit());
        let outwards = Vec3::new(u.cos(), u.sin(), 0.0);
        let normal = outwards * v.cos() + Vec3::Z * v.sin();
        (outwards * MAJOR + normal * MINOR, normal)
    }

    /// The signed distance of a point from the surface; negative inside.
    pub(crate) fn distance(p: Vec3) -> f32 {
        (Vec3::new(p.x.hypot(p.y) - MAJOR, p.z, 0.0)).length() - MINOR
    }
}

/// The neighbours of each query, in reused memory that grows to the longest lists.
#[derive(Default)]
pub(crate) struct Neighbours {
    lists: Vec<List>,
    indices: Vec<u32>,
}

impl Neighbours {
    pub(crate) fn find(
        &mut self,
        search: &RangeSearch,
        cloud: &CloudRef<'_>,
        queries: &Queries<'_>,
        count: usize,
        radius: f32,
    ) -> Result<(), SearchError> {
        self.lists.resize(count, List::default());
        loop {
            match search.fill(cloud, queries, Radii::Same(radius), &mut self.lists, &mut self.indices) {
                Err(SearchError::Buffer { need, .. }) if need < u64::from(u32::MAX) => {
                    // Some more, so that the next step is likely to fit.
                    self.indices.resize(need as usize * 5 / 4, 0);
                }
                found => return found.map(drop),
            }
        }
    }

    /// The neighbours of one query.
    pub(crate) fn of(&self, query: usize) -> impl Iterator<Item = usize> + Clone {
        self.indices[self.lists[query].range()].iter().map(|&index| index as usize)
    }
}

/// Names everything once, so that examples which use only some of it compile without a warning.
const _: () = {
    let _ = (Random::unit, Random::between, Random::direction, torus::point, torus::distance);
    let _ = Neighbours::find;
    let _ = |found: &Neighbours| found.of(0).count();
};
