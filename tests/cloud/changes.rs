//! Points that move, or are inserted or removed: the tree stays correct.

use crate::data::by_suite;
use crate::scenes::{Random, brute, is_near};
use simdop::cloud::{CloudError, CloudMut, Memory, PointCloud, Queries, Radii, RangeSearch};
use simdop::isa::Isa;
use simdop::node::{Aabb16, Bucket};

/// Compares the counts of all points with a loop over those that exist.
fn assert_right(cloud: &PointCloud, points: &[Option<[f32; 3]>], radius: f32, what: &str) {
    let mut counts = vec![u32::MAX; points.len()];
    let search = RangeSearch::new(Isa::detect());
    search.count(&cloud.view(), &Queries::own(), Radii::Same(radius), &mut counts).unwrap();
    for (i, point) in points.iter().enumerate() {
        let near = |p: [f32; 3]| points.iter().flatten().filter(|q| is_near(p, **q, radius)).count() as u32;
        assert_eq!(counts[i], point.map_or(u32::MAX, near), "{what}, point {i}");
    }
    assert_eq!(cloud.view().len(), points.iter().flatten().count());
}

/// Two thousand frames of particles that drift, bounce, and sometimes leave the box that the tree was built
/// for.
#[test]
fn particles_stay_exact_through_refits_and_rebuilds() {
    let (n, frames) = (by_suite(600, 120), by_suite(2000, 60));
    let random = &mut Random(5);
    let mut points: Vec<_> = (0..n).map(|_| random.point()).collect();
    let velocities: Vec<_> = (0..n).map(|_| random.point().map(|x| (x - 0.5) * 0.02)).collect();
    let mut cloud = PointCloud::new(&points).unwrap();
    let (search, mut rebuilds, mut counts) = (RangeSearch::new(Isa::detect()), 0, vec![0; n]);
    for frame in 0..frames {
        for (point, velocity) in points.iter_mut().zip(&velocities) {
            for i in 0..3 {
                point[i] += velocity[i] * if frame / 50 % 2 == 0 { 1.0 } else { -1.0 };
            }
        }
        if frame % 97 == 0 {
            points[frame % n] = random.point().map(|x| 50.0 * (x - 0.5));
        }
        let ratio = cloud.refit(&points).unwrap();
        assert!(ratio >= 1.0);
        if ratio > 10.0 {
            cloud.rebuild().unwrap();
            assert_eq!(cloud.refit(&points).unwrap(), 1.0, "nothing moved since");
            rebuilds += 1;
        }
        search.count(&cloud.view(), &Queries::own(), Radii::Same(0.1), &mut counts).unwrap();
        for i in (frame % 7..n).step_by(7) {
            assert_eq!(counts[i] as usize, brute(&points, points[i], 0.1).len(), "frame {frame}, point {i}");
        }
    }
    assert!(rebuilds > 0 && rebuilds < frames, "{rebuilds} of {frames}");
}

#[test]
fn a_tree_that_was_rebuilt_is_the_tree_that_is_built() {
    let random = &mut Random(9);
    let mut points: Vec<_> = (0..1000).map(|_| random.point()).collect();
    for bucket_size in [1, 7, 16] {
        let mut cloud = PointCloud::with_room(&points, bucket_size, points.len()).unwrap();
        points.iter_mut().for_each(|point| *point = random.point());
        cloud.refit(&points).unwrap();
        cloud.rebuild().unwrap();
        let anew = PointCloud::with_room(&points, bucket_size, points.len()).unwrap();
        let bits = |cloud: &PointCloud| {
            let view = cloud.view();
            let (nodes, buckets): (&[u8], &[u8]) =
                (bytemuck::cast_slice(view.nodes()), bytemuck::cast_slice(view.buckets()));
            (nodes.to_vec(), buckets.to_vec())
        };
        assert!(bits(&cloud) == bits(&anew), "{bucket_size} a bucket");
    }
}

