//! Single queries.

use crate::data::by_suite;
use crate::scenes::{self, Random, brute, square};
use core::ops::ControlFlow;
use simdop::cloud::{Neighbour, PointCloud, RangeSearch, SearchError};
use simdop::isa::Isa;

/// Points of the cloud, points between them, and points far outside.
fn queries(points: &[[f32; 3]], count: usize) -> Vec<[f32; 3]> {
    let random = &mut Random(21);
    let pick =
        |random: &mut Random| points[((random.next() * points.len() as f32) as usize).min(points.len() - 1)];
    (0..count)
        .map(|i| {
            let (p, q) = (pick(random), pick(random));
            match i % 3 {
                0 => p,
                1 => [0, 1, 2].map(|k| 0.5 * p[k] + 0.5 * q[k]),
                _ => [0, 1, 2].map(|k| if i % 2 == 0 { p[k] * 0.25 } else { p[k] / 2.0 + q[k] / 3.0 }),
            }
        })
        .collect()
}

#[test]
fn what_is_within_is_what_a_loop_finds() {
    for (name, points, radii) in scenes::all(by_suite(1200, 150)) {
        let cloud = PointCloud::new(&points).unwrap();
        for (i, &query) in queries(&points, by_suite(300, 40)).iter().enumerate() {
            let radius = radii[i % radii.len()];
            let want = brute(&points, query, radius);
            for isa in Isa::available() {
                let search = RangeSearch::new(isa);
                let any = search.any_within(&cloud.view(), query, radius).unwrap();
                assert_eq!(any, !want.is_empty(), "{name}, {isa}, query {i}");
                let mut found = Vec::new();
                let visit = |index| {
                    found.push(index);
                    ControlFlow::Continue(())
                };
                let work = search.each_within(&cloud.view(), query, radius, visit).unwrap();
                assert_eq!(work.neighbours, want.len() as u64);
                found.sort_unstable();
                assert_eq!(found, want, "{name}, {isa}, query {i}");
            }
        }
    }
}

#[test]
fn the_nearest_are_the_first_of_all_in_order() {
    for (name, points, _) in scenes::all(by_suite(900, 120)) {
        let cloud = PointCloud::new(&points).unwrap();
        for (i, &query) in queries(&points, by_suite(150, 30)).iter().enumerate() {
            let mut all: Vec<_> = (0..).zip(&points).map(|(index, p)| (square(query, *p), index)).collect();
            all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for isa in Isa::available() {
                let search = RangeSearch::new(isa);
                for k in [0, 1, 2, 7, 40, points.len(), points.len() + 3] {
                    let mut found = vec![Neighbour::NONE; k];
                    let count = search.k_nearest(&cloud.view(), query, &mut found).unwrap();
                    assert_eq!(count, k.min(points.len()));
                    let found: Vec<_> = found[..count].iter().map(|n| (n.square, n.index)).collect();
                    assert!(found == all[..count], "{name}, {isa}, query {i}, k = {k}");
                }
                let nearest = search.nearest(&cloud.view(), query).unwrap().unwrap();
                assert_eq!((nearest.square, nearest.index), all[0], "{name}, {isa}, query {i}");
            }
        }
    }
}

#[test]
fn an_empty_cloud_has_nothing_near() {
    let cloud = PointCloud::new(&[]).unwrap();
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        assert_eq!(search.nearest(&cloud.view(), [0.0; 3]), Ok(None));
        assert_eq!(search.any_within(&cloud.view(), [0.0; 3], f32::MAX), Ok(false));
    }
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let cloud = PointCloud::new(&[[0.0; 3]]).unwrap();
    let (view, search) = (cloud.view(), RangeSearch::new(Isa::SCALAR));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let query = [0.0, 0.0, bad];
        assert_eq!(search.any_within(&view, query, 1.0), Err(SearchError::Query { query: 0 }));
        assert_eq!(search.nearest(&view, query), Err(SearchError::Query { query: 0 }));
        assert_eq!(search.k_nearest(&view, query, &mut []), Err(SearchError::Query { query: 0 }));
        let visit = |_| ControlFlow::Continue(());
        assert_eq!(search.each_within(&view, query, 1.0, visit), Err(SearchError::Query { query: 0 }));
        assert_eq!(search.any_within(&view, [0.0; 3], bad), Err(SearchError::Radius { query: 0 }));
    }
    assert_eq!(search.any_within(&view, [0.0; 3], -0.5), Err(SearchError::Radius { query: 0 }));
    assert_eq!(search.any_within(&view, [0.0; 3], -0.0), Ok(true));
}
