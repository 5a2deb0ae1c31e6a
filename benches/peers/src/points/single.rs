//! Queries one after another, in random order: within a radius, and the nearest.

use super::entrants::{LEAF, Radii, nanoflann};
use super::grid::{Grid, Kind, best_side};
use super::nanoflann::{Nanoflann, Queries};
use super::scenes::{self, Points, USUAL};
use super::{median, milliseconds, square};
use crate::Options;
use crate::rng::Rng;
use core::num::NonZeroUsize;
use core::ops::ControlFlow;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use serde::{Deserialize, Serialize};
use simdop::cloud::{self, Neighbour, PointCloud, RangeSearch, Seat};
use simdop::isa::Isa;

/// A library and a kind of query.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) table: String,
    pub(crate) scene: String,
    pub(crate) points: usize,
    pub(crate) what: String,
    pub(crate) library: String,
    /// Nanoseconds per query, the median of the rounds.
    pub(crate) ns: f64,
    /// Number of queries, and of wrong answers: the nearest points of the first [`SAMPLE`] queries are compared with
    /// brute force, all others with simdop.
    pub(crate) asked: usize,
    pub(crate) wrong: usize,
    pub(crate) build_ms: Option<f64>,
    pub(crate) bytes_per_point: Option<f64>,
    /// The sum of the answers: neighbours, or spheres that contain a point.
    pub(crate) sum: u64,
}

pub(crate) const ROUNDS: usize = 7;

/// Queries that are checked by brute force.
const SAMPLE: usize = 128;

const ASKED: usize = 20_000;

/// How many units in the last place squared distances may differ: kiddo fuses operations where the processor can.
const ROUNDINGS: u64 = 4;

type Answer<'a> = dyn FnMut(&mut [u64]) + 'a;

/// A way to answer: it returns a number for each query, which is compared.
pub(crate) struct Way<'a> {
    pub(crate) library: &'a str,
    pub(crate) answer: Box<Answer<'a>>,
}

/// Times the ways in turns, and compares their answers, which may be `off` apart, with those of the first one, which is
/// checked against brute force on its first queries.
pub(crate) fn compare(of: &Row, ways: Vec<Way<'_>>, truth: &[u64], off: u64, rows: &mut Vec<Row>) {
    let mut answers = vec![0; of.asked];
    let mut first: Vec<u64> = Vec::new();
    let mut timed: Vec<(Way<'_>, Vec<f64>, usize, u64)> = Vec::new();
    for mut way in ways {
        answers.fill(u64::MAX);
        (way.answer)(&mut answers);
        if first.is_empty() {
            assert!(answers.starts_with(truth), "{} is wrong: {}, {}", way.library, of.scene, of.what);
            first.clone_from(&answers);
        }
        let wrong = answers.iter().zip(&first).filter(|(a, b)| a.abs_diff(**b) > off).count();
        timed.push((way, Vec::new(), wrong, answers.iter().sum()));
    }
    for _ in 0..ROUNDS {
        for (way, times, ..) in &mut timed {
            times.push(milliseconds(|| (way.answer)(&mut answers)) * 1e6 / of.asked as f64);
        }
    }
    for (way, times, wrong, sum) in timed {
        rows.push(Row { library: way.library.to_owned(), ns: median(times), wrong, sum, ..of.clone() });
    }
}

pub(crate) fn row(table: &str, scene: &str, points: usize, what: &str, asked: usize) -> Row {
    Row {
        table: table.to_owned(),
        scene: scene.to_owned(),
        points,
        what: what.to_owned(),
        library: String::new(),
        ns: 0.0,
        asked,
        wrong: 0,
        build_ms: None,
        bytes_per_point: None,
        sum: 0,
    }
}

/// A cloud and its queries.
struct Scene {
    name: String,
    points: Points,
    queries: Points,
    radius: f32,
    ks: &'static [usize],
}

pub(crate) fn measure(options: &Options) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for scene in scenes(options)?.into_iter().filter(|scene| scene.points.len() <= options.most) {
        eprintln!("single: {}", scene.name);
        measure_scene(&scene, options, &mut rows);
    }
    Ok(rows)
}

