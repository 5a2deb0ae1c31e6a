//! Whether any point is within a sphere, as planners query it: compared with capt, whose trees are built for a range of
//! radii.

use super::scenes::{self, Points};
use super::single::{Row, Way, compare, row};
use super::{
    entrants::Radii,
    grid::{Grid, Kind, best_side},
};
use super::{lent, median, milliseconds, square};
use crate::Options;
use crate::rng::Rng;
use capt::Capt;
use simdop::cloud::{PointCloud, RangeSearch};
use simdop::isa::Isa;
use std::collections::BTreeSet;

/// The range of radii of capt's trees, in metres: that of the spheres of robot arms.
const RANGE: (f32, f32) = (0.02, 0.2);

/// Spheres of a link, which are queried together.
const LINK: usize = 8;

const ASKED: usize = 40_000;

const TRUE: usize = 256;

#[derive(Copy, Clone)]
struct Sphere {
    centre: [f32; 3],
    radius: f32,
}

pub(crate) fn measure(options: &Options) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for name in ["street_lidar_source", "street_lidar_target"] {
        let sweep = scenes::ply(&options.data.join("points").join(name).with_extension("ply"))?;
        let seen: Points = sweep.iter().copied().filter(|point| *point != [0.0; 3]).collect();
        let thin = thinned(&seen);
        for (what, points) in
            [("as it is", sweep), ("(0, 0, 0) left out", seen), ("a point each 0.1 m", thin)]
        {
            if points.len() <= options.most {
                eprintln!("any: {name}, {what}");
                measure_sweep(&format!("{name}, {what}"), &points, options, &mut rows);
            }
        }
    }
    Ok(rows)
}

/// The first point in each cell of 0.1 m: clouds are thinned for planning with capt.
fn thinned(sweep: &Points) -> Points {
    let mut cells = BTreeSet::new();
    sweep.iter().copied().filter(|point| cells.insert(point.map(|x| (x * 10.0).floor() as i32))).collect()
}

/// Spheres in rows of [`LINK`], a radius apart. Each row is near a random point of the sweep, at a distance given by
/// `away`.
fn links(sweep: &Points, away: f64, radii: (f32, f32), rng: &mut Rng) -> Vec<Sphere> {
    let mut spheres = Vec::with_capacity(ASKED);
    while spheres.len() < ASKED {
        let from = sweep[rng.below(sweep.len() as u64) as usize].map(|x| x + rng.range(-away, away) as f32);
        let direction = rng.rotation()[0].map(|x| x as f32);
        let radius = rng.range(f64::from(radii.0), f64::from(radii.1)) as f32;
        spheres.extend((0..LINK).map(|i| Sphere {
            centre: core::array::from_fn(|axis| from[axis] + i as f32 * radius * direction[axis]),
            radius,
        }));
    }
    spheres
}

