//! Lists, counts and visits of all neighbours.

use crate::data::by_suite;
use crate::scenes::{self, Random, brute};
use core::ops::ControlFlow;
use simdop::cloud::{CloudRef, List, PointCloud, Queries, Radii, RangeSearch, SearchError, Seat};
use simdop::isa::Isa;

/// Counts, fills and visits on every instruction set, compares them all, and returns the lists of the queries.
fn ask(cloud: &CloudRef<'_>, queries: &Queries<'_>, radii: Radii<'_>, room: usize) -> Vec<Vec<u32>> {
    let mut first = None;
    for isa in Isa::available() {
        let search = RangeSearch::new(isa);
        let mut counts = vec![0; room];
        let counted = search.count(cloud, queries, radii, &mut counts).unwrap();
        let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        let mut lists = vec![List::default(); room];
        let mut indices = vec![u32::MAX; total as usize];
        if total > 0 {
            let short = search.fill(cloud, queries, radii, &mut lists, &mut indices[1..]);
            assert_eq!(short, Err(SearchError::Buffer { have: total as usize - 1, need: total }), "{isa}");
        }
        let filled = search.fill(cloud, queries, radii, &mut lists, &mut indices).unwrap();
        let mut visited = vec![Vec::new(); room];
        let visit = |query: u32, neighbour: u32| {
            visited[query as usize].push(neighbour);
            ControlFlow::Continue(())
        };
        let seen = search.visit(cloud, queries, radii, visit).unwrap();
        assert_eq!((counted, counted), (filled, seen), "{isa}");
        assert_eq!(counted.neighbours, total);
        for (query, list) in lists.iter().enumerate() {
            assert_eq!(list.count, counts[query], "{isa}, query {query}");
            assert_eq!(indices[list.range()], visited[query], "{isa}, query {query}");
        }
        let answer = (counted, lists, indices);
        assert_eq!(first.get_or_insert_with(|| answer.clone()), &answer, "{isa} and the first");
    }
    let (_, lists, indices) = first.unwrap();
    lists.iter().map(|list| indices[list.range()].to_vec()).collect()
}

fn sorted(mut list: Vec<u32>) -> Vec<u32> {
    list.sort_unstable();
    list
}

#[test]
fn own_neighbours_are_those_of_a_loop() {
    for (name, points, radii) in scenes::all(by_suite(1500, 200)) {
        let cloud = PointCloud::new(&points).unwrap();
        for &radius in &radii {
            let found = ask(&cloud.view(), &Queries::own(), Radii::Same(radius), points.len());
            for (i, list) in found.into_iter().enumerate() {
                assert_eq!(
                    sorted(list),
                    brute(&points, points[i], radius),
                    "{name}, radius {radius}, point {i}"
                );
            }
        }
    }
}

#[test]
fn neighbours_come_in_the_order_of_buckets_and_slots() {
    let (_, points, _) = scenes::all(2000).swap_remove(0);
    let cloud = PointCloud::with_room(&points, 12, points.len()).unwrap();
    assert!(cloud.view().buckets().len() > 128, "more than eight sixteens");
    let order: Vec<u32> = cloud.view().buckets().iter().flat_map(|bucket| bucket.indices).collect();
    let mut places = vec![0; points.len()];
    for (place, &index) in order.iter().enumerate().filter(|(_, index)| **index != u32::MAX) {
        places[index as usize] = place;
    }
    // With the last radius, packets find more buckets than a packet can store.
    for radius in [0.1, 0.3, 2.0] {
        for list in ask(&cloud.view(), &Queries::own(), Radii::Same(radius), points.len()) {
            assert!(list.is_sorted_by_key(|&index| places[index as usize]));
        }
    }
}

/// Where a packet finds more buckets than it can store, its queries descend one by one. The radii are on both
/// sides of that limit.
#[test]
fn queries_go_down_alone_where_packets_find_too_much() {
    let random = &mut Random(23);
    let n = by_suite(2000, 500);
    let points: Vec<_> = (0..n).map(|_| random.point()).collect();
    let cloud = PointCloud::with_room(&points, 3, n).unwrap();
    assert!(cloud.view().buckets().len() > 128, "more than eight sixteens");
    for radius in [0.2, 0.4, 0.6, 2.0] {
        let found = ask(&cloud.view(), &Queries::own(), Radii::Same(radius), n);
        for (i, list) in found.into_iter().enumerate().step_by(7) {
            assert_eq!(sorted(list), brute(&points, points[i], radius), "radius {radius}, point {i}");
        }
    }
}

/// Queries at points of another set, inside the cloud's box and far outside, each with a radius of its own.
#[test]
fn neighbours_of_other_points_are_those_of_a_loop() {
    for (name, points, radii) in scenes::all(by_suite(1000, 150)) {
        let cloud = PointCloud::new(&points).unwrap();
        let random = &mut Random(3);
        let bounds = cloud.view().bounds();
        let other = |i: usize| -> [f32; 3] {
            let share = if i.is_multiple_of(4) { 3.0 } else { 1.0 };
            let side =
                |k: usize| bounds.lower[k] + share * (bounds.upper[k] - bounds.lower[k]) * random.next();
            let asked: [f32; 3] = [0, 1, 2].map(side);
            // Every third query is a point of the cloud.
            if i.is_multiple_of(3) || asked.iter().any(|x| !x.is_finite()) {
                points[i % points.len()]
            } else {
                asked
            }
        };
        let queries: Vec<_> = (0..by_suite(700, 90)).map(other).collect();
        let each: Vec<f32> = (0..queries.len()).map(|i| radii[i % radii.len()]).collect();
        let mut seats = vec![Seat::default(); queries.len()];
        let packed = RangeSearch::new(Isa::detect()).seat(&cloud.view(), &queries, &mut seats).unwrap();
        let found = ask(&cloud.view(), &packed, Radii::Each(&each), queries.len());
        for (i, list) in found.into_iter().enumerate() {
            assert_eq!(sorted(list), brute(&points, queries[i], each[i]), "{name}, query {i}");
        }
    }
}