fn scenes(options: &Options) -> Result<Vec<Scene>, String> {
    let mut rng = Rng::new(options.seed * 1000 + 40);
    let mut scenes = Vec::new();
    for count in [1000, 10_000, 131_072, 1_000_000] {
        let points = scenes::uniform(count.min(options.most), &mut rng);
        let (queries, radius) = (scenes::uniform(ASKED, &mut rng), scenes::radius(points.len(), USUAL));
        let ks: &[usize] = if count == 131_072 { &[1, 8, 30, 100] } else { &[1, 30] };
        scenes.push(Scene { name: "uniform, anywhere in it".to_owned(), points, queries, radius, ks });
    }
    let usual = 131_072.min(options.most);
    let (points, radius) = (scenes::uniform(usual, &mut rng), scenes::radius(usual, USUAL));
    let away = |point: [f32; 3]| point.map(|x| 3.0 + 4.0 * x);
    let queries: Points = scenes::uniform(ASKED, &mut rng).into_iter().map(away).collect();
    scenes.push(Scene { name: "uniform, far from it".to_owned(), points, queries, radius, ks: &[1, 30] });
    let points = scenes::clustered(usual, &mut rng);
    let queries = scenes::uniform(ASKED, &mut rng);
    scenes.push(Scene {
        name: "clusters, anywhere".to_owned(),
        points,
        queries,
        radius: 0.004,
        ks: &[1, 30],
    });
    let sweep = scenes::ply(&options.data.join("points/street_lidar_source.ply"))?;
    let queries = (0..ASKED)
        .map(|_| sweep[rng.below(sweep.len() as u64) as usize].map(|x| x + rng.range(-0.5, 0.5) as f32))
        .collect();
    scenes.push(Scene {
        name: "street_lidar_source, within 0.5 m of its points".to_owned(),
        points: sweep,
        queries,
        radius: 0.5,
        ks: &[1, 30],
    });
    Ok(scenes)
}

