//! Poses of two bodies at given distances, after the benchmarking suite of Trenkel, Weller and Zachmann (WSCG 2007),
//! which the SIMDop paper uses.
//!
//! Body A is rotated at random and approaches B along a line until it is at a given distance. Two ways to choose lines:
//!
//! * *sphere*: from a random direction towards the centre of B's box;
//! * *grid*: along a coordinate axis through a point of a regular grid, so that A also passes the sides of B. The grid
//!   spans the positions at which the two boxes, A's at any rotation, can overlap.
//!
//! Lines that do not lead to contact are dropped, so that each line gives a pose at every distance. Distances are
//! relative to the diagonal of A's box.

use crate::data::{Approach, MeshData};
use crate::rng::Rng;
use simdop::hierarchy::BvhRef;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::Query;

/// `[R|t]`.
pub(crate) type Rows = [[f64; 4]; 3];

/// A target distance of the bodies.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) enum Distance {
    /// A moves on by this share of the diagonal after first contact.
    Deep(f64),
    /// Gap between the bodies, relative to the diagonal.
    Gap(f64),
}

/// The presets, with their names. A gap of exactly zero is not attainable: 2e-5 is the paper's zero.
pub(crate) const DISTANCES: [(&str, Distance); 4] = [
    ("1 % deep", Distance::Deep(0.01)),
    ("0 %", Distance::Gap(2e-5)),
    ("1 %", Distance::Gap(0.01)),
    ("5 %", Distance::Gap(0.05)),
];

/// How lines are chosen.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Method {
    Sphere,
    Grid,
}

impl Method {
    pub(crate) const ALL: [Self; 2] = [Self::Sphere, Self::Grid];
}

/// Positions along a line are multiples of this share of the diagonal: 0.3 % of the smallest gap, and coarse enough
/// that a pose does not depend on the last bits of a distance.
const STEP: f64 = 1.0 / (1 << 24) as f64;

/// A pair of bodies, with trees for distance queries.
pub(crate) struct Approaching<'t> {
    pub(crate) a: &'t MeshData,
    pub(crate) b: &'t MeshData,
    pub(crate) tree_a: BvhRef<'t, Node16<18>>,
    pub(crate) tree_b: BvhRef<'t, Node16<18>>,
}

impl Approaching<'_> {
    /// The poses of `count` lines, each with its pose at each of the distances, nearest (or deepest) first.
    ///
    /// # Panics
    /// If most lines miss: then the bodies cannot touch.
    pub(crate) fn poses<const N: usize>(
        &self,
        distances: &[(&str, Distance); N],
        method: Method,
        count: usize,
        seed: u64,
    ) -> Vec<[Rows; N]> {
        let mut rng = Rng::new(seed);
        let mut poses = Vec::with_capacity(count);
        let mut lines = 0;
        while poses.len() < count {
            let batch = match method {
                Method::Sphere => vec![self.sphere_line(&mut rng)],
                Method::Grid => self.grid_lines(count, &mut rng),
            };
            lines += batch.len();
            let found = batch.iter().filter_map(|line| self.along(line, distances));
            poses.extend(found.take(count - poses.len()));
            assert!(lines <= 1000 * (poses.len() + 1), "no line of {lines} comes to a contact");
        }
        poses
    }

    fn line(&self, target: [f64; 3], towards: [f64; 3], rng: &mut Rng) -> Approach {
        Approach { rotation: rng.rotation(), target, towards, centre: self.a.centre() }
    }

    fn sphere_line(&self, rng: &mut Rng) -> Approach {
        let towards = rng.rotation()[0];
        self.line(self.b.centre(), towards, rng)
    }

    /// In random order, about twice as many as needed.
    fn grid_lines(&self, count: usize, rng: &mut Rng) -> Vec<Approach> {
        let (low, high) = self.b.bounds();
        let reach = 0.5 * self.a.diagonal();
        // Six directions, a square grid for each.
        let side = (count as f64 / 3.0).sqrt().ceil() as usize;
        let mut lines = Vec::new();
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                let at = |k: usize, cell: usize| {
                    let share = (cell as f64 + 0.5) / side as f64;
                    (low[k] - reach) + share * (high[k] - low[k] + 2.0 * reach)
                };
                let (mut target, mut towards) = (self.b.centre(), [0.0; 3]);
                (target[(axis + 1) % 3], target[(axis + 2) % 3]) =
                    (at((axis + 1) % 3, i), at((axis + 2) % 3, j));
                towards[axis] = sign;
                lines.push(self.line(target, towards, rng));
            }
        }
        for i in (1..lines.len()).rev() {
            lines.swap(i, rng.below(i as u64 + 1) as usize);
        }
        lines
    }

    /// The poses on a line, or `None` if it misses.
    fn along<const N: usize>(&self, line: &Approach, distances: &[(&str, Distance); N]) -> Option<[Rows; N]> {
        let far = 2.0 * (self.a.diagonal() + self.b.diagonal());
        let mut at = [line.at(far); N];
        let mut place = self.place(far);
        // From the largest gap to contact: each search continues where the last one ended.
        for i in (0..N).rev() {
            let (gap, depth) = match distances[i].1 {
                Distance::Gap(gap) => (gap, 0.0),
                Distance::Deep(depth) => (0.0, depth),
            };
            place = self.reach(line, place, gap * self.a.diagonal())?;
            at[i] = line.at(self.distance(place - self.place(depth * self.a.diagonal())));
        }
        Some(at)
    }

    fn distance(&self, place: i64) -> f64 {
        place as f64 * STEP * self.a.diagonal()
    }

    fn place(&self, distance: f64) -> i64 {
        (distance / (STEP * self.a.diagonal())) as i64
    }

    /// The last position, coming from `start`, at which the bodies are more than `gap` apart, up to 1/128 of the gap.
    ///
    /// No point moves farther than A's centre does, so a stride as long as the spare distance is safe. The last steps
    /// use bisection, since the spare distance shrinks slowly where A passes the side of B.
    fn reach(&self, line: &Approach, start: i64, gap: f64) -> Option<i64> {
        let query = Query::new(Isa::detect());
        let pose = |place: i64| Pose::from_rows(line.at(self.distance(place))).expect("rotations are rigid");
        let within = |place: i64, spare: i64| {
            let margin = gap + self.distance(spare);
            query
                .within(&self.tree_a, &self.tree_b, &pose(place), margin)
                .expect("margins are finite")
                .hit()
                .is_some()
        };
        let short = (self.place(gap) / 128).max(1);
        let (mut place, mut stride) = (start, 16 * short);
        while place > -start {
            // A rough distance is cheap, and sufficient while it is large.
            let rough = query.distance(&self.tree_a, &self.tree_b, &pose(place), 0.5).expect("a tolerance");
            let spare = self.place(rough.lower - gap);
            if spare > stride {
                place -= spare;
            } else if !within(place, stride) {
                place -= stride;
            } else if stride > short {
                stride /= 4;
            } else if let Some(inside) =
                [1, 4, 16].map(|n| place - n * short).into_iter().find(|&p| within(p, 0))
            {
                return Some(last_outside(place, inside, short, |place| within(place, 0)));
            } else {
                place -= 16 * short;
            }
        }
        None
    }
}

/// Bisects to an outside position at most `short` from an inside one.
fn last_outside(mut outside: i64, mut inside: i64, short: i64, is_inside: impl Fn(i64) -> bool) -> i64 {
    while outside - inside > short {
        let middle = inside + (outside - inside) / 2;
        if is_inside(middle) { inside = middle } else { outside = middle }
    }
    outside
}