fn measure_sweep(name: &str, sweep: &Points, options: &Options, rows: &mut Vec<Row>) {
    let search = RangeSearch::new(Isa::detect());
    let (mut times, mut bytes) = ([const { Vec::new() }; 2], [0; 2]);
    let (mut cloud, mut tree) = (None, None);
    for _ in 0..5 {
        (cloud, tree) = (None, None);
        let before = lent();
        times[0].push(milliseconds(|| cloud = PointCloud::new(sweep).ok()));
        let between = lent();
        times[1].push(milliseconds(|| tree = Some(Capt::<3, f32, u32>::new(sweep, RANGE, LINK))));
        bytes = [between - before, lent() - between];
    }
    let (Some(cloud), Some(tree)) = (cloud, tree) else { return };
    let (view, [build_ms, capt_ms]) = (cloud.view(), times.map(median));
    let radii = Radii::Same(RANGE.1);
    let grid = best_side(sweep, &radii, Kind::Hashed).and_then(|side| Grid::new(sweep, side, Kind::Hashed));

    let mut rng = Rng::new(options.seed * 1000 + 50);
    for (what, away, range) in [
        ("within 0.1 m of its points, radii 0.02 to 0.2 m", 0.1, RANGE),
        ("within 1 m of its points, radii 0.02 to 0.2 m", 1.0, RANGE),
        ("within 10 m of its points, radii 0.02 to 0.2 m", 10.0, RANGE),
        ("within 1 m of its points, radii 0.2 to 1 m: beyond capt's range", 1.0, (0.2, 1.0)),
        ("within 10 m of its points, radii 1 to 5 m: beyond capt's range", 10.0, (1.0, 5.0)),
        ("within 0.01 m of its points, radii 0.001 to 0.02 m: below capt's range", 0.01, (0.001, 0.02)),
    ] {
        let spheres = &links(sweep, away, range, &mut rng);
        #[cfg(feature = "simd")]
        let lanes = in_lanes(spheres);
        let is_in = |sphere: &Sphere| {
            sweep.iter().any(|&p| square(p, sphere.centre) <= sphere.radius * sphere.radius)
        };
        let truth: Vec<u64> = spheres[..TRUE].iter().map(|sphere| u64::from(is_in(sphere))).collect();
        let any = |sphere: &Sphere| search.any_within(&view, sphere.centre, sphere.radius) == Ok(true);
        let mut ways = vec![
            Way {
                library: "simdop",
                answer: Box::new(|answers| {
                    for (answer, sphere) in answers.iter_mut().zip(spheres) {
                        *answer = u64::from(any(sphere));
                    }
                }),
            },
            Way {
                library: "capt",
                answer: Box::new(|answers| {
                    for (answer, sphere) in answers.iter_mut().zip(spheres) {
                        *answer = u64::from(tree.collides(&sphere.centre, sphere.radius));
                    }
                }),
            },
        ];
        if let Some(grid) = &grid {
            ways.push(Way {
                library: "grid, hashed",
                answer: Box::new(|answers| {
                    for (answer, sphere) in answers.iter_mut().zip(spheres) {
                        *answer = u64::from(grid.any_within(sphere.centre, sphere.radius));
                    }
                }),
            });
        }
        let from = rows.len();
        compare(
            &row("any", name, sweep.len(), &format!("a sphere {what}"), spheres.len()),
            ways,
            &truth,
            0,
            rows,
        );

        let truth: Vec<u64> = truth.chunks(LINK).map(|link| u64::from(link.contains(&1))).collect();
        #[cfg_attr(
            not(feature = "simd"),
            expect(unused_mut, reason = "capt's SIMD needs an unstable compiler")
        )]
        let mut ways = vec![
            Way {
                library: "simdop",
                answer: Box::new(|answers| {
                    for (answer, link) in answers.iter_mut().zip(spheres.chunks(LINK)) {
                        *answer = u64::from(link.iter().any(any));
                    }
                }),
            },
            Way {
                library: "capt",
                answer: Box::new(|answers| {
                    for (answer, link) in answers.iter_mut().zip(spheres.chunks(LINK)) {
                        *answer = u64::from(link.iter().any(|s| tree.collides(&s.centre, s.radius)));
                    }
                }),
            },
        ];
        #[cfg(feature = "simd")]
        ways.push(Way {
            library: "capt, SIMD",
            answer: Box::new(|answers| {
                for (answer, (centres, radii)) in answers.iter_mut().zip(&lanes) {
                    *answer = u64::from(tree.collides_simd(centres, *radii));
                }
            }),
        });
        let of =
            row("any", name, sweep.len(), &format!("any of {LINK} spheres {what}"), spheres.len() / LINK);
        compare(&of, ways, &truth, 0, rows);
        for row in &mut rows[from..] {
            let per_point = |bytes: usize| Some(bytes as f64 / sweep.len() as f64);
            match row.library.as_str() {
                "simdop" => (row.build_ms, row.bytes_per_point) = (Some(build_ms), per_point(bytes[0])),
                "grid, hashed" => {}
                _ => (row.build_ms, row.bytes_per_point) = (Some(capt_ms), per_point(bytes[1])),
            }
        }
    }
}

#[cfg(feature = "simd")]
type Lanes = std::simd::Simd<f32, LINK>;

/// In the form that capt takes, and in which a planner would store them.
#[cfg(feature = "simd")]
fn in_lanes(spheres: &[Sphere]) -> Vec<([Lanes; 3], Lanes)> {
    let lanes = |link: &[Sphere]| {
        let centres =
            core::array::from_fn(|axis| Lanes::from_array(core::array::from_fn(|i| link[i].centre[axis])));
        (centres, Lanes::from_array(core::array::from_fn(|i| link[i].radius)))
    };
    spheres.chunks(LINK).map(lanes).collect()
}