fn measure_scene(scene: &Scene, options: &Options, rows: &mut Vec<Row>) {
    let Scene { name, points, queries, radius, ks } = scene;
    let radius = *radius;
    let cloud = PointCloud::new(points).expect("the points are finite");
    let (view, search) = (cloud.view(), RangeSearch::new(Isa::detect()));
    let tree = ImmutableKdTree::new_from_slice(points).expect("kiddo builds it");
    let flann = nanoflann(&options.drivers).map(|driver| Nanoflann::build(&driver, points, LEAF));
    let order: Vec<u32> = (0..queries.len() as u32).collect();
    let asked = Queries { points: queries, order: &order };
    let radii = Radii::Same(radius);
    let grid = best_side(points, &radii, Kind::Dense).and_then(|side| Grid::new(points, side, Kind::Dense));

    let truth: Vec<u64> = queries[..SAMPLE]
        .iter()
        .map(|&at| points.iter().filter(|point| square(**point, at) <= radius * radius).count() as u64)
        .collect();
    let (mut seats, mut counts) = (vec![Seat::default(); queries.len()], vec![0; queries.len()]);
    let mut flann_counts = counts.clone();
    let mut ways = vec![
        Way {
            library: "simdop, one by one",
            answer: Box::new(|answers| {
                for (answer, query) in answers.iter_mut().zip(queries) {
                    let mut count = 0;
                    let visit = |_| {
                        count += 1;
                        ControlFlow::Continue(())
                    };
                    search.each_within(&view, *query, radius, visit).expect("the query is finite");
                    *answer = count;
                }
            }),
        },
        Way {
            library: "simdop, seated",
            answer: Box::new(|answers| {
                let seated = search.seat(&view, queries, &mut seats).expect("a seat for each");
                search
                    .count(&view, &seated, cloud::Radii::Same(radius), &mut counts)
                    .expect("a count for each");
                answers.iter_mut().zip(&counts).for_each(|(answer, count)| *answer = u64::from(*count));
            }),
        },
        Way {
            library: "kiddo",
            answer: Box::new(|answers| {
                let mut scratch = tree.create_scratch::<SquaredEuclidean<f32>>();
                for (answer, query) in answers.iter_mut().zip(queries) {
                    let mut count = 0;
                    let query = tree.query(query).within::<SquaredEuclidean<f32>>(radius * radius).unsorted();
                    query
                        .without_items()
                        .without_distances()
                        .with_scratch(&mut scratch)
                        .visit(|_| count += 1);
                    *answer = count;
                }
            }),
        },
    ];
    if let Some(flann) = &flann {
        ways.push(Way {
            library: "nanoflann",
            answer: Box::new(|answers| {
                flann.count(asked, &radii, &mut flann_counts);
                answers.iter_mut().zip(&flann_counts).for_each(|(answer, count)| *answer = u64::from(*count));
            }),
        });
    }
    if let Some(grid) = &grid {
        ways.push(Way {
            library: "grid, dense",
            answer: Box::new(|answers| {
                for (answer, query) in answers.iter_mut().zip(queries) {
                    *answer = u64::from(grid.count_one(*query, radius));
                }
            }),
        });
    }
    let of = row("single", name, points.len(), "count within the radius", queries.len());
    compare(&of, ways, &truth, 0, rows);

    for &k in *ks {
        let k = k.min(points.len());
        // The bits of the farthest one's squared distance: which of several equally far points is found is up to the
        // library.
        let truth: Vec<u64> = queries[..SAMPLE]
            .iter()
            .map(|&at| {
                let mut squares: Vec<f32> = points.iter().map(|point| square(*point, at)).collect();
                u64::from(squares.select_nth_unstable_by(k - 1, f32::total_cmp).1.to_bits())
            })
            .collect();
        let mut found = vec![Neighbour::NONE; k];
        let (mut indices, mut squares) = (vec![0; k * queries.len()], vec![0.0; k * queries.len()]);
        let mut ways = vec![
            Way {
                library: "simdop, one by one",
                answer: Box::new(|answers| {
                    for (answer, query) in answers.iter_mut().zip(queries) {
                        search.k_nearest(&view, *query, &mut found).expect("the query is finite");
                        *answer = u64::from(found[k - 1].square.to_bits());
                    }
                }),
            },
            Way {
                library: "kiddo",
                answer: Box::new(|answers| {
                    let mut scratch = tree.create_scratch::<SquaredEuclidean<f32>>();
                    for (answer, query) in answers.iter_mut().zip(queries) {
                        let query = tree.query(query);
                        *answer = if k == 1 {
                            let nearest = query.nearest_one::<SquaredEuclidean<f32>>();
                            u64::from(nearest.with_scratch(&mut scratch).execute().distance.to_bits())
                        } else {
                            let many = NonZeroUsize::new(k).expect("k is not 0");
                            let nearest = query.nearest_n::<SquaredEuclidean<f32>>(many);
                            let found = nearest.with_scratch(&mut scratch).execute();
                            u64::from(found[k - 1].distance.to_bits())
                        };
                    }
                }),
            },
        ];
        if let Some(flann) = &flann {
            ways.push(Way {
                library: "nanoflann",
                answer: Box::new(|answers| {
                    flann.nearest(asked, k, &mut indices, &mut squares);
                    for (answer, squares) in answers.iter_mut().zip(squares.chunks(k)) {
                        *answer = u64::from(squares[k - 1].to_bits());
                    }
                }),
            });
        }
        compare(
            &row("single", name, points.len(), &format!("the nearest {k}"), queries.len()),
            ways,
            &truth,
            ROUNDINGS,
            rows,
        );
    }
}
