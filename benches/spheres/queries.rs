//! The BNG paper's figure 10: time of a query along a path, by the division of the spheres; and whether weighting by
//! volume helps.

use super::all_pairs::{Shared, by_all_pairs};
use super::heuristics::Heuristic;
use super::models::{Model, path};
use crate::short::count;
use core::ops::ControlFlow;
use simdop::construct::{Builder, Magnification, SphereSet, Splitter};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Completion, Lanes, Query, QueryStats};
use std::hint::black_box;
use std::time::Instant;

/// Number of poses of a path.
const POSES: usize = 400;
/// Passes of each tree along a path, of which the minimum counts for each pose: limited by the total number of spheres,
/// and clamped to this range.
const RUNS: core::ops::RangeInclusive<usize> = 5..=25;
const SPHERES_OF_ALL_RUNS: usize = 100_000;
/// Number of random starts of Batch Neural Gas, to distinguish the effect of weights from chance.
const SEEDS: usize = 10;
/// Maximum number of pairs of spheres tested by brute force for a pair of bodies; at least one pose is tested.
const PAIRS: usize = 2_000_000_000;

/// The division of a node's spheres.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) enum Division {
    Splitter(Splitter),
    /// By the default splitter, and trees without balls.
    KDops,
    Heuristic(Heuristic),
}

/// The divisions compared, the first with all others.
pub(crate) const DIVISIONS: [Division; 6] = [
    gas(Magnification::Area, 0),
    gas(Magnification::None, 0),
    Division::Heuristic(Heuristic::Biggest),
    Division::Heuristic(Heuristic::Extremes),
    Division::Splitter(Splitter::MeanWidth),
    Division::KDops,
];

const fn gas(magnification: Magnification, seed: u32) -> Division {
    Division::Splitter(Splitter::BatchNeuralGas { magnification, seed })
}

impl Division {
    fn name(self, arity: usize) -> &'static str {
        match self {
            Self::Splitter(Splitter::BatchNeuralGas { magnification: Magnification::Area, .. }) => {
                "neural gas by volume"
            }
            Self::Splitter(Splitter::BatchNeuralGas { .. }) => "neural gas",
            Self::Splitter(_) => "mean width",
            Self::KDops => "mean width, without balls",
            Self::Heuristic(Heuristic::Biggest) if arity == 4 => "four biggest",
            Self::Heuristic(Heuristic::Biggest) => "sixteen biggest",
            Self::Heuristic(Heuristic::Extremes) if arity == 4 => "extremes on two axes",
            Self::Heuristic(Heuristic::Extremes) => "extremes on two axes, twice",
        }
    }

    /// The tree, and the number of nodes that could not be divided in this way.
    fn build<N: Lanes>(self, spheres: &[Sphere]) -> (Bvh<N, Spheres>, usize) {
        let set = SphereSet { spheres };
        match self {
            Self::Splitter(splitter) => {
                let builder = Builder::new().splitter(splitter);
                (builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap(), 0)
            }
            Self::KDops => {
                let builder = Builder::new().without_balls();
                (builder.build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap(), 0)
            }
            Self::Heuristic(heuristic) => {
                let shape = heuristic.shape(spheres, N::ARITY);
                (Builder::new().build_assigned(&set, &shape.assignment).unwrap(), shape.balanced)
            }
        }
    }
}

/// Two bodies and a path of the first through the second.
pub(crate) struct Scene<'m> {
    a: &'m Model,
    b: &'m Model,
    size: usize,
    poses: Vec<Pose>,
    /// The shared volume and pairs at each pose.
    shared: Vec<Shared>,
}

/// The cost of a query.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Cost {
    /// Times in microseconds.
    pub(crate) mean: f64,
    pub(crate) median: f64,
    pub(crate) p99: f64,
    /// The mean work.
    pub(crate) work: Work,
}

/// Counted: the same on every machine.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Work {
    pub(crate) visits: f64,
    pub(crate) kernels: f64,
    pub(crate) pairs: f64,
}

/// One scene, number of spheres, arity, and division.
pub(crate) struct Row {
    pub(crate) scene: String,
    pub(crate) spheres: usize,
    pub(crate) arity: usize,
    pub(crate) division: &'static str,
    /// Number of nodes of both trees.
    pub(crate) nodes: usize,
    pub(crate) depth: u32,
    pub(crate) balanced: usize,
    pub(crate) volume: Cost,
    pub(crate) verdict: Cost,
}

/// The effect of weights on the work of a query, as ratios of work with to without, over the seeds.
pub(crate) struct Weights {
    pub(crate) scene: String,
    pub(crate) spheres: usize,
    pub(crate) arity: usize,
    pub(crate) volume: [Spread; 3],
    pub(crate) verdict: [Spread; 3],
}