#[test]
fn every_instruction_set_seats_alike() {
    let (_, points, _) = scenes::all(800).swap_remove(9);
    let cloud = PointCloud::new(&points).unwrap();
    let queries: Vec<_> = points.iter().map(|p| [p[1], p[2], p[0]]).collect();
    let seated = Isa::available().map(|isa| {
        let mut seats = vec![Seat::default(); queries.len()];
        RangeSearch::new(isa).seat(&cloud.view(), &queries, &mut seats).unwrap();
        seats
    });
    let seated: Vec<_> = seated.collect();
    assert!(seated.iter().all(|seats| *seats == seated[0]));
}

#[test]
fn any_number_of_points_makes_a_cloud() {
    let random = &mut Random(11);
    let most = by_suite(5000, 300);
    for n in (0..70).chain([255, 256, 257, 271, 272, 273, 4095, 4096, 4097]).filter(|&n| n < most) {
        let points: Vec<_> = (0..n).map(|_| random.point()).collect();
        for bucket_size in [1, 2, 5, 15, 16] {
            let cloud = PointCloud::with_room(&points, bucket_size, n).unwrap();
            let view = cloud.view();
            assert_eq!(view.len(), n);
            assert_eq!(view.buckets().len(), n.div_ceil(bucket_size as usize));
            let found: usize = view.buckets().iter().map(|bucket| bucket.used().count_ones() as usize).sum();
            assert_eq!(found, n);
            let mut counts = vec![0; n];
            let search = RangeSearch::new(Isa::detect());
            search.count(&view, &Queries::own(), Radii::Same(2.0), &mut counts).unwrap();
            assert!(counts.iter().all(|&count| count as usize == n), "{n} points, {bucket_size} a bucket");
        }
    }
}

#[test]
fn shares_of_the_buckets_make_the_whole() {
    let (_, points, _) = scenes::all(1000).swap_remove(0);
    let cloud = PointCloud::new(&points).unwrap();
    let (view, search) = (cloud.view(), RangeSearch::new(Isa::detect()));
    let (mut whole, mut shares) = (vec![0; 1000], vec![u32::MAX; 1000]);
    search.count(&view, &Queries::own(), Radii::Same(0.1), &mut whole).unwrap();
    for range in [0..10, 10..11, 11..usize::MAX, 500..600, 3..3] {
        search.count(&view, &Queries::own_of(range), Radii::Same(0.1), &mut shares).unwrap();
    }
    assert_eq!(whole, shares);
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let points = [[0.0; 3], [1.0; 3]];
    let cloud = PointCloud::new(&points).unwrap();
    let (view, search) = (cloud.view(), RangeSearch::new(Isa::SCALAR));
    let mut counts = [0; 2];
    for radius in [-1.0, f32::NAN, f32::INFINITY] {
        let refused = search.count(&view, &Queries::own(), Radii::Same(radius), &mut counts);
        assert_eq!(refused, Err(SearchError::Radius { query: 0 }));
        let refused = search.count(&view, &Queries::own(), Radii::Each(&[1.0, radius]), &mut counts);
        assert_eq!(refused, Err(SearchError::Radius { query: 1 }));
    }
    let refused = search.count(&view, &Queries::own(), Radii::Each(&[1.0]), &mut counts);
    assert_eq!(refused, Err(SearchError::Length { what: "radii", have: 1, need: 2 }));
    let refused = search.count(&view, &Queries::own(), Radii::Same(1.0), &mut counts[..1]);
    assert_eq!(refused, Err(SearchError::Length { what: "counts", have: 1, need: 2 }));
    let refused = search.fill(&view, &Queries::own(), Radii::Same(1.0), &mut [], &mut []);
    assert_eq!(refused, Err(SearchError::Length { what: "lists", have: 0, need: 2 }));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let queries = [[0.0; 3], [0.0, bad, 0.0]];
        let refused = search.seat(&view, &queries, &mut [Seat::default(); 2]).unwrap_err();
        assert_eq!(refused, SearchError::Query { query: 1 });
    }
    let refused = search.seat(&view, &points, &mut [Seat::default(); 1]).unwrap_err();
    assert_eq!(refused, SearchError::Length { what: "seats", have: 1, need: 2 });
}

#[test]
fn a_visitor_that_breaks_is_not_called_again() {
    let (_, points, _) = scenes::all(500).swap_remove(0);
    let cloud = PointCloud::new(&points).unwrap();
    for isa in Isa::available() {
        for limit in [1, 63, 64, 65, 1000] {
            let mut calls = 0;
            let visit = |_, _| {
                calls += 1;
                if calls < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            RangeSearch::new(isa).visit(&cloud.view(), &Queries::own(), Radii::Same(1.0), visit).unwrap();
            assert_eq!(calls, limit);
        }
    }
}
