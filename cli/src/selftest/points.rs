//! Points and their neighbours, compared with a loop over all points by the definition of a neighbour in
//! [`simdop::cloud`].

use super::check::{Wrong, first_of_each, unequal};
use super::draw::Draw;
use super::tally::{Asked, Tally};
use crate::error::Error;
use core::time::Duration;
use simdop::cloud::{List, PointCloud, Queries, Radii, RangeSearch, RangeStats, SearchError};
use simdop::isa::Isa;
use std::time::Instant;

/// Points that all have the same search radius.
pub(super) struct Neighbourhood {
    points: Vec<[f32; 3]>,
    radius: f32,
}

/// Number of points in a cloud, and of queries.
const POINTS: usize = 256;

/// Uniform in a cube, with about ten neighbours each.
pub(super) fn uniform(draw: &mut Draw) -> Neighbourhood {
    let points = (0..POINTS).map(|_| core::array::from_fn(|_| draw.unit() as f32)).collect();
    Neighbourhood { points, radius: 0.22 }
}

/// On a lattice, with a radius that equals a distance on it, up to rounding.
pub(super) fn at_radius(draw: &mut Draw) -> Neighbourhood {
    let unit = draw.pick(&[1.0, 0.1, 1e-3, 1024.0]);
    let away = draw.pick(&[0.0, 0.0, 1e4, 1e6]) * unit;
    let is_nudged = draw.below(4) == 0;
    let coordinate = |draw: &mut Draw| {
        let x = (away + unit * f64::from(draw.int(0, 7))) as f32;
        match draw.below(3) {
            0 if is_nudged => x.next_up(),
            1 if is_nudged => x.next_down(),
            _ => x,
        }
    };
    let points = (0..POINTS).map(|_| core::array::from_fn(|_| coordinate(draw))).collect();
    // Squared lengths of integer vectors: the lengths are 1, 2, 3 and square roots.
    let square = draw.pick(&[1.0, 4.0, 9.0, 2.0, 3.0, 5.0, 6.0, 14.0, 0.0]);
    let radius = (f64::sqrt(square) * unit) as f32;
    let radius = if is_nudged && radius > 0.0 && draw.is_heads() { radius.next_down() } else { radius };
    Neighbourhood { points, radius }
}

impl Neighbourhood {
    /// Whether p is a neighbour of q.
    fn is_near(p: &[f32; 3], q: &[f32; 3], radius: f32) -> bool {
        let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        (x * x + y * y) + z * z <= radius * radius
    }

    /// The neighbours of a point, in ascending order.
    fn near(&self, query: usize, radius: f32) -> Vec<u32> {
        let points = self.points.iter().zip(0..);
        let near = points.filter(|(p, _)| Self::is_near(p, &self.points[query], radius));
        near.map(|(_, index)| index).collect()
    }

    /// Whether the answer changes if the radius changes by one unit in the last place.
    fn is_knife_edge(&self, query: usize, neighbours: usize) -> bool {
        let beside = [self.radius.next_up(), self.radius.next_down().max(0.0)];
        beside.iter().any(|&radius| self.near(query, radius).len() != neighbours)
    }

    /// Queries the first `count` points.
    pub(super) fn ask(&self, count: usize, trial: u64, tally: &mut Tally<'_>) -> Result<(), Error> {
        let name = || "the cloud of a trial".to_owned();
        let cloud =
            PointCloud::new(&self.points).map_err(|error| Error::PointCloud { name: name(), error })?;
        let failed = |error| Error::Search { name: name(), error };
        let (mut answers, mut stats, mut nanoseconds) = (Vec::new(), Vec::new(), 0);
        for isa in Isa::available() {
            let (lists, work, time) = self.lists(isa, &cloud).map_err(failed)?;
            nanoseconds = time.as_nanos() as u64 / self.points.len() as u64;
            answers.push((isa, lists));
            stats.push((isa, work));
        }
        for query in 0..count.min(self.points.len()) {
            let near = self.near(query, self.radius);
            let each: Vec<(Isa, &[u32])> =
                answers.iter().map(|(isa, lists)| (*isa, lists[query].as_slice())).collect();
            let mut wrong = differences(&near, &each);
            if query == 0 {
                // The statistics cover all points.
                wrong.extend(unequal(&stats));
            }
            let first = each.first().map_or(&[][..], |(_, found)| found);
            tally.add_answer(first.iter().copied().map(u64::from));
            tally.add(Asked {
                trial,
                place: query,
                is_hit: near.len() > 1,
                is_knife_edge: self.is_knife_edge(query, near.len()),
                exact_pairs: 0,
                nanoseconds,
                wrong,
                describe: &|| format!("radius {:?} of point {query}, {:?}", self.radius, self.points[query]),
            });
        }
        Ok(())
    }

    /// The neighbours of each point, in the order of the library, and the range statistics.
    fn lists(
        &self,
        isa: Isa,
        cloud: &PointCloud,
    ) -> Result<(Vec<Vec<u32>>, RangeStats, Duration), SearchError> {
        let search = RangeSearch::new(isa);
        let mut lists = vec![List::default(); self.points.len()];
        let mut indices = vec![0; self.points.len() * self.points.len()];
        let (radii, start) = (Radii::Same(self.radius), Instant::now());
        let work = search.fill(&cloud.view(), &Queries::own(), radii, &mut lists, &mut indices)?;
        let time = start.elapsed();
        Ok((lists.into_iter().map(|list| indices[list.range()].to_vec()).collect(), work, time))
    }
}

/// The errors in the lists of one point.
fn differences(near: &[u32], answers: &[(Isa, &[u32])]) -> Vec<(Wrong, Isa)> {
    let of_one = |(isa, found): &(Isa, &[u32])| {
        let mut sorted = found.to_vec();
        sorted.sort_unstable();
        let lacks = |all: &[u32], some: &[u32]| some.iter().any(|index| all.binary_search(index).is_err());
        // A neighbour that is listed twice is an error, too.
        let is_invented = lacks(near, &sorted) || sorted.windows(2).any(|pair| pair[0] == pair[1]);
        let missed = lacks(&sorted, near).then_some((Wrong::Missed, *isa));
        missed.into_iter().chain(is_invented.then_some((Wrong::Invented, *isa)))
    };
    first_of_each(answers.iter().flat_map(of_one).chain(unequal(answers)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_too_few_and_too_many_are_reported() {
        let kinds = |found: &[u32]| {
            let wrong = differences(&[1, 4, 6], &[(Isa::SCALAR, found)]);
            wrong.into_iter().map(|(wrong, _)| wrong).collect::<Vec<_>>()
        };
        assert_eq!(kinds(&[4, 1, 6]), []);
        assert_eq!(kinds(&[4, 1]), [Wrong::Missed]);
        assert_eq!(kinds(&[4, 1, 6, 2]), [Wrong::Invented]);
        assert_eq!(kinds(&[4, 1, 6, 1]), [Wrong::Invented], "twice");
        let isa = Isa::detect();
        let unequal = differences(&[1, 4], &[(Isa::SCALAR, &[1, 4]), (isa, &[4, 1])]);
        assert_eq!(unequal, [(Wrong::Unequal, isa)], "another order");
    }

    #[test]
    fn ties_are_on_the_edge() {
        let points = vec![[0.0; 3], [3.0, 4.0, 0.0], [0.0, 0.0, 5.5]];
        let trial = Neighbourhood { points, radius: 5.0 };
        assert_eq!(trial.near(0, trial.radius), [0, 1]);
        assert!(trial.is_knife_edge(0, 2) && !trial.is_knife_edge(2, 1));
    }
}