#[derive(Copy, Clone, Debug)]
pub(crate) struct Spread {
    pub(crate) mean: f64,
    pub(crate) least: f64,
    pub(crate) most: f64,
}

impl<'m> Scene<'m> {
    /// Both bodies with their first `size` spheres. The expected answers come from the default's trees; those of some
    /// poses are compared with the sum over all pairs.
    pub(crate) fn new(a: &'m Model, b: &'m Model, size: usize) -> Self {
        let poses = path(a, b, count(POSES, 23));
        let mut scene = Self { a, b, size, poses, shared: Vec::new() };
        let trees = scene.trees::<Node16<18>>(Division::Splitter(Splitter::default())).0;
        scene.shared = scene.poses.iter().map(|pose| shared(&trees, pose).0).collect();
        scene.check();
        scene
    }

    pub(crate) fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// The trees of both bodies.
    pub(crate) fn trees_of(&self, splitter: Splitter) -> [Bvh<Node16<18>, Spheres>; 2] {
        self.trees(Division::Splitter(splitter)).0
    }

    fn name(&self) -> String {
        format!("{} in {}", self.a.name, self.b.name)
    }

    fn spheres(&self) -> [&'m [Sphere]; 2] {
        [self.a, self.b].map(|model| &model.spheres[..self.size])
    }

    fn trees<N: Lanes>(&self, division: Division) -> ([Bvh<N, Spheres>; 2], usize) {
        let [(a, of_a), (b, of_b)] = self.spheres().map(|spheres| division.build(spheres));
        ([a, b], of_a + of_b)
    }

    /// Checks the deepest pose, and as many more as time allows.
    fn check(&self) {
        let deepest = (0..self.poses.len()).max_by(|&i, &j| {
            let volume = |i: usize| self.shared[i].volume;
            volume(i).total_cmp(&volume(j))
        });
        let step = self.poses.len().div_ceil((PAIRS / (self.size * self.size)).max(1));
        let others = (step / 2..self.poses.len()).step_by(step).filter(|_| step < self.poses.len());
        for i in deepest.into_iter().chain(others) {
            let want = by_all_pairs(self.spheres(), &self.poses[i]);
            let got = self.shared[i];
            assert!((got.volume - want.volume).abs() <= 1e-9 * want.volume, "{got:?}, not {want:?}");
            assert_eq!(got.pairs, want.pairs, "{}", self.name());
        }
    }

    /// Describes the path.
    pub(crate) fn describe(&self) -> String {
        let meet = self.shared.iter().filter(|shared| shared.pairs > 0).count();
        let deepest = self.shared.iter().map(|shared| shared.volume).fold(0.0, f64::max);
        let volume = |model: &Model| {
            let cubes = model.spheres[..self.size].iter().map(|s| s.radius * s.radius * s.radius);
            4.0 / 3.0 * core::f64::consts::PI * cubes.sum::<f64>()
        };
        let smaller = f64::min(volume(self.a), volume(self.b));
        let pairs = self.shared.iter().map(|shared| shared.pairs).sum::<u64>() / self.poses.len() as u64;
        format!(
            "{}, {} spheres each: {} poses, the two meet at {:.0} %, share at most {:.0} % of the smaller packing, \
             and {pairs} pairs of spheres in the mean",
            self.name(),
            self.size,
            self.poses.len(),
            100.0 * meet as f64 / self.poses.len() as f64,
            100.0 * deepest / smaller,
        )
    }

    pub(crate) fn measure(&self, rows: &mut Vec<Row>) {
        self.measure_arity::<Node4<18>>(rows);
        self.measure_arity::<Node16<18>>(rows);
    }

    fn measure_arity<N: Lanes>(&self, rows: &mut Vec<Row>) {
        eprintln!("{}, {} spheres, arity {}: queries", self.name(), self.size, N::ARITY);
        let built = DIVISIONS.map(|division| self.trees::<N>(division));
        // Before timing: every answer of every tree, and its work.
        let work = built.each_ref().map(|(trees, _)| self.work(trees));
        let mut times = vec![
            [vec![f64::INFINITY; self.poses.len()], vec![f64::INFINITY; self.poses.len()]];
            DIVISIONS.len()
        ];
        let query = Query::new(Isa::detect());
        let runs = (SPHERES_OF_ALL_RUNS / self.size).clamp(*RUNS.start(), *RUNS.end());
        for _ in 0..count(runs, 1) {
            for ((trees, _), [volume, verdict]) in built.iter().zip(&mut times) {
                let [a, b] = trees.each_ref().map(Bvh::view);
                timed(&self.poses, volume, |pose| query.penetration(&a, &b, pose).volume);
                timed(&self.poses, verdict, |pose| query.collide(&a, &b, pose).is_free());
            }
        }
        for (((division, (trees, balanced)), work), times) in
            DIVISIONS.iter().zip(&built).zip(work).zip(times)
        {
            let [volume, verdict] = times;
            let headers = trees.each_ref().map(|tree| *tree.view().header());
            rows.push(Row {
                scene: self.name(),
                spheres: self.size,
                arity: N::ARITY,
                division: division.name(N::ARITY),
                nodes: headers.iter().map(|header| header.node_count as usize).sum(),
                depth: headers.iter().map(|header| header.depth).max().unwrap(),
                balanced: *balanced,
                volume: Cost::of(volume, work[0]),
                verdict: Cost::of(verdict, work[1]),
            });
        }
    }