#[test]
fn points_come_and_go() {
    let (n, room) = (by_suite(500, 100), by_suite(700, 140));
    let random = &mut Random(13);
    for bucket_size in [1, 8, 13] {
        let points: Vec<_> = (0..n).map(|_| random.point()).collect();
        let mut cloud = PointCloud::with_room(&points, bucket_size, room).unwrap();
        let mut there: Vec<_> = points.into_iter().map(Some).collect();
        there.resize(room, None);
        let (mut inserted, mut removed) = (0, 0);
        for step in 0..by_suite(2000, 200) {
            let index = ((random.next() * room as f32) as usize).min(room - 1);
            match there[index] {
                Some(_) => {
                    assert_eq!(
                        cloud.insert(index as u32, [0.5; 3]),
                        Err(CloudError::Index { index: index as u32 })
                    );
                    cloud.remove(index as u32).unwrap();
                    there[index] = None;
                    removed += 1;
                }
                None => {
                    assert_eq!(cloud.remove(index as u32), Err(CloudError::Index { index: index as u32 }));
                    let point = random.point().map(|x| 1.2 * x);
                    match cloud.insert(index as u32, point) {
                        Ok(()) => (there[index], inserted) = (Some(point), inserted + 1),
                        Err(CloudError::Full) => cloud.rebuild().unwrap(),
                        Err(error) => panic!("{error}"),
                    }
                }
            }
            if step % 100 == 99 {
                assert_right(&cloud, &there, 0.15, "changed");
            }
        }
        assert!(inserted > 20 && removed > 20, "{inserted} inserted, {removed} removed");
        let positions: Vec<_> = there.iter().map(|point| point.unwrap_or([f32::NAN; 3])).collect();
        cloud.refit(&positions).unwrap();
        assert_right(&cloud, &there, 0.15, "refitted");
        cloud.rebuild().unwrap();
        assert_right(&cloud, &there, 0.15, "rebuilt");
        for index in 0..room as u32 {
            let _ = cloud.remove(index);
        }
        assert!(cloud.view().is_empty());
        cloud.rebuild().unwrap();
        assert!(cloud.view().bounds().is_empty());
        for index in 0..room.min(16) as u32 {
            let Err(error) = cloud.insert(index, [index as f32; 3]) else { continue };
            assert_eq!(error, CloudError::Full);
            cloud.rebuild().unwrap();
        }
    }
}

/// A cloud without points, whether it was built empty or emptied, takes as many points as its capacity.
#[test]
fn an_empty_cloud_takes_points() {
    let random = &mut Random(41);
    let points: Vec<_> = (0..100).map(|_| random.point()).collect();
    let mut emptied = PointCloud::with_room(&points[..50], 8, 100).unwrap();
    (0..50).for_each(|index| emptied.remove(index).unwrap());
    emptied.rebuild().unwrap();
    for mut cloud in [PointCloud::with_room(&[], 8, 100).unwrap(), emptied] {
        cloud.view().validate().unwrap();
        assert!(cloud.view().bounds().is_empty() && cloud.view().is_empty());
        assert_eq!(PointCloud::from_bytes(&cloud.view().to_bytes()).unwrap().view().len(), 0);
        let mut there = vec![None; 100];
        assert_right(&cloud, &there, 0.3, "empty");
        assert_eq!(cloud.refit(&[[f32::NAN; 3]; 100]), Ok(1.0));
        for (index, &point) in points.iter().enumerate() {
            if cloud.insert(index as u32, point) == Err(CloudError::Full) {
                cloud.rebuild().unwrap();
                cloud.insert(index as u32, point).unwrap();
            }
            there[index] = Some(point);
        }
        assert_right(&cloud, &there, 0.3, "filled");
    }
    // With a capacity of 0 there is no valid index.
    let nothing = PointCloud::new(&[]).unwrap();
    assert_eq!((nothing.view().buckets().len(), nothing.view().nodes().len()), (0, 1));
}

