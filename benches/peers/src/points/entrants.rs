//! The libraries compared, each with points, its tree, and queries at its own points.

use super::grid::{Grid, Kind, best_side};
use super::nanoflann::{self, Nanoflann};
use kiddo::{ImmutableKdTree, MutableKdTree, PairQueryResult, SquaredEuclidean};
use simdop::cloud::{self, PointCloud, RangeSearch};
use simdop::isa::Isa;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The search radius of each point.
pub(crate) enum Radii {
    Same(f32),
    Each(Vec<f32>),
}

impl Radii {
    #[inline]
    pub(crate) fn of(&self, query: u32) -> f32 {
        match self {
            Self::Same(radius) => *radius,
            Self::Each(radii) => radii[query as usize],
        }
    }

    /// The radii, and the stride from one query to the next.
    pub(crate) fn strided(&self, queries: usize) -> (&[f32], usize) {
        match self {
            Self::Same(radius) => (core::slice::from_ref(radius), 0),
            Self::Each(radii) => {
                assert!(radii.len() >= queries, "a radius for each query");
                (radii, 1)
            }
        }
    }

    fn ours(&self) -> cloud::Radii<'_> {
        match self {
            Self::Same(radius) => cloud::Radii::Same(*radius),
            Self::Each(radii) => cloud::Radii::Each(radii),
        }
    }
}

/// The place of a query's neighbours.
#[repr(C)]
#[derive(Copy, Clone, Default)]
pub(crate) struct List {
    pub(crate) start: u32,
    pub(crate) count: u32,
}

/// Memory for the neighbours of all points. Libraries that answer in pairs or in simdop's lists use their own.
#[derive(Default)]
pub(crate) struct Lists {
    pub(crate) lists: Vec<List>,
    pub(crate) indices: Vec<u32>,
    ours: Vec<cloud::List>,
    pairs: Vec<PairQueryResult<u32, u32, ()>>,
}

impl Lists {
    /// Room for this many points and neighbours.
    pub(crate) fn new(points: usize, neighbours: usize) -> Self {
        Self {
            lists: vec![List::default(); points],
            indices: vec![0; neighbours],
            ours: vec![cloud::List::default(); points],
            pairs: Vec::new(),
        }
    }

    /// The neighbours of these queries, sorted.
    pub(crate) fn sets(&self, filled: Filled, queries: &[u32]) -> Vec<Vec<u32>> {
        let mut sets: Vec<Vec<u32>> = match filled {
            Filled::Lists => {
                let list = |&query: &u32| {
                    let List { start, count } = self.lists[query as usize];
                    self.indices[start as usize..][..count as usize].to_vec()
                };
                queries.iter().map(list).collect()
            }
            Filled::Ours => {
                queries.iter().map(|&q| self.indices[self.ours[q as usize].range()].to_vec()).collect()
            }
            Filled::Pairs => {
                let mut sets = vec![Vec::new(); queries.len()];
                for pair in &self.pairs {
                    if let Ok(place) = queries.binary_search(&pair.left_item) {
                        sets[place].push(pair.right_item);
                    }
                }
                sets
            }
        };
        sets.iter_mut().for_each(|set| set.sort_unstable());
        sets
    }
}

/// Where `Built::fill` stored them.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(crate) enum Filled {
    Lists,
    Ours,
    Pairs,
}

/// `None` if the library does not support these points or radii.
type Build = dyn Fn(&[[f32; 3]], &Radii) -> Option<Box<dyn Built>>;
type Prepare = dyn Fn(&[[f32; 3]], &Radii);

/// A library, ready to build.
pub(crate) struct Entrant {
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) build: Box<Build>,
    /// Work before anything is timed.
    pub(crate) prepare: Box<Prepare>,
}

/// A library's structure over points.
pub(crate) trait Built {
    /// Called once before the first query, and not timed.
    fn ready(&mut self, _points: &[[f32; 3]]) {}
    fn count(&mut self, points: &[[f32; 3]], radii: &Radii, counts: &mut [u32]);
    fn fill(&mut self, points: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled;
    /// Moves the points to new positions; returns whether the library supports this.
    fn refit(&mut self, _points: &[[f32; 3]]) -> bool {
        false
    }
}

struct Ours {
    cloud: PointCloud,
    search: RangeSearch,
}

impl Built for Ours {
    fn count(&mut self, _: &[[f32; 3]], radii: &Radii, counts: &mut [u32]) {
        let own = cloud::Queries::own();
        self.search
            .count(&self.cloud.view(), &own, radii.ours(), counts)
            .expect("the queries are the points");
    }