    /// Mean work of the query for the volume and of the query for yes or no.
    ///
    /// # Panics
    /// If an answer differs in any bit from that of the other trees.
    fn work<N: Lanes>(&self, trees: &[Bvh<N, Spheres>; 2]) -> [Work; 2] {
        let mut stats = [Vec::new(), Vec::new()];
        for (pose, want) in self.poses.iter().zip(&self.shared) {
            let (got, work) = shared(trees, pose);
            assert!(
                got.volume.to_bits() == want.volume.to_bits() && got.pairs == want.pairs,
                "{got:?} {want:?}"
            );
            stats[0].push(work);
            let verdict = Query::new(Isa::detect()).collide(&trees[0], &trees[1], pose);
            assert_eq!(verdict.is_free(), want.pairs == 0, "{}", self.name());
            stats[1].push(verdict.stats);
        }
        stats.map(|stats| Work::of(&stats))
    }

    pub(crate) fn weights(&self, rows: &mut Vec<Weights>) {
        rows.push(self.weights_of_arity::<Node4<18>>());
        rows.push(self.weights_of_arity::<Node16<18>>());
    }

    fn weights_of_arity<N: Lanes>(&self) -> Weights {
        eprintln!("{}, {} spheres, arity {}: weights", self.name(), self.size, N::ARITY);
        let works = |magnification| -> Vec<[Work; 2]> {
            let seeds = 0..count(SEEDS, 2) as u32;
            seeds.map(|seed| self.work(&self.trees::<N>(gas(magnification, seed)).0)).collect()
        };
        let (with, without) = (works(Magnification::Area), works(Magnification::None));
        let ratios = |query: usize| {
            [|work: &Work| work.visits, |work: &Work| work.kernels, |work: &Work| work.pairs].map(|of| {
                // Relative to the mean over seeds: pairing individual seeds is meaningless.
                let mean = without.iter().map(|work| of(&work[query])).sum::<f64>() / without.len() as f64;
                Spread::of(with.iter().map(|work| of(&work[query]) / mean).collect())
            })
        };
        Weights {
            scene: self.name(),
            spheres: self.size,
            arity: N::ARITY,
            volume: ratios(0),
            verdict: ratios(1),
        }
    }
}

fn shared<N: Lanes>([a, b]: &[Bvh<N, Spheres>; 2], pose: &Pose) -> (Shared, QueryStats) {
    let found = Query::new(Isa::detect()).penetration(a, b, pose);
    assert_eq!(found.completion, Completion::Complete);
    (Shared { volume: found.volume, pairs: found.pairs }, found.stats)
}

/// Queries the poses in the order of the path; the minimum time of each counts.
fn timed<T>(poses: &[Pose], times: &mut [f64], query: impl Fn(&Pose) -> T) {
    for (pose, time) in poses.iter().zip(times) {
        let start = Instant::now();
        let _ = black_box(query(black_box(pose)));
        *time = time.min(start.elapsed().as_secs_f64());
    }
}

impl Cost {
    fn of(mut seconds: Vec<f64>, work: Work) -> Self {
        seconds.sort_by(f64::total_cmp);
        let at = |percent: usize| 1e6 * seconds[(seconds.len() * percent / 100).min(seconds.len() - 1)];
        let mean = 1e6 * seconds.iter().sum::<f64>() / seconds.len() as f64;
        Self { mean, median: at(50), p99: at(99), work }
    }
}

impl Work {
    fn of(stats: &[QueryStats]) -> Self {
        let mean = |of: fn(&QueryStats) -> u64| stats.iter().map(of).sum::<u64>() as f64 / stats.len() as f64;
        Self { visits: mean(|c| c.visits), kernels: mean(|c| c.kernels), pairs: mean(|c| c.primitive_pairs) }
    }
}

impl Spread {
    fn of(numbers: Vec<f64>) -> Self {
        Self {
            mean: numbers.iter().sum::<f64>() / numbers.len() as f64,
            least: numbers.iter().copied().fold(f64::INFINITY, f64::min),
            most: numbers.iter().copied().fold(0.0, f64::max),
        }
    }
}