#[test]
fn what_is_wrong_changes_nothing() {
    let points: Vec<_> = (0..40).map(|i| [i as f32, 0.0, 1.0]).collect();
    let mut cloud = PointCloud::new(&points).unwrap();
    let mut wrong = points.clone();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        wrong[17] = [0.0, bad, 0.0];
        assert_eq!(PointCloud::new(&wrong).unwrap_err(), CloudError::Point { index: 17 });
        assert_eq!(cloud.refit(&wrong), Err(CloudError::Point { index: 17 }));
        assert_eq!(cloud.insert(3, [bad; 3]), Err(CloudError::Point { index: 3 }));
    }
    assert_eq!(cloud.refit(&points[..39]), Err(CloudError::Positions { have: 39, need: 40 }));
    assert_eq!(cloud.insert(40, [0.0; 3]), Err(CloudError::Index { index: 40 }));
    assert_eq!(cloud.remove(40), Err(CloudError::Index { index: 40 }));
    for asked in [0, 17] {
        assert_eq!(PointCloud::with_room(&points, asked, 40).unwrap_err(), CloudError::BucketSize { asked });
    }
    let there: Vec<_> = points.iter().copied().map(Some).collect();
    assert_right(&cloud, &there, 2.0, "after errors");
    assert_eq!(cloud.refit(&points), Ok(1.0));
}

#[test]
fn memory_may_be_the_callers() {
    let points: Vec<_> = (0..100).map(|i| [(i % 10) as f32, (i / 10) as f32, 0.0]).collect();
    let (mut nodes, mut buckets, mut places) = ([Aabb16::EMPTY; 1], [Bucket::EMPTY; 7], [0; 100]);
    let mut build = |node_count: usize, bucket_count: usize, place_count: usize| {
        let memory = Memory {
            nodes: &mut nodes[..node_count],
            buckets: &mut buckets[..bucket_count],
            places: &mut places[..place_count],
        };
        CloudMut::build(memory, &points, 16).map(|cloud| {
            let mut counts = [0; 100];
            let search = RangeSearch::new(Isa::detect());
            search.count(&cloud.view(), &Queries::own(), Radii::Same(1.0), &mut counts).unwrap();
            counts
        })
    };
    let counts = build(1, 7, 100).unwrap();
    assert_eq!([counts[0], counts[5], counts[55]], [3, 4, 5]);
    let too_little = |what, have, need| CloudError::Memory { what, have, need };
    assert_eq!(build(0, 7, 100), Err(too_little("nodes", 0, 1)));
    assert_eq!(build(1, 6, 100), Err(too_little("buckets", 6, 7)));
    assert_eq!(build(1, 7, 99), Err(too_little("places", 99, 100)));
}

/// The paper's ratio: the present volume of a box over its volume when built.
#[test]
fn the_ratio_is_that_of_the_box_that_grew_most() {
    let mut points: Vec<_> =
        (0..4096).map(|i| [(i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32]).collect();
    let mut cloud = PointCloud::new(&points).unwrap();
    assert_eq!(cloud.refit(&points), Ok(1.0));
    // All boxes become twice as large along one axis.
    for point in &mut points {
        point[1] *= 2.0;
    }
    let ratio = cloud.refit(&points).unwrap();
    assert!((ratio - 2.0).abs() < 1e-5, "{ratio}");
    cloud.rebuild().unwrap();
    assert_eq!(cloud.refit(&points), Ok(1.0));
    let mut coincident = PointCloud::new(&[[1.0; 3]; 5]).unwrap();
    assert_eq!(coincident.refit(&[[2.0; 3]; 5]), Ok(1.0));
    assert_eq!(coincident.refit(&[[2.0; 3], [2.0; 3], [2.0; 3], [2.0; 3], [2.5; 3]]), Ok(f64::INFINITY));
}