    fn fill(&mut self, _: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled {
        let own = cloud::Queries::own();
        let filled =
            self.search.fill(&self.cloud.view(), &own, radii.ours(), &mut lists.ours, &mut lists.indices);
        filled.expect("there is room");
        Filled::Ours
    }

    fn refit(&mut self, points: &[[f32; 3]]) -> bool {
        self.cloud.refit(points).expect("the points are finite");
        true
    }
}

/// The points in the order of the leaves, which is the best order for queries one after another.
macro_rules! kiddo {
    ($name:ident, $tree:ty) => {
        struct $name {
            tree: $tree,
            order: Vec<(u32, [f32; 3])>,
        }

        impl $name {
            fn build(points: &[[f32; 3]], _: &Radii) -> Option<Box<dyn Built>> {
                Some(Box::new(Self { tree: <$tree>::new_from_slice(points).ok()?, order: Vec::new() }))
            }
        }

        impl Built for $name {
            fn ready(&mut self, _: &[[f32; 3]]) {
                self.order = self.tree.iter().collect();
            }

            fn count(&mut self, _: &[[f32; 3]], radii: &Radii, counts: &mut [u32]) {
                let mut scratch = self.tree.create_scratch::<SquaredEuclidean<f32>>();
                for (index, point) in &self.order {
                    let (radius, mut count) = (radii.of(*index), 0);
                    let query =
                        self.tree.query(point).within::<SquaredEuclidean<f32>>(radius * radius).unsorted();
                    query
                        .without_items()
                        .without_distances()
                        .with_scratch(&mut scratch)
                        .visit(|_| count += 1);
                    counts[*index as usize] = count;
                }
            }

            fn fill(&mut self, _: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled {
                let mut scratch = self.tree.create_scratch::<SquaredEuclidean<f32>>();
                let mut end = 0;
                for (index, point) in &self.order {
                    let (radius, start) = (radii.of(*index), end);
                    let query =
                        self.tree.query(point).within::<SquaredEuclidean<f32>>(radius * radius).unsorted();
                    query.without_distances().with_scratch(&mut scratch).visit(|found| {
                        lists.indices[end] = found.item;
                        end += 1;
                    });
                    lists.lists[*index as usize] = List { start: start as u32, count: (end - start) as u32 };
                }
                Filled::Lists
            }
        }
    };
}

kiddo!(Kiddo, ImmutableKdTree<f32, 3>);
kiddo!(KiddoMutable, MutableKdTree<f32, 3>);

/// Two trees of the same points, which kiddo joins: all pairs within one radius. kiddo requires two trees.
struct KiddoJoin {
    trees: [ImmutableKdTree<f32, 3>; 2],
}

impl Built for KiddoJoin {
    fn count(&mut self, _: &[[f32; 3]], radii: &Radii, counts: &mut [u32]) {
        let Radii::Same(radius) = radii else { unreachable!("joins have one radius") };
        // The callback may run on several threads, so counts are atomic; on one thread these are plain additions.
        let found: Vec<AtomicU32> = counts.iter().map(|_| AtomicU32::new(0)).collect();
        let join = self.trees[0].query_tree(&self.trees[1]).within::<SquaredEuclidean<f32>>(radius * radius);
        join.without_distances().for_each(|pair| {
            let count = &found[pair.left_item as usize];
            count.store(count.load(Relaxed) + 1, Relaxed);
        });
        for (count, found) in counts.iter_mut().zip(&found) {
            *count = found.load(Relaxed);
        }
    }

    fn fill(&mut self, _: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled {
        let Radii::Same(radius) = radii else { unreachable!("joins have one radius") };
        let join = self.trees[0].query_tree(&self.trees[1]).within::<SquaredEuclidean<f32>>(radius * radius);
        lists.pairs = join.without_distances().execute();
        Filled::Pairs
    }
}

struct Flann {
    cloud: nanoflann::PointCloud,
    order: Vec<u32>,
}

impl Built for Flann {
    fn ready(&mut self, _: &[[f32; 3]]) {
        self.order = self.cloud.order();
    }

    fn count(&mut self, points: &[[f32; 3]], radii: &Radii, counts: &mut [u32]) {
        self.cloud.count(nanoflann::Queries { points, order: &self.order }, radii, counts);
    }

    fn fill(&mut self, points: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled {
        self.cloud.fill(nanoflann::Queries { points, order: &self.order }, radii, lists);
        Filled::Lists
    }
}

impl Built for Grid {
    fn count(&mut self, _: &[[f32; 3]], radii: &Radii, counts: &mut [u32]) {
        Self::count(self, radii, counts);
    }

    fn fill(&mut self, _: &[[f32; 3]], radii: &Radii, lists: &mut Lists) -> Filled {
        Self::fill(self, radii, lists);
        Filled::Lists
    }
}

fn grid(kind: Kind) -> Entrant {
    let side = Rc::new(std::cell::Cell::new(None));
    let kept = Rc::clone(&side);
    Entrant {
        name: format!("grid, {}", if kind == Kind::Dense { "dense" } else { "hashed" }),
        version: "this package's".to_owned(),
        prepare: Box::new(move |points, radii| kept.set(best_side(points, radii, kind))),
        build: Box::new(move |points, _| Some(Box::new(Grid::new(points, side.get()?, kind)?))),
    }
}

/// Points per leaf of nanoflann: the fastest here of 10 (its default), 16, 24 and 32.
pub(crate) const LEAF: usize = 16;

/// The version in this package's lock file.
fn locked(package: &str) -> String {
    let lock = include_str!("../../Cargo.lock");
    let mut lines = lock.lines().skip_while(|line| *line != format!("name = \"{package}\""));
    let version = lines.nth(1).and_then(|line| line.strip_prefix("version = "));
    version.unwrap_or("unknown").trim_matches('"').to_owned()
}

pub(crate) fn nanoflann(drivers: &Path) -> Option<Rc<Nanoflann>> {
    match Nanoflann::load(&drivers.join("nanoflann.so")) {
        Ok(driver) => Some(Rc::new(driver)),
        Err(problem) => {
            eprintln!("*** nanoflann is left out: {problem} ***");
            None
        }
    }
}

pub(crate) fn capt_version() -> String {
    locked("capt")
}

pub(crate) fn entrants(drivers: &Path) -> Vec<Entrant> {
    let search = RangeSearch::new(Isa::detect());
    let nothing = || -> Box<Prepare> { Box::new(|_, _| ()) };
    let entrant = |name: &str, version: &str, build| Entrant {
        name: name.to_owned(),
        version: version.to_owned(),
        build,
        prepare: nothing(),
    };
    let ours = move |points: &[[f32; 3]], _: &Radii| -> Option<Box<dyn Built>> {
        Some(Box::new(Ours { cloud: PointCloud::new(points).expect("the points are finite"), search }))
    };
    let join = |points: &[[f32; 3]], radii: &Radii| -> Option<Box<dyn Built>> {
        let Radii::Same(_) = radii else { return None };
        let tree = || ImmutableKdTree::new_from_slice(points).ok();
        Some(Box::new(KiddoJoin { trees: [tree()?, tree()?] }))
    };
    let version = locked("kiddo");
    let mut all = vec![
        entrant("simdop", &Isa::detect().to_string(), Box::new(ours)),
        entrant("kiddo", &version, Box::new(Kiddo::build)),
        entrant("kiddo mutable", &version, Box::new(KiddoMutable::build)),
        entrant("kiddo join", &version, Box::new(join)),
    ];
    if let Some(driver) = nanoflann(drivers) {
        let version = driver.version();
        let build = move |points: &[[f32; 3]], _: &Radii| -> Option<Box<dyn Built>> {
            Some(Box::new(Flann { cloud: Nanoflann::build(&driver, points, LEAF), order: Vec::new() }))
        };
        all.push(entrant("nanoflann", &version, Box::new(build)));
    }
    all.push(grid(Kind::Dense));
    all.push(grid(Kind::Hashed));
    all
}
